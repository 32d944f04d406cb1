//! Errors against area means, for the terminal.

use crate::bench::{FOOTPRINTS, FootprintError, Results, Row};
use crate::report::answer::pareto::scenes;
use crate::report::format::{Specs, one_line, significant};
use crate::report::table::casters::lines;

/// Formats each scene's rows, one per line, with a column for each size of squares. Empty if there are no points.
pub fn footprints(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let rows: Vec<&Row> =
            results.rows.iter().filter(|row| row.scene == scene && !row.footprints.is_empty()).collect();
        if !rows.is_empty() {
            text += &table(&one_line(scene), &rows, &specs);
        }
    }
    if !text.is_empty() {
        text += "root mean square against the mean of the truth over squares across the light, whose sides are so many texels of a fitted map of 256²; `<`: no more than the truth's own noise\n";
    }
    text
}

fn table(scene: &str, rows: &[&Row], specs: &Specs) -> String {
    let heading = |texels: f64| if texels < 1.0 { format!("1/{}", 1.0 / texels) } else { texels.to_string() };
    let rows = rows.iter().map(|row| (*row, row.footprints.iter().map(cell).collect()));
    lines(scene, FOOTPRINTS.map(heading).into(), rows.collect(), specs)
}

/// Formats an error: `0.0123`, or `< 0.004` if it is within the noise.
fn cell(error: &FootprintError) -> String {
    if error.rms > error.noise { significant(error.rms) } else { format!("< {}", significant(error.noise)) }
}
