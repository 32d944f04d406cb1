//! How far answers and pictures are from the truth.

pub(super) mod caster_error;
pub(super) mod color;
pub(super) mod error_metrics;
pub(super) mod flicker;
pub(super) mod footprint;
pub(super) mod light_ray;
pub(super) mod picture_error;
pub(super) mod seen;
pub(super) mod spearman;
