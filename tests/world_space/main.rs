//! Techniques that store or query casters in world space, against their CPU twins, closed forms and the reference.

#![cfg(feature = "program")]

mod density_grid;
mod grid_query;
mod marched;
mod optical_depth_grid;
mod shapes;
#[path = "../support/mod.rs"]
mod support;
mod volumes;
mod voxel_grid;
mod voxelized;
