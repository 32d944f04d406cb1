//! Errors against what areas see, for the terminal.

use crate::measure::{FOOTPRINTS, FootprintError, Results, Row};
use crate::report::pareto::scenes;
use crate::report::wording::{Specs, one_line, significant};
use comfy_table::presets;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

/// A scene's rows one a line, a column for each size. Empty where there are no points.
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
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let heading = |texels: f64| if texels < 1.0 { format!("1/{}", 1.0 / texels) } else { texels.to_string() };
    table.set_header([scene.to_owned(), "path".into()].into_iter().chain(FOOTPRINTS.map(heading)));
    for row in rows {
        let naming = [format!("  {}", specs.compact(row)), one_line(&row.path)].map(Cell::new);
        table.add_row(naming.into_iter().chain(row.footprints.iter().map(|error| Cell::new(cell(error)))));
    }
    for (place, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if place >= 2 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// `0.0123`, or `< 0.004`.
fn cell(error: &FootprintError) -> String {
    if error.rms > error.noise { significant(error.rms) } else { format!("< {}", significant(error.noise)) }
}
