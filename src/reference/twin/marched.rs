//! Curves from a march through a density grid. Twin of glsl/technique/marched/march.comp, in f32.

use super::avsm::curve::{Build, Curve};
use super::grid::Place;
use super::media::{Media, length};
use super::segment::ray;
use super::sums::DARK;
use crate::scene::{Projection, View};
use glam::{Vec2, Vec3};

/// Errors of transmittance above which a sample of the march is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Twin: ABSOLUTE_ERROR.
    pub absolute: f32,
    /// Twin: RELATIVE_ERROR.
    pub relative: f32,
}

/// The state of a march. Names match the shader's.
struct March {
    curve: Curve,
    errors: Errors,
    depth_of: [f32; 2],
    near_place: f32,
    kept: [f32; 3],
    last: [f32; 2],
    /// Smallest relative distance between an error and a threshold over all decisions so far.
    margin: f32,
}

/// Returns the curve of a texel, and the margin of the march's closest decision: the smallest relative change that would have reversed it.
/// The margin is infinite if nothing was decided.
pub fn marched(
    media: &Media,
    place: &Place,
    view: &View,
    texel: [u32; 2],
    build: Build,
    errors: Errors,
) -> (Curve, f32) {
    let about = View { origin: (Vec3::from(view.origin) - Vec3::from(place.origin)).into(), ..*view };
    let (origin, direction) = ray(&about, Vec2::new(texel[0] as f32, texel[1] as f32) + 0.5);
    let reach = 1.732_050_9 * place.size as f32 * place.voxel;
    let (mut first, last) = (view.near - reach, view.far + reach);
    if view.projection() == Projection::Perspective {
        first = first.max(0.0);
    }
    let range = view.far - view.near;
    let mut march = March {
        curve: Curve::new(build),
        errors,
        depth_of: [(first - view.near) / range, (last - first) / range],
        near_place: (view.near - first) / (last - first),
        kept: [0.0; 3],
        last: [0.0; 2],
        margin: f32::INFINITY,
    };
    let from = ((origin + first * direction) * place.per_unit).to_array();
    let way = (direction * ((last - first) * place.per_unit)).to_array();
    let voxels = length(way);
    media.bits.walk(from, way, |voxel, [begin, end]| {
        march.visit(media.of(voxel) * voxels, begin, end.max(begin));
        march.last[1] < DARK
    });
    if !march.curve.nodes().is_empty() || march.last[1] > 0.0 {
        march.keep(0.0);
    }
    march.curve.reduce();
    (march.curve, march.margin)
}

impl March {
    fn keep(&mut self, rate: f32) {
        let [place, value] = self.last;
        self.curve.append((self.depth_of[0] + self.depth_of[1] * place).clamp(0.0, 1.0), value);
        self.kept = [place, value, rate];
    }

    fn stretch(&mut self, rate: f32, end: f32) {
        let ([kept_place, kept_value, kept_rate], [place, value]) = (self.kept, self.last);
        let next = value + rate * (end - place);
        let through = (-next).exp();
        let error = (through - (-(kept_value + kept_rate * (end - kept_place))).exp()).abs();
        let Errors { absolute, relative } = self.errors;
        if place > kept_place {
            for threshold in [absolute, relative * through] {
                self.margin = self.margin.min((error - threshold).abs() / through.max(1e-5));
            }
            if error > absolute && error > relative * through {
                self.keep(rate);
            }
        }
        self.last = [end, next];
    }

    /// Twin: media_visit.
    fn visit(&mut self, rate: f32, mut begin: f32, end: f32) {
        if rate.is_nan() || rate <= 0.0 {
            return;
        }
        if begin < self.near_place {
            let part = end.min(self.near_place);
            self.last = [part, self.last[1] + rate * (part - begin)];
            if end <= self.near_place {
                return;
            }
            begin = self.near_place;
        }
        if self.curve.nodes().is_empty() {
            self.last[0] = if self.last[1] > 0.0 { self.near_place } else { begin };
            self.keep(if self.last[0] < begin { 0.0 } else { rate });
        }
        if begin > self.last[0] {
            self.stretch(0.0, begin);
        }
        self.stretch(rate, end);
    }
}
