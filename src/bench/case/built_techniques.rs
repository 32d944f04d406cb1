//! Techniques that are built once for a scene and then queried along light rays.

use crate::Result;
use crate::gpu::Context;
use crate::scene::Scene;
use crate::technique::{Opened, Spec, open};
use crate::world::World;

/// Techniques, each built for the same scene.
pub struct BuiltTechniques {
    /// The techniques, in the order of their specs.
    pub opened: Vec<Opened>,
    /// Spec and path of each technique.
    pub names: Vec<String>,
    /// The world they were built for.
    pub world: World,
}

impl BuiltTechniques {
    /// Opens and builds the techniques of `specs`.
    ///
    /// # Errors
    /// See [`World::new`], [`open`] and [`Opened::build`].
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
