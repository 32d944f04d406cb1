//! Twin of glsl/technique/ism/visibility.glsl.

use super::map::{Axes, V3, dot, minus};

/// How much of a virtual light at `origin` reaches `position`, by its map of `size` texels a side.
pub fn look_up(map: &[f32], size: u32, origin: V3, normal: V3, position: V3) -> f32 {
    let offset = Axes::of(normal).into_axes(minus(position, origin));
    let square = dot(offset, offset);
    if !(offset[2] > 0.0 && square < 3e38) {
        return 1.0;
    }
    let distance = square.sqrt();
    let at = [0, 1].map(|i| (offset[i] / (distance + offset[2]) * 0.5 + 0.5) * size as f32 - 0.5);
    let (low, part) = (at.map(f32::floor), at.map(|a| a - a.floor()));
    let last = size as i32 - 1;
    let lit = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|corner| {
        let [x, y] = [0, 1].map(|i| (low[i] as i32 + corner[i]).clamp(0, last));
        if distance <= map[(y * size as i32 + x) as usize] { 1.0 } else { 0.0 }
    });
    let rows = [lit[0] + part[0] * (lit[1] - lit[0]), lit[2] + part[0] * (lit[3] - lit[2])];
    rows[0] + part[1] * (rows[1] - rows[0])
}
