//! The exit status of a run, determined by its rows.

use crate::bench::{Results, Status};
use crate::cli::complain;
use std::process::ExitCode;

/// Returns success if every row is ok or refused, and not all are refused.
pub(in crate::cli) fn exit_code(results: &Results) -> ExitCode {
    let failed: Vec<_> = results.rows.iter().filter(|r| r.status == Status::Failed).collect();
    for row in &failed {
        complain(format!("gobo: {} on {} ({}): {}", row.spec(), row.scene, results.device.name, row.reason));
    }
    let nothing = nothing_measured(results);
    nothing.iter().for_each(|why| complain(format!("gobo: {why}")));
    if failed.is_empty() && nothing.is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Returns why there is nothing to compare if every row is refused. A shard, which is only part of a run, may consist of refused rows only.
fn nothing_measured(results: &Results) -> Option<String> {
    let first = results.rows.first().filter(|_| results.shard.is_none())?;
    results.rows.iter().all(|row| row.status == Status::Refused).then(|| {
        let (spec, scene, reason) = (first.spec(), &first.scene, &first.reason);
        let which = match results.rows.len() {
            1 => format!("{spec} on {scene} is"),
            rows => format!("all {rows} rows ({spec} on {scene}, …) are"),
        };
        format!("nothing is measured: {which} {reason}; name what `gobo devices` lists with yes, or another scene")
    })
}
