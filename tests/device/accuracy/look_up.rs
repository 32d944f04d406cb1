//! The look-up of glsl/technique/avsm/visibility.glsl: nodes of several texels, weighted by a filter, all recomputed here.

use crate::support::{ask, built_avsm, gpu_test, nodes_of, scenes, some};
use glam::{DVec2, DVec3};
use gobo::Error;
use gobo::query::{PointBatch, Query};
use gobo::reference::twin::filter::Filter;
use gobo::scene::{Projection, Scene, View};
use gobo::technique::{NodeData, Technique};

/// Texels per side.
const SIZE: u32 = 12;

/// Approximate error bound of a rounded depth: a step of the curve may lie this far to either side.
const DEPTH_ROUNDING: f64 = 1e-5;

/// Returns the optical depth of a texel's curve at `depth`, in f64: linear between the last node at or in front of it and the next.
fn optical_depth(nodes: &[NodeData], depth: f64) -> f64 {
    let Some(last) = nodes.iter().rposition(|n| f64::from(n.depth) <= depth) else { return 0.0 };
    let near = nodes[last];
    match nodes.get(last + 1) {
        Some(far) if far.depth < 2.0 => {
            let along = (depth - f64::from(near.depth)) / (f64::from(far.depth) - f64::from(near.depth));
            f64::from(near.value) + (f64::from(far.value) - f64::from(near.value)) * along
        }
        _ => near.value.into(),
    }
}

/// Returns the bilinear mean of the four texels around `position`; outside the map all light passes.
fn visibility(view: &View, nodes: &[NodeData], count: usize, position: DVec3, depth_error: f64) -> f64 {
    let (texel, z) = view.project(position);
    if z <= f64::from(view.near) {
        return 1.0;
    }
    let depth = view.depth(z) + depth_error;
    let corner = (texel - 0.5).floor();
    let weight = texel - 0.5 - corner;
    let mut sum = 0.0;
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let at = corner + DVec2::new(dx, dy);
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmplt(DVec2::splat(SIZE.into())).all();
        let first = if inside { (at.y as usize * SIZE as usize + at.x as usize) * count } else { 0 };
        let through = if inside { (-optical_depth(&nodes[first..first + count], depth)).exp() } else { 1.0 };
        let weights = (weight * DVec2::new(dx, dy)) + (1.0 - weight) * (1.0 - DVec2::new(dx, dy));
        sum += weights.x * weights.y * through;
    }
    sum
}

/// Returns texel centres at many depths, random points, and points far outside the map on every side.
fn points(scene: &Scene, view: &View) -> Vec<DVec3> {
    let mut points = Vec::new();
    for texel in 0..SIZE * SIZE {
        let at = DVec2::new(f64::from(texel % SIZE) + 0.5, f64::from(texel / SIZE) + 0.5);
        points.extend((0..=16).map(|i| view.ray(at).at(view.z(f64::from(i) / 16.0))));
    }
    let mut random = scenes::Random::new(77);
    let mut point = |reach: f32| DVec3::from(random.point(-reach, reach).map(f64::from));
    points.extend((0..3000).map(|_| point(1.4)));
    points.extend((0..200).map(|_| point(50.0)));
    if view.projection() == Projection::Perspective {
        // Behind the light the projection is meaningless, and nothing casts a shadow there.
        let behind = DVec3::from(view.origin.map(f64::from)) - DVec3::from(view.forward.map(f64::from));
        points.push(behind);
    }
    assert!(!scene.has_only_meshes());
    points
}

#[test]
fn looks_up_what_the_nodes_say() {
    gpu_test("looks_up_what_the_nodes_say", |context| {
        for scene in [scenes::random(), scenes::spot([1.5, 1.0, 2.5], 70.0, scenes::opaque())] {
            for (count, storage) in some([8, 4, 16], 1).into_iter().flat_map(|n| [(n, "full"), (n, "packed")]) {
                let text = format!("avsm:nodes={count},curve=exponential,path=two-pass,size={SIZE},storage={storage}");
                let avsm = built_avsm(context, &scene, &text);
                let nodes = nodes_of(&avsm, &text, (SIZE * SIZE) as usize);
                let view = avsm.inspect().maps()[0].caster_view;
                // Rounded to the precision of the query.
                let asked: Vec<_> = points(&scene, &view).iter().map(|p| p.as_vec3().to_array()).collect();
                let answers = ask(context, avsm.as_ref(), 0, &asked);
                let mut shadowed = 0;
                for (point, answer) in asked.iter().zip(answers) {
                    let at = DVec3::from(point.map(f64::from));
                    let high = visibility(&view, &nodes, count, at, -DEPTH_ROUNDING);
                    let low = visibility(&view, &nodes, count, at, DEPTH_ROUNDING);
                    let answer = f64::from(answer);
                    // The weights' rounding error adds at most 1e-6 of a texel times the difference between neighbouring texels, which is
                    // at most 1.
                    let fits = (low - 2e-5..=high + 2e-5).contains(&answer);
                    assert!(fits, "{} {text} at {point:?}: {answer}, not {low} to {high}", scene.name);
                    shadowed += u32::from(answer < 0.9);
                }
                assert!(shadowed > 500, "only {shadowed} points are in shadow");
            }
        }
    });
}

/// Box and Gaussian look-ups equal sums with the twin's weights, even across the map's edges.
#[test]
fn filters_weigh_as_their_twins() {
    gpu_test("filters_weigh_as_their_twins", |context| {
        for scene in [scenes::random(), scenes::spot([1.5, 1.0, 2.5], 70.0, scenes::opaque())] {
            for (name, radius, filter) in [
                ("box", 1, Filter::Box(1)),
                ("box", 3, Filter::Box(3)),
                ("gaussian", 1, Filter::Gaussian(1)),
                ("gaussian", 3, Filter::Gaussian(3)),
            ] {
                let text = format!("avsm:nodes=8,path=two-pass,size={SIZE},filter={name},radius={radius}");
                let avsm = built_avsm(context, &scene, &text);
                let nodes: Vec<NodeData> = avsm.curves().read((SIZE * SIZE) as usize * 8).expect("the nodes");
                let view = avsm.inspect().maps()[0].caster_view;
                let asked: Vec<_> = points(&scene, &view).iter().map(|p| p.as_vec3().to_array()).collect();
                let visibility = |at: DVec3, depth_error: f64| {
                    let (texel, z) = view.project(at);
                    if z <= f64::from(view.near) {
                        return 1.0;
                    }
                    let depth = view.depth(z) + depth_error;
                    let size = glam::Vec2::splat(SIZE as f32);
                    let through = |t: glam::IVec2| {
                        let inside = t.min_element() >= 0 && t.max_element() < SIZE as i32;
                        let first = if inside { (t.y * SIZE as i32 + t.x) as usize * 8 } else { 0 };
                        if inside { (-optical_depth(&nodes[first..first + 8], depth)).exp() } else { 1.0 }
                    };
                    filter.weights(size, texel.as_vec2()).iter().map(|(t, w)| f64::from(*w) * through(*t)).sum()
                };
                let mut shadowed = 0;
                for (point, answer) in asked.iter().zip(ask(context, avsm.as_ref(), 0, &asked)) {
                    let at = DVec3::from(point.map(f64::from));
                    let (high, low) = (visibility(at, -DEPTH_ROUNDING), visibility(at, DEPTH_ROUNDING));
                    // Weights are rounded as in the bilinear look-up above.
                    let fits = (low - 2e-5..=high + 2e-5).contains(&f64::from(answer));
                    assert!(fits, "{} {text} at {point:?}: {answer}, not {low} to {high}", scene.name);
                    shadowed += u32::from(answer < 0.9);
                }
                assert!(shadowed > 500, "only {shadowed} points are in shadow");
            }
        }
    });
}

/// A query has one normal and one side length per point, or none at all.
#[test]
fn a_query_of_other_lengths_is_refused() {
    gpu_test("look_up::a_query_of_other_lengths_is_refused", |context| {
        let (points, normals) = ([[0.0; 3], [1.0; 3]], [[0.0, 0.0, 1.0]; 2]);
        let ask = |normals: &[[f32; 3]], sides: &[f32]| {
            Query::of_areas(context, &[PointBatch { light: 0, points: &points, normals }], sides)
                .map(|query| query.points())
        };
        assert_eq!(ask(&normals, &[0.1; 2]).expect("one each"), 2);
        assert_eq!(ask(&[], &[]).expect("none"), 2);
        for (normals, sides, said) in
            [(&normals[..1], &[][..], "1 normals for 2 points"), (&[], &[0.1; 3], "3 sides for 2 points")]
        {
            let error = ask(normals, sides).expect_err(said);
            assert!(matches!(&error, Error::Input { cause, .. } if cause == said), "{error}");
        }
    });
}
