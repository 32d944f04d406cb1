//! The table for the terminal.

pub(super) mod casters;
pub(super) mod columns;
pub(super) mod counts;
pub(super) mod footprints;
pub(super) mod passes;
pub(super) mod regression;
pub(super) mod submission;

use crate::bench::{Results, Row, Status};
use crate::report::answer::pareto::scenes;
use crate::report::format::{Specs, one_line, outcome, path, shortened};
use crate::report::table::columns::{Column, shown};
use crate::report::warnings::{agreement, marked, notes};
use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};

/// Blanks between two columns.
const GAP: usize = 2;
/// Columns that every row has: the spec and the path.
const NAMING_COLUMNS: usize = 2;

/// Columns that stay, however narrow the terminal is.
const KEPT_COLUMNS: usize = 3;

/// Formats one row per line, grouped by scene in measured order. Columns in which no row has a value are left out. On a terminal that is
/// too narrow, the least useful columns are left out first, and a last line names them. The output has no color, so a file or a pipe gets
/// the same text at full width.
pub fn table(results: &Results) -> String {
    table_of_width(results, Table::new().width().map(usize::from))
}

fn table_of_width(results: &Results, width: Option<usize>) -> String {
    let specs = Specs::of(&results.rows);
    let device = &results.device;
    let mut text = one_line(&format!("{} ({}), {}, Vulkan {}", device.name, device.kind, device.driver, device.api));
    if let Some(stages) = device.stages.filter(|stages| stages.is_lopsided()) {
        text += &format!("; {}", stages.sentence());
    }
    text.push('\n');
    if let Some(shared) = specs.shared_line() {
        text += &format!("the same in every row that has it: {shared}\n");
    }
    if results.rows.is_empty() {
        return text + "nothing measured\n";
    }

    let mut columns = shown(results.rows.iter());
    let mut left_out = Vec::new();
    let mut longest_spec = usize::MAX;
    let lines = loop {
        let lines = lines(results, &specs, &columns, longest_spec);
        let widest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
        let Some(excess) = width.and_then(|width| widest.checked_sub(width)).filter(|&excess| excess > 0) else {
            break lines;
        };
        let most_dispensable = (0..columns.len()).max_by_key(|&place| columns[place].dispensable);
        match most_dispensable.filter(|_| columns.len() > KEPT_COLUMNS) {
            Some(place) => left_out.push(columns.remove(place).heading),
            // The last columns stay. The spec is shortened instead, as far as it remains distinguishable from others.
            None if longest_spec == usize::MAX => {
                let longest = results.rows.iter().map(|row| specs.compact(row).chars().count()).max().unwrap_or(0);
                longest_spec = longest.saturating_sub(excess).max(16);
            }
            None => break lines,
        }
    };
    for line in lines {
        text += &line;
        text.push('\n');
    }
    if !left_out.is_empty() {
        left_out.reverse();
        text += &format!("left out for this width: {}\n", left_out.join(", "));
    }
    let name = |row: &Row| format!("{} on {}", specs.compact(row), one_line(&row.scene));
    text.extend(notes(&results.rows, name).into_iter().map(|note| format!("note: {note}\n")));
    text.extend(marked(&results.rows, device.stages).map(|note| format!("note: {note}\n")));
    text.extend(agreement(results).map(|line| line + "\n"));
    text
}

/// Formats the heading and a rule, then each scene's name above its rows.
fn lines(results: &Results, specs: &Specs, columns: &[&Column], longest_spec: usize) -> Vec<String> {
    let spec = |row: &Row| shortened(&specs.compact(row), longest_spec);
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Disabled);
    let naming = ["  technique", "path"].map(String::from);
    table.set_header(naming.into_iter().chain(columns.iter().map(|column| column.heading.to_owned())));
    let mut rows: Vec<&Row> = Vec::new();
    for scene in scenes(results) {
        for row in results.rows.iter().filter(|row| row.scene == scene) {
            let naming = [format!("  {}", spec(row)), path(row)].map(Cell::new);
            let cells = columns.iter().map(|column| match row.status {
                Status::Ok => Cell::new(column.cell(row)).set_alignment(CellAlignment::Right),
                Status::Refused | Status::Failed => Cell::new(""),
            });
            table.add_row(naming.into_iter().chain(cells));
            rows.push(row);
        }
    }
    for (place, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, GAP as u16));
        if place >= NAMING_COLUMNS {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let widths: Vec<usize> = table.column_max_content_widths().iter().map(|&width| usize::from(width) + GAP).collect();
    let reason_starts: usize = widths.iter().take(NAMING_COLUMNS).sum();
    let table_width = widths.iter().sum::<usize>().saturating_sub(GAP);

    let mut rendered = table.lines();
    let mut lines: Vec<String> = rendered.next().map(|heading| heading.trim_end().to_owned()).into_iter().collect();
    lines.push("─".repeat(table_width));
    let mut scene = None;
    for (row, line) in rows.into_iter().zip(rendered) {
        if scene != Some(&row.scene) {
            lines.push(one_line(&row.scene));
            scene = Some(&row.scene);
        }
        match row.status {
            Status::Ok => lines.push(line.trim_end().to_owned()),
            // comfy_table has no cells that span columns, so the reason goes where the measured columns would be.
            Status::Refused | Status::Failed => {
                let mut start: String = line.chars().take(reason_starts).collect();
                for part in wrapped(&outcome(row), table_width.saturating_sub(reason_starts).max(24)) {
                    lines.push(format!("{start}{part}"));
                    start = " ".repeat(reason_starts);
                }
            }
        }
    }
    lines
}

/// Breaks text at blanks; a word longer than a line gets its own line.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{DeviceFacts, ImageError, PartError, PointError, RowError, SCHEMA, StageRates, Timing};

    fn row(nodes: &str, status: Status, reason: &str) -> Row {
        let measured = status == Status::Ok;
        let point = PointError {
            points: Some(64),
            mean_abs: 0.0142,
            bias: Some(-0.002),
            rms: Some(0.03),
            p99: Some(0.2),
            max: Some(0.5),
            ..PointError::default()
        };
        Row {
            scene: "plume_8k".into(),
            technique: "avsm".into(),
            variant: [("nodes", nodes), ("size", "256")].map(|(k, v)| (k.to_owned(), v.to_owned())).into(),
            path: "two-pass".into(),
            status,
            reason: reason.into(),
            build_ns: measured.then_some(Timing { median: 2e6, p05: 1.9e6, p95: 2.5e6, samples: 30 }),
            bytes_resident: Some(2 << 20),
            bytes_transient: Some(0),
            error: measured.then_some(RowError {
                seen: None,
                map: Some(point),
                space: Some(point),
                surface: None,
                casters: None,
                image: Some(ImageError { rmse: 0.01, flip_mean: 0.02, bounce_rmse: None, bounce_noise: None }),
            }),
            limit_mean_abs: Some(0.0071),
            ..Row::default()
        }
    }

    fn results(rows: Vec<Row>) -> Results {
        let device = DeviceFacts { name: "llvmpipe".into(), driver: "Mesa 26.1".into(), ..DeviceFacts::default() };
        Results { schema: SCHEMA, device, rows, ..Results::default() }
    }

    #[test]
    fn says_shared_keys_once_and_numbers_with_three_digits() {
        let text = table_of_width(&results(vec![row("4", Status::Ok, ""), row("8", Status::Ok, "")]), None);
        assert_eq!(text.matches("size=256").count(), 1, "{text}");
        let line = text.lines().find(|line| line.contains("nodes=8")).expect("the row");
        // 0.0142 / 0.0071 is 2.
        for part in ["avsm:nodes=8", "2.00 [1.90–2.50]", "2.00 MiB", "0.0142", "2.00×", "−0.00200", "0.500"] {
            assert!(line.contains(part), "{part} is not in {line}");
        }
        assert!(text.starts_with("llvmpipe") && text.contains("Mesa 26.1"), "{text}");
    }

    #[test]
    fn refused_rows_say_why_across() {
        let reason = "fragmentShaderSampleInterlock or fragmentShaderPixelInterlock of VK_EXT_fragment_shader_interlock, \
                      which this driver does not have, and neither has it another way to keep fragments in order here";
        let text = table_of_width(&results(vec![row("8", Status::Ok, ""), row("16", Status::Refused, reason)]), None);
        let told: Vec<&str> = text.lines().skip_while(|line| !line.contains("nodes=16")).collect();
        assert!(told[0].contains("refused: fragmentShaderSampleInterlock"), "{text}");
        let words: Vec<&str> = told.iter().flat_map(|line| line.split_whitespace()).collect();
        assert!(words.join(" ").ends_with(reason), "{text}");
        let width = text.lines().find(|line| line.starts_with('─')).map_or(0, |line| line.chars().count());
        assert!(told.iter().all(|line| line.chars().count() <= width), "{text}");
    }

    #[test]
    fn narrow_terminals_lose_columns_and_say_so() {
        let rows = vec![row("4", Status::Ok, ""), row("8", Status::Failed, "device lost\nat \u{1b}[31mresolve")];
        let text = table_of_width(&results(rows), Some(80));
        assert!(text.lines().skip(2).take(5).all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("left out for this width:"), "{text}");
        assert!(text.contains("map |err|") && text.contains("FLIP"), "{text}");
        assert!(text.contains("failed: device lost at") && !text.contains('\u{1b}'), "{text}");
    }

    /// The least valuable columns must be left out first, whatever the display order.
    #[test]
    fn what_is_worth_most_stays_longest() {
        let mut rows = vec![row("4", Status::Ok, ""), row("8", Status::Ok, "")];
        rows.iter_mut().for_each(|row| row.cost_ns = Some(5e6));
        let headings = ["cost ms", "resident", "FLIP", "map |err|", "space |err|", "build ms"];
        let shown = |width| {
            let text = table_of_width(&results(rows.clone()), Some(width));
            let heading = text.lines().find(|line| line.contains("technique")).expect("a heading").to_owned();
            headings.map(|name| heading.contains(name))
        };
        let mut kept = Vec::new();
        for width in 30..140 {
            let shown = shown(width);
            assert!(shown.is_sorted_by(|a, b| a >= b), "{width}: {shown:?}");
            kept.push(shown.iter().filter(|shown| **shown).count());
        }
        assert!(
            kept.is_sorted() && kept[0] == 3 && kept.contains(&4) && kept.contains(&5) && kept.contains(&6),
            "{kept:?}"
        );
    }

    /// A row whose technique does not see the smoke, whose times are unsteady and which has errors beyond its resolution. The table must
    /// state the unseen smoke beside the path, and give one note for each of the other two.
    #[test]
    fn what_a_reader_has_to_know_stands_beside_the_figures() {
        let mut odd = row("8", Status::Ok, "");
        odd.unseen = vec!["smoke".into()];
        odd.steadiness =
            Some(crate::bench::Stability { spread: Some(1.8), measured_again: true, ..Default::default() });
        let within = Some(PartError { points: 16, mean_abs: Some(0.05), leaks: 1, false_shadows: 0 });
        let points =
            PointError { points: Some(64), leaks: Some(3), false_shadows: Some(0), within, ..PointError::default() };
        odd.error.as_mut().expect("measured").surface = Some(points);
        let text = table_of_width(&results(vec![row("4", Status::Ok, ""), odd]), None);
        for part in [
            "two-pass, smoke is not seen",
            "note: avsm:nodes=8 on plume_8k: not steady: p95/p05 1.8, the steadier of two",
            "note: avsm:nodes=8 on plume_8k: on surfaces, beyond its own resolution: 2 leaks, 0 false shadows",
            "25 % (0.0500)",
        ] {
            assert!(text.contains(part), "{part} is not in {text}");
        }
        assert_eq!(text.matches("note:").count(), 2, "{text}");
    }

    /// The times of a marked row must have the mark, its errors must not, and one line must say why.
    #[test]
    fn a_marked_row_says_so_once() {
        let mut marked = row("8", Status::Ok, "");
        marked.marks = vec!["81 % raster work, on 4 of 132 processors".into()];
        let mut results = results(vec![row("4", Status::Ok, ""), marked.clone(), marked]);
        results.device.stages =
            Some(StageRates { fragment_slowdown: 32.9, fragment_processors: Some(4), processors: Some(132) });
        let text = table_of_width(&results, None);
        assert!(
            text.lines().next().is_some_and(|line| line.contains("; fragments run on 4 of 132 processors")),
            "{text}"
        );
        let note = "note: 2 rows are marked †: more than a quarter of their time is raster work, and fragments run on 4 of 132 \
                    processors, 33 times slower; their times decide no answer";
        assert_eq!(text.matches(note).count(), 1, "{text}");
        assert_eq!((text.matches("2.00† [1.90–2.50]").count(), text.matches('†').count()), (2, 3), "{text}");
        results.rows.iter_mut().for_each(|row| row.marks.clear());
        assert!(!table_of_width(&results, None).contains('†'));
    }

    /// Notes of one kind must take one line, however many rows have them.
    #[test]
    fn notes_of_one_kind_are_one_line() {
        let points = |leaks| {
            let within = Some(PartError { points: 16, mean_abs: Some(0.05), leaks: 1, false_shadows: 0 });
            let (points, leaks, false_shadows) = (Some(64), Some(leaks), Some(0));
            Some(PointError { points, leaks, false_shadows, within, ..PointError::default() })
        };
        let rows: Vec<Row> = (0..9u32)
            .map(|i| {
                let mut row = row(&i.to_string(), Status::Ok, "");
                let busy = Some(0.1 * f64::from(i));
                row.steadiness = Some(crate::bench::Stability { busy, measured_again: i == 8, ..Default::default() });
                let error = row.error.as_mut().expect("measured");
                (error.space, error.surface) = (points(u64::from(i)), points(1));
                row
            })
            .collect();
        let text = table_of_width(&results(rows), None);
        // Rows with a load of at least 0.3 are unsteady. Rows with at least two leaks in space, one of them within the resolution, are
        // wrong.
        let lines: Vec<_> = text.lines().filter(|line| line.starts_with("note:")).collect();
        assert_eq!(
            lines,
            [
                "note: 6 of 9 rows were not steady: others used up to 80 % of the processors (6), the steadier of two (1)",
                "note: 7 of 9 rows are wrong in space, beyond their own resolution: at most 7 leaks, 0 false shadows, avsm:nodes=8 on plume_8k",
            ],
            "{text}"
        );
    }

    #[test]
    fn no_rows() {
        assert!(table_of_width(&results(vec![]), Some(40)).contains("nothing measured"));
    }
}
