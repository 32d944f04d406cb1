//! How much of light `l` reaches point `p`? Shadow techniques for what lets some light pass, measured side by side.
//!
//! A [`technique`] builds a representation on the GPU from a [`scene`] and answers with one GLSL function,
//! `light_visibility`; [`measure`] asks it at the same points as the f64 [`mod@reference`] and times it; [`report`] shows
//! what came out. [`gpu`] is Vulkan and knows none of them.

#![deny(missing_docs, unsafe_code)]

pub mod cli;
pub mod consume;
mod error;
pub mod glsl;
#[allow(unsafe_code)]
pub mod gpu;
pub mod grid;
pub mod maps;
pub mod measure;
pub mod reference;
pub mod report;
pub mod scene;
pub mod shaders;
pub mod simulate;
pub mod stress;
pub mod technique;
pub mod world;

pub use error::{Error, Result};
pub use technique::requirements;
