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

    /// Returns its plan on the path of that name, as in [`super::Facts::path`]. A technique opened from a file was built on no path of its
    /// own, and keeps the promises of the first.
    pub fn plan_on(&self, path: &str) -> Option<PathPlan> {
        self.entry.path(path).or(self.entry.paths.first()).map(|path| (self.entry.plan)(self, path))
    }

    /// Returns the spec's plan on the path that it names, or, if it names none, its plans on all of the technique's paths.
    pub fn plans(&self) -> Vec<PathPlan> {
        let named = self.named_path();
        let all = self.entry.paths.iter().filter(|path| named.is_none_or(|named| named.name == path.name));
        all.map(|path| (self.entry.plan)(self, path)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parse;

    /// What `gobo stress` checks must not vanish for a baked file, whose facts name the path `file`.
    #[test]
    fn a_baked_file_keeps_its_promises() {
        let of = |text: &str, path: &str| parse(text, &[]).expect(text)[0].plan_on(path).map(|plan| plan.promises);
        assert_eq!(of("voxelized:file=a", "file"), Some(Promises::OF_OPAQUE));
        assert_ne!(of("layers", "binned"), of("layers", "raster"), "drawn sums are rounded at each caster");
    }
}
