//! Pictures of a world filled by the caller's buffers: the device sorts the casters, so the host need not know them.

use super::buffers::{fill, scene, theirs};
use super::{build, opened};
use crate::support::{gpu_test, spec};
use gobo::Error;
use gobo::gpu::Context;
use gobo::scene::{Picture, Scene, View};
use gobo::shading::{Lighting, PainterKind, Renderer, Shading};
use gobo::world::{Capacity, World};

fn pictured(context: &Context, world: &World, scene: &Scene, text: &str) -> Picture {
    let mut opened = opened(context, world, &spec(text));
    build(&mut opened, world, text);
    let camera = View::camera(&scene.camera, scene, [64, 36]);
    let renderer = Renderer::new(context, world, &camera).expect("a renderer");
    renderer.picture_of(opened.technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("drawn")
}

/// Smoke from a buffer, with its count on the host or on the device and room for more: the picture equals that of a scene of the same
/// casters, to the bit.
#[test]
fn smoke_of_a_buffer_is_seen_as_a_scenes() {
    gpu_test("smoke_of_a_buffer_is_seen_as_a_scenes", |context| {
        let mut scene = scene(9, 80);
        scene.lights.truncate(1);
        // Meshes are left out: whether triangles form a closed mesh affects their lighting, and triangles from a buffer do not carry that
        // flag.
        scene.meshes.clear();
        let nothing = Scene { particles: Vec::new(), ..scene.clone() };
        for text in ["none", "avsm:path=two-pass,size=32", "half-angle:size=32,slices=32"] {
            let ours = super::world(context, &scene);
            let expected = pictured(context, &ours, &scene, text);
            let without = pictured(context, &super::world(context, &nothing), &scene, "none");
            let differing = expected.pixels.iter().zip(&without.pixels).filter(|(a, b)| a != b).count();
            assert!(differing > 200, "{text}: {differing} pixels see smoke");
            for (more, on_device) in [(0, false), (40, false), (40, true)] {
                // Slices hold equal numbers of casters, which include those past the device's count.
                if text.starts_with("half") && on_device {
                    continue;
                }
                let world = theirs(context, &scene, more, on_device);
                assert_eq!(world.caster_count(), if on_device { 120 } else { 80 });
                assert!(pictured(context, &world, &scene, text) == expected, "{text}, {more} more, {on_device}");
            }
        }
    });
}

/// Data that only a scene has is named in the error: colors of splats and volumes.
#[test]
fn splats_of_a_buffer_have_no_colors() {
    gpu_test("splats_of_a_buffer_have_no_colors", |context| {
        let scene = scene(9, 10);
        for capacity in [Capacity { splats: 5, ..Capacity::default() }, Capacity { cells: 5, ..Capacity::default() }] {
            let mut world = World::of(context, Capacity { lights: 3, particles: 2, ..capacity }).expect("room");
            context
                .submit(|commands| world.update_lights(commands, &scene.lights).expect("lights"))
                .expect("submitted");
            let camera = View::camera(&scene.camera, &scene, [16, 9]);
            match Renderer::new(context, &world, &camera) {
                Err(Error::Refused(needs)) => {
                    assert!(needs.to_string().contains("colors of splats and volumes"), "{needs}")
                }
                Err(error) => panic!("{error}"),
                Ok(_) => panic!("it is drawn"),
            }
        }
    });
}

/// Triangles added after the renderer was created appear in its next picture, with either painter.
#[test]
fn triangles_may_come_after_the_renderer() {
    gpu_test("triangles_may_come_after_the_renderer", |context| {
        let full = scene(9, 20);
        let camera = View::camera(&full.camera, &full, [64, 36]);
        for painter in [PainterKind::Raster, PainterKind::Compute] {
            let draw = |renderer: &Renderer, world: &World| {
                let mut opened = opened(context, world, &spec("none"));
                build(&mut opened, world, "none");
                renderer.picture_of(opened.technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("drawn")
            };
            let made = |world: &World| {
                let mut renderer = Renderer::new(context, world, &camera).expect("a renderer");
                renderer.paint_by(Some(painter));
                renderer
            };
            let expected = theirs(context, &full, 0, false);
            let expected = draw(&made(&expected), &expected);
            let triangles = full.meshes.iter().map(|mesh| mesh.triangles.len()).sum::<usize>() as u32;
            let capacity =
                Capacity { particles: 20, triangles, lights: full.lights.len() as u32, ..Capacity::default() };
            let mut world = World::of(context, capacity).expect("room");
            fill(context, &mut world, &Scene { meshes: Vec::new(), ..full.clone() }, false);
            let mut renderer = made(&world);
            let before = draw(&renderer, &world);
            fill(context, &mut world, &full, false);
            renderer.look(&world, &camera).expect("the next frame");
            let differing = before.pixels.iter().zip(&expected.pixels).filter(|(a, b)| a != b).count();
            assert!(differing > 100, "{differing} pixels see meshes");
            assert!(draw(&renderer, &world) == expected, "{}: the meshes are not all there", painter.word());
        }
    });
}
