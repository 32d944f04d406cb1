//! A standard run as one file for `results/community/`: how it was produced, and reasons not to count it.

use crate::bench::results::standard;
use crate::bench::{PointError, Results, Row, Status};
use crate::gpu::Tool;
use crate::{Error, Result};
use fnv::FnvHasher;
use serde::{Deserialize, Serialize};
use std::hash::Hasher;
use std::path::Path;

/// The format version that is written.
pub const SUBMISSION: u32 = 1;

/// The schema of the rows in the first submissions.
const FIRST_SCHEMA: u32 = 3;

/// The content of a submission file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Submission {
    /// The format version, [`SUBMISSION`].
    pub submission: u32,
    /// The commit from which the program was built; `unknown` outside git.
    pub commit: String,
    /// Whether any source differed from that commit.
    pub changed: bool,
    /// Duration of the run in seconds.
    pub seconds: f64,
    /// Layers and tools that were active.
    pub layers: Vec<Tool>,
    /// Layers named by the environment, which need not report themselves.
    pub environment: Vec<String>,
    /// Whether the validation layer was active, in which case times mean nothing.
    pub validation: bool,
    /// Messages of the validation layer, and leaks.
    pub failed: Vec<String>,
    /// How noisy the times are: for half of the rows, the band of the build time from the 5th to the 95th percentile is narrower than this
    /// share of its median. Absent without times.
    pub noise: Option<f64>,
    /// The [`answers_hash`] of each row.
    pub answers: Vec<String>,
    /// The rows, with the device, the hashes of the scenes among the conditions, and the bands of the times.
    pub results: Results,
}

/// Returns a hash of all errors of a row at points, by their bits. If one answer differs by one rounding, a sum over thousands of answers
/// changes by far more than the sum's own rounding in f64. So this hash distinguishes answers as well as a hash of the answers would, and
/// it can be recomputed from the file alone. Hashing rounded answers would not make devices comparable: some answer is always so close to
/// halfway between two rounded values that devices round it differently.
pub fn answers_hash(row: &Row) -> String {
    let Some(error) = &row.error else { return String::new() };
    let mut hasher = FnvHasher::default();
    for points in [error.map, error.space, error.surface] {
        let PointError { mean_abs, bias, rms, p99, max, points, leaks, false_shadows, .. } = points.unwrap_or_default();
        for value in [Some(mean_abs), bias, rms, p99, max] {
            hasher.write_u64(value.map_or(u64::MAX, f64::to_bits));
        }
        for count in [points, leaks, false_shadows] {
            hasher.write_u64(count.unwrap_or(u64::MAX));
        }
    }
    format!("{:016x}", hasher.finish())
}

/// Computes [`Submission::noise`].
pub fn noise(rows: &[Row]) -> Option<f64> {
    let timings = rows.iter().filter_map(|row| row.build_ns).filter(|time| time.samples > 1 && time.median > 0.0);
    let mut shares: Vec<f64> = timings.map(|time| (time.p95 - time.p05) / time.median).collect();
    shares.sort_by(f64::total_cmp);
    shares.get(shares.len() / 2).copied()
}

impl Submission {
    /// Reads a submission.
    ///
    /// # Errors
    /// [`Error::Input`], naming the file, if it is missing, not a submission, or of a newer version.
    pub fn read(path: &Path) -> Result<Self> {
        let input = |cause: String| {
            let way_out = "measure again with gobo submit, or use the gobo that wrote it";
            Error::input(path.display().to_string(), cause, way_out)
        };
        let json = std::fs::read(path).map_err(|cause| input(cause.to_string()))?;
        let read: Self =
            serde_json::from_slice(&json).map_err(|cause| input(format!("no whole submission: {cause}")))?;
        // Rows of every schema since the first submission are read as they are: fields added by a schema are absent in older files.
        let (first, last) = (FIRST_SCHEMA, crate::bench::SCHEMA);
        if read.submission != SUBMISSION || !(first..=last).contains(&read.results.schema) {
            let cause = format!("format {} with rows of schema {}", read.submission, read.results.schema);
            return Err(input(format!("{cause}, and this gobo reads {SUBMISSION} with {first} to {last}")));
        }
        Ok(read)
    }

    /// Returns the reasons not to count the submission that the file itself shows; empty if it counts.
    ///
    /// # Errors
    /// Fails if [`standard::scenes`] does.
    pub fn marks(&self) -> Result<Vec<String>> {
        let (results, mut marks) = (&self.results, Vec::new());
        let hash = self.commit.len() == 40 && self.commit.chars().all(|c| c.is_ascii_hexdigit());
        if !hash || self.changed {
            marks.push("it was built from sources that are no commit".into());
        }
        for tool in self.layers.iter().filter(|tool| tool.changes_features) {
            marks.push(format!("{} may change features", tool.name));
        }
        for name in &self.environment {
            marks.push(format!("the environment names the layer {name}, which may change features"));
        }
        if self.validation {
            marks.push("times were taken under the validation layer".into());
        }
        marks.extend(self.failed.iter().cloned());
        let failed = results.rows.iter().filter(|row| row.status == Status::Failed).count();
        if failed > 0 {
            marks.push(format!("{failed} rows failed"));
        }
        let scenes = standard::scenes()?;
        for (name, value) in standard::conditions(&scenes) {
            let theirs = results.conditions.get(&name).map_or("not known", String::as_str);
            if theirs != value {
                marks.push(format!("{name} was {theirs}, and is {value}"));
            }
        }
        for scene in scenes.iter().filter(|scene| results.rows.iter().all(|row| row.scene != scene.scene.name)) {
            marks.push(format!("it has no row of {}", scene.scene.name));
        }
        let hashes: Vec<String> = results.rows.iter().map(answers_hash).collect();
        if hashes != self.answers {
            let row =
                hashes.iter().zip(&self.answers).position(|(a, b)| a != b).map_or(results.rows.len(), |row| row + 1);
            marks.push(format!("the errors of row {row} are not those that were hashed"));
        }
        Ok(marks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{RowError, Timing};

    fn row(mean_abs: f64, band: f64) -> Row {
        let space = Some(PointError { mean_abs, ..PointError::default() });
        let build_ns = Some(Timing { median: 100.0, p05: 100.0 - band / 2.0, p95: 100.0 + band / 2.0, samples: 9 });
        let error = Some(RowError { seen: None, map: None, space, surface: None, casters: None, image: None });
        Row { error, build_ns, ..Row::default() }
    }

    #[test]
    fn a_hash_is_of_bits() {
        assert_eq!(answers_hash(&row(0.1, 0.0)), answers_hash(&row(0.1, 5.0)));
        assert_ne!(answers_hash(&row(0.1, 0.0)), answers_hash(&row(0.1f64.next_up(), 0.0)));
        assert_eq!(answers_hash(&Row::default()), "");
    }

    #[test]
    fn half_of_the_rows_are_steadier() {
        let rows: Vec<Row> = [4.0, 50.0, 2.0].map(|band| row(0.1, band)).into();
        assert_eq!((noise(&rows), noise(&[])), (Some(0.04), None));
    }
}
