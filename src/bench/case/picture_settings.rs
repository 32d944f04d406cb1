//! How a row's picture is made.

use crate::shading::{Lighting, PainterKind, Shading, ShadingSettings};

/// The parts of a spec that pictures depend on, and builds do not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bench) struct PictureSettings {
    pub shading: Shading,
    pub lighting: Lighting,
    /// None: the painter that is faster on most devices of a kind.
    pub painter: Option<PainterKind>,
}

impl PictureSettings {
    pub fn of(settings: &ShadingSettings) -> Self {
        Self { shading: Shading::of(settings), lighting: Lighting::of(settings), painter: settings.painter }
    }
}
