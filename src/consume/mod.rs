//! Whoever needs the answer: the point query, the depth slice, the shaded picture (of many lights in tiles, a part of them or one
//! a pixel) and fog before it. They know no technique, only its [`crate::technique::Answer`].

mod fog;
mod gbuffer;
mod half;
mod interleaved;
mod lighting;
pub mod many_lights;
mod picture;
mod points;
mod query;
mod reservoir;
mod settings;
mod shading;
mod slice;
mod sliced;
mod steps;

pub use fog::FogKernel;
pub use interleaved::PartsSeen;
pub use lighting::{Lighting, VERTEX_SPACING};
pub use picture::{Kernels, Renderer};
pub use points::{Colours, Points};
pub use query::{Asked, Query, QueryKernel};
pub use reservoir::ReservoirData;
pub use settings::{DitherKind, KEYS, LightingKind, ShadingKind, ShadingSettings, ShadowsKind, keys, parse, runs};
pub use shading::{Shading, Tiled};
pub use slice::{Slice, slice};
pub use steps::StepsKernel;
