//! A run measured by several processes, each of which measures a shard of its rows, and the joining of the shards.

use crate::bench::{DeviceFacts, Results, Row};
use crate::{Error, Result};
use fnv::FnvHasher;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::hash::Hasher;

/// The rows of a run's list that one process measures: every `of`-th row, starting with the `number`-th. Neighbours in
/// the list are sizes and paths of one technique and take about the same time, and therefore so do all shards.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of this shard, from 1.
    pub number: usize,
    /// Number of shards.
    pub of: usize,
    /// Number of rows in all shards together.
    pub rows: usize,
    /// A hash of the whole list: scenes and specs.
    pub list: String,
}

impl Shard {
    /// Creates shard `number` of `of` shards of a list of scenes and specs.
    pub fn of_list(number: usize, of: usize, list: &[(&str, String)]) -> Self {
        let mut hasher = FnvHasher::default();
        for (scene, spec) in list {
            hasher.write(format!("{scene}\n{spec}\n").as_bytes());
        }
        Self { number, of, rows: list.len(), list: format!("{:016x}", hasher.finish()) }
    }

    /// Whether the shard contains the row at index `place` of the list, counted from 0.
    pub fn has(&self, place: usize) -> bool {
        place % self.of + 1 == self.number
    }

    /// Returns the number of rows in the shard once all are measured.
    pub fn share(&self) -> usize {
        (0..self.rows).filter(|place| self.has(*place)).count()
    }
}

/// Returns the results that a single run would have: the rows of all shards in the order of the list. Each shard comes
/// with the name that the user gave it.
///
/// # Errors
/// [`Error::Input`], naming the file, if it holds no shard or a shard of another run, or if a shard is given twice,
/// missing or incomplete.
pub fn join(shards: &[(String, Results)]) -> Result<Results> {
    const SAME: &str = "give all shards of one run, each once";
    let input = |name: &str, cause: String, way_out: &str| Error::input(name.to_owned(), cause, way_out);
    let [(first_name, first), ..] = shards else {
        return Err(Error::input("join", "no shard is given", SAME));
    };
    // Maps each shard's number to its rows, which are consumed in order.
    let mut rows: BTreeMap<usize, (&str, std::slice::Iter<Row>)> = BTreeMap::new();
    for (name, results) in shards {
        let Some(shard) = results.shard.as_ref().filter(|shard| (1..=shard.of).contains(&shard.number)) else {
            return Err(input(name, "it is no shard of a run".into(), "measure it with gobo compare --shard"));
        };
        if let Some((what, one, other)) = difference(first, results) {
            return Err(input(name, format!("{what} is {other}, and {one} in {first_name}"), SAME));
        }
        let (number, of, has, share) = (shard.number, shard.of, results.rows.len(), shard.share());
        if has != share {
            let cause = format!("shard {number}/{of} has {has} of its {share} rows");
            return Err(input(name, cause, "repeat its command with --resume"));
        }
        if let Some((other, _)) = rows.insert(number, (name, results.rows.iter())) {
            return Err(input(name, format!("shard {number}/{of} is {other} too"), SAME));
        }
    }
    let of = first.shard.as_ref().map_or(1, |shard| shard.of);
    if let Some(number) = (1..=of).find(|number| !rows.contains_key(number)) {
        return Err(input(first_name, format!("shard {number}/{of} of its run is not there"), SAME));
    }
    let mut joined = Results { shard: None, command: whole(&first.command), rows: Vec::new(), ..first.clone() };
    // The driver's reports on a shader are the same in every shard.
    for executable in shards.iter().flat_map(|(_, results)| &results.executables) {
        if !joined.executables.contains(executable) {
            joined.executables.push(executable.clone());
        }
    }
    let mut turns: Vec<_> = rows.into_values().map(|(_, rows)| rows).collect();
    loop {
        // The first shards have one row more than the last if the rows do not divide evenly.
        let before = joined.rows.len();
        joined.rows.extend(turns.iter_mut().filter_map(Iterator::next).cloned());
        if joined.rows.len() == before {
            return Ok(joined);
        }
    }
}

/// Returns a condition that shards of one run must share but in which these differ: its name and both values.
fn difference(one: &Results, other: &Results) -> Option<(String, String, String)> {
    let of = |results: &Results| {
        let DeviceFacts { name, driver, api, features, .. } = &results.device;
        let named = [("gobo", &results.gobo), ("device", name), ("driver", driver), ("Vulkan", api)];
        let mut all: BTreeMap<_, _> = named.map(|(name, value)| (name.to_owned(), value.clone())).into();
        all.extend(features.iter().map(|(name, value)| (name.clone(), value.to_string())));
        all.extend(results.conditions.clone());
        all.extend(results.commit.iter().map(|commit| ("commit".to_owned(), commit.clone())));
        if let Some(Shard { of, rows, list, .. }) = &results.shard {
            let of_run = [("the number of shards", of), ("the number of rows", rows)];
            all.extend(of_run.map(|(name, value)| (name.to_owned(), value.to_string())));
            all.insert("the list of rows".into(), list.clone());
        }
        all
    };
    let (one, other) = (of(one), of(other));
    one.keys().chain(other.keys()).find_map(|name| {
        let [a, b] = [&one, &other].map(|all| all.get(name).map_or("not known", String::as_str));
        (a != b).then(|| (name.clone(), a.to_owned(), b.to_owned()))
    })
}

/// Returns a run's command without the options that differ between shards.
fn whole(command: &str) -> String {
    let mut left = Vec::new();
    let mut words = command.split(' ');
    while let Some(word) = words.next() {
        match word {
            "--shard" | "--out" => drop(words.next()),
            _ if word.starts_with("--shard=") || word.starts_with("--out=") => {}
            _ => left.push(word),
        }
    }
    left.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shards(rows: usize, of: usize) -> Vec<(String, Results)> {
        let list: Vec<_> = (0..rows).map(|i| ("scene", format!("avsm:nodes={i}"))).collect();
        let one = |number: usize| {
            let shard = Shard::of_list(number, of, &list);
            let mine = list.iter().enumerate().filter(|(place, _)| shard.has(*place));
            let rows = mine.map(|(_, (_, spec))| Row { technique: spec.clone(), ..Row::default() }).collect();
            let command = format!("gobo compare scene --shard {number}/{of} --out shard-{number} --quick");
            (format!("shard-{number}"), Results { command, rows, shard: Some(shard), ..Results::default() })
        };
        (1..=of).map(one).collect()
    }

    /// Joined rows must be in the order of the run's list, for any number of rows and shards, and for shards in any
    /// order.
    #[test]
    fn all_rows_come_in_their_order() {
        for rows in 0..9 {
            for of in 1..6 {
                let mut all = shards(rows, of);
                all.rotate_left(rows % of);
                let joined = join(&all).expect("whole");
                let found: Vec<_> = joined.rows.iter().map(|row| row.technique.clone()).collect();
                assert_eq!(found, (0..rows).map(|i| format!("avsm:nodes={i}")).collect::<Vec<_>>(), "{rows}, {of}");
                assert_eq!((joined.shard, joined.command.as_str()), (None, "gobo compare scene --quick"));
            }
        }
    }

    #[test]
    fn what_is_no_whole_run_is_refused() {
        /// Changes shards so that they no longer form a complete run.
        type Change = fn(&mut Vec<(String, Results)>);
        let cases: [(&str, Change); 9] = [
            ("no shard is given", |all| all.clear()),
            ("shard-2: it is no shard", |all| all[1].1.shard = None),
            ("shard 2/3 of its run is not there", |all| drop(all.remove(1))),
            ("shard-1: shard 1/3 is shard-1 too", |all| all[2] = all[0].clone()),
            ("shard-2: shard 2/3 has 1 of its 2 rows", |all| drop(all[1].1.rows.pop())),
            ("shard-3: --frames is 8, and not known", |all| {
                drop(all[2].1.conditions.insert("--frames".into(), "8".into()))
            }),
            ("shard-3: driver is other", |all| all[2].1.device.driver = "other".into()),
            ("shard-2: the number of rows is 9, and 6", |all| all[1].1.shard.as_mut().expect("one").rows = 9),
            ("shard-2: the list of rows", |all| all[1].1.shard.as_mut().expect("one").list = "0".into()),
        ];
        for (cause, change) in cases {
            let mut all = shards(6, 3);
            change(&mut all);
            let error = join(&all).expect_err(cause).to_string();
            assert!(error.contains(cause), "{error}\n{cause}");
        }
    }

    /// Each shard measures the device's copy bandwidth; shards with different bandwidths must still join.
    #[test]
    fn what_is_measured_may_differ() {
        let mut all = shards(6, 3);
        all[1].1.device.copy_bytes_per_second = Some(1.0);
        assert!(join(&all).is_ok());
    }
}
