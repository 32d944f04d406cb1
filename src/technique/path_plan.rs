//! What a spec comes to on a path of its technique.

use super::keys::{Name, Word, word_of};
use super::{Entry, Promises, Spec};
use crate::gpu::{Limit, Requirement};

/// A path of a technique: one way to build its representation.
#[derive(Debug)]
pub struct Path {
    /// Its name in specs.
    pub name: &'static str,
    /// What the device must have.
    pub requires: &'static [Requirement],
}

impl Path {
    /// Whether it is the path that a setting's value names.
    pub(super) fn is<T: Word + PartialEq>(&self, value: T) -> bool {
        self.name == word_of(value)
    }
}

/// What a spec needs and promises on one path.
#[derive(Clone, Debug)]
pub struct PathPlan {
    /// The path.
    pub path: &'static Path,
    /// Limits of the device; one that has less is refused. They cover a world with one light and smoke. A world with more lights needs
    /// higher ones, and one with strands or meshes may.
    pub limits: Vec<Limit>,
    /// Promises about the answers.
    pub promises: Promises,
}

impl Entry {
    /// The path of that name.
    pub fn path(&self, name: &str) -> Option<&'static Path> {
        self.paths.iter().find(|path| path.name == name)
    }
}

impl Spec {
    /// The path that it names; none where it leaves the choice to the device.
    pub fn named_path(&self) -> Option<&'static Path> {
        let has_path = self.entry.keys.iter().any(|key| key.name == Name::PATH.text());
        self.entry.path(self.text(if has_path { Name::PATH } else { Name::OPAQUE }))
    }

    /// Its plan on the path of that name, with the name that [`super::Facts::path`] has.
    pub fn plan_on(&self, path: &str) -> Option<PathPlan> {
        self.entry.path(path).map(|path| (self.entry.plan)(self, path))
    }

    /// Its plan on the path that it names, or on each of the technique's paths.
    pub fn plans(&self) -> Vec<PathPlan> {
        let named = self.named_path();
        let all = self.entry.paths.iter().filter(|path| named.is_none_or(|named| named.name == path.name));
        all.map(|path| (self.entry.plan)(self, path)).collect()
    }
}
