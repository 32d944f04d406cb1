//! CPU twin of glsl/maps/filter.glsl: the texels that a look-up averages and their weights, in f32.

use glam::{IVec2, Vec2};

/// Twin: FILTER and FILTER_RADIUS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The four texels around the position.
    Bilinear,
    /// Each texel, weighted by the fraction of its area inside a square that extends this many texels from the position.
    Box(u32),
    /// The weight of [`Filter::Box`] times a Gaussian whose standard deviation is half the radius.
    Gaussian(u32),
}

impl Filter {
    /// Returns the texels around the point `at` (in texels) of a map of `size` texels, row by row, with their weights. Texels may lie
    /// outside the map. The weights sum to 1.
    pub fn weights(self, size: Vec2, at: Vec2) -> Vec<(IVec2, f32)> {
        let (across, before, reach) = match self {
            Self::Bilinear => (2, 0.5, 2.0),
            Self::Box(radius) | Self::Gaussian(radius) => (2 * radius + 1, radius as f32, radius as f32 + 2.0),
        };
        let at = at.clamp(Vec2::splat(-reach), size + reach) - before;
        let corner = at.floor();
        let axis: Vec<Vec2> = (0..across).map(|i| self.axis(i, at - corner)).collect();
        let sum: Vec2 = axis.iter().copied().sum();
        let total = if self == Self::Bilinear { 1.0 } else { sum.x * sum.y };
        let texel = |x: u32, y: u32| {
            (corner.as_ivec2() + IVec2::new(x as i32, y as i32), axis[x as usize].x * axis[y as usize].y / total)
        };
        (0..across).flat_map(|y| (0..across).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect()
    }

    /// Twin: filter_axis.
    fn axis(self, i: u32, rest: Vec2) -> Vec2 {
        match self {
            Self::Bilinear => {
                if i == 0 {
                    1.0 - rest
                } else {
                    rest
                }
            }
            Self::Box(radius) | Self::Gaussian(radius) => {
                let radius = radius as f32;
                let distance = (i as f32 + 0.5 - radius - rest).abs();
                let share = (radius + 0.5 - distance).clamp(Vec2::ZERO, Vec2::ONE);
                if matches!(self, Self::Box(_)) {
                    return share;
                }
                share * (-2.0 * distance * distance / (radius * radius)).exp()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn filter(kind: u32, radius: u32) -> Filter {
        [Filter::Bilinear, Filter::Box(radius), Filter::Gaussian(radius)][kind as usize]
    }

    proptest! {
        /// Weights sum to 1, their mean position is the given position, and they change continuously as the position moves. (The box moves
        /// with the position; if it were cut to whole texels, its mean would be off.)
        #[test]
        fn weights_are_a_mean_about_the_position(
            kind in 0u32..3, radius in 1u32..=8, x in 0.0f32..16.0, y in 0.0f32..16.0, step in 0.0f32..1e-3,
        ) {
            let filter = filter(kind, radius);
            let (size, at) = (Vec2::splat(16.0), Vec2::new(x, y));
            let weights = filter.weights(size, at);
            prop_assert!(weights.iter().all(|(_, w)| (0.0..=1.0).contains(w)));
            prop_assert!((weights.iter().map(|(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-5);
            if !matches!(filter, Filter::Gaussian(_)) {
                let mean: Vec2 = weights.iter().map(|(t, w)| (t.as_vec2() + 0.5) * *w).sum();
                prop_assert!((mean - at).abs().max_element() < 1e-4, "{mean} is not {at}");
            }
            let moved = filter.weights(size, at + step);
            let of = |weights: &[(IVec2, f32)], t: IVec2| weights.iter().find(|w| w.0 == t).map_or(0.0, |w| w.1);
            for texel in weights.iter().chain(&moved).map(|w| w.0) {
                // A weight is a product of two factors, each of which changes by at most 3 per texel.
                let change = (of(&weights, texel) - of(&moved, texel)).abs();
                prop_assert!(change <= 6.0 * step + 1e-5, "{texel} changes by {change} over {step}");
            }
        }
    }

    /// Expected by hand: a box of radius 1 around a texel's centre covers half of the texel on each side.
    #[test]
    fn a_box_about_a_texel_centre() {
        let weights = Filter::Box(1).weights(Vec2::splat(8.0), Vec2::splat(3.5));
        let expected = [1.0, 2.0, 1.0, 2.0, 4.0, 2.0, 1.0, 2.0, 1.0].map(|w: f32| w / 16.0);
        assert_eq!(weights.iter().map(|w| w.1).collect::<Vec<_>>(), expected);
        assert_eq!(weights[0].0, IVec2::splat(2));
    }
}
