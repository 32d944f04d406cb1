//! A scene as the shaders have it.

use crate::gpu::{Buffer, Context};
use crate::scene::{LightKind, Scene, View};
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Twin: Light in glsl/common/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// World units; of a spot or a point light.
    pub position: [f32; 3],
    /// 0 directional, 1 spot, 2 point.
    pub kind: u32,
    /// The way a directional light travels, the axis of a spot light; 0 for a point light.
    pub direction: [f32; 3],
    /// Cosine of half the cone of a spot light, −2 for the others.
    pub cos_cone: f32,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// Its first map among the maps of all lights.
    pub first_map: u32,
    /// 6 for a point light, else 1.
    pub map_count: u32,
    /// 1 where meshes cast.
    pub has_opaque: u32,
}

impl LightData {
    /// The lights of `scene`.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let data = |(i, light): (usize, &crate::scene::Light)| {
            let (kind, position, direction, cos_cone) = match light.kind {
                LightKind::Directional { direction } => (0, glam::DVec3::ZERO, direction, -2.0),
                LightKind::Spot { position, direction, cone_degrees } => {
                    (1, position, direction, (cone_degrees.to_radians() * 0.5).cos())
                }
                LightKind::Point { position } => (2, position, glam::DVec3::ZERO, -2.0),
            };
            Self {
                position: position.as_vec3().into(),
                kind,
                direction: direction.as_vec3().into(),
                cos_cone: cos_cone as f32,
                radiance: light.radiance,
                first_map: scene.first_map(i) as u32,
                map_count: light.map_count() as u32,
                has_opaque: u32::from(!scene.meshes.is_empty()),
            }
        };
        scene.lights.iter().enumerate().map(data).collect()
    }
}

/// A map of a light. Twin: Map in glsl/common/light.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MapData {
    /// The view of the translucent casters.
    pub volume: View,
    /// The view of the meshes and all they may shadow.
    pub opaque: View,
}

/// Texels a side of an opaque map where there are meshes.
pub const OPAQUE_SIZE: u32 = 1024;

/// Maps of a scene. A build has up to eight passes a map, and a submission times 512.
const MAX_MAPS: usize = 48;

impl MapData {
    /// The maps of all lights of `scene`, those of the first light first, with volume maps of `size` texels a side.
    pub fn all(scene: &Scene, size: u32) -> Vec<Self> {
        let opaque_size = if scene.meshes.is_empty() { 1 } else { OPAQUE_SIZE };
        let views = View::volumes(scene, size).into_iter().zip(View::opaques(scene, opaque_size));
        views.map(|(volume, opaque)| Self { volume, opaque }).collect()
    }
}

/// The lights of a scene and their maps, on the device.
pub struct Maps {
    /// What `buffer` holds.
    pub data: Vec<MapData>,
    /// [`MapData`].
    pub buffer: Buffer,
    /// [`LightData`].
    pub lights: Buffer,
}

impl Maps {
    /// The lights and maps of `scene`, with volume maps of `size` texels a side.
    ///
    /// # Errors
    /// [`Error::Input`] where the lights have too many maps, [`Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene, size: u32) -> Result<Self> {
        let count = scene.map_count();
        if !(1..=MAX_MAPS).contains(&count) {
            let cause =
                format!("{count} maps (six for a point light, one for any other), and 1 to {MAX_MAPS} are built");
            return Err(Error::input(format!("the lights of {}", scene.name), cause, "change the number of lights"));
        }
        let data = MapData::all(scene, size);
        let buffer = Buffer::with_data(context, "maps", &data)?;
        Ok(Self { data, buffer, lights: Buffer::with_data(context, "lights", &LightData::all(scene))? })
    }

    /// How many.
    pub fn count(&self) -> u32 {
        self.data.len() as u32
    }

    /// Texels across and down a volume map; all have the same.
    pub fn size(&self) -> [u32; 2] {
        self.data.first().map_or([1, 1], |m| [m.volume.width, m.volume.height])
    }
}

/// The size of an image of `count` maps of `size`, one above the other.
///
/// # Errors
/// [`Error::Gpu`] where the device has no images of so many rows.
pub fn stacked(context: &Context, name: &str, size: [u32; 2], count: u32) -> Result<[u32; 2]> {
    let limit = context.features().max_image_dimension_2d;
    match size[1].checked_mul(count) {
        Some(rows) if count == 1 || rows <= limit => Ok([size[0], rows]),
        _ => Err(Error::Gpu {
            operation: "create image",
            name: name.into(),
            cause: format!("{count} maps of {} rows, and this device takes {limit} rows", size[1]),
            way_out: "use fewer lights or smaller maps (size=)".into(),
        }),
    }
}

/// Twin: Triangle in glsl/common/triangle.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TriangleData {
    /// World units.
    pub corners: [[f32; 3]; 3],
    /// Diffuse reflectance.
    pub albedo: [f32; 3],
}

/// The casters on the device. All techniques of a scene share it.
pub struct SceneData {
    /// [`Caster`](crate::scene::Caster): spheres, then strands.
    pub casters: Buffer,
    /// How many.
    pub caster_count: u32,
    /// [`TriangleData`].
    pub triangles: Buffer,
    /// How many.
    pub triangle_count: u32,
}

impl SceneData {
    /// Uploads the casters of `scene`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where memory runs out.
    pub fn new(context: &Context, scene: &Scene) -> Result<Self> {
        let corner = |positions: &[[f32; 3]], i: u32| positions.get(i as usize).copied().unwrap_or_default();
        let triangles: Vec<_> = scene
            .meshes
            .iter()
            .flat_map(|m| {
                m.triangles
                    .iter()
                    .map(|t| TriangleData { corners: t.map(|i| corner(&m.positions, i)), albedo: m.albedo })
            })
            .collect();
        let casters = scene.casters();
        Ok(Self {
            casters: Buffer::with_data(context, "scene.casters", &casters)?,
            caster_count: casters.len() as u32,
            triangles: Buffer::with_data(context, "scene.triangles", &triangles)?,
            triangle_count: triangles.len() as u32,
        })
    }
}
