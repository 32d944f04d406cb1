//! What commands write: files, pictures, progress.

pub(super) mod exit_code;
pub(super) mod output_path;
pub(super) mod progress;
pub(super) mod render_frames;
pub(super) mod sequence;
pub(super) mod silhouette;
pub(super) mod writer;
