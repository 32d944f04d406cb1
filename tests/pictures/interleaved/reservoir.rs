//! One light per pixel: the lights drawn and kept equal the twin's, the estimate's mean is the sum over all lights, and keeping lights from
//! frame to frame makes it steadier.

use super::{AMBIENT, Built, build, camera, lamps};
use crate::support::{all, gpu_test, scenes, some};
use glam::{DVec2, DVec3};
use gobo::gpu::Context;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::SurfacePoint;
use gobo::reference::twin::interleaved::gather;
use gobo::reference::twin::many_lights::frame::Frame;
use gobo::reference::twin::packed_normal::pack_normal;
use gobo::reference::twin::reservoir::{Reservoir, ask, pixel_seed};
use gobo::scene::{Camera, Light, LightKind, SKY, Scene, Strand, View};
use gobo::shading::{Kernels, Lighting, PartReadback, Renderer, Shading};

const CLOSED: u32 = 1 << 31;

/// Margin within which rounding may decide: decisions compare sums of sixteen floats, each from a few operations.
const MARGIN: f32 = 1e-4;

fn renderer(context: &Context, built: &Built, size: [u32; 2]) -> Renderer {
    let scene = built.world.scene().expect("of a scene");
    Renderer::new(context, &built.world, &camera(scene, size)).expect("a renderer")
}

fn kernels(renderer: &Renderer, built: &Built) -> Kernels {
    let answer = built.technique.technique.answer();
    renderer.kernels(&answer, Shading::Reservoir, Lighting::Fragment).expect("kernels")
}

fn parts(renderer: &Renderer, kernels: &Kernels) -> PartReadback {
    renderer.draw(kernels).expect("drawn");
    renderer.read_parts(kernels).expect("read").expect("parts")
}

/// Returns the light that a pixel receives from an unshadowed light.
fn turned(scene: &Scene, light: u32, position: DVec3, normal: DVec3) -> DVec3 {
    let light = &scene.lights[light as usize];
    if !light.shines_on(position) {
        return DVec3::ZERO;
    }
    let cosine = light.towards(position).dot(normal).abs();
    DVec3::from(light.radiance.map(f64::from)) * light.falloff(position) * cosine
}

fn luminance(color: DVec3) -> f32 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722)) as f32
}

/// Compares reservoirs with their twin under every kind of light, under many and few, over three consecutive frames of the same view.
#[test]
fn reservoirs_equal_their_twin() {
    gpu_test("reservoirs_equal_their_twin", |context| {
        let cases = [(lamps::kinds(), [45, 27]), (lamps::lamps(3), [23, 14]), (lamps::lamps(100), [50, 29])];
        for (mut scene, size) in some(cases, 2) {
            scene.lights.iter_mut().for_each(|light| light.radius *= 2.5);
            let built = build(context, &scene, "none");
            let renderer = renderer(context, &built, size);
            let (kernels, camera) = (kernels(&renderer, &built), camera(&scene, size));
            let lights = scene.lights.len() as u32;
            let (mut before, mut compared, mut close) = (Vec::new(), 0, 0);
            for frame in 0..3 {
                let seen = parts(&renderer, &kernels);
                for (i, kept) in seen.reservoirs.iter().enumerate() {
                    let what = format!("{}, frame {frame}, pixel {i}", scene.name);
                    if seen.albedo[i][3] == 0.0 {
                        assert_eq!(
                            (kept.z, kept.frames, kept.weight, seen.estimates[i]),
                            (0.0, 0, 0.0, [0.0; 3]),
                            "{what}"
                        );
                        continue;
                    }
                    let at = DVec2::new((i as u32 % size[0]).into(), (i as u32 / size[0]).into()) + 0.5;
                    let normal = seen.normal[i];
                    assert_eq!((kept.z, kept.normal), (seen.z[i], [normal[0], normal[1], normal[2]]), "{what}");
                    assert_eq!(kept.frames & CLOSED != 0, normal[3] != 0.0, "{what}");
                    let position = camera.ray(at).at(f64::from(seen.z[i]));
                    let normal = DVec3::from(kept.normal.map(f64::from));
                    let target = |light| luminance(turned(&scene, light, position, normal));
                    let seed = pixel_seed(i as u32, frame);
                    // A closed surface facing away from a sun receives none of it.
                    let closed = kept.frames & CLOSED != 0;
                    let surface = SurfacePoint { position, normal, closed };
                    let lit = |light: u32| !surface.looks_away(&scene.lights[light as usize]);
                    let visibility = |light: u32| f32::from(u8::from(lit(light)));
                    let twin = ask(seed, lights, before.get(i).copied(), target, visibility, lit);
                    let frames = kept.frames & !CLOSED;
                    assert_eq!(frames, twin.kept.frames, "{what}");
                    if twin.margin < MARGIN {
                        close += 1;
                        continue;
                    }
                    compared += 1;
                    assert_eq!(kept.light, twin.kept.light, "{what}: {kept:?}, not {twin:?}");
                    let off = (kept.weight - twin.kept.weight).abs();
                    assert!(off <= 1e-3 * twin.kept.weight, "{what}: {kept:?}, not {twin:?}");
                    let found = turned(&scene, kept.light, position, normal) * f64::from(kept.weight);
                    let apart = (DVec3::from(seen.estimates[i].map(f64::from)) - found).abs().max_element();
                    assert!(apart <= 1e-3 * found.max_element(), "{what}: {:?}, not {found}", seen.estimates[i]);
                }
                let kept = |r: &gobo::shading::ReservoirData| Reservoir {
                    light: r.light,
                    weight: r.weight,
                    frames: r.frames & !CLOSED,
                };
                before = seen.reservoirs.iter().map(kept).collect();
            }
            println!("{}: {compared} pixels equal their twin, {close} are too close to tell", scene.name);
            assert!(compared > 300 && close * 50 < compared, "{compared}, {close}");
        }
    });
}

/// A floor under a lattice of strands, spaced more closely than pixels, and under many suns.
fn under_a_lattice() -> Scene {
    let mut scene = scenes::directional("lattice", [0.0, 0.0, -1.0], Vec::new());
    scene.meshes.push(scenes::level(0.0, 4.0, [0.0; 2]));
    let strand = |i: i16| {
        let x = 0.24 * f32::from(i);
        Strand { start: [x, -6.0, 4.0], end: [x, 6.0, 4.0], radius: 0.06, opacity: 0.9 }
    };
    scene.strands = (-25..25).map(strand).collect();
    let mut random = scenes::Random::new(3);
    let sun = |_| {
        let [x, y, radiance] = random.point(-0.3, 0.3);
        let direction = DVec3::new(x.into(), y.into(), -1.0).normalize();
        Light { kind: LightKind::Directional { direction }, radiance: [0.5 + radiance; 3], radius: f64::INFINITY }
    };
    scene.lights = (0..24).map(sun).collect();
    scene.camera =
        Camera { position: DVec3::new(0.0, -6.0, 1.5), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 40.0 };
    scene
}

/// Each pixel's look-up covers its own width: the visibility of the light it keeps equals a query of squares as wide as the pixel on the
/// floor, and not a query of points; both in the first frame and with a light kept from a previous one.
#[test]
fn pixels_ask_by_their_width() {
    if crate::support::is_costly("pixels_ask_by_their_width") {
        return;
    }
    gpu_test("pixels_ask_by_their_width", |context| {
        let (scene, size) = (under_a_lattice(), [32, 18]);
        for name in some(["layers:layers=4,", "avsm:nodes=4,", "beer-shadow-map:"], 1) {
            let text = format!("{name}path=binned,size=128,levels=6");
            let built = build(context, &scene, &text);
            let renderer = renderer(context, &built, size);
            let (kernels, camera) = (kernels(&renderer, &built), camera(&scene, size));
            for frame in 0..3 {
                let seen = parts(&renderer, &kernels);
                let mut each: Vec<[Vec<[f32; 3]>; 2]> = vec![Default::default(); scene.lights.len()];
                let (mut sides, mut found) = (vec![Vec::new(); each.len()], vec![Vec::new(); each.len()]);
                for (i, kept) in seen.reservoirs.iter().enumerate().filter(|(_, kept)| kept.weight > 0.0) {
                    let at = DVec2::new((i as u32 % size[0]).into(), (i as u32 / size[0]).into()) + 0.5;
                    let position = camera.ray(at).at(f64::from(kept.z));
                    let normal = DVec3::from(kept.normal.map(f64::from));
                    let light = kept.light as usize;
                    let facing = if scene.lights[light].towards(position).dot(normal) < 0.0 { -normal } else { normal };
                    let all = turned(&scene, kept.light, position, normal)[0] * f64::from(kept.weight);
                    each[light][0].push(position.as_vec3().to_array());
                    each[light][1].push(facing.as_vec3().to_array());
                    sides[light].push((2.0 * kept.z / (size[1] as f32 * camera.scale_y)).abs());
                    found[light].push(f64::from(seen.estimates[i][0]) / all);
                }
                let asked: Vec<_> = (each.iter().enumerate())
                    .map(|(light, [points, normals])| PointBatch { light, points, normals })
                    .collect();
                let (sides, found) = (sides.concat(), found.concat());
                let off = |sides: &[f32]| {
                    let query = Query::of_areas(context, &asked, sides).expect("room");
                    let answers = query.ask(&built.technique.technique.answer()).expect("answered");
                    let apart = answers.iter().zip(&found).map(|(answer, found)| (f64::from(*answer) - found).abs());
                    apart.filter(|apart| *apart > 2e-3).count()
                };
                let (wrong, of_points) = (off(&sides), off(&vec![0.0; sides.len()]));
                let lights = each.iter().filter(|[points, _]| !points.is_empty()).count();
                println!(
                    "{text}, frame {frame}: {wrong} of {} off, {of_points} of points; {lights} lights",
                    found.len()
                );
                assert!(wrong == 0, "{text}, frame {frame}: {wrong} of {}", found.len());
                assert!(found.len() > 200 && 4 * of_points > found.len() && lights > 12, "proves nothing");
            }
        }
    });
}

/// Colors are means over pixels that see the same surface.
#[test]
fn what_is_gathered_is_a_mean() {
    gpu_test("what_is_gathered_is_a_mean", |context| {
        let (scene, size) = (lamps::lamps(17), [37, 21]);
        let built = build(context, &scene, "shadow-map:size=64");
        let renderer = renderer(context, &built, size);
        let kernels = kernels(&renderer, &built);
        let seen = parts(&renderer, &kernels);
        let gobo::shading::many_lights::FrameData { camera, corner, across, down, edge } =
            gobo::shading::many_lights::FrameData::of(&camera(&scene, size));
        let geometry = |i: usize| {
            let [x, y, z, _] = seen.normal[i];
            if seen.albedo[i][3] == 0.0 { [0; 2] } else { [seen.z[i].to_bits(), pack_normal([x, y, z])] }
        };
        let geometry: Vec<_> = (0..seen.z.len()).map(geometry).collect();
        // Gathers as with a single light, since each pixel's estimate stands for all lights.
        let frame = Frame { camera, corner, across, down, edge };
        let light = gather(&frame, &geometry, &seen.estimates, 1);
        let picture = renderer.read().expect("read");
        for (i, color) in picture.pixels.iter().enumerate() {
            let albedo = seen.albedo[i];
            let expected = if albedo[3] == 0.0 { SKY } else { super::shaded(albedo, light[i]) };
            super::assert_near(context, *color, expected, format!("pixel {i}"));
        }
        // Restarting at the first frame gives the same bytes.
        kernels.begin_at(0);
        assert!(parts(&renderer, &kernels).estimates == seen.estimates, "the same bytes");
    });
}

/// Returns the camera in frame `i` of an orbit.
fn going_round(scene: &Scene, size: [u32; 2], i: usize) -> View {
    let mut scene = scene.clone();
    let angle = 0.04 * i as f64;
    scene.camera.position =
        DVec3::new(angle.cos() * 0.5 + angle.sin() * 5.5, angle.sin() * 0.5 - angle.cos() * 5.5, 2.2);
    camera(&scene, size)
}

/// Over many runs of a few frames with an orbiting camera, the mean of each pixel's last estimate equals that pixel in a deferred picture
/// of all lights: each pixel within six standard errors, all together within four. Weights that ignored how a kept light's contribution
/// differs from place to place would be off by more.
#[test]
fn all_lights_count_on_average() {
    if crate::support::is_costly("all_lights_count_on_average") {
        return;
    }
    gpu_test("all_lights_count_on_average", |context| {
        let (size, runs, frames) = ([24, 14], if all() { 1000 } else { 250 }, 4);
        let mut scene = lamps::lamps(24);
        scene.lights.iter_mut().for_each(|light| light.radius *= 2.0);
        let built = build(context, &scene, "shadow-map:size=64");
        let answer = built.technique.technique.answer();
        let mut renderer = renderer(context, &built, size);
        let last = going_round(&scene, size, frames - 1);
        renderer.look(&built.world, &last).expect("as many pixels");
        let deferred = renderer.picture(&answer, Shading::Deferred, Lighting::Fragment).expect("drawn");
        let kernels = kernels(&renderer, &built);
        let pixels = (size[0] * size[1]) as usize;
        let (mut sums, mut squares) = (vec![[0.0f64; 3]; pixels], vec![[0.0f64; 3]; pixels]);
        let (mut wholes, mut albedo, mut aged, mut seen_at_all) = (Vec::new(), Vec::new(), 0, 0);
        for run in 0..runs {
            kernels.begin_at(1000 * run);
            for i in 0..frames {
                renderer.look(&built.world, &going_round(&scene, size, i)).expect("as many pixels");
                renderer.draw(&kernels).expect("drawn");
            }
            let seen = renderer.read_parts(&kernels).expect("read").expect("parts");
            aged += seen.reservoirs.iter().filter(|kept| kept.frames & !CLOSED == frames as u32).count();
            seen_at_all += seen.reservoirs.iter().filter(|kept| kept.z != 0.0).count();
            for (i, found) in seen.estimates.iter().enumerate() {
                for c in 0..3 {
                    sums[i][c] += f64::from(found[c]);
                    squares[i][c] += f64::from(found[c]).powi(2);
                }
            }
            wholes.push(seen.estimates.iter().flatten().map(|c| f64::from(*c)).sum::<f64>());
            albedo = seen.albedo;
        }
        let n = f64::from(runs);
        let (mut all, mut most, mut compared) = (0.0, 0.0f64, 0);
        for i in (0..pixels).filter(|i| albedo[*i][3] != 0.0) {
            for c in 0..3 {
                let truth = f64::from(deferred.pixels[i][c] / albedo[i][c] - AMBIENT[c]);
                let mean = sums[i][c] / n;
                let error = ((squares[i][c] / n - mean * mean).max(0.0) / n).sqrt();
                // Lights that are hardly ever drawn do not show in the spread of so few runs: allow a thousandth of the brightest.
                most = most.max((mean - truth).abs() / (error + 1e-3));
                all += truth;
                compared += 1;
            }
        }
        let mean = wholes.iter().sum::<f64>() / n;
        let error = (wholes.iter().map(|whole| (whole - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        println!("{compared} means, the farthest by {most:.2} errors; all {mean:.3} ± {error:.3}, not {all:.3}");
        println!("{aged} of {seen_at_all} kept all frames");
        assert!(aged * 2 > seen_at_all, "{aged} of {seen_at_all} kept all frames: proves nothing");
        assert!(error < 0.004 * all, "{error} of {all}: proves nothing");
        assert!((mean - all).abs() <= 4.0 * error && most <= 6.0, "{mean} ± {error}, not {all}; {most}");
    });
}

/// After twenty frames of a static world, each pixel's own estimate, before any averaging, is much nearer to the sum over all lights than
/// after one frame; nothing is kept from other kernels' frames.
#[test]
fn what_is_kept_makes_it_steady() {
    gpu_test("what_is_kept_makes_it_steady", |context| {
        let (scene, size) = (super::room(8), [48, 32]);
        let built = build(context, &scene, "shadow-map:size=32");
        let answer = built.technique.technique.answer();
        let renderer = renderer(context, &built, size);
        let deferred = renderer.picture(&answer, Shading::Deferred, Lighting::Fragment).expect("drawn");
        let off = |seen: &PartReadback| {
            let shown = |i: &usize| seen.albedo[*i][3] != 0.0;
            // With virtual lights nothing is ambient.
            let square = |i: usize| (seen.estimates[i][0] - deferred.pixels[i][0] / seen.albedo[i][0]).powi(2);
            let squares: Vec<f32> = (0..seen.z.len()).filter(shown).map(square).collect();
            (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
        };
        let kernels = kernels(&renderer, &built);
        let first = parts(&renderer, &kernels);
        let is_new = |kept: &gobo::shading::ReservoirData| kept.frames & !CLOSED == u32::from(kept.z != 0.0);
        assert!(first.reservoirs.iter().all(is_new), "there is no frame before");
        for _ in 2..Shading::Reservoir.frames_to_settle() {
            renderer.draw(&kernels).expect("drawn");
        }
        let (once, settled) = (off(&first), off(&parts(&renderer, &kernels)));
        println!("from all lights {once:.4} after a frame, {settled:.4} settled");
        assert!(settled < 0.5 * once, "{settled} of {once}");
    });
}
