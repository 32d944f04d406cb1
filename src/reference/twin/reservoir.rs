//! Twin of glsl/shading/reservoir/: which lights a pixel draws, which one it keeps, and its weight.

/// Number of candidate lights that a pixel draws per frame. Twin: CANDIDATES.
pub const CANDIDATES: u32 = 16;

/// Maximum number of earlier frames that a reservoir may represent. Twin: MOST_FRAMES.
pub const MOST_FRAMES: u32 = 20;

/// Twin: hashed.
pub fn hashed(bits: u32) -> u32 {
    let state = bits.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Twin: pixel_seed.
pub fn pixel_seed(pixel: u32, frame: u32) -> u32 {
    hashed(hashed(pixel).wrapping_add(frame))
}

/// Twin: random_bits.
pub fn random_bits(seed: u32, i: u32) -> u32 {
    hashed(seed.wrapping_add(i))
}

/// Twin: random_share.
pub fn random_share(bits: u32) -> f32 {
    ((bits >> 8) as f32 + 0.5) / 16_777_216.0
}

/// Twin: candidate_light.
pub fn candidate_light(bits: u32, i: u32, candidates: u32, lights: u32) -> u32 {
    let place = ((u64::from(bits) * u64::from(lights)) >> 32) as u32;
    (i * lights + place) / candidates
}

/// The light that a pixel keeps, and its weight. Twin: Reservoir.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reservoir {
    /// The light.
    pub light: u32,
    /// Factor that turns the light reflected from the kept light into an unbiased estimate of the sum over all lights; 0 if no light is
    /// kept.
    pub weight: f32,
    /// Number of frames that the reservoir combines.
    pub frames: u32,
}

/// A pixel's result in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadedReservoir {
    /// The reservoir to keep for the next frame.
    pub kept: Reservoir,
    /// How much of the kept light arrives.
    pub visible: f32,
    /// Smallest distance of a random number from the threshold of its decision. If rounding is larger than this, a device may decide
    /// differently.
    pub margin: f32,
}

/// Runs one frame of a pixel. `old` is the reservoir kept at the surface's position in the previous frame. Three functions take a light's
/// index: `target` returns the light that the pixel would reflect if nothing shadowed it, `visibility` how much of the light arrives, and
/// `reached` whether the light lit the surface in the previous frame. Twin: ask.comp.
pub fn ask(
    seed: u32,
    lights: u32,
    old: Option<Reservoir>,
    target: impl Fn(u32) -> f32,
    visibility: impl Fn(u32) -> f32,
    reached: impl Fn(u32) -> bool,
) -> ShadedReservoir {
    let (mut light, mut own, mut sum, mut margin) = (0, 0.0, 0.0, 1.0f32);
    let mut decide = |share: f32, part: f32, all: f32| {
        if all > 0.0 {
            margin = margin.min((share - part / all).abs());
        }
        share * all < part
    };
    for i in (0..CANDIDATES).filter(|_| lights > 0) {
        let candidate = candidate_light(random_bits(seed, 2 * i), i, CANDIDATES, lights);
        let one = target(candidate);
        sum += one;
        if decide(random_share(random_bits(seed, 2 * i + 1)), one, sum) {
            (light, own) = (candidate, one);
        }
    }
    let mut visible = if own > 0.0 { visibility(light) } else { 0.0 };
    let mut weight = if visible > 0.0 { sum * (lights as f32 / CANDIDATES as f32) / own } else { 0.0 };
    let mut frames = 1;
    if let Some(old) = old {
        let before = old.frames.min(MOST_FRAMES);
        frames += before;
        let other = if old.weight > 0.0 { target(old.light) } else { 0.0 };
        let old_part = before as f32 * other * old.weight;
        let all = own * weight + old_part;
        let is_old = decide(random_share(random_bits(seed, 2 * CANDIDATES)), old_part, all);
        if is_old {
            (light, own) = (old.light, other);
            visible = visibility(light);
        }
        let mut could = if is_old { before } else { 0 } + u32::from(visible > 0.0);
        if !is_old && visible > 0.0 && reached(light) {
            could += before;
        }
        weight = if visible > 0.0 { all / (could as f32 * own) } else { 0.0 };
    }
    ShadedReservoir { kept: Reservoir { light, weight, frames }, visible, margin }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over all candidates, each light is drawn equally often, for any number of lights.
    #[test]
    fn each_light_is_drawn_as_often() {
        for lights in (1..=70).chain([1000, 1023, 4096]) {
            let mut drawn = vec![0; lights as usize];
            for i in 0..CANDIDATES {
                for place in 0..lights {
                    // The centre of the range of random bits that leads to this position.
                    let bits = ((2 * u64::from(place) + 1) << 31) / u64::from(lights);
                    drawn[candidate_light(bits as u32, i, CANDIDATES, lights) as usize] += 1;
                }
            }
            assert!(drawn.iter().all(|count| *count == CANDIDATES), "{lights} lights: {drawn:?}");
        }
    }

    /// Random numbers are spread evenly over neighbouring pixels, over successive frames, and within one pixel and frame.
    #[test]
    fn shares_are_even() {
        let of = |at: &dyn Fn(u32) -> u32| {
            let mut counts = [0i32; 64];
            (0..64_000).for_each(|i| counts[(64.0 * random_share(at(i))).min(63.0) as usize] += 1);
            counts.iter().map(|count| f64::from(count - 1000).powi(2) / 1000.0).sum::<f64>()
        };
        // χ² of 63 degrees of freedom is below 110 in 999.7 of 1,000 cases.
        for chi in [
            of(&|i| random_bits(pixel_seed(i, 0), 0)),
            of(&|i| random_bits(pixel_seed(7, i), 3)),
            of(&|i| random_bits(pixel_seed(9, 9), i)),
        ] {
            assert!(chi < 110.0, "{chi}");
        }
    }

    /// Returns how much a pixel reflects of light number `light` in a frame. This result and the result of [`visibility`] change from frame
    /// to frame, so that a kept light may no longer reach the pixel.
    fn target(frame: u32, light: u32) -> f32 {
        let lit = !(light + frame).is_multiple_of(5);
        if lit { 0.1 + ((light * 7 + frame * 3) % 11) as f32 } else { 0.0 }
    }

    fn visibility(frame: u32, light: u32) -> f32 {
        [0.0, 1.0, 1.0, 0.25][((light / 3 + frame) % 4) as usize]
    }

    /// In every frame the mean over many runs is the sum over all lights, within five standard errors, although light and visibility change
    /// between frames. A kept light must count only the frames in which it could have been drawn; otherwise the mean would be wrong.
    #[test]
    fn the_mean_is_the_sum_over_all_lights() {
        const RUNS: u32 = 40_000;
        const FRAMES: u32 = 5;
        for lights in [1, 3, 16, 50] {
            let (mut sums, mut squares) = ([0.0f64; FRAMES as usize], [0.0f64; FRAMES as usize]);
            for run in 0..RUNS {
                let mut old = None;
                for frame in 0..FRAMES {
                    let reached = |light| target(frame - 1, light) > 0.0 && visibility(frame - 1, light) > 0.0;
                    let seed = pixel_seed(run, frame);
                    let asked = ask(seed, lights, old, |i| target(frame, i), |i| visibility(frame, i), reached);
                    let found = f64::from(asked.visible * target(frame, asked.kept.light) * asked.kept.weight);
                    sums[frame as usize] += found;
                    squares[frame as usize] += found * found;
                    old = Some(asked.kept);
                }
            }
            for frame in 0..FRAMES {
                let all: f32 = (0..lights).map(|i| target(frame, i) * visibility(frame, i)).sum();
                let mean = sums[frame as usize] / f64::from(RUNS);
                let error = ((squares[frame as usize] / f64::from(RUNS) - mean * mean) / f64::from(RUNS)).sqrt();
                let off = mean - f64::from(all);
                assert!(
                    off.abs() <= 5.0 * error + 1e-5 * mean,
                    "{lights} lights, frame {frame}: {mean}, not {all} ± {error}"
                );
            }
        }
    }
}
