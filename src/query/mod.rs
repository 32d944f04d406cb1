//! Queries to a technique: how much of a light reaches points, or one depth of a light's view. A query knows only the
//! [`crate::technique::Answer`], never which technique it comes from.

mod colored;
mod points;
mod slice;

pub(crate) use colored::colored;
pub use points::{PointBatch, Query, QueryKernel};
pub use slice::{Slice, slice};
