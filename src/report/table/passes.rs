//! The passes of a build, for the terminal: the timing table of NVIDIA's "Particle Shadow Mapping" (2013) for every technique; and the
//! passes of a picture, if it takes several.

use crate::bench::{PassTiming, Results, Row, Status, Timing};
use crate::report::answer::pareto::scenes;
use crate::report::format::{NOTHING, Specs, milliseconds, one_line, significant};
use comfy_table::presets;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

/// Formats each scene's measured rows, one per line, with a column of median milliseconds for each pass. Further columns have the time of
/// the passes that techniques share (the world, fits, orders, opaque maps), of the technique's own passes, and of the whole build. If the
/// device's copy rate is known, one more column has the build time divided by the floor, which is the time to copy the bytes that look-ups
/// need. A second table shows drawing times, for rows whose pictures take several passes.
pub fn passes(results: &Results) -> String {
    let specs = Specs::of(&results.rows);
    let mut text = String::new();
    for scene in scenes(results) {
        let rows: Vec<&Row> = results.rows.iter().filter(|r| r.scene == scene && r.status == Status::Ok).collect();
        let scene = one_line(scene);
        let floor = results.device.copy_bytes_per_second;
        text += &table(&format!("{scene}: passes, ms"), &rows, &specs, BUILD, floor);
        let drawn: Vec<&Row> = rows.into_iter().filter(|row| !row.draw_passes.is_empty()).collect();
        if !drawn.is_empty() {
            text += &table(&format!("{scene}: drawing, ms"), &drawn, &specs, DRAW, None);
        }
    }
    if let Some(rate) = results.device.copy_bytes_per_second {
        text += &format!("floor: copying as many bytes as look-ups need, at {} GB/s\n", significant(rate / 1e9));
    }
    text
}

/// The subject of a table.
#[derive(Clone, Copy)]
struct PassTable {
    /// Passes of a row.
    passes: fn(&Row) -> &Vec<PassTiming>,
    /// Time of all these passes.
    whole: fn(&Row) -> Option<Timing>,
    /// Time of the passes that techniques share, if there are any.
    shared: Option<fn(&Row) -> Option<f64>>,
}

const BUILD: PassTable =
    PassTable { passes: |row| &row.passes, whole: |row| row.build_ns, shared: Some(Row::shared_ns) };
const DRAW: PassTable = PassTable { passes: |row| &row.draw_passes, whole: |row| row.draw_ns, shared: None };

/// Formats rows with their passes. `rate` is the device's copy rate in bytes per second, for the floor column.
fn table(
    title: &str,
    rows: &[&Row],
    specs: &Specs,
    PassTable { passes, whole, shared }: PassTable,
    rate: Option<f64>,
) -> String {
    let names = names(rows.iter().map(|row| passes(row)));
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let floor = rate.map(|_| "× floor");
    let sums = if shared.is_some() { &["shared", "own", "total"][..] } else { &["total"] };
    table.set_header([title, "path"].into_iter().chain(names.iter().copied()).chain(sums.iter().copied()).chain(floor));
    for row in rows {
        let of = |name: &&str| passes(row).iter().find(|p| p.name == *name).map(|p| p.median_ns);
        let total = whole(row).map(|t| t.median);
        // Passes are timed in separate builds, so their times do not add up exactly to the whole.
        let parts = shared.map(|shared| shared(row)).map(|shared| {
            let all = (!passes(row).is_empty()).then(|| passes(row).iter().map(|p| p.median_ns).sum::<f64>());
            [shared, all.zip(shared).map(|(all, shared)| all - shared)]
        });
        let times = names.iter().map(of).chain(parts.into_iter().flatten()).chain([total]);
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

/// Returns the names of build passes, in the order in which they first ran.
pub(in crate::report) fn pass_names<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
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
