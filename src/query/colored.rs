//! Extinction in three colors: in each channel, transmittance is raised to the power of that channel's extinction ratio.
//! Twin: glsl/query/colored.glsl.

use crate::gpu::Constants;
use crate::shaders::constant;

/// Adds the extinction ratio of red, green and blue to a technique's shader constants.
pub(crate) fn colored(constants: &Constants, [red, green, blue]: [f32; 3]) -> Constants {
    let constants = constants.clone().set(constant::EXTINCTION_RED, red);
    constants.set(constant::EXTINCTION_GREEN, green).set(constant::EXTINCTION_BLUE, blue)
}
