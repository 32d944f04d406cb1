//! Twin of glsl/technique/ism/visibility.glsl.

use super::map::{Axes, V3, dot, map_way, minus, texel_place};

/// Twins: NEARER_TEXELS, AWAY.
const NEARER_TEXELS: f32 = 0.5;
const AWAY: f32 = 1e-4;

/// Twins: WIDEST, REACH.
const WIDEST: f32 = 3.0;
const REACH: f32 = 1.2;

/// Twin: surface_distance.
fn surface_distance(normal: V3, plane: f32, (size, radius): (u32, f32), texel: [i32; 2], distance: f32) -> f32 {
    let mut least = distance;
    for side in (0..).map(|level| size as i32 >> level).take_while(|side| *side >= 4) {
        let splatted = if side == size as i32 { 3e38 } else { radius * (REACH + side as f32 / (2.0 * WIDEST)) };
        if 0.25 * distance > splatted {
            break;
        }
        let way = map_way(texel_place(side, texel.map(|t| t * side / size as i32)));
        let along = plane / dot(normal, way);
        if along > 0.0 && along < splatted {
            least = least.min(along * (2.0 - way[2]));
        }
    }
    least.max(0.5 * distance)
}

/// Returns how much of a virtual light at `origin` reaches `position`, in space or on a surface with the normal `surface`. The light's map
/// has `size` texels per side and was built from points of radius `radius`.
pub fn look_up(
    map: &[f32],
    (size, radius): (u32, f32),
    [origin, normal]: [V3; 2],
    position: V3,
    surface: Option<V3>,
) -> f32 {
    let axes = Axes::of(normal);
    let offset = axes.into_axes(minus(position, origin));
    let square = dot(offset, offset);
    if !(offset[2] > 0.0 && square < 3e38) {
        return 1.0;
    }
    let (distance, surface) = (square.sqrt(), surface.map(|normal| axes.into_axes(normal)));
    let plane = surface.map_or(0.0, |normal| dot(normal, offset));
    if plane > AWAY * distance {
        return 0.0;
    }
    let nearer = NEARER_TEXELS * (distance + offset[2]) * (2.0 / size as f32);
    let at = [0, 1].map(|i| (offset[i] / (distance + offset[2]) * 0.5 + 0.5) * size as f32 - 0.5);
    let (low, part) = (at.map(f32::floor), at.map(|a| a - a.floor()));
    let last = size as i32 - 1;
    let lit = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|corner| {
        let texel = [0, 1].map(|i| (low[i] as i32 + corner[i]).clamp(0, last));
        let here = surface
            .map_or(distance, |normal| surface_distance(normal, plane, (size, radius), texel, distance) - nearer);
        if here <= map[(texel[1] * size as i32 + texel[0]) as usize] { 1.0 } else { 0.0 }
    });
    let rows = [lit[0] + part[0] * (lit[1] - lit[0]), lit[2] + part[0] * (lit[3] - lit[2])];
    rows[0] + part[1] * (rows[1] - rows[0])
}
