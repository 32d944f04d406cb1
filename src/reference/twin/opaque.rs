//! CPU twin of glsl/maps/opaque_draw.glsl and glsl/maps/stored.glsl: triangles rasterized into a depth map in integer arithmetic, keeping
//! the smallest depth per texel. The bits equal the device's, since every operation is rounded once and in the same order.

use super::alpha::{TriangleAlpha, weights};
use super::exact::{cross3, dot3, longest3, reciprocal};
use crate::scene::{Projection, View};
use glam::{IVec2, Vec2, Vec3};

/// Number of quantization steps per texel for corner positions.
const STEPS: i32 = 256;
/// Distance from the map's centre at which triangles are clipped, as a multiple of the distance to the map's edge.
const GUARD: f32 = 1.5;
/// Square of twice a triangle's area below which it has no usable normal, in world units⁴.
const NO_AREA: f32 = 1e-30;

/// Draws triangles, given by their corners, and returns the depths in row-major order, 1 in empty texels.
pub fn draw(view: &View, triangles: &[[[f32; 3]; 3]]) -> Vec<f32> {
    draw_with_alpha(view, &triangles.iter().map(|corners| (*corners, None)).collect::<Vec<_>>())
}

/// Like [`draw`], for triangles that may have alpha.
pub fn draw_with_alpha(view: &View, triangles: &[([[f32; 3]; 3], Option<TriangleAlpha>)]) -> Vec<f32> {
    let mut depths = vec![1.0; view.texels()];
    for (corners, alpha) in triangles {
        let corners = corners.map(Vec3::from);
        let Some(seen) = see(view, corners) else { continue };
        covered(view, &seen, |texel, z| {
            let at = |alpha: &TriangleAlpha| alpha.blocks(weights(corners, ray_at(view, texel, z)));
            if !alpha.as_ref().is_none_or(at) {
                return;
            }
            let depth = stored(view, texel, z);
            let place = texel.y as usize * view.width as usize + texel.x as usize;
            if depth < 1.0 {
                depths[place] = f32::min(depths[place], depth.max(0.0));
            }
        });
    }
    depths
}

/// Returns how many of the triangles cover each texel. A texel on a shared edge is covered once.
pub fn coverage(view: &View, triangles: &[[[f32; 3]; 3]]) -> Vec<u32> {
    let mut counts = vec![0; view.texels()];
    for seen in triangles.iter().filter_map(|t| see(view, t.map(Vec3::from))) {
        covered(view, &seen, |texel, _| counts[texel.y as usize * view.width as usize + texel.x as usize] += 1);
    }
    counts
}

/// A triangle clipped to a map: the corners of the polygon, in steps, and their z.
struct VisibleTriangle {
    places: Vec<IVec2>,
    all_z: Vec<f32>,
    first: IVec2,
    last: IVec2,
}

fn is_parallel(view: &View) -> bool {
    view.projection() == Projection::Parallel
}

fn in_view(view: &View, corner: Vec3) -> Vec3 {
    let offset = corner - Vec3::from(view.origin);
    let along = |axis: [f32; 3]| dot3(offset, Vec3::from(axis));
    Vec3::new(along(view.right) * view.scale_x, along(view.up) * view.scale_y, along(view.forward))
}

fn w_of(view: &View, corner: Vec3) -> f32 {
    if is_parallel(view) { 1.0 } else { corner.z }
}

fn inside(view: &View, corner: Vec3, plane: u32) -> f32 {
    let guard = GUARD * w_of(view, corner);
    match plane {
        0 => corner.z - view.near,
        1 => guard - corner.x,
        2 => guard + corner.x,
        3 => guard - corner.y,
        _ => guard + corner.y,
    }
}

fn cut(a: Vec3, here: f32, b: Vec3, there: f32) -> Vec3 {
    a + (here * reciprocal(here - there)) * (b - a)
}

fn cut_off(view: &View, mut corners: Vec<Vec3>) -> Vec<Vec3> {
    for plane in 0..5 {
        let before = corners;
        corners = Vec::new();
        for (i, a) in before.iter().copied().enumerate() {
            let b = before[(i + 1) % before.len()];
            let (here, there) = (inside(view, a, plane), inside(view, b, plane));
            if here >= 0.0 {
                corners.push(a);
            }
            if (here >= 0.0) != (there >= 0.0) {
                corners.push(if here >= 0.0 { cut(a, here, b, there) } else { cut(b, there, a, here) });
            }
        }
    }
    corners
}

fn place_of(view: &View, corner: Vec3) -> IVec2 {
    let across = Vec2::new(corner.x, corner.y);
    let ndc = if is_parallel(view) { across } else { across * reciprocal(corner.z) };
    let size = Vec2::new(view.width as f32, view.height as f32);
    let steps = (ndc * 0.5 + Vec2::splat(0.5)) * (size * STEPS as f32);
    (steps + 0.5).floor().as_ivec2()
}

fn see(view: &View, triangle: [Vec3; 3]) -> Option<VisibleTriangle> {
    let corners = triangle.map(|corner| in_view(view, corner));
    let all = |is: &dyn Fn(Vec3) -> bool| corners.iter().all(|c| is(*c));
    let w = |c: Vec3| w_of(view, c);
    if all(&|c| c.z < view.near)
        || all(&|c| c.z > view.far)
        || all(&|c| c.x > w(c))
        || all(&|c| c.x < -w(c))
        || all(&|c| c.y > w(c))
        || all(&|c| c.y < -w(c))
    {
        return None;
    }
    let cuts = |c: &Vec3| c.z < view.near || c.x.abs().max(c.y.abs()) > GUARD * w(*c);
    let polygon = if corners.iter().any(cuts) { cut_off(view, corners.to_vec()) } else { corners.to_vec() };
    let places: Vec<_> = polygon.iter().map(|c| place_of(view, *c)).collect();
    let low: IVec2 = places.iter().copied().reduce(IVec2::min)?;
    let high: IVec2 = places.iter().copied().reduce(IVec2::max)?;
    let texel = |steps: IVec2| steps.div_euclid(IVec2::splat(STEPS));
    let first = texel(low + (STEPS / 2 - 1)).max(IVec2::ZERO);
    let last = texel(high - STEPS / 2).min(IVec2::new(view.width as i32, view.height as i32) - 1);
    let normal = cross3(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    let square = dot3(normal, normal);
    if polygon.len() < 3 || first.cmpgt(last).any() || square <= NO_AREA {
        return None;
    }
    Some(VisibleTriangle { places, all_z: polygon.iter().map(|c| c.z).collect(), first, last })
}

fn cross(a: IVec2, b: IVec2) -> i64 {
    i64::from(a.x) * i64::from(b.y) - i64::from(a.y) * i64::from(b.x)
}

/// Returns whether a triangle covers texel centres exactly on this edge, which holds for exactly one of the two triangles that share the
/// edge.
fn owns_edge(edge: IVec2) -> bool {
    edge.y < 0 || (edge.y == 0 && edge.x > 0)
}

/// Converts an integer to a float as the device does: its two 32-bit words are rounded separately.
fn wide_float(value: i64) -> f32 {
    ((value >> 32) as f32) * 4_294_967_296.0 + (value as u32) as f32
}

/// Calls `each` with every texel that the polygon covers, and its z there.
fn covered(view: &View, seen: &VisibleTriangle, mut each: impl FnMut(IVec2, f32)) {
    for i in 1..seen.places.len() - 1 {
        let [a, mut b, mut c] = [0, i, i + 1].map(|c| (seen.places[c], seen.all_z[c]));
        if cross(b.0 - a.0, c.0 - a.0) < 0 {
            (b, c) = (c, b);
        }
        let area = cross(b.0 - a.0, c.0 - a.0);
        if area == 0 {
            continue;
        }
        let one = |z: f32| if is_parallel(view) { z } else { reciprocal(z) };
        let (weights, area_divisor) = (Vec3::new(one(a.1), one(b.1), one(c.1)), reciprocal(wide_float(area)));
        for y in seen.first.y..=seen.last.y {
            for x in seen.first.x..=seen.last.x {
                let middle = STEPS * IVec2::new(x, y) + STEPS / 2;
                let edges = [(b, c), (c, a), (a, b)].map(|(from, to)| (from.0, to.0 - from.0));
                let values = edges.map(|(from, edge)| (cross(edge, middle - from), owns_edge(edge)));
                if values.iter().any(|(value, owned)| *value < 0 || (*value == 0 && !owned)) {
                    continue;
                }
                let at = Vec3::from(values.map(|(value, _)| wide_float(value)));
                let mean = dot3(at, weights) * area_divisor;
                let z = if is_parallel(view) { mean } else { reciprocal(mean) };
                each(IVec2::new(x, y), z.max(view.near));
            }
        }
    }
}

/// Returns the point at `z` on a texel's ray.
fn ray_at(view: &View, texel: IVec2, z: f32) -> Vec3 {
    let right = Vec3::from(view.right) * (2.0 * reciprocal(view.width as f32 * view.scale_x));
    let up = Vec3::from(view.up) * (2.0 * reciprocal(view.height as f32 * view.scale_y));
    let at = texel.as_vec2() + 0.5 - 0.5 * Vec2::new(view.width as f32, view.height as f32);
    let across = right * at.x + up * at.y;
    let (view_origin, forward) = (Vec3::from(view.origin), Vec3::from(view.forward));
    let (origin, direction) =
        if is_parallel(view) { (view_origin + across, forward) } else { (view_origin, forward + across) };
    origin + z * direction
}

/// Returns the depth stored for a surface at `z` on a texel's ray, pushed back by the error bound for rounding. Twin: stored_depth.
fn stored(view: &View, texel: IVec2, z: f32) -> f32 {
    let position = ray_at(view, texel, z);
    let view_origin = Vec3::from(view.origin);
    let coordinates = position.abs();
    let off = 1.2e-7 * (coordinates.x + coordinates.y + coordinates.z) + 6e-7 * longest3(position - view_origin);
    (z + off - view.near) * reciprocal(view.far - view.near) + 4e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parallel(size: u32) -> View {
        View {
            origin: [0.0; 3],
            projection: Projection::Parallel as u32,
            right: [1.0, 0.0, 0.0],
            scale_x: 1.0,
            up: [0.0, 1.0, 0.0],
            scale_y: 1.0,
            forward: [0.0, 0.0, 1.0],
            near: 0.0,
            far: 2.0,
            width: size,
            height: size,
        }
    }

    /// Two triangles form the halves of a map of 4 × 4 texels. Centres on the diagonal belong to exactly one of them.
    #[test]
    fn halves_are_a_whole() {
        let view = parallel(4);
        let [a, b, c, d] = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
        let [first, second] = [[a, b, c], [a, c, d]].map(|t| coverage(&view, &[t]));
        assert!(first.iter().zip(&second).all(|(one, other)| one + other == 1), "{first:?} {second:?}");
        let counts = [first, second].map(|half| half.iter().sum::<u32>());
        assert!(counts == [6, 10] || counts == [10, 6], "{counts:?}");
    }

    /// A plane that faces the light is pushed back only by the error bound for rounding.
    #[test]
    fn a_level_plane_has_its_depth() {
        let view = parallel(8);
        let plane = [[[-3.0, -3.0, 0.5], [3.0, -3.0, 0.5], [0.0, 5.0, 0.5]]];
        let depths = draw(&view, &plane);
        assert!(depths.iter().all(|d| (0.25..0.250_01).contains(d)), "{depths:?}");
    }

    /// Depths stay in range for a triangle with a corner behind the light, a sliver across the near plane, a triangle with a corner at the
    /// light, and a huge one.
    #[test]
    fn depths_of_what_is_cut_are_in_range() {
        let view = View { projection: Projection::Perspective as u32, near: 0.01, ..parallel(16) };
        let cut = [
            [[0.0, 0.0, -5.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
            [[-1e-3, 0.0, -1.0], [1e-3, 0.0, -1.0], [0.0, 0.3, 1.5]],
            [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.5]],
            [[0.0, 0.0, 1.0], [1e6, 0.0, 1.0], [0.0, 1e6, 1.0]],
        ];
        for triangle in cut {
            let depths = draw(&view, &[triangle]);
            assert!(depths.iter().all(|d| (0.0..=1.0).contains(d)), "{depths:?}");
            assert!(coverage(&view, &[triangle]).iter().all(|n| *n <= 1), "{triangle:?}");
        }
        assert_eq!(coverage(&view, &cut[3..]).iter().sum::<u32>(), 64, "a quarter of the map");
    }
}
