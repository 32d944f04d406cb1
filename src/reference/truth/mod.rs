//! The truth, against which techniques are measured: how much of each light reaches each point, in f64.

mod alpha;
mod backdrop;
mod bounce;
mod boundary;
mod casters;
mod fog;
mod grid;
mod limit;
mod meshes;
mod picture;
mod points;
mod seen;
mod seen_points;
mod shaft;
mod shown;
pub(super) mod splat;
mod surface;
mod true_curve;
mod tube;
mod volume;

pub use backdrop::{ground_faded, sky_color};
pub use bounce::{Bounce, bounce};
pub use casters::Casters;
pub use fog::fog;
pub use limit::{LIMIT_TEXELS, limit_mean_abs, limit_steps};
pub use meshes::{Hit, Meshes};
pub(super) use picture::{camera_rays, lift, light, lit_surface};
pub use picture::{picture, picture_rows, picture_tries, shown_picture, shown_rows};
pub use points::{MAP_DEPTHS, MapTruth, bounds, map_truths, points_outside, points_within, sample_maps, space_points};
pub use seen_points::{SeenPoint, SeenQuery, seen_points, seen_queries};
pub use shown::{filmic, tonemapped};
pub use surface::{SurfacePoint, surface_points};
pub use true_curve::TrueCurve;
