//! Checks the pictures of each painting command against the truth, a twin or a ray that the command does not know.

mod curve;
mod figures;
mod map;
mod plot;
mod shown;
mod slice;
mod steps;
mod voxels;
mod wireframe;

use std::path::Path;

/// Reads a picture: its size, and three bytes per pixel.
fn rgb8(path: &Path) -> ([u32; 2], Vec<[u8; 3]>) {
    let picture = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).to_rgb8();
    (picture.dimensions().into(), picture.pixels().map(|pixel| pixel.0).collect())
}
