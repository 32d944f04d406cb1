//! A depth map of the meshes, with percentage closer filtering. Sources: Williams 1978, *Casting curved shadows on curved surfaces*;
//! Reeves, Salesin and Cook 1987, *Rendering antialiased shadows with depth maps*.
//!
//! A baseline: what most engines use.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, solid};
//! # on_a_device(|context| {
//! use gobo::query::Query;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let world = World::new(context, &solid())?;
//! let mut map = open(context, &world, &parse("shadow-map:size=64", &[])?[0])?;
//! map.build(&world)?;
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! let [above, below] = query.ask(&map.technique.answer())?[..] else { panic!("two answers") };
//! assert!(above == 1.0 && below == 0.0);
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::settings::{Keyed, OPAQUE, PCF, Setting, settings};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Commands, Constants, Context, Format, Image, Limit};
use crate::maps::{AlphaTest, Map, Maps, OpaqueMaps, OpaqueWay};
use crate::scene::{Light, LightKind, Resolution, gutter_texels};
use crate::shaders::{constant, folder};
use crate::world::{Parts, World};
use crate::{Error, Result};

/// The technique's registry entry.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "shadow-map",
    about: "the depth of the nearest mesh per texel, compared (Williams 1978; Reeves, Salesin and Cook 1987)",
    casts: Casts::MESHES,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: RASTER, requires: &[] }, Path { name: COMPUTE, requires: &[] }],
    plan: |spec, path| PathPlan {
        path,
        limits: vec![Limit::image_2d(spec.settings::<Settings>().size.into())],
        promises: promises(&spec.settings()),
    },
    runs: Runs {
        usual: &[""],
        usual_on_cpu: &[""],
        many_lights: &["shading=tiled,size=128|512"],
        on_cpu: &[(Name::SIZE, "64")],
        stress_meshes: &["size=32"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(ShadowMap::new(context, world, &spec.settings())?)),
};

/// Levels of textures cut other holes than the truth's, wherever the map's texels are larger than the texture's.
fn promises(settings: &Settings) -> Promises {
    let by_levels = matches!(settings.alpha, AlphaTest::Coverage | AlphaTest::Hash);
    Promises { wrong: Promises::OF_OPAQUE.wrong.filter(|_| !by_levels), ..Promises::OF_OPAQUE }
}

const RASTER: &str = "raster";
const COMPUTE: &str = "compute";

words! {
    /// Bits per depth.
    pub enum Bits {
        /// An integer.
        Sixteen = "16",
        /// A float.
        ThirtyTwo = "32",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Texels per side of a light's map, 1 to 16,384, if the device supports images that large.
        size: u32 = Setting::number("1024", 1, 16384, "texels per side of a light's map");
        /// Bits per depth.
        bits: Bits = Setting::word("32", "bits of a depth: whole numbers of 16, or floats of 32");
        /// Texels per side of the square whose comparisons a look-up averages: 1, 3, 5, 7 or 9 (Reeves, Salesin and Cook 1987).
        filter: u32 = PCF;
        /// How far a point is moved along its surface normal before the look-up, in hundredths of the filter's extent along the normal: 7
        /// to 1,000. A bias of 7 exceeds the subpixel step of the coarsest rasterizer, 1/16 of a texel.
        bias: u32 = Setting::number("15", 7, 1000, "offset along a surface's normal, hundredths of the filter's side");
        /// Number of maps per directional light in front of the camera, 1 to 4; each is half as wide as the one before.
        cascades: u32 = Setting::number("1", 1, 4, "maps of a directional light in front of the camera, each half as wide as the one before");
        /// What alpha of triangles means.
        alpha: AlphaTest = Setting::word("cut",
            "triangles with alpha: cut at full resolution, by levels that keep coverage, by levels at random, or whole");
        /// How the maps are drawn. `None`: compute passes on GPUs if depths have 32 bits, else the rasterizer.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
}

/// Smallest filter sizes at which texels are gathered four at a time instead of fetched one by one. The first is for GPUs; the second is
/// for software devices, where a gather of four takes as long as two to four fetches.
const GATHERED: [u32; 2] = [3, 5];

/// The technique, opened for one world.
pub struct ShadowMap {
    maps: Maps,
    opaque: OpaqueMaps,
    /// The maps as callers see them, which are the opaque maps alone. Empty before the first build.
    all: Vec<Map>,
    look_up: Bindings,
    constants: Constants,
    /// Reason for the choice of drawing method, if the settings leave it open.
    reason: String,
}

impl ShadowMap {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device does not support maps of that size or the world does not allow cascades; [`Error::Input`] if a
    /// setting's value is not allowed, or the filter is too wide for the faces of a point light; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        let Settings { size, bits, filter: side, bias, cascades, alpha, opaque: way } = *settings;
        if let Some(needs) = Limit::image_2d(size.into()).lacks(context.features(), "") {
            return Err(Error::Refused(needs));
        }
        check_faces(world, size, side)?;
        if matches!(alpha, AlphaTest::Coverage | AlphaTest::Hash) && world.has_alpha() && world.scene().is_err() {
            return Err(Error::Refused("alpha of a scene: buffers of the caller's have no levels".into()));
        }
        check_cascades(world, cascades)?;
        let format = match bits {
            Bits::Sixteen => Format::D16_UNORM,
            Bits::ThirtyTwo => Format::D32_SFLOAT,
        };
        let normal_bias = side as f32 * bias as f32 / 100.0;
        // The reach is half the filter's side: from the centre of the corner texel to the far corner of the central texel.
        let opaque = OpaqueMaps { size, format, reach: side as f32 / 2.0, normal_bias, cascades, alpha, way };
        let maps = Maps::with_opaque(context, world, size, opaque)?;
        let look_up = maps.look_up(context, "shadow_map.look_up", &[])?;
        let gathers = side >= GATHERED[usize::from(context.features().is_software())];
        let reason = match opaque.format {
            Format::D16_UNORM => "auto: depths of 16 bits are drawn".to_owned(),
            _ => format!("auto: {} device", context.features().kind),
        };
        let constants = Constants::new()
            .set(constant::PCF, side)
            .set(constant::GATHERS, gathers)
            .set(constant::NORMAL_BIAS, normal_bias)
            .set(constant::CASCADES, cascades)
            .set(constant::CASCADE_MAPS, world.map_count() as u32);
        Ok(Self { all: Vec::new(), maps, opaque, look_up, constants, reason })
    }

    /// Returns the depths of all maps, each placed at its [`crate::maps::opaque_corner`].
    pub fn image(&self) -> &Image {
        self.maps.opaque_image()
    }
}

/// Returns the maps as callers see them: both views of each map are set to the view from which its depths are drawn. Lists only the widest
/// cascade, since the other cascades have finer texels.
fn seen(maps: &Maps, cascades: u32) -> Vec<Map> {
    let all = maps.all();
    all[..all.len() / cascades as usize].iter().map(|map| Map { caster_view: map.opaque, opaque: map.opaque }).collect()
}

/// Checks that the filter fits: at the edge of a point light's face, look-ups read texels from the face's margin.
fn check_faces(world: &World, size: u32, side: u32) -> Result<()> {
    // One texel more than the filter reaches, to allow for rounding.
    let needed = side / 2 + 1;
    if world.has_faces() && (size < 4 || needed > gutter_texels(size)) {
        let cause = "too small for this filter across the edges of a point light's faces";
        let least = if needed == 1 { 4 } else { 8 * needed };
        let way_out = format!("use a size of {least} or more, or a smaller filter");
        return Err(Error::input(format!("a map of size {size}"), cause, way_out));
    }
    Ok(())
}

/// Checks that the world allows cascades: they are placed in front of a camera, and all lights must be directional.
fn check_cascades(world: &World, cascades: u32) -> Result<()> {
    let directional = |light: &Light| matches!(light.kind, LightKind::Directional { .. });
    let needs = match cascades {
        1 => return Ok(()),
        _ if !world.aim().lights.iter().all(directional) => "directional lights alone",
        _ if world.camera().is_none() => "a camera, in front of which they stand (World::set_camera)",
        _ => return Ok(()),
    };
    Err(Error::Refused(format!("{needs} for cascades={cascades}").into()))
}

impl Technique for ShadowMap {
    /// Leaves out smoke and hair, which the technique does not see.
    fn made_of(&self) -> Parts {
        if self.opaque.cascades > 1 { Maps::OPAQUE.and(Parts::CAMERA) } else { Maps::OPAQUE }
    }

    fn forget(&mut self) {
        self.maps.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        check_cascades(world, self.opaque.cascades)?;
        self.maps.record(commands, world)?;
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.maps.settle(frame, false)?;
        self.all = seen(&self.maps, self.opaque.cascades);
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::SHADOW_MAP, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for ShadowMap {
    fn maps(&self) -> &[Map] {
        &self.all
    }

    fn resolution(&self) -> Vec<Resolution> {
        self.all.iter().map(|map| self.opaque.resolution(map.opaque)).collect()
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: if self.maps.opaque_way() == OpaqueWay::Raster { RASTER } else { COMPUTE },
            reason: if self.opaque.way.is_some() { "asked for".into() } else { self.reason.clone() },
            bytes_resident: self.image().bytes(),
            bytes_transient: self.maps.opaque_bytes_transient(),
            ..Facts::default()
        })
    }
}
