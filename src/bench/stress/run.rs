//! The run loop of the stress test: every technique at every value of each sweep.

use crate::Result;
use crate::bench::stress::{CaseResult, Outcome, Results, Sweep, Worker, verdicts};
use crate::technique::Spec;
use std::time::{Duration, Instant};

/// What a run measures.
pub struct StressPlan {
    /// The sweeps, in the order in which they run.
    pub sweeps: Vec<Sweep>,
    /// The specs for scenes with smoke or hair.
    pub smoke_specs: Vec<Spec>,
    /// The specs for scenes of meshes alone.
    pub mesh_specs: Vec<Spec>,
}

/// Measures all rows of a plan into `results`. Calls `row_ends` with each row and the time it took, and `sweep_ends` after each sweep.
///
/// # Errors
/// Fails if a new process is needed and [`Worker::start`] fails, or if `sweep_ends` does.
pub fn run(
    worker: &mut Worker,
    plan: &StressPlan,
    results: &mut Results,
    row_ends: impl Fn(&CaseResult, Duration),
    sweep_ends: impl Fn(&Sweep, &Results) -> Result<()>,
) -> Result<()> {
    for sweep in &plan.sweeps {
        run_sweep(worker, plan, sweep, &mut results.rows, &row_ends)?;
        results.verdicts = verdicts(&results.rows);
        sweep_ends(sweep, results)?;
    }
    Ok(())
}

/// Queries every technique at all values of a sweep. A technique that was refused, or did not answer in time, is not queried at more
/// extreme values.
fn run_sweep(
    worker: &mut Worker,
    plan: &StressPlan,
    sweep: &Sweep,
    rows: &mut Vec<CaseResult>,
    row_ends: impl Fn(&CaseResult, Duration),
) -> Result<()> {
    let Some(first) = sweep.values.first() else { return Ok(()) };
    let specs = if sweep.scene(*first).has_only_meshes() { &plan.mesh_specs } else { &plan.smoke_specs };
    let mut left = specs.clone();
    for value in sweep.values(worker.device.1) {
        let (from, mut start) = (rows.len(), Instant::now());
        worker.ask(sweep, value, &left, |row| {
            row_ends(&row, start.elapsed());
            start = Instant::now();
            rows.push(row);
        })?;
        let ended = |row: &CaseResult| matches!(row.outcome, Outcome::NoAnswer | Outcome::Refused);
        left.retain(|spec| !rows[from..].iter().any(|row| row.technique == spec.short() && ended(row)));
    }
    Ok(())
}
