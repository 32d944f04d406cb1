//! A separate thread may own a world, the techniques opened for it, and their pictures.

use super::{build, fewer, opened, specs};
use crate::support::{ask, gpu_test, some};
use gobo::gpu::{Buffer, Context, Image};
use gobo::query::{Query, QueryKernel, Slice};
use gobo::scene::View;
use gobo::shading::{FogKernel, Kernels, Lighting, Pictures, Renderer, Shading, StepsKernel};
use gobo::technique::{Opened, Technique};
use gobo::world::World;

/// Anything that is not `Send` fails to compile.
#[test]
fn owners_are_sent() {
    fn is_send<T: Send>() {}
    is_send::<Context>();
    is_send::<Buffer>();
    is_send::<Image>();
    is_send::<World>();
    is_send::<Box<dyn Technique>>();
    is_send::<Opened>();
    is_send::<Query>();
    is_send::<QueryKernel>();
    is_send::<Slice>();
    is_send::<Renderer>();
    is_send::<Kernels>();
    is_send::<Pictures>();
    is_send::<FogKernel>();
    is_send::<StepsKernel>();
}

/// A world, techniques and a renderer created on this thread are built, queried and drawn on another one, and come back: look-ups and
/// picture equal those of a single thread, to the bit.
#[test]
fn a_render_thread_owns_a_technique() {
    gpu_test("a_render_thread_owns_a_technique", |context| {
        let mut scene = fewer();
        scene.lights.truncate(1);
        let camera = View::camera(&scene.camera, &scene, [32, 18]);
        let points: Vec<_> =
            (0..64).map(|i| [0, 1, 2].map(|axis| ((i >> (2 * axis)) % 4) as f32 * 0.5 - 0.8)).collect();
        for spec in some(specs("a_render_thread_owns_a_technique", context), 4) {
            let text = spec.short();
            let make = || {
                let world = World::new(context, &scene).expect("room for the scene");
                let opened = opened(context, &world, &spec);
                (opened, Renderer::new(context, &world, &camera).expect("room for the picture"), world)
            };
            let answer = |(opened, renderer, world): &mut (Opened, Renderer, World)| {
                build(opened, world, &text);
                let technique = opened.technique.as_ref();
                let picture = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect("drawn");
                (ask(context, technique, 0, &points), picture)
            };
            let expected = answer(&mut make());
            let mut made = make();
            let (mut made, there) = std::thread::scope(|scope| {
                let other = scope.spawn(move || {
                    let answers = answer(&mut made);
                    (made, answers)
                });
                other.join().expect("the thread ended well")
            });
            assert!(there == expected, "{text}: other answers on another thread");
            made.0.rebuild(&made.2).expect("built");
            assert!(answer(&mut made) == expected, "{text}: other answers after it came back");
        }
    });
}
