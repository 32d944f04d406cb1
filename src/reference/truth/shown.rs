//! The finished picture for viewing, made from a picture with many samples per pixel. Samples are averaged in linear light; then the tone
//! curve [`filmic`] is applied to the mean. Twin: glsl/shading/tonemap.comp.

use crate::scene::{Picture, Show};
use glam::DVec3;

/// Applies the filmic tone curve, from linear light to a linear value from 0 to 1. Source: Narkowicz 2016, ACES filmic tone mapping curve.
pub fn filmic(light: f64) -> f64 {
    let x = light.clamp(0.0, 1e6);
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

/// Averages and tone-maps a picture that has one pixel per sample.
pub fn tonemapped(samples: &Picture, show: &Show) -> Picture {
    let [columns, rows] = show.grid;
    let (width, height) = (samples.width / columns, samples.height / rows);
    let exposure = f64::from(show.stops).exp2();
    let pixel = |i: u32| {
        let (x, y) = (i % width * columns, i / width * rows);
        let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (x + column, y + row)));
        let sum: DVec3 =
            all.map(|(x, y)| DVec3::from(samples.pixels[(y * samples.width + x) as usize].map(f64::from))).sum();
        (sum / f64::from(columns * rows)).to_array().map(|light| filmic(exposure * light) as f32)
    };
    Picture { width, height, pixels: (0..width * height).map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Black stays black, white leaves headroom, more light is never darker, and nothing exceeds white.
    #[test]
    fn the_curve_rises_from_black_to_white() {
        assert_eq!(filmic(0.0), 0.0);
        assert!(filmic(1.0) > 0.75 && filmic(1.0) < 0.85, "{}", filmic(1.0));
        let curve: Vec<f64> = (-30..30).map(|i| filmic(f64::from(i).exp2())).collect();
        assert!(curve.windows(2).all(|two| two[0] <= two[1]) && curve[59] == 1.0);
        assert_eq!(filmic(f64::INFINITY), 1.0);
    }

    /// Half of the samples are black and half are white. They are averaged first, and the tone curve is applied to the mean.
    #[test]
    fn samples_are_averaged_in_linear_light() {
        let pixels = vec![[0.0; 3], [1.0; 3], [1.0; 3], [0.0; 3]];
        let shown = tonemapped(&Picture { width: 2, height: 2, pixels }, &Show::new(4, 1.0).expect("four"));
        assert_eq!((shown.width, shown.height), (1, 1));
        assert_eq!(shown.pixels[0], [filmic(1.0) as f32; 3]);
    }
}
