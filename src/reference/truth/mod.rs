//! The truth: how much of each light reaches each point, in f64, and what techniques are measured against.

mod casters;
mod grid;
mod limit;
mod meshes;
mod picture;
mod points;
mod true_curve;

pub use casters::Casters;
pub use limit::{LIMIT_TEXELS, limit_mean_abs};
pub use meshes::{Hit, Meshes};
pub use picture::picture;
pub(super) use picture::{camera_rays, lift, light};
pub use points::{MAP_DEPTHS, MapTruth, map_truths, space_points};
pub use true_curve::TrueCurve;
