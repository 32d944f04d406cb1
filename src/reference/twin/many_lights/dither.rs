//! Twin of glsl/shading/many_lights/dither.glsl.

/// Returns the offset at which a pixel queries light with ordered dither. The first number is a position within a step along the ray, the
/// other two are positions across a voxel along two axes; each ranges from 0 to 1. `phase` is the phase in `ManyLightsPush`.
pub fn ordered([x, y]: [u32; 2], phase: u32) -> [f32; 3] {
    // Bayer's 4 × 4 matrix, built from the 2 × 2 one.
    let two = |x: u32, y: u32| [[0, 2], [3, 1]][(y & 1) as usize][(x & 1) as usize];
    let place = 4 * two(x, y) + two(x >> 1, y >> 1);
    [4 * place + phase, 16 * (place % 4) + 4 * phase, 16 * (place / 4) + 4 * phase].map(|part| part as f32 / 64.0)
}

/// Like [`ordered`], but returns an offset from noise.
pub fn noise([x, y]: [u32; 2], phase: u32) -> [f32; 3] {
    // Roberts' R2: multiples of 1 / p and 1 / p², where p³ = p + 1.
    let (a, b) = (3_242_174_889u32, 2_447_445_414u32);
    let half_way = if phase == 3 { 1 << 31 } else { 0 };
    let share = |bits: u32| ((bits >> 8) as f32 + 0.5) / (1 << 24) as f32;
    let along = share(x.wrapping_mul(a).wrapping_add(y.wrapping_mul(b)).wrapping_add(half_way));
    let across = share(x.wrapping_mul(b).wrapping_sub(y.wrapping_mul(a)).wrapping_add(half_way));
    [along, along, across]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of 4 × 4 pixels queries at a different position, and two frames together are evenly spaced. Noise is uniform over many pixels.
    #[test]
    fn places_are_even() {
        let all = |phase: u32| (0..16).map(move |i| ordered([i % 4 + 8, i / 4 + 4], phase));
        let sorted = |values: &mut dyn Iterator<Item = f32>| {
            let mut all: Vec<f32> = values.collect();
            all.sort_by(f32::total_cmp);
            all
        };
        let even = |n: usize| (0..n).map(|i| (i as f32 + 0.5) / n as f32).collect::<Vec<_>>();
        assert_eq!(sorted(&mut all(2).map(|p| p[0])), even(16));
        assert_eq!(sorted(&mut all(1).chain(all(3)).map(|p| p[0])), even(32));
        for i in 0..16 {
            let cell = [i % 4, i / 4].map(|c| (c as f32 + 0.5) / 4.0);
            assert_eq!(all(2).filter(|p| p[1..] == cell).count(), 1, "one per cell of 4 × 4");
        }
        let below = (0..4096).filter(|i| noise([i % 64, i / 64], 2)[0] < 0.25).count();
        assert!((1014..=1034).contains(&below), "{below}");
    }
}
