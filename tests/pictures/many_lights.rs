//! Many lights in tiles: tiles, bits, sources and the blur against their twins; the bare picture against the deferred one; queued look-ups
//! against immediate ones; and the effect of dither, blur and history on a picture.

mod frames;
mod queue;
mod twins;

use crate::lamps;
use crate::support::{gpu_test, opened, some, those_that_run};
use gobo::Error;
use gobo::gpu::Context;
use gobo::scene::{Picture, SKY, Scene, View};
use gobo::shading::many_lights::TileReadback;
use gobo::shading::{Lighting, Renderer, Shading, Tiled};
use gobo::technique::Opened;
use gobo::world::World;

/// A world with a technique built for it.
pub struct Built {
    pub world: World,
    pub technique: Opened,
}

pub fn build(context: &Context, scene: &Scene, text: &str) -> Built {
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = opened(gobo::technique::open(context, &world, &crate::support::spec(text)), text);
    technique.build(&world).expect(text);
    Built { world, technique }
}

pub fn camera(scene: &Scene, size: [u32; 2]) -> View {
    View::camera(&scene.camera, scene, size)
}

/// Returns the picture of a static world, drawn until history no longer changes it.
pub fn picture(context: &Context, built: &Built, size: [u32; 2], shading: Shading) -> Picture {
    let renderer = Renderer::new(context, &built.world, &camera(built.world.scene().expect("of a scene"), size))
        .expect("a renderer");
    renderer.picture(&built.technique.technique.answer(), shading, Lighting::Fragment).expect("drawn")
}

/// Returns what one frame leaves on the device, drawn from scratch.
pub fn seen(context: &Context, built: &Built, size: [u32; 2], tiled: Tiled) -> TileReadback {
    let renderer = Renderer::new(context, &built.world, &camera(built.world.scene().expect("of a scene"), size))
        .expect("a renderer");
    let answer = built.technique.technique.answer();
    let kernels = renderer.kernels(&answer, Shading::Tiled(tiled), Lighting::Fragment).expect("kernels");
    renderer.draw(&kernels).expect("drawn");
    renderer.read_tiles().expect("read").expect("tiles")
}

pub fn largest_difference(a: &Picture, b: &Picture) -> f32 {
    a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Returns the error bound for rounding of a color, stored in f32, or in half floats on a device that cannot blend f32.
pub fn rounding(context: &Context, picture: &Picture) -> f32 {
    let brightest = picture.pixels.iter().flatten().fold(1.0f32, |most, c| most.max(*c));
    brightest * if context.features().float32_blend { 1e-5 } else { 2e-3 }
}

/// With binary visibility, one bit per light loses nothing, for every such technique, scene and size.
#[test]
fn bare_tiles_are_the_deferred_picture() {
    let name = "bare_tiles_are_the_deferred_picture";
    gpu_test(name, |context| {
        let techniques = ["voxel-grid:size=64", "shadow-map:size=256", "voxelized:size=256", "ray-query"];
        let techniques = some(those_that_run(name, context, techniques), 1);
        for (scene, size) in some(lamps::all(), 3) {
            for text in &techniques {
                let built = build(context, &scene, text);
                let deferred = picture(context, &built, size, Shading::Deferred);
                let tiled = picture(context, &built, size, Shading::Tiled(Tiled::BARE));
                let difference = largest_difference(&deferred, &tiled);
                let allowed = rounding(context, &deferred);
                println!("{text}, {}, {size:?}: {difference:.1e}", scene.name);
                assert!(difference <= allowed, "{text}, {}, {size:?}: {difference}", scene.name);
            }
        }
    });
}

/// The pictures of the previous test are not trivial: they contain lit and shadowed surfaces and sky.
#[test]
fn lamps_light_and_shadow() {
    gpu_test("lamps_light_and_shadow", |context| {
        let scene = lamps::lamps(40);
        let built = build(context, &scene, "voxel-grid:size=64");
        let shadowed = picture(context, &built, [96, 54], Shading::Tiled(Tiled::BARE));
        let mut bare = scene.clone();
        bare.meshes.truncate(1);
        let open = picture(context, &build(context, &bare, "voxel-grid:size=64"), [96, 54], Shading::Deferred);
        let is_sky = |p: &[f32; 3]| (0..3).all(|i| (p[i] - SKY[i]).abs() < 1e-3);
        assert!(shadowed.pixels.iter().filter(|p| is_sky(p)).count() > 100);
        let darker = shadowed.pixels.iter().zip(&open.pixels).filter(|(a, b)| a[1] < 0.7 * b[1]).count();
        assert!(darker > 100, "{darker} pixels are darker than without houses");
    });
}

/// Soft visibility does not fit in a bit, but the mean of its dithered bits matches: exactly over even smoke, nearly elsewhere. Without
/// dithering it does not.
#[test]
fn dithered_bits_have_the_mean_of_soft_answers() {
    gpu_test("dithered_bits_have_the_mean_of_soft_answers", |context| {
        let scene = lamps::smoke();
        let built = build(context, &scene, "beer-shadow-map:size=64");
        let size = [96, 54];
        let deferred = picture(context, &built, size, Shading::Deferred);
        let far = |tiled: Tiled| {
            let drawn = picture(context, &built, size, Shading::Tiled(tiled));
            let off: f32 = deferred.pixels.iter().zip(&drawn.pixels).map(|(a, b)| (a[0] - b[0]).abs()).sum();
            off / drawn.pixels.len() as f32
        };
        let dithered = far(Tiled::default());
        let none = far(Tiled { dither: gobo::shading::DitherKind::None, ..Tiled::default() });
        println!("mean |difference|: dithered {dithered:.4}, not {none:.4}");
        assert!(dithered < 0.012 && none > 2.0 * dithered, "dithered {dithered}, not {none}");
    });
}

/// Too many lights, too many pixels for a buffer, and another picture size are refused by name, before anything is drawn.
#[test]
fn what_has_no_room_is_refused() {
    gpu_test("what_has_no_room_is_refused", |context| {
        let tiled = Shading::Tiled(Tiled::default());
        let kernels = |scene: &Scene, size: [u32; 2], shading: Shading| {
            let built = build(context, scene, "voxel-grid:size=64");
            let renderer = Renderer::new(context, &built.world, &camera(scene, size)).expect("a renderer");
            renderer.kernels(&built.technique.technique.answer(), shading, Lighting::Fragment).map(|_| ())
        };
        let error = kernels(&lamps::lamps(1025), [32, 32], tiled).expect_err("one too many");
        assert!(matches!(&error, Error::Input { .. }) && error.to_string().contains("1025 lights"), "{error}");
        kernels(&lamps::lamps(1024), [32, 32], tiled).expect("as many as there is room for");
        let limit = context.features().max_storage_buffer_range;
        if limit < 4 * 32 * 1100 * 1000 {
            let error = kernels(&lamps::lamps(1024), [1100, 1000], tiled).expect_err("too large");
            assert!(error.to_string().contains("maxStorageBufferRange"), "{error}");
        }
        let built = build(context, &lamps::lamps(2), "voxel-grid:size=64");
        let scene = built.world.scene().expect("of a scene");
        let mut renderer = Renderer::new(context, &built.world, &camera(scene, [32, 32])).expect("a renderer");
        let error = renderer.look(&built.world, &camera(scene, [32, 33])).expect_err("another size");
        assert!(error.to_string().contains("[32, 33]"), "{error}");
    });
}
