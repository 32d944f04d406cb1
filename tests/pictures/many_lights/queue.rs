//! `shadows=queued`: the same look-ups, whichever thread does them.

use super::{build, lamps, seen};
use crate::support::{gpu_test, is_left_out, some};
use gobo::shading::Tiled;
use gobo::shading::{DitherKind, ShadowsKind};

/// Queued look-ups give the same bits as immediate ones, in scenes whose look-ups all fit in the list and in one whose look-ups do not:
/// sixty lights of infinite reach at each pixel, with capacity for half of them.
#[test]
fn a_list_answers_what_is_asked_at_once() {
    gpu_test("a_list_answers_what_is_asked_at_once", |context| {
        let mut endless = lamps::lamps(60);
        endless.lights.iter_mut().for_each(|light| light.radius = f64::INFINITY);
        endless.name = "endless".into();
        for (scene, size) in some([(endless, [40, 24])].into_iter().chain(lamps::all()), 2) {
            let built = build(context, &scene, "voxel-grid:size=64");
            for dither in some([DitherKind::Noise, DitherKind::None], 1) {
                let direct = Tiled { dither, ..Tiled::BARE };
                let bits = seen(context, &built, size, direct);
                let queued = seen(context, &built, size, Tiled { shadows: ShadowsKind::Queued, ..direct });
                let sky = |shadows: &[u32]| -> Vec<u32> {
                    let is_seen = |i: &usize| bits.geometry[i % bits.geometry.len()][0] != 0;
                    (0..shadows.len()).filter(is_seen).map(|i| shadows[i]).collect()
                };
                assert!(sky(&bits.shadows) == sky(&queued.shadows), "{}, {dither:?}", scene.name);
            }
        }
    });
}

/// The list is empty again after each frame: the third frame equals the first.
#[test]
fn a_list_is_emptied() {
    let name = "a_list_is_emptied";
    if is_left_out(name) {
        return;
    }
    gpu_test(name, |context| {
        use gobo::shading::{Lighting, Renderer, Shading};
        let scene = lamps::lamps(40);
        let built = build(context, &scene, "voxel-grid:size=64");
        let renderer = Renderer::new(context, &built.world, &super::camera(&scene, [96, 54])).expect("a renderer");
        let tiled = Shading::Tiled(Tiled { shadows: ShadowsKind::Queued, ..Tiled::BARE });
        let kernels =
            renderer.kernels(&built.technique.technique.answer(), tiled, Lighting::Fragment).expect("kernels");
        let mut pictures = Vec::new();
        for _ in 0..3 {
            renderer.draw(&kernels).expect("drawn");
            pictures.push(renderer.read().expect("read"));
        }
        assert!(pictures[0] == pictures[1] && pictures[0] == pictures[2]);
        let direct = super::picture(context, &built, [96, 54], Shading::Tiled(Tiled::BARE));
        assert!(pictures[0] == direct, "the same bits, the same shader");
    });
}
