//! Consumers of a technique's answers: the point query, the depth slice, the shaded picture (with many lights in tiles, a part of them per
//! pixel, or one per pixel) and fog over it. A consumer knows only the [`crate::technique::Answer`], never which technique it comes from.

mod blending;
mod chunked_draw;
mod colored;
mod display;
mod far_to_near;
mod fog;
mod gbuffer;
mod half;
mod half_angle_draw;
mod interleaved;
mod kernels;
mod lighting;
pub mod many_lights;
mod painter;
mod passes;
mod picture;
mod pictures;
mod points;
mod query;
mod readback;
mod reservoir;
mod settings;
mod shading;
mod slice;
mod steps;
mod volumes;

pub use display::Tonemapped;
pub use far_to_near::FarToNear;
pub use fog::FogKernel;
pub use interleaved::PartReadback;
pub use kernels::Kernels;
pub use lighting::{Lighting, VERTEX_SPACING};
pub use painter::{ListReadback, PaintTotals, PartData, PatchData};
pub use picture::Renderer;
pub use pictures::Pictures;
pub use points::{Colors, Points};
pub use query::{PointBatch, Query, QueryKernel};
pub use reservoir::ReservoirData;
pub use settings::{
    DitherKind, KEYS, LightingKind, PainterKind, ShadingKind, ShadingSettings, ShadowsKind, keys, parse, runs,
};
pub use shading::{Shading, Tiled};
pub use slice::{Slice, slice};
pub use steps::StepsKernel;
pub use volumes::{FieldData, SlotData};
