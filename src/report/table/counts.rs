//! Work counts of passes, for the terminal.

use crate::bench::{PassCount, Results, Row};
use crate::gpu::Executable;
use crate::report::answer::pareto::scenes;
use crate::report::format::{Specs, one_line};
use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, Table};

/// Formats one table per scene. Each row has a line for each of its passes: those of a build first, then those of its picture. Below the
/// tables are the driver's reports about compiled shaders, if any. Empty unless counts were requested.
pub fn counts(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let counted = |row: &&Row| row.scene == scene && !row.counts.is_empty();
        let rows: Vec<&Row> = results.rows.iter().filter(counted).collect();
        if !rows.is_empty() {
            text += &table(&one_line(scene), &rows, &specs);
        }
    }
    if let (false, Some(width)) = (text.is_empty(), results.device.features.get("subgroup_size")) {
        text += &format!("threads run in subgroups of {width}\n");
    }
    if !text.is_empty() && !results.executables.is_empty() {
        text += &programs(&results.executables);
    }
    text
}

/// Formats one line per program, with the driver's names for its figures.
fn programs(executables: &[Executable]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    table.set_header(["pipelines, as the driver made them", "program", "subgroup", "what it tells"]);
    for Executable { pipeline, name, subgroup_size, figures } in executables {
        let figures: Vec<_> = figures.iter().map(|(name, value)| format!("{}: {value}", one_line(name))).collect();
        table.add_row([
            &format!("  {}", one_line(pipeline)),
            &one_line(name),
            &subgroup_size.to_string(),
            &figures.join(", "),
        ]);
    }
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 2));
    });
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

fn table(scene: &str, rows: &[&Row], specs: &Specs) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let title = format!("{scene}: passes, how many of each");
    table.set_header([&title, "passes", "vertices", "primitives", "fragments", "threads"]);
    for row in rows {
        table.add_row([format!("  {} {}", specs.compact(row), one_line(&row.path)).trim_end().to_owned()]);
        for PassCount { name, runs, counts } in &row.counts {
            let numbers = [*runs, counts.vertices, counts.primitives, counts.fragments, counts.threads];
            table.add_row(
                std::iter::once(format!("    {}", one_line(name))).chain(numbers.map(|number| number.to_string())),
            );
        }
    }
    for (place, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if place > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
