//! Particle shadow maps: every pass against its CPU twin, routes and coverages against each other byte for byte, and the effect of each
//! storage and each assignment of casters to slices.

mod coverage;
mod look_up;

use crate::support::scenes::Random;
use crate::support::{gpu_test, gpu_test_needing, runs, scenes, some, spec};
use crate::twin;
use gobo::gpu::{Context, Requirement};
use gobo::reference::twin::bins::{TILE_TEXELS, tile_key};
use gobo::reference::twin::psm;
use gobo::reference::twin::segment::texel_segment;
use gobo::scene::{Particle, Scene, View};
use gobo::technique::psm::{Assign, Settings, Storage};
use gobo::technique::{Opened, Psm, Spec, Technique};
use gobo::world::World;
use twin::Twins;

/// The contents of a volume: the slices of each texel of each map.
struct Rays {
    size: u32,
    rays: Vec<Vec<f32>>,
}

impl Rays {
    fn at(&self, map: usize, texel: u32) -> &[f32] {
        &self.rays[map * (self.size * self.size) as usize + texel as usize]
    }
}

fn half(bits: u16) -> f32 {
    let (sign, exponent, mantissa) = (bits >> 15, i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => mantissa * (-24f32).exp2(),
        31 if mantissa == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1024.0 + mantissa) * ((exponent - 25) as f32).exp2(),
    };
    if sign == 0 { size } else { -size }
}

/// Reads the slices, without the coverage layer.
fn rays(psm: &Psm, spec: &Spec, maps: usize) -> Rays {
    let Settings { size, slices, storage, .. } = spec.settings();
    let slices = slices as usize;
    let texels: Vec<[f32; 4]> = if storage == Storage::Rgba8 {
        let bytes: Vec<[u8; 4]> = psm.volume.read().expect("read");
        bytes.into_iter().map(|t| t.map(|c| f32::from(c) / 255.0)).collect()
    } else {
        let halves: Vec<[u16; 4]> = psm.volume.read().expect("read");
        halves.into_iter().map(|t| t.map(half)).collect()
    };
    let layer = (size * size) as usize;
    let layers = texels.len() / layer / maps;
    let ray = |i: usize| {
        let (map, texel) = (i / layer, i % layer);
        (0..slices).map(|k| texels[(map * layers + k / 4) * layer + texel][k % 4]).collect()
    };
    Rays { size, rays: (0..maps * layer).map(ray).collect() }
}

fn world(context: &Context, scene: &Scene) -> World {
    World::new(context, scene).expect("room for the scene")
}

fn opened(context: &Context, world: &World, text: &str) -> Opened<Psm> {
    Opened::new(context, Box::new(crate::support::opened(Psm::new(context, world, &spec(text).settings()), text)), true)
}

fn built(context: &Context, scene: &Scene, text: &str) -> Box<Psm> {
    let world = world(context, scene);
    let mut psm = opened(context, &world, text);
    psm.build(&world).expect(text);
    psm.technique
}

fn is_additive(spec: &Spec) -> bool {
    spec.settings::<Settings>().storage == Storage::OpticalDepth
}

/// Converts stored values to the light that remains; with optical-depth the volume stores what is absorbed.
fn kept(spec: &Spec, values: &[f32]) -> Vec<f32> {
    let additive = is_additive(spec);
    values.iter().map(|v| if additive { 1.0 - v } else { *v }).collect()
}

fn slices(spec: &Spec) -> psm::Slices {
    let Settings { slices: count, assign, .. } = spec.settings();
    psm::Slices { count, split: assign == Assign::Split }
}

/// Returns the slices on both sides of each slice boundary that is so close to a caster that rounding decides which slice the caster is in.
/// A depth, in slices, has a rounding error of about 1e-7 times the number of slices.
fn ambiguous_slices(scene: &Scene, view: &View, slices: psm::Slices) -> Vec<usize> {
    if slices.split {
        return Vec::new();
    }
    let face = |c| {
        let at = psm::depth_in_slices(view, &c, slices.count);
        ((at - at.round()).abs() < 1e-4).then_some(at.round() as usize)
    };
    scene.casters().into_iter().filter_map(face).flat_map(|face| [face.saturating_sub(1), face]).collect()
}

/// Returns the quantization step of a stored number: 8 bits, or the 11 bits of a half float in [0.5, 1]. Some drivers truncate, so the
/// error may be a whole step.
fn step(spec: &Spec) -> f32 {
    if spec.settings::<Settings>().storage == Storage::Rgba8 { 1.0 / 255.0 } else { 1.0 / 2048.0 }
}

/// Largest change of a transmittance by arithmetic alone: chords of nearly grazing rays lose digits to cancellation.
const ARITHMETIC: f32 = 5e-4;

/// A short run omits rgba16f, which is stored like optical-depth and multiplied like rgba8.
fn storages() -> Vec<&'static str> {
    some(["rgba8", "optical-depth", "rgba16f"], 2)
}

/// Returns scenes with map sizes that are not whole tiles, slice counts that are not whole runs, and all kinds of casters. A short run has
/// the first four; the crowd among them has more casters than shared memory holds at a time, so they are summed in batches.
fn cases() -> Vec<(Scene, &'static str)> {
    let cases = [
        (scenes::locks(), "size=24,slices=64"),
        (scenes::nested(), "size=20,slices=132"),
        (scenes::crowd(), "size=16,slices=64"),
        (scenes::inside(), "size=16,slices=32"),
        (scenes::random(), "size=28,slices=64"),
        (scenes::random(), "size=16,slices=256"),
        (scenes::duplicates(), "size=17,slices=4"),
        (scenes::opaque(), "size=24,slices=20"),
        (scenes::spot([0.3, 0.2, 0.9], 80.0, scenes::random()), "size=20,slices=64"),
    ];
    some(cases, 4)
}

/// Calls `check` for every texel of every map that no caster grazes, and asserts that few texels are grazed.
fn each_ray(scene: &Scene, psm: &Psm, mut check: impl FnMut(usize, &View, u32, [u32; 2])) {
    let (mut seen, mut grazed) = (0, 0);
    for (map, view) in psm.inspect().maps().iter().map(|m| &m.caster_view).enumerate() {
        let twins = Twins::new(scene, *view);
        for texel in 0..view.texels() as u32 {
            seen += 1;
            if twins.grazed(texel) > 0 {
                grazed += 1;
            } else {
                check(map, view, texel, [texel % view.width, texel / view.width]);
            }
        }
    }
    assert!(grazed * 20 <= seen, "{}: {grazed} of {seen} texels are grazed", scene.name);
}

#[test]
fn voxelize_and_propagate_equal_their_twins() {
    gpu_test_needing("voxelize_and_propagate_equal_their_twins", &[Requirement::Layers], |context| {
        for (scene, keys) in cases() {
            for storage in storages() {
                for assign in ["nearest", "split"] {
                    let text = format!("psm:path=raster,storage={storage},assign={assign},{keys}");
                    let spec = spec(&text);
                    voxelize_and_propagate(context, &scene, &spec, &format!("{} {text}", scene.name));
                }
            }
        }
    });
}

fn voxelize_and_propagate(context: &Context, scene: &Scene, spec: &Spec, what: &str) {
    let psm = opened(context, &world(context, scene), &spec.to_string()).technique;
    let (maps, casters, slices) = (scene.map_count(), scene.casters(), slices(spec));
    context
        .submit(|commands| {
            psm.clear(commands);
            psm.voxelize(commands);
        })
        .expect(what);
    let local = rays(&psm, spec, maps);
    context.submit(|commands| psm.propagate(commands)).expect(what);
    let behind = rays(&psm, spec, maps);
    let additive = is_additive(spec);
    each_ray(scene, &psm, |map, view, texel, at| {
        let met: Vec<_> = casters.iter().filter(|c| texel_segment(view, at, c).is_some()).copied().collect();
        let twin = psm::voxelize(view, at, &met, slices);
        let ambiguous = ambiguous_slices(scene, view, slices);
        let mut blended = vec![0.0f32; twin.len()];
        for place in met.iter().map(|c| psm::place(view, c, slices)) {
            blended[place.slice] += 1.0;
            if place.share > 0.0 {
                blended[place.slice + 1] += 1.0;
            }
        }
        for (k, (found, depth)) in
            local.at(map, texel).iter().zip(&twin).enumerate().filter(|(k, _)| !ambiguous.contains(k))
        {
            // Each blend rounds its input and its result, by up to a step each.
            let blends = 2.0 * blended[k];
            if additive {
                // Steps are relative to the sum, and τ exp(−τ) is at most 1/e.
                let (found, expected) = ((-found).exp(), (-depth).exp());
                let tolerance = blends * 2.0 * step(spec) / std::f32::consts::E + ARITHMETIC;
                assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected}, in {map} {at:?} {k}");
            } else {
                let tolerance = if blends == 0.0 { 0.0 } else { blends * step(spec) + ARITHMETIC };
                let expected = (-depth).exp();
                assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected}, in {map} {at:?} {k}");
            }
        }
        // Propagates the values that were actually blended.
        let local = local.at(map, texel);
        let expected = if additive { psm::propagate_depths(local) } else { psm::propagate(local) };
        for (found, expected) in kept(spec, behind.at(map, texel)).iter().zip(expected) {
            let tolerance = step(spec) + 1e-5;
            assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected}, in {map} {at:?}");
        }
    });
}

#[test]
fn fused_equals_its_twin() {
    if crate::support::is_costly("fused_equals_its_twin") {
        return;
    }
    gpu_test("fused_equals_its_twin", |context| {
        for (scene, keys) in cases() {
            for storage in storages() {
                for assign in ["nearest", "split"] {
                    let text = format!("psm:path=fused,storage={storage},assign={assign},{keys}");
                    let spec = spec(&text);
                    if !runs(&format!("fused_equals_its_twin, {}", scene.name), context, &text) {
                        continue;
                    }
                    let world = world(context, &scene);
                    fused(opened(context, &world, &text), &world, &spec, &format!("{} {text}", scene.name));
                }
            }
        }
    });
}

/// If a tile has too many casters for all tiles to get equal room, parts are listed: one tile of 4,096 has 440 casters.
#[test]
fn fused_equals_its_twin_where_parts_are_listed() {
    // A quarter of a million rays, each tested against all casters.
    if crate::support::is_left_out("fused_equals_its_twin_where_parts_are_listed") {
        return;
    }
    gpu_test("fused_equals_its_twin_where_parts_are_listed", |context| {
        let mut random = Random::new(61);
        let mut heap: Vec<_> = (0..440)
            .map(|_| Particle {
                position: random.point(-0.001, 0.001).map(|x| x + 0.32),
                radius: random.between(0.002, 0.004),
                extinction: random.between(0.2, 2.0),
            })
            .collect();
        for position in [[1.0, 1.0, 1.0], [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0]] {
            heap.push(Particle { position, radius: 0.1, extinction: 3.0 });
        }
        let scene = scenes::directional("heap", [0.3, 0.2, -0.9], heap);
        let text = "psm:path=fused,storage=optical-depth,assign=nearest,size=512,slices=8";
        if runs("fused_equals_its_twin_where_parts_are_listed", context, text) {
            let world = world(context, &scene);
            let psm = opened(context, &world, text);
            fused(psm, &world, &spec(text), "heap");
            // Counts again, even though the previous build's numbers are known.
            let mut psm = opened(context, &world, text);
            psm.rebuild(&world).expect("built");
            let passes = psm.rebuild(&world).expect("built").passes;
            let counts = passes.iter().any(|pass| pass.name == "bins.count");
            assert_eq!(counts, context.features().timestamp_valid_bits > 0);
        }
    });
}

/// Tests as many threads as GPUs use. Software devices use 16, too few to share the slices of a texel in runs; on GPUs the other tests
/// cover that only by luck.
#[test]
fn fused_equals_its_twin_with_many_threads() {
    if crate::support::is_costly("fused_equals_its_twin_with_many_threads") {
        return;
    }
    gpu_test("fused_equals_its_twin_with_many_threads", |context| {
        let has = context.features().max_compute_workgroup_threads;
        for (scene, keys) in cases() {
            for (assign, threads, ahead) in [("nearest", 512, false), ("split", 384, true), ("nearest", 96, true)] {
                if threads > has {
                    println!("skipped: {threads} threads, and this device has {has}");
                    continue;
                }
                let text = format!("psm:path=fused,storage=optical-depth,assign={assign},{keys}");
                if !runs("fused_equals_its_twin_with_many_threads", context, &text) {
                    continue;
                }
                let world = world(context, &scene);
                let psm = crate::support::opened(
                    Psm::with_threads(context, &world, &spec(&text).settings(), threads, ahead),
                    &text,
                );
                let psm = Opened::new(context, Box::new(psm), true);
                fused(psm, &world, &spec(&text), &format!("{} {text}, {threads} threads", scene.name));
            }
        }
    });
}

fn fused(mut psm: Opened<Psm>, world: &World, spec: &Spec, what: &str) {
    psm.rebuild(world).expect(what);
    let scene = world.scene().expect("of a scene");
    let (maps, casters, slices) = (scene.map_count(), scene.casters(), slices(spec));
    let behind = rays(&psm.technique, spec, maps);
    psm.rebuild(world).expect(what);
    let psm = psm.technique;
    assert!(behind.rays == rays(&psm, spec, maps).rays, "{what}: the second build differs");
    each_ray(scene, &psm, |map, view, texel, at| {
        let tile = at.map(|t| t / TILE_TEXELS);
        let near: Vec<_> = casters.iter().filter(|c| tile_key(view, c, tile).is_some()).copied().collect();
        let twin = psm::fused(view, at, &casters, slices, psm::scale(&near, slices.split));
        let ambiguous = ambiguous_slices(scene, view, slices);
        let mut last = 1.0;
        for (k, (found, expected)) in kept(spec, behind.at(map, texel)).into_iter().zip(twin).enumerate() {
            assert!((0.0..=last).contains(&found), "{what}: {found} after {last}");
            last = found;
            if !ambiguous.contains(&k) {
                let tolerance = step(spec) + ARITHMETIC;
                assert!((found - expected).abs() <= tolerance, "{what}: {found}, not {expected}, in {map} {at:?} {k}");
            }
        }
        let segments = casters.iter().filter_map(|c| texel_segment(view, at, c));
        let product = (-segments.map(|s| s.optical_depth).sum::<f32>()).exp();
        assert!((last - product).abs() <= step(spec) + ARITHMETIC, "{what}: the tail is {last}, not {product}");
    });
}

/// Every mistake in a spec is reported in one line that says what would be right.
#[test]
fn bad_specs_are_refused_in_one_line() {
    gpu_test("bad_specs_are_refused_in_one_line", |context| {
        let mut lights = scenes::random();
        lights.lights = (0..40).flat_map(|_| scenes::random().lights).collect();
        let scene = scenes::random();
        let (layers, depth) = (context.features().max_framebuffer_layers, context.features().max_image_dimension_3d);
        let mut cases = vec![
            (&scene, "psm:path=fused,slices=64,coverage=tiles", "path=raster"),
            (&scene, "psm:path=fused,slices=64,route=vertex", "path=raster"),
        ];
        let draws = context.features().lacks(Requirement::Layers).is_none();
        if draws && layers.min(depth) < 40 * 64 {
            cases.push((&lights, "psm:path=raster,size=8,slices=256", "fewer"));
        }
        if depth < 40 * 64 && runs("bad_specs_are_refused_in_one_line", context, "psm:path=fused,slices=256") {
            cases.push((&lights, "psm:path=fused,size=8,slices=256", "fewer"));
        }
        for (scene, text, expected) in cases {
            let error =
                Psm::new(context, &world(context, scene), &spec(text).settings()).err().expect(text).to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{text}: {error}");
        }
    });
}
