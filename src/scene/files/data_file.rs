//! A data file that is loaded as a scene of its own.

use crate::Result;
use crate::scene::files::animation::{self, Animation, Kind, Part, Sequence};
use crate::scene::files::contents::{Contents, Loaded};
use crate::scene::files::placement::Placement;
use crate::scene::files::strand_file::Overrides;
use crate::scene::{
    Scene, files::default_view, files::input, files::mesh_file, files::particle_file, files::ply, files::splat_file,
    files::splat_ply, files::strand_file, files::volume_file,
};
use glam::DVec3;
use std::path::Path;

/// Extensions of files that can be loaded as scenes of their own, in upper or lower case.
pub const DATA_ENDINGS: [&str; 10] = ["ply", "hair", "tfx", "gltf", "glb", "splat", "spz", "volume", "nrrd", "vdb"];

/// Loads a file of particles, hair, splats, densities or meshes, with everything at the file's own coordinates. Light and camera come from
/// a glTF file if it has them; otherwise they are fitted. Up is +y in glTF and SPZ by their specifications, and in TressFX by its
/// exporters' convention; in other formats, which define no up direction, it is +z.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if a file is invalid, is empty, or has everything at one point.
pub(in crate::scene) fn load(path: &Path) -> Result<Loaded> {
    if animation::is_sequence(path) {
        return sequence(path);
    }
    let ending = input::ending(path);
    let mut contents = match ending.as_str() {
        "hair" | "tfx" => {
            let mut notes = Vec::new();
            let strands = strand_file::load(path, &Placement::AS_IT_STANDS, Overrides::default(), &mut notes)?;
            Contents { strands, notes, ..Contents::default() }
        }
        "splat" | "spz" => splats(path)?,
        ending if volume_file::ENDINGS.contains(&ending) => {
            let mut notes = Vec::new();
            let volumes = vec![volume_file::load(path, &volume_file::Placing::AS_IT_STANDS, &mut notes)?];
            Contents { volumes, notes, ..Contents::default() }
        }
        "ply" if splat_ply::is_of_splats(&ply::open(path)?) => splats(path)?,
        "ply" if ply::open(path)?.has_rows("tristrips") => {
            return Err(input::error(path, "its triangles are in strips, which are not read", "save it with faces"));
        }
        "ply" if !ply::open(path)?.has_rows("face") => {
            Contents { particles: particle_file::load(path)?, ..Contents::default() }
        }
        _ => mesh_file::load(path)?,
    };
    let wrong = |cause| input::error(path, cause, "give another file, or name it in a scene file");
    if contents.spheres().next().is_none() {
        let why = contents.notes.first().map_or("it is empty", String::as_str);
        return Err(wrong(format!("nothing casts a shadow: {why}")));
    }
    let up = up(path);
    let camera = match contents.camera {
        Some(camera) => camera,
        None => default_view::camera(&contents, up).map_err(wrong)?,
    };
    let mut lights = std::mem::take(&mut contents.lights);
    if lights.is_empty() {
        lights.push(default_view::light(up));
    }
    let notes = std::mem::take(&mut contents.notes);
    let scene = contents.scene(input::stem(path), lights, camera).with_tints()?;
    Ok(Loaded { notes, ..scene.into() })
}

/// Returns the up direction of a file, by its format.
pub(in crate::scene) fn up(path: &Path) -> DVec3 {
    match input::ending(path).as_str() {
        "gltf" | "glb" | "tfx" | "spz" => DVec3::Y,
        _ => DVec3::Z,
    }
}

/// Loads a scene of particles or a volume with one file per frame. The camera is fitted to a few of the files.
fn sequence(pattern: &Path) -> Result<Loaded> {
    let wrong = |cause: String| input::error(pattern, cause, "give other files, or name them in a scene file");
    let kind = match input::ending(pattern).as_str() {
        "ply" => Kind::Particles(Placement::AS_IT_STANDS),
        ending if volume_file::ENDINGS.contains(&ending) => Kind::Volume(volume_file::Placing::AS_IT_STANDS),
        _ => return Err(wrong("sequences are of particles (.ply) or of volumes (.vdb, .nrrd, .volume)".into())),
    };
    let mut notes = Vec::new();
    let sequence = Sequence::open(pattern, animation::FRAMES_PER_SECOND, kind, &mut notes)?;
    let (particles, volumes) = sequence.some()?;
    let contents = Contents { particles, volumes, ..Contents::default() };
    if contents.spheres().next().is_none() {
        return Err(wrong("nothing casts a shadow: its first, middle and last frames are empty".into()));
    }
    let camera = default_view::camera(&contents, DVec3::Z).map_err(wrong)?;
    let animation = Animation::new(vec![Part::Moving(sequence)]);
    let ((particles, volumes), reserve) = (animation.at(0.0)?, animation.reserve());
    let scene = contents.scene(animation::stem(pattern), vec![default_view::light(DVec3::Z)], camera);
    let scene = Scene { particles, volumes, reserve, ..scene };
    Ok(Loaded { sequences: Some(animation), notes, ..scene.into() })
}

fn splats(path: &Path) -> Result<Contents> {
    let mut notes = Vec::new();
    let splats = splat_file::load(path, &Placement::AS_IT_STANDS, &mut notes)?;
    Ok(Contents { splats, notes, ..Contents::default() })
}
