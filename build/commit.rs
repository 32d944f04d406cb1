//! The commit that the program is built from, so that others can reproduce its results.

use std::process::Command;

/// Everything that the program is built from.
pub const SOURCES: [&str; 6] = ["src", "glsl", "build", "build.rs", "Cargo.toml", "Cargo.lock"];

/// Sets GOBO_COMMIT, which is `unknown` outside git, and GOBO_CHANGED: whether a source differs from that commit.
///
/// This runs when a source changes, not on every commit, which would rebuild the whole crate and its tests. A program that was built before
/// its source was committed therefore stays *changed* until build.rs is touched; a program that is not *changed* matches its commit.
pub fn tell() {
    let commit = git(&["rev-parse", "HEAD"]).filter(|commit| !commit.is_empty());
    let changes = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat());
    println!("cargo:rustc-env=GOBO_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    println!("cargo:rustc-env=GOBO_CHANGED={}", changes.is_none_or(|changes| !changes.is_empty()));
}

/// Returns git's output for this folder, or `None` if the folder is inside another project's repository, as the source of a downloaded
/// package may be.
fn git(arguments: &[&str]) -> Option<String> {
    let said = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    said(&["rev-parse", "--show-prefix"]).filter(String::is_empty).and_then(|_| said(arguments))
}
