//! The passes of a build, for the terminal: the table of timings in NVIDIA's "Particle Shadow Mapping" (2013), for
//! whatever technique; and those of a picture that is not shaded in one.

use crate::measure::{PassTiming, Results, Row, Status, Timing};
use crate::report::pareto::scenes;
use crate::report::wording::{NOTHING, Specs, milliseconds, one_line, significant};
use comfy_table::presets;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

/// A scene's measured rows one a line, a column for each pass: median milliseconds, and those of the whole build. Where it
/// is known how fast the device copies, also the whole over the floor: the time of copying the bytes that look-ups need. Below,
/// the same of drawing, for rows whose pictures are drawn in passes.
pub fn passes(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let rows: Vec<&Row> = results.rows.iter().filter(|r| r.scene == scene && r.status == Status::Ok).collect();
        let scene = one_line(scene);
        let floor = results.device.copy_bytes_per_second;
        text += &table(&format!("{scene}: passes, ms"), &rows, &specs, (|row| &row.passes, |row| row.build_ns), floor);
        let drawn: Vec<&Row> = rows.into_iter().filter(|row| !row.draw_passes.is_empty()).collect();
        if !drawn.is_empty() {
            let of: (Passes, Whole) = (|row| &row.draw_passes, |row| row.draw_ns);
            text += &table(&format!("{scene}: drawing, ms"), &drawn, &specs, of, None);
        }
    }
    if let Some(rate) = results.device.copy_bytes_per_second {
        text += &format!("floor: copying as many bytes as look-ups need, at {} GB/s\n", significant(rate / 1e9));
    }
    text
}

/// Which passes of a row.
type Passes = fn(&Row) -> &Vec<PassTiming>;

/// And their time in all.
type Whole = fn(&Row) -> Option<Timing>;

/// Rows with their passes. `rate` is how many bytes a second the device copies, for the column of the floor.
fn table(title: &str, rows: &[&Row], specs: &Specs, (passes, whole): (Passes, Whole), rate: Option<f64>) -> String {
    let names = names(rows.iter().map(|row| passes(row)));
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let floor = rate.map(|_| "× floor");
    table.set_header([title, "path"].into_iter().chain(names.iter().copied()).chain(["total"]).chain(floor));
    for row in rows {
        let of = |name: &&str| passes(row).iter().find(|p| p.name == *name).map(|p| p.median_ns);
        let times = names.iter().map(of).chain([whole(row).map(|t| t.median)]);
        let naming = [format!("  {}", specs.compact(row)), one_line(&row.path)].map(Cell::new);
        let number = |time: Option<f64>| {
            Cell::new(time.map_or(NOTHING.into(), milliseconds)).set_alignment(CellAlignment::Right)
        };
        let over = rate.map(|rate| {
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
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Of builds, in the order in which they first ran.
pub(super) fn pass_names<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
    names(rows.map(|row| &row.passes))
}

fn names<'a>(all: impl Iterator<Item = &'a Vec<PassTiming>>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for pass in all.flatten() {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    names
}
