//! Maps: splatting points and filling holes.

use crate::ism::adaptive::of_device;
use crate::ism::{PATHS, built, refusal, scenes};
use crate::support::{gpu_test, scenes::cuboid, some};
use gobo::gpu::Context;
use gobo::reference::twin::ism::adapt::{taken_bounds, taken_index, taken_radius};
use gobo::reference::twin::ism::clusters::CLUSTER;
use gobo::reference::twin::ism::fill::{fill, wide_down};
use gobo::reference::twin::ism::map::{Axes, Levels, dot, minus};
use gobo::reference::twin::ism::points::{point_of, unpack_normal};
use gobo::reference::twin::ism::splat::{Culling, Point, Taken, is_before, splat};
use gobo::scene::{LightKind, Scene};
use gobo::technique::{Ism, PointData};

/// Returns the position and normal of a light.
pub fn stand(scene: &Scene, light: usize) -> ([f32; 3], [f32; 3]) {
    let LightKind::Virtual { position, normal, .. } = scene.lights[light].kind else { panic!("a virtual light") };
    (position.as_vec3().to_array(), normal.as_vec3().to_array())
}

/// Converts a point to the twins' type.
pub fn point(point: &PointData) -> Point {
    let (normal, closed) = unpack_normal(point.normal);
    Point { position: point.position, normal, closed }
}

/// Returns the points of a light.
pub fn points(ism: &Ism, light: usize) -> Vec<Taken> {
    let (head, pool) = ism.points().expect("the points");
    let points = pool.len() / gobo::technique::ISM_SUBSETS as usize;
    let of = |index: u32| point(&pool[index as usize]);
    match ism.taken().expect("what lights take") {
        None => {
            let even =
                |i| Taken { point: of(point_of(light as u32, i, points as u32)), radius: head.radius, bounds: None };
            (0..points as u32).map(even).collect()
        }
        Some((clusters, taken)) => {
            let own = taken[light * points..][..points].iter().filter(|code| **code != u32::MAX);
            let one = |code: &u32| {
                let (index, radius) = (taken_index(*code), taken_radius(*code, head.radius));
                let bounds = taken_bounds(&of_device(&clusters[index / CLUSTER]), radius, head.radius);
                Taken { point: of(index as u32), radius, bounds: Some(bounds) }
            };
            own.map(one).collect()
        }
    }
}

/// Returns the twin's map of a light, and the number of points that the light sees.
fn twin(scene: &Scene, ism: &Ism, light: usize, size: u32, culling: Culling, filled: bool) -> (Levels, u32) {
    let head = ism.points().expect("the points").0;
    let (origin, normal) = stand(scene, light);
    let (mut map, seen) = splat(size, normal, origin, &points(ism, light), culling);
    wide_down(&mut map);
    if filled {
        fill(&mut map, head.radius);
    }
    (map, seen)
}

/// Returns the number of texels, over all lights' maps, that differ from their twins', and the total number of texels.
fn others(context: &Context, scene: &Scene, text: &str, size: u32, culling: Culling, filled: bool) -> [usize; 2] {
    let ism = built(context, scene, text);
    let (mut others, mut texels) = (0, 0);
    for (light, seen) in ism.atlas().seen().expect("counted").into_iter().enumerate() {
        let (map, count) = twin(scene, &ism, light, size, culling, filled);
        assert!(seen.abs_diff(count) <= 2, "{text}: {seen} seen, not {count}");
        let got = ism.atlas().map(light).expect("the map");
        let near = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-4 * a.min(b);
        others += got.iter().zip(&map.levels[0]).filter(|(a, b)| !near(**a, **b)).count();
        texels += got.len();
        assert!(got.iter().all(|d| *d > 0.0), "{text}: a distance that is none");
    }
    [others, texels]
}

/// Maps equal their twins texel by texel, except where rounding decides whether a point's disc covers a texel's centre.
#[test]
fn maps_equal_their_twin() {
    gpu_test("ism::maps_equal_their_twin", |context| {
        let cases = [
            ("culling=on,adaptive=off", Culling { on: true, far: false, slide: false }),
            ("culling=far,adaptive=off", Culling { on: true, far: true, slide: false }),
            ("adaptive=on", Culling { on: true, far: false, slide: false }),
            ("culling=off,adaptive=off", Culling { on: false, far: false, slide: false }),
            ("facing=slide,adaptive=off", Culling { on: true, far: false, slide: true }),
            ("facing=slide,adaptive=on", Culling { on: true, far: false, slide: true }),
        ];
        let fills = [("off", false), ("on", true)];
        let cases: Vec<_> = some(cases, 3).into_iter().flat_map(|case| fills.map(|fill| (case, fill))).collect();
        for scene in [scenes::soup(), scenes::room()] {
            for (path, size) in
                ["tiled", "atomic"].into_iter().flat_map(|p| some([64, 32, 128], 1).into_iter().map(move |s| (p, s)))
            {
                for ((case, culling), (fill, filled)) in &cases {
                    let text = format!("ism:points=1024,size={size},path={path},fill={fill},{case}");
                    if refusal(context, &scene, &text).is_some() {
                        continue;
                    }
                    let [others, texels] = others(context, &scene, &text, size, *culling, *filled);
                    assert!(others * 1000 <= texels, "{text}: {others} of {texels} texels are others");
                }
            }
        }
    });
}

/// Every path, whatever its splatting order, gives the same bytes on every run.
#[test]
fn paths_give_the_same_bytes() {
    if crate::support::is_costly("paths_give_the_same_bytes") {
        return;
    }
    gpu_test("ism::paths_give_the_same_bytes", |context| {
        for scene in [scenes::soup(), scenes::room()] {
            for size in some([64, 32], 2) {
                for more in [
                    "fill=off,adaptive=off",
                    "fill=on,adaptive=off",
                    "fill=off,culling=off,adaptive=off",
                    "adaptive=on",
                    "adaptive=on,culling=off",
                ] {
                    let text = |path: &str| format!("ism:points=2048,size={size},path={path},{more}");
                    if refusal(context, &scene, &text("tiled")).is_some() {
                        continue;
                    }
                    let [tiled, again, atomic] =
                        ["tiled", "tiled", "atomic"].map(|path| built(context, &scene, &text(path)));
                    for light in 0..scene.lights.len() {
                        let bits = |ism: &Ism| {
                            let map = ism.atlas().map(light).expect("the map");
                            map.into_iter().map(f32::to_bits).collect::<Vec<_>>()
                        };
                        let first = bits(&tiled);
                        assert!(first == bits(&again), "{size}, {more}, light {light}: twice");
                        assert!(first == bits(&atomic), "{size}, {more}, light {light}: tiled and atomic");
                    }
                    assert_eq!(tiled.atlas().seen().expect("counted"), atomic.atlas().seen().expect("counted"));
                }
            }
        }
    });
}

/// Returns how far a texel's centre lies inside the shape drawn for a point, in texels; negative outside. Twins: drawn_point, draw.vert.
fn drawn_inside(square: bool, middle: [f32; 2], reach: f32, texel: [f32; 2]) -> f32 {
    let [x, y] = [0, 1].map(|i| texel[i] - middle[i]);
    if square {
        return 0.886_226_9 * reach - x.abs().max(y.abs());
    }
    // A triangle with one corner at the top and two at the bottom: its edges are half as far from the centre as its corners.
    let slant = 0.75f32.sqrt();
    0.777_560_2 * reach - (-y).max(slant * x + 0.5 * y).max(-slant * x + 0.5 * y)
}

/// Each texel of a drawn map holds the nearest of the points drawn over its centre, at the distance of that point's centre. Where the
/// rasterizer's grid decides which texels a point covers, or rounding decides whether a light sees it, the texel may hold that point or the
/// next. Holes are filled as by the twin.
#[test]
fn drawn_maps_have_what_is_drawn() {
    gpu_test("ism::drawn_maps_have_what_is_drawn", |context| {
        /// Step of the coarsest rasterizer grid plus arithmetic error, in texels.
        const STEP: f32 = 0.0625 + 2e-3;
        let scene = scenes::room();
        let (size, wide) = (64, 64.0f32);
        let cases = [("on", "off"), ("on", "on"), ("off", "off"), ("off", "on")];
        for (path, (culling, adaptive)) in
            ["quads", "triangles"].into_iter().flat_map(|path| some(cases, 2).into_iter().map(move |case| (path, case)))
        {
            let text =
                |fill: &str| format!("ism:points=4096,path={path},culling={culling},adaptive={adaptive},fill={fill}");
            let (drawn, filled) = (built(context, &scene, &text("off")), built(context, &scene, &text("on")));
            let usual = drawn.points().expect("the points").0.radius;
            let (mut texels, mut decided, mut empty, mut others) = (0usize, 0usize, 0usize, 0usize);
            for light in 0..scene.lights.len() {
                let (origin, normal) = stand(&scene, light);
                let axes = Axes::of(normal);
                // The farthest and the nearest distance that each texel may have.
                let (mut most, mut least) = (vec![f32::INFINITY; size * size], vec![f32::INFINITY; size * size]);
                for Taken { point, radius, .. } in points(&drawn, light) {
                    let offset = minus(point.position, origin);
                    let way = axes.into_axes(offset);
                    let distance = dot(way, way).sqrt();
                    let sees = |slack: f32| {
                        let before = way[2] > slack * distance && is_before(origin, normal, offset)
                            || slack < 0.0 && way[2] > 0.0;
                        let facing = culling == "off" || !point.closed || dot(point.normal, offset) > slack * distance;
                        before && facing
                    };
                    let (may, does) = (sees(-1e-5), sees(2e-3));
                    if !may {
                        continue;
                    }
                    let ahead = distance + way[2];
                    let middle = [0, 1].map(|i| ((way[i] / ahead * 0.5 + 0.5) * wide).clamp(0.0, wide - 0.01));
                    let reach = (1.2 * radius / ahead * (0.5 * wide)).max(0.57);
                    let range = |i: usize| {
                        let low = (middle[i] - 2.0 * reach).floor().max(0.0) as usize;
                        low..((middle[i] + 2.0 * reach).ceil() as usize).min(size)
                    };
                    for (x, y) in range(1).flat_map(|y| range(0).map(move |x| (x, y))) {
                        let inside = drawn_inside(path == "quads", middle, reach, [x, y].map(|t| t as f32 + 0.5));
                        let place = y * size + x;
                        if inside > -STEP {
                            least[place] = least[place].min(distance);
                        }
                        if does && inside > STEP {
                            most[place] = most[place].min(distance);
                        }
                    }
                }
                let map = drawn.atlas().map(light).expect("the map");
                for (place, got) in map.iter().enumerate() {
                    let (least, most) = (least[place], most[place]);
                    // The stored depth is rounded.
                    let rounding = 1e-5 * (1.0 + least / usual);
                    assert!(
                        *got >= least * (1.0 - rounding) && *got <= most * (1.0 + rounding),
                        "{}, light {light}, texel {place}: {got}, not {least} to {most}",
                        text("off")
                    );
                    texels += 1;
                    decided += usize::from(least == most);
                    empty += usize::from(got.is_infinite());
                }
                let mut levels = Levels::new(size as u32);
                levels.levels[0] = map;
                fill(&mut levels, usual);
                let now = filled.atlas().map(light).expect("the map");
                let near = |a: f32, b: f32| a == b || (a - b).abs() <= 1e-3 * a.min(b);
                others += now.iter().zip(&levels.levels[0]).filter(|(a, b)| !near(**a, **b)).count();
            }
            println!("{}: {decided} of {texels} decided, {empty} empty, {others} filled otherwise", text("off"));
            assert!(others * 1000 <= texels, "{}: {others} of {texels} are filled otherwise", text("on"));
        }
    });
}

/// A plate covers exactly the texels inside its outline as projected into the map, for which there is a closed form.
#[test]
fn a_plate_covers_its_angle() {
    gpu_test("ism::a_plate_covers_its_angle", |context| {
        // From −1 to 1, one unit in front of the light: the tangent of a place's angle is its distance from the axis.
        let plate = cuboid([-1.0, -1.0, 1.0], [1.0, 1.0, 1.02]);
        let scene = scenes::under("plate", vec![plate], vec![scenes::light(glam::DVec3::ZERO, glam::DVec3::Z)]);
        for (path, adaptive) in PATHS.into_iter().flat_map(|path| ["off", "on"].map(|adaptive| (path, adaptive))) {
            let text = format!("ism:points=4096,path={path},adaptive={adaptive}");
            if refusal(context, &scene, &text).is_some() {
                continue;
            }
            let map = built(context, &scene, &text).atlas().map(0).expect("the map");
            for (i, distance) in map.iter().enumerate() {
                let [x, y] = [i % 64, i / 64].map(|t| (t as f64 + 0.5) / 32.0 - 1.0);
                let square = x * x + y * y;
                let on_plate = [x, y].map(|p| 2.0 * p / (1.0 - square));
                let off_axis = on_plate.map(f64::abs).into_iter().fold(0.0, f64::max);
                if square >= 1.0 || off_axis > 1.2 {
                    assert!(distance.is_infinite(), "{path}: {distance} beside the plate, texel {i}");
                } else if off_axis < 0.85 {
                    let wanted = (1.0 + square) / (1.0 - square) * 1.02;
                    // Error bound of the stored distance: that of a point's plane or, on drawn paths, that of an adjacent point's centre at
                    // a slant of up to 50°.
                    let most = if path == "tiled" || path == "atomic" { 0.03 } else { 0.15 };
                    assert!((f64::from(*distance) / wanted - 1.0).abs() < most, "{path}: {distance}, not {wanted}");
                }
            }
        }
    });
}

/// Holes are filled and nothing else changes: texels seen before filling stay as they were, and texels with no points around them stay
/// empty.
#[test]
fn only_holes_are_filled() {
    gpu_test("ism::only_holes_are_filled", |context| {
        let scene = scenes::soup();
        for adaptive in ["on", "off"] {
            let text = |fill: &str| format!("ism:points=1024,path=atomic,fill={fill},adaptive={adaptive}");
            let (before, after) = (built(context, &scene, &text("off")), built(context, &scene, &text("on")));
            let (mut holes, mut filled) = (0, 0);
            for light in 0..scene.lights.len() {
                let maps = [&before, &after].map(|ism| ism.atlas().map(light).expect("the map"));
                let nearest = maps[0].iter().copied().fold(f32::INFINITY, f32::min);
                for (was, is) in maps[0].iter().zip(&maps[1]) {
                    assert!(was.is_infinite() || was == is, "{was} became {is}");
                    assert!(*is >= nearest, "{is} is nearer than anything that was seen");
                    holes += usize::from(was.is_infinite());
                    filled += usize::from(was.is_infinite() && is.is_finite());
                }
            }
            assert!(filled > 0 && filled < holes, "{filled} of {holes} filled");
        }
    });
}
