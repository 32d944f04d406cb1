//! The effect of packing on the map errors.

use super::map_error;
use crate::support::{gpu_test, shared_data, some};
use gobo::reference::truth::{Casters, map_truths};
use gobo::scene::{Scene, View};

/// No map error grows by more than a twentieth.
#[test]
fn packing_adds_little_to_the_errors() {
    if crate::support::is_costly("packing_adds_little_to_the_errors") {
        return;
    }
    let name = "packing_adds_little_to_the_errors";
    let Some(data) = shared_data(name) else { return };
    gpu_test(name, |context| {
        let file = data.join("plume_8k.toml");
        let scene = Scene::load(file.to_str().expect("UTF-8"), 0.0).expect("a scene");
        let truth = map_truths(&Casters::new(&scene), &scene, &View::volumes(&scene, 128)).remove(0);
        for curve in ["linear", "exponential"] {
            for nodes in some([8, 4, 16], 1) {
                let [full, packed] = ["full", "packed"].map(|storage| {
                    let text = format!("avsm:nodes={nodes},curve={curve},path=two-pass,size=128,storage={storage}");
                    let error = map_error(context, &scene, &text, &truth);
                    println!("{text}: {error:?}");
                    error
                });
                for (what, full, packed) in [
                    ("mean", Some(full.mean_abs), Some(packed.mean_abs)),
                    ("rms", full.rms, packed.rms),
                    ("p99", full.p99, packed.p99),
                    ("max", full.max, packed.max),
                ] {
                    let (full, packed) = full.zip(packed).expect("measured");
                    assert!(packed <= 1.05 * full, "{nodes} nodes, {curve}: {what} {packed}, not {full}");
                }
            }
        }
    });
}
