//! For tests, with `GOBO_TEST_LITTLE` ([`super::test_hooks`]): commands run all their steps, on a reduced workload.
//! They use two frames, small pictures, maps and grids, the first variant of each sweep, and the first casters of the
//! first scene. So a test can run every command that the documentation names.

use crate::scene::Scene;
use crate::technique::{Name, Spec, Values};
use std::sync::atomic::{AtomicBool, Ordering};

/// Maximum number of texels per side or of slices, where the key accepts any number: enough for the widest filter.
const MOST_TEXELS: u32 = 48;

/// Maximum number of casters of each kind, and of triangles of each mesh.
const MOST_CASTERS: usize = 300;

/// Largest number in the name of a scene; larger than the number of lights above which a scene counts as one of many
/// lights.
const MOST_NAMED: u32 = 12;

/// Number of look-ups timed at once.
pub(super) const LOOKUPS: usize = 8192;
/// Number of seen points in a run with a reduced workload.
pub(super) const SEEN: usize = 1024;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Reduces the workload of all commands from now on.
pub(super) fn begin() {
    ASKED.store(true, Ordering::Relaxed);
}

/// Whether the workload is reduced.
pub(super) fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Returns the name of a scene with small numbers: `courtyard:lights=12` for `courtyard:lights=1024`.
pub(super) fn name(name: &str) -> String {
    match name.rsplit_once('=').and_then(|(key, number)| Some((key, number.parse::<u32>().ok()?))) {
        Some((key, number)) if is_asked() => format!("{key}={}", number.min(MOST_NAMED)),
        _ => name.to_owned(),
    }
}

/// Keeps the first `few` of several items. The caller has already checked that all items exist.
pub(super) fn first<T>(all: &mut Vec<T>, few: usize) {
    if is_asked() {
        all.truncate(few);
    }
}

/// Keeps the first casters of the scene.
pub(super) fn scene(mut scene: Scene) -> Scene {
    // Inks hold caster counts, so a scene with inks keeps all casters.
    if is_asked() && scene.inks.is_empty() {
        scene.particles.truncate(MOST_CASTERS);
        scene.strands.truncate(MOST_CASTERS);
        scene.splats.truncate(MOST_CASTERS);
        scene.volumes.iter_mut().for_each(|volume| volume.truncate(MOST_CASTERS));
        for mesh in &mut scene.meshes {
            mesh.triangles.truncate(MOST_CASTERS);
            let used = mesh.triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
            mesh.positions.truncate(used);
            if let Some(alpha) = &mut mesh.alpha {
                alpha.factors.truncate(used);
                alpha.uvs.truncate(used);
            }
        }
    }
    scene
}

/// Keeps the first spec of a sweep, with the smallest map or grid.
pub(super) fn specs(mut specs: Vec<Spec>) -> Vec<Spec> {
    if !is_asked() {
        return specs;
    }
    for spec in &mut specs {
        for name in Name::SIZES {
            let key = spec.keys().find(|key| Name::from(*key) == name && !spec.text(name).is_empty());
            match key.map(|key| key.values) {
                Some(Values::OneOf(words)) => spec.set(name, words[0]),
                Some(_) if spec.text(name).parse().is_ok_and(|size: u32| size > MOST_TEXELS) => {
                    spec.set(name, &MOST_TEXELS.to_string());
                }
                _ => {}
            }
        }
    }
    specs.truncate(1);
    specs
}
