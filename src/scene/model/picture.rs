//! A picture in linear light.

/// The background of pictures, linear RGB.
pub const SKY: [f32; 3] = [0.16, 0.22, 0.32];

/// A camera's picture, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width, in pixels.
    pub width: u32,
    /// Height, in pixels.
    pub height: u32,
    /// Pixels in linear RGB, not clamped.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// Returns display-referred sRGB in [0, 1], three numbers per pixel.
    pub fn to_srgb(&self) -> Vec<f32> {
        self.pixels.iter().flatten().map(|c| encode(*c)).collect()
    }

    /// Returns sRGB with eight bits per channel.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.to_srgb().iter().map(|c| (c * 255.0).round() as u8).collect()
    }
}

/// Encodes a linear value as sRGB (IEC 61966-2-1).
fn encode(linear: f32) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}
