//! Fuzzed bodies: each accepts any bytes, panics if Gobo breaks a promise, and returns whether Gobo accepted the bytes. Both
//! fuzz/fuzz_targets/ and tests/host/fuzz.rs run them; docs/reference/fuzzing.md describes the promises.

// Each fuzz target uses only one of these bodies.
#![allow(dead_code, unused_imports)]

mod avsm;
mod bake;
mod files;
mod memory;
mod psm;
mod segments;
mod spec;
mod valid;
mod voxels;

pub use avsm::{avsm, cells};
pub use bake::bake;
pub use files::{gltf, hair, ksplat, nrrd, nvdb, ply, scene, sog, splat, spz, tressfx, vdb, volume};
pub use psm::psm;
pub use spec::spec;
pub use voxels::voxels;

/// Asserts what every error message must satisfy: one line of printable characters that names the cause.
#[track_caller]
fn assert_one_line(error: &gobo::Error, names: &str) {
    let message = error.to_string();
    assert!(
        !message.chars().any(|c| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}')),
        "not one line: {message:?}"
    );
    assert!(message.contains(names), "{message:?} does not name {names}");
}
