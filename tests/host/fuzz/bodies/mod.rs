//! What is fuzzed: a body takes any bytes, and panics where Gobo breaks a promise. It says whether Gobo took the bytes for
//! something. fuzz/fuzz_targets/ and tests/host/fuzz.rs run the same ones; docs/reference/fuzzing.md says what is asked of them.

// A fuzz target uses one of them.
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
pub use files::{gltf, hair, nrrd, ply, scene, splat, spz, tressfx, vdb, volume};
pub use psm::psm;
pub use spec::spec;
pub use voxels::voxels;

/// Holds what an error message must keep: one line, of printable characters, that names the thing.
#[track_caller]
fn assert_one_line(error: &gobo::Error, names: &str) {
    let message = error.to_string();
    assert!(
        !message.chars().any(|c| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}')),
        "not one line: {message:?}"
    );
    assert!(message.contains(names), "{message:?} does not name {names}");
}
