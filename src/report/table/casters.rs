//! Errors in the shadows of meshes by caster distance, for the terminal.

use crate::bench::{CASTER_CLASSES, CasterClass, CasterError, Results, Row};
use crate::report::answer::pareto::scenes;
use crate::report::format::{NOTHING, Specs, grouped, one_line, significant};
use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, Table};

/// The end of the segment between light and point from which distances are measured.
pub(in crate::report) type End = fn(&CasterError) -> Option<&Vec<CasterClass>>;

/// Both ends, by name.
pub(in crate::report) const ENDS: [(&str, End); 2] =
    [("light to caster", |error| error.from_light.as_ref()), ("caster to surface", |error| Some(&error.from_receiver))];

/// Formats two tables per scene, one row per line: the first sorts shadowed surface points by their caster's distance from the light, the
/// second by its distance from the surface. Each class of distances has a column with the mean error at its points and the number of leaks
/// among them. Empty if there are no such points.
pub fn casters(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let rows: Vec<(&Row, &CasterError)> = results
            .rows
            .iter()
            .filter(|row| row.scene == scene)
            .filter_map(|row| Some((row, row.error.as_ref()?.casters.as_ref()?)))
            .collect();
        for (name, end) in ENDS {
            let rows: Vec<_> = rows.iter().filter_map(|(row, error)| Some((*row, end(error)?))).collect();
            if !rows.is_empty() {
                text += &table(&format!("{}: {name}", one_line(scene)), &rows, &specs);
            }
        }
    }
    if !text.is_empty() {
        text += "mean error of surface points in the shadow of meshes, and leaks of how many, by distance in parts of the meshes' diagonal\n";
    }
    text
}

fn table(title: &str, rows: &[(&Row, &Vec<CasterClass>)], specs: &Specs) -> String {
    let headings = (0..CASTER_CLASSES.len()).map(heading).collect();
    let rows = rows.iter().map(|(row, classes)| (*row, classes.iter().map(cell).collect()));
    lines(title, headings, rows.collect(), specs)
}

/// Formats one line per row of the results, with a cell for each heading.
pub(in crate::report) fn lines(
    title: &str,
    headings: Vec<String>,
    rows: Vec<(&Row, Vec<String>)>,
    specs: &Specs,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header([title.to_owned(), "path".into()].into_iter().chain(headings));
    for (row, cells) in rows {
        let naming = [format!("  {}", specs.compact(row)), one_line(&row.path)];
        table.add_row(naming.into_iter().chain(cells));
    }
    for (place, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if place >= 2 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Formats a class of distances: `1/64–1/32`.
pub(in crate::report) fn heading(class: usize) -> String {
    let part = |from: f64| if from == 0.0 { "0".into() } else { format!("1/{}", (1.0 / from).round()) };
    let from = part(CASTER_CLASSES[class]);
    CASTER_CLASSES.get(class + 1).map_or(format!("{from} and more"), |to| format!("{from}–{}", part(*to)))
}

/// Formats a class's errors: `0.0123, 4 of 1 234`.
pub(in crate::report) fn cell(class: &CasterClass) -> String {
    let text = |mean| format!("{}, {} of {}", significant(mean), grouped(class.leaks), grouped(class.points));
    class.mean_abs.map_or(NOTHING.into(), text)
}
