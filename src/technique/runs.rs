//! What is run of a technique where nobody names it: settings as in a spec, without the technique's name.

use super::{Entry, REGISTRY, Spec, parse};
use crate::Result;

/// A list for each command; a list may be empty.
pub struct Runs {
    /// By `compare`, of a scene of few lights or of translucent casters.
    pub compare: &'static [&'static str],
    /// By `compare`, of meshes under many lights.
    pub many_lights: &'static [&'static str],
    /// What both set otherwise on a software device, which would take minutes: keys and values.
    pub on_cpu: &'static [(&'static str, &'static str)],
    /// By `stress`, of smoke and hair: every path, in maps and grids that a software device builds in no time.
    pub stress_smoke: &'static [&'static str],
    /// By `stress`, of meshes alone. The opaque maps of all that also have smoke are the same, and one stands for them.
    pub stress_meshes: &'static [&'static str],
}

impl Runs {
    /// Nothing.
    pub const NONE: Self = Self { compare: &[], many_lights: &[], on_cpu: &[], stress_smoke: &[], stress_meshes: &[] };
}

/// One of the lists.
pub type List = fn(&Runs) -> &'static [&'static str];

impl Entry {
    /// The specs of one of its lists, each once, on a software device or another.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where a list names what is no setting.
    pub fn specs(&self, list: List, on_cpu: bool) -> Result<Vec<Spec>> {
        let mut specs: Vec<Spec> = Vec::new();
        for settings in list(&self.runs) {
            for mut spec in parse(&format!("{}:{settings}", self.name))? {
                for (key, value) in self.runs.on_cpu.iter().filter(|_| on_cpu) {
                    spec.set(key, value);
                }
                // Two lines may have one in common.
                if specs.iter().all(|other| other.to_string() != spec.to_string()) {
                    specs.push(spec);
                }
            }
        }
        Ok(specs)
    }
}

/// The same of all techniques, in the registry's order.
///
/// # Errors
/// As [`Entry::specs`].
pub fn specs(list: List, on_cpu: bool) -> Result<Vec<Spec>> {
    Ok(REGISTRY.iter().map(|entry| entry.specs(list, on_cpu)).collect::<Result<Vec<_>>>()?.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six numbers of steps and every voxel, in each of three sizes; maps of each light, and rays.
    #[test]
    fn many_lights_have_a_table_of_their_own() {
        for (on_cpu, maps) in [(false, 2), (true, 1)] {
            let specs = specs(|runs| runs.many_lights, on_cpu).expect("they are known");
            let count = |name: &str| specs.iter().filter(|spec| spec.entry.name == name).count();
            // Three sizes with seven ways each, and twelve ways to shade with two of these that are among the seven.
            assert_eq!(["voxel-grid", "shadow-map", "ray-query"].map(count), [21 + 2 * 11, maps, 1]);
            assert_eq!(specs.len(), 44 + maps);
            let mut all: Vec<_> = specs.iter().map(ToString::to_string).collect();
            all.sort();
            all.dedup();
            assert_eq!(all.len(), specs.len(), "{all:?}");
        }
    }

    /// Nobody goes unstressed: each technique in each of its paths, of smoke or of meshes.
    #[test]
    fn every_path_is_stressed() {
        for entry in REGISTRY {
            let of = |list: List| entry.specs(list, true).expect("they are known");
            let (smoke, meshes) = (of(|runs| runs.stress_smoke), of(|runs| runs.stress_meshes));
            assert_eq!(!smoke.is_empty(), entry.casts.particles || entry.casts.strands, "{}", entry.name);
            assert!(meshes.is_empty() || entry.casts.meshes, "{}", entry.name);
            let named = |path: &str| smoke.iter().chain(&meshes).any(|spec| ["", path].contains(&spec.value("path")));
            assert!(entry.paths.iter().all(|path| named(path.name)), "{}", entry.name);
        }
    }
}
