//! The standard run: the same rows on every machine, small ones, of every technique. `gobo submit` measures them.

use super::{Case, Effort, Extent, PointError, Row, Status, Submission, with_case};
use crate::Result;
use crate::consume::{parse, runs};
use crate::gpu::Context;
use crate::scene::Scene;
use crate::technique::{Casts, REGISTRY, Spec};
use std::collections::BTreeMap;

/// Smoke, hair, and meshes in a room and in the open.
pub const SCENES: [&str; 4] = ["plume_8k", "hair", "cornell", "houses"];

/// Seconds for which what moves has been running.
pub const TIME_S: f64 = 20.0;

/// How much is measured of each row.
pub const EFFORT: Effort =
    Effort { frames: 30, warm_up: 5, space_points: 8192, picture: [160, 90], turning: false, truth: Extent::Sample };

/// The mean error of a row on two devices differs by less than this share of it,
const SHARE: f64 = 0.02;

/// or than this: devices round, and cover the edges of triangles, each in its own way.
const ROUNDING: f64 = 2e-5;

/// The scenes.
///
/// # Errors
/// None but those of a scene that is not built in.
pub fn scenes() -> Result<Vec<Scene>> {
    SCENES.iter().map(|name| Scene::load(name, TIME_S)).collect()
}

/// The rows of a scene: of each technique that casts from something in it what `compare` has, else what `stress` has, as small as on a
/// software device; of hair one of each. So a technique that is new in the registry has rows here.
///
/// # Errors
/// [`crate::Error::Input`] where an entry names what is no setting.
pub fn specs(scene: &Scene) -> Result<Vec<Spec>> {
    let (compare, smoke, meshes) = (
        runs(|runs| runs.compare, true)?,
        runs(|runs| runs.stress_smoke, true)?,
        runs(|runs| runs.stress_meshes, true)?,
    );
    let only_meshes = scene.has_only_meshes();
    let lists = if only_meshes { [&meshes, &compare] } else { [&compare, &smoke] };
    let mut all = Vec::new();
    for entry in REGISTRY {
        let sees = if only_meshes { entry.casts.meshes } else { entry.casts.particles || entry.casts.strands };
        if !sees && entry.casts != Casts::NONE {
            continue;
        }
        let of = |list: &&Vec<Spec>| list.iter().filter(|s| s.entry.name == entry.name).cloned().collect::<Vec<_>>();
        let found = lists.iter().map(of).find(|found| !found.is_empty());
        let mut found = found.map_or_else(|| parse(entry.name), Ok)?;
        if !scene.strands.is_empty() {
            found.truncate(1);
        }
        all.append(&mut found);
    }
    Ok(all)
}

/// What figures depend on that neither the specs nor the device say.
pub fn conditions(scenes: &[Scene]) -> BTreeMap<String, String> {
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
    all.extend(scenes.iter().map(|scene| (format!("scene {}", scene.name), format!("{:08x}", scene.fingerprint()))));
    all
}

/// Measures the errors of rows of a submission again, on this device: what speaks against them, a line a row that differs or is no row any
/// more, and how many agree. What either device refuses is neither. `few` says how many rows of a scene at most, and of which scenes.
///
/// # Errors
/// Those of [`with_case`].
pub fn again(
    context: &Context,
    submission: &Submission,
    few: Option<(usize, &[&str])>,
) -> Result<(usize, Vec<String>)> {
    let (mut agree, mut against) = (0, Vec::new());
    for scene in scenes()?.iter().filter(|scene| few.is_none_or(|(_, names)| names.contains(&scene.name.as_str()))) {
        let rows = submission.results.rows.iter().filter(|row| row.scene == scene.name && row.status == Status::Ok);
        let mut rows: Vec<&Row> = rows.collect();
        if let Some((most, _)) = few {
            let host_ns = |row: &Row| row.host_ns.map_or(f64::INFINITY, |time| time.median);
            rows.sort_by(|a, b| host_ns(a).total_cmp(&host_ns(b)));
            rows.truncate(most);
        }
        with_case(context, std::slice::from_ref(scene), EFFORT, |case| {
            case.repeat([1, 0]);
            for row in rows {
                match differs(case, row) {
                    Ok(None) => {}
                    Ok(Some(None)) => agree += 1,
                    Ok(Some(Some(how))) => against.push(format!("{} on {}: {how}", row.spec(), row.scene)),
                    Err(error) => against.push(format!("{} on {}: no row any more: {error}", row.spec(), row.scene)),
                }
            }
            Ok(())
        })?;
    }
    Ok((agree, against))
}

/// How a row's errors differ from those of now, if they do; nothing where the device refuses it.
fn differs(case: &mut Case, row: &Row) -> Result<Option<Option<String>>> {
    // What a technique found for itself is no key of it.
    let usual = parse(&row.technique)?;
    let known = |key: &&String| usual[0].keys().any(|known| known.name == key.as_str());
    let keys: Vec<String> = row
        .variant
        .iter()
        .filter(|(key, value)| known(key) && !value.is_empty())
        .map(|(k, v)| format!("{k}={v}"))
        .collect();
    let specs = parse(&format!("{}:{}", row.technique, keys.join(",")))?;
    let (now, _) = case.measure(&specs[0]);
    match now.status {
        Status::Refused => return Ok(None),
        Status::Failed => return Ok(Some(Some(now.reason))),
        Status::Ok => {}
    }
    let kinds: [(&str, fn(&Row) -> Option<PointError>); 3] = [
        ("map", |row| row.error.as_ref()?.map),
        ("space", |row| row.error.as_ref()?.space),
        ("surface", |row| row.error.as_ref()?.surface),
    ];
    let how = kinds.iter().find_map(|(name, of)| match (of(row), of(&now)) {
        (Some(then), Some(now)) => {
            let (then, now) = (then.mean_abs, now.mean_abs);
            let agree = (then - now).abs() <= (SHARE * then.max(now)).max(ROUNDING);
            (!agree).then(|| format!("mean {name} error {then:e}, and here {now:e}"))
        }
        (then, now) => (then.is_some() != now.is_some()).then(|| format!("{name} error on one of two devices alone")),
    });
    Ok(Some(how))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Nobody is left out, nobody is asked what it casts nothing from, and no row is there twice.
    #[test]
    fn every_technique_has_rows() {
        let mut named = BTreeSet::new();
        for scene in scenes().expect("built in") {
            let specs = specs(&scene).expect("known");
            let distinct: BTreeSet<_> = specs.iter().map(ToString::to_string).collect();
            assert!(distinct.len() == specs.len() && specs.len() > 5, "{}: {specs:?}", scene.name);
            named.extend(specs.iter().map(|spec| spec.entry.name));
        }
        assert_eq!(named, REGISTRY.iter().map(|entry| entry.name).collect());
    }
}
