//! Scene files: TOML that names files of particles, hair, splats, volumes and meshes, and describes lights and a camera.
//!
//! ```toml
//! [[particles]]                 # any number of them
//! file = "smoke.ply"            # beside the scene file; "smoke.####.ply": one frame per file, smoke.0001.ply and so on
//! scale = 2.0                   # optional, about the file's origin; optical depths are unchanged
//! rotate = [1.0, 0.0, 0.0, 90]  # optional, after the scale: an axis and degrees
//! translate = [0.0, 0.0, 1.0]   # optional, after both
//! up = "-y"                     # optional, which axis of the file points up: the file is first turned so that this is the up of [camera],
//!                               # or without one that of files without an `up`. [[hair]], [[splats]], [[volumes]] and [[meshes]] have it too
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
//! file = "smoke.vdb"            # .vdb, .nvdb, .nrrd, or .volume, which names a raw file; "smoke.####.vdb": one
//!                               # frame per file
//! grid = "density"              # optional, which grids of a .vdb or .nvdb: all of that name; "density[1]" is the second
//! level_set = "fog"             # optional, of a .vdb or .nvdb: density 1 inside the surface, 0 outside
//! window = [-1000.0, 400.0]     # optional, of a .nrrd or .volume: the stored numbers that are densities 0 and 1
//! offset = [0.5, 0.5, 0.5]      # optional, moves the grid by so many samples along its axes
//! extinction = 4.0              # optional, at density 1, in 1 / world unit of the file; replaces the file's
//! scale = 1.0                   # optional, about the file's origin; optical depths are unchanged
//! rotate = [0.0, 0.0, 1.0, 90]  # optional, after the scale: an axis and degrees
//! translate = [0.0, 0.0, 0.0]   # optional, after both
//! color = [0.9, 0.9, 0.95]      # optional, albedo
//! cells = 1                     # optional, 1, 2, 4 or 8: cells of the file along each side of a casting cell
//! frames_per_second = 24.0      # optional, for a sequence of files
//!
//! [[meshes]]                    # any number of them
//! file = "ground.gltf"          # .ply, .gltf or .glb, which may have splats too
//! scale = 1.0                   # optional
//! rotate = [1.0, 0.0, 0.0, 180] # optional
//! translate = [0.0, 0.0, 0.0]   # optional
//! albedo = [0.6, 0.6, 0.6]      # optional, replaces the file's
//! solid = false                 # optional; true: its back is never seen, like that of a ground
//! animation = "Run"             # optional, which animation of a .gltf or .glb is played, in a loop; without it the first
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
//!                               # a data file: up is the axis that is up in every file as placed, otherwise +z
//! position = [9.0, -9.0, 5.0]
//! target = [0.0, 0.0, 2.0]
//! up = [0.0, 0.0, 1.0]
//! fov_y_degrees = 38.0          # full vertical angle
//! ```

use crate::Result;
use crate::scene::files::animation::{self, Animation, Content, Kind, Part, Sequence};
use crate::scene::files::contents::{Contents, Loaded};
use crate::scene::files::far;
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{CameraEntry, LightEntry, camera, light, one_or_more};
use crate::scene::files::strand_file::Overrides;
use crate::scene::files::volume_file::{self, LevelSet, Placing};
use crate::scene::{
    AlphaMode, Camera, ExtinctionGroup, Mesh, Scene, files::input, files::mesh_file, files::particle_file, files::ply,
    files::splat_file, files::splat_ply, files::strand_file, files::up,
};
use glam::{DQuat, DVec3};
use serde::Deserialize;
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
    up: Option<String>,
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
    up: Option<String>,
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
    up: Option<String>,
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
    up: Option<String>,
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    extinction: Option<f64>,
    color: Option<[f32; 3]>,
    grid: Option<String>,
    level_set: Option<LevelSet>,
    window: Option<[f64; 2]>,
    #[serde(default)]
    offset: [f64; 3],
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
    up: Option<String>,
    rotate: Option<[f64; 4]>,
    #[serde(default = "one")]
    scale: f64,
    albedo: Option<[f64; 3]>,
    #[serde(default)]
    solid: bool,
    animation: Option<String>,
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
    let lights =
        parsed.light.as_ref().map(|entries| entries.iter().map(light).collect::<std::result::Result<Vec<_>, _>>());
    let lights = lights.transpose().map_err(wrong)?;
    let camera = parsed.camera.as_ref().map(camera).transpose().map_err(wrong)?;
    let extinction_ratio = parsed
        .color
        .as_ref()
        .map_or(Ok(Scene::GREY), |color| extinction_ratio("color extinction", color.extinction))
        .map_err(wrong)?;

    let up = scene_up(path, &parsed, camera.as_ref());
    let read = |away: DVec3| parsed.read(path, WorldFrame { away, up }, extinction_ratio);
    let (mut content, away) = far::brought_home(read, |content| &content.contents)?;
    let SceneContents { contents, animation, ups, .. } = &mut content;
    let mut notes = std::mem::take(&mut contents.notes);
    notes.extend(far::note(path, away));
    let home = Placement { translate: -away, ..Placement::AS_IT_STANDS };
    let lights = lights.map(|lights| lights.into_iter().map(|light| home.light(light)).collect());
    let lights = lights.transpose().map_err(wrong)?;
    let camera = camera.map(|camera| home.camera(&camera)).transpose().map_err(wrong)?;
    let lights = lights.unwrap_or_else(|| std::mem::take(&mut contents.lights));
    if lights.is_empty() {
        let cause = "missing field `light`, and no glTF file that it names brings one";
        return Err(input::error(path, cause, "add [light] to the scene file"));
    }
    let camera = match camera.or(contents.camera) {
        Some(camera) => camera,
        None => fitted_camera(path, contents, ups)?,
    };
    (contents.particles, contents.volumes) = animation.at(0.0)?;
    let SceneContents { mut contents, animation, inks, .. } = content;
    let sequences = Some(animation).filter(Animation::moves);
    if inks.own && sequences.as_ref().is_some_and(Animation::has_sequences) {
        return Err(wrong(
            "extinction_ratio beside a sequence of files, whose frames have other numbers of casters".into(),
        ));
    }
    if sequences.as_ref().is_some_and(Animation::has_sequences) {
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

impl SceneFile {
    /// Returns the name, the rotation and the up axis of each file.
    fn files(&self) -> impl Iterator<Item = (&str, Option<[f64; 4]>, Option<&str>)> {
        let particles = self.particles.iter().map(|e| (&*e.file, e.rotate, e.up.as_deref()));
        let hair = self.hair.iter().map(|e| (&*e.file, e.rotate, e.up.as_deref()));
        let splats = self.splats.iter().map(|e| (&*e.file, e.rotate, e.up.as_deref()));
        let volumes = self.volumes.iter().map(|e| (&*e.file, e.rotate, e.up.as_deref()));
        let meshes = self.meshes.iter().map(|e| (&*e.file, e.rotate, e.up.as_deref()));
        particles.chain(hair).chain(splats).chain(volumes).chain(meshes)
    }

    /// Reads all files. `common`: the extinction ratio of entries without their own.
    fn read(&self, path: &Path, frame: WorldFrame, common: [f32; 3]) -> Result<SceneContents> {
        let wrong = |cause: String| input::error(path, cause, WAY_OUT);
        let folder = path.parent().unwrap_or(Path::new(""));
        let named = input::named_by(path);
        let mut contents = Contents::default();
        let mut parts = Vec::new();
        let mut ups = Vec::new();
        let mut inks = Inks { common, all: Vec::new(), own: false };
        let mut record_up = |placement: Placement, file: &Path, up: Option<&str>| {
            ups.push(if up.is_some() { frame.up } else { placed_up(&placement, file) });
            placement
        };
        for entry in &self.particles {
            let wrong = |cause| wrong(format!("particles {}: {cause}", entry.file));
            let file = folder.join(&entry.file);
            let placement = frame.placement(entry.translate, entry.rotate, entry.scale, entry.up.as_deref());
            let placement = record_up(placement.map_err(wrong)?, &file, entry.up.as_deref());
            if let Some(rate) = rate(entry.frames_per_second, &file).map_err(wrong)? {
                inks.add(entry.extinction_ratio, 0).map_err(wrong)?;
                let kind = Kind::Particles(placement);
                let sequence = Sequence::open(&file, rate, kind, &mut contents.notes).map_err(&named)?;
                parts.push(Part::Moving(Box::new(sequence)));
                continue;
            }
            let particles = particle_file::load(&file, &placement).map_err(&named)?;
            inks.add(entry.extinction_ratio, particles.len()).map_err(wrong)?;
            parts.push(Part::Still(Content::Particles(particles)));
        }
        for entry in &self.hair {
            let wrong = |cause| wrong(format!("hair {}: {cause}", entry.file));
            let file = folder.join(&entry.file);
            let placement = frame.placement(entry.translate, entry.rotate, entry.scale, entry.up.as_deref());
            let placement = record_up(placement.map_err(wrong)?, &file, entry.up.as_deref());
            let overrides = entry.overrides().map_err(wrong)?;
            let strands = strand_file::load(&file, &placement, overrides, &mut contents.notes).map_err(&named)?;
            inks.add(entry.extinction_ratio, strands.len()).map_err(wrong)?;
            contents.strands.extend(strands);
        }
        for entry in &self.splats {
            let wrong = |cause| wrong(format!("splats {}: {cause}", entry.file));
            let file = folder.join(&entry.file);
            let placement = frame.placement(entry.translate, entry.rotate, entry.scale, entry.up.as_deref());
            let placement = record_up(placement.map_err(wrong)?, &file, entry.up.as_deref());
            let splats = splat_file::load(&file, &placement, &mut contents.notes).map_err(&named)?;
            inks.add(entry.extinction_ratio, splats.len()).map_err(wrong)?;
            contents.splats.extend(splats);
        }
        for entry in &self.meshes {
            let wrong = |cause| wrong(format!("meshes {}: {cause}", entry.file));
            let file = folder.join(&entry.file);
            let placement = frame.placement(entry.translate, entry.rotate, entry.scale, entry.up.as_deref());
            let placement = record_up(placement.map_err(wrong)?, &file, entry.up.as_deref());
            let albedo = entry.albedo.map(fractions).transpose().map_err(wrong)?;
            let mut loaded = mesh_file::load(&file, &placement, entry.animation.as_deref()).map_err(&named)?;
            entry.cut(&mut loaded.meshes).map_err(wrong)?;
            // A file may be named more than once.
            loaded.notes.retain(|note| !contents.notes.contains(note));
            contents.notes.extend(loaded.notes);
            for mut motion in loaded.motions {
                motion.follow(contents.meshes.len());
                contents.motions.push(motion);
            }
            for mesh in loaded.meshes {
                let albedo = albedo.unwrap_or(mesh.albedo);
                contents.meshes.push(Mesh { albedo, solid: entry.solid, ..mesh });
            }
            if !loaded.splats.is_empty() {
                inks.add(None, loaded.splats.len()).map_err(wrong)?;
                contents.splats.extend(loaded.splats);
            }
            contents.lights.extend(loaded.lights);
            contents.camera = contents.camera.or(loaded.camera);
        }
        for entry in &self.volumes {
            let wrong = |cause| wrong(format!("volumes {}: {cause}", entry.file));
            if let Some([low, high]) = entry.window.filter(|[low, high]| !(low < high && (high - low).is_finite())) {
                return Err(wrong(format!("window [{low:?}, {high:?}] is not two numbers, the lower first")));
            }
            let file = folder.join(&entry.file);
            let placement = frame.placement(entry.translate, entry.rotate, entry.scale, entry.up.as_deref());
            let placing = entry.placing(record_up(placement.map_err(wrong)?, &file, entry.up.as_deref()));
            if let Some(rate) = rate(entry.frames_per_second, &file).map_err(wrong)? {
                inks.add(entry.extinction_ratio, 0).map_err(wrong)?;
                let kind = Kind::Volume(placing);
                let sequence = Sequence::open(&file, rate, kind, &mut contents.notes).map_err(&named)?;
                parts.push(Part::Moving(Box::new(sequence)));
                continue;
            }
            let volumes = volume_file::load(&file, &placing, &mut contents.notes).map_err(&named)?;
            inks.add(entry.extinction_ratio, volumes.iter().map(|volume| volume.cells().len()).sum()).map_err(wrong)?;
            parts.push(Part::Still(Content::Volumes(volumes)));
        }
        let animation = Animation::new(parts, contents.motions.clone());
        (contents.particles, contents.volumes) = animation.some()?;
        Ok(SceneContents { contents, animation, inks, ups })
    }
}

/// How files stand in the scene.
#[derive(Clone, Copy)]
struct WorldFrame {
    /// By how much everything is moved to the origin.
    away: DVec3,
    /// The scene's up, to which files with an `up` are turned.
    up: DVec3,
}

impl WorldFrame {
    /// Creates an entry's placement; the error describes what is wrong.
    fn placement(
        &self,
        translate: [f64; 3],
        rotate: Option<[f64; 4]>,
        scale: f64,
        up: Option<&str>,
    ) -> std::result::Result<Placement, String> {
        let placement = Placement::new(translate, rotate, scale)?;
        let turn = up.map_or(Ok(DQuat::IDENTITY), |up| Ok::<_, String>(up::turn(up::parse(up)?, self.up)))?;
        let rotate = if turn == DQuat::IDENTITY { placement.rotate } else { placement.rotate * turn };
        Ok(Placement { translate: placement.translate - self.away, rotate, ..placement })
    }
}

/// What the files of a scene file hold.
struct SceneContents {
    /// With all that a camera must see: the first, middle and last frames of sequences.
    contents: Contents,
    animation: Animation,
    inks: Inks,
    /// The files' up directions, as placed.
    ups: Vec<DVec3>,
}

/// Returns the up direction of a scene: that of its camera, or of all files that are not turned, or else +z.
fn scene_up(path: &Path, parsed: &SceneFile, camera: Option<&Camera>) -> DVec3 {
    if let Some(camera) = camera {
        return up::nearest(camera.up);
    }
    let ups = parsed.files().filter(|(_, _, up)| up.is_none()).map(|(file, rotate, _)| {
        let placement = Placement::new([0.0; 3], rotate, 1.0).unwrap_or(Placement::AS_IT_STANDS);
        placed_up(&placement, &path.with_file_name(file))
    });
    common_up(&ups.collect::<Vec<_>>())
}

/// Returns the axis that is up in all files; +z if they differ.
fn common_up(ups: &[DVec3]) -> DVec3 {
    let first = ups.first().copied().unwrap_or(DVec3::Z);
    if ups.iter().all(|up| *up == first) { first } else { DVec3::Z }
}

/// Returns which direction is up in a file as placed. A file that is turned, but not to +y, is meant to stand along +z.
fn placed_up(placement: &Placement, file: &Path) -> DVec3 {
    let up = up_of(file);
    let placed = up::nearest(placement.rotate * up);
    if placement.rotate == DQuat::IDENTITY || placed == DVec3::Y { placed } else { DVec3::Z }
}

/// Returns which axis of a file points up, by its format.
fn up_of(file: &Path) -> DVec3 {
    let is_ply = input::ending(file) == "ply";
    let is_capture = !is_ply || ply::open(file).is_ok_and(|file| splat_ply::is_of_splats(&file));
    up::by_format(file, is_capture && splat_file::ENDINGS.contains(&input::ending(file).as_str()))
}

/// Returns a camera that sees all of the contents. `ups` are the files' up directions, as placed.
fn fitted_camera(path: &Path, contents: &mut Contents, ups: &[DVec3]) -> Result<Camera> {
    let camera = contents.fitted_camera(common_up(ups))?;
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

impl VolumesEntry {
    fn placing(&self, placement: Placement) -> Placing {
        let Self { extinction, color, cells: side, window, offset, .. } = *self;
        let (grid, level_set) = (self.grid.clone(), self.level_set);
        let offset = offset.into();
        Placing { extinction, color, side, grid, window, offset, level_set, ..Placing::from(placement) }
    }
}

impl HairEntry {
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
