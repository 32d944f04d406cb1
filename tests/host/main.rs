//! What no device makes a difference to: scene files, fuzzed input, which room of the source uses which.

#![cfg(feature = "program")]

mod fuzz;
mod rooms;
mod scene;
#[path = "../support/mod.rs"]
mod support;
