//! How much of light `l` reaches point `p`? Shadow techniques for smoke, hair, foliage and meshes.
//!
//! A [`technique`] builds a representation of a [`world`] on the GPU and answers with one GLSL function,
//! `float light_visibility(uint light, vec3 position)`. Its callers need to know nothing else: the queries and pictures in [`query`] and
//! [`shading`], or a shader of your own.
//!
//! # In an engine
//!
//! This code follows docs/guide/embedding.md, which explains what each step requires. examples/minimal.rs also opens the device, and
//! examples/engine is a whole renderer.
//!
//! ```
//! use glam::DVec3;
//! use gobo::query::Query;
//! use gobo::gpu::{Buffer, Commands, Context, ReadBack};
//! use gobo::scene::{Light, LightKind};
//! use gobo::technique::{Avsm, Technique, avsm};
//! use gobo::world::{Capacity, Count, Source, SphereAt, World};
//!
//! # mod engine { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/minimal.rs")); }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let Ok(engine) = engine::Engine::open(&[gobo::gpu::Enabled::FLOOR]) else { return Ok(println!("skipped: no device")) };
//! // Once, 1 and 2. SAFETY: the engine's handles live longer, and the device was opened with what is said of it.
//! let context = unsafe { Context::adopt(engine.adopt()) }?;
//! // Once, 3. `Buffer::adopt` takes a buffer of the engine's; this one is Gobo's: x, y, z, radius, extinction.
//! let mut world = World::of(&context, Capacity { particles: 1, lights: 1, ..Default::default() })?;
//! let buffer = Buffer::with_data(&context, "smoke", &[0.0f32, 0.0, 1.0, 0.5, 2.0])?;
//! let smoke = Source { buffer, offset: 0, stride: 20, count: Count::Host(1) };
//! let kind = LightKind::Directional { direction: DVec3::NEG_Z };
//! let sun = Light { kind, radiance: [1.0; 3], radius: f64::INFINITY };
//!
//! // Once, 4. SAFETY: the commands are being recorded, and are submitted once and in order.
//! world.update_lights(&mut unsafe { Commands::on(&context, engine.begin(0)?, 0) }?, &[sun])?;
//! engine.submit(0)?;
//! // Once, 5.
//! let mut avsm = Avsm::new(&context, &world, &avsm::Settings { nodes: 8, size: 64, ..Default::default() })?;
//!
//! // Once, 6. In place of the engine's shader a query asks, below the smoke.
//! let query = Query::new(&context, 0, &[[0.0; 3]])?;
//! let (kernel, read) = (query.kernel(&avsm.answer())?, ReadBack::new(&context, "light", 4)?);
//! for frame in 1..8 {
//!     // Each frame, 1.
//!     let commands = engine.begin(frame)?;
//!     avsm.settle(frame.saturating_sub(2))?;
//!     // Each frame, 3. SAFETY: as above; frame − 2 is over.
//!     let mut commands = unsafe { Commands::on(&context, commands, frame) }?;
//!     world.update_particles(&mut commands, &smoke, SphereAt::PARTICLE)?;
//!     avsm.record(&mut commands, &world)?;
//!     // Each frame, 4 and 5: the query has its own set.
//!     query.record(&mut commands, &kernel);
//!     commands.read_back(query.buffer(), &read);
//!     commands.end();
//!     engine.submit(frame)?;
//! }
//! engine.wait()?;
//! let light = read.read::<f32>(7, 1)?.expect("frame 7 is over");
//! assert!((light[0] - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) }
//! ```
//!
//! # On a device of Gobo's own
//!
//! The same, on a device that [`gpu::Context::new`] opens and with a [`scene::Scene`] on the host:
//!
//! ```
//! use gobo::scene::{Particle, Scene};
//! use gobo::{query::Query, gpu::Context, technique, world::World};
//!
//! # mod example { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/example.rs")); }
//! # example::on_a_device(|_| {
//! // The default has a light that shines straight down.
//! let scene = Scene {
//!     name: "a ball of smoke".into(),
//!     particles: vec![Particle { position: [0.0, 0.0, 1.0], radius: 0.5, extinction: 2.0 }],
//!     ..Scene::default()
//! };
//! let context = Context::new(&Default::default())?;
//! let world = World::new(&context, &scene)?;
//! let mut avsm = technique::open(&context, &world, &technique::parse("avsm:nodes=8,size=64", &[])?[0])?;
//! avsm.build(&world)?;
//! // One unit of smoke, of extinction 2, stands between the light and the origin.
//! let light = Query::new(&context, 0, &[[0.0; 3]])?.ask(&avsm.technique.answer())?;
//! assert!((light[0] - (-2f32).exp()).abs() < 0.02);
//! # Ok(()) });
//! ```
//!
//! # Techniques
//!
//! `docs/techniques/NAME.md` explains what each technique stores, how it is built and what it is good at; its module has an example.
//! [`technique::REGISTRY`] lists the techniques as data.
//!
//! | Technique | Casts from | Built |
//! |---|---|---|
//! | avsm | all kinds of casters | each frame |
//! | deep-shadow-map | all kinds of casters | each frame |
//! | psm | all kinds of casters | each frame |
//! | layers | all kinds of casters | each frame |
//! | fourier | all kinds of casters | each frame |
//! | moments | all kinds of casters | each frame |
//! | wavelet | all kinds of casters | each frame |
//! | beer-shadow-map | all kinds of casters | each frame |
//! | half-angle | all kinds of casters | each frame |
//! | translucency-map | all kinds of casters | each frame |
//! | stochastic | all kinds of casters | each frame |
//! | uncompressed | all kinds of casters | each frame |
//! | marched | all kinds of casters | each frame |
//! | density-grid | all kinds of casters | each frame |
//! | optical-depth-grid | all kinds of casters | each frame |
//! | grid-query | all kinds of casters | each frame |
//! | voxel-grid | all kinds of casters | each frame |
//! | shadow-map | meshes | each frame |
//! | ism | meshes | each frame |
//! | ray-query | all kinds of casters | each frame |
//! | none | nothing | each frame |
//! | voxelized | meshes | once |
//!
//! # What is where
//!
//! [`gpu`] wraps Vulkan and knows no technique. [`scene`] describes casters and lights on the host; [`world`] holds their current state on
//! the device. `maps` and `grid` hold code that techniques share. A failure is an [`Error`], which names the operation, the object, the
//! cause and a [`WayOut`]. A device that lacks a feature gets a refusal that names the feature ([`Error::Refused`]), never a wrong answer.
//!
//! # Features
//!
//! `program`, on by default: the program `gobo`, scene files and built-in scenes, the f64 reference, measurements and reports. An engine
//! turns it off with `default-features = false` and then depends on few other crates: ash, glam, gpu-allocator, bytemuck, thiserror and
//! their dependencies.

#![deny(missing_docs, unsafe_code)]

#[cfg(feature = "program")]
mod advice;
#[cfg(feature = "program")]
pub mod animate;
#[cfg(feature = "program")]
#[doc(hidden)]
pub mod bench;
#[cfg(feature = "program")]
#[doc(hidden)]
pub mod cli;
mod error;
pub mod glsl;
#[allow(unsafe_code)]
pub mod gpu;
#[doc(hidden)]
pub mod grid;
pub mod lights;
#[doc(hidden)]
pub mod maps;
pub mod query;
#[cfg(feature = "program")]
#[doc(hidden)]
pub mod reference;
#[cfg(feature = "program")]
#[doc(hidden)]
pub mod report;
pub mod scene;
#[doc(hidden)]
pub mod shaders;
pub mod shading;
pub mod technique;
#[cfg(feature = "view")]
mod view;
pub mod world;

#[cfg(feature = "program")]
use error::one_of;
pub use error::{Error, GpuCause, Less, Need, Result, WayOut};
pub use technique::requirements;

#[cfg(test)]
mod tests {
    use crate::technique::{Entry, Lifetime, REGISTRY};

    /// The table above has one row per technique, and each row agrees with the registry.
    #[test]
    fn the_first_page_is_right() {
        let table = include_str!("lib.rs").lines().skip_while(|line| *line != "//! |---|---|---|").skip(1);
        let mut rows: Vec<_> = table.take_while(|line| line.starts_with("//! |")).map(String::from).collect();
        let of = |entry: &&Entry| {
            let built = if entry.lifetime == Lifetime::Baked { "once" } else { "each frame" };
            format!("//! | {} | {} | {built} |", entry.name, entry.casts.names())
        };
        let mut are: Vec<_> = REGISTRY.iter().map(of).collect();
        rows.sort();
        are.sort();
        assert_eq!(rows, are);
    }
}
