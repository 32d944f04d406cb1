//! `path=raster`: rasterization proposes columns, and the bytes equal those of `path=compute`.

use crate::support::{self, gpu_test, scenes, scenes::Random, spec};
use crate::voxel_grid::{PLAIN, all, built, place, triangles, twin};
use gobo::gpu::{Context, Requirement};
use gobo::grid::Voxelizer;
use gobo::reference::twin::grid::Bits;
use gobo::scene::{Mesh, Scene};
use gobo::technique::{open, voxel_grid::Plan as Settings};
use gobo::world::World;
use gobo::{Error, Need};

/// Returns the device's voxelizers besides compute: widened triangles, and conservative rasterization.
pub fn rasterizers(test: &str, context: &Context) -> Vec<Voxelizer> {
    let features = context.features();
    if let Some(missing) = features.lacks(Requirement::FragmentStores) {
        support::skipped(test, &format!("needs {missing}"));
        return Vec::new();
    }
    let mut all = vec![Voxelizer::Raster { conservative: false }];
    if features.conservative_rasterization {
        all.push(Voxelizer::Raster { conservative: true });
    } else {
        support::skipped(test, "needs VK_EXT_conservative_rasterization for one of two ways");
    }
    all
}

/// Triangles on which a rasterizer fails, in a cube of side 2: slivers in every direction, from as long as the cube to as short as a voxel,
/// motes, points, lines, sides on voxel borders and through voxel centres.
pub fn slivers() -> Scene {
    let mut random = Random::new(23);
    let mut all: Vec<[[f32; 3]; 3]> = Vec::new();
    for i in 0..240 {
        let at = random.point(-0.9, 0.9);
        let reach = [0.9, 0.2, 0.03, 0.004][i % 4];
        let thin = [0.1, 1e-2, 1e-4, 1e-7, 0.0][i % 5];
        let (along, aside) = (random.point(-reach, reach), random.point(-thin, thin));
        let share = random.between(-0.2, 1.2);
        let moved = |by: [f32; 3], share: f32| [0, 1, 2].map(|a| (at[a] + share * by[a]).clamp(-1.0, 1.0));
        let third = moved(along, share);
        all.push([at, moved(along, 1.0), [0, 1, 2].map(|a| third[a] + aside[a])]);
    }
    // The cube is 62 voxels wide: first every corner is on a voxel's border, then at a voxel's centre.
    let step = 2.0 / 62.0;
    for i in 0..120 {
        let half = if i % 2 == 0 { 0.0 } else { 0.5 };
        let mut corner = || [(); 3].map(|()| (random.between(1.0, 60.0).floor() + half) * step - 1.0);
        all.push([corner(), corner(), corner()]);
    }
    for axis in 0..3 {
        let mut to = [0.3; 3];
        to[axis] = 0.9;
        all.extend([[[0.3; 3], to, [0.3; 3]], [[0.3; 3]; 3], [[0.3; 3], to, [0.5, 0.1, -0.7]]]);
    }
    all.extend([[[-1.0; 3], [1.0; 3], [1.0; 3]], [[-1.0; 3], [1.0; 3], [0.999, 1.0, 1.0]]]);
    let mut scene = scenes::directional("slivers", [0.4, 0.35, -0.8], Vec::new());
    scene.meshes.push(Mesh {
        name: "slivers".into(),
        positions: all.concat(),
        triangles: (0..all.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        albedo: [0.5; 3],
        solid: false,
        alpha: None,
    });
    scene
}

#[test]
fn drawn_bits_are_the_computed_ones() {
    if crate::support::is_long("drawn_bits_are_the_computed_ones") {
        return;
    }
    let name = "drawn_bits_are_the_computed_ones";
    gpu_test(name, |context| {
        let ways = rasterizers(name, context);
        for scene in [slivers()].into_iter().chain(all()) {
            for size in support::some([64, 256, 512, 128], 2) {
                let (_, computed) = built(context, &scene, Settings { size, ..PLAIN });
                let bits = computed.technique.grid().bits().expect("read");
                assert!(scene.name != "slivers" || bits == twin(&scene, &place(&computed.technique)).words);
                for voxelizer in &ways {
                    let (_, drawn) = built(context, &scene, Settings { size, voxelizer: *voxelizer, ..PLAIN });
                    let drawn = drawn.technique.grid().bits().expect("read");
                    let differ = bits.iter().zip(&drawn).filter(|(a, b)| a != b).count();
                    assert_eq!(differ, 0, "{}, size {size}, {voxelizer:?}", scene.name);
                }
            }
        }
    });
}

/// Voxelizes each triangle alone: among overlapping ones, a missed triangle would go unnoticed.
#[test]
fn no_triangle_is_missed_alone() {
    let name = "no_triangle_is_missed_alone";
    gpu_test(name, |context| {
        let scene = slivers();
        for voxelizer in rasterizers(name, context) {
            let mut alone = scene.clone();
            let mesh = &scene.meshes[0];
            let frame = [[-1.0; 3], [1.0; 3], [1.0; 3]];
            alone.meshes[0].positions = [frame, frame].concat();
            alone.meshes[0].triangles = vec![[0, 1, 2], [3, 4, 5]];
            let (mut world, mut opened) = built(context, &alone, Settings { voxelizer, ..PLAIN });
            for triangle in support::some(&mesh.triangles, 60) {
                let corners = triangle.map(|i| mesh.positions[i as usize]);
                // The cube stays in place.
                alone.meshes[0].positions[..3].copy_from_slice(&corners);
                world.replace(&alone).expect("as many");
                opened.build(&world).expect("built");
                let at = place(&opened.technique);
                let among = triangles(&alone).into_iter().map(|t| t.map(|corner| at.voxels(corner)));
                let expected = Bits::voxelize(among, at.size).words;
                let bits = opened.technique.grid().bits().expect("read");
                assert!(bits == expected, "{voxelizer:?}: {corners:?}");
            }
        }
    });
}

/// Reports which path runs and why, and names what the device lacks.
#[test]
fn paths_say_what_they_are() {
    gpu_test("paths_say_what_they_are", |context| {
        let scene = slivers();
        let world = World::new(context, &scene).expect("room for the scene");
        let of = |text: &str| {
            open(context, &world, &spec(text)).map(|opened| opened.technique.inspect().facts().expect("facts"))
        };
        for text in ["voxel-grid", "voxel-grid:path=compute"] {
            assert_eq!(of(text).expect(text).path, "compute");
        }
        let features = context.features();
        match of("voxel-grid:path=raster") {
            Ok(facts) => {
                let way = if features.conservative_rasterization { "conservative" } else { "wider" };
                assert!(facts.path == "raster" && facts.reason.contains(way), "{facts:?}");
            }
            Err(error) => {
                assert!(!features.fragment_stores_and_atomics);
                assert!(matches!(&error, Error::Refused(Need::Feature(Requirement::FragmentStores))), "{error}");
            }
        }
    });
}
