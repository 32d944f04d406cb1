//! Smaller levels of textures that cut holes, for maps whose texels are larger than the texture's. A level holds, per texel, the share of
//! its area that blocks light at level 0, and a threshold: where the share, interpolated, is at least the threshold, as much of the level
//! blocks light as of level 0. Plain levels of alpha, compared with the cutoff, would not keep that. Sources: Castaño 2010, Computing Alpha
//! Mipmaps (coverage that is kept); Wyman and McGuire 2017, Hashed Alpha Testing (shares as probabilities).

use crate::scene::{AlphaTexture, Wrap};

/// A level of a texture, half as large as the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaLevel {
    /// The share of each texel that blocks light, 255 for all of it.
    pub shares: AlphaTexture,
    /// Least share that blocks light, in [0, 1]; 2 if nothing does.
    pub threshold: f32,
}

/// Width or height, in texels, at which levels end: smaller ones have no shape that a threshold could cut out. Twin: ALPHA_LAST_LEVEL.
const SMALLEST: u32 = 8;
/// Bins of the shares by which a threshold is found.
const BINS: usize = 4096;
/// A threshold is found from at least this many points of a level, if it needs no more than 16 × 16 of a texel.
const POINTS: usize = 1 << 16;

/// Returns the levels of a texture from level 1 on, down to [`SMALLEST`]; none for a smaller texture.
pub fn alpha_levels(texture: &AlphaTexture, cutoff: f32) -> Vec<AlphaLevel> {
    let blocks = |alpha: &u8| if f64::from(*alpha) / 255.0 + 1e-6 >= f64::from(cutoff) { 1.0 } else { 0.0 };
    let mut shares: Vec<f32> = texture.texels.iter().map(blocks).collect();
    let all: f64 = shares.iter().map(|share| f64::from(*share)).sum();
    let coverage = all / shares.len().max(1) as f64;
    let mut size = texture.size;
    let mut levels = Vec::new();
    while size[0].max(size[1]) >= 2 * SMALLEST {
        let smaller = size.map(|side| (side / 2).max(1));
        shares = shrunk(&shares, size, smaller);
        size = smaller;
        let texels = shares.iter().map(|share| (255.0 * share).round() as u8).collect();
        let shares = AlphaTexture { size, wrap: texture.wrap, texels };
        let threshold = threshold(&shares, coverage);
        levels.push(AlphaLevel { shares, threshold });
    }
    levels
}

/// Returns the weights by which the texels of a row of `from` texels make up texel `at` of a row of `to`.
fn weights(at: u32, from: u32, to: u32) -> impl Iterator<Item = (u32, f32)> {
    let per = f64::from(from) / f64::from(to);
    let (low, high) = (per * f64::from(at), per * f64::from(at + 1));
    (low as u32..(high.ceil() as u32).min(from)).map(move |texel| {
        let covered = high.min(f64::from(texel + 1)) - low.max(f64::from(texel));
        (texel, (covered / per) as f32)
    })
}

fn shrunk(shares: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    let texel = |x: u32, y: u32| -> f32 {
        let row = |y: u32| -> f32 {
            weights(x, from[0], to[0])
                .map(|(x, weight)| weight * shares[y as usize * from[0] as usize + x as usize])
                .sum()
        };
        weights(y, from[1], to[1]).map(|(y, weight)| weight * row(y)).sum()
    };
    (0..to[1]).flat_map(|y| (0..to[0]).map(move |x| texel(x, y))).collect()
}

/// Returns the threshold at which a share of about `coverage` of a level blocks light.
fn threshold(level: &AlphaTexture, coverage: f64) -> f32 {
    let [width, height] = level.size.map(|side| side as usize);
    // An even number, so that no point is at a texel's centre, where the share is that of no area.
    let each = (2..16).step_by(2).find(|each| each * each * width * height >= POINTS).unwrap_or(16);
    let mut bins = vec![0_u64; BINS + 1];
    for y in 0..height * each {
        for x in 0..width * each {
            let at = [x, y].map(|at| (at as f32 + 0.5) / each as f32 - 0.5);
            bins[(bilinear(level, at) * BINS as f32) as usize] += 1;
        }
    }
    let wanted = coverage * (width * height * each * each) as f64;
    if wanted == 0.0 {
        return 2.0;
    }
    // The middle of the thresholds whose count is the nearest.
    let (mut above, mut best, mut off) = (0.0, None, wanted);
    for bin in (0..=BINS).rev() {
        above += bins[bin] as f64;
        match best {
            Some((first, _)) if bins[bin] == 0 && (above - wanted).abs() == off => best = Some((first, bin)),
            _ if (above - wanted).abs() < off => (best, off) = (Some((bin, bin)), (above - wanted).abs()),
            _ => {}
        }
    }
    best.map_or(2.0, |(first, last)| 0.5 * (first + last) as f32 / BINS as f32)
}

/// Returns the share at a place, in texels from the centre of the first one.
fn bilinear(level: &AlphaTexture, at: [f32; 2]) -> f32 {
    let low = at.map(f32::floor);
    let [x, y] = [0, 1]
        .map(|axis| [low[axis] as i64, low[axis] as i64 + 1].map(|at| wrapped(at, level.size[axis], level.wrap[axis])));
    let texel = |x: usize, y: usize| f32::from(level.texels[y * level.size[0] as usize + x]);
    let [right, down] = [0, 1].map(|axis| at[axis] - low[axis]);
    let row = |y: usize| texel(x[0], y) + right * (texel(x[1], y) - texel(x[0], y));
    ((row(y[0]) + down * (row(y[1]) - row(y[0]))) / 255.0).clamp(0.0, 1.0)
}

fn wrapped(at: i64, size: u32, wrap: Wrap) -> usize {
    let size = i64::from(size);
    let at = match wrap {
        Wrap::Repeat => at.rem_euclid(size),
        Wrap::Mirror => {
            let within = at.rem_euclid(2 * size);
            within.min(2 * size - 1 - within)
        }
        Wrap::Clamp => at.clamp(0, size - 1),
    };
    at as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Each level has the mean of level 0, within the rounding of its bytes, and blocks as nearly as much of its area as a threshold
        /// can: texels of one share, side by side, all block or none.
        #[test]
        fn levels_keep_what_blocks(
            size in prop::array::uniform2(1u32..80),
            seed in any::<u64>(),
            wrap in prop::sample::select(vec![Wrap::Repeat, Wrap::Mirror, Wrap::Clamp]),
        ) {
            use rand::Rng;
            let mut random = rand_pcg::Pcg32::new(seed, 7);
            let texels: Vec<u8> = (0..size[0] * size[1]).map(|_| random.next_u32() as u8).collect();
            let texture = AlphaTexture { size, wrap: [wrap; 2], texels };
            let coverage = texture.texels.iter().filter(|alpha| **alpha >= 128).count() as f64 / texture.texels.len() as f64;
            let levels = alpha_levels(&texture, 128.0 / 255.0);
            prop_assert_eq!(levels.len() as u32, size[0].max(size[1]).ilog2().saturating_sub(3));
            for level in &levels {
                let mean = level.shares.texels.iter().map(|share| f64::from(*share) / 255.0).sum::<f64>();
                let mean = mean / level.shares.texels.len() as f64;
                prop_assert!((mean - coverage).abs() < 0.01, "{mean}, not {coverage}, at {:?}", level.shares.size);
                if level.shares.size[0].min(level.shares.size[1]) >= 4 {
                    let [width, height] = level.shares.size;
                    let points = (0..24 * height).flat_map(|y| (0..24 * width).map(move |x| [x, y]));
                    let at = points.map(|at| at.map(|at| (at as f32 + 0.5) / 24.0 - 0.5));
                    let mut shares: Vec<f32> = at.map(|at| bilinear(&level.shares, at)).collect();
                    shares.sort_unstable_by(f32::total_cmp);
                    let off = |threshold: f32| {
                        let open = shares.partition_point(|share| *share < threshold);
                        ((shares.len() - open) as f64 / shares.len() as f64 - coverage).abs()
                    };
                    let least = (0..=1000).map(|i| off(i as f32 / 1000.0)).fold(1.0, f64::min);
                    let (found, size) = (off(level.threshold), level.shares.size);
                    prop_assert!(found < least + 0.01, "off by {found}, where {least} is possible, at {size:?}");
                }
            }
        }
    }

    /// Thin stripes: between the texels of level 1 a quarter blocks light, as at level 0. Smaller levels are even, so that no threshold cuts
    /// a quarter out of them; their shares, as probabilities, are right.
    #[test]
    fn thin_stripes_in_closed_form() {
        let stripes = (0..64 * 64).map(|i| if i % 4 == 0 { 255 } else { 0 }).collect();
        let texture = AlphaTexture { size: [64, 64], wrap: [Wrap::Repeat; 2], texels: stripes };
        let levels = alpha_levels(&texture, 0.5);
        assert!(
            levels[1..].iter().all(|level| level.shares.texels.iter().all(|share| *share == 64)),
            "means of a quarter"
        );
        assert!((levels[0].threshold - 0.375).abs() < 0.01, "{}", levels[0].threshold);
    }

    #[test]
    fn what_blocks_nothing_blocks_nothing_smaller() {
        let texture = |alpha: u8| AlphaTexture { size: [32, 32], wrap: [Wrap::Clamp; 2], texels: vec![alpha; 1024] };
        assert!(alpha_levels(&texture(0), 0.5).iter().all(|level| level.threshold == 2.0));
        assert!(alpha_levels(&texture(255), 0.5).iter().all(|level| level.threshold <= 1.0));
        assert_eq!(alpha_levels(&texture(255), 0.5).len(), 2);
    }
}
