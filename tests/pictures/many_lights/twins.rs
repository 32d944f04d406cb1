//! Tiles, bits and the blur against their twins and the truth.

use super::{Built, build, camera, lamps, picture, seen};
use crate::support::{gpu_test, scenes::Random, some};
use glam::DVec3;
use gobo::grid::{GridData, Voxelizer};
use gobo::reference::twin::grid::{Bits, Place};
use gobo::reference::twin::many_lights::cull::{Reach, TILE, cull};
use gobo::reference::twin::many_lights::frame::Frame;
use gobo::reference::twin::many_lights::shade::{Found, visibility};
use gobo::reference::twin::many_lights::{dither, reproject};
use gobo::reference::twin::packed_normal::{pack_normal, unpack_normal};
use gobo::scene::{Scene, View};
use gobo::shading::DitherKind;
use gobo::shading::{Shading, Tiled};
use gobo::shading::{many_lights::FrameData, many_lights::TileReadback, many_lights::words};
use gobo::technique::Opened;
use gobo::technique::voxel_grid::{self, VoxelGrid};
use gobo::world::{LightData, World};

pub fn frame(data: &FrameData) -> Frame {
    let FrameData { camera, corner, across, down, edge } = *data;
    Frame { camera, corner, across, down, edge }
}

fn reaches(scene: &Scene) -> Vec<Reach> {
    LightData::all(scene).iter().map(|l| Reach { position: l.position, falloff: l.falloff }).collect()
}

fn z_of(seen: &TileReadback) -> Vec<f32> {
    seen.geometry.iter().map(|g| f32::from_bits(g[0])).collect()
}

/// Returns the position that a pixel sees, in f64 from the device's f32 numbers.
fn position(camera: &View, pixel: usize, z: f32) -> DVec3 {
    let [x, y] = [pixel as u32 % camera.width, pixel as u32 / camera.width].map(|c| f64::from(c) + 0.5);
    camera.ray(glam::DVec2::new(x, y)).at(f64::from(z))
}

/// Masks equal their twin to the bit; they hold every light that reaches a pixel of the tile, but not all lights.
#[test]
fn tiles_hold_the_lights_that_reach_them() {
    gpu_test("tiles_hold_the_lights_that_reach_them", |context| {
        let mut far = lamps::lamps(40);
        // Far from the origin, where floats are coarse.
        let by = DVec3::new(4096.0, -9000.0, 800.0);
        for mesh in &mut far.meshes {
            mesh.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|i| p[i] + by[i] as f32));
        }
        for light in &mut far.lights {
            if let gobo::scene::LightKind::Point { position } = &mut light.kind {
                *position += by;
            }
        }
        (far.camera.position, far.camera.target) = (far.camera.position + by, far.camera.target + by);
        let many = [(lamps::lamps(1024), [64, 36]), (far, [96, 54])];
        let (mut kept, mut all) = (0, 0);
        for (scene, size) in some(many.into_iter().chain(lamps::all()), 4) {
            let built = build(context, &scene, "voxel-grid:size=64");
            let seen = seen(context, &built, size, Tiled::BARE);
            let camera = camera(&scene, size);
            let (z, lights) = (z_of(&seen), reaches(&scene));
            let twin = cull(&camera, &z, &lights);
            assert!(seen.masks == twin, "{}", scene.name);
            let words = words(lights.len() as u32) as usize;
            let across = size[0].div_ceil(TILE) as usize;
            for (pixel, z) in z.iter().enumerate().filter(|(_, z)| **z > 0.0) {
                let at = position(&camera, pixel, *z);
                let tile = pixel / size[0] as usize / 16 * across + pixel % size[0] as usize / 16;
                for (i, light) in scene.lights.iter().enumerate() {
                    let has = twin[tile * words + i / 32] >> (i % 32) & 1 == 1;
                    assert!(has || !light.shines_on(at), "{}: light {i} reaches pixel {pixel}", scene.name);
                    (kept, all) = (kept + usize::from(has), all + 1);
                }
            }
        }
        println!("{kept} of {all} lights and pixels are kept");
        assert!(kept * 2 < all, "culling keeps {kept} of {all}");
    });
}

/// No light that reaches a tile is lost, for random lights and ranges of z, in tiles of a camera above the ground that looks in any
/// direction.
#[test]
fn what_reaches_a_tile_is_never_lost() {
    let mut random = Random::new(77);
    for _ in 0..300 {
        let mut scene = lamps::lamps(32);
        let eye = random.point(-200.0, 200.0);
        let aim = random.point(-1.0, 1.0);
        scene.camera.position = DVec3::from(eye.map(f64::from));
        scene.camera.target = scene.camera.position + DVec3::from(aim.map(f64::from));
        let camera = camera(&scene, [48, 32]);
        let z: Vec<f32> = (0..48 * 32).map(|_| random.between(0.01, 30.0) * random.between(0.0, 1.0)).collect();
        for light in &mut scene.lights {
            // A light around a visible point, whose sphere just reaches the point or just fails to.
            let pixel = random.bits() as usize % z.len();
            let at = position(&camera, pixel, z[pixel]);
            let to = DVec3::from(random.point(-1.0, 1.0).map(f64::from));
            light.kind = gobo::scene::LightKind::Point { position: at + to };
            light.radius = to.length() * f64::from(random.between(0.9999, 1.001));
        }
        let masks = cull(&camera, &z, &reaches(&scene));
        // The lights as the device stores them, in f32.
        let lights = LightData::all(&scene);
        for (pixel, z) in z.iter().enumerate() {
            let tile = pixel / 48 / 16 * 3 + pixel % 48 / 16;
            let at = position(&camera, pixel, *z);
            for (i, light) in lights.iter().enumerate() {
                let square = (at - DVec3::from(light.position.map(f64::from))).length_squared();
                let reached = square * f64::from(light.falloff) < 1.0;
                assert!(!reached || masks[tile] >> i & 1 == 1, "{light:?} reaches {at}");
            }
        }
    }
}

/// z and normals of the picture match the meshes.
#[test]
fn pixels_see_the_meshes() {
    gpu_test("pixels_see_the_meshes", |context| {
        let scene = lamps::kinds();
        let size = [96, 54];
        let built = build(context, &scene, "voxel-grid:size=64");
        let seen = seen(context, &built, size, Tiled::BARE);
        let casters = gobo::reference::truth::Casters::new(&scene);
        let camera = camera(&scene, size);
        let mut off = 0;
        for (pixel, [z, normal]) in seen.geometry.iter().enumerate() {
            let ray = camera.ray(glam::DVec2::new((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5));
            let hit = casters.meshes.hit(ray.origin, ray.direction).filter(|hit| hit.distance < camera.far.into());
            let z = f64::from(f32::from_bits(*z));
            let agrees = match hit {
                None => z == 0.0,
                Some(hit) => {
                    let there = unpack_normal(*normal).map(|c| f64::from(c) / 511.0);
                    (z - hit.distance).abs() < 1e-3 * z && DVec3::from(there).dot(hit.normal).abs() > 0.995
                }
            };
            off += usize::from(!agrees);
        }
        // The rasterizer decides at edges.
        assert!(off < 60, "{off} of {} pixels", seen.geometry.len());
    });
}

fn grid(context: &gobo::gpu::Context, scene: &Scene, settings: voxel_grid::Plan) -> (World, Opened<VoxelGrid>) {
    let world = World::new(context, scene).expect("room for the scene");
    let technique = VoxelGrid::planned(context, &world, &settings).expect("voxel-grid");
    let mut opened = Opened::new(context, Box::new(technique), true);
    opened.build(&world).expect("built");
    (world, opened)
}

/// Even steps that start at a pixel's dither offset: each bit equals the grid twin's march from the same offset.
#[test]
fn dithered_bits_equal_their_twin() {
    gpu_test("dithered_bits_equal_their_twin", |context| {
        use gobo::shading::{Lighting, Renderer};
        let scene = lamps::lamps(40);
        let size = [64, 40];
        let settings = voxel_grid::Plan {
            size: 64,
            steps: Some(10),
            offset: 0.5,
            cone: None,
            voxelizer: Voxelizer::Compute,
            masks: false,
            bias: 0.0,
        };
        let (world, opened) = grid(context, &scene, settings);
        let GridData { origin, voxel, per_unit, size: side, .. } = opened.technique.grid().data().expect("read");
        let place = Place { origin, voxel, per_unit, size: side };
        let triangles =
            scene.meshes.iter().flat_map(|m| m.triangles.iter().map(|t| t.map(|i| m.positions[i as usize])));
        let bits = Bits::voxelize(triangles.map(|t| t.map(|corner| place.voxels(corner))), side);
        let lights = LightData::all(&scene);
        for (kind, at) in [
            (DitherKind::Ordered, dither::ordered as fn([u32; 2], u32) -> [f32; 3]),
            (DitherKind::Noise, dither::noise),
        ] {
            let renderer = Renderer::new(context, &world, &camera(&scene, size)).expect("a renderer");
            let tiled = Shading::Tiled(Tiled { dither: kind, ..Tiled::BARE });
            let answer = gobo::technique::Technique::answer(&*opened.technique);
            let kernels = renderer.kernels(&answer, tiled, Lighting::Fragment).expect("kernels");
            renderer.draw(&kernels).expect("drawn");
            let seen = renderer.read_tiles().expect("read").expect("tiles");
            let camera = camera(&scene, size);
            let (mut asked, mut off, mut shadowed) = (0, 0, 0);
            for (pixel, z) in z_of(&seen).into_iter().enumerate().filter(|(_, z)| *z > 0.0) {
                let p = position(&camera, pixel, z);
                let normal = DVec3::from(unpack_normal(seen.geometry[pixel][1]).map(f64::from)).normalize();
                let offset = at([pixel as u32 % size[0], pixel as u32 / size[0]], 2)[0];
                for (i, light) in scene.lights.iter().enumerate().filter(|(_, l)| l.shines_on(p)) {
                    let is_closed = true;
                    let towards = light.towards(p);
                    // The roof is open; all other meshes are closed.
                    let is_roof = normal.z.abs() > 0.9 && normal.z.abs() < 0.9999;
                    let facing = if (is_closed && !is_roof) || normal.dot(towards) >= 0.0 { normal } else { -normal };
                    // Surfaces that face away are not offset.
                    let reach = if facing.dot(towards) > 0.0 { facing.abs().element_sum() + 1e-3 } else { 0.0 };
                    let from = place.voxels((p + facing * reach * f64::from(voxel)).as_vec3().into());
                    let to = place.voxels(lights[i].position);
                    let way = [0, 1, 2].map(|i| to[i] - from[i]);
                    let met = bits.march_steps(from, way, 10, offset);
                    let bit = seen.shadows[i / 32 * seen.geometry.len() + pixel] >> (i % 32) & 1 == 1;
                    (asked, off, shadowed) = (asked + 1, off + usize::from(bit != met), shadowed + usize::from(bit));
                }
            }
            println!("{kind:?}: {off} of {asked} bits differ, {shadowed} are set");
            // Positions are rounded differently, and some lie on a voxel's face.
            assert!(off * 100 < asked && shadowed > 400 && asked > 1500, "{off} of {asked}, {shadowed} set");
        }
    });
}

/// With blur and with history, each light's visibility at a pixel equals the twin's sum, and the picture is shaded with it.
#[test]
fn the_blur_equals_its_twin() {
    gpu_test("the_blur_equals_its_twin", |context| {
        use gobo::shading::{Lighting, Renderer};
        let size = [72, 40];
        let mut scene = lamps::lamps(40);
        // Bright enough that no weight is lost in rounding.
        scene.lights.iter_mut().for_each(|light| light.radiance = [8.0, 4.0, 2.0]);
        scene.meshes.iter_mut().for_each(|mesh| mesh.albedo = [0.5; 3]);
        let built = build(context, &scene, "voxel-grid:size=64");
        for (blur, history, moving) in
            [(true, false, false), (true, true, false), (false, true, true), (true, true, true)]
        {
            let tiled = Tiled { blur, history, ..Tiled::default() };
            let mut renderer = Renderer::new(context, &built.world, &camera(&scene, size)).expect("a renderer");
            let answer = built.technique.technique.answer();
            let kernels = renderer.kernels(&answer, Shading::Tiled(tiled), Lighting::Fragment).expect("kernels");
            renderer.draw(&kernels).expect("drawn");
            let before = renderer.read_tiles().expect("read").expect("tiles");
            let mut other = scene.clone();
            if moving {
                other.camera.position += DVec3::new(0.25, 0.1, -0.05);
            }
            renderer.look(&built.world, &camera(&other, size)).expect("the next frame");
            renderer.draw(&kernels).expect("drawn");
            let seen = renderer.read_tiles().expect("read").expect("tiles");
            let frames = seen.frames.each_ref().map(frame);
            let found = Found {
                geometry: &seen.geometry,
                shadows: &seen.shadows,
                shadows_before: &before.shadows,
                sources: &seen.sources,
            };
            let reach = if blur { 2 } else { 0 };
            let visible: Vec<_> = (0..40).map(|light| visibility(&frames[0], &found, light, reach)).collect();
            let drawn = renderer.read().expect("read");
            let casters = gobo::reference::truth::Casters::new(&other);
            let (mut largest, mut soft) = (0.0f64, 0);
            for (pixel, [z, normal]) in seen.geometry.iter().enumerate().filter(|(_, g)| g[0] != 0) {
                let at = position(&frames[0].camera, pixel, f32::from_bits(*z));
                let ray = frames[0].camera.ray(glam::DVec2::new((pixel % 72) as f64 + 0.5, (pixel / 72) as f64 + 0.5));
                // The normal before packing.
                let Some(hit) = casters.meshes.hit(ray.origin, ray.direction) else { continue };
                let exact = hit.normal.as_vec3().to_array();
                if pack_normal(exact) != *normal && pack_normal(exact.map(|c| -c)) != *normal {
                    continue; // the rasterizer decides at edges
                }
                let mut sum = DVec3::new(0.10, 0.12, 0.15);
                for (light, visible) in scene.lights.iter().zip(&visible) {
                    let arrives = light.falloff(at) * hit.normal.dot(light.towards(at)).abs();
                    sum += DVec3::new(8.0, 4.0, 2.0) * arrives * f64::from(visible[pixel]);
                    soft += usize::from(arrives > 0.0 && visible[pixel] > 0.0 && visible[pixel] < 1.0);
                }
                let color = DVec3::from(drawn.pixels[pixel].map(f64::from));
                largest = largest.max((color - 0.5 * sum).abs().max_element() / sum.max_element());
            }
            println!("{tiled:?}, moving {moving}: largest {largest:.1e}, {soft} soft");
            assert!(largest < if context.features().float32_blend { 1e-4 } else { 4e-3 }, "{tiled:?}: {largest}");
            assert!(soft > 25, "{soft} pixels and lights are in half shadow");
            if history {
                check_sources(&seen, &before, moving);
            }
        }
    });
}

/// Asserts that sources equal the twin's, except where the rounding of a division decides between two pixels.
fn check_sources(seen: &TileReadback, before: &TileReadback, moving: bool) {
    let frames = seen.frames.each_ref().map(frame);
    let twin = reproject::reproject(&frames, &seen.geometry, &before.geometry);
    let (mut hidden, mut kept) = (0, 0);
    for (pixel, (twin, source)) in twin.iter().zip(&seen.sources).enumerate() {
        if twin.margin > 1e-3 {
            assert_eq!(twin.index.unwrap_or(u32::MAX), *source, "pixel {pixel}: {twin:?}");
        }
        let is_seen = seen.geometry[pixel][0] != 0;
        assert!(moving || !is_seen || *source == pixel as u32, "pixel {pixel} stands still");
        hidden += usize::from(is_seen && *source == u32::MAX);
        kept += usize::from(*source != u32::MAX);
    }
    assert!(kept > 1000 && (!moving || hidden > 20), "{kept} kept, {hidden} not");
}

/// In a static world, shadows end as the blur's weights say: on flat ground, half light midway across a straight edge.
#[test]
fn the_blur_keeps_the_mean() {
    gpu_test("the_blur_keeps_the_mean", |context| {
        let scene = lamps::lamps(12);
        let built: Built = build(context, &scene, "voxel-grid:size=64");
        let size = [96, 54];
        let mean = |tiled: Tiled| {
            let picture = picture(context, &built, size, Shading::Tiled(tiled));
            picture.pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / picture.pixels.len() as f64
        };
        let (sharp, blurred) = (mean(Tiled::BARE), mean(Tiled { blur: true, ..Tiled::BARE }));
        assert!((sharp - blurred).abs() < 0.01 * sharp, "{sharp} sharp, {blurred} blurred");
        assert!(sharp != blurred);
    });
}
