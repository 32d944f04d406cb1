//! Pictures: casters, volumes and meshes lit by a technique, painted by compute passes or drawn; many lights in tiles, a part of them per
//! pixel, or one per pixel; fog. Shading knows only the [`crate::technique::Answer`], never the technique that it comes from.

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
#[doc(hidden)]
pub mod many_lights;
mod mesh_shading;
mod painter;
mod passes;
mod picture;
mod picture_scene;
mod pictures;
mod points;
mod readback;
mod reservoir;
mod settings;
mod shared;
mod steps;
mod targets;
mod volumes;

pub use display::Tonemapped;
pub use fog::FogKernel;
pub use kernels::Kernels;
pub use lighting::Lighting;
pub use mesh_shading::{Shading, Tiled};
pub use picture::Renderer;
pub use settings::{PainterKind, ShadingSettings};

// For the program and the tests.
#[doc(hidden)]
pub use self::{
    far_to_near::FarToNear,
    interleaved::PartReadback,
    lighting::VERTEX_SPACING,
    painter::{ListReadback, PaintTotals, PartData, PatchData},
    pictures::Pictures,
    points::{Colors, Points},
    reservoir::ReservoirData,
    settings::{DitherKind, KEYS, LightingKind, ShadingKind, ShadowsKind, keys, parse, runs},
    steps::StepsKernel,
    volumes::{FieldData, SlotData},
};

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a buffer or state that several [`Kernels`] of a renderer share. Only the thread that owns the renderer ever locks it.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
