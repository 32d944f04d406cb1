//! Whoever needs the answer: the point query, the depth slice and the shaded picture. They know no technique, only its
//! [`crate::technique::Answer`].

mod lighting;
mod picture;
mod query;
mod slice;

pub use lighting::{Lighting, VERTEX_SPACING};
pub use picture::{Kernels, Renderer, Shading};
pub use query::{Query, QueryKernel};
pub use slice::slice;
