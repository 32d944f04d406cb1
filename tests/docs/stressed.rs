//! Figures in docs/notebook/stress.md derived from stress.csv: the number of rows per outcome, and verdicts by the techniques' current
//! promises. `GOBO_WRITE_TABLES=1` rewrites both, between `<!-- stress FOLDER -->` and `<!-- /stress -->`.

use gobo::bench::stress::{CaseResult, ErrorSummary, Figures, Outcome, verdicts};
use gobo::bench::{PartError, PointError};
use std::collections::BTreeMap;
use std::path::Path;

type Row = BTreeMap<String, String>;

fn number<T: std::str::FromStr>(row: &Row, column: &str) -> Option<T> {
    row[column].parse().ok()
}

/// Returns the figures of a row that verdicts use.
fn stressed(row: &Row) -> CaseResult {
    let asked = |points: &str| {
        let column = |name: &str| format!("{points}_{name}");
        // Counts all points that are wrong beyond the resolution as leaks: only their sum matters.
        let wrong: Option<u64> = number(row, &column("wrong"));
        let error = number(row, &column("mean_abs")).map(|mean_abs: f64| PointError {
            points: number(row, &column("points")),
            mean_abs,
            leaks: wrong,
            false_shadows: wrong.map(|_| 0),
            within: wrong.map(|_| PartError::default()),
            ..PointError::default()
        });
        number(row, &column("points")).map(|points| ErrorSummary { error, points })
    };
    let outcome = match row["outcome"].as_str() {
        "answered" => Outcome::Answered,
        "refused" => Outcome::Refused,
        "failed" => Outcome::Failed,
        "no-answer" => Outcome::NoAnswer,
        other => panic!("{other}"),
    };
    let figures = || Figures {
        map: asked("map"),
        space: asked("space"),
        surface: asked("surface"),
        // Verdicts do not use seen errors, and older rows lack them.
        seen: None,
        not_finite: number(row, "not_finite").expect("a count"),
        outside: number(row, "outside").expect("a count"),
        rise: number(row, "rise"),
        tail: number(row, "tail"),
        order_spread: number(row, "order_spread"),
        step_rms: number(row, "step_rms"),
        messages: number(row, "messages").expect("a count"),
    };
    CaseResult {
        case: row["case"].clone(),
        value: number(row, "value").expect("a value"),
        technique: row["technique"].clone(),
        path: row["path"].clone(),
        outcome,
        // Older rows have this message in its uncorrected form.
        reason: row["reason"].replace("texels a side", "texels per side"),
        figures: (outcome == Outcome::Answered).then(figures),
    }
}

/// Formats a number with separated thousands.
fn count(number: usize) -> String {
    match number {
        0..1000 => number.to_string(),
        _ => format!("{},{:03}", number / 1000, number % 1000),
    }
}

/// Formats the number of rows per outcome, and a line for each case and verdict except *holds* and refusals.
fn block(root: &Path, folder: &str) -> String {
    let path = root.join("results").join(folder).join("stress.csv");
    let mut reader = csv::Reader::from_path(&path).expect(folder);
    let rows: Vec<CaseResult> = reader.deserialize().map(|row| stressed(&row.expect("a row"))).collect();
    let of = |outcome: Outcome| count(rows.iter().filter(|row| row.outcome == outcome).count());
    let verdicts = verdicts(&rows);
    let broken = verdicts.iter().filter(|verdict| !verdict.invariants.is_empty()).count();
    let text = format!(
        "{} rows: {} answered, {} refused, {} with no answer in time, {} failed. Broken invariants: {broken} of {} verdicts.\n\n",
        count(rows.len()),
        of(Outcome::Answered),
        of(Outcome::Refused),
        of(Outcome::NoAnswer),
        of(Outcome::Failed),
        count(verdicts.len()),
    );
    let mut lines: Vec<(&str, String, Vec<&str>)> = Vec::new();
    for verdict in verdicts.iter().filter(|v| v.verdict != "holds" && !v.verdict.starts_with("refused")) {
        let at = verdict.breaks_at.filter(|_| verdict.holds_up_to.is_some());
        let at = at.map(|at| format!("; at {at} {}", verdict.why)).unwrap_or_default();
        let only = if verdict.holds_up_to.is_none() { verdict.why.as_str() } else { "" };
        let words = format!("{}{at} {only}", verdict.verdict).trim_end().replace('|', "or");
        match lines.iter_mut().find(|(case, text, _)| *case == verdict.case && *text == words) {
            Some((.., techniques)) => techniques.push(&verdict.technique),
            None => lines.push((&verdict.case, words, vec![&verdict.technique])),
        }
    }
    let line = |(case, words, techniques): &(&str, String, Vec<&str>)| {
        let specs: Vec<String> = techniques.iter().map(|spec| format!("`{spec}`")).collect();
        format!("| {case} | {} | {words} |\n", specs.join(", "))
    };
    let lines: String = lines.iter().map(line).collect();
    format!("{text}| case | technique | verdict |\n|---|---|---|\n{lines}")
}

#[test]
fn stress_is_its_rows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("docs/notebook/stress.md");
    let page = std::fs::read_to_string(&path).expect("the page");
    let mut parts = page.split("<!-- stress ");
    let mut new = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (folder, rest) = part.split_once(" -->\n").expect("a folder");
        let (_, after) = rest.split_once("<!-- /stress -->").expect("an end");
        new += &format!("<!-- stress {folder} -->\n{}<!-- /stress -->{after}", block(root, folder));
    }
    assert!(new.matches("<!-- stress ").count() >= 2, "where are the tables of stress.md?");
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(&path, &new).expect("write the page");
    } else {
        for (old, new) in page.lines().zip(new.lines()) {
            assert_eq!(old, new, "docs/notebook/stress.md: GOBO_WRITE_TABLES=1 writes it anew");
        }
        assert_eq!(page.len(), new.len(), "docs/notebook/stress.md");
    }
}
