//! Whoever needs the answer: the point query, the depth slice and the shaded picture. They know no technique, only its
//! [`crate::technique::Visibility`].

mod lighting;
mod picture;
mod query;
mod slice;

pub use lighting::{Lighting, VERTEX_SPACING};
pub use picture::{Pipelines, Renderer, Shading};
pub use query::Query;
pub use slice::slice;

use crate::Result;
use crate::gpu::{Shader, shader};
use crate::technique::Visibility;

/// A shader of glsl/consume/ as built for the technique.
fn built_for(visibility: &Visibility, name: &str) -> Result<&'static Shader> {
    shader(&format!("{}/consume/{name}", visibility.folder))
}
