//! CPU twins of glsl/technique/avsm/. Source: Salvi et al. 2010, "Adaptive Volumetric Shadow Maps", and Intel's sample of 2013, "AVSM
//! with pixel shader ordering".

pub mod cells;
pub mod curve;
mod fit;
pub mod levels;
pub mod node;
pub mod pack;
