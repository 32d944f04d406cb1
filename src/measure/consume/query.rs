//! Visibility of a light at a list of points.

use super::built_for;
use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Memory, PassTime, Pipeline, Resource};
use crate::technique::Visibility;

/// Points on the device, the light that is asked about, and room for an answer each.
pub struct Query {
    context: Context,
    light: u32,
    points: u32,
    answers: Buffer,
    bindings: Bindings,
}

impl Query {
    /// Uploads world positions; `light` counts the scene's lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, light: usize, points: &[[f32; 3]]) -> Result<Self> {
        let answers = Buffer::new(context, "query.answers", points.len() as u64 * 4, Memory::Device)?;
        let resources =
            [Resource::Buffer(Buffer::with_data(context, "query.points", points)?), Resource::Buffer(answers.clone())];
        let bindings = Bindings::new(context, "query", &resources)?;
        Ok(Self { context: context.clone(), light: light as u32, points: points.len() as u32, answers, bindings })
    }

    /// The pipeline that asks `visibility`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader.
    pub fn pipeline(&self, visibility: &Visibility) -> Result<Pipeline> {
        let sets = [&self.bindings, visibility.bindings];
        Pipeline::compute(&self.context, built_for(visibility, "query.comp")?, &sets, visibility.constants)
    }

    /// Asks for all points; the answers stay on the device. Returns the pass's time, where the device has timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn query(&self, pipeline: &Pipeline, visibility: &Visibility) -> Result<Option<PassTime>> {
        let times = self.context.submit(|commands| {
            commands.pass("query", |pass| {
                let sets = [&self.bindings, visibility.bindings];
                let groups = [self.points.div_ceil(64), 1, 1];
                pass.dispatch(pipeline, &sets, bytemuck::bytes_of(&[self.light, self.points]), groups);
            });
        })?;
        Ok(times.into_iter().next())
    }

    /// The answers, one a point.
    ///
    /// # Errors
    /// As [`Query::query`].
    pub fn answers(&self) -> Result<Vec<f32>> {
        self.answers.read(self.points as usize)
    }
}
