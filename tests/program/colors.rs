//! `compare` with a colored scene: printed and written values must be those measured; other scenes must show no color columns.

use crate::{folder, ok, results, text};

fn columns(folder: &std::path::Path) -> (csv::StringRecord, Vec<csv::StringRecord>) {
    let csv = std::fs::read_to_string(folder.join("results.csv")).expect("a CSV");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().expect("columns").clone();
    (names, reader.records().map(|record| record.expect("a record")).collect())
}

#[test]
fn errors_of_colors_are_beside_errors_of_points() {
    let out = folder();
    let few = ["--quick", "--frames", "1", "--picture", "32x18", "--technique", "none", "--out", text(out.path())];
    ok(&[&["compare", "ink"][..], &few].concat());
    let rows = results(out.path()).rows;
    let (names, records) = columns(out.path());
    assert_eq!((rows.len(), records.len(), rows[0].colors.len()), (1, 1, 3));
    for error in &rows[0].colors {
        for (points, of) in [("space", error.space), ("surface", error.surface)] {
            let of = of.expect("ink is over a ground");
            let column = |what: &str| {
                let name = format!("{points}_{}_{what}", error.color);
                let place = names.iter().position(|n| n == name).unwrap_or_else(|| panic!("no {name}"));
                records[0][place].parse::<f64>().expect("a number")
            };
            assert_eq!(
                ["mean_abs", "bias", "max"].map(column),
                [of.mean_abs, of.bias.unwrap_or(9.0), of.max.unwrap_or(9.0)]
            );
        }
    }
    // Without shadows, the error of a color is the fraction of its light that casters absorb.
    let space: Vec<f64> = rows[0].colors.iter().filter_map(|error| Some(error.space?.mean_abs)).collect();
    assert!(space[0] > space[1] && space[1] > space[2] && space[2] > 0.0, "{space:?}");
    let page = std::fs::read_to_string(out.path().join("report.html")).expect("a page");
    assert!(page.contains("In space, by color") && page.contains("On surfaces, by color"));

    let out = folder();
    let few = ["--quick", "--frames", "1", "--picture", "32x18", "--technique", "none", "--out", text(out.path())];
    ok(&[&["compare", "plume_8k"][..], &few].concat());
    let (names, _) = columns(out.path());
    assert!(results(out.path()).rows[0].colors.is_empty() && !names.iter().any(|name| name.contains("_red_")));
    assert!(!std::fs::read_to_string(out.path().join("results.json")).expect("a JSON").contains("\"colors\""));
}
