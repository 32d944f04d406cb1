//! How far a picture is from the reference picture, as a person sees it.

use super::ImageError;
use crate::scene::Picture;

/// RMSE of the display-referred numbers, and the mean of FLIP (Andersson et al. 2020) at its usual 67 pixels a degree.
/// Both pictures have the same size.
pub fn picture_error(picture: &Picture, reference: &Picture) -> ImageError {
    let (a, b) = (picture.to_srgb(), reference.to_srgb());
    let square: f64 = a.iter().zip(&b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let image = |p: &Picture| nv_flip::FlipImageRgb8::with_data(p.width, p.height, &p.to_srgb8());
    let map = nv_flip::flip(image(reference), image(picture), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    let values = map.to_vec();
    ImageError {
        rmse: (square / a.len().max(1) as f64).sqrt(),
        flip_mean: values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len().max(1) as f64,
    }
}

/// The difference, eight times enlarged, as a picture: grey is none, brighter is too bright.
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
}
