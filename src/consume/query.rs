//! Visibility of a light at a list of points.

use crate::Result;
use crate::gpu::{Bindings, Buffer, Context, Kernel, Memory, PassTime, Resource, groups, push_struct};
use crate::shaders;
use crate::technique::Answer;

push_struct! {
    /// Twin: QueryPush in glsl/consume/query.comp.
    struct QueryPush {
        light: u32,
        count: u32,
        /// How many of the points have a normal: all or none.
        normals: u32,
    }
}

/// Points on the device, the light that is asked about, and room for an answer each.
pub struct Query {
    context: Context,
    light: u32,
    points: u32,
    normals: u32,
    answers: Buffer,
    bindings: Bindings,
}

/// Asks one technique for the points of one [`Query`].
pub struct QueryKernel(Kernel<QueryPush>);

impl Query {
    /// Uploads world positions; `light` counts the scene's lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, light: usize, points: &[[f32; 3]]) -> Result<Self> {
        Self::on_surfaces(context, light, points, &[])
    }

    /// The same for points on surfaces: `normals` has one for each, unit length, on the side that light is asked for (the
    /// light's, or of a closed thing the outside); or none, and the points are in space.
    ///
    /// # Errors
    /// As [`Query::new`].
    pub fn on_surfaces(context: &Context, light: usize, points: &[[f32; 3]], normals: &[[f32; 3]]) -> Result<Self> {
        let answers = Buffer::new(context, "query.answers", points.len() as u64 * 4, Memory::Device)?;
        let normals = if normals.len() == points.len() { normals } else { &[] };
        let resources = [
            Resource::Buffer(Buffer::with_data(context, "query.points", points)?),
            Resource::Buffer(answers.clone()),
            Resource::Buffer(Buffer::with_data(context, "query.normals", normals)?),
        ];
        let bindings = Bindings::new(context, "query", &resources)?;
        let (light, points, normals) = (light as u32, points.len() as u32, normals.len() as u32);
        Ok(Self { context: context.clone(), light, points, normals, answers, bindings })
    }

    /// What asks `answer`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the driver rejects the shader.
    pub fn kernel(&self, answer: &Answer) -> Result<QueryKernel> {
        let shader = shaders::consume::QUERY.of(answer.folder);
        let sets = [&self.bindings, answer.bindings];
        Ok(QueryKernel(Kernel::compute(&self.context, shader, &sets, answer.constants)?))
    }

    /// Asks for all points; the answers stay on the device. Returns the pass's time, where the device has timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device is lost.
    pub fn query(&self, kernel: &QueryKernel) -> Result<Option<PassTime>> {
        let times = self.context.submit(|commands| {
            commands.pass("consume.query", |pass| {
                let push = QueryPush { light: self.light, count: self.points, normals: self.normals };
                let [x, y] = groups(u64::from(self.points).div_ceil(64));
                pass.dispatch(&kernel.0, &push, [x, y, 1]);
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

    /// Asks `answer` for all points and reads what it says.
    ///
    /// # Errors
    /// As [`Query::kernel`] and [`Query::query`].
    pub fn ask(&self, answer: &Answer) -> Result<Vec<f32>> {
        self.query(&self.kernel(answer)?)?;
        self.answers()
    }
}
