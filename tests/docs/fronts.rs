//! The fronts of docs/notebook/all.md: the marks behind frame times, of rows that no other beats in both frame time and error in space,
//! and the table of all fronts, each of an error against a cost. `GOBO_WRITE_TABLES=1` writes that table.

use super::rows::{Rows, Which};
use std::path::{Path, PathBuf};

/// What the table's recipe calls a scene, its name, and where its rows are.
const SCENES: [(&str, &str, &str); 5] = [
    ("p", "plume_8k", "nvidia-h200/all"),
    ("k", "plume_64k", "nvidia-h200/all"),
    ("b", "big-8k", "nvidia-h200/all"),
    ("m", "three-emitters", "nvidia-h200/all-moving"),
    ("h", "hair", "nvidia-h200/all"),
];

const PLANES: [(&str, &str); 6] = [
    ("map.error", "build"),
    ("map.error", "frame"),
    ("map.error", "resident"),
    ("space.error", "build"),
    ("space.error", "frame"),
    ("space.error", "resident"),
];

const BEGIN: &str = "<!-- fronts -->\n";
const END: &str = "<!-- /fronts -->";

/// A row of the table of times.
struct Line {
    spec: String,
    label: String,
    cells: String,
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/notebook/all.md")
}

fn lines(text: &str) -> Vec<Line> {
    let recipe = text.split("<!-- rows nvidia-h200/all\n").nth(1).and_then(|rest| rest.split("-->").next());
    let line = |line: &str| {
        let (spec, rest) = line.strip_prefix("t=")?.split_once(" | ")?;
        let (label, cells) = rest.split_once(" | ")?;
        Some(Line { spec: spec.replace(';', ","), label: label.to_owned(), cells: cells.to_owned() })
    };
    recipe.expect("the table").lines().filter_map(line).collect()
}

/// Whether each line is on the front of its scene: none is at most as dear and at most as wrong, and other in one of them. What has no
/// such error or no such cost is on none; `none` is not, since it has no shadow.
fn front(lines: &[Line], rows: &Rows, scene: &str, error: &str, cost: &str) -> Vec<bool> {
    let figures = |line: &Line| {
        let value = |column| rows.value(&Which { scene, spec: &line.spec }, column).ok();
        (line.spec != "none").then(|| Some((value(cost)?, value(error)?))).flatten()
    };
    let all: Vec<Option<(f64, f64)>> = lines.iter().map(figures).collect();
    let beaten =
        |own: (f64, f64)| all.iter().flatten().any(|other| *other != own && other.0 <= own.0 && other.1 <= own.1);
    all.iter().map(|own| own.is_some_and(|own| !beaten(own))).collect()
}

#[test]
fn marks_are_of_the_front() {
    let text = std::fs::read_to_string(page()).expect("the page");
    let lines = lines(&text);
    let mut marks = 0;
    for (letter, scene, file) in SCENES {
        let rows = Rows::read(Path::new(env!("CARGO_MANIFEST_DIR")), file).expect(file);
        for (line, on) in lines.iter().zip(front(&lines, &rows, scene, "space.error", "frame")) {
            let marked = line.cells.contains(&format!("{{frame {letter}}} *"));
            assert_eq!(marked, on, "{} on {scene}", line.spec);
            marks += usize::from(marked);
        }
    }
    assert!(lines.len() > 20 && marks > 20, "{marks} marks in {} lines", lines.len());
}

#[test]
fn fronts_are_those_of_the_rows() {
    let text = std::fs::read_to_string(page()).expect("the page");
    let lines = lines(&text);
    let files: Vec<Rows> =
        SCENES.map(|(_, _, file)| Rows::read(Path::new(env!("CARGO_MANIFEST_DIR")), file).expect(file)).into();
    // By plane, then scene, then line.
    let fronts = PLANES.map(|(error, cost)| {
        let of = |((_, scene, _), rows): (&(&str, &str, &str), &Rows)| front(&lines, rows, scene, error, cost);
        SCENES.iter().zip(&files).map(of).collect::<Vec<_>>()
    });
    let cell = |plane: &Vec<Vec<bool>>, i: usize| {
        let names = SCENES.iter().zip(plane).filter(|(_, on)| on[i]).map(|((letter, ..), _)| *letter);
        names.collect::<Vec<_>>().join(" ")
    };
    let mut table = String::from(
        "| technique | at texels, build | frame | bytes | in space, build | frame | bytes |\n|---|---|---|---|---|---|---|\n",
    );
    for (i, line) in lines.iter().enumerate() {
        let cells: Vec<String> = fronts.iter().map(|plane| cell(plane, i)).collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            table += &format!("| {} | {} |\n", line.label, cells.join(" | "));
        }
    }
    let (before, rest) = text.split_once(BEGIN).expect("the beginning");
    let (old, after) = rest.split_once(END).expect("the end");
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(page(), format!("{before}{BEGIN}{table}{END}{after}")).expect("write the page");
    } else {
        assert_eq!(old, table, "GOBO_WRITE_TABLES=1 cargo test --release --test docs fronts writes it anew");
    }
    // What is exact is on each front of errors in space, whatever it costs.
    let exact = lines.iter().position(|line| line.spec == "grid-query").expect("grid-query");
    assert!(fronts[3..].iter().all(|plane| plane.iter().all(|scene| scene[exact])));
}
