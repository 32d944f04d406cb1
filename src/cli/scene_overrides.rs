//! Options that change a scene after it is loaded.

use crate::scene::SceneChange;
use clap::Args;
use glam::DVec3;

#[derive(Args)]
pub(super) struct ChangeArguments {
    /// Put the camera here, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Have the camera look at this point, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Direction in which the light of the first directional or spot light travels
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    direction: Option<DVec3>,
    /// Factor for the optical depths of smoke, hair and splats
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", allow_hyphen_values = true)]
    extinction: f64,
}

impl ChangeArguments {
    pub fn change(&self) -> SceneChange {
        SceneChange { eye: self.eye, target: self.target, direction: self.direction, extinction: self.extinction }
    }
}

/// Parses `1,2.5,-3`.
pub(super) fn vector(text: &str) -> std::result::Result<DVec3, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let three = <[f64; 3]>::try_from(numbers).ok().filter(|v| v.iter().all(|n| n.is_finite()));
    three.map(DVec3::from).ok_or_else(|| "give three numbers, X,Y,Z".into())
}
