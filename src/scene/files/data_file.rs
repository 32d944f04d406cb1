//! A data file that is loaded as a scene of its own.

use crate::Result;
use crate::scene::files::animation::{self, Animation, Kind, Part, Sequence};
use crate::scene::files::contents::{Contents, Loaded};
use crate::scene::files::far;
use crate::scene::files::placement::Placement;
use crate::scene::files::strand_file::Overrides;
use crate::scene::files::volume_file::{self, Placing};
use crate::scene::{
    Scene, files::default_view, files::input, files::mesh_file, files::particle_file, files::ply, files::splat_file,
    files::splat_ply, files::strand_file, files::up,
};
use glam::DVec3;
use std::path::Path;

/// Extensions of files that can be loaded as scenes of their own, in upper or lower case.
pub const DATA_ENDINGS: [&str; 14] =
    ["ply", "hair", "tfx", "gltf", "glb", "splat", "spz", "sog", "ksplat", "json", "volume", "nrrd", "vdb", "nvdb"];

/// Loads a file of particles, hair, splats, densities or meshes, with everything at the file's own coordinates, unless these are far from
/// the origin. Light and camera come from a glTF file if it has them; otherwise they are fitted. `up`: the axis that points up, if not that
/// of [`up::by_format`].
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if a file is invalid, is empty, or has everything at one point.
pub(in crate::scene) fn load(path: &Path, up: Option<DVec3>) -> Result<Loaded> {
    if animation::is_sequence(path) {
        return sequence(path, up);
    }
    let moved = |away: DVec3| contents(path, &Placement { translate: -away, ..Placement::AS_IT_STANDS });
    let (mut contents, away) = far::brought_home(moved, |contents| contents)?;
    let wrong = |cause| input::error(path, cause, "give another file, or name it in a scene file");
    if contents.spheres().next().is_none() {
        let why = contents.notes.first().map_or("it is empty", String::as_str);
        return Err(wrong(format!("nothing casts a shadow: {why}")));
    }
    let mut notes = std::mem::take(&mut contents.notes);
    notes.extend(far::note(path, away));
    let up = chosen_up(path, up, !contents.splats.is_empty(), &mut notes);
    let camera = match contents.camera {
        Some(camera) => camera,
        None => contents.fitted_camera(up)?.map_err(wrong)?,
    };
    let mut lights = std::mem::take(&mut contents.lights);
    if lights.is_empty() {
        lights.push(default_view::light(up));
    }
    let motions = std::mem::take(&mut contents.motions);
    let sequences = (!motions.is_empty()).then(|| Animation::new(Vec::new(), motions));
    let scene = contents.scene(input::stem(path), lights, camera).with_tints()?;
    Ok(Loaded { scene, sequences, notes })
}

/// Returns the axis that points up: the given one, or that of the file's format, with a note.
fn chosen_up(path: &Path, given: Option<DVec3>, is_capture: bool, notes: &mut Vec<String>) -> DVec3 {
    given.unwrap_or_else(|| {
        let up = up::by_format(path, is_capture);
        notes.extend(up::note(path, up));
        up
    })
}

/// Loads and places what a file has.
fn contents(path: &Path, placement: &Placement) -> Result<Contents> {
    let mut notes = Vec::new();
    let mut splats = || {
        let splats = splat_file::load(path, placement, &mut notes)?;
        Ok(Contents { splats, ..Contents::default() })
    };
    let contents = match input::ending(path).as_str() {
        "hair" | "tfx" => {
            let strands = strand_file::load(path, placement, Overrides::default(), &mut notes)?;
            Contents { strands, ..Contents::default() }
        }
        "splat" | "spz" | "sog" | "ksplat" | "json" => splats()?,
        ending if volume_file::ENDINGS.contains(&ending) => {
            let volumes = volume_file::load(path, &Placing::from(*placement), &mut notes)?;
            Contents { volumes, ..Contents::default() }
        }
        "ply" if splat_ply::is_of_splats(&ply::open(path)?) => splats()?,
        "ply" if ply::open(path)?.has_rows("tristrips") => {
            return Err(input::error(path, "its triangles are in strips, which are not read", "save it with faces"));
        }
        "ply" if !ply::open(path)?.has_rows("face") => {
            Contents { particles: particle_file::load(path, placement)?, ..Contents::default() }
        }
        _ => mesh_file::load(path, placement, None)?,
    };
    notes.extend(contents.notes);
    Ok(Contents { notes, ..contents })
}

/// Loads a scene of particles or a volume with one file per frame. The camera is fitted to a few of the files.
fn sequence(pattern: &Path, up: Option<DVec3>) -> Result<Loaded> {
    let wrong = |cause: String| input::error(pattern, cause, "give other files, or name them in a scene file");
    let moved = |away: DVec3| {
        let placement = Placement { translate: -away, ..Placement::AS_IT_STANDS };
        let kind = match input::ending(pattern).as_str() {
            "ply" => Kind::Particles(placement),
            ending if volume_file::ENDINGS.contains(&ending) => Kind::Volume(Placing::from(placement)),
            _ => {
                return Err(wrong(
                    "sequences are of particles (.ply) or of volumes (.vdb, .nvdb, .nrrd, .volume)".into(),
                ));
            }
        };
        let mut notes = Vec::new();
        let sequence = Sequence::open(pattern, animation::FRAMES_PER_SECOND, kind, &mut notes)?;
        let (particles, volumes) = sequence.some()?;
        Ok((sequence, Contents { particles, volumes, notes, ..Contents::default() }))
    };
    let ((sequence, mut contents), away) = far::brought_home(moved, |(_, contents)| contents)?;
    if contents.spheres().next().is_none() {
        return Err(wrong("nothing casts a shadow: its first, middle and last frames are empty".into()));
    }
    let mut notes = std::mem::take(&mut contents.notes);
    notes.extend(far::note(pattern, away));
    let up = chosen_up(pattern, up, false, &mut notes);
    let camera = contents.fitted_camera(up)?.map_err(wrong)?;
    let animation = Animation::new(vec![Part::Moving(Box::new(sequence))], Vec::new());
    let ((particles, volumes), reserve) = (animation.at(0.0)?, animation.reserve());
    let scene = contents.scene(animation::stem(pattern), vec![default_view::light(up)], camera);
    let scene = Scene { particles, volumes, reserve, ..scene };
    Ok(Loaded { sequences: Some(animation), notes, ..scene.into() })
}
