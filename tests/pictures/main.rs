//! Shaded pictures: casters painted and drawn, colors, fog, many lights, indirect light.

#![cfg(feature = "program")]

mod color;
mod fog;
mod indirect;
mod inks;
mod interleaved;
mod lamps;
mod lighting;
mod many_lights;
mod painter;
#[path = "../support/mod.rs"]
mod support;
