//! Virtual point lights, created on the device from a world and its lights. Each light's view gets a reflective shadow map; texels of all
//! maps become virtual lights, with a probability proportional to their flux, or to the part of it that reaches the picture. Sources:
//! Keller 1997, *Instant radiosity*; Dachsbacher and Stamminger 2005, *Reflective shadow maps*; Ritschel et al. 2011, *Making imperfect
//! shadow maps view-adaptive*. Twin: reference::twin::indirect.

mod passes;
mod view_importance;
mod vpl_scene;

pub use vpl_scene::{VplsBy, lit_by_vpls};

// For the program and the tests.
#[doc(hidden)]
pub use self::{
    view_importance::{POINTS_ACROSS, ViewPointData},
    vpl_scene::{VPLS, check_count, check_meshes},
};

use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Format, Image, ImageUse, Memory, PassTime};
use crate::maps::{Map, Maps, OpaqueMaps, OpaqueWay};
use crate::scene::{Light, LightKind, View};
use crate::shaders::set;
use crate::world::{LightData, World};
use glam::DVec3;
use passes::Kernels;
use view_importance::ViewImportance;
use vpl_scene::check_has_meshes;

/// Maximum texels per side of a map, as a power of 2. With one map and 1,024 virtual lights, this is 64 texels per virtual light.
const MOST_SIDE_BITS: u32 = 8;

/// Minimum texels per side of a map, as a power of 2: the size in the worst case, 6,144 maps of 1,024 point lights.
const LEAST_SIDE_BITS: u32 = 4;

/// Maximum number of texels in all maps together, unless [`LEAST_SIDE_BITS`] demands more: 64 maps may have the largest size. More texels
/// would move each virtual light only within the surface patch that it represents.
const MOST_TEXELS: u64 = 1 << 22;

/// Returns the texels per side of each of `maps` maps, as a power of 2.
fn side_bits(maps: u32) -> u32 {
    let fits = |bits: &u32| u64::from(maps) << (2 * bits) <= MOST_TEXELS;
    (LEAST_SIDE_BITS..=MOST_SIDE_BITS).rev().find(fits).unwrap_or(LEAST_SIDE_BITS)
}

/// Virtual lights on the device, with the maps from which they are created.
pub struct Vpls {
    context: Context,
    count: u32,
    side_bits: u32,
    maps: Maps,
    seen: Image,
    fluxes: Buffer,
    greatest: Buffer,
    sums: Buffer,
    starts: Buffer,
    picks: Buffer,
    lights: Buffer,
    kernels: Kernels,
    viewed: Option<ViewImportance>,
}

impl Vpls {
    /// Creates buffers and maps for `count` virtual lights, which represent light from the lights of `world`.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if the count is out of range or there is no mesh; [`crate::Error::Refused`] if the device has no room for
    /// the maps of all lights; [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, count: u32) -> Result<Self> {
        Self::with_camera(context, world, count, None)
    }

    /// Same as [`Vpls::new`], but virtual lights are denser, and dimmer in proportion, where more of their light reaches what `camera`, a
    /// perspective view, sees.
    ///
    /// # Errors
    /// See [`Vpls::new`].
    pub fn by_view(context: &Context, world: &World, count: u32, camera: &View) -> Result<Self> {
        Self::with_camera(context, world, count, Some(camera))
    }

    fn with_camera(context: &Context, world: &World, count: u32, camera: Option<&View>) -> Result<Self> {
        check_count(count)?;
        check_has_meshes(world.triangle_capacity() > 0, world.name())?;
        let side_bits = side_bits(world.map_count() as u32);
        let opaque = OpaqueMaps { size: 1 << side_bits, ..OpaqueMaps::shared(Some(OpaqueWay::Raster)) };
        let maps = Maps::with_opaque(context, world, 1 << side_bits, opaque)?;
        let seen = Image::new(context, "indirect.seen", Format::R32_UINT, maps.opaque_image().size(), ImageUse::Color)?;
        let owner = |(light, shining): (usize, &Light)| vec![light as u32; shining.map_count()];
        let owners: Vec<u32> = world.all_lights().iter().enumerate().flat_map(owner).collect();
        let owners = Buffer::with_data(context, "indirect.owners", &owners)?;
        let rows = u64::from(maps.count()) << side_bits;
        let buffer = |name, words: u64| Buffer::new(context, name, 4 * words, Memory::Device);
        let [fluxes, greatest] = [buffer("indirect.fluxes", rows << side_bits)?, buffer("indirect.greatest", 1)?];
        let [sums, starts] = [buffer("indirect.sums", rows)?, buffer("indirect.starts", 2 * rows + 2)?];
        let picks = buffer("indirect.picks", count.into())?;
        let lights = buffer("indirect.lights", u64::from(count) * size_of::<LightData>() as u64 / 4)?;
        let lit = set::IndirectLit { lights: &world.lights, owners: &owners, sides: &world.sides, seen: &seen };
        let lit = lit.bind(context, "indirect.lit")?;
        let drawn = set::IndirectDrawn {
            fluxes: &fluxes,
            greatest: &greatest,
            sums: &sums,
            starts: &starts,
            picks: &picks,
            virtual_lights: &lights,
        };
        let drawn = drawn.bind(context, "indirect.drawn")?;
        let sets = [maps.scene(), &lit, &drawn];
        let kernels = Kernels::new(context, sets, side_bits, world.constants())?;
        let viewed = |camera| ViewImportance::new(context, world, sets, [rows as u32, side_bits], camera);
        let viewed = camera.map(viewed).transpose()?;
        let context = context.clone();
        Ok(Self {
            context,
            count,
            side_bits,
            maps,
            seen,
            fluxes,
            greatest,
            sums,
            starts,
            picks,
            lights,
            kernels,
            viewed,
        })
    }

    /// Follows another camera from the next record on. Has no effect on virtual lights created by [`Vpls::new`].
    pub fn look(&mut self, camera: &View) {
        if let Some(viewed) = &mut self.viewed {
            viewed.camera = *camera;
        }
    }

    /// Records all passes that create the virtual lights of the current world. Nothing is read back between passes.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if the world's lights are no longer those that [`Vpls::new`] saw.
    pub fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.fit(commands, world)?;
        self.map(commands, world);
        self.flux(commands);
        self.weigh(commands, world);
        self.sums(commands);
        self.scan(commands);
        self.draw(commands);
        self.virtual_lights(commands);
        Ok(())
    }

    /// Creates the virtual lights of the current world, and waits. Returns the time of each pass.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn make(&mut self, world: &World) -> Result<Vec<PassTime>> {
        let context = self.context.clone();
        let mut frame = 0;
        let times = context.try_submit(|commands| {
            frame = commands.frame();
            self.record(commands, world)
        })?;
        self.settle(frame)?;
        Ok(times)
    }

    /// Reads the views of the maps back to the host, as they were fitted in frame `frame`. Call this once the device has finished that
    /// frame.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read.
    pub fn settle(&mut self, frame: u64) -> Result<()> {
        self.maps.settle(frame, false).map(|_| ())
    }

    /// Returns the virtual lights on the device, as many as [`Vpls::new`] was given: [`LightData`] of kind 3. If no light reaches a mesh,
    /// all are black.
    pub fn lights(&self) -> &Buffer {
        &self.lights
    }

    /// Reads the virtual lights back to the host.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read.
    pub fn read(&self) -> Result<Vec<Light>> {
        Ok(self.lights.read::<LightData>(self.count as usize)?.iter().map(light_of).collect())
    }
}

/// Converts an element read back from [`Vpls::lights`] to a virtual light on the host.
#[doc(hidden)]
pub fn light_of(data: &LightData) -> Light {
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let kind = LightKind::Virtual {
        position: vec(data.position),
        normal: vec(data.direction).normalize_or(DVec3::Z),
        nearest: 1.0 / f64::from(data.falloff).sqrt(),
    };
    Light { kind, radiance: data.radiance, radius: f64::INFINITY }
}

/// The passes' buffers, read back to compare with their twin.
#[doc(hidden)]
pub struct VplsSeen {
    /// The maps, with the views that were fitted to the scene.
    pub maps: Vec<Map>,
    /// Texels per side of a map, as a power of 2.
    pub side_bits: u32,
    /// For each texel, the number of the triangle that the light sees, plus 1; 0 if it sees none. The maps are stored one after another,
    /// each row by row.
    pub triangles: Vec<u32>,
    /// Luminance of each texel's flux; with [`Vpls::by_view`], weighted by the texel's importance.
    pub fluxes: Vec<f32>,
    /// The largest of these fluxes, as the bits of a float.
    pub greatest: u32,
    /// Flux of each row of texels, in the integer units of the drawing passes.
    pub sums: Vec<u32>,
    /// Units of flux in all rows before each row, then the total; each a 64-bit number, lower word first.
    pub starts: Vec<[u32; 2]>,
    /// For each virtual light, the texel that it represents; [`u32::MAX`] if there is no flux.
    pub picks: Vec<u32>,
    /// The virtual lights.
    pub lights: Vec<LightData>,
    /// The view that the virtual lights follow, if created by [`Vpls::by_view`].
    pub view: Option<ViewSeen>,
}

/// The view that virtual lights follow; see [`VplsSeen`].
#[doc(hidden)]
pub struct ViewSeen {
    /// For each point, row by row, the number of the triangle that the camera sees, plus 1.
    pub numbers: Vec<u32>,
    /// The points.
    pub points: Vec<ViewPointData>,
    /// For each texel, the light that it sends to all points, per unit of flux.
    pub importances: Vec<f32>,
    /// The mean importance of all flux.
    pub mean: f32,
}

impl Vpls {
    /// Reads the buffers back; see [`VplsSeen`].
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if they cannot be read.
    pub fn seen(&self) -> Result<VplsSeen> {
        let words = |buffer: &Buffer| buffer.read::<u32>(buffer.bytes() as usize / 4);
        let side = 1u32 << self.side_bits;
        let (image, across) = (self.seen.read::<u32>()?, self.seen.size()[0]);
        let texels = |map: u32| {
            let [x, y] = crate::maps::opaque_corner(&self.seen, [side; 2], map);
            let row = move |row: u32| ((y + row) * across + x) as usize;
            (0..side).flat_map(move |r| row(r)..row(r) + side as usize)
        };
        Ok(VplsSeen {
            maps: self.maps.all().to_vec(),
            side_bits: self.side_bits,
            triangles: (0..self.maps.count()).flat_map(texels).map(|i| image[i]).collect(),
            fluxes: self.fluxes.read(self.fluxes.bytes() as usize / 4)?,
            greatest: words(&self.greatest)?[0],
            sums: words(&self.sums)?,
            starts: self.starts.read(self.starts.bytes() as usize / 8)?,
            picks: words(&self.picks)?,
            lights: self.lights.read(self.count as usize)?,
            view: self.viewed.as_ref().map(ViewImportance::seen).transpose()?,
        })
    }

    /// Chooses texels by the given fluxes instead of the maps' own, one per texel, so that a test can compare the choice with its twin.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device is lost.
    pub fn draw_from(&self, fluxes: &[f32]) -> Result<()> {
        self.fluxes.write(fluxes)?;
        // The flux pass would write the largest flux as bits. The bits of non-negative floats compare like their values.
        self.greatest.write(&[fluxes.iter().map(|f| f.to_bits()).max().unwrap_or(0)])?;
        self.context.submit(|commands| {
            self.sums(commands);
            self.scan(commands);
            self.draw(commands);
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_as_large_as_their_number_leaves() {
        assert_eq!([1, 64, 65, 192, 1024, 6144, 65535].map(side_bits), [8, 8, 7, 7, 6, 4, 4]);
    }
}
