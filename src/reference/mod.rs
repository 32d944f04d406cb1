//! The truth in f64, and a CPU twin in f32 of each GPU pass that computes something. Never touches the GPU.

pub mod avsm;
pub mod bins;
mod casters;
pub mod cells;
pub mod filter;
mod grid;
mod limit;
pub mod list;
mod meshes;
pub mod packed;
mod picture;
mod points;
pub mod psm;
pub mod sums;
mod true_curve;
pub mod vertex_lit;

pub use casters::Casters;
pub use limit::{LIMIT_TEXELS, limit_mean_abs};
pub use meshes::{Hit, Meshes};
pub use picture::{SKY, far_to_near, picture};
pub use points::{MAP_DEPTHS, MapTruth, map_truths, space_points};
pub use true_curve::TrueCurve;
