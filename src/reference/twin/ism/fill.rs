//! Twin of glsl/technique/ism/fill.glsl.

use super::map::{Levels, texel_place};

/// Twin: WIDE.
const WIDE: f32 = 8.0;

/// Twin: texel_wide.
fn texel_wide(side: i32, texel: [i32; 2]) -> f32 {
    let [x, y] = texel_place(side, texel);
    4.0 / ((1.0 + (x * x + y * y)) * side as f32)
}

fn texels(side: i32) -> impl Iterator<Item = [i32; 2]> {
    (0..side).flat_map(move |y| (0..side).map(move |x| [x, y]))
}

/// Twin: wide_down.
pub fn wide_down(map: &mut Levels) {
    for level in (0..map.levels.len() - 1).rev() {
        for texel in texels(map.side(level)) {
            let nearest = map.get(level, texel).min(map.get(level + 1, texel.map(|t| t / 2)));
            map.set(level, texel, nearest);
        }
    }
}

/// Twin: SURROUNDED.
const SURROUNDED: f32 = 13.0;

/// Twin: mean_of.
fn mean_of(distances: [f32; 4], weights: [f32; 4], least: f32, wide: f32, radius: f32) -> f32 {
    let nearest = distances.into_iter().fold(f32::INFINITY, f32::min);
    let last = nearest + 2.0 * (radius + wide * nearest);
    let (mut sum, mut weight) = (0.0, 0.0);
    for (distance, w) in distances.into_iter().zip(weights) {
        if distance <= last && distance <= 3e38 {
            sum += w * distance;
            weight += w;
        }
    }
    if weight >= least { (sum / weight).max(nearest) } else { f32::INFINITY }
}

/// Twin: pull.
pub fn pull(map: &mut Levels, radius: f32) {
    for level in 1..map.levels.len() {
        for texel in texels(map.side(level)) {
            let [x, y] = texel.map(|t| 2 * t);
            let four = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|t| map.get(level - 1, t));
            let wide = texel_wide(map.side(level), texel);
            let mean = mean_of(four, [1.0; 4], 1.0, wide, radius);
            let kept = mean * wide <= WIDE * radius;
            map.set(level, texel, if kept { mean } else { f32::INFINITY });
        }
    }
}

/// Twin: push.
pub fn push(map: &mut Levels, radius: f32) {
    for level in (0..map.levels.len() - 1).rev() {
        let last = map.side(level + 1) - 1;
        for texel in texels(map.side(level)) {
            if map.get(level, texel).is_finite() {
                continue;
            }
            let about = texel.map(|t| t / 2);
            let beside = texel.map(|t| (t / 2 + 2 * (t & 1) - 1).clamp(0, last));
            let four = [about, [beside[0], about[1]], [about[0], beside[1]], beside];
            let (four, wide) = (four.map(|t| map.get(level + 1, t)), texel_wide(map.side(level), texel));
            map.set(level, texel, mean_of(four, [9.0, 3.0, 3.0, 1.0], SURROUNDED, wide, radius));
        }
    }
}

/// Fills the holes of a map: pull, then push. Twin: glsl/technique/ism/fill.comp.
pub fn fill(map: &mut Levels, radius: f32) {
    pull(map, radius);
    push(map, radius);
}
