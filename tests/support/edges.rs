//! How much of a scene lies near the edges of shadows, from its edges and triangles alone: what no technique of a stated size may exceed.

use glam::DVec3;
use gobo::reference::truth::{Casters, bounds, points_outside, surface_points};
use gobo::scene::{LightKind, Scene, View};
use std::collections::BTreeMap;

/// The diagonal of the box about the meshes, world units.
pub fn diagonal(scene: &Scene) -> f64 {
    bounds(scene).map_or(0.0, |[low, high]| (high - low).length())
}

/// The share of points in space, and of those on surfaces, from which the way to a light passes less than `reach` beside an edge whose
/// shadow has an edge, or that lie less than `reach` from a triangle, but for what is in the plane of their own.
pub fn shares_near_edges(scene: &Scene, reach: f64) -> [f64; 2] {
    let casters = Casters::new(scene);
    let camera = View::camera(&scene.camera, scene, [96, 64]);
    let corner = |mesh: usize, i: u32| DVec3::from(scene.meshes[mesh].positions[i as usize].map(f64::from));
    let triangles: Vec<[DVec3; 3]> = (0..scene.meshes.len())
        .flat_map(|mesh| scene.meshes[mesh].triangles.iter().map(move |t| t.map(|i| corner(mesh, i))))
        .collect();
    let lights: Vec<usize> = (0..scene.lights.len()).step_by(scene.lights.len().div_ceil(8)).collect();
    let (mut near, mut all) = ([0.0; 2], [0.0; 2]);
    for &light in &lights {
        let from_light = |p: DVec3| match scene.lights[light].kind {
            LightKind::Directional { direction } => direction,
            _ => p - scene.lights[light].position().expect("a place"),
        };
        let edges = edges_of_shadows(&triangles, from_light);
        let far = 4.0 * diagonal(scene);
        let is_near = |p: DVec3, normal: Option<DVec3>| {
            let way = from_light(p);
            let end = p - if scene.lights[light].position().is_some() { way } else { way * far };
            edges.iter().any(|[a, b]| apart(p, end, *a, *b) < reach)
                || triangles.iter().any(|t| {
                    let in_plane = |n: DVec3| t.iter().all(|c| (*c - p).dot(n).abs() < 1e-5 * far);
                    !normal.is_some_and(in_plane) && from_triangle(p, *t) < reach
                })
        };
        let count = 1600 / lights.len();
        let space = points_outside(&casters, bounds(scene).expect("meshes"), light, count);
        let surface = surface_points(&casters, scene, light, &camera, count);
        all = [all[0] + space.len() as f64, all[1] + surface.len() as f64];
        near[0] += space.iter().filter(|p| is_near(DVec3::from(p.map(f64::from)), None)).count() as f64;
        near[1] += surface.iter().filter(|p| is_near(p.position, Some(p.normal))).count() as f64;
    }
    [near[0] / all[0], near[1] / all[1]]
}

/// Edges of one triangle alone, of more than two, and of two of which the light sees one's front and the other's back.
fn edges_of_shadows(triangles: &[[DVec3; 3]], from_light: impl Fn(DVec3) -> DVec3) -> Vec<[DVec3; 2]> {
    let mut edges: BTreeMap<[[u64; 3]; 2], Vec<(bool, bool)>> = BTreeMap::new();
    let bits = |p: DVec3| p.to_array().map(|c| (c + 0.0).to_bits());
    for [a, b, c] in triangles {
        let normal = (*b - *a).cross(*c - *a);
        let front = normal.dot(from_light(*a)) < 0.0;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (bits(*from), bits(*to));
            edges.entry([from.min(to), from.max(to)]).or_default().push((front, from < to));
        }
    }
    // Two triangles that are wound alike go along their edge in opposite ways.
    let inner = |sides: &[(bool, bool)]| matches!(sides, [a, b] if (a.0 == b.0) == (a.1 != b.1));
    let point = |bits: [u64; 3]| DVec3::from(bits.map(f64::from_bits));
    edges.into_iter().filter(|(_, sides)| !inner(sides)).map(|(edge, _)| edge.map(point)).collect()
}

/// How far two segments are apart. Source: Ericson 2005, Real-time collision detection, section 5.1.9.
fn apart(p: DVec3, q: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (along, edge, offset) = (q - p, b - a, p - a);
    let (aa, ee, f) = (along.dot(along), edge.dot(edge), edge.dot(offset));
    let (c, d) = (along.dot(offset), along.dot(edge));
    let denominator = aa * ee - d * d;
    let s = if denominator > 0.0 { ((d * f - c * ee) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let t = if ee > 0.0 { ((d * s + f) / ee).clamp(0.0, 1.0) } else { 0.0 };
    let s = if aa > 0.0 { ((d * t - c) / aa).clamp(0.0, 1.0) } else { 0.0 };
    (p + s * along - a - t * edge).length()
}

/// How far a point is from a triangle.
fn from_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = normal != DVec3::ZERO
        && [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(p - *from).dot(normal) >= 0.0);
    if inside {
        return (p - a).dot(normal.normalize()).abs();
    }
    [(a, b), (b, c), (c, a)].into_iter().map(|(from, to)| apart(p, p, from, to)).fold(f64::MAX, f64::min)
}
