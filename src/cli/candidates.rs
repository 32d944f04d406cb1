//! The candidates of `gobo recommend`: every spec that may be the answer, and those that remain after a first look.

use crate::Result;
use crate::bench::Row;
use crate::cli::default_specs::{has_many_lights, sees_all};
use crate::cli::test_reduction;
use crate::report::{Limits, best_and_extremes, is_hopeless, to_be_sized};
use crate::scene::Scene;
use crate::shading::{KEYS, parse, runs};
use crate::technique::{Lifetime, Name, REGISTRY, Spec};
use std::collections::BTreeSet;

/// Returns the specs whose technique sees all casters of the scene, and `none`. These are `specs`, which come from `compare`, and one spec
/// of each technique that `specs` lacks. In a scene of meshes alone, a technique that `specs` lacks gets a spec for each of its ways to
/// store meshes. A technique in `specs` then keeps only its first spec, since the way it stores smoke does not change its opaque maps.
pub fn candidates(scene: &Scene, mut specs: Vec<Spec>, on_cpu: bool, many_lights: bool) -> Result<Vec<Spec>> {
    let only_meshes = scene.has_only_meshes();
    if !many_lights && !has_many_lights(scene) {
        if only_meshes {
            let mut known = BTreeSet::new();
            specs.retain(|spec| known.insert(spec.entry.name));
        }
        let of_meshes = runs(|runs| runs.stress_meshes, on_cpu)?;
        // Specs that a software device builds quickly.
        let of_smoke = runs(|runs| runs.stress_smoke, on_cpu)?;
        for entry in REGISTRY {
            if specs.iter().any(|spec| spec.entry.name == entry.name) {
                continue;
            }
            let is_its = |spec: &&Spec| spec.entry.name == entry.name;
            let usual = parse(entry.name)?;
            if only_meshes {
                // All ways to store meshes, in their usual size, and four times as large unless a bake would take long.
                let size = |spec: &Spec| {
                    let mut spec = spec.clone();
                    Name::SIZES.iter().for_each(|name| spec.set(*name, usual[0].text(*name)));
                    spec
                };
                let ways: Vec<Spec> = of_meshes.iter().filter(is_its).map(size).collect();
                let ways = if ways.is_empty() { usual } else { ways };
                let more = ways.iter().filter(|_| entry.lifetime == Lifetime::Frame);
                let more: Vec<Spec> = more.filter_map(|spec| sized(spec, |size| size.saturating_mul(4))).collect();
                specs.extend(ways);
                specs.extend(more);
            } else if on_cpu {
                specs.extend(of_smoke.iter().find(is_its).cloned());
            } else {
                specs.extend(usual);
            }
        }
    }
    specs.retain(|spec| sees_all(spec, scene));
    Ok(specs)
}

/// Whether a few specs of a technique are enough to show that it is far from the best. They are not in a scene of meshes alone or under
/// many lights, where specs of a technique store meshes in different ways, one of which may be exact; nor with limits, since techniques far
/// from the best may be the only ones within the limits.
pub fn may_be_far(scene: &Scene, limits: &Limits, many_lights: bool) -> bool {
    !scene.has_only_meshes() && !many_lights && limits.are_none()
}

/// Returns one spec of each path of each technique, the one that sets the fewest keys, and all other specs. Paths build the same data
/// faster or slower, and which path is fastest depends on the device.
pub fn one_of_each(specs: &[Spec]) -> (Vec<Spec>, Vec<Spec>) {
    let keys = |spec: &Spec| spec.short().matches('=').count();
    let way = |spec: &Spec| (spec.entry.name, spec.variant().get("path").cloned());
    let is_first = |(place, spec): &(usize, &Spec)| {
        let alike = specs.iter().enumerate().filter(|(_, other)| way(other) == way(spec));
        alike.min_by_key(|(_, other)| keys(other)).is_some_and(|(first, _)| first == *place)
    };
    let (first, others): (Vec<_>, Vec<_>) = specs.iter().enumerate().partition(is_first);
    let specs = |all: Vec<(usize, &Spec)>| all.into_iter().map(|(_, spec)| spec.clone()).collect();
    (specs(first), specs(others))
}

/// Returns the first spec of each group whose specs differ only in keys that affect pictures alone, and all other specs.
pub fn one_of_each_shading(specs: &[Spec]) -> (Vec<Spec>, Vec<Spec>) {
    let mut known = BTreeSet::new();
    specs.iter().cloned().partition(|spec| known.insert(built(spec)))
}

/// Returns the specs that differ only in shading from one of `seen` that is the best, fastest, closest or smallest so far.
pub fn shadings(specs: &[Spec], seen: &[Spec], rows: &[Row]) -> Vec<Spec> {
    let found: BTreeSet<String> =
        best_and_extremes(rows, &Limits::default()).into_iter().map(|place| built(&seen[place])).collect();
    specs.iter().filter(|spec| found.contains(&built(spec))).cloned().collect()
}

/// Returns the specs that are not hopeless, and the best specs so far at half and at twice their size, since these may be better.
pub fn promising(specs: &[Spec], rows: &[Row], limits: &Limits) -> Vec<Spec> {
    let found = best_and_extremes(rows, limits);
    let stays = |place: usize| found.contains(&place) || !is_hopeless(&rows[place], rows, limits);
    let mut left: Vec<usize> = (0..rows.len()).filter(|place| stays(*place)).collect();
    if limits.flip.is_none() {
        // Specs that differ only in shading have equal errors at points: only a picture would tell them apart. The fastest stays.
        let is_quicker = |a: usize, b: usize| {
            let host = |row: &Row| row.host_ns.map(|host| host.median);
            let ns = |place: usize| {
                rows[place].cost_ns.or(rows[place].frame_ns).or(host(&rows[place])).unwrap_or(f64::INFINITY)
            };
            ns(a).total_cmp(&ns(b)).then(a.cmp(&b)).is_lt()
        };
        let others = left.clone();
        // Marked times cannot tell shadings apart: all stay, and pictures decide.
        let is_beaten = |place: usize| {
            rows[place].marks.is_empty()
                && others.iter().any(|other| is_quicker(*other, place) && built(&specs[*other]) == built(&specs[place]))
        };
        left.retain(|place| found.contains(place) || !is_beaten(*place));
    }
    let left = left.into_iter().map(|place| specs[place].clone()).collect();
    let is_new = |near: &Spec| specs.iter().all(|spec| spec.to_string() != near.to_string());
    with(left, to_be_sized(rows, limits).iter().flat_map(|place| neighbours(&specs[*place])).filter(is_new))
}

/// Returns the spec without keys that affect only pictures.
fn built(spec: &Spec) -> String {
    let mut keys = spec.variant();
    keys.retain(|name, _| KEYS.iter().all(|key| key.name != name));
    format!("{} {keys:?}", spec.entry.name)
}

/// Returns `specs`, followed by the specs of `more` that are not among them. With `GOBO_TEST_LITTLE`, returns `specs` alone.
pub fn with(mut specs: Vec<Spec>, more: impl IntoIterator<Item = Spec>) -> Vec<Spec> {
    for near in more.into_iter().filter(|_| !test_reduction::is_asked()) {
        if specs.iter().all(|spec| spec.to_string() != near.to_string()) {
            specs.push(near);
        }
    }
    specs
}

/// Returns the spec at half and at twice its size, if it has a size.
pub fn neighbours(spec: &Spec) -> Vec<Spec> {
    [sized(spec, |size| size / 2), sized(spec, |size| size.saturating_mul(2))].into_iter().flatten().collect()
}

/// Returns the spec at another size, set by the first of its size keys. `None` if it has no such key, or does not accept that size.
fn sized(spec: &Spec, of: impl Fn(u32) -> u32) -> Option<Spec> {
    let (name, size) = Name::SIZES.into_iter().find_map(|name| Some((name, spec.text(name).parse().ok()?)))?;
    let mut other = spec.clone();
    other.set(name, &of(size).to_string());
    (other.text(name) == of(size).to_string()).then_some(other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{RowError, SeenError};
    use crate::cli::default_specs::without_alike;
    use crate::technique::Casts;

    /// A technique must be a candidate for a scene if and only if it sees all casters of the scene.
    #[test]
    fn each_technique_is_looked_at_where_it_sees_all() {
        for name in ["cornell", "plume_8k", "town"] {
            let scene = Scene::load(name, 0.0).expect(name);
            for (on_cpu, entry) in
                [true, false].into_iter().flat_map(|on_cpu| REGISTRY.iter().map(move |e| (on_cpu, e)))
            {
                let usual = runs(|runs| runs.compare, on_cpu).expect("known");
                let specs = candidates(&scene, usual, on_cpu, false).expect("known");
                let sees = entry.casts == Casts::NONE || entry.casts.unseen_of(scene.kinds()).is_empty();
                assert_eq!(specs.iter().any(|spec| spec.entry.name == entry.name), sees, "{} on {name}", entry.name);
            }
        }
    }

    /// Splits specs into two lists. Every spec must be in one of them, and every path of a technique once in the first, with default keys
    /// except for its size.
    #[test]
    fn first_one_of_each_is_looked_at() {
        for on_cpu in [true, false] {
            let specs = runs(|runs| runs.compare, on_cpu).expect("known");
            let (first, others) = one_of_each(&specs);
            let ways = |specs: &[Spec]| {
                specs
                    .iter()
                    .map(|spec| format!("{} {:?}", spec.entry.name, spec.variant().get("path")))
                    .collect::<Vec<_>>()
            };
            let of = |specs: &[Spec]| specs.iter().map(Spec::to_string).collect::<BTreeSet<_>>();
            assert_eq!(first.len() + others.len(), specs.len());
            assert_eq!(&of(&first) | &of(&others), of(&specs));
            let once: BTreeSet<_> = ways(&first).into_iter().collect();
            assert_eq!((once.len(), once), (first.len(), ways(&specs).into_iter().collect()));
            let avsm = first.iter().filter(|spec| spec.entry.name == "avsm").map(Spec::variant).collect::<Vec<_>>();
            assert!(avsm.len() > 2, "{avsm:?}");
            assert!(avsm.iter().all(|avsm| avsm["nodes"] == "8" && avsm["curve"] == "exponential"), "{avsm:?}");
        }
    }

    /// Splits specs into two lists. Every spec must be in one of them, and no two specs of the first may differ in shading alone. The
    /// second is then narrowed to specs that are built like the best, the fastest, the closest or the smallest.
    #[test]
    fn each_shading_of_the_best_is_looked_at() {
        let specs: Vec<Spec> = [
            "none:shading=tiled",
            "voxel-grid:shading=tiled",
            "voxel-grid:shading=tiled,blur=off",
            "voxel-grid:shading=tiled,march=steps",
            "voxel-grid:shading=tiled,march=steps,blur=off",
            "voxel-grid:shading=tiled,march=steps,dither=noise",
            "shadow-map:shading=tiled",
        ]
        .map(|spec| parse(spec).expect(spec).remove(0))
        .into();
        let (first, others) = one_of_each_shading(&specs);
        let same = |found: Vec<Spec>, places: &[usize]| {
            assert!(found.iter().map(Spec::to_string).eq(places.iter().map(|place| specs[*place].to_string())));
        };
        same(first.clone(), &[0, 1, 3, 6]);
        same(others.clone(), &[2, 4, 5]);
        let row = |(spec, [ms, error]): (&Spec, [f64; 2])| {
            let seen = Some(SeenError { mean: error, ..SeenError::default() });
            let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image: None });
            let technique = spec.entry.name.into();
            Row { technique, variant: spec.variant(), cost_ns: Some(1e6 * ms), error, ..Row::default() }
        };
        let rows = |ms: f64| -> Vec<Row> {
            let figures = [[0.1, 0.9], [2.0, 0.07], [ms, 0.06], [9.0, 0.01]];
            first.iter().zip(figures).map(row).collect()
        };
        // At 1 ms, spec 3 is the fastest and the best, so its other shadings are candidates; at 2.5 ms spec 1 is both.
        same(shadings(&others, &first, &rows(1.0)), &[4, 5]);
        same(shadings(&others, &first, &rows(2.5)), &[2]);
    }

    /// In a scene of meshes alone, one technique must represent all techniques that draw the same opaque maps, and techniques that store
    /// meshes in other ways must stay. In a scene of smoke, all techniques must stay.
    #[test]
    fn opaque_maps_are_looked_at_once() {
        let names = |name: &str| {
            let scene = Scene::load(name, 0.0).expect(name);
            let usual = runs(|runs| runs.compare, false).expect("known");
            let all = candidates(&scene, usual, false, false).expect("known");
            let names = |specs: &[Spec]| specs.iter().map(|spec| spec.entry.name).collect::<BTreeSet<_>>();
            (names(&all), names(&without_alike(&scene, all)))
        };
        let (all, left) = names("houses");
        assert!(all.contains("avsm") && all.contains("psm"), "{all:?}");
        let stay = ["grid-query", "ism", "none", "ray-query", "shadow-map", "voxel-grid", "voxelized"];
        assert_eq!(left, BTreeSet::from(stay));
        let (all, left) = names("plume_8k");
        assert_eq!(all, left);
    }

    /// Among specs that differ only in shading, only the fastest must stay; if FLIP is limited, all must stay.
    #[test]
    fn shading_is_told_by_pictures_alone() {
        let specs: Vec<Spec> = ["voxel-grid:size=64", "voxel-grid:shading=tiled,size=64", "voxel-grid:size=128"]
            .map(|spec| parse(spec).expect(spec).remove(0))
            .into();
        let row = |(spec, [ms, error]): (&Spec, [f64; 2])| {
            let seen = Some(SeenError { mean: error, ..SeenError::default() });
            let error = Some(RowError { seen, map: None, space: None, surface: None, casters: None, image: None });
            let technique = spec.entry.name.into();
            Row { technique, variant: spec.variant(), cost_ns: Some(1e6 * ms), error, ..Row::default() }
        };
        let rows: Vec<Row> = specs.iter().zip([[2.1, 0.2], [2.0, 0.2], [4.0, 0.05]]).map(row).collect();
        let left = |limits: Limits| {
            let left = promising(&specs, &rows, &limits);
            specs.iter().map(|spec| left.iter().any(|other| other.to_string() == spec.to_string())).collect::<Vec<_>>()
        };
        assert_eq!(left(Limits::default()), [false, true, true]);
        assert_eq!(left(Limits { flip: Some(0.1), ..Limits::default() }), [true; 3]);
    }

    #[test]
    fn a_neighbour_is_half_or_twice_as_large() {
        let of = |text: &str| {
            let spec = parse(text).expect("valid").remove(0);
            neighbours(&spec).iter().map(Spec::short).collect::<Vec<_>>()
        };
        assert_eq!(of("avsm:size=64"), ["avsm:size=32", "avsm:size=128"]);
        assert!(of("ray-query").is_empty());
    }
}
