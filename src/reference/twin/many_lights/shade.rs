//! Twin of the blur in glsl/shading/many_lights/shade.comp: weights are added one by one, separately for each light.

use super::frame::Frame;
use crate::reference::twin::packed_normal::{NORMAL_UNIT, along_normal, same_normal};

/// The buffers of a frame read by the blur.
pub struct Found<'a> {
    /// z (as bits) and packed normal of each pixel.
    pub geometry: &'a [[u32; 2]],
    /// One bit per light and pixel, set if the pixel is shadowed: the first words of all pixels, then all second words, and so on.
    pub shadows: &'a [u32],
    /// Shadows of the previous frame, in the same layout.
    pub shadows_before: &'a [u32],
    /// The pixel that showed each pixel's surface in the previous frame, or [`u32::MAX`]; empty without a history.
    pub sources: &'a [u32],
}

/// Returns how much of a light reaches each pixel, averaged over pixels of the same surface up to `reach` pixels away.
pub fn visibility(frame: &Frame, found: &Found, light: usize, reach: i32) -> Vec<f32> {
    let [width, height] = [frame.camera.width as i32, frame.camera.height as i32];
    let pixels = (width * height) as usize;
    let bit = |words: &[u32], pixel: usize| words[light / 32 * pixels + pixel] >> (light % 32) & 1;
    let one = |pixel: usize| {
        let at = [pixel as i32 % width, pixel as i32 / width];
        let (mut shadowed, mut all) = (0, 0);
        for (x, y) in (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y))) {
            let [to_x, to_y] = [at[0] + x, at[1] + y];
            let other = (to_y * width + to_x) as usize;
            let is_inside = (0..width).contains(&to_x) && (0..height).contains(&to_y);
            if !is_inside || !is_same_surface(frame, found.geometry, [pixel, other], [x, y]) {
                continue;
            }
            let weight = [x, y].map(|by| if by.abs() < 2 { 2 } else { 1 }).iter().product::<u32>();
            shadowed += weight * bit(found.shadows, other);
            all += weight;
            if let Some(source) = found.sources.get(other).filter(|source| **source != u32::MAX) {
                shadowed += weight * bit(found.shadows_before, *source as usize);
                all += weight;
            }
        }
        1.0 - shadowed as f32 / all.max(1) as f32
    };
    (0..pixels).map(one).collect()
}

/// Returns whether a pixel and the pixel `other`, which is `by` pixels away, see the same surface.
pub(in crate::reference::twin) fn is_same_surface(
    frame: &Frame,
    geometry: &[[u32; 2]],
    [pixel, other]: [usize; 2],
    by: [i32; 2],
) -> bool {
    let [z, normal] = geometry[pixel];
    let [other_z, other_normal] = geometry[other];
    let (z, other_z) = (f32::from_bits(z), f32::from_bits(other_z));
    let width = frame.camera.width;
    let along = |vector: [f32; 3]| along_normal(normal, vector);
    let away = along(frame.direction([pixel as u32 % width, pixel as u32 / width]));
    let there = away + by[0] as f32 * along(frame.across) + by[1] as f32 * along(frame.down);
    let off = other_z * there - z * away;
    let tolerance = NORMAL_UNIT as f32 * frame.edge * z;
    pixel == other || other_z > 0.0 && same_normal(normal, other_normal) && off.abs() <= tolerance
}
