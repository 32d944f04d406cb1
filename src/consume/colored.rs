//! Smoke and hair that absorb some colors of light more than others: the powers to which look-ups and transmittances are raised in each
//! channel. Each channel has an opacity of its own but a target has only one alpha, so channels are drawn one after the other. Twin:
//! glsl/consume/colored.glsl.

use super::{Renderer, Shading};
use crate::gpu::{Blend, Constants};
use crate::scene::Scene;
use crate::shaders::constant;
use crate::{Error, Result};

/// A technique's constants, with those of light whose colors are taken in this ratio.
pub(super) fn colored(constants: &Constants, [red, green, blue]: [f32; 3]) -> Constants {
    let constants = constants.clone().set(constant::EXTINCTION_RED, red);
    constants.set(constant::EXTINCTION_GREEN, green).set(constant::EXTINCTION_BLUE, blue)
}

impl Renderer {
    /// Whether all light is taken alike.
    pub(super) fn is_grey(&self) -> bool {
        self.extinction_ratio == Scene::GREY
    }

    /// How each kernel blends that draws casters, and its constants: one for all channels at once, or one per channel.
    pub(super) fn channels(&self, constants: &Constants) -> Vec<(Blend, Constants)> {
        let constants = colored(constants, self.extinction_ratio);
        if self.is_grey() {
            return vec![(Blend::Over, constants)];
        }
        (0..3).map(|channel| (Blend::OverChannel(channel), constants.clone().set(constant::CHANNEL, channel))).collect()
    }

    /// That meshes can be shaded like that where smoke has a color.
    pub(super) fn check_colored(&self, shading: Shading) -> Result<()> {
        match shading {
            Shading::Tiled(_) if !self.is_grey() => Err(Error::Refused {
                needs: "shading=forward, deferred, interleaved or reservoir: tiled keeps one bit of a light, and smoke of this scene has a color"
                    .into(),
            }),
            _ => Ok(()),
        }
    }
}
