//! The passes of a build, for the terminal: the table of timings in NVIDIA's "Particle Shadow Mapping" (2013), for
//! whatever technique.

use crate::measure::{Results, Row, Status};
use crate::report::pareto::scenes;
use crate::report::wording::{NOTHING, Specs, milliseconds, one_line, significant};
use comfy_table::presets;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

/// A scene's measured rows one a line, a column for each pass: median milliseconds, and those of the whole build. Where it
/// is known how fast the device copies, also the whole over the floor: the time of copying the bytes that look-ups need.
pub fn passes(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let rows: Vec<&Row> = results.rows.iter().filter(|r| r.scene == scene && r.status == Status::Ok).collect();
        let names = pass_names(rows.iter().copied());
        let mut table = Table::new();
        table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
        let floor = results.device.copy_bytes_per_second.map(|_| "× floor");
        let title = format!("{}: passes, ms", one_line(scene));
        table.set_header(
            [title.as_str(), "path"].into_iter().chain(names.iter().copied()).chain(["total"]).chain(floor),
        );
        for row in rows {
            let of = |name: &&str| row.passes.iter().find(|p| p.name == *name).map(|p| p.median_ns);
            let times = names.iter().map(of).chain([row.build_ns.map(|t| t.median)]);
            let naming = [format!("  {}", specs.compact(row)), one_line(&row.path)].map(Cell::new);
            let number = |time: Option<f64>| {
                Cell::new(time.map_or(NOTHING.into(), milliseconds)).set_alignment(CellAlignment::Right)
            };
            let over = results.device.copy_bytes_per_second.map(|rate| {
                let floor_ns = row.bytes_resident.map(|bytes| bytes as f64 * 1e9 / rate);
                let over = row.build_ns.zip(floor_ns).map(|(build, floor)| significant(build.median / floor));
                Cell::new(over.unwrap_or(NOTHING.into())).set_alignment(CellAlignment::Right)
            });
            table.add_row(naming.into_iter().chain(times.map(number)).chain(over));
        }
        for (place, column) in table.column_iter_mut().enumerate() {
            column.set_padding((0, 2));
            if place >= 2 {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        for line in table.lines() {
            text += line.trim_end();
            text.push('\n');
        }
    }
    if let Some(rate) = results.device.copy_bytes_per_second {
        text += &format!("floor: copying as many bytes as look-ups need, at {} GB/s\n", significant(rate / 1e9));
    }
    text
}

/// In the order in which they first ran.
pub(super) fn pass_names<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for pass in rows.flat_map(|row| &row.passes) {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    names
}
