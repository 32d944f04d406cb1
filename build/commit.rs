//! The commit that the program is built from, for results that others are to make again.

use std::process::Command;

/// All that the program is made of.
pub const SOURCES: [&str; 6] = ["src", "glsl", "build", "build.rs", "Cargo.toml", "Cargo.lock"];

/// Sets GOBO_COMMIT, which is `unknown` outside git, and GOBO_CHANGED: whether a source differs from that commit.
///
/// This runs where a source changes, and not with each commit, which would build the whole crate and its tests again. So what is built
/// before its commit stays *changed* until build.rs is touched; what is not changed is what that commit has.
pub fn tell() {
    let commit = git(&["rev-parse", "HEAD"]).filter(|commit| !commit.is_empty());
    let changes = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat());
    println!("cargo:rustc-env=GOBO_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    println!("cargo:rustc-env=GOBO_CHANGED={}", changes.is_none_or(|changes| !changes.is_empty()));
}

/// What git says in this folder, unless that is a part of another project's: the source of a registry's package may lie in one.
fn git(arguments: &[&str]) -> Option<String> {
    let said = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    said(&["rev-parse", "--show-prefix"]).filter(String::is_empty).and_then(|_| said(arguments))
}
