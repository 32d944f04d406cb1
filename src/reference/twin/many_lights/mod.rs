//! CPU twins of glsl/consume/many_lights/: a file per pass that computes, in f32 and to the bit, but for the division by which a place is
//! projected.

pub mod cull;
pub mod dither;
pub mod frame;
pub mod reproject;
pub mod shade;
