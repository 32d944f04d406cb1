//! CPU twins of glsl/shading/many_lights/: one file per pass that computes something, in f32. Bits equal the device's, except where a
//! position is projected by a division.

pub mod cull;
pub mod dither;
pub mod frame;
pub mod reproject;
pub mod shade;
