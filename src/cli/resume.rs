//! `compare --resume`, `recommend --resume`: rows that an earlier run has measured are kept.

use crate::bench::{Results, Row, Status};
use crate::gpu::Mapped;
use crate::report::remove_unfinished;
use crate::technique::Spec;
use crate::{Error, Result};
use fnv::FnvHasher;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::Hasher;
use std::path::Path;

/// Finds the rows that `folder` already has, from a run under the conditions of `now`: one entry for each scene and
/// spec in `asked`, which for a shard lists only the shard's rows. A row that failed, or lacks one of its pictures, is
/// not kept and is measured again. A folder without results has no rows.
///
/// # Errors
/// [`Error::Input`] if the rows in the folder are from another device, driver, version or scene, were measured under
/// other conditions, or are more than requested.
pub fn kept(folder: &Path, now: &Results, asked: &[(&str, &Spec)]) -> Result<Vec<Option<Row>>> {
    let mut kept = vec![None; asked.len()];
    remove_unfinished(folder);
    let path = folder.join("results.json");
    if !path.exists() {
        return Ok(kept);
    }
    let before = Results::read(&path)?;
    let otherwise = |cause: String| {
        let way_out = "repeat the command as it was, choose another --out, or leave --resume out to begin anew";
        Error::input(format!("--resume {}", folder.display()), cause, way_out)
    };
    if let Some((what, old, new)) = difference(&before, now) {
        return Err(otherwise(format!("what is there was measured with {what} {old}, and this is {new}")));
    }
    for row in before.rows.into_iter().filter(|row| row.status != Status::Failed) {
        let place = asked
            .iter()
            .zip(&kept)
            .position(|((scene, spec), taken)| taken.is_none() && row.scene == *scene && is_of(&row, spec));
        let Some(place) = place else {
            return Err(otherwise(format!("{} on {} is there, and not asked for", row.spec(), row.scene)));
        };
        if pictures(&row).iter().all(|name| folder.join(name).is_file()) {
            kept[place] = Some(row);
        }
    }
    Ok(kept)
}

/// Returns the first condition of the measurement that has changed: its name and both values.
fn difference(before: &Results, now: &Results) -> Option<(String, String, String)> {
    let of = |results: &Results| {
        let device = &results.device;
        let named =
            [("gobo", &results.gobo), ("device", &device.name), ("driver", &device.driver), ("Vulkan", &device.api)];
        let mut all: BTreeMap<_, _> = named.map(|(name, value)| (name.to_owned(), value.clone())).into();
        all.extend(device.features.iter().map(|(name, value)| (name.clone(), value.to_string())));
        all.extend(results.conditions.clone());
        let shard = results.shard.as_ref().map_or("none".into(), |shard| format!("{}/{}", shard.number, shard.of));
        all.insert("--shard".into(), shard);
        all.extend(results.commit.iter().map(|commit| ("commit".to_owned(), commit.clone())));
        all
    };
    let before = of(before);
    of(now).into_iter().find_map(|(name, new)| match before.get(&name) {
        // A newly requested scene or file has no rows yet.
        None if name.starts_with(SCENE) || name.starts_with(FILE) => None,
        // Older files lack the commit.
        None if name == "commit" => None,
        None => Some((name, "unknown".into(), new)),
        Some(old) => (*old != new).then(|| (name, old.clone(), new)),
    })
}

/// The prefix of a scene's fingerprint in [`Results::conditions`].
pub const SCENE: &str = "scene ";

/// The prefix of a file's fingerprint in [`Results::conditions`].
const FILE: &str = "file ";

/// Returns the fingerprints of all files that specs name: a bake may have changed since.
pub fn files<'a>(specs: impl Iterator<Item = &'a Spec>) -> BTreeMap<String, String> {
    let names: BTreeSet<_> = specs.flat_map(Spec::files).collect();
    let print = |name: &str| match Mapped::open(Path::new(name)) {
        // Not a CRC: files that end in their own CRC all have the same one.
        Ok(bytes) => {
            let mut hasher = FnvHasher::default();
            hasher.write(&bytes);
            format!("{:016x}", hasher.finish())
        }
        // The file's rows will fail and report why.
        Err(_) => "unreadable".into(),
    };
    names.into_iter().map(|name| (format!("{FILE}{name}"), print(name))).collect()
}

/// Whether a row belongs to a spec; the row may have values for keys that the spec leaves open.
fn is_of(row: &Row, spec: &Spec) -> bool {
    let says = |(key, value): (&String, &String)| value.is_empty() || row.variant.get(key) == Some(value);
    row.technique == spec.entry.name && spec.variant().iter().all(says)
}

/// Returns the files of a row's pictures, including those of the truth.
pub fn pictures(row: &Row) -> Vec<String> {
    let mut names: Vec<String> = [&row.picture, &row.difference].into_iter().flatten().cloned().collect();
    let bounced = row.error.as_ref().and_then(|error| error.image).is_some_and(|image| image.bounce_rmse.is_some());
    names.extend(row.difference.is_some().then(|| format!("{}-reference.png", row.scene)));
    names.extend((row.difference.is_some() && bounced).then(|| format!("{}-bounce.png", row.scene)));
    names
}
