//! CPU twins: a file a GPU pass that computes something, in f32 as on the device. [`vertex_lit`] is in f64, since it asks
//! the truth for light, and so is what [`indirect`] knows of patches.

pub mod area;
pub mod avsm;
pub mod beer_shadow_map;
pub mod bins;
pub mod compact;
pub mod cone;
pub mod deep_shadow_map;
pub mod detail;
pub mod exact;
pub mod filter;
pub mod fit;
pub mod fourier;
pub mod gather;
pub mod gbuffer;
pub mod grid;
pub mod half_angle;
pub mod harmonics;
pub mod indirect;
pub mod interleaved;
pub mod ism;
pub mod layers;
pub mod lists;
pub mod many_lights;
pub mod masks;
pub mod media;
pub mod moments;
pub mod opaque;
pub mod order;
pub mod packed_normal;
pub mod psm;
pub mod ray_query;
pub mod receiver;
pub mod reservoir;
mod roots;
pub mod segment;
pub mod shadow_map;
pub mod simulate;
pub mod stochastic;
#[cfg(test)]
mod sum_checks;
pub mod sums;
pub mod texel_sums;
pub mod translucency_map;
pub mod vertex_lit;
pub mod voxelized;
pub mod wavelet;
