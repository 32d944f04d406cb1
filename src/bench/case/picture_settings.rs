//! How a row's picture is drawn.

use crate::shading::{Lighting, PainterKind, Shading, ShadingSettings};

/// The parts of a spec that affect pictures but not builds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bench) struct PictureSettings {
    pub shading: Shading,
    pub lighting: Lighting,
    /// `None` selects the painter that is faster on most devices of this kind.
    pub painter: Option<PainterKind>,
}

impl PictureSettings {
    pub fn of(settings: &ShadingSettings) -> Self {
        Self { shading: Shading::of(settings), lighting: Lighting::of(settings), painter: settings.painter }
    }
}
