//! The specs that are compared if no technique is named.

use crate::Result;
use crate::gpu::Features;
use crate::scene::Scene;
use crate::shading::runs;
use crate::technique::runs::List;
use crate::technique::{Casts, Name, Spec};
use std::collections::BTreeSet;

/// Number of lights above which a scene of meshes counts as one of many lights.
const FEW_LIGHTS: usize = 8;

/// Whether a scene counts as one of many lights.
pub(super) fn has_many_lights(scene: &Scene) -> bool {
    scene.lights.len() > FEW_LIGHTS && scene.has_only_meshes()
}

/// Returns the specs to compare if no technique is named: each technique that sees all casters, once, and AVSM by each path that the device
/// supports. Under many lights, they use the shading intended for them.
pub(super) fn usual_specs(scene: &Scene, features: &Features) -> Result<Vec<Spec>> {
    let on_cpu = features.is_software();
    let mut specs = if has_many_lights(scene) {
        let mut known = BTreeSet::new();
        let mut specs = runs(|runs| runs.many_lights, on_cpu)?;
        specs.retain(|spec| known.insert(spec.entry.name));
        specs
    } else {
        let list: List = if on_cpu { |runs| runs.usual_on_cpu } else { |runs| runs.usual };
        without_alike(scene, runs(list, false)?)
    };
    specs.retain(|spec| runs_on(spec, features) && sees_all(spec, scene));
    Ok(specs)
}

/// Whether a technique sees all casters of a scene, or is included for comparison.
pub(super) fn sees_all(spec: &Spec, scene: &Scene) -> bool {
    spec.entry.casts == Casts::NONE || spec.entry.casts.unseen_of(scene.kinds()).is_empty()
}

/// Returns the specs that can be the answer, as far as is known before anything is measured. In a scene of meshes alone, a technique that
/// also sees smoke or hair is left out: it draws the opaque maps of `shadow-map`, answers from them alone, and builds its smoke maps in
/// addition.
pub(super) fn without_alike(scene: &Scene, mut specs: Vec<Spec>) -> Vec<Spec> {
    let has_maps = |spec: &Spec| spec.keys().any(|key| key.name == Name::OPAQUE.text());
    let is_map = |spec: &Spec| has_maps(spec) && !spec.entry.casts.particles && !spec.entry.casts.strands;
    if scene.has_only_meshes() && specs.iter().any(is_map) {
        specs.retain(|spec| !has_maps(spec) || is_map(spec));
    }
    specs
}

/// Whether the device meets the requirements of the spec's path.
fn runs_on(spec: &Spec, features: &Features) -> bool {
    let path = spec.named_path();
    path.is_none_or(|path| path.requires.iter().all(|requirement| features.lacks(*requirement).is_none()))
}

/// Returns the specs of `compare --all`. Under many lights these are all specs of the techniques' entries, so that a missing feature gives
/// a row that reports it. Otherwise they are the specs whose features the device supports.
pub(super) fn all_specs(scene: &Scene, features: &Features, many_lights: bool) -> Result<Vec<Spec>> {
    let on_cpu = features.is_software();
    if many_lights || has_many_lights(scene) {
        return runs(|runs| runs.many_lights, on_cpu);
    }
    let mut specs = runs(|runs| runs.compare, on_cpu)?;
    specs.retain(|spec| runs_on(spec, features));
    Ok(specs)
}
