//! Scene files: TOML that names particle, hair and mesh files, lights and a camera.
//!
//! ```toml
//! [[particles]]                 # any number of them
//! file = "smoke.ply"            # beside the scene file
//! scale = 2.0                   # optional, about the file's origin; optical depths stay as they are
//! translate = [0.0, 0.0, 1.0]   # optional, after the scale
//!
//! [[hair]]                      # any number of them
//! file = "head.hair"            # Cem Yuksel's HAIR format
//! scale = 1.0                   # optional, also of the thickness
//! translate = [0.0, 0.0, 0.0]   # optional
//! radius = 0.01                 # optional, world units, replaces half the file's thickness
//! opacity = 0.5                 # optional, replaces the file's
//!
//! [[meshes]]                    # any number of them
//! file = "ground.gltf"          # .ply, .gltf or .glb
//! scale = 1.0                   # optional
//! translate = [0.0, 0.0, 0.0]   # optional
//! albedo = [0.6, 0.6, 0.6]      # optional, replaces the file's
//!
//! [light]                       # or [[light]], any number of them
//! kind = "directional"          # or "spot" with position, target and cone_degrees in place of direction, or "point"
//!                               # with position
//! direction = [0.5, 0.3, -0.81] # the way the light travels
//! radiance = [1.0, 1.0, 1.0]    # optional
//!
//! [camera]
//! position = [9.0, -9.0, 5.0]
//! target = [0.0, 0.0, 2.0]
//! up = [0.0, 0.0, 1.0]
//! fov_y_degrees = 38.0          # full vertical angle
//! ```

use super::hair_file::Overrides;
use super::{Camera, Light, LightKind, Mesh, Motion, Particle, Scene, hair_file, input, mesh_file, particle_file};
use crate::Result;
use glam::DVec3;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::path::Path;

const WAY_OUT: &str = "correct the scene file";

/// The sine of the angle below which `up` counts as parallel to the view: the picture's roll would be rounding noise.
const MIN_UP_SINE: f64 = 1e-6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    particles: Vec<ParticlesEntry>,
    #[serde(default)]
    hair: Vec<HairEntry>,
    #[serde(default)]
    meshes: Vec<MeshesEntry>,
    #[serde(deserialize_with = "one_or_more")]
    light: Vec<LightEntry>,
    camera: CameraEntry,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParticlesEntry {
    file: String,
    #[serde(default)]
    translate: [f64; 3],
    #[serde(default = "one")]
    scale: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HairEntry {
    file: String,
    #[serde(default)]
    translate: [f64; 3],
    #[serde(default = "one")]
    scale: f64,
    radius: Option<f64>,
    opacity: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshesEntry {
    file: String,
    #[serde(default)]
    translate: [f64; 3],
    #[serde(default = "one")]
    scale: f64,
    albedo: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
enum LightEntry {
    Directional {
        direction: [f64; 3],
        #[serde(default = "white")]
        radiance: [f64; 3],
    },
    Spot {
        position: [f64; 3],
        target: [f64; 3],
        cone_degrees: f64,
        #[serde(default = "white")]
        radiance: [f64; 3],
    },
    Point {
        position: [f64; 3],
        #[serde(default = "white")]
        radiance: [f64; 3],
    },
}

/// A table or an array of tables. Not an untagged enum, whose errors do not say what is wrong.
fn one_or_more<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Vec<LightEntry>, D::Error> {
    struct Lights;
    impl<'de> Visitor<'de> for Lights {
        type Value = Vec<LightEntry>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("[light] or [[light]]")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Self::Value, A::Error> {
            Ok(vec![LightEntry::deserialize(MapAccessDeserializer::new(map))?])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> std::result::Result<Self::Value, A::Error> {
            Vec::deserialize(SeqAccessDeserializer::new(sequence))
        }
    }
    deserializer.deserialize_any(Lights)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    position: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    fov_y_degrees: f64,
}

fn one() -> f64 {
    1.0
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

/// Loads a scene file and the files that it names. The scene is called as the file without its ending.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input): unreadable file; not TOML, an unknown or missing key, with the line; a number
/// that its key does not allow; whatever the named files are wrong with.
pub(super) fn load(path: &Path) -> Result<Scene> {
    let bytes = input::read(path)?;
    let text = str::from_utf8(&bytes).map_err(|cause| input::error(path, cause, "save the scene file as UTF-8"))?;
    let parsed: SceneFile = toml::from_str(text).map_err(|cause| {
        let line = cause.span().and_then(|span| text.get(..span.start)).map(|before| before.matches('\n').count() + 1);
        let line = line.map_or_else(String::new, |line| format!("line {line}: "));
        input::error(path, format!("{line}{}", cause.message()), WAY_OUT)
    })?;
    let wrong = |cause: String| input::error(path, cause, WAY_OUT);
    if parsed.particles.is_empty() && parsed.hair.is_empty() && parsed.meshes.is_empty() {
        return Err(wrong("nothing casts a shadow: no [[particles]], no [[hair]] and no [[meshes]]".into()));
    }
    if parsed.light.is_empty() {
        return Err(wrong("no light: nothing would be seen".into()));
    }
    let lights = parsed.light.iter().map(light).collect::<std::result::Result<Vec<_>, _>>().map_err(wrong)?;
    let camera = camera(&parsed.camera).map_err(wrong)?;

    let folder = path.parent().unwrap_or(Path::new(""));
    let mut scene = Scene {
        name: input::stem(path),
        particles: Vec::new(),
        strands: Vec::new(),
        meshes: Vec::new(),
        motion: Motion::Still,
        lights,
        camera,
    };
    for entry in &parsed.particles {
        let placement = Placement::new(entry.translate, entry.scale).map_err(|cause| wrong(entry.cause(cause)))?;
        for (number, particle) in particle_file::load(&folder.join(&entry.file))?.iter().enumerate() {
            let placed = placement.particle(particle);
            let cause = |cause| entry.cause(format!("placed particle {number} (the first is 0): {cause}"));
            scene.particles.push(placed.map_err(|text| wrong(cause(text)))?);
        }
    }
    for entry in &parsed.hair {
        let placement = Placement::new(entry.translate, entry.scale).map_err(|cause| wrong(entry.cause(cause)))?;
        let overrides = entry.overrides().map_err(|cause| wrong(entry.cause(cause)))?;
        let place = |position| placement.position(position);
        scene.strands.extend(hair_file::load(&folder.join(&entry.file), place, entry.scale, overrides)?);
    }
    for entry in &parsed.meshes {
        let placement = Placement::new(entry.translate, entry.scale).map_err(|cause| wrong(entry.cause(cause)))?;
        let albedo = entry.albedo.map(|albedo| fractions(albedo).map_err(|cause| wrong(entry.cause(cause))));
        let albedo = albedo.transpose()?;
        for mesh in mesh_file::load(&folder.join(&entry.file))? {
            let mut placed = placement.mesh(mesh).map_err(|cause| wrong(entry.cause(cause)))?;
            placed.albedo = albedo.unwrap_or(placed.albedo);
            scene.meshes.push(placed);
        }
    }
    Ok(scene)
}

impl ParticlesEntry {
    fn cause(&self, cause: String) -> String {
        format!("particles {}: {cause}", self.file)
    }
}

impl HairEntry {
    fn cause(&self, cause: String) -> String {
        format!("hair {}: {cause}", self.file)
    }

    fn overrides(&self) -> std::result::Result<Overrides, String> {
        let Self { radius, opacity, .. } = *self;
        if let Some(radius) = radius.filter(|r| !((*r as f32).is_finite() && *r as f32 > 0.0)) {
            return Err(format!("radius {radius} is not finite and greater than 0"));
        }
        if let Some(opacity) = opacity.filter(|o| !(0.0..=1.0).contains(o)) {
            return Err(format!("opacity {opacity} is not in [0, 1]"));
        }
        Ok(Overrides { radius, opacity })
    }
}

impl MeshesEntry {
    fn cause(&self, cause: String) -> String {
        format!("meshes {}: {cause}", self.file)
    }
}

/// Where the things of a file go in the world.
struct Placement {
    translate: DVec3,
    scale: f64,
}

impl Placement {
    fn new(translate: [f64; 3], scale: f64) -> std::result::Result<Self, String> {
        if !(scale.is_finite() && scale > 0.0) {
            return Err(format!("scale {scale} is not finite and greater than 0"));
        }
        Ok(Self { translate: finite("translate", translate)?, scale })
    }

    fn position(&self, position: [f32; 3]) -> [f64; 3] {
        (DVec3::from_array(position.map(f64::from)) * self.scale + self.translate).to_array()
    }

    /// The extinction shrinks as the radius grows: a larger model of the same smoke is as dark as the smaller one.
    fn particle(&self, particle: &Particle) -> std::result::Result<Particle, String> {
        particle_file::checked(
            self.position(particle.position),
            f64::from(particle.radius) * self.scale,
            f64::from(particle.extinction) / self.scale,
        )
    }

    fn mesh(&self, mut mesh: Mesh) -> std::result::Result<Mesh, String> {
        for position in &mut mesh.positions {
            *position = self.position(*position).map(|value| value as f32);
            if !position.iter().all(|value| value.is_finite()) {
                return Err(format!("scale and translate move mesh {} out of range", mesh.name));
            }
        }
        Ok(mesh)
    }
}

fn light(entry: &LightEntry) -> std::result::Result<Light, String> {
    let (kind, radiance) = match *entry {
        LightEntry::Directional { direction, radiance } => {
            let direction = unit(finite("light direction", direction)?).ok_or("light direction has no length")?;
            (LightKind::Directional { direction }, radiance)
        }
        LightEntry::Spot { position, target, cone_degrees, radiance } => {
            let position = finite("light position", position)?;
            let target = finite("light target", target)?;
            let direction = unit(target - position).ok_or("light position and target are the same point")?;
            if !(cone_degrees > 0.0 && cone_degrees <= 170.0) {
                return Err(format!("light cone_degrees {cone_degrees} is not in (0, 170]"));
            }
            (LightKind::Spot { position, direction, cone_degrees }, radiance)
        }
        LightEntry::Point { position, radiance } => {
            (LightKind::Point { position: finite("light position", position)? }, radiance)
        }
    };
    let radiance = radiance.map(|value| value as f32);
    if !radiance.iter().all(|value| value.is_finite() && *value >= 0.0) {
        return Err(format!("light radiance {radiance:?} is not finite and at least 0"));
    }
    Ok(Light { kind, radiance })
}

fn camera(entry: &CameraEntry) -> std::result::Result<Camera, String> {
    let position = finite("camera position", entry.position)?;
    let target = finite("camera target", entry.target)?;
    let up = finite("camera up", entry.up)?;
    let view = unit(target - position).ok_or("camera position and target are the same point")?;
    let unit_up = unit(up).ok_or("camera up has no length")?;
    if view.cross(unit_up).length() < MIN_UP_SINE {
        return Err("camera up is parallel to the view".into());
    }
    let fov_y_degrees = entry.fov_y_degrees;
    if !(fov_y_degrees > 0.0 && fov_y_degrees < 180.0) {
        return Err(format!("camera fov_y_degrees {fov_y_degrees} is not in (0, 180)"));
    }
    Ok(Camera { position, target, up, fov_y_degrees })
}

/// The widest coordinate a scene file may hold. Everything is stored or sent to the device as f32 sooner or later, and
/// the squares of distances must stay finite there.
const MAX_COORDINATE: f64 = 1e18;

fn finite(name: &str, values: [f64; 3]) -> std::result::Result<DVec3, String> {
    if values.iter().all(|value| value.abs() <= MAX_COORDINATE) {
        return Ok(DVec3::from_array(values));
    }
    Err(format!("{name} {values:?} is not finite or exceeds {MAX_COORDINATE:e}"))
}

fn fractions(values: [f64; 3]) -> std::result::Result<[f32; 3], String> {
    if values.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Ok(values.map(|value| value as f32));
    }
    Err(format!("albedo {values:?} is not in [0, 1]"))
}

/// The vector at unit length; `None` if it has no direction. Divides first, so that tiny vectors keep theirs.
fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    if largest == 0.0 {
        return None;
    }
    (vector / largest).try_normalize()
}
