//! Tests without a device: scene files, fuzzed input, and dependencies between the source's folders.

#![cfg(feature = "program")]

mod fuzz;
mod rooms;
mod scene;
#[path = "../support/mod.rs"]
mod support;
