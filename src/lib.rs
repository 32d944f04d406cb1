//! How much of light `l` reaches point `p`? Shadow techniques for what lets some light pass, measured side by side.
//!
//! A [`technique`] builds a representation on the GPU from a [`scene`] and answers with one GLSL function,
//! `light_visibility`; [`measure`] asks it at the same points as the f64 [`mod@reference`] and times it; [`report`] shows
//! what came out. [`gpu`] is Vulkan and knows none of them.

#![deny(missing_docs, unsafe_code)]

#[cfg(feature = "program")]
mod advice;
#[cfg(feature = "program")]
pub mod cli;
pub mod consume;
mod error;
#[allow(unsafe_code)]
pub mod gpu;
pub mod grid;
pub mod maps;
#[cfg(feature = "program")]
pub mod measure;
#[cfg(feature = "program")]
pub mod reference;
#[cfg(feature = "program")]
pub mod report;
pub mod scene;
pub mod shaders;
pub mod simulate;
#[cfg(feature = "program")]
pub mod stress;
pub mod technique;
pub mod world;

#[cfg(feature = "program")]
use error::one_of;
pub use error::{Error, Less, Result, WayOut};
