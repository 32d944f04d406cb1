//! Scene files: TOML that names files of particles, hair, splats, volumes and meshes, and describes lights and a camera.
//!
//! ```toml
//! [[particles]]                 # any number of them
//! file = "smoke.ply"            # beside the scene file; "smoke.####.ply": one frame per file, smoke.0001.ply and so on
//! scale = 2.0                   # optional, about the file's origin; optical depths are unchanged
//! rotate = [1.0, 0.0, 0.0, 90]  # optional, after the scale: an axis and degrees
//! translate = [0.0, 0.0, 1.0]   # optional, after both
//! frames_per_second = 24.0      # optional, for a sequence of files
//!
//! [[hair]]                      # any number of them
//! file = "head.hair"            # Cem Yuksel's HAIR format, or TressFX, versions 3 and 4 (.tfx)
//! scale = 1.0                   # optional, also of the thickness
//! rotate = [1.0, 0.0, 0.0, 90]  # optional
//! translate = [0.0, 0.0, 0.0]   # optional
//! radius = 0.01                 # optional, world units, replaces half the file's thickness
//! opacity = 0.5                 # optional, replaces the file's
//!
//! [[splats]]                    # any number of them
//! file = "garden.splat"         # .ply of 3D Gaussian Splatting, also PlayCanvas' compressed one, .splat or .spz
//! scale = 1.0                   # optional
//! rotate = [1.0, 0.0, 0.0, 180] # optional
//! translate = [0.0, 0.0, 0.0]   # optional
//!
//! [[volumes]]                   # any number of them
//! file = "smoke.vdb"            # .vdb, .nrrd, or .volume, which names a raw file; "smoke.####.vdb": one frame per file
//! grid = "density"              # optional, which grid of a .vdb
//! extinction = 4.0              # optional, at density 1, in 1 / world unit of the file; replaces the file's
//! scale = 1.0                   # optional, about the file's origin; optical depths are unchanged
//! rotate = [0.0, 0.0, 1.0, 90]  # optional, after the scale: an axis and degrees
//! translate = [0.0, 0.0, 0.0]   # optional, after both
//! color = [0.9, 0.9, 0.95]      # optional, albedo
//! cells = 1                     # optional, 1, 2, 4 or 8: cells of the file along each side of a casting cell
//! frames_per_second = 24.0      # optional, for a sequence of files
//!
//! [[meshes]]                    # any number of them
//! file = "ground.gltf"          # .ply, .gltf or .glb
//! scale = 1.0                   # optional
//! rotate = [1.0, 0.0, 0.0, 180] # optional
//! translate = [0.0, 0.0, 0.0]   # optional
//! albedo = [0.6, 0.6, 0.6]      # optional, replaces the file's
//! solid = false                 # optional; true: its back is never seen, like that of a ground
//! cutout = 0.5                  # optional, above 0 and at most 1: where alpha is below it, see-through meshes have a hole; elsewhere they
//!                               # block all light. For leaves of exporters that write BLEND in place of MASK
//!
//! [color]                       # optional
//! extinction = [1.0, 0.6, 0.3]  # for red, green and blue: factors on the extinction of everything but meshes
//!                               # [[particles]], [[hair]], [[splats]] and [[volumes]] may each have an
//!                               # extinction_ratio = [1.0, 0.6, 0.3] of their own; all are then in [0, 1]
//!
//! [light]                       # or [[light]], any number of them; without it, the lights of the glTF files are used
//! kind = "directional"          # or "spot" with position, target and cone_degrees in place of direction, or "point"
//!                               # with position
//! direction = [0.5, 0.3, -0.81] # the direction in which light travels
//! radiance = [1.0, 1.0, 1.0]    # optional
//! # radius = 4.0                # optional, for a spot or point light: where its light fades to zero
//!
//! [camera]                      # without it, the first camera of the glTF files is used, or else one that sees everything, as for
//!                               # a data file: up is +y if it is up in every file as placed, otherwise +z
//! position = [9.0, -9.0, 5.0]
//! target = [0.0, 0.0, 2.0]
//! up = [0.0, 0.0, 1.0]
//! fov_y_degrees = 38.0          # full vertical angle
//! ```

use crate::Result;
use crate::scene::files::animation::{self, Animation, Content, Kind, Part, Sequence};
use crate::scene::files::contents::{Contents, Loaded};
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{CameraEntry, LightEntry, camera, light, one_or_more};
use crate::scene::files::strand_file::Overrides;
use crate::scene::files::volume_file::{self, Placing};
use crate::scene::{
    AlphaMode, Camera, ExtinctionGroup, Mesh, Scene, files::data_file, files::default_view, files::input,
    files::mesh_file, files::particle_file, files::splat_file, files::strand_file,
};
use glam::DVec3;
use serde::Deserialize;
use std::mem::replace;
use std::path::Path;

const WAY_OUT: &str = "correct the scene file";

const MOST_FRAMES_PER_SECOND: f64 = 1000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    particles: Vec<ParticlesEntry>,
    #[serde(default)]
    hair: Vec<HairEntry>,
    #[serde(default)]
    splats: Vec<SplatsEntry>,
    #[serde(default)]
    volumes: Vec<VolumesEntry>,
    #[serde(default)]
    meshes: Vec<MeshesEntry>,
    #[serde(default, deserialize_with = "one_or_more")]
    light: Option<Vec<LightEntry>>,
    camera: Option<CameraEntry>,
    color: Option<ColorEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ColorEntry {
    extinction: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ParticlesEntry {
    file: String,
    extinction_ratio: Option<[f64; 3]>,
    #[serde(default)]
    translate: [f64; 3],
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    frames_per_second: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SplatsEntry {
    file: String,
    extinction_ratio: Option<[f64; 3]>,
    #[serde(default)]
    translate: [f64; 3],
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HairEntry {
    file: String,
    extinction_ratio: Option<[f64; 3]>,
    #[serde(default)]
    translate: [f64; 3],
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    radius: Option<f64>,
    opacity: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VolumesEntry {
    file: String,
    extinction_ratio: Option<[f64; 3]>,
    #[serde(default)]
    translate: [f64; 3],
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    extinction: Option<f64>,
    color: Option<[f32; 3]>,
    grid: Option<String>,
    #[serde(default = "single")]
    cells: u32,
    frames_per_second: Option<f64>,
}

fn single() -> u32 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshesEntry {
    file: String,
    #[serde(default)]
    translate: [f64; 3],
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    albedo: Option<[f64; 3]>,
    #[serde(default)]
    solid: bool,
    cutout: Option<f64>,
}

fn one() -> f64 {
    1.0
}

/// Loads a scene file and the files that it names. The scene is named after the file, without its extension.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if a file is unreadable, is not TOML, or has an unknown or missing key (with its line); if a
/// number is out of range for its key; or if one of the named files is invalid.
pub(in crate::scene) fn load(path: &Path) -> Result<Loaded> {
    let bytes = input::read(path)?;
    let text = str::from_utf8(&bytes).map_err(|cause| input::error(path, cause, "save the scene file as UTF-8"))?;
    let parsed: SceneFile = toml::from_str(text).map_err(|cause| {
        let line = cause.span().and_then(|span| text.get(..span.start)).map(|before| before.matches('\n').count() + 1);
        let line = line.map_or_else(String::new, |line| format!("line {line}: "));
        input::error(path, format!("{line}{}", cause.message()), WAY_OUT)
    })?;
    let wrong = |cause: String| input::error(path, cause, WAY_OUT);
    let nothing =
        [parsed.particles.is_empty(), parsed.hair.is_empty(), parsed.splats.is_empty(), parsed.volumes.is_empty()];
    if nothing.into_iter().all(|none| none) && parsed.meshes.is_empty() {
        return Err(wrong(
            "nothing casts a shadow: no [[particles]], no [[hair]], no [[splats]], no [[volumes]] and no [[meshes]]"
                .into(),
        ));
    }
    if parsed.light.as_ref().is_some_and(Vec::is_empty) {
        return Err(wrong("no light: nothing would be seen".into()));
    }
    let lights = parsed.light.map(|entries| entries.iter().map(light).collect::<std::result::Result<Vec<_>, _>>());
    let lights = lights.transpose().map_err(wrong)?;
    let camera = parsed.camera.as_ref().map(camera).transpose().map_err(wrong)?;
    let extinction_ratio = parsed
        .color
        .map_or(Ok(Scene::GREY), |color| extinction_ratio("color extinction", color.extinction))
        .map_err(wrong)?;

    let folder = path.parent().unwrap_or(Path::new(""));
    let mut contents = Contents::default();
    let mut parts = Vec::new();
    let mut ups = Vec::new();
    let named = input::named_by(path);
    let mut inks = Inks { common: extinction_ratio, all: Vec::new(), own: false };
    for entry in &parsed.particles {
        let placement =
            Placement::new(entry.translate, entry.rotate, entry.scale).map_err(|cause| wrong(entry.cause(cause)))?;
        let file = folder.join(&entry.file);
        ups.push(placement.rotate * data_file::up(&file));
        if let Some(rate) = rate(entry.frames_per_second, &file).map_err(|cause| wrong(entry.cause(cause)))? {
            inks.add(entry.extinction_ratio, 0).map_err(|cause| wrong(entry.cause(cause)))?;
            parts.push(Part::Moving(
                Sequence::open(&file, rate, Kind::Particles(placement), &mut contents.notes).map_err(&named)?,
            ));
            continue;
        }
        let place = |(number, particle)| {
            let cause = |cause| entry.cause(format!("placed particle {number} (the first is 0): {cause}"));
            placement.particle(particle).map_err(|text| wrong(cause(text)))
        };
        let loaded = particle_file::load(&file).map_err(&named)?;
        let particles = loaded.iter().enumerate().map(place).collect::<Result<Vec<_>>>()?;
        inks.add(entry.extinction_ratio, particles.len()).map_err(|cause| wrong(entry.cause(cause)))?;
        parts.push(Part::Still(Content::Particles(particles)));
    }
    for entry in &parsed.hair {
        let placement =
            Placement::new(entry.translate, entry.rotate, entry.scale).map_err(|cause| wrong(entry.cause(cause)))?;
        let overrides = entry.overrides().map_err(|cause| wrong(entry.cause(cause)))?;
        let before = contents.strands.len();
        let file = folder.join(&entry.file);
        ups.push(placement.rotate * data_file::up(&file));
        contents.strands.extend(strand_file::load(&file, &placement, overrides, &mut contents.notes).map_err(&named)?);
        let count = contents.strands.len() - before;
        inks.add(entry.extinction_ratio, count).map_err(|cause| wrong(entry.cause(cause)))?;
    }
    for entry in &parsed.splats {
        let cause = |cause| wrong(format!("splats {}: {cause}", entry.file));
        let placement = Placement::new(entry.translate, entry.rotate, entry.scale).map_err(cause)?;
        let before = contents.splats.len();
        let file = folder.join(&entry.file);
        ups.push(placement.rotate * data_file::up(&file));
        contents.splats.extend(splat_file::load(&file, &placement, &mut contents.notes).map_err(&named)?);
        inks.add(entry.extinction_ratio, contents.splats.len() - before).map_err(cause)?;
    }
    for entry in &parsed.volumes {
        let wrong = |cause| wrong(format!("volumes {}: {cause}", entry.file));
        let (placing, file) = (entry.placing().map_err(wrong)?, folder.join(&entry.file));
        ups.push(placing.rotate * data_file::up(&file));
        parts.push(match rate(entry.frames_per_second, &file).map_err(wrong)? {
            Some(rate) => {
                inks.add(entry.extinction_ratio, 0).map_err(wrong)?;
                Part::Moving(Sequence::open(&file, rate, Kind::Volume(placing), &mut contents.notes).map_err(&named)?)
            }
            None => {
                let volume = volume_file::load(&file, &placing, &mut contents.notes).map_err(&named)?;
                inks.add(entry.extinction_ratio, volume.cells().len()).map_err(wrong)?;
                Part::Still(Content::Volume(volume))
            }
        });
    }
    let animation = Animation::new(parts);
    (contents.particles, contents.volumes) = animation.at(0.0)?;
    for entry in &parsed.meshes {
        let wrong = |cause| wrong(entry.cause(cause));
        let placement = Placement::new(entry.translate, entry.rotate, entry.scale).map_err(wrong)?;
        let albedo = entry.albedo.map(fractions).transpose().map_err(wrong)?;
        let file = folder.join(&entry.file);
        ups.push(placement.rotate * data_file::up(&file));
        let mut loaded = mesh_file::load(&file).map_err(&named)?;
        entry.cut(&mut loaded.meshes).map_err(wrong)?;
        // A file may be named more than once.
        let is_new = |note: &String| !contents.notes.contains(note);
        let notes: Vec<_> = loaded.notes.into_iter().filter(is_new).collect();
        contents.notes.extend(notes);
        for mesh in loaded.meshes {
            let mut placed = placement.mesh(mesh).map_err(wrong)?;
            placed.albedo = albedo.unwrap_or(placed.albedo);
            placed.solid = entry.solid;
            contents.meshes.push(placed);
        }
        if lights.is_none() {
            for light in loaded.lights {
                contents.lights.push(placement.light(light).map_err(wrong)?);
            }
        }
        if let (None, None, Some(found)) = (camera, contents.camera, loaded.camera) {
            contents.camera = Some(placement.camera(&found).map_err(wrong)?);
        }
    }
    let lights = lights.unwrap_or_else(|| std::mem::take(&mut contents.lights));
    if lights.is_empty() {
        let cause = "missing field `light`, and no glTF file that it names brings one";
        return Err(input::error(path, cause, "add [light] to the scene file"));
    }
    let camera = match camera.or(contents.camera) {
        Some(camera) => camera,
        None => fitted_camera(path, &mut contents, &animation, &ups)?,
    };
    let sequences = Some(animation).filter(Animation::moves);
    if inks.own && sequences.is_some() {
        return Err(wrong(
            "extinction_ratio beside a sequence of files, whose frames have other numbers of casters".into(),
        ));
    }
    let mut notes = std::mem::take(&mut contents.notes);
    if sequences.is_some() {
        notes.extend(without_tints(&mut contents.meshes));
    }
    let reserve = sequences.as_ref().map(Animation::reserve).unwrap_or_default();
    let scene = Scene { reserve, ..contents.scene(input::stem(path), lights, camera) };
    let is_one = scene.sheet_count() == 0 || extinction_ratio == Scene::GREY && !scene.is_tinted();
    if !inks.own && is_one {
        return Ok(Loaded { scene: Scene { extinction_ratio, ..scene }, sequences, notes });
    }
    let scene = scene.with_inks(&inks.all).map_err(|error| error.with_name(|_| input::file_name(path)))?;
    Ok(Loaded { scene, sequences, notes })
}

/// Returns a camera that sees all of the contents, including the first, middle and last frames of sequences. `ups` are the files' up
/// directions, after placement.
fn fitted_camera(path: &Path, contents: &mut Contents, animation: &Animation, ups: &[DVec3]) -> Result<Camera> {
    let is_y = |up: &DVec3| up.y > up.x.abs().max(up.z.abs());
    let up = if ups.iter().all(is_y) { DVec3::Y } else { DVec3::Z };
    let (particles, volumes) = animation.some()?;
    let now = (replace(&mut contents.particles, particles), replace(&mut contents.volumes, volumes));
    let camera = default_view::camera(contents, up);
    (contents.particles, contents.volumes) = now;
    camera.map_err(|cause| input::error(path, cause, "add [camera] to the scene file"))
}

/// Takes the color from see-through meshes, and returns a note if any has one: a sequence of files has ever other numbers of casters.
fn without_tints(meshes: &mut [Mesh]) -> Option<String> {
    let mut count = 0;
    for alpha in meshes.iter_mut().filter_map(|mesh| mesh.alpha.as_mut()) {
        count += usize::from(alpha.extinction_ratio != Scene::GREY);
        alpha.extinction_ratio = Scene::GREY;
    }
    let meshes =
        if count == 1 { "1 see-through mesh absorbs".into() } else { format!("{count} see-through meshes absorb") };
    (count > 0).then(|| format!("{meshes} all colors alike beside a sequence"))
}

/// The extinction ratios of the entries so far.
struct Inks {
    /// The ratio of entries without their own.
    common: [f32; 3],
    all: Vec<ExtinctionGroup>,
    /// Whether any entry has its own ratio.
    own: bool,
}

impl Inks {
    /// Adds the ratio of one entry; the error describes what is wrong.
    fn add(&mut self, own: Option<[f64; 3]>, casters: usize) -> std::result::Result<(), String> {
        let ratio = own.map_or(Ok(self.common), |own| extinction_ratio("extinction_ratio", own))?;
        self.own |= own.is_some();
        self.all.push(ExtinctionGroup { casters, ratio });
        Ok(())
    }
}

/// Returns the frames per second if `file` is a sequence; None if it is a single file.
fn rate(given: Option<f64>, file: &Path) -> std::result::Result<Option<f64>, String> {
    match (given, animation::is_sequence(file)) {
        (None, false) => Ok(None),
        (Some(_), false) => Err("frames_per_second is of a sequence, whose name has a #".into()),
        (given, true) => {
            let rate = given.unwrap_or(animation::FRAMES_PER_SECOND);
            if rate > 0.0 && rate <= MOST_FRAMES_PER_SECOND {
                return Ok(Some(rate));
            }
            Err(format!("frames_per_second {rate} is not greater than 0 and at most {MOST_FRAMES_PER_SECOND}"))
        }
    }
}

impl ParticlesEntry {
    fn cause(&self, cause: String) -> String {
        format!("particles {}: {cause}", self.file)
    }
}

impl VolumesEntry {
    fn placing(&self) -> std::result::Result<Placing, String> {
        let Placement { translate, rotate, scale } = Placement::new(self.translate, self.rotate, self.scale)?;
        let Self { extinction, color, cells: side, .. } = *self;
        Ok(Placing { translate, rotate, scale, extinction, color, side, grid: self.grid.clone() })
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

    /// Cuts holes into see-through meshes, if the entry has a cutout; the error describes what is wrong.
    fn cut(&self, meshes: &mut [Mesh]) -> std::result::Result<(), String> {
        let Some(cutout) = self.cutout else { return Ok(()) };
        let cutoff = cutout as f32;
        if !(cutoff > 0.0 && cutoff <= 1.0) {
            return Err(format!("cutout {cutout} is not above 0 and at most 1"));
        }
        let modes = meshes.iter_mut().filter_map(|mesh| Some(&mut mesh.alpha.as_mut()?.mode));
        let see_through: Vec<_> = modes.filter(|mode| **mode == AlphaMode::SeeThrough).collect();
        if see_through.is_empty() {
            return Err("there is a cutout, but no mesh of the file is see-through".into());
        }
        see_through.into_iter().for_each(|mode| *mode = AlphaMode::Cut(cutoff));
        Ok(())
    }
}

/// Checks the extinction of red, green and blue light given by `key`; the error describes what is wrong.
fn extinction_ratio(key: &str, values: [f64; 3]) -> std::result::Result<[f32; 3], String> {
    let ratio = values.map(|value| value as f32);
    if !ratio.iter().all(|value| value.is_finite() && *value >= 0.0) {
        return Err(format!("{key} {values:?} is not finite and at least 0"));
    }
    if ratio == [0.0; 3] {
        return Err(format!("{key} is 0 in every color: nothing would cast"));
    }
    Ok(ratio)
}

fn fractions(values: [f64; 3]) -> std::result::Result<[f32; 3], String> {
    if values.iter().all(|value| (0.0..=1.0).contains(value)) {
        return Ok(values.map(|value| value as f32));
    }
    Err(format!("albedo {values:?} is not in [0, 1]"))
}
