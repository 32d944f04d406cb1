//! Whoever needs the answer: the point query, the depth slice, the shaded picture and fog before it. They know no technique, only its
//! [`crate::technique::Answer`].

mod fog;
mod lighting;
mod picture;
mod query;
mod slice;
mod steps;

pub use lighting::{Lighting, VERTEX_SPACING};
pub use picture::{Kernels, Renderer, Shading};
pub use query::{Asked, Query, QueryKernel};
pub use slice::slice;
