//! No shadows at all: a reference for the cost of shadows and for the error of omitting them.
//!
//! Nothing is built and every point is lit: the baseline for comparisons.
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
//! let mut none = open(context, &world, &parse("none", &[])?[0])?;
//! assert!(none.build(&world)?.passes.is_empty());
//! // Above the box and below it.
//! let query = Query::new(context, 0, &[[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])?;
//! assert_eq!(query.ask(&none.technique.answer())?, [1.0, 1.0]);
//! # Ok(()) });
//! ```

use super::{Answer, Casts, Entry, Facts, Inspect, Lifetime, Path, PathPlan, Promises, Runs, Technique};
use crate::Result;
use crate::gpu::{Bindings, Commands, Constants, Context};
use crate::shaders::folder;
use crate::world::{Parts, World};

/// There are no settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Settings;

/// The technique's registry entry. Look-ups always return 1, so transmittance never rises and the order of casters does not matter. Light
/// leaks everywhere, and nothing is promised about leaks. Nothing can break it, so it is stress-tested only if named.
#[doc(hidden)]
pub const ENTRY: Entry = Entry {
    name: "none",
    about: "no shadow: all light everywhere; what shadows cost, and what leaving them out costs",
    casts: Casts::NONE,
    lifetime: Lifetime::Frame,
    keys: &[],
    paths: &[Path { name: LIT, requires: &[] }],
    plan: |_, path| PathPlan {
        path,
        limits: Vec::new(),
        promises: Promises { rise: Some(0.0), order: Some(0.0), ..Promises::NONE },
    },
    runs: Runs { usual: &[""], usual_on_cpu: &[""], compare: &[""], many_lights: &["shading=tiled"], ..Runs::NONE },
    open: |context, _, _| Ok(Box::new(Unshadowed::new(context, &Settings)?)),
};

const LIT: &str = "lit";

/// The technique.
pub struct Unshadowed {
    look_up: Bindings,
    constants: Constants,
}

impl Unshadowed {
    /// Creates the technique.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if memory runs out.
    pub fn new(context: &Context, _: &Settings) -> Result<Self> {
        Ok(Self { look_up: Bindings::new(context, "none.look_up", &[])?, constants: Constants::new() })
    }
}

impl Technique for Unshadowed {
    fn made_of(&self) -> Parts {
        Parts::NONE
    }

    fn record(&mut self, _: &mut Commands, _: &World) -> Result<()> {
        Ok(())
    }

    fn answer(&self) -> Answer<'_> {
        Answer::new(folder::NONE, &self.look_up, &self.constants)
    }

    fn inspect(&self) -> &dyn Inspect {
        self
    }
}

impl Inspect for Unshadowed {
    fn facts(&self) -> Result<Facts> {
        Ok(Facts { path: LIT, reason: "the only path".into(), ..Facts::default() })
    }
}
