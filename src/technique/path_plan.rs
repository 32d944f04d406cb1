//! Plan of a spec on a path of its technique: what it requires of the device, and what it promises.

use super::keys::{Name, Word, word_of};
use super::{Entry, Promises, Spec};
use crate::gpu::{Limit, Requirement};

/// A path of a technique: one way to build its representation.
#[derive(Debug)]
pub struct Path {
    /// Name in specs.
    pub name: &'static str,
    /// Features that the device must have.
    pub requires: &'static [Requirement],
}

impl Path {
    /// Returns whether `value` is the word for this path in specs.
    pub(super) fn is<T: Word + PartialEq>(&self, value: T) -> bool {
        self.name == word_of(value)
    }
}

/// What a spec requires of the device and promises on one path.
#[derive(Clone, Debug)]
pub struct PathPlan {
    /// The path.
    pub path: &'static Path,
    /// Limits that the device must meet. They suffice for a world with one light and smoke. A world with more lights needs higher limits,
    /// and one with strands or meshes may.
    pub limits: Vec<Limit>,
    /// Promises about results.
    pub promises: Promises,
}

impl Entry {
    /// Returns the path named `name`.
    pub fn path(&self, name: &str) -> Option<&'static Path> {
        self.paths.iter().find(|path| path.name == name)
    }
}

impl Spec {
    /// Returns the path that the spec names. `None` if the spec leaves the choice to the device.
    pub fn named_path(&self) -> Option<&'static Path> {
        let has_path = self.entry.keys.iter().any(|key| key.name == Name::PATH.text());
        self.entry.path(self.text(if has_path { Name::PATH } else { Name::OPAQUE }))
    }

    /// Returns the spec's plan on the path named `path`, a name as in [`super::Facts::path`]. `None` if the technique has no path of that
    /// name.
    pub fn plan_on(&self, path: &str) -> Option<PathPlan> {
        self.entry.path(path).map(|path| (self.entry.plan)(self, path))
    }

    /// Returns the spec's plan on the path that it names, or, if it names none, its plans on all of the technique's paths.
    pub fn plans(&self) -> Vec<PathPlan> {
        let named = self.named_path();
        let all = self.entry.paths.iter().filter(|path| named.is_none_or(|named| named.name == path.name));
        all.map(|path| (self.entry.plan)(self, path)).collect()
    }
}
