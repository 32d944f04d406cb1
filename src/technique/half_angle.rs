//! Half-angle slicing: casters are sorted into slices along the half vector between light and camera. Each slice is drawn for the camera,
//! then into the light's buffer. Sources: Kniss, Premože, Hansen, Shirley and McPherson 2003, A Model for Volume Lighting and Modeling;
//! Green 2008, Volumetric Particle Shadows.
//!
//! The technique paints the picture itself: [`crate::shading::Renderer::kernels_of`] draws with it. A look-up returns only the light left
//! behind all casters, or at the first mesh; surfaces in the picture are lit by this value.
//!
//! ```
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # use example::{on_a_device, smoke};
//! # on_a_device(|context| {
//! use gobo::shading::{Lighting, Renderer, Shading};
//! use gobo::scene::View;
//! use gobo::technique::{open, parse};
//! use gobo::world::World;
//!
//! let scene = smoke();
//! let world = World::new(context, &scene)?;
//! let mut slices = open(context, &world, &parse("half-angle:size=64", &[])?[0])?;
//! slices.build(&world)?;
//! let renderer = Renderer::new(context, &world, &View::camera(&scene.camera, &scene, [32, 18]))?;
//! let kernels = renderer.kernels_of(slices.technique.as_ref(), Shading::Forward, Lighting::Fragment)?;
//! renderer.draw(&kernels)?;
//! assert!(renderer.read()?.pixels.iter().flatten().all(|channel| channel.is_finite()));
//! # Ok(()) });
//! ```

use super::keys::{Name, words};
use super::painter::{Painter, PainterKernels};
use super::settings::{Keyed, OPAQUE, SIZE, SKIP, Setting, settings};
use super::{Answer, BuildStatus, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::gpu::{Bindings, Blend, Commands, Constants, Context, Format, Image, ImageUse, Kernel, Resource, Target};
use crate::maps::{CasterQuads, DrawingOrder, Map, Maps, OpaqueMaps, OpaqueWay, QuadsPush};
use crate::scene::LightKind;
use crate::shaders::constant::ENDS_AT_MESHES;
use crate::shaders::{folder, half_angle as shaders};
use crate::world::{BuildStamp, Parts, World};
use crate::{Error, Result};
use std::sync::Arc;

words! {
    /// Storage format of a texel of the light's buffer.
    pub enum Storage {
        /// 8 bits.
        R8 = "r8",
        /// A half float.
        R16f = "r16f",
        /// 32 bits.
        R32f = "r32f",
    }
}

settings! {
    /// Settings of the technique.
    #[derive(Copy)]
    pub struct Settings {
        /// Number of slices, each with the same number of casters: 32, 64 or 128.
        slices: u32 = Setting::one_of("64", &["32", "64", "128"], "slices along the half vector, of as many casters each");
        /// Texels per side of the light's buffer, 1 to 16,384.
        size: u32 = SIZE;
        /// Storage format of a texel of the light's buffer.
        storage: Storage = Setting::word("r16f", "8 bits per texel of the light's buffer, half floats (as published), or 4 bytes");
        /// How the opaque maps are drawn. `None`: compute passes on GPUs, the rasterizer elsewhere.
        opaque: Option<OpaqueWay> = OPAQUE;
    }
    every {
        /// Whether builds are skipped if nothing has changed.
        skip: bool = SKIP;
    }
}

/// The technique's registry entry. Look-ups return only the light behind all casters, or at the first mesh, so nothing is promised about
/// how results change with depth. The order of casters affects results only through rounding in blending.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "half-angle",
    about: "slices along the half vector of light and camera; paints the picture, has no look-up in space (Kniss 2003, Green 2008)",
    casts: Casts::ALL,
    lifetime: Lifetime::Frame,
    keys: Settings::KEYS,
    paths: &[Path { name: SLICED, requires: &[] }],
    plan: |_, path| PathPlan { path, limits: Vec::new(), promises: Promises::OF_NO_DEPTH },
    runs: Runs {
        usual: &[""],
        usual_on_cpu: &["size=128"],
        compare: &[""],
        on_cpu: &[(Name::SIZE, "64")],
        stress_smoke: &["size=32,slices=32,storage=r16f|r8|r32f"],
        ..Runs::NONE
    },
    open: |context, world, spec| Ok(Box::new(HalfAngle::new(context, world, &spec.settings())?)),
};

const SLICED: &str = "sliced";

/// The technique, opened for one world.
pub struct HalfAngle {
    maps: Maps,
    /// Light left behind all casters that are in front of the nearest mesh.
    whole: Image,
    quads: CasterQuads,
    draw: Kernel<QuadsPush>,
    written: BuildStamp,
    painter: Arc<Painter>,
    look_up: Bindings,
    constants: Constants,
}

impl HalfAngle {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`Error::Input`] if a setting's value is not allowed; [`Error::Refused`] if there are several lights or a point light, or if the
    /// device cannot blend the format of `storage`; [`Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, world: &World, settings: &Settings) -> Result<Self> {
        settings.check()?;
        world.one_color("slices leave")?;
        let Settings { slices, size, storage, opaque, skip: _ } = *settings;
        if world.light_count() != 1 || world.map_count() != 1 {
            let needs =
                "one light, directional or a spot: slices lie along the half vector of one light and the camera";
            return Err(Error::Refused(needs.into()));
        }
        if storage == Storage::R32f && !context.features().float32_blend {
            return Err(Error::Refused("blending into 32-bit floats, or storage=r16f".into()));
        }
        let format = match storage {
            Storage::R8 => Format::R8_UNORM,
            Storage::R16f => Format::R16_SFLOAT,
            Storage::R32f => Format::R32_SFLOAT,
        };
        let maps = Maps::new(context, world, size, OpaqueMaps::shared(opaque))?;
        let constants = world.constants();
        let whole = Image::new(context, "half_angle.whole", format, maps.size(), ImageUse::Color)?;
        let quads = CasterQuads::new(context, world, &maps, DrawingOrder::Index, None)?;
        let cut = constants.clone().set(ENDS_AT_MESHES, world.triangle_capacity() > 0);
        let kernels = PainterKernels {
            name: "half_angle.light",
            slices,
            format,
            fragment: &shaders::LIGHT_FRAG,
            keys: &shaders::KEYS,
            constants: &constants,
        };
        Ok(Self {
            draw: quads.kernel(context, &maps, kernels.fragment, &[(format, Blend::Multiply)], &[], &cut)?,
            painter: Arc::new(Painter::new(context, world, &maps, &kernels)?),
            look_up: maps.look_up(context, "half_angle.look_up", &[Resource::Texture(whole.clone())])?,
            written: BuildStamp::of(Maps::VOLUME.and(Maps::OPAQUE)),
            maps,
            whole,
            quads,
            constants,
        })
    }

    fn light(&self, commands: &mut Commands) {
        commands.pass("half_angle.light", |pass| {
            let target = Target { image: &self.whole, clear: Some([1.0; 4]) };
            pass.render(self.whole.size(), &[target], None, |draw| self.quads.draw(draw, &self.draw, 0..1, 0, 0));
        });
    }
}

impl Technique for HalfAngle {
    fn made_of(&self) -> Parts {
        Maps::VOLUME.and(Maps::OPAQUE)
    }

    fn forget(&mut self) {
        self.maps.forget();
        self.written.forget();
    }

    fn record(&mut self, commands: &mut Commands, world: &World) -> Result<()> {
        self.maps.record(commands, world)?;
        // If only the device knows the light, slices keep the last known direction.
        if let (true, Some(LightKind::Directional { direction } | LightKind::Spot { direction, .. })) =
            (world.knows_lights(), world.all_lights().first().map(|light| light.kind))
        {
            self.painter.set_forward(direction.normalize().as_vec3().into());
        }
        if self.written.make(world) {
            self.quads.record(commands, world, &self.maps, None);
            self.light(commands);
        }
        Ok(())
    }

    fn settle(&mut self, frame: u64) -> Result<BuildStatus> {
        let grew = self.maps.settle(frame, false)?;
        if grew {
            self.written.forget();
        }
        if let Some(map) = self.maps.all().first() {
            self.painter.set_forward(map.caster_view.forward);
        }
        Ok(BuildStatus::of(grew))
    }

    fn answer(&self) -> Answer<'_> {
        Answer { painter: Some(&self.painter), ..Answer::new(folder::HALF_ANGLE, &self.look_up, &self.constants) }
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for HalfAngle {
    fn maps(&self) -> &[Map] {
        self.maps.all()
    }

    fn facts(&self) -> Result<Facts> {
        Ok(Facts {
            path: SLICED,
            reason: "the only path".into(),
            bytes_resident: self.whole.bytes() + self.painter.bytes() + self.maps.opaque_image().bytes(),
            bytes_transient: self.maps.opaque_bytes_transient(),
            ..Facts::default()
        })
    }
}
