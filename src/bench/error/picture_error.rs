//! Errors of a picture against the reference picture, as a person sees them.

use crate::bench::ImageError;
use crate::reference::truth::Bounce;
use crate::scene::Picture;

/// Returns the RMSE of the display-referred values.
fn rmse(picture: &Picture, reference: &Picture) -> f64 {
    let (a, b) = (picture.to_srgb(), reference.to_srgb());
    let square: f64 = a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (square / a.len().max(1) as f64).sqrt()
}

/// Returns the RMSE of a picture against one bounce of light, and the standard error of that bounce, which is traced with a finite number
/// of directions: half of the RMSE between its two halves.
pub(in crate::bench) fn bounce_error(picture: &Picture, bounce: &Bounce) -> [f64; 2] {
    [rmse(picture, &bounce.picture), 0.5 * rmse(&bounce.halves[0], &bounce.halves[1])]
}

/// Returns the RMSE of the display-referred values, and the mean of FLIP (Andersson et al. 2020) at its usual 67 pixels per degree. Both
/// pictures must have the same size.
pub fn picture_error(picture: &Picture, reference: &Picture) -> ImageError {
    let image = |p: &Picture| nv_flip::FlipImageRgb8::with_data(p.width, p.height, &p.to_srgb8());
    let map = nv_flip::flip(image(reference), image(picture), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    let values = map.to_vec();
    ImageError {
        rmse: rmse(picture, reference),
        flip_mean: values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len().max(1) as f64,
        bounce_rmse: None,
        bounce_noise: None,
    }
}

/// Returns the root mean square, over pixels and channels, of changes between consecutive pictures that do not occur between their
/// references, in display-referred values. `None` for fewer than two pictures. All pictures must have the same size.
pub fn picture_flicker(pictures: &[Picture], references: &[Picture]) -> Option<f64> {
    let off = |(picture, reference): (&Picture, &Picture)| -> Vec<f64> {
        let (a, b) = (picture.to_srgb(), reference.to_srgb());
        a.iter().zip(&b).map(|(a, b)| f64::from(a - b)).collect()
    };
    let off: Vec<_> = pictures.iter().zip(references).map(off).collect();
    let changes: Vec<f64> =
        off.windows(2).flat_map(|two| two[0].iter().zip(&two[1]).map(|(a, b)| (b - a).powi(2))).collect();
    (!changes.is_empty()).then(|| (changes.iter().sum::<f64>() / changes.len() as f64).sqrt())
}

/// Returns the difference, amplified eight times, as a picture: grey means no difference, brighter means too bright.
pub fn difference_srgb8(picture: &Picture, reference: &Picture) -> Vec<u8> {
    let (a, b) = (picture.to_srgb(), reference.to_srgb());
    a.iter().zip(&b).map(|(a, b)| ((0.5 + 8.0 * (a - b)).clamp(0.0, 1.0) * 255.0).round() as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_have_no_error_and_black_against_white_has_all() {
        let gray = |v: f32| Picture { width: 8, height: 8, pixels: vec![[v; 3]; 64] };
        let same = picture_error(&gray(0.3), &gray(0.3));
        assert_eq!((same.rmse, same.flip_mean), (0.0, 0.0));
        let opposite = picture_error(&gray(0.0), &gray(1.0));
        assert!((opposite.rmse - 1.0).abs() < 1e-6, "{}", opposite.rmse);
        assert!(opposite.flip_mean > 0.9, "{}", opposite.flip_mean);
    }

    /// Pictures equal to the truth must have no flicker. The flicker of pictures that stay constant while the truth jumps must be that
    /// jump.
    #[test]
    fn flicker_is_what_the_truth_does_not_change() {
        let gray = |v: f32| Picture { width: 2, height: 2, pixels: vec![[v; 3]; 4] };
        let truth = [0.2, 0.4, 0.2].map(gray);
        assert_eq!(picture_flicker(&truth, &truth), Some(0.0));
        assert_eq!(picture_flicker(&truth[..1], &truth[..1]), None);
        let jump = f64::from(gray(0.4).to_srgb()[0] - gray(0.2).to_srgb()[0]);
        let flickers = [gray(0.2), gray(0.2), gray(0.2)];
        let found = picture_flicker(&flickers, &truth).expect("three frames");
        assert!((found - jump).abs() < 1e-6, "{found}, not {jump}");
    }
}
