//! The alpha texture of the leaf cards in `grove`: a sprig of seven leaves.

use crate::scene::{AlphaTexture, Wrap};
use glam::DVec2;

/// Width and height, in texels.
const SIDE: u32 = 64;

/// The stem, the leaf at its end, and the three leaves on its right: base, tip, and half the greatest width, in texels. The three leaves on
/// the left are their mirror images.
const LEAVES: [([f64; 2], [f64; 2], f64); 5] = [
    ([32.0, 62.0], [32.0, 20.0], 1.2),
    ([32.0, 30.0], [32.0, 2.0], 7.5),
    ([32.0, 58.0], [60.0, 46.0], 6.5),
    ([32.0, 46.0], [61.0, 27.0], 7.2),
    ([32.0, 33.0], [56.0, 8.0], 6.6),
];

/// Builds the texture. Its edges are one texel wide, and the texels at its border are 0.
pub(super) fn sprig() -> AlphaTexture {
    let middle = |i: u32| DVec2::new(f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5);
    let texels = (0..SIDE * SIDE).map(|i| (255.0 * alpha(middle(i)) + 0.5) as u8).collect();
    AlphaTexture { size: [SIDE; 2], wrap: [Wrap::Clamp; 2], texels }
}

/// Returns the alpha at a position in texels.
fn alpha(at: DVec2) -> f64 {
    let centre = 0.5 * f64::from(SIDE);
    let folded = DVec2::new(centre + (at.x - centre).abs(), at.y);
    let depth = LEAVES.iter().map(|leaf| depth(*leaf, folded)).fold(f64::NEG_INFINITY, f64::max);
    (depth + 0.5).clamp(0.0, 1.0)
}

/// Returns roughly how deep a position is inside a leaf, in texels. The sides of a leaf are parabolas.
fn depth((base, tip, half_width): ([f64; 2], [f64; 2], f64), at: DVec2) -> f64 {
    let axis = DVec2::from(tip) - DVec2::from(base);
    let from_base = at - DVec2::from(base);
    let along = axis.dot(from_base) / axis.length_squared();
    let across = axis.perp_dot(from_base).abs() / axis.length();
    let slope = 4.0 * half_width * (1.0 - 2.0 * along) / axis.length();
    (4.0 * half_width * along * (1.0 - along) - across) / (1.0 + slope * slope).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// About half of the texture is opaque at a cutoff of ½, its border is empty, and few texels lie on an edge.
    #[test]
    fn a_sprig_fills_half_a_card() {
        let sprig = sprig();
        let share = |is: &dyn Fn(u8) -> bool| {
            sprig.texels.iter().filter(|texel| is(**texel)).count() as f64 / sprig.texels.len() as f64
        };
        let opaque = share(&|texel| texel >= 128);
        assert!((0.45..0.55).contains(&opaque), "{opaque}");
        let edge = share(&|texel| texel > 0 && texel < 255);
        assert!((0.05..0.15).contains(&edge), "{edge}");
        for (i, texel) in (0..).zip(&sprig.texels) {
            let at_border = [i % SIDE, i / SIDE].iter().any(|at| *at == 0 || *at == SIDE - 1);
            assert!(!at_border || *texel == 0, "texel {i}");
        }
    }
}
