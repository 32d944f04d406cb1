//! Several routes to the same bytes: geometry and vertex routes, and coverages, which never skip a covered ray.

use super::{built, cases, opened, rays, storages, world};
use crate::support::scenes::{self, Random};
use crate::support::{gpu_test_needing, some, spec};
use gobo::gpu::Requirement;
use gobo::scene::{Particle, Scene};
use gobo::technique::Technique;

#[test]
fn geometry_and_vertex_routes_give_the_same_bytes() {
    let name = "geometry_and_vertex_routes_give_the_same_bytes";
    gpu_test_needing(name, &[Requirement::GeometryLayers, Requirement::VertexLayers], |context| {
        for (scene, keys) in cases() {
            for storage in storages() {
                for more in ["assign=nearest", "assign=split,coverage=viewport"] {
                    let bytes = ["geometry", "vertex"].map(|route| {
                        let text = format!("psm:path=raster,storage={storage},{more},route={route},{keys}");
                        let psm = built(context, &scene, &text);
                        rays(&psm, &spec(&text), scene.map_count()).rays
                    });
                    assert!(bytes[0] == bytes[1], "{}: {storage}, {more}, {keys}", scene.name);
                    assert!(bytes[0].iter().flatten().any(|v| *v != bytes[0][0][0]), "{}: empty", scene.name);
                }
            }
        }
    });
}

/// Many particles far smaller than a texel, some at the very edges of the map. Rays run only through texel centres, so few meet a particle.
/// Two particles without extinction fix the view.
fn specks(seed: u64, texel: f32) -> Scene {
    let mut random = Random::new(seed);
    let mut particles: Vec<_> =
        [-1.0, 1.0].map(|at| Particle { position: [at, at, at], radius: 0.01, extinction: 0.0 }).into_iter().collect();
    for i in 0..3000 {
        let mut position = random.point(-1.0, 1.0);
        if i % 8 == 0 {
            position[i / 8 % 2] = if i % 16 == 0 { -1.0 } else { 1.0 };
        }
        particles.push(Particle { position, radius: texel * random.between(0.05, 0.6), extinction: 30.0 / texel });
    }
    // Half of the map stays empty, so that there is something to skip.
    particles.retain(|p| p.position[0] < 0.0 || p.extinction == 0.0 || p.position[1] > 0.98);
    scenes::directional("specks", [0.0, 0.0, -1.0], particles)
}

/// Skipped rays keep their cleared values, and without coverage no ray is skipped. Equal bytes prove that no ray with anything to propagate
/// was skipped.
#[test]
fn no_covered_ray_is_skipped() {
    if crate::support::is_costly("no_covered_ray_is_skipped") {
        return;
    }
    gpu_test_needing("no_covered_ray_is_skipped", &[Requirement::Layers, Requirement::Viewports], |context| {
        let mut all: Vec<(Scene, String)> = cases().into_iter().map(|(scene, keys)| (scene, keys.to_owned())).collect();
        for (seed, size) in some([(1, 60), (2, 64), (3, 41), (4, 128)], 1) {
            let scene = specks(seed, 2.0 / size as f32);
            let slanted = Scene { lights: scenes::random().lights, ..scene.clone() };
            for scene in [scenes::spot([0.4, 0.3, 3.5], 50.0, scene.clone()), slanted, scene] {
                all.push((scene, format!("size={size},slices=16")));
            }
        }
        for (scene, keys) in all {
            // Which rays are covered does not depend on the storage.
            let most = if scene.particles.len() < 1000 { 3 } else { 1 };
            for storage in storages().into_iter().take(most) {
                let [off, viewport, tiles] = ["off", "viewport", "tiles"].map(|coverage| {
                    let text = format!("psm:path=raster,storage={storage},coverage={coverage},{keys}");
                    rays(&built(context, &scene, &text), &spec(&text), scene.map_count()).rays
                });
                let covered = off.iter().filter(|ray| ray.iter().any(|v| *v != off_value(storage))).count();
                assert!(covered > 0, "{} {keys}: nothing is covered", scene.name);
                assert!(off == viewport, "{} {keys} {storage}: viewport", scene.name);
                assert!(off == tiles, "{} {keys} {storage}: tiles", scene.name);
            }
        }
    });
}

fn off_value(storage: &str) -> f32 {
    if storage == "optical-depth" { 0.0 } else { 1.0 }
}

/// Coverage does skip: its layer is marked where casters are, and nowhere far from them.
#[test]
fn coverage_marks_what_casters_touch() {
    let needs = [Requirement::Layers, Requirement::Viewports];
    gpu_test_needing("coverage_marks_what_casters_touch", &needs, |context| {
        for (size, tiles) in [(64u32, 8u32), (60, 8)] {
            let scene = specks(7, 2.0 / size as f32);
            let text = format!("psm:path=raster,coverage=viewport,size={size},slices=16");
            let world = world(context, &scene);
            let mut opened = opened(context, &world, &text);
            // This build fits the maps; the next submission omits the passes after voxelizing.
            opened.build(&world).expect(&text);
            let psm = opened.technique;
            context
                .submit(|commands| {
                    psm.clear(commands);
                    psm.voxelize(commands);
                })
                .expect(&text);
            let texels: Vec<[u8; 4]> = psm.volume.read().expect("read");
            let coverage = &texels[(4 * size * size) as usize..];
            let view = psm.inspect().maps()[0].caster_view;
            let (mut marked, mut all) = (0, 0);
            for y in 0..tiles {
                for x in 0..tiles {
                    let mark = coverage[(y * size + x) as usize] == [0; 4];
                    // Distance in texels from the tile to the nearest caster's outline, taken as a square around the caster.
                    let nearest = scene.particles.iter().map(|p| {
                        let (at, _) = view.project(glam::DVec3::from(p.position.map(f64::from)));
                        let radius = f64::from(p.radius * view.scale_x) * 0.5 * f64::from(size);
                        let low = glam::DVec2::new(f64::from(8 * x), f64::from(8 * y));
                        let apart = (low - at).max(at - low - 8.0);
                        apart.max_element() - radius
                    });
                    let nearest = nearest.fold(f64::INFINITY, f64::min);
                    // Bounds are a 16th of a texel too large.
                    assert!(mark || nearest > 0.0, "{size}: tile {x},{y} is not marked, {nearest} from a caster");
                    assert!(!mark || nearest < 0.1, "{size}: tile {x},{y} is marked, {nearest} from a caster");
                    marked += u32::from(mark);
                    all += 1;
                }
            }
            assert!(4 * marked < 3 * all && marked > 0, "{marked} of {all}");
        }
    });
}

/// Rays of tiles without casters keep whatever they held, and no others do.
#[test]
fn rays_without_casters_are_skipped() {
    gpu_test_needing("rays_without_casters_are_skipped", &[Requirement::Layers], |context| {
        let scene = specks(8, 2.0 / 64.0);
        let text = "psm:path=raster,coverage=tiles,size=64,slices=16";
        let psm = built(context, &scene, text);
        let whole = rays(&psm, &spec(text), 1).rays;
        context
            .submit(|commands| {
                commands.pass("half", |pass| pass.clear_volume(&psm.volume, 0.5));
                psm.propagate(commands);
            })
            .expect(text);
        let halves = rays(&psm, &spec(text), 1).rays;
        let half = halves[0][0].max(halves[0][1]);
        let kept = |ray: &Vec<f32>| ray.iter().all(|v| *v == half);
        let (mut skipped, mut covered) = (0, 0);
        for (whole, halves) in whole.iter().zip(&halves) {
            let met = whole.iter().any(|v| *v != 1.0);
            assert!(!met || !kept(halves), "a ray that meets a caster was not propagated");
            covered += u32::from(met);
            skipped += u32::from(kept(halves));
        }
        assert!(covered > 0 && skipped > 1000, "{covered} covered, {skipped} of 4096 skipped");
    });
}
