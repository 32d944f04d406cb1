//! AVSM suits hair, say Fife and Strugar (2013): on the built-in hair a few nodes match whole lists.

use super::map_error;
use crate::support::{gpu_test, some};
use gobo::reference::truth::{Casters, limit_mean_abs, map_truths};
use gobo::scene::{Scene, View};

/// Texels per side.
const SIZE: u32 = 128;

/// For each number of nodes, the error is at most about twice the lower bound for that number. The head is removed from the scene, because
/// the error of its depth map is the same for every technique.
#[test]
fn avsm_suits_hair() {
    if crate::support::is_costly("avsm_suits_hair") {
        return;
    }
    gpu_test("avsm_suits_hair", |context| {
        let mut scene = Scene::load("hair", 20.0).expect("built in");
        scene.meshes.clear();
        let casters = Casters::new(&scene);
        let views = View::volumes(&scene, SIZE);
        let truths = map_truths(&casters, &scene, &views);
        let limits = limit_mean_abs(&casters, &views, &truths, &[4, 8, 16]);
        let truth = &truths[0];
        println!("{:.1} segments a covered texel", truth.segments as f64 / truth.texels.len() as f64);
        let lists = map_error(context, &scene, &format!("uncompressed:size={SIZE}"), truth).mean_abs;
        println!("uncompressed: {lists:.2e}");
        assert!(lists < 1e-5, "{lists}");
        for (count, limit) in some([8, 4, 16].into_iter().zip([limits[1], limits[0], limits[2]]), 1) {
            for path in ["two-pass", "two-pass,resolve=whole", "binned"] {
                let text = format!("avsm:nodes={count},path={path},size={SIZE}");
                let error = map_error(context, &scene, &text, truth).mean_abs;
                println!("{text}: {error:.2e}, {:.2} × the limit {limit:.2e}", error / limit);
                // On smoke these settings come within about twice the limit; hair must be no worse.
                assert!(error < 2.0 * limit + 1e-5, "{text}: {error}, the limit is {limit}");
            }
        }
    });
}
