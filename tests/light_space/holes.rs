//! Triangles with holes: opaque maps against their twin, and every technique against the truth.

use crate::opaque::lights;
use crate::support::{gpu_test, opened, rows, scenes, some, spec};
use glam::DVec3;
use gobo::bench::Status;
use gobo::gpu::Context;
use gobo::maps::opaque_corner;
use gobo::reference::twin::alpha::{TriangleAlpha, at_levels, triangles};
use gobo::reference::twin::opaque::draw_with_alpha;
use gobo::scene::{Scene, View};
use gobo::technique::{Opened, ShadowMap, Technique};
use gobo::world::World;
use std::cell::Cell;

/// Opaque maps drawn by compute have the twin's depths, bit for bit, with levels of textures too; with `alpha=whole`, those of triangles
/// without alpha.
#[test]
fn depths_with_holes_equal_their_twin() {
    gpu_test("depths_with_holes_equal_their_twin", |context| {
        // Maps that levels change. Some maps see nothing.
        let changed = [Cell::new(0), Cell::new(0)];
        for (seed, light) in (1..).zip(some(lights(&[90.0, 40.0, 3.0], DVec3::ZERO), 2)) {
            let scene = Scene { meshes: scenes::cards(seed).meshes, ..light };
            let cut: Vec<_> = scene.meshes.iter().flat_map(triangles).collect();
            let whole: Vec<_> = cut.iter().map(|(corners, _)| (*corners, None)).collect();
            for (alpha, all) in [("cut", &cut), ("whole", &whole)] {
                compare(context, &scene, &format!("shadow-map:opaque=compute,size=150,alpha={alpha}"), |_| all.clone());
            }
            for ((alpha, hashed), changed) in [("coverage", false), ("hash", true)].into_iter().zip(&changed) {
                let text = format!("shadow-map:opaque=compute,size=50,alpha={alpha}");
                compare(context, &scene, &text, |view| {
                    let all = at_levels(view, &cut, hashed);
                    changed
                        .update(|count| count + i32::from(draw_with_alpha(view, &all) != draw_with_alpha(view, &cut)));
                    all
                });
            }
        }
        assert!(changed.iter().all(|count| count.get() > 0), "all at level 0: {changed:?}");
    });
}

/// Compares the depths of a spec's maps with those of the twin.
fn compare(
    context: &Context,
    scene: &Scene,
    text: &str,
    all: impl Fn(&View) -> Vec<([[f32; 3]; 3], Option<TriangleAlpha>)>,
) {
    let world = World::new(context, scene).expect("room for the scene");
    let map = opened(ShadowMap::new(context, &world, &spec(text).settings()), text);
    let mut opened = Opened::new(context, Box::new(map), true);
    opened.build(&world).expect("built");
    let depths: Vec<f32> = opened.technique.image().read().expect("the depths");
    let across = opened.technique.image().size()[0];
    for (map, views) in opened.technique.inspect().maps().iter().enumerate() {
        let view = views.opaque;
        let [x, y] = opaque_corner(opened.technique.image(), [view.width, view.height], map as u32);
        let twin = draw_with_alpha(&view, &all(&view));
        let row = |row: u32| &depths[((y + row) * across + x) as usize..][..view.width as usize];
        let differ = (0..view.height).flat_map(row).zip(&twin).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{text}, {:?}, map {map}: {differ} of {} differ", scene.lights[0].kind, twin.len());
    }
}

/// Techniques that know holes are right wherever they resolve a shadow's edge.
#[test]
fn holes_let_light_through() {
    if crate::support::is_costly("holes_let_light_through") {
        return;
    }
    gpu_test("holes_let_light_through", |context| {
        let texts = [
            "shadow-map:opaque=raster,size=2048",
            "voxel-grid:size=128",
            "voxel-grid:size=64,cell=triangles",
            "grid-query:size=64",
            "shadow-map:opaque=compute,size=2048",
            "shadow-map:opaque=compute,size=1024,filter=5",
            "avsm:size=64",
            "voxel-grid:size=128,path=raster",
            "voxel-grid:size=128,cell=mask",
            "voxelized:size=512",
            "voxelized:size=512,coverage=conservative",
            "ray-query",
        ];
        let texts = some(texts, 4);
        let mut scene = scenes::cards(1);
        scene.meshes.retain(|mesh| !mesh.is_see_through());
        for (turn, light) in some(lights(&[90.0], DVec3::ZERO), 1).into_iter().enumerate() {
            scene.lights = light.lights;
            scene.name = format!("cards-{turn}");
            for (row, text) in rows(context, &scene, &texts).into_iter().zip(&texts) {
                let what = format!("{}, {:?}", scene.name, row.variant);
                if row.status == Status::Refused {
                    println!("{what}: {}", row.reason);
                    continue;
                }
                assert_eq!(row.status, Status::Ok, "{what}: {}", row.reason);
                let error = row.error.expect("a truth");
                for (kind, points) in [("space", error.space), ("surface", error.surface)] {
                    let points = points.unwrap_or_else(|| panic!("{what}: no {kind} points"));
                    let beyond = points.beyond().unwrap_or_else(|| panic!("{what}: nothing opaque casts"));
                    println!("{what}: {kind}: {} beyond, mean error {}", beyond.points, points.mean_abs);
                    assert_eq!((beyond.leaks, beyond.false_shadows), (0, 0), "{what}: {kind}");
                    let is_exact =
                        ["cell=triangles", "grid-query", "ray-query"].iter().any(|exact| text.contains(exact));
                    assert!(!is_exact || points.mean_abs < 2e-4, "{what}: {kind}: {}", points.mean_abs);
                    assert!(beyond.points > 200, "{what}: too few {kind} points beyond the resolution");
                }
            }
        }
    });
}
