//! How much a row measures.

use crate::bench::Extent;

/// Maximum number of look-ups timed or queried at once.
pub const LOOKUPS: usize = 1_000_000;

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Number of timed builds in a static world; fewer for baked techniques that are slow to build.
    pub frames: usize,
    /// Number of untimed warm-up frames before the timed builds.
    pub warm_up: usize,
    /// Number of points per light that are compared with the truth, in space and again on surfaces. With more than eight lights there are
    /// fewer per light.
    pub space_points: usize,
    /// Number of look-ups timed at once, shared equally between the lights; 0 times none.
    pub lookups: usize,
    /// Number of seen points compared with the truth, over all frames.
    pub seen_points: usize,
    /// Size of the picture in pixels.
    pub picture: [u32; 2],
    /// Whether pictures of consecutive frames are compared with the true pictures.
    pub turning: bool,
    /// Whether answers are also compared with means of the truth over areas; in a moving world, in its first frame only.
    pub footprints: bool,
    /// Whether passes count their work, in one additional build and picture; in a moving world, in its last frame only.
    pub counts: bool,
    /// How much of the truth to compute.
    pub truth: Extent,
}

impl Effort {
    /// Whether rows are measured only to choose between them.
    pub(in crate::bench) fn is_choice(&self) -> bool {
        matches!(self.truth, Extent::Glance | Extent::Choice)
    }
}
