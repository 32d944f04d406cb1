//! How much a row measures.

use crate::bench::Extent;

/// The most look-ups that are timed or asked at once.
pub const LOOKUPS: usize = 1_000_000;

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Builds that are timed in a still world; fewer for baked techniques that take long.
    pub frames: usize,
    /// Frames that warm up before those, and are not timed.
    pub warm_up: usize,
    /// How many points in space per light are compared with the truth, and how many points on surfaces. With more than eight lights there
    /// are fewer per light.
    pub space_points: usize,
    /// Look-ups that are timed at once, an equal share per light; 0 times none.
    pub lookups: usize,
    /// How many seen points are compared with the truth, of all frames together.
    pub seen_points: usize,
    /// Size of the picture, pixels.
    pub picture: [u32; 2],
    /// Whether pictures of consecutive frames are compared with the truth's.
    pub turning: bool,
    /// Whether answers are also compared with means over areas. Where the world moves, in its first frame.
    pub footprints: bool,
    /// Whether passes count their work, in one more build and picture. Where the world moves, in its last frame.
    pub counts: bool,
    /// How much of the truth is computed.
    pub truth: Extent,
}

impl Effort {
    /// Whether rows are measured only for a choice between them.
    pub(in crate::bench) fn is_choice(&self) -> bool {
        matches!(self.truth, Extent::Glance | Extent::Choice)
    }
}
