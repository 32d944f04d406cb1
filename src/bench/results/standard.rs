//! The standard run: the same small rows of every technique on every machine, as measured by `gobo submit`.

use crate::Result;
use crate::animate::AnimatedScene;
use crate::bench::{Effort, Extent, LOOKUPS, Plan, PlannedScene, PointError, Results, Row, Status, Submission, run};
use crate::gpu::Context;
use crate::scene::Scene;
use crate::shading::{parse, runs};
use crate::technique::{Casts, REGISTRY, Spec};
use std::collections::{BTreeMap, BTreeSet};

/// Smoke, hair, and meshes in a room and in the open.
pub const SCENES: [&str; 4] = ["plume_8k", "hair", "cornell", "houses"];

/// Time of moving scenes, in seconds.
pub const TIME_S: f64 = 20.0;

/// How much to measure for each row.
pub const EFFORT: Effort = Effort {
    frames: 15,
    warm_up: 2,
    space_points: 8192,
    seen_points: 16384,
    lookups: LOOKUPS,
    picture: [160, 90],
    turning: false,
    footprints: false,
    counts: false,
    truth: Extent::Sample,
};

/// Relative tolerance between the mean errors of a row on two devices; `ROUNDING` applies instead if it is larger.
const SHARE: f64 = 0.02;

/// Absolute tolerance between the mean errors of a row on two devices; `SHARE` of the error applies instead if it is larger. Devices differ
/// in rounding and in which pixels along triangle edges they cover.
const ROUNDING: f64 = 2e-5;

/// Loads the scenes of the standard run.
///
/// # Errors
/// Fails as for a scene that is not built in; all of these are built in.
pub fn scenes() -> Result<Vec<AnimatedScene>> {
    SCENES.iter().map(|name| AnimatedScene::load(name, TIME_S)).collect()
}

/// Returns the specs for a scene, in the small sizes of a software device. For smoke: each technique's specs from the list of `compare`, or
/// from the list of `stress` if `compare` has none. For hair: the same, but one spec per technique. For meshes: each technique's specs from
/// the list of `stress`. A technique in none of these lists gets its usual spec; for meshes, only if it sees nothing but meshes. So a new
/// technique in the registry gets rows here.
///
/// # Errors
/// [`crate::Error::Input`] if an entry of the registry names an unknown setting.
pub fn specs(scene: &Scene) -> Result<Vec<Spec>> {
    let only_meshes = scene.has_only_meshes();
    let of_meshes = runs(|runs| runs.stress_meshes, true)?;
    let (compare, of_smoke) = (runs(|runs| runs.compare, true)?, runs(|runs| runs.stress_smoke, true)?);
    let lists = if only_meshes { [&of_meshes, &Vec::new()] } else { [&compare, &of_smoke] };
    let mut all = Vec::new();
    for entry in REGISTRY {
        let of_list = |list: &&Vec<Spec>| {
            let specs: Vec<Spec> = list.iter().filter(|spec| spec.entry.name == entry.name).cloned().collect();
            (!specs.is_empty()).then_some(specs)
        };
        // Techniques that also see smoke share the opaque maps, so one of them is enough.
        let is_usual = if only_meshes { !entry.casts.particles && !entry.casts.strands } else { entry.casts.particles };
        let sees = entry.casts == Casts::NONE || entry.casts.are_in(scene.kinds());
        let mut specs = match lists.iter().find_map(of_list) {
            Some(specs) if sees => specs,
            None if sees && is_usual => parse(entry.name)?,
            _ => continue,
        };
        if !scene.strands.is_empty() {
            specs.truncate(1);
        }
        all.append(&mut specs);
    }
    Ok(all)
}

/// Returns the conditions that affect the figures, apart from specs and device.
pub fn conditions(scenes: &[AnimatedScene]) -> BTreeMap<String, String> {
    let [width, height] = EFFORT.picture;
    let mut all: BTreeMap<String, String> = [
        ("--frames", EFFORT.frames.to_string()),
        ("errors", "over all points".into()),
        ("points", EFFORT.space_points.to_string()),
        ("--picture", format!("{width}x{height}")),
        ("--truth", "sample".into()),
        ("--time", TIME_S.to_string()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into();
    all.extend(
        scenes.iter().map(|scene| (format!("scene {}", scene.scene.name), format!("{:08x}", scene.fingerprint()))),
    );
    all
}

/// The result of measuring a submission's errors again.
#[derive(Clone, Debug, Default)]
pub struct Again {
    /// Number of rows with the same errors, up to rounding.
    pub agree: usize,
    /// One line per row whose errors differ, stating the difference, or that the row no longer exists.
    pub against: Vec<String>,
}

/// Measures the errors of submissions again, on this device. A row that either device refuses neither agrees nor differs. With `few`, only
/// the named scenes are measured, with at most the given number of rows each.
///
/// # Errors
/// Fails as [`crate::bench::with_case`] does, and with [`crate::Error::Gpu`] if the device is lost.
pub fn again(context: &Context, all: &[&Submission], few: Option<(usize, &[&str])>) -> Result<Vec<Again>> {
    let mut scenes: Vec<Scene> = scenes()?.into_iter().map(|animated| animated.scene).collect();
    scenes.retain(|scene| few.is_none_or(|(_, names)| names.contains(&scene.name.as_str())));
    let rows = |submission: &Submission, scene: &Scene| few_rows(submission, &scene.name, few.map(|(most, _)| most));
    let planned = |scene| {
        // Submissions have rows in common, each of which is measured only once.
        let mut known = BTreeSet::new();
        let specs = all.iter().flat_map(|submission| rows(submission, scene)).filter_map(|row| spec_of(&row).ok());
        let specs = specs.filter(|spec| known.insert(spec.to_string())).collect();
        PlannedScene { frames: std::slice::from_ref(scene).into(), specs }
    };
    let effort = Effort { frames: 1, warm_up: 0, lookups: 0, ..EFFORT };
    let mut plan = Plan::new(effort, scenes.iter().map(planned).collect());
    let mut now = Results::default();
    run(context, &mut plan, &mut now, &mut ())?;
    if context.is_lost() {
        return Err(plan.lost(context));
    }
    let list = plan.list().into_iter().map(|(scene, spec)| (scene.to_owned(), spec.to_string()));
    let now: BTreeMap<(String, String), Row> = list.zip(now.rows).collect();
    let again = |submission: &&Submission| {
        let mut found = Again::default();
        for row in scenes.iter().flat_map(|scene| rows(submission, scene)) {
            let how = match spec_of(&row) {
                Ok(spec) => differs(&row, &now[&(row.scene.clone(), spec.to_string())]),
                Err(error) => Some(Some(format!("no row any more: {error}"))),
            };
            match how {
                None => {}
                Some(None) => found.agree += 1,
                Some(Some(how)) => found.against.push(format!("{} on {}: {how}", row.spec(), row.scene)),
            }
        }
        found
    };
    Ok(all.iter().map(again).collect())
}

/// Returns the rows of a submission that were measured on a scene. With `most`, returns at most that many, each of a different technique:
/// submissions with the same techniques have the same rows.
fn few_rows(submission: &Submission, scene: &str, most: Option<usize>) -> Vec<Row> {
    let rows = submission.results.rows.iter().filter(|row| row.scene == scene && row.status == Status::Ok);
    let mut named = BTreeSet::new();
    let rows: Vec<&Row> = rows.filter(|row| most.is_none() || named.insert(&row.technique)).collect();
    let step = most.map_or(1, |most| rows.len().div_ceil(most).max(1));
    rows.into_iter().step_by(step).cloned().collect()
}

/// Returns the spec of a row. Values that the technique found by itself are not keys and are left out.
fn spec_of(row: &Row) -> Result<Spec> {
    let usual = parse(&row.technique)?;
    let is_key = |name: &str| usual[0].keys().any(|key| key.name == name);
    let keys: Vec<String> = row
        .variant
        .iter()
        .filter(|(key, value)| is_key(key) && !value.is_empty())
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    Ok(parse(&format!("{}:{}", row.technique, keys.join(",")))?.remove(0))
}

/// The name of a kind of points, and a row's errors at them.
type Kind = (&'static str, fn(&Row) -> Option<PointError>);

/// Returns how a row's errors differ from those measured now: `Some(None)` if they agree, `None` if the device refuses the row.
fn differs(row: &Row, now: &Row) -> Option<Option<String>> {
    match now.status {
        Status::Refused => return None,
        Status::Failed => return Some(Some(now.reason.clone())),
        Status::Ok => {}
    }
    let kinds: [Kind; 3] = [
        ("map", |row| row.error.as_ref()?.map),
        ("space", |row| row.error.as_ref()?.space),
        ("surface", |row| row.error.as_ref()?.surface),
    ];
    Some(kinds.iter().find_map(|(name, of)| match (of(row), of(now)) {
        (Some(then), Some(now)) => {
            let (then, now) = (then.mean_abs, now.mean_abs);
            let agree = (then - now).abs() <= (SHARE * then.max(now)).max(ROUNDING);
            (!agree).then(|| format!("mean {name} error {then:e}, and here {now:e}"))
        }
        (then, now) => (then.is_some() != now.is_some()).then(|| format!("{name} error on one of two devices alone")),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every technique of the registry must have a row in some scene, and no scene may have the same row twice.
    #[test]
    fn every_technique_has_rows() {
        let mut named = BTreeSet::new();
        for AnimatedScene { scene, .. } in scenes().expect("built in") {
            let specs = specs(&scene).expect("known");
            let distinct: BTreeSet<_> = specs.iter().map(ToString::to_string).collect();
            assert!(distinct.len() == specs.len() && specs.len() > 5, "{}: {specs:?}", scene.name);
            named.extend(specs.iter().map(|spec| spec.entry.name));
        }
        assert_eq!(named, REGISTRY.iter().map(|entry| entry.name).collect());
    }
}
