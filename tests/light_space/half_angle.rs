//! Half-angle slicing: the picture against its CPU twin, for cameras in front of and behind the smoke, and its convergence with more
//! slices.

use crate::support::scenes::Random;
use crate::support::{ask, gpu_test, ran, scenes, some, spec};
use glam::{DVec2, DVec3};
use gobo::bench::picture_error;
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, picture as truth};
use gobo::reference::twin::{half_angle, opaque};
use gobo::scene::{Camera, Mesh, Particle, Picture, Scene, Strand, View};
use gobo::shading::{Lighting, PainterKind, Renderer, Shading};
use gobo::technique::{answers_in_space, open};
use gobo::world::World;

const PIXELS: [u32; 2] = [48, 32];

const PAINTERS: [PainterKind; 2] = [PainterKind::Raster, PainterKind::Compute];

/// Returns a technique's picture, the camera, and the light's map if there is one.
fn painted(context: &Context, scene: &Scene, text: &str, painter: PainterKind) -> (Picture, View, Option<View>) {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = crate::support::opened(open(context, &world, &spec(text)), text);
    opened.build(&world).expect(text);
    let camera = View::camera(&scene.camera, scene, PIXELS);
    let mut renderer = Renderer::new(context, &world, &camera).expect("room for the picture");
    renderer.paint_by(Some(painter));
    let technique = opened.technique.as_ref();
    let first = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect(text);
    let again = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect(text);
    assert!(first == again, "{text}: the second picture differs");
    (first, camera, technique.inspect().maps().first().map(|map| map.caster_view))
}

/// Returns cameras that look along the light, against it and across it.
fn cameras() -> [Camera; 3] {
    let at = |x, y, z| Camera { position: DVec3::new(x, y, z), target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 40.0 };
    [at(1.0, 0.5, 6.0), at(-1.0, 0.7, -6.0), at(6.0, 0.5, 0.4)]
}

/// Returns the largest difference in any channel.
fn largest(a: &Picture, b: &Picture) -> f32 {
    let channels = |p: &Picture| p.pixels.concat();
    channels(a).into_iter().zip(channels(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn pictures_equal_their_twins() {
    gpu_test("pictures_equal_their_twins", |context| {
        let smoke = scenes::directional("smoke", [0.1, 0.2, -1.0], scenes::random().particles);
        let spot = scenes::spot([0.3, 0.2, 6.0], 80.0, smoke.clone());
        let mut hair = scenes::strands();
        hair.particles = smoke.particles.clone();
        for scene in some(vec![smoke, spot, hair], 2) {
            for camera in cameras() {
                let scene = Scene { camera, ..scene.clone() };
                for (slices, storage) in [(32, "r32f"), (64, "r16f")] {
                    let text = format!("half-angle:slices={slices},storage={storage},size=24");
                    if !crate::support::runs("pictures_equal_their_twins", context, &text) {
                        continue;
                    }
                    let pictures = PAINTERS.map(|painter| painted(context, &scene, &text, painter));
                    let (camera, view) = (pictures[0].1, pictures[0].2.expect("a map"));
                    let twin = half_angle::picture(&Casters::new(&scene), &scene, &camera, &view, slices);
                    for ((painted, ..), painter) in pictures.iter().zip(PAINTERS) {
                        let error = picture_error(painted, &twin);
                        let what =
                            format!("{} {text} from {:?}, {}", scene.name, scene.camera.position, painter.word());
                        println!("{what}: RMSE {}, largest {}", error.rmse, largest(painted, &twin));
                        assert!(error.rmse < if storage == "r32f" { 1e-4 } else { 1e-3 }, "{what}: {error:?}");
                    }
                    // Without meshes, both painters blend the same slices.
                    let apart = largest(&pictures[0].0, &pictures[1].0);
                    let most = if context.features().float32_blend { 1e-4 } else { 1e-2 };
                    assert!(apart < most, "{} {text}: painters are {apart} apart", scene.name);
                }
            }
        }
    });
}

/// Many small spheres, so that a slice of a 128th contains more than one.
fn fine() -> Vec<Particle> {
    let mut random = Random::new(34);
    (0..2000).map(|_| Particle { position: random.point(-1.0, 1.0), radius: 0.12, extinction: 0.8 }).collect()
}

/// More slices come nearer to the truth, from whichever side the smoke is seen.
#[test]
fn more_slices_are_nearer_to_the_truth() {
    gpu_test("more_slices_are_nearer_to_the_truth", |context| {
        for camera in cameras() {
            let scene = Scene { camera, ..scenes::directional("smoke", [0.1, 0.2, -1.0], fine()) };
            let view = View::camera(&scene.camera, &scene, PIXELS);
            let reference = truth(&Casters::new(&scene), &scene, &view);
            let errors = [32, 64, 128].map(|slices| {
                let (painted, ..) =
                    painted(context, &scene, &format!("half-angle:slices={slices},size=64"), PainterKind::Raster);
                picture_error(&painted, &reference).rmse
            });
            let (none, ..) = painted(context, &scene, "none", PainterKind::Raster);
            let none = picture_error(&none, &reference).rmse;
            println!("from {:?}: {errors:?}, without shadows {none}", scene.camera.position);
            assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
            assert!(errors[2] < 0.2 * none, "{errors:?} of {none}");
        }
    });
}

/// A ball of smoke with a wall through its centre, lit from above. On the wall the light is what the ball's upper half transmits, a closed
/// form; beside the wall it is what the whole ball transmits; below the wall there is none. A second ball and a lock of hair below the wall
/// change nothing.
#[test]
fn what_lies_behind_a_wall_does_not_darken_it() {
    gpu_test("what_lies_behind_a_wall_does_not_darken_it", |context| {
        let (radius, extinction, half) = (0.8f32, 1.5f32, 0.5f32);
        let ball = Particle { position: [0.0; 3], radius, extinction };
        let behind = Particle { position: [0.1, 0.0, -0.7], radius: 0.6, extinction: 4.0 };
        let hair = |i: i16| {
            let y = f32::from(i) * 0.02;
            Strand { start: [-0.4, y, -0.2], end: [0.4, y, -0.2], radius: 0.02, opacity: 0.9 }
        };
        let straight = scenes::directional("straight", [0.0, 0.0, -1.0], Vec::new());
        let lamp = scenes::spot([0.0, 0.0, 40.0], 6.0, straight.clone());
        for (mut scene, opaque) in [(straight.clone(), "raster"), (straight, "compute"), (lamp, "raster")] {
            scene.meshes.push(scenes::level(0.0, half, [0.0; 2]));
            for (particles, strands) in [(vec![ball], vec![]), (vec![behind, ball], (-20..20).map(hair).collect())] {
                let is_alone = particles.len() == 1;
                (scene.particles, scene.strands) = (particles, strands);
                let text = format!("half-angle:size=256,storage=r16f,opaque={opaque}");
                let world = World::new(context, &scene).expect("room for the scene");
                let mut opened = crate::support::opened(open(context, &world, &spec(&text)), &text);
                opened.build(&world).expect("built");
                let mut random = Random::new(35);
                // Points on the wall and beside it. Beside it, some are taken on a circle where the ray crosses the whole ball, but only if
                // the ball is alone.
                let mut on = Vec::new();
                for _ in 0..400 {
                    let [x, y, _] = random.point(-0.5, 0.5);
                    let (out, far) = (x.abs().max(y.abs()) - half, (x * x + y * y).sqrt());
                    if out.abs() > 0.03 && far < 0.7 {
                        on.push([x, y, if out < 0.0 { 0.01 } else { -0.9 }]);
                    }
                }
                for i in 0..60 {
                    let angle = i as f32 * 0.1;
                    let [x, y] = [0.6 * angle.cos(), 0.6 * angle.sin()];
                    if is_alone && x.abs().max(y.abs()) > half + 0.05 {
                        on.push([x, y, -0.9]);
                    }
                }
                let answers = ask(context, opened.technique.as_ref(), 0, &on);
                let mut beside = 0;
                for ([x, y, z], answer) in on.iter().zip(answers) {
                    let chord = (radius * radius - x * x - y * y).sqrt();
                    let whole = *z < 0.0;
                    let expected = (-extinction * chord * if whole { 2.0 } else { 1.0 }).exp();
                    // The lamp's rays are tilted by a twentieth at most.
                    assert!((answer - expected).abs() < 0.02, "{text}, {x}, {y}: {answer}, not {expected}");
                    beside += usize::from(whole);
                }
                assert_eq!(beside > 0, is_alone);
                let below: Vec<_> =
                    (0..50).map(|_| random.point(-0.4, 0.4)).map(|[x, y, z]| [x, y, -0.05 - z.abs()]).collect();
                let answers = ask(context, opened.technique.as_ref(), 0, &below);
                assert!(answers.iter().all(|answer| *answer == 0.0), "{text}: there is light below the wall");
            }
        }
    });
}

/// The light on surfaces equals its twin's, texel by texel, with walls oblique to the light among casters.
#[test]
fn the_light_on_walls_equals_its_twin() {
    gpu_test("the_light_on_walls_equals_its_twin", |context| {
        let mut scene = scenes::directional("walls", [0.3, 0.2, -0.9], scenes::random().particles);
        scene.strands = scenes::locks().strands;
        scene.meshes = vec![scenes::cuboid([-0.5, -0.6, -0.4], [0.3, 0.2, 0.1]), scenes::level(-0.9, 0.7, [0.2, 0.3])];
        let text = "half-angle:size=48,storage=r16f,opaque=compute";
        let world = World::new(context, &scene).expect("room for the scene");
        let mut opened = crate::support::opened(open(context, &world, &spec(text)), text);
        opened.build(&world).expect("built");
        let map = opened.technique.inspect().maps()[0];
        let corner = |mesh: &Mesh, i: u32| mesh.positions[i as usize];
        let triangles: Vec<_> =
            scene.meshes.iter().flat_map(|m| m.triangles.iter().map(|t| t.map(|i| corner(m, i)))).collect();
        let depths = opaque::draw(&map.opaque, &triangles);
        let (casters, view) = (scene.casters(), &map.caster_view);
        let (mut points, mut expected, mut cut) = (Vec::new(), Vec::new(), 0);
        for i in 0..48 * 48 {
            let texel = [i % 48, i / 48];
            let end = half_angle::mesh_depth(view, &map.opaque, &depths, texel);
            let at = view.ray(DVec2::new(f64::from(texel[0]) + 0.5, f64::from(texel[1]) + 0.5));
            // The point is in front of the wall by the most that the wall's depth may differ in neighbouring texels; without a wall, it is
            // behind all casters.
            let z = f64::from(view.near) + f64::from(end.min(1.0)) * f64::from(view.far - view.near);
            points.push(at.at(if end.is_finite() { z - 0.05 } else { z + 0.05 }).as_vec3().to_array());
            expected.push(half_angle::light(view, texel, end, &casters));
            cut += usize::from(half_angle::light(view, texel, f32::INFINITY, &casters) < 0.9 * expected[i as usize]);
        }
        let answers = ask(context, opened.technique.as_ref(), 0, &points);
        let lit = answers.iter().zip(&expected).filter(|(answer, _)| **answer > 0.0);
        let wrong = lit.clone().filter(|(answer, expected)| (*answer - *expected).abs() > 4e-3).count();
        println!("{} lit, {wrong} off, {cut} cut", lit.clone().count());
        assert!(lit.count() > 1900 && cut > 100 && wrong < 20, "{wrong} are off");
    });
}

/// Unsupported look-ups are refused by name.
#[test]
fn what_it_cannot_answer_is_refused() {
    gpu_test("what_it_cannot_answer_is_refused", |context| {
        let mut scene = scenes::random();
        let world = World::new(context, &scene).expect("room for the scene");
        let opened = crate::support::opened(open(context, &world, &spec("half-angle:size=16")), "half-angle");
        let error = answers_in_space(opened.technique.as_ref()).expect_err("it paints").to_string();
        assert!(error.contains("paints the picture") && error.lines().count() == 1, "{error}");
        scene.lights.push(scene.lights[0]);
        let world = World::new(context, &scene).expect("room for the scene");
        let error = open(context, &world, &spec("half-angle")).map(|_| ()).expect_err("two lights").to_string();
        assert!(error.contains("one light"), "{error}");
    });
}

/// Both painters make the same picture of a crowd amid meshes, with more casters per tile than the initial lists have room for, from in
/// front of the smoke, from behind it and across the light.
#[test]
fn crowds_among_meshes_are_painted_alike() {
    if crate::support::is_costly("crowds_among_meshes_are_painted_alike") {
        return;
    }
    gpu_test("crowds_among_meshes_are_painted_alike", |context| {
        let sphere = |i: u16| Particle { position: [0.0, 0.0, 0.01 * f32::from(i)], radius: 3.0, extinction: 0.01 };
        let mut scene = scenes::directional("crowd", [0.1, 0.2, -1.0], (0..200).map(sphere).collect());
        scene.strands = scenes::strands().strands;
        scene.meshes = vec![scenes::cuboid([-0.5, -0.6, -0.4], [0.3, 0.2, 0.1]), scenes::level(-0.9, 0.7, [0.2, 0.3])];
        for camera in cameras() {
            let scene = Scene { camera, ..scene.clone() };
            let [raster, compute] = PAINTERS.map(|p| painted(context, &scene, "half-angle:size=32,storage=r16f", p).0);
            let pixels = raster.pixels.iter().flatten().zip(compute.pixels.iter().flatten());
            let mut apart: Vec<f32> = pixels.map(|(a, b)| (a - b).abs()).collect();
            apart.sort_by(f32::total_cmp);
            // Pixels whose centre lies on a triangle's edge differ; with half-float blending of 200 layers, rounding dominates.
            let (most, edge) = (apart[apart.len() - 1 - 3 * 8], apart[apart.len() - 1]);
            println!("from {:?}: {most} apart, {edge} with edges", scene.camera.position);
            assert!(most < if context.features().float32_blend { 1e-3 } else { 5e-2 }, "{most} apart");
        }
    });
}

/// Technique and picture are recorded into the very first frame, before any read-back: slicing must still use this frame's light.
#[test]
fn the_first_frame_is_sliced_by_its_light() {
    gpu_test("the_first_frame_is_sliced_by_its_light", |context| {
        let smoke = scenes::directional("smoke", [0.1, 0.2, -1.0], scenes::random().particles);
        for (scene, camera) in [(&smoke, 0), (&smoke, 1), (&scenes::spot([0.3, 0.2, 6.0], 80.0, smoke.clone()), 1)] {
            let scene = Scene { camera: cameras()[camera], ..scene.clone() };
            for painter in PAINTERS {
                let world = World::new(context, &scene).expect("room for the scene");
                let text = "half-angle:size=32,storage=r16f";
                let mut opened = crate::support::opened(open(context, &world, &spec(text)), text);
                let view = View::camera(&scene.camera, &scene, PIXELS);
                let mut renderer = Renderer::new(context, &world, &view).expect("room for the picture");
                renderer.paint_by(Some(painter));
                let kernels = renderer.kernels_of(opened.technique.as_ref(), Shading::Forward, Lighting::Fragment);
                let kernels = kernels.expect("kernels");
                let frame = ran(context, |commands| {
                    opened.technique.record(commands, &world).expect("recorded");
                    renderer.record(commands, &kernels).expect("recorded");
                });
                assert!(renderer.settle(&kernels, frame).expect("settled"), "there is room");
                let first = renderer.read().expect("read");
                let (later, ..) = painted(context, &scene, text, painter);
                let apart = largest(&first, &later);
                assert!(apart < 2e-3, "camera {camera}, {}: {apart} apart", painter.word());
            }
        }
    });
}
