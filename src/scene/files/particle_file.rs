//! Particles from PLY files: element `vertex` with `x y z radius` and `extinction` or `opacity`.

use crate::Result;
use crate::scene::files::placement::Placement;
use crate::scene::files::stage::{MAX_COORDINATE, in_range};
use crate::scene::{MAX_OPTICAL_DEPTH, Particle, files::input, files::ply};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::path::Path;

/// One row of the file. Missing properties stay 0.
#[derive(Default)]
struct Row {
    position: [f64; 3],
    radius: f64,
    extinction: f64,
    opacity: f64,
}

impl PropertyAccess for Row {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let [x, y, z] = &mut self.position;
        let field = match name {
            "x" => x,
            "y" => y,
            "z" => z,
            "radius" => &mut self.radius,
            "extinction" => &mut self.extinction,
            "opacity" => &mut self.opacity,
            _ => return PropertyAccessResult::Ignored,
        };
        if let Some(value) = ply::scalar(&value) {
            *field = value;
        }
        PropertyAccessResult::Set
    }
}

/// Loads and places particles from a PLY file: ASCII or binary of either byte order, with numbers of any type.
///
/// `opacity` is the fraction of light that a particle removes along its diameter: extinction = −ln(1−opacity)/(2·radius), with the optical
/// depth capped at [`MAX_OPTICAL_DEPTH`]. If a file has both, `extinction` is used. A file without rows gives no particles.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the file is unreadable or truncated, a property is missing, a position, radius or extinction is
/// invalid for a [`Particle`], or an opacity is outside [0, 1]; the message gives the particle's number.
pub(in crate::scene) fn load(path: &Path, placement: &Placement) -> Result<Vec<Particle>> {
    let file = ply::open(path)?;
    file.require_scalars("vertex", &["x", "y", "z", "radius"])?;
    let has_extinction = file.has_scalar("vertex", "extinction");
    if !has_extinction && !file.has_scalar("vertex", "opacity") {
        let way_out = "add one of the two properties to the file";
        return Err(file.error("element vertex lacks the property extinction and also opacity", way_out));
    }
    let mut particles = Vec::new();
    file.read_rows(&["vertex"], |element, number, row: Row| {
        if element == "vertex" {
            let particle = particle(&row, has_extinction, placement).map_err(|cause| {
                input::error(path, format!("particle {number} (the first is 0): {cause}"), "correct or drop it")
            })?;
            particles.push(particle);
        }
        Ok(())
    })?;
    Ok(particles)
}

/// Places a particle. A larger model of the same smoke is as dark as the smaller one.
fn particle(row: &Row, has_extinction: bool, placement: &Placement) -> std::result::Result<Particle, String> {
    let extinction = if has_extinction {
        row.extinction
    } else if (0.0..=1.0).contains(&row.opacity) {
        // ln_1p, because computing 1 − opacity would round a thin particle's opacity away.
        (-(-row.opacity).ln_1p()).min(MAX_OPTICAL_DEPTH.into()) / (2.0 * row.radius)
    } else {
        return Err(format!("opacity {} is not in [0, 1]", row.opacity));
    };
    checked(placement.position(row.position), row.radius * placement.scale, extinction / placement.scale)
}

/// Returns a particle that is valid according to the documentation of [`Particle`]; the error describes what is wrong. Checked in f32,
/// because a finite f64 may become infinite or zero when converted.
fn checked(position: [f64; 3], radius: f64, extinction: f64) -> std::result::Result<Particle, String> {
    let particle =
        Particle { position: position.map(|value| value as f32), radius: radius as f32, extinction: extinction as f32 };
    if !in_range(&particle.position) {
        return Err(format!("position {position:?} is not finite or exceeds {MAX_COORDINATE:e}"));
    }
    if !(in_range(&[particle.radius]) && particle.radius > 0.0) {
        return Err(format!("radius {radius} is not greater than 0 or exceeds {MAX_COORDINATE:e}"));
    }
    if !(particle.extinction.is_finite() && particle.extinction >= 0.0) {
        return Err(format!("extinction {extinction} is not finite and at least 0"));
    }
    Ok(particle)
}
