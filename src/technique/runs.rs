//! Which specs of a technique run if a command names none: settings as in a spec, without the technique's name.

use super::keys::Name;
use super::{Entry, Key, REGISTRY, Spec, parse};
use crate::Result;

/// Specs of a technique, one list per command and kind of scene; a list may be empty.
pub struct Runs {
    /// Run by `compare`: the technique on its best path, and runs that show what device features gain.
    pub usual: &'static [&'static str],
    /// Run by `compare` on a software device: sizes at which techniques differ, without runs that would take minutes.
    pub usual_on_cpu: &'static [&'static str],
    /// Run by `compare --all`, for a scene with few lights or with translucent casters.
    pub compare: &'static [&'static str],
    /// Run by `compare --all`, for meshes under many lights.
    pub many_lights: &'static [&'static str],
    /// Keys and values that override the other lists on a software device, where the original values would take minutes.
    pub on_cpu: &'static [(Name, &'static str)],
    /// Run by `stress` on smoke and hair: every path, with maps and grids that a software device builds quickly.
    pub stress_smoke: &'static [&'static str],
    /// Run by `stress` on meshes alone. Techniques that also see smoke share the same opaque maps, so one of them is enough here.
    pub stress_meshes: &'static [&'static str],
}

impl Runs {
    /// No runs.
    pub const NONE: Self = Self {
        usual: &[],
        usual_on_cpu: &[],
        compare: &[],
        many_lights: &[],
        on_cpu: &[],
        stress_smoke: &[],
        stress_meshes: &[],
    };
}

/// Selects one of the lists.
pub type List = fn(&Runs) -> &'static [&'static str];

impl Entry {
    /// Returns the specs of one of the technique's lists, without duplicates. `on_cpu`: for a software device. `more`: further keys, as in
    /// [`parse`].
    ///
    /// # Errors
    /// [`crate::Error::Input`] if a list has a setting that does not exist.
    pub fn specs(&self, list: List, on_cpu: bool, more: &'static [Key]) -> Result<Vec<Spec>> {
        let mut specs: Vec<Spec> = Vec::new();
        for settings in list(&self.runs) {
            for mut spec in parse(&format!("{}:{settings}", self.name), more)? {
                for (key, value) in self.runs.on_cpu.iter().filter(|_| on_cpu) {
                    spec.set(*key, value);
                }
                // Two lines of a list may expand to the same spec.
                if specs.iter().all(|other| other.to_string() != spec.to_string()) {
                    specs.push(spec);
                }
            }
        }
        Ok(specs)
    }
}

/// Same as [`Entry::specs`], but for all techniques in the registry's order.
///
/// # Errors
/// Same as [`Entry::specs`].
pub fn specs(list: List, on_cpu: bool, more: &'static [Key]) -> Result<Vec<Spec>> {
    Ok(REGISTRY.iter().map(|entry| entry.specs(list, on_cpu, more)).collect::<Result<Vec<_>>>()?.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::Casts;

    /// Asserts that every path of every technique is stress-tested, on smoke or on meshes.
    #[test]
    fn every_path_is_stressed() {
        // A technique that sees no caster has nothing that could break.
        for entry in REGISTRY.iter().filter(|entry| entry.casts != Casts::NONE) {
            let of = |list: List| entry.specs(list, true, &[]).expect("they are known");
            let (smoke, meshes) = (of(|runs| runs.stress_smoke), of(|runs| runs.stress_meshes));
            assert_eq!(!smoke.is_empty(), entry.casts.particles || entry.casts.strands, "{}", entry.name);
            assert!(meshes.is_empty() || entry.casts.meshes, "{}", entry.name);
            let named =
                |path: &str| smoke.iter().chain(&meshes).any(|spec| ["", path].contains(&spec.text(Name::PATH)));
            assert!(entry.paths.iter().all(|path| named(path.name)), "{}", entry.name);
        }
    }
}
