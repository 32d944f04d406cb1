//! CPU twin of glsl/world/sheet.glsl and glsl/grid/pane.glsl: where a ray crosses a see-through triangle, and the points by which a grid
//! represents one. Optical depth comes from constant alpha alone here; alpha from textures is held against the truth.

use super::grid::Place;
use super::media::{light_taken, root, units};
use crate::scene::Caster;
use glam::{Vec2, Vec3};

/// A ray as a shear. Twin: Shear in glsl/world/shear.glsl.
struct Shear {
    origin: Vec3,
    axis: usize,
    by: Vec3,
}

/// Twin: shear_turned.
fn turned(v: Vec3, axis: usize) -> Vec3 {
    match axis {
        0 => Vec3::new(v.y, v.z, v.x),
        1 => Vec3::new(v.z, v.x, v.y),
        _ => v,
    }
}

impl Shear {
    /// Twin: shear_of.
    fn new(origin: Vec3, direction: Vec3) -> Self {
        let far = direction.abs();
        let axis = if far.x >= far.y && far.x >= far.z {
            0
        } else if far.y >= far.z {
            1
        } else {
            2
        };
        let turned = turned(direction, axis);
        Self { origin, axis, by: Vec3::new(turned.x / turned.z, turned.y / turned.z, 1.0 / turned.z) }
    }

    /// Twin: sheared.
    fn corner(&self, corner: Vec3) -> Vec3 {
        let v = turned(corner - self.origin, self.axis);
        Vec3::new(v.x - self.by.x * v.z, v.y - self.by.y * v.z, v.z * self.by.z)
    }
}

/// Twin: side_area.
fn area(from: Vec2, to: Vec2) -> f32 {
    from.x * to.y - from.y * to.x
}

/// Twin: side_is_left.
fn is_left(from: Vec2, to: Vec2, area: f32) -> bool {
    if area != 0.0 {
        return area > 0.0;
    }
    if from.x == to.x { from.y < to.y } else { from.x < to.x }
}

/// Returns where a ray crosses a triangle, in lengths of its direction. Twin: sheet_overlap.
pub fn crossing((origin, direction): (Vec3, Vec3), corners: [Vec3; 3]) -> Option<f32> {
    let shear = Shear::new(origin, direction);
    let [a, b, c] = corners.map(|corner| shear.corner(corner));
    let (low, high) = (a.min(b.min(c)), a.max(b.max(c)));
    if low.x > 0.0 || low.y > 0.0 || high.x < 0.0 || high.y < 0.0 {
        return None;
    }
    let sides = [(b, c), (c, a), (a, b)].map(|(from, to)| (from.truncate(), to.truncate()));
    let areas = sides.map(|(from, to)| area(from, to));
    let left = [0, 1, 2].map(|i| is_left(sides[i].0, sides[i].1, areas[i]));
    let all = areas[0] + areas[1] + areas[2];
    if left[0] != left[1] || left[0] != left[2] || all == 0.0 {
        return None;
    }
    Some((areas[0] * a.z + areas[1] * b.z + areas[2] * c.z) / all)
}

/// Calls `deposit` with each point of a sheet in a grid, in voxels, and its amount. Twin: pane_of and the functions after it.
pub(super) fn points(sheet: &Caster, corners: [[f32; 3]; 3], place: &Place, mut deposit: impl FnMut([f32; 3], u32)) {
    let voxels = |v: Vec3| v * place.per_unit;
    let [a, b, c] = corners.map(Vec3::from);
    let (first, b, c) = (Vec3::from(place.voxels(corners[0])), voxels(b - a), voxels(c - a));
    let widest = b.abs().max(c.abs()).max((b - c).abs()).max_element();
    let (mut side, mut each) = (2_u32, 0.25_f32);
    while (side as f32) < 2.0 * widest && side < 1024 {
        (side, each) = (2 * side, 0.25 * each);
    }
    let normal = Vec3::new(b.y * c.z - b.z * c.y, b.z * c.x - b.x * c.z, b.x * c.y - b.y * c.x);
    let amount = 0.25 * root(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z) * each;
    let is_large = sheet.radius * place.per_unit >= 1.0;
    let amount = units(amount * if is_large { sheet.density } else { light_taken(sheet.density) });
    for i in 0..side * side {
        let at = [i % side, i / side].map(|at| (at as f32 + 0.5) / side as f32);
        let [u, v] = if at[0] + at[1] > 1.0 { at.map(|at| 1.0 - at) } else { at };
        deposit((first + b * u + c * v).into(), amount);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A ray through a fan of triangles crosses exactly one of them, even if it meets an edge or the corner that all share; rays beside
        /// the fan cross none.
        #[test]
        fn a_fan_is_crossed_once(
            hub in prop::array::uniform2(-4i32..=4),
            tilt in prop::array::uniform2(-2i32..=2),
            direction in prop::array::uniform2(-3i32..=3),
            at in prop::array::uniform2(-8i32..=8),
            turned in any::<bool>(),
        ) {
            // Whole numbers, so that many rays meet edges and corners exactly.
            let rim = [[-8, -8], [0, -8], [8, -8], [8, 1], [8, 8], [-3, 8], [-8, 8], [-8, -2]];
            let corner = |[x, y]: [i32; 2]| Vec3::new(x as f32, y as f32, (tilt[0] * x + tilt[1] * y) as f32);
            let way = Vec3::new(direction[0] as f32, direction[1] as f32, if turned { 4.0 } else { -4.0 });
            let target = corner(at);
            let count = (0..rim.len()).filter(|&i| {
                let all = [corner(hub), corner(rim[i]), corner(rim[(i + 1) % rim.len()])];
                // Every other triangle has its corners the other way round.
                let all = if i % 2 == 0 { all } else { [all[0], all[2], all[1]] };
                crossing((target - 2.0 * way, way), all).is_some()
            });
            let count = count.count();
            let plane = Vec3::new(-tilt[0] as f32, -tilt[1] as f32, 1.0);
            // Along the fan's plane, nothing is crossed.
            prop_assume!(plane.dot(way) != 0.0);
            let is_inside = at.iter().all(|at| at.abs() < 8);
            prop_assert!(if is_inside { count == 1 } else { count <= 1 }, "{count}");
        }

        /// The crossing is that of f64.
        #[test]
        fn crossings_are_those_of_f64(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0f32..1.0)),
            origin in prop::array::uniform3(-2.0f32..2.0),
            direction in prop::array::uniform3(-1.0f32..1.0),
        ) {
            let corners = corners.map(Vec3::from);
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (from, way) = (Vec3::from(origin).as_dvec3(), Vec3::from(direction).as_dvec3());
            let normal = (b - a).cross(c - a);
            let at = normal.dot(a - from) / normal.dot(way);
            let point = from + at * way;
            let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).cross(point - p).dot(normal) / normal.length_squared());
            let least = sides.into_iter().fold(f64::INFINITY, f64::min);
            prop_assume!(at.is_finite() && normal.length() > 0.05 && normal.normalize().dot(way.normalize()).abs() > 0.05);
            let found = crossing((Vec3::from(origin), Vec3::from(direction)), corners);
            prop_assert!(found.is_some() == (least > 0.0) || least.abs() < 1e-4, "{found:?} {least}");
            prop_assert!(found.is_none_or(|found| (f64::from(found) - at).abs() * way.length() < 1e-4), "{found:?} {at}");
        }
    }
}
