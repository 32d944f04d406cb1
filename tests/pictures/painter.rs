//! Pictures painted by compute passes: against the rasterizer's, their lists against a twin and the truth, and with lists that are too
//! short.

use crate::support::{all, built, gpu_test, ran, scenes, skipped, some, spec, those_that_run};
use glam::{DVec2, DVec3};
use gobo::gpu::Context;
use gobo::reference::truth::{Casters, picture};
use gobo::reference::twin::painter::{lists, parts};
use gobo::scene::{AlphaMode, Camera, Fog, Light, LightKind, Particle, Picture, Scene, Show, Splat, View};
use gobo::shading::{Lighting, PainterKind, Pictures, Renderer, Shading, Tiled};
use gobo::technique::{Entry, REGISTRY, Technique, open};
use gobo::world::World;
use gobo::{Error, Result};

const SIZE: [u32; 2] = [75, 52];
const PAINTERS: [PainterKind; 2] = [PainterKind::Raster, PainterKind::Compute];

fn camera(scene: &Scene) -> View {
    View::camera(&scene.camera, scene, SIZE)
}

/// Returns a renderer of a world for each painter.
fn renderers(context: &Context, world: &World, camera: &View) -> [Renderer; 2] {
    PAINTERS.map(|painter| {
        let mut renderer = Renderer::new(context, world, camera).expect("a renderer");
        renderer.paint_by(Some(painter));
        renderer
    })
}

/// Returns a scene's picture by each painter.
fn both(context: &Context, scene: &Scene, technique: &dyn Technique, shading: Shading) -> [Picture; 2] {
    let world = World::new(context, scene).expect("room");
    let draw = |r: Renderer| r.picture_of(technique, shading, Lighting::Fragment).expect("drawn");
    renderers(context, &world, &camera(scene)).map(draw)
}

/// Compares two pictures: the mean difference is only rounding, and so is each pixel's, except for `left_out` pixels. Those may have a
/// triangle's edge through their centre, which one rasterizer includes and the other does not.
fn alike(context: &Context, [a, b]: &[Picture; 2], left_out: usize, what: &str) {
    // Error bounds: f32 rounding over many layers, or half-float rounding if the device cannot blend f32. At a sphere's edge opacity rises
    // as a square root, which magnifies rounding.
    let [mean, most] = if context.features().float32_blend { [1e-5, 5e-4] } else { [2e-3, 2e-2] };
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max);
    let mut all: Vec<f32> = a.pixels.iter().zip(&b.pixels).map(pixel).collect();
    assert!(all.iter().all(|d| d.is_finite()), "{what}");
    all.sort_by(f32::total_cmp);
    let all = &all[..all.len() - left_out];
    let (worst, sum) = (all[all.len() - 1], all.iter().sum::<f32>() / all.len() as f32);
    assert!(worst <= most && sum <= mean, "{what}: {worst} at most, {sum} on average");
}

/// Smoke, hair and splats among meshes, under a light of each kind.
fn mixed() -> Scene {
    let mut scene = scenes::opaque();
    scene.particles.extend(scenes::random().particles);
    scene.splats = scenes::splats().splats;
    scene.strands = scenes::strands().strands;
    let at = DVec3::new(1.5, -1.0, 3.0);
    let far = f64::INFINITY;
    scene.lights.push(Light { kind: LightKind::Point { position: at }, radiance: [0.4, 0.2, 0.1], radius: far });
    scene.name = "mixed".into();
    scene
}

/// A view from inside the smoke.
fn within() -> Scene {
    let mut scene = scenes::random();
    scene.camera = Camera { position: DVec3::new(0.05, 0.0, 0.1), ..scene.camera };
    scene.name = "within".into();
    scene
}

/// Returns a technique's default spec, with small maps or grids if it has a size.
fn small(entry: &&Entry) -> String {
    let has_size = entry.keys.iter().any(|key| key.name == "size");
    if has_size { format!("{}:size=64", entry.name) } else { entry.name.into() }
}

/// Returns whether compute passes may have too few buffers for a technique.
fn has_few_buffers(context: &Context) -> bool {
    context.features().max_per_stage_descriptor_storage_buffers < 24
}

/// Calls `check` with a world's picture by each painter and shading, and with their names.
fn drawn(
    test: &str,
    context: &Context,
    world: &World,
    view: &View,
    technique: &dyn Technique,
    mut check: impl FnMut(&Picture, &str),
) {
    for (painter, renderer) in PAINTERS.into_iter().zip(renderers(context, world, view)) {
        if painter == PainterKind::Compute && has_few_buffers(context) {
            skipped(test, "PainterKind::Compute needs more storage buffers than this device has");
            continue;
        }
        for shading in [Shading::Forward, Shading::Deferred] {
            let shown = renderer.picture_of(technique, shading, Lighting::Fragment).expect("drawn");
            check(&shown, &format!("{painter:?}, {shading:?}"));
        }
    }
}

/// Cards that light passes through, by textures and by factors, amid smoke.
fn glass() -> Scene {
    let mut scene = scenes::cards(3);
    for mesh in &mut scene.meshes {
        if let Some(alpha) = &mut mesh.alpha {
            alpha.mode = AlphaMode::SeeThrough;
        }
    }
    scene.particles = scenes::random().particles;
    scene.particles.truncate(40);
    scene.name = "glass".into();
    scene
}

/// The camera sees see-through meshes, before and behind smoke, in the pictures of both painters as in the truth.
#[test]
fn the_camera_sees_glass() {
    const TEST: &str = "the_camera_sees_glass";
    gpu_test(TEST, |context| {
        let scene = glass();
        let view = camera(&scene);
        let truth = picture(&Casters::new(&scene), &scene, &view);
        let technique = built(context, &scene, "grid-query");
        let world = World::new(context, &scene).expect("room");
        let apart = |other: &Picture| {
            let far = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.02);
            other.pixels.iter().zip(&truth.pixels).filter(|pair| far(*pair)).count()
        };
        drawn(TEST, context, &world, &view, technique.as_ref(), |shown, what| {
            let found = apart(shown);
            println!("{what}: {found} of {} pixels differ", truth.pixels.len());
            assert!(found <= 40, "{what}: {found} of {}", truth.pixels.len());
        });
        let mut clear = scene.clone();
        clear.meshes.retain(|mesh| !mesh.is_see_through());
        let clear = picture(&Casters::new(&clear), &clear, &view);
        assert!(apart(&clear) > 500, "glass looks like none: {} pixels differ", apart(&clear));
    });
}

/// The camera sees through holes, in the pictures of both painters as in the truth, with any shading.
#[test]
fn the_camera_sees_through_holes() {
    const TEST: &str = "the_camera_sees_through_holes";
    gpu_test(TEST, |context| {
        let mut scene = scenes::cards(3);
        scene.meshes.retain(|mesh| !mesh.is_see_through());
        let view = camera(&scene);
        let truth = picture(&Casters::new(&scene), &scene, &view);
        let technique = built(context, &scene, "grid-query");
        // A pixel whose ray passes an edge or a cut within rounding may show the other side.
        let apart = |other: &Picture| {
            let far = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.02);
            other.pixels.iter().zip(&truth.pixels).filter(|pair| far(*pair)).count()
        };
        let world = World::new(context, &scene).expect("room");
        drawn(TEST, context, &world, &view, technique.as_ref(), |shown, what| {
            let found = apart(shown);
            println!("{what}: {found} of {} pixels differ", truth.pixels.len());
            assert!(found <= 30, "{what}: {found} of {}", truth.pixels.len());
        });
        let renderer = Renderer::new(context, &world, &view).expect("a renderer");
        let refused = renderer.steps(&technique.answer()).expect_err("steps of whole cards");
        assert!(matches!(refused, Error::Refused(_)), "{refused}");
        let mut whole = scene.clone();
        whole.meshes.iter_mut().for_each(|mesh| mesh.alpha = None);
        let whole = picture(&Casters::new(&whole), &whole, &view);
        assert!(apart(&whole) > 150, "cards that are whole look the same: {} pixels differ", apart(&whole));
    });
}

/// Both painters make the same picture for every technique, in smoke alone and amid casters of all kinds, from outside and from inside.
#[test]
fn both_painters_make_one_picture() {
    const TEST: &str = "both_painters_make_one_picture";
    if crate::support::is_costly(TEST) {
        return;
    }
    gpu_test(TEST, |context| {
        let (mut count, specs) = (0, REGISTRY.iter().filter(|entry| entry.name != "half-angle").map(small));
        let specs: Vec<String> = specs.collect();
        for scene in [mixed(), scenes::nested(), within(), glass()] {
            let world = World::new(context, &scene).expect("room");
            for text in those_that_run(TEST, context, some(specs.iter().map(String::as_str), 4)) {
                let mut technique = match open(context, &world, &spec(text)) {
                    // Supports one light at most, or does not see smoke.
                    Err(Error::Refused(_)) => continue,
                    opened => opened.expect(text),
                };
                technique.build(&world).expect(text);
                let [_, renderer] = renderers(context, &world, &camera(&scene));
                let kernels = renderer.kernels_of(technique.technique.as_ref(), Shading::Forward, Lighting::Fragment);
                if let (true, Err(Error::Refused(needs))) = (has_few_buffers(context), kernels) {
                    skipped(TEST, &format!("{text}: needs {needs}"));
                    continue;
                }
                let pictures = both(context, &scene, technique.technique.as_ref(), Shading::Forward);
                let edges = if scene.meshes.is_empty() { 0 } else { 8 };
                alike(context, &pictures, edges, &format!("{text} in {}", scene.name));
                count += 1;
            }
        }
        assert!(count >= 8, "{count} pictures");
    });
}

/// Both painters agree on meshes in each shading, colored smoke, volumes among casters, and fog over the picture.
#[test]
fn both_painters_shade_alike() {
    if crate::support::is_costly("both_painters_shade_alike") {
        return;
    }
    gpu_test("both_painters_shade_alike", |context| {
        let scene = mixed();
        let technique = built(context, &scene, "layers:size=64");
        for shading in [Shading::Deferred, Shading::Tiled(Tiled::BARE), Shading::Interleaved] {
            let pictures = both(context, &scene, technique.as_ref(), shading);
            // A pixel that sees a different surface averages light over different neighbours.
            alike(context, &pictures, if shading == Shading::Interleaved { 80 } else { 8 }, &format!("{shading:?}"));
        }
        let mut inks = mixed();
        inks.extinction_ratio = [1.0, 0.5, 2.0];
        let technique = built(context, &inks, "layers:size=64");
        alike(context, &both(context, &inks, technique.as_ref(), Shading::Forward), 8, "colors");
        let world = World::new(context, &scene).expect("room");
        let technique = built(context, &scene, "avsm:size=64");
        let foggy = renderers(context, &world, &camera(&scene)).map(|renderer| {
            renderer.picture(&technique.answer(), Shading::Forward, Lighting::Fragment).expect("drawn");
            renderer.fog(&technique.answer(), &Fog::new(0.05, 16).expect("fog")).expect("fog");
            renderer.read().expect("read")
        });
        alike(context, &foggy, 8, "fog");
    });
}

/// Both painters agree on pictures for display: sky, smooth normals, several samples.
#[test]
fn both_painters_show_alike() {
    gpu_test("both_painters_show_alike", |context| {
        let scene = mixed();
        let world = World::new(context, &scene).expect("room");
        let technique = built(context, &scene, "avsm:size=64");
        let pictures = PAINTERS.map(|painter| {
            let show = Show::new(4, 0.0).expect("samples");
            let mut pictures = Pictures::new(context, &world, &scene, SIZE, Some(show)).expect("pictures");
            pictures.renderer.paint_by(Some(painter));
            pictures.renderer.picture_of(technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("drawn");
            pictures.read().expect("read")
        });
        alike(context, &pictures, 16, "shown");
    });
}

/// Returns a picture painted by compute, with lists cut into parts of at least `least` casters, and its renderer.
fn cut(context: &Context, scene: &Scene, technique: &dyn Technique, least: u32) -> (Renderer, Picture) {
    let world = World::new(context, scene).expect("room");
    let [_, mut renderer] = renderers(context, &world, &camera(scene));
    renderer.cut_lists(least);
    let picture = renderer.picture_of(technique, Shading::Forward, Lighting::Fragment).expect("drawn");
    (renderer, picture)
}

/// Lists and parts equal their twin. A pixel's parts composited over each other give the pixel, however long the parts are.
#[test]
fn parts_make_the_whole() {
    gpu_test("parts_make_the_whole", |context| {
        for scene in [mixed(), scenes::random(), scenes::strands(), scenes::splats(), within()] {
            let technique = built(context, &scene, "avsm:size=64");
            let whole = cut(context, &scene, technique.as_ref(), 1 << 20);
            for least in [1, 3, 16] {
                let (renderer, picture) = cut(context, &scene, technique.as_ref(), least);
                let (seen, order) = renderer.read_lists().expect("read").expect("lists");
                let twin = lists(SIZE, &seen.boxes, &order);
                assert!(seen.lists == twin, "{}: lists", scene.name);
                let all = twin.iter().map(Vec::len).sum::<usize>() as u32;
                assert_eq!((seen.totals.entries, seen.totals.wanted), (all, all));
                for (tile, list) in (0..).zip(&twin) {
                    let mut numbers: Vec<_> = seen.parts.iter().filter(|p| p.tile == tile).map(|p| p.number).collect();
                    numbers.sort_unstable();
                    let count = parts(list.len() as u32, all, [least, 8192]);
                    assert!(numbers.into_iter().eq(0..count), "{}: parts of tile {tile}", scene.name);
                }
                alike(context, &[whole.1.clone(), picture], 0, &format!("{} in parts of {least}", scene.name));
            }
        }
    });
}

/// A sphere's box contains each pixel whose ray meets the sphere, and at most one more pixel on each side.
#[test]
fn boxes_hold_what_is_seen() {
    gpu_test("boxes_hold_what_is_seen", |context| {
        let scene = scenes::random();
        let technique = built(context, &scene, "none");
        let (renderer, _) = cut(context, &scene, technique.as_ref(), 16);
        let (seen, _) = renderer.read_lists().expect("read").expect("lists");
        let view = camera(&scene);
        for (particle, found) in scene.particles.iter().zip(&seen.boxes) {
            let centre = DVec3::from(particle.position.map(f64::from));
            let meets = |x: u32, y: u32| {
                let ray = view.ray(DVec2::new(f64::from(x), f64::from(y)) + 0.5);
                let way = ray.direction.normalize();
                let offset = centre - ray.origin;
                (offset - offset.dot(way) * way).length() < f64::from(particle.radius)
            };
            let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
            let within: Vec<_> = pixels.filter(|&(x, y)| meets(x, y)).collect();
            let [[left, top], [right, bottom]] = found.map(|word| [word & 0xFFFF, word >> 16]);
            assert!(within.iter().all(|&(x, y)| (left..=right).contains(&x) && (top..=bottom).contains(&y)));
            let Some(low) = within.iter().map(|p| p.0).min() else { continue };
            let high = within.iter().map(|p| p.0).max().unwrap_or(low);
            assert!(low - left <= 1 && right - high <= 1, "{low} to {high}, and the box is {left} to {right}");
        }
    });
}

/// A scene with so many large spheres that the initial lists are too short.
fn crowded() -> Scene {
    let sphere = |i: u16| Particle { position: [0.0, 0.0, 0.01 * f32::from(i)], radius: 3.0, extinction: 0.01 };
    let mut scene = scenes::directional("crowded", [0.3, 0.2, -0.9], (0..300).map(sphere).collect());
    scene.camera = Camera { position: DVec3::new(0.0, -9.0, 1.0), ..scene.camera };
    scene
}

/// If lists are too short, a picture that is waited for has all casters anyway. A recorded one reports that some are missing, and the next
/// one has them.
#[test]
fn lists_grow() {
    gpu_test("lists_grow", |context| {
        let scene = crowded();
        let technique = built(context, &scene, "none");
        let pictures = both(context, &scene, technique.as_ref(), Shading::Forward);
        // With half-float blending of 300 layers, rounding dominates.
        if context.features().float32_blend {
            alike(context, &pictures, 0, "waited for");
        }
        let world = World::new(context, &scene).expect("room");
        let [_, renderer] = renderers(context, &world, &camera(&scene));
        let kernels = renderer.kernels_of(technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("kernels");
        let record = || -> Result<bool> {
            let frame = ran(context, |commands| renderer.record(commands, &kernels).expect("recorded"));
            renderer.settle(&kernels, frame)
        };
        assert!(!record().expect("ran"), "the lists had room");
        assert!(record().expect("ran"), "the lists have not grown");
        alike(context, &[pictures[1].clone(), renderer.read().expect("read")], 0, "recorded");
    });
}

/// Lighting at vertices by both painters differs only by the diagonal that splits a grid cell of a quad, also with colors, fog, and hair
/// among splats.
#[test]
fn vertices_are_lit_alike() {
    if crate::support::is_costly("vertices_are_lit_alike") {
        return;
    }
    gpu_test("vertices_are_lit_alike", |context| {
        if !context.features().tessellation_shader || has_few_buffers(context) {
            return skipped("vertices_are_lit_alike", "needs tessellation and 24 storage buffers per stage");
        }
        let mut inks = mixed();
        inks.extinction_ratio = [1.0, 0.5, 2.0];
        for scene in [mixed(), inks, within()] {
            let world = World::new(context, &scene).expect("room");
            let technique = built(context, &scene, "layers:size=64");
            let draw = |renderer: Renderer| {
                let lightings = [Lighting::Vertex { spacing: 4.0 }, Lighting::Fragment];
                lightings.map(|l| renderer.picture(&technique.answer(), Shading::Forward, l).expect("drawn"))
            };
            let [[drawn, at_pixels], [painted, _]] = renderers(context, &world, &camera(&scene)).map(draw);
            let rms = |a: &Picture, b: &Picture| {
                let all = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
                all.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt() / (a.pixels.len() as f64).sqrt()
            };
            let (apart, from_pixels) = (rms(&drawn, &painted), rms(&drawn, &at_pixels));
            println!("{}: {apart:.1e} apart, {from_pixels:.1e} from light at pixels", scene.name);
            assert!(apart < 0.5 * from_pixels, "{}: {apart} apart, and {from_pixels} from pixels", scene.name);
        }
    });
}

/// More vertices than the initial buffer holds: a picture that is waited for has their light, and a recorded one reports that some are
/// missing.
#[test]
fn vertices_get_room() {
    gpu_test("vertices_get_room", |context| {
        let scene = crowded();
        let technique = built(context, &scene, "none");
        let world = World::new(context, &scene).expect("room");
        let lighting = Lighting::Vertex { spacing: 1.0 };
        let [[_, waited], [_, recorded]] = [(), ()].map(|()| renderers(context, &world, &camera(&scene)));
        let waited = waited.picture(&technique.answer(), Shading::Forward, lighting).expect("drawn");
        let kernels = recorded.kernels(&technique.answer(), Shading::Forward, lighting).expect("kernels");
        let record = || -> Result<bool> {
            let frame = ran(context, |commands| recorded.record(commands, &kernels).expect("recorded"));
            recorded.settle(&kernels, frame)
        };
        assert!(!record().expect("ran"), "vertices had room");
        assert!((0..8).any(|_| record().expect("ran")), "there is no room after eight frames");
        alike(context, &[waited.clone(), recorded.read().expect("read")], 0, "recorded");
        // Without shadows, light is the same at all vertices and pixels.
        let [_, pixels] = both(context, &scene, technique.as_ref(), Shading::Forward);
        alike(context, &[waited, pixels], 0, "at each pixel");
    });
}

/// Splats all over a large picture, with more entries than the lists' maximum capacity: green splats hide red ones, in however many runs
/// they are painted.
#[test]
fn more_entries_than_there_is_room_for() {
    const TEST: &str = "more_entries_than_there_is_room_for";
    if crate::support::is_costly(TEST) {
        return;
    }
    gpu_test(TEST, |context| {
        let size = [1600, 1200];
        let splat = |i: u16| Splat {
            position: [0.0, 0.01 * f32::from(i), 0.0],
            deviations: [30.0, 0.05, 30.0],
            rotation: [0.0, 0.0, 0.0, 1.0],
            opacity: 0.6,
            color: if i < 150 { [0.1, 0.8, 0.1] } else { [0.8, 0.1, 0.1] },
        };
        let painted = |count: u16| {
            let mut scene = scenes::directional("splats", [0.3, 0.2, -0.9], Vec::new());
            scene.splats = (0..count).map(splat).collect();
            scene.camera = Camera { position: DVec3::new(0.0, -9.0, 0.0), ..scene.camera };
            let world = World::new(context, &scene).expect("room");
            let mut renderer =
                Renderer::new(context, &world, &View::camera(&scene.camera, &scene, size)).expect("a renderer");
            renderer.paint_by(Some(PainterKind::Compute));
            let technique = built(context, &scene, "none");
            let kernels =
                renderer.kernels_of(technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("kernels");
            renderer.draw(&kernels).expect("painted");
            let (_, order) = renderer.read_lists().expect("read").expect("lists");
            assert_eq!(order.len(), usize::from(count));
            (renderer.read().expect("read"), renderer.lists_bytes(&kernels).expect("lists"))
        };
        // 30,000 tiles, so 290 splats have 8.7 million entries, and the capacity is 8.4 million.
        let [(few, _), (all, bytes)] = [60, 290].map(painted);
        assert!(bytes > 100 << 20, "{bytes} bytes");
        alike(context, &[few.clone(), all], 0, "in runs");
        let middle = few.pixels[600 * 1600 + 800];
        assert!(middle[1] > 2.0 * middle[0], "{middle:?} is not green");
    });
}

/// Spheres in planes across the view, many of them equally far away, give the same picture, to the bit, in whatever order they are listed.
#[test]
fn it_does_not_matter_how_casters_are_listed() {
    gpu_test("it_does_not_matter_how_casters_are_listed", |context| {
        let at = |i: u16| [i % 9, i / 9 % 9, i / 81].map(|place| 0.125 * f32::from(place) - 0.5);
        let sphere = |i: u16| Particle { position: at(i), radius: 0.25, extinction: 0.5 + f32::from(i % 7) };
        let mut scene = scenes::directional("planes", [0.3, 0.2, -0.9], (0..729).map(sphere).collect());
        let (position, target) = (4.0 * DVec3::Z, DVec3::ZERO);
        scene.camera = Camera { position, target, up: DVec3::Y, fov_y_degrees: 30.0 };
        let technique = built(context, &scene, "none");
        let listed = both(context, &scene, technique.as_ref(), Shading::Forward);
        let mut random = scenes::Random::new(3);
        for last in (1..scene.particles.len()).rev() {
            scene.particles.swap(last, random.between(0.0, last as f32) as usize);
        }
        let shuffled = both(context, &scene, technique.as_ref(), Shading::Forward);
        for (listed, shuffled) in listed.iter().zip(&shuffled) {
            assert!(listed.pixels == shuffled.pixels, "the order of a file shows in the picture");
        }
    });
}

/// A moving world, recorded frame after frame as an engine does: memory does not grow, and the last picture equals a new renderer's.
#[test]
fn frames_in_motion_take_no_more_memory() {
    gpu_test("frames_in_motion_take_no_more_memory", |context| {
        let scene = scenes::random();
        let technique = built(context, &scene, "none");
        let mut world = World::new(context, &scene).expect("room");
        let [_, mut renderer] = renderers(context, &world, &camera(&scene));
        let kernels = renderer.kernels_of(technique.as_ref(), Shading::Forward, Lighting::Fragment).expect("kernels");
        let (mut state, mut bytes) = (scene.clone(), None);
        for frame in 0..if all() { 1000u16 } else { 120 } {
            for (particle, still) in state.particles.iter_mut().zip(&scene.particles) {
                particle.position[0] = still.position[0] + 0.3 * (0.1 * f32::from(frame) + still.position[1]).sin();
            }
            world.replace(&state).expect("as many");
            renderer.look(&world, &camera(&state)).expect("the next frame");
            let ran = ran(context, |commands| renderer.record(commands, &kernels).expect("recorded"));
            let is_whole = renderer.settle(&kernels, ran).expect("settled");
            if frame >= 8 {
                let now = context.allocated_bytes();
                assert!(
                    is_whole && now == *bytes.get_or_insert(now),
                    "frame {frame}: {now} bytes, and before {bytes:?}"
                );
            }
        }
        let [fresh, _] = both(context, &state, technique.as_ref(), Shading::Forward);
        alike(context, &[fresh, renderer.read().expect("read")], 0, "after all frames");
    });
}
