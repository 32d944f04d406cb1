//! CPU twin of glsl/technique/shadow_map/visibility.glsl: percentage closer filtering of a depth map, in f32. Source: Reeves, Salesin and
//! Cook 1987.

use glam::{IVec2, Vec2};

/// Returns the lit share of the `side` × `side` texels around the texel that contains the point `at` (in texels). `hit` returns a texel's
/// depth. `is_ended` decides, from that depth and the offset to the texel's centre, whether the texel blocks the point's light. Texels
/// outside the map, and texels that hold 1, block nothing.
pub fn visibility(
    side: u32,
    at: Vec2,
    is_ended: impl Fn(f32, Vec2) -> bool,
    hit: impl Fn(IVec2) -> Option<f32>,
) -> f32 {
    let first = at.floor().as_ivec2() - (side / 2) as i32;
    let texels = (0..side as i32).flat_map(|y| (0..side as i32).map(move |x| first + IVec2::new(x, y)));
    let ends = |texel: IVec2| hit(texel).is_some_and(|hit| hit < 1.0 && is_ended(hit, texel.as_vec2() + 0.5 - at));
    let lit = texels.filter(|texel| !ends(*texel)).count();
    lit as f32 / (side * side) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand: in a block of 3 × 3 texels, the left column has a mesh in front of the point.
    #[test]
    fn a_third_is_dark() {
        let hit = |texel: IVec2| (texel.x >= 0).then_some(if texel.x == 3 { 0.25 } else { 1.0 });
        let of = |side: u32, at: Vec2, depth: f32| visibility(side, at, |hit, _| hit < depth, hit);
        assert_eq!(of(3, Vec2::splat(4.5), 0.5), 6.0 / 9.0);
        assert_eq!(of(3, Vec2::splat(4.5), 0.25), 1.0, "on it");
        assert_eq!(of(1, Vec2::new(3.99, 4.0), 0.5), 0.0);
        assert_eq!(of(9, Vec2::new(-7.0, 3.0), 0.5), 1.0, "outside");
    }
}
