//! Redrawing opaque maps: only maps of lights that moved, and only triangles that a map may see.

use super::compute::mesh;
use crate::support::{gpu_test, ran, scenes};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::maps::{Map, Maps, OPAQUE_PARTS, OpaqueDraw, OpaqueMaps, OpaqueWay, opaque_corner};
use gobo::scene::{Light, LightKind, Projection, Scene, View};
use gobo::world::World;

const SIZE: u32 = 48;

fn light(kind: LightKind) -> Light {
    Light { kind, radiance: [1.0; 3], radius: f64::INFINITY }
}

fn spot(position: DVec3) -> Light {
    light(LightKind::Spot { position, direction: DVec3::new(0.1, 0.2, -1.0).normalize(), cone_degrees: 80.0 })
}

fn lamp(position: DVec3) -> Light {
    light(LightKind::Point { position })
}

fn opened(context: &Context, world: &World, way: OpaqueWay) -> Maps {
    let opaque = OpaqueMaps { size: SIZE, ..OpaqueMaps::shared(Some(way)) };
    Maps::with_opaque(context, world, 8, opaque).expect("room for the maps")
}

/// Builds the maps, and returns each map's depths as bits.
fn built(context: &Context, world: &World, maps: &mut Maps) -> Vec<Vec<u32>> {
    loop {
        let frame = ran(context, |commands| maps.record(commands, world).expect("its lights"));
        if !maps.settle(frame, false).expect("read") {
            break;
        }
    }
    let (image, depths) = (maps.opaque_image(), maps.opaque_image().read::<u32>().expect("the depths"));
    let of_map = |map| {
        let [x, y] = opaque_corner(image, [SIZE; 2], map);
        let row = |row: u32| &depths[((y + row) * image.size()[0] + x) as usize..][..SIZE as usize];
        (0..SIZE).flat_map(row).copied().collect()
    };
    (0..maps.count()).map(of_map).collect()
}

/// When one of several lights moves, its maps equal a fresh build and no other map is touched: triangles erased without notice disappear
/// only from its maps.
#[test]
fn only_maps_of_lights_that_moved_are_drawn() {
    gpu_test("opaque_kept::only_maps_of_lights_that_moved_are_drawn", |context| {
        let mut scene = scenes::directional("kept", [0.3, 0.2, -0.9], Vec::new());
        scene.meshes = crate::opaque::plates();
        let places = [DVec3::new(0.5, -1.0, 5.0), DVec3::new(0.2, 0.1, 1.5), DVec3::new(-1.0, 0.5, 3.0)];
        scene.lights.extend([spot(places[0]), lamp(places[1]), spot(places[2])]);
        // Maps of the first light, the spot, the lamp (six), and the second spot.
        let maps_of = [0..1, 1..2, 2..8, 8..9];
        let empty = 1f32.to_bits();
        for way in [OpaqueWay::Raster, OpaqueWay::Compute] {
            let mut world = World::new(context, &scene).expect("room for the scene");
            let mut maps = opened(context, &world, way);
            let mut before = built(context, &world, &mut maps);
            assert_eq!(before.len(), 9);
            let mut now = scene.clone();
            for (i, moved) in [lamp(places[1] + 0.1), spot(places[2] - 0.2)].into_iter().enumerate() {
                now.lights[2 + i] = moved;
                world.replace(&now).expect("the same scene");
                let after = built(context, &world, &mut maps);
                let fresh_world = World::new(context, &now).expect("room for the scene");
                let fresh = built(context, &fresh_world, &mut opened(context, &fresh_world, way));
                for map in 0..9 {
                    assert!(after[map] == fresh[map], "{way:?}, light {}: map {map} of a build from nothing", 2 + i);
                    let is_its_own = maps_of[2 + i].contains(&map);
                    assert!(is_its_own || after[map] == before[map], "{way:?}, light {}: map {map}", 2 + i);
                }
                assert!(maps_of[2 + i].clone().any(|map| after[map] != before[map]), "{way:?}: it has moved");
                before = after;
            }
            let triangles = world.buffers().triangles.clone();
            ran(context, |commands| commands.pass("test", |pass| pass.fill(&triangles, 0)));
            for moves in [&[1][..], &[0, 2]] {
                for i in moves {
                    now.lights[*i] = match now.lights[*i].kind {
                        LightKind::Directional { .. } => {
                            light(LightKind::Directional { direction: DVec3::new(0.1, 0.2, -0.9).normalize() })
                        }
                        LightKind::Point { position } => lamp(position + 0.1),
                        _ => spot(places[0] + 0.1),
                    };
                }
                world.replace(&now).expect("the same scene");
                let after = built(context, &world, &mut maps);
                for (i, its_maps) in maps_of.iter().enumerate() {
                    for map in its_maps.clone() {
                        if moves.contains(&i) {
                            assert!(after[map].iter().all(|depth| *depth == empty), "{way:?}, map {map}: is not drawn");
                        } else {
                            assert!(after[map] == before[map], "{way:?}, map {map}: of a light that stands still");
                        }
                    }
                }
                before = after;
            }
            assert!(before[8].iter().any(|depth| *depth != empty), "{way:?}: the last one's is as it was");
            // When the meshes move, they are uploaded again and all maps are drawn.
            now.meshes[1].positions.iter_mut().for_each(|p| p[0] += 0.4);
            world.replace(&now).expect("the same scene");
            let after = built(context, &world, &mut maps);
            let fresh_world = World::new(context, &now).expect("room for the scene");
            assert!(after == built(context, &fresh_world, &mut opened(context, &fresh_world, way)), "{way:?}: meshes");
        }
    });
}

/// Returns whether a triangle is invisible: all of it lies beyond one of the view's planes by more than `by`.
fn is_beyond(view: &View, triangle: &[[f32; 3]; 3], by: f64) -> bool {
    let corners = triangle.map(|corner| view.axes(DVec3::from(corner.map(f64::from))));
    let [near, far, right, up] = [view.near, view.far, view.scale_x, view.scale_y].map(f64::from);
    assert_eq!(view.projection(), Projection::Perspective);
    let all = |out: &dyn Fn(DVec3) -> f64| corners.iter().all(|corner| out(*corner) > by);
    all(&|c| near - c.z)
        || all(&|c| c.z - far)
        || all(&|c| c.x * right - c.z)
        || all(&|c| -c.x * right - c.z)
        || all(&|c| c.y * up - c.z)
        || all(&|c| -c.y * up - c.z)
}

fn draws(context: &Context, world: &World) -> (Vec<Map>, Vec<OpaqueDraw>, Vec<Vec<u32>>) {
    let mut maps = opened(context, world, OpaqueWay::Raster);
    let depths = built(context, world, &mut maps);
    let draws = maps.opaque_draws().expect("faces do not see all");
    let draws = draws.read((maps.count() * OPAQUE_PARTS) as usize).expect("draws");
    (maps.all().to_vec(), draws, depths)
}

/// The rasterizer draws only the parts of the triangles that a map may see, including everything visible according to f64. The depths equal
/// those of a world that skips no part, and a map that sees nothing draws nothing.
#[test]
fn what_a_map_does_not_see_is_not_drawn() {
    gpu_test("opaque_kept::what_a_map_does_not_see_is_not_drawn", |context| {
        let mut random = scenes::Random::new(23);
        let at = DVec3::new(0.125, -0.25, 0.0625);
        let mut triangles: Vec<_> = (0..63 * 9)
            .map(|_| {
                let middle = random.point(-2.0, 2.0);
                [(); 3].map(|()| {
                    let by = random.point(-0.2, 0.2);
                    [0, 1, 2].map(|axis| middle[axis] + by[axis])
                })
            })
            .collect();
        triangles.sort_by(|a, b| (a[0][0] + a[0][1]).total_cmp(&(b[0][0] + b[0][1])));
        let mut scene = scenes::point(at.into(), scenes::directional("seen", [0.0, 0.0, -1.0], Vec::new()));
        scene.meshes = vec![mesh(&triangles)];
        let (views, found, depths) = draws(context, &World::new(context, &scene).expect("room for the scene"));
        let (mut left_out, mut seen) = (0, 0);
        for (map, views) in views.iter().enumerate() {
            let mut counted = 0;
            for draw in &found[map * OPAQUE_PARTS as usize..][..OPAQUE_PARTS as usize] {
                let [first, count] = [draw.first_vertex, draw.vertex_count].map(|vertices| vertices as usize / 3);
                let part = &triangles[first..first + count];
                let is_drawn = draw.instance_count == 1;
                assert!(is_drawn || part.iter().all(|t| is_beyond(&views.opaque, t, 0.0)), "map {map}: {draw:?}");
                assert!(!is_drawn || !part.iter().all(|t| is_beyond(&views.opaque, t, 1e-2)), "map {map}: {draw:?}");
                counted += count;
                *(if is_drawn { &mut seen } else { &mut left_out }) += usize::from(count > 0);
            }
            assert_eq!(counted, triangles.len(), "map {map}: the parts are all of it");
        }
        println!("{seen} parts seen, {left_out} left out");
        assert!(seen > 6 && left_out > 6, "{seen} and {left_out}");

        // Adds to each part of 64 triangles a degenerate one through the light, which covers no texel but is not culled by any face.
        let [one, other] = [-0.1, 0.1].map(|by| (at + by).as_vec3().to_array());
        let with_needles: Vec<_> = triangles
            .chunks(63)
            .flat_map(|part| std::iter::once([one, other, one]).chain(part.iter().copied()))
            .collect();
        scene.meshes = vec![mesh(&with_needles)];
        let (all_views, all, all_depths) = draws(context, &World::new(context, &scene).expect("room for the scene"));
        assert!(all.iter().all(|draw| (draw.instance_count == 1) == (draw.vertex_count > 0)), "{all:?}");
        assert!(all_views.iter().zip(&views).all(|(a, b)| a.opaque == b.opaque), "the same views");
        assert!(all_depths == depths, "the same depths");

        // The only mesh is in front of one face.
        scene.meshes = vec![mesh(&[[[5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]]])];
        let (_, found, depths) = draws(context, &World::new(context, &scene).expect("room for the scene"));
        let drawn = |map: &usize| found[map * OPAQUE_PARTS as usize..][..OPAQUE_PARTS as usize].iter();
        let drawing: Vec<_> = (0..6).filter(|map| drawn(map).any(|draw| draw.instance_count > 0)).collect();
        let filled: Vec<_> = (0..6).filter(|map| depths[*map].iter().any(|d| *d != 1f32.to_bits())).collect();
        assert!(drawing.len() == 1 && drawing == filled, "{drawing:?} draw, {filled:?} have something");
        // Maps fitted to all meshes skip nothing, and test nothing.
        let sun = scenes::directional("sun", [0.0, 0.0, -1.0], Vec::new());
        let world = World::new(context, &Scene { meshes: scene.meshes, ..sun }).expect("room for the scene");
        assert!(opened(context, &world, OpaqueWay::Raster).opaque_draws().is_none());
    });
}
