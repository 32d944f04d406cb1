//! Techniques that store light in the views of lights: what they build and answer, against their CPU twins, closed forms and the
//! reference.

#![cfg(feature = "program")]

mod avsm;
mod bins;
mod deep_shadow_map;
mod half_angle;
mod ism;
mod maps;
mod opaque;
mod psm;
mod stochastic;
#[path = "../support/mod.rs"]
mod support;
mod texel_maps;
mod twin;
