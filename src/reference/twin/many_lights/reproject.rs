//! Twin of glsl/shading/many_lights/reproject.comp.

use super::frame::Frame;
use crate::reference::twin::packed_normal::{NORMAL_UNIT, along_normal, same_normal};

/// The pixel that showed a pixel's surface in the previous frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Index of that pixel, if the surface was visible there.
    pub index: Option<u32>,
    /// Distance to the nearest border between two pixels, in pixels. If it is smaller than the rounding error, the device may pick the
    /// neighbouring pixel.
    pub margin: f32,
}

/// Returns the source of each pixel. `now` and `before` hold, for each pixel, the surface that it shows in this frame and in the previous
/// one: z as bits, and the packed normal.
pub fn reproject(frames: &[Frame; 2], now: &[[u32; 2]], before: &[[u32; 2]]) -> Vec<Source> {
    let width = frames[0].camera.width;
    let pixel = |i: u32| source(frames, [i % width, i / width], now[i as usize], before);
    (0..now.len() as u32).map(pixel).collect()
}

fn source([now, was]: &[Frame; 2], pixel: [u32; 2], [z, normal]: [u32; 2], before: &[[u32; 2]]) -> Source {
    let nowhere = Source { index: None, margin: 1.0 };
    if z == 0 {
        return nowhere;
    }
    let (z, ray, camera) = (f32::from_bits(z), now.direction(pixel), &was.camera);
    let offset: [f32; 3] = std::array::from_fn(|i| (now.camera.origin[i] + z * ray[i]) - camera.origin[i]);
    let along = |axis: [f32; 3]| offset[0] * axis[0] + offset[1] * axis[1] + offset[2] * axis[2];
    let ahead = along(camera.forward);
    if ahead <= camera.near {
        return nowhere;
    }
    let ndc = [along(camera.right) * camera.scale_x, along(camera.up) * camera.scale_y].map(|c| c / ahead);
    let size = [camera.width, camera.height];
    let texel = [0, 1].map(|i| (0.5 * ndc[i] + 0.5) * size[i] as f32);
    let margin = texel.iter().map(|t| (t - t.round()).abs()).fold(1.0, f32::min);
    if (0..2).any(|i| texel[i] < 0.0 || texel[i] >= size[i] as f32) {
        return Source { index: None, margin };
    }
    let place = texel.map(|t| t as u32);
    let index = place[1] * size[0] + place[0];
    let [there_z, there_normal] = before[index as usize];
    let ray = was.direction(place);
    let between: [f32; 3] = std::array::from_fn(|i| offset[i] - f32::from_bits(there_z) * ray[i]);
    let is_near = along_normal(normal, between).abs() <= NORMAL_UNIT as f32 * was.edge * ahead;
    let is_same = there_z != 0 && same_normal(normal, there_normal) && is_near;
    Source { index: is_same.then_some(index), margin }
}
