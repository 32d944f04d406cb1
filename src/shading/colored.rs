//! Pictures of smoke and hair that absorb some colors of light more than others. Each channel has its own opacity, but a target has only
//! one alpha, so channels are drawn one after another.

use super::{Renderer, Shading};
use crate::gpu::{Blend, Constants};
use crate::query::colored;
use crate::scene::Scene;
use crate::shaders::constant;
use crate::{Error, Result};

impl Renderer {
    /// Returns whether casters absorb all colors of light equally.
    pub(super) fn is_grey(&self) -> bool {
        self.kinds.extinction_ratio == Scene::GREY && self.kinds.room_per_color == 0
    }

    /// Specializes the shaders that draw casters for the kinds that may occur, so that they omit the arithmetic for all other kinds.
    pub(super) fn with_kinds(&self, constants: Constants) -> Constants {
        constants
            .set(constant::STRANDS, self.kinds.has_strands)
            .set(constant::SPLATS_OR_CELLS, self.kinds.has_splats_or_cells)
            .set(constant::SHEETS, self.kinds.has_sheets)
            .set(constant::ALPHA_FIRST, self.kinds.alpha_first)
    }

    /// Returns the blend state and constants of each kernel that draws casters: one kernel for all channels at once, or
    /// one per channel.
    pub(super) fn channels(&self, constants: &Constants) -> Vec<(Blend, Constants)> {
        let mut constants = self.with_kinds(colored(constants, self.kinds.extinction_ratio));
        if self.is_grey() {
            return vec![(Blend::Over, constants)];
        }
        if self.kinds.room_per_color > 0 {
            constants = constants.set(constant::CASTER_ROOM, self.kinds.room_per_color);
        }
        (0..3).map(|channel| (Blend::OverChannel(channel), constants.clone().set(constant::CHANNEL, channel))).collect()
    }

    /// Refuses tiled shading if smoke has a color.
    pub(super) fn check_colored(&self, shading: Shading) -> Result<()> {
        match shading {
            Shading::Tiled(_) if !self.is_grey() => Err(Error::Refused("shading=forward, deferred, interleaved or reservoir: tiled keeps one bit of a light, and smoke of this scene has a color"
                    .into())),
            _ => Ok(()),
        }
    }
}
