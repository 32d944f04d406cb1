//! The marks of docs/notebook/all.md behind frame times: those of rows that no other beats in both frame time and error in space.

use super::rows::{Rows, Which};
use std::path::Path;

/// What the table's recipe calls a scene, and where its rows are.
const SCENES: [(&str, &str, &str); 5] = [
    ("p", "plume_8k", "nvidia-h100/all"),
    ("k", "plume_64k", "nvidia-h100/all"),
    ("b", "big-8k", "nvidia-h100/all"),
    ("m", "three-emitters", "nvidia-h100/all-moving"),
    ("h", "hair", "nvidia-h100/all"),
];

#[test]
fn marks_are_of_the_front() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/notebook/all.md")).expect("the page");
    let recipe = page.split("<!-- rows nvidia-h100/all\n").nth(1).and_then(|rest| rest.split("-->").next());
    let lines: Vec<(String, &str)> = recipe
        .expect("the table")
        .lines()
        .filter_map(|line| line.strip_prefix("t=")?.split_once(" | "))
        .map(|(spec, cells)| (spec.replace(';', ","), cells))
        .collect();
    let mut marks = 0;
    for (letter, scene, file) in SCENES {
        let rows = Rows::read(root, file).expect(file);
        let figures = |spec: &str| {
            let value = |column| rows.value(&Which { scene, spec }, column).expect(spec);
            (value("frame"), value("space.error"))
        };
        let all: Vec<(f64, f64)> = lines.iter().map(|(spec, _)| figures(spec)).collect();
        for ((spec, cells), own) in lines.iter().zip(&all) {
            let beaten = all.iter().any(|other| other != own && other.0 <= own.0 && other.1 <= own.1);
            let marked = cells.contains(&format!("{{frame {letter}}} *"));
            assert_eq!(marked, !beaten, "{spec} on {scene}: {own:?}");
            marks += usize::from(marked);
        }
    }
    assert!(lines.len() > 20 && marks > 20, "{marks} marks in {} lines", lines.len());
}
