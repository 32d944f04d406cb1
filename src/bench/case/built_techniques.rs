//! Techniques that are built for a scene once and then asked along rays of light.

use crate::Result;
use crate::gpu::Context;
use crate::scene::Scene;
use crate::technique::{Opened, Spec, open};
use crate::world::World;

/// Techniques, each built for the same scene.
pub struct BuiltTechniques {
    /// In the order of their specs.
    pub opened: Vec<Opened>,
    /// Spec and path of each.
    pub names: Vec<String>,
    /// The scene that they were built for.
    pub world: World,
}

impl BuiltTechniques {
    /// Opens and builds the techniques of `specs`.
    ///
    /// # Errors
    /// As [`World::new`], [`open`] and [`Opened::build`].
    pub fn new(context: &Context, scene: &Scene, specs: &[Spec]) -> Result<Self> {
        let world = World::new(context, scene)?;
        let (mut opened, mut names) = (Vec::new(), Vec::new());
        for spec in specs {
            let mut technique = open(context, &world, spec)?;
            technique.build(&world)?;
            names.push(format!("{} ({})", spec.short(), technique.technique.inspect().facts()?.path));
            opened.push(technique);
        }
        Ok(Self { opened, names, world })
    }
}
