//! The benchmark of the rasterizer's benefit: every way of doing the same work gives the same picture.

use crate::support::{gpu_test, skipped};
use gobo::bench::{LAYERS, LayerWay, LayeredPictures, OPACITY, raster_worth};

const SIDE: u32 = 64;

/// Returns the layers blended over black, by definition, in f64.
fn layered(layers: u32) -> [f64; 4] {
    let opacity = f64::from(OPACITY);
    (0..layers).fold([0.0; 4], |behind, layer| {
        let color = [layer & 1, layer >> 1 & 1, layer >> 2 & 1, 1].map(|part| f64::from(part) * opacity);
        [0, 1, 2, 3].map(|i| color[i] + (1.0 - opacity) * behind[i])
    })
}

#[test]
fn layers_are_the_same_each_way() {
    const TEST: &str = "layers_are_the_same_each_way";
    gpu_test(TEST, |context| {
        let pictures = LayeredPictures::new(context, SIDE).expect("pictures");
        for way in [LayerWay::Blended, LayerWay::Computed, LayerWay::Interlocked] {
            let has_interlock =
                context.features().fragment_shader_pixel_interlock && context.features().fragment_stores_and_atomics;
            if way == LayerWay::Interlocked && !has_interlock {
                skipped(TEST, "layers with interlock: needs fragmentShaderPixelInterlock and fragmentStoresAndAtomics");
                continue;
            }
            for layers in [1, 3, LAYERS] {
                pictures.run(way, layers).expect("ran");
                let Some(pixels) = pictures.read(way).expect("read") else { continue };
                let expected = layered(layers);
                let off =
                    |pixel: &[f32; 4]| (0..4).map(|i| (f64::from(pixel[i]) - expected[i]).abs()).fold(0.0, f64::max);
                let worst = pixels.iter().map(off).fold(0.0, f64::max);
                assert!(worst < 1e-6, "{way:?}, {layers} layers: {worst}");
            }
        }
        for work in raster_worth(context).expect("timed") {
            let is_timed = context.features().timestamp_valid_bits > 0 && work.needs.is_none();
            assert_eq!(work.ratio.is_some(), is_timed, "{work:?}");
            assert!(work.ratio.is_none_or(|ratio| ratio > 0.0 && ratio.is_finite()), "{work:?}");
        }
    });
}
