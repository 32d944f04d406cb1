//! Chooses the points that each light uses, based on the views of the light and of the viewer. Source: Ritschel et al. 2011, Making
//! imperfect shadow maps view-adaptive.

use super::Settings;
use super::sample::{SUBSETS, Sample};
use crate::gpu::{Buffer, Commands, Constants, Context, Kernel, Memory, groups, push_struct};
use crate::shaders::set;
use crate::shaders::{constant, ism as shaders};
use crate::world::World;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Points per cluster. Twin: CLUSTER.
pub const CLUSTER: u32 = 64;

/// A cluster of neighbouring points. Twin: IsmCluster in glsl/technique/ism/adaptive.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterData {
    /// Centre, in world units.
    pub middle: [f32; 3],
    /// Distance from the centre to the farthest point.
    pub reach: f32,
    /// Mean normal, of unit length; 0 if the normals have no mean direction.
    pub normal: [f32; 3],
    /// Greatest distance of a point's normal from the mean normal.
    pub spread: f32,
    /// Half extents of the axis-aligned box around the centre that contains all points of the cluster.
    pub sides: [f32; 3],
    /// Greatest distance of a point from the plane through the centre that is perpendicular to the mean normal.
    pub thick: f32,
    /// 1 if all points are on closed meshes.
    pub closed: u32,
}

/// Used as the camera's distance to its target if no camera is set: so large that all points count as equally near.
const FAR: f32 = 1e18;

push_struct! {
    /// Twin: ClustersPush in glsl/technique/ism/clusters.comp.
    struct ClustersPush { cluster_count: u32 }
}

push_struct! {
    /// Twin: AdaptPush in glsl/technique/ism/adapt.comp.
    struct AdaptPush { light_count: u32, points: u32, eye: [f32; 3], near: f32 }
}

/// The points that lights use, and the passes that choose them.
pub struct Adapt {
    settings: Settings,
    light_count: u32,
    /// Points that each light uses, light by light. Each entry holds the point's index in the pool and the fraction of its cluster's area
    /// that the point represents.
    pub taken: Buffer,
    /// [`ClusterData`].
    pub clusters: Buffer,
    gather: Kernel<ClustersPush>,
    adapt: Kernel<AdaptPush>,
}

impl Adapt {
    /// Allocates the points of a world's lights, which are chosen from `sample`, and creates the passes.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device cannot bind a buffer as large as the list of points, [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings, sample: &Sample) -> Result<Self> {
        let light_count = world.light_count();
        let bytes = 4 * u64::from(light_count.max(1)) * u64::from(settings.points);
        let most = u64::from(context.features().max_storage_buffer_range);
        if bytes > most {
            let needs = format!(
                "maxStorageBufferRange of at least {bytes} for adaptive points (this device has {most}; even points have no such list)"
            );
            return Err(Error::Refused(needs.into()));
        }
        let taken = Buffer::new(context, "ism.taken", bytes, Memory::Device)?;
        let bytes = u64::from(cluster_count(settings)) * size_of::<ClusterData>() as u64;
        let clusters = Buffer::new(context, "ism.clusters", bytes, Memory::Device)?;
        let gathers = set::IsmClusters { pool: &sample.pool, clusters: &clusters }.bind(context, "ism.clusters")?;
        let adapts = set::IsmAdapt { lights: &world.lights, head: &sample.head, clusters: &clusters, taken: &taken };
        let adapts = adapts.bind(context, "ism.adapt")?;
        let constants = Constants::new()
            .set(constant::ISM_SIZE, settings.size)
            .set(constant::ISM_CULLING, settings.culls())
            .set(constant::ISM_SLIDE, settings.slides());
        Ok(Self {
            settings: *settings,
            light_count,
            taken,
            clusters,
            gather: Kernel::compute(context, &shaders::CLUSTERS, &[&gathers], &Constants::new())?,
            adapt: Kernel::compute(context, &shaders::ADAPT, &[&adapts], &constants)?,
        })
    }

    /// Records the pass that finds bounds and means of the clusters for the current points.
    pub fn gather(&self, commands: &mut Commands) {
        let push = ClustersPush { cluster_count: cluster_count(&self.settings) };
        let [x, y] = groups(push.cluster_count.into());
        commands.pass("ism.clusters", |pass| pass.dispatch(&self.gather, &push, [x, y, 1]));
    }

    /// Records the pass that chooses points for each light.
    pub fn record(&self, commands: &mut Commands, world: &World) {
        let (eye, near) = world.camera().map_or(([0.0; 3], FAR), |camera| {
            (camera.position.as_vec3().to_array(), camera.position.distance(camera.target) as f32)
        });
        let push = AdaptPush { light_count: self.light_count, points: self.settings.points, eye, near };
        let [x, y] = groups(self.light_count.into());
        commands.pass("ism.adapt", |pass| pass.dispatch(&self.adapt, &push, [x, y, 1]));
    }

    /// Returns the number of bytes needed only while building.
    pub fn transient_bytes(&self) -> u64 {
        self.taken.bytes() + self.clusters.bytes()
    }
}

fn cluster_count(settings: &Settings) -> u32 {
    settings.points * SUBSETS / CLUSTER
}
