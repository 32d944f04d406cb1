//! Consecutive frames with a moving and a static camera.

use super::{build, camera, lamps, largest_difference, rounding};
use crate::support::{gpu_test, is_left_out, some};
use glam::DVec3;
use gobo::bench::{picture_error, picture_flicker};
use gobo::reference::truth::{Casters, picture};
use gobo::scene::{Picture, Scene, View};
use gobo::shading::DitherKind;
use gobo::shading::{Lighting, Renderer, Shading, Tiled};

const SIZE: [u32; 2] = [96, 54];

/// Returns the cameras of a sideways move in `frames` steps.
fn sideways(scene: &Scene, frames: usize) -> Vec<View> {
    let moved = |frame: usize| {
        let mut scene = scene.clone();
        scene.camera.position += frame as f64 * DVec3::new(0.09, 0.02, 0.01);
        camera(&scene, SIZE)
    };
    (0..frames).map(moved).collect()
}

fn drawn(context: &gobo::gpu::Context, scene: &Scene, text: &str, tiled: Tiled, cameras: &[View]) -> Vec<Picture> {
    let built = build(context, scene, text);
    let answer = built.technique.technique.answer();
    let mut renderer = Renderer::new(context, &built.world, &cameras[0]).expect("a renderer");
    renderer.sequence(&built.world, &answer, Shading::Tiled(tiled), Lighting::Fragment, cameras).expect("drawn")
}

/// Frames alternate between two sets of sample positions, yet from the second frame on all pictures of a static camera are the same.
#[test]
fn a_still_picture_does_not_flicker() {
    gpu_test("a_still_picture_does_not_flicker", |context| {
        let scene = lamps::lamps(33);
        let cameras = vec![camera(&scene, SIZE); 5];
        let of = |text: &'static str| [true, false].map(|blur| (text, blur));
        let cases = [of("voxel-grid:size=64,march=steps,steps=5"), of("voxel-grid:size=64")].concat();
        for (text, blur) in some(cases, 1) {
            for dither in [DitherKind::None, DitherKind::Ordered, DitherKind::Noise] {
                let tiled = Tiled { dither, blur, ..Tiled::default() };
                let pictures = drawn(context, &scene, text, tiled, &cameras);
                assert!(pictures[1..].windows(2).all(|two| two[0] == two[1]), "{text}, {tiled:?}");
                let changes = pictures[0] != pictures[1];
                assert_eq!(changes, dither != DitherKind::None, "{text}, {tiled:?}: the two frames differ");
            }
        }
    });
}

/// Newly visible places have no history, and all history belongs to the same place. So blur and history bring even steps nearer to the
/// truth, and reduce their flicker.
#[test]
fn blur_and_history_calm_what_is_dithered() {
    let name = "blur_and_history_calm_what_is_dithered";
    if is_left_out(name) {
        return;
    }
    gpu_test(name, |context| {
        let scene = lamps::lamps(24);
        let cameras = sideways(&scene, 6);
        let casters = Casters::new(&scene);
        let truth: Vec<_> = cameras.iter().map(|camera| picture(&casters, &scene, camera)).collect();
        let measured = |tiled: Tiled| {
            let pictures = drawn(context, &scene, "voxel-grid:size=128,march=steps,steps=15", tiled, &cameras);
            let last = picture_error(&pictures[5], &truth[5]).rmse;
            let flicker = picture_flicker(&pictures, &truth).expect("frames");
            println!("{tiled:?}: RMSE {last:.4}, flicker {flicker:.4}");
            (last, flicker)
        };
        let all = measured(Tiled::default());
        let no_history = measured(Tiled { history: false, ..Tiled::default() });
        let dither_alone = measured(Tiled { history: false, blur: false, ..Tiled::default() });
        let bare = measured(Tiled::BARE);
        assert!(no_history.0 < dither_alone.0 && no_history.1 < dither_alone.1);
        assert!(all.0 < bare.0 && all.1 < no_history.1, "{all:?}, {no_history:?}, {bare:?}");
    });
}

/// Bits belong to lights: if all lights move at once, and the technique's look-ups with them, nothing of their old positions is left one
/// frame later. Kernels of another technique start anew.
#[test]
fn history_is_one_frame_long() {
    let name = "history_is_one_frame_long";
    if is_left_out(name) {
        return;
    }
    gpu_test(name, |context| {
        let scene = lamps::lamps(24);
        let mut moved = scene.clone();
        moved.lights.reverse();
        let mut built = build(context, &scene, "voxel-grid:size=64");
        let renderer = Renderer::new(context, &built.world, &camera(&scene, SIZE)).expect("a renderer");
        let shading = Shading::Tiled(Tiled::default());
        renderer.picture(&built.technique.technique.answer(), shading, Lighting::Fragment).expect("drawn");
        built.world.replace(&moved).expect("as many of all");
        built.technique.build(&built.world).expect("built");
        let answer = built.technique.technique.answer();
        let after = renderer.picture(&answer, shading, Lighting::Fragment).expect("drawn");
        let fresh = super::picture(context, &build(context, &moved, "voxel-grid:size=64"), SIZE, shading);
        let difference = largest_difference(&after, &fresh);
        assert!(difference <= rounding(context, &fresh), "{difference}");
        // Another technique's look-ups are not averaged with previous ones.
        let other = build(context, &moved, "shadow-map:size=64");
        let mixed = Renderer::new(context, &other.world, &camera(&moved, SIZE)).expect("a renderer");
        let once = |answer| {
            let kernels = mixed.kernels(&answer, shading, Lighting::Fragment).expect("kernels");
            mixed.draw(&kernels).expect("drawn");
            mixed.read_tiles().expect("read").expect("tiles").sources
        };
        let shadow_map = other.technique.technique.answer();
        assert!(once(shadow_map).iter().all(|source| *source == u32::MAX), "there is no frame before");
        assert!(once(shadow_map).iter().any(|source| *source != u32::MAX), "there is");
        let grid = build(context, &moved, "voxel-grid:size=64");
        assert!(once(grid.technique.technique.answer()).iter().all(|source| *source == u32::MAX), "it was another's");
    });
}
