//! Visibility of lights at lists of points.

use super::colored;
use crate::gpu::{Bindings, Buffer, Commands, Context, Kernel, Memory, PassTime, groups, push_struct};
use crate::shaders;
use crate::shaders::set;
use crate::technique::Answer;
use crate::{Error, Result};

push_struct! {
    /// Twin: QueryPush in glsl/query/points.comp.
    struct QueryPush {
        light: u32,
        /// Index of the first point to query for this light, counted over all points.
        first: u32,
        count: u32,
        /// Number of points that have a normal: either all points or none.
        normals: u32,
        /// Number of points that have a width: either all points or none.
        areas: u32,
    }
}

/// Points at which one light is queried.
#[derive(Clone, Copy, Debug)]
pub struct PointBatch<'a> {
    /// Index of the light in the scene.
    pub light: usize,
    /// World positions.
    pub points: &'a [[f32; 3]],
    /// Empty for points in space. For points on surfaces, one unit normal per point, on the side of the surface whose light is queried: the
    /// light's side, or the outside of a closed surface. The normal is 0 if that side faces away from a directional light, so that no light
    /// reaches it.
    pub normals: &'a [[f32; 3]],
}

/// Points on the device, the lights to query at each, and a buffer for the results.
pub struct Query {
    context: Context,
    /// The points at which each light is queried.
    parts: Vec<QueryPush>,
    answers: Buffer,
    bindings: Bindings,
}

/// Queries one technique at the points of one [`Query`].
pub struct QueryKernel(Kernel<QueryPush>);

impl Query {
    /// Uploads world positions. `light` is an index into the scene's lights.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, light: usize, points: &[[f32; 3]]) -> Result<Self> {
        Self::of_lights(context, &[PointBatch { light, points, normals: &[] }])
    }

    /// Same as [`Query::new`], but for several lights in one pass. Either all points have a normal, or none has.
    ///
    /// # Errors
    /// [`Error::Input`] if only some points have a normal; otherwise as [`Query::new`].
    pub fn of_lights(context: &Context, asked: &[PointBatch]) -> Result<Self> {
        Self::of_areas(context, asked, &[])
    }

    /// Same as [`Query::of_lights`], but for squares instead of points. Each square is centred at its point and faces the light; its width,
    /// in world units, is the point's entry in `sides`. Techniques with levels of detail return the mean over the square.
    ///
    /// # Errors
    /// [`Error::Input`] if there are sides, but not as many as points; otherwise as [`Query::of_lights`].
    pub fn of_areas(context: &Context, asked: &[PointBatch], sides: &[f32]) -> Result<Self> {
        let points: Vec<_> = asked.iter().flat_map(|part| part.points).copied().collect();
        let normals: Vec<_> = asked.iter().flat_map(|part| part.normals).copied().collect();
        for (what, count) in [("normals", normals.len()), ("sides", sides.len())] {
            if count != 0 && count != points.len() {
                let cause = format!("{count} {what} for {} points", points.len());
                return Err(Error::input("the query", cause, "give one for each point, or none"));
            }
        }
        let answers = Buffer::new(context, "query.answers", points.len() as u64 * 4, Memory::Device)?;
        let set = set::Query {
            points: &Buffer::with_data(context, "query.points", &points)?,
            answers: &answers,
            all_normals: &Buffer::with_data(context, "query.normals", &normals)?,
            sides: &Buffer::with_data(context, "query.sides", sides)?,
        };
        let bindings = set.bind(context, "query")?;
        let (mut first, normals, areas) = (0, normals.len() as u32, sides.len() as u32);
        let part = |part: &PointBatch| {
            let push = QueryPush { light: part.light as u32, first, count: part.points.len() as u32, normals, areas };
            first += push.count;
            push
        };
        let parts = asked.iter().map(part).collect();
        Ok(Self { context: context.clone(), parts, answers, bindings })
    }

    /// Returns the number of points.
    pub fn points(&self) -> usize {
        self.parts.iter().map(|part| part.count as usize).sum()
    }

    /// Creates the kernel that queries `answer`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the driver rejects the shader.
    pub fn kernel(&self, answer: &Answer) -> Result<QueryKernel> {
        let shader = shaders::query::POINTS.of(answer.folder);
        let sets = [&self.bindings, answer.bindings];
        Ok(QueryKernel(Kernel::compute(&self.context, shader, &sets, answer.constants)?))
    }

    /// Creates the kernel that queries `answer` for light of one color. For this color, the extinction of all casters but meshes is
    /// multiplied by `extinction` ([`crate::scene::Scene::extinction_ratio`]).
    ///
    /// # Errors
    /// See [`Query::kernel`].
    pub fn color_kernel(&self, answer: &Answer, extinction: f32) -> Result<QueryKernel> {
        let constants = colored(answer.constants, [extinction; 3]);
        self.kernel(&Answer { constants: &constants, ..*answer })
    }

    /// Queries all points; the results stay on the device. Returns the pass's time if the device has timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn query(&self, kernel: &QueryKernel) -> Result<Option<PassTime>> {
        let times = self.context.submit(|commands| self.record(commands, kernel))?;
        Ok(times.into_iter().next())
    }

    /// Records the pass that queries all points.
    pub fn record(&self, commands: &mut Commands, kernel: &QueryKernel) {
        commands.pass("query.points", |pass| {
            for part in self.parts.iter().filter(|part| part.count > 0) {
                let [x, y] = groups(u64::from(part.count).div_ceil(64));
                pass.dispatch(&kernel.0, part, [x, y, 1]);
            }
        });
    }

    /// Returns the results on the device, one float per point, in the order of the lights passed.
    pub fn buffer(&self) -> &Buffer {
        &self.answers
    }

    /// Reads the results, one per point, in the order of the lights passed.
    ///
    /// # Errors
    /// See [`Query::query`].
    pub fn answers(&self) -> Result<Vec<f32>> {
        self.answers.read(self.points())
    }

    /// Queries `answer` at all points and reads the results.
    ///
    /// # Errors
    /// See [`Query::kernel`] and [`Query::query`].
    pub fn ask(&self, answer: &Answer) -> Result<Vec<f32>> {
        self.query(&self.kernel(answer)?)?;
        self.answers()
    }
}
