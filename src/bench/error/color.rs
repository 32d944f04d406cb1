//! Errors of visibility per color, for smoke that absorbs some colors more than others.

use crate::Result;
use crate::bench::case::points::{ask, at_once};
use crate::bench::case::truth::{Points, Truth};
use crate::bench::{Answers, PointError};
use crate::gpu::Context;
use crate::query::Query;
use crate::scene::Scene;
use crate::technique::Technique;
use crate::world::World;
use serde::{Deserialize, Serialize};

/// Colors of light, in the order of a picture's channels.
pub const COLORS: [&str; 3] = ["red", "green", "blue"];

/// Errors of visibility in one color.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColorError {
    /// One of [`COLORS`].
    pub color: String,
    /// The color's extinction, as a multiple of the casters' extinction ([`Scene::extinction_ratio`]); 1 if casters have several ratios
    /// ([`Scene::with_inks`]).
    pub extinction: f64,
    /// Errors at the space points of [`crate::bench::RowError`]. Absent for a technique without a look-up.
    pub space: Option<PointError>,
    /// Errors at the surface points of [`crate::bench::RowError`]. Absent without meshes.
    pub surface: Option<PointError>,
}

/// Answers in space and on surfaces for each color, over all moments.
#[derive(Default)]
pub(in crate::bench) struct ColorAnswers([[Answers; 2]; 3]);

impl ColorAnswers {
    /// Returns the errors of each color; empty if casters absorb all colors alike.
    pub(in crate::bench) fn errors(&self, world: &World) -> Result<Vec<ColorError>> {
        let (ratio, is_one) = (world.extinction_ratio(), world.colors() == 1);
        let of = |((color, extinction), [space, surface]): ((&&str, f32), &[Answers; 2])| {
            let (space, surface) = (space.error()?, surface.error()?);
            Ok(ColorError { color: (*color).into(), extinction: extinction.into(), space, surface })
        };
        let all = COLORS.iter().zip(ratio).zip(&self.0).filter(|_| ratio != Scene::GREY || !is_one);
        all.map(of).collect()
    }

    /// Queries the technique in each color at the truth's points at one moment, unless casters absorb all colors alike. A technique that
    /// paints has no look-up in space, so it is not queried there.
    pub(in crate::bench) fn ask(
        &mut self,
        context: &Context,
        world: &World,
        technique: &dyn Technique,
        truth: &Truth,
    ) -> Result<()> {
        let ratio = world.extinction_ratio();
        let space: &[Points] = if technique.answer().painter.is_some() { &[] } else { truth.space() };
        if world.colors() > 1 {
            // Each light is listed once per color, with that color alone.
            let scene = truth.scene();
            for (channel, answers) in self.0.iter_mut().enumerate() {
                for (points, answers) in [space, truth.surface()].into_iter().zip(answers) {
                    let of_color =
                        points.chunk_by(|a, b| scene.color_of_light(a.light) == scene.color_of_light(b.light));
                    for lights in of_color.filter(|lights| scene.color_of_light(lights[0].light) == channel) {
                        answers.approximate.extend(ask(context, technique, lights)?);
                        answers.truth.extend(lights.iter().flat_map(|points| &points.visibility));
                    }
                }
            }
            return Ok(());
        }
        if ratio == Scene::GREY {
            return Ok(());
        }
        for (channel, (extinction, answers)) in ratio.into_iter().zip(&mut self.0).enumerate() {
            for (points, answers) in [space, truth.surface()].into_iter().zip(answers) {
                for list in at_once(points) {
                    let query = Query::of_lights(context, &list)?;
                    query.query(&query.color_kernel(&technique.answer(), extinction)?)?;
                    answers.approximate.extend(query.answers()?);
                }
                answers.truth.extend(points.iter().flat_map(|p| &p.colors).map(|colors| colors[channel]));
            }
        }
        Ok(())
    }
}
