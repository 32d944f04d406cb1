//! Compares devices as Markdown to paste and as CSV to process.

use super::{Cell, Names, cell, interlock_cell, selection};
use crate::bench::{BUILD_PATHS, Comparison, Timing, Verdict};
use crate::report::format::{NOTHING, one_line, significant, status_word};
use crate::report::warnings::MARK;
use crate::{Error, Result};
use serde_json::{Number, Value, json};

/// Returns the verdict on a ratio in a few words.
pub(super) fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Same => "no difference",
        Verdict::Better => "faster",
        Verdict::Worse => "slower",
        Verdict::Unknown => "too unsteady to tell",
    }
}

fn row(cells: impl IntoIterator<Item = String>) -> String {
    let safe = |cell: String| one_line(&cell).replace('|', "\\|");
    format!("| {} |\n", cells.into_iter().map(safe).collect::<Vec<_>>().join(" | "))
}

/// Returns a cell's time, with its mark.
fn timed(cell: &Cell) -> String {
    cell.text.clone() + if cell.marked { MARK } else { "" }
}

fn header(cells: Vec<String>) -> String {
    let rule = cells.iter().map(|_| "---".to_owned()).collect::<Vec<_>>();
    row(cells) + &row(rule)
}

/// Returns Markdown: the answer in sentences, one table per scene with the rows that two or more devices have, what interlock gains, and
/// the errors that differ.
pub fn devices_markdown(beside: &Comparison) -> String {
    let names = Names::of(beside);
    let mut text = format!("{}\n", selection::devices_answer(beside));
    for sentence in selection::best(beside, &names) {
        text += &format!("\n{sentence}.\n");
    }
    for sentence in selection::stages(beside) {
        text += &format!("\n{sentence}.\n");
    }
    let what = selection::what(beside);
    let columns = || beside.columns.iter().map(|column| column.name.clone());
    text += &format!(
        "\nMilliseconds of a {what} [5th–95th percentile], and how many times as long as in the first that is not marked.\n"
    );
    let mut scene = String::new();
    for place in beside.shared() {
        let line = &beside.lines[place];
        let is = &beside.any(line).scene;
        if *is != scene {
            scene.clone_from(is);
            text += &format!("\n**{}**\n\n", one_line(is));
            text += &header(["technique".to_owned()].into_iter().chain(columns()).collect());
        }
        let cells = (0..beside.columns.len()).map(|column| {
            let cell = cell(beside, line, column);
            [timed(&cell), cell.band, cell.ratio]
                .into_iter()
                .filter(|part| !part.is_empty())
                .collect::<Vec<_>>()
                .join(" ")
        });
        text += &row([format!("`{}`", names.with_path(place))].into_iter().chain(cells));
    }
    let built = beside.built();
    if !built.is_empty() {
        text += "\n**What interlock buys**: milliseconds of a build, and how many times as long as by interlock.\n\n";
        for bought in selection::interlock(beside, &built) {
            text += &format!("- {}\n", bought.long);
        }
        text += "\n";
        text += &header(["build", "device"].into_iter().chain(BUILD_PATHS).map(str::to_owned).collect());
        for of in built.iter().flatten() {
            let first = of.lines.iter().flatten().next().copied().unwrap_or(0);
            let scene = &beside.any(&beside.lines[first]).scene;
            let cells = (0..BUILD_PATHS.len()).map(|path| {
                let cell = interlock_cell(beside, of, path);
                format!("{} {}", timed(&cell), cell.ratio)
            });
            let naming = [format!("{scene} `{}`", names.compact(first)), beside.columns[of.column].name.clone()];
            text += &row(naming.into_iter().chain(cells));
        }
    }
    text += "\n**What was measured**\n\n";
    text += &header(["device", "driver", "gobo", "rows"].map(str::to_owned).into());
    for column in &beside.columns {
        let results = &column.results;
        let rows = results.rows.len().to_string();
        text += &row([column.name.clone(), results.device.driver.clone(), results.edition(), rows]);
    }
    let agreement = beside.agreement();
    if !agreement.disagreements.is_empty() {
        text += "\n**Errors that differ by more than rounding**\n\n";
        let naming = ["scene", "technique", "error"].map(str::to_owned);
        text += &header(naming.into_iter().chain(columns()).chain(["apart", "share"].map(str::to_owned)).collect());
        for found in &agreement.disagreements {
            let line = &beside.lines[found.line];
            let naming =
                [beside.any(line).scene.clone(), format!("`{}`", names.with_path(found.line)), found.name.to_owned()];
            let values = found.values.iter().map(|value| value.map_or(NOTHING.into(), significant));
            text +=
                &row(naming.into_iter().chain(values).chain([significant(found.apart), selection::share(found.share)]));
        }
    }
    text
}

/// Returns CSV with one line per row and device. Numbers have full precision; missing values are empty fields.
///
/// # Errors
/// [`Error::Output`] if memory runs out.
pub fn devices_csv(beside: &Comparison) -> Result<String> {
    let fail = |cause: &dyn std::fmt::Display| Error::output("devices.csv".as_ref(), cause);
    let mut writer = csv::Writer::from_writer(Vec::new());
    let is_marked = beside.columns.iter().flat_map(|column| &column.results.rows).any(|row| !row.marks.is_empty());
    let columns = [
        "scene",
        "technique",
        "variant",
        "path",
        "device",
        "driver",
        "commit",
        "changed",
        "files",
        "status",
        "reason",
        "compared",
        "median_ns",
        "p05_ns",
        "p95_ns",
        "samples",
        "ratio_to_first",
        "verdict",
        "build_median_ns",
        "build_p05_ns",
        "build_p95_ns",
        "lookup_median_ns_per_million",
        "draw_median_ns",
        "frame_ns",
        "cost_ns",
        "bytes_resident",
        "seen_mean",
        "map_mean_abs",
        "space_mean_abs",
        "surface_mean_abs",
        "image_flip_mean",
        "differs",
    ];
    // The column exists only if a row is marked.
    let columns = columns.into_iter().chain(is_marked.then_some("marks"));
    writer.write_record(columns).map_err(|cause| fail(&cause))?;
    let agreement = beside.agreement();
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    for (place, line) in beside.lines.iter().enumerate() {
        for (index, column) in beside.columns.iter().enumerate() {
            let Some(row) = beside.row(line, index) else { continue };
            let time = beside.time(row);
            let of = |timing: Option<Timing>| {
                [timing.map(|t| t.median), timing.map(|t| t.p05), timing.map(|t| t.p95)].map(number)
            };
            let ratio =
                beside.first(line).filter(|first| *first < index).and_then(|first| beside.ratio(line, index, first));
            let mut fields = vec![row.scene.clone(), row.technique.clone(), row.spec(), row.path.clone()];
            fields.extend([column.results.device.name.clone(), column.results.device.driver.clone()]);
            let changed = column.results.changed.map(|changed| changed.to_string());
            fields.extend([column.results.commit.clone(), changed].map(Option::unwrap_or_default));
            fields.extend([column.files.join(" "), status_word(row.status).into(), one_line(&row.reason)]);
            fields.push(selection::what(beside).into());
            fields.extend(of(time));
            fields.push(time.map(|t| t.samples.to_string()).unwrap_or_default());
            fields.push(number(ratio.map(|(ratio, _)| ratio)));
            fields.push(ratio.map(|(_, verdict)| verdict_word(verdict).to_owned()).unwrap_or_default());
            fields.extend(of(row.build_ns));
            fields.extend([row.lookup_ns_per_million, row.draw_ns].map(|timing| number(timing.map(|t| t.median))));
            fields.extend([row.frame_ns, row.cost_ns].map(number));
            fields.push(row.bytes_resident.map(|b| b.to_string()).unwrap_or_default());
            let error = row.error.as_ref();
            fields.push(number(error.and_then(|e| e.seen).map(|seen| seen.mean)));
            let points = [error.and_then(|e| e.map), error.and_then(|e| e.space), error.and_then(|e| e.surface)];
            fields.extend(points.map(|points| number(points.map(|p| p.mean_abs))));
            fields.push(number(error.and_then(|e| e.image).map(|image| image.flip_mean)));
            let differs = agreement.disagreements.iter().filter(|d| d.line == place && d.values[index].is_some());
            fields.push(differs.map(|d| d.name).collect::<Vec<_>>().join(", "));
            fields.extend(is_marked.then(|| row.marks.join("; ")));
            writer.write_record(fields).map_err(|cause| fail(&cause))?;
        }
    }
    let bytes = writer.into_inner().map_err(|failed| fail(failed.error()))?;
    String::from_utf8(bytes).map_err(|cause| fail(&cause))
}

/// Returns the same data as JSON: the sentences, and the lines of [`devices_csv`] keyed by column name. Values that a line lacks are
/// omitted.
///
/// # Errors
/// See [`devices_csv`].
pub fn devices_json(beside: &Comparison) -> Result<Value> {
    let csv = devices_csv(beside)?;
    let fail = |cause: csv::Error| Error::output("devices.csv".as_ref(), cause);
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().map_err(fail)?.clone();
    let mut rows = Vec::new();
    for line in reader.records() {
        let line = line.map_err(fail)?;
        let fields = names.iter().zip(&line).filter(|(_, text)| !text.is_empty());
        let value = |(name, text): (&str, &str)| {
            let number = if is_number(name) { text.parse().ok().and_then(Number::from_f64) } else { None };
            (name.to_owned(), number.map_or_else(|| Value::from(text), Value::Number))
        };
        rows.push(Value::Object(fields.map(value).collect()));
    }
    let best = selection::best(beside, &Names::of(beside));
    let bought: Vec<_> = selection::interlock(beside, &beside.built()).into_iter().map(|bought| bought.long).collect();
    let (answer, stages) = (selection::devices_answer(beside), selection::stages(beside));
    Ok(json!({ "answer": answer, "best": best, "stages": stages, "interlock": bought, "rows": rows }))
}

/// Whether a column of [`devices_csv`] contains numbers.
fn is_number(column: &str) -> bool {
    let ends = ["_ns", "_per_million", "_abs", "_mean", "samples", "_resident", "_first"];
    ends.iter().any(|end| column.ends_with(end))
}
