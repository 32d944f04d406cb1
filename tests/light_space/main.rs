//! Light-space techniques: what they build and what their look-ups return, against CPU twins, closed forms and the reference.

#![cfg(feature = "program")]

mod avsm;
mod bins;
mod deep_shadow_map;
mod half_angle;
mod holes;
mod ism;
mod maps;
mod opaque;
mod psm;
mod sheets;
mod stochastic;
#[path = "../support/mod.rs"]
mod support;
mod texel_maps;
mod twin;
