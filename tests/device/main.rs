//! The device, the world on it, parts for other engines, and all techniques against the reference.

#![cfg(feature = "program")]

mod accuracy;
mod glsl;
mod gpu;
mod settings;
mod simulate;
#[path = "../support/mod.rs"]
mod support;
mod world;
