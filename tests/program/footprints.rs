//! `compare --footprints`: printed and written values must be those measured, and consistent with the errors at points.

use crate::support::log;
use crate::{folder, ok, results, runs, text};
use gobo::bench::{FOOTPRINTS, Status};

#[test]
fn footprints_are_beside_errors_of_points() {
    if crate::support::is_costly("footprints_are_beside_errors_of_points") {
        return;
    }
    log("exercised", "footprints_are_beside_errors_of_points", &runs("none", "lit").0);
    let out = folder();
    let specs = ["--technique", "none", "--technique", "uncompressed:size=64"];
    let arguments = ["compare", "plume_8k", "--quick", "--frames", "1", "--picture", "32x18", "--footprints"];
    let printed = ok(&[&arguments[..], &specs, &["--out", text(out.path())]].concat());
    // A device without stores from fragments refuses lists.
    let rows = results(out.path()).rows;
    assert!(rows.len() == 2 && rows[0].status == Status::Ok, "{rows:?}");
    let csv = std::fs::read_to_string(out.path().join("results.csv")).expect("a CSV");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let columns = reader.headers().expect("columns").clone();
    let records: Vec<csv::StringRecord> = reader.records().map(|record| record.expect("a record")).collect();
    for (row, record) in rows.iter().zip(&records).filter(|(row, _)| row.status == Status::Ok) {
        let space = row.error.as_ref().and_then(|error| error.space).expect("points in space");
        assert_eq!(row.footprints.iter().map(|error| error.texels).collect::<Vec<_>>(), FOOTPRINTS);
        for error in &row.footprints {
            let what = format!("{}: {error:?}", row.technique);
            // The mean over places must not depend on the squares' size; errors at points are averaged over four times as many points.
            let bias = space.bias.expect("of each point");
            assert!((error.bias - bias).abs() < 0.01, "{what}, and {bias} of points");
            let column = |name: &str| {
                let name = format!("footprint_{}_{name}", error.texels);
                let place = columns.iter().position(|column| column == name).unwrap_or_else(|| panic!("no {name}"));
                record[place].parse::<f64>().expect("a number")
            };
            assert_eq!(["rms", "noise", "bias"].map(column), [error.rms, error.noise, error.bias]);
        }
        // The smallest squares are nearly points.
        let smallest = row.footprints[0];
        let rms = space.rms.expect("of each point");
        assert!((smallest.rms - rms).abs() < 0.05 * rms + smallest.noise, "{}: {smallest:?}, {rms}", row.technique);
        let header = printed.find("1/4 ").expect("a table of sizes");
        let line =
            printed[header..].lines().find(|line| line.trim_start().starts_with(&row.technique)).expect("its row");
        let numbers: Vec<f64> = line.split_whitespace().rev().take(4).map(|cell| cell.parse().expect(line)).collect();
        for (number, error) in numbers.iter().rev().zip(&row.footprints) {
            assert!((number - error.rms).abs() < 0.01 * error.rms, "{line}: {error:?}");
        }
    }
    // This technique absorbs no light, so wider squares average out more of the contrast.
    assert!(rows[0].footprints.windows(2).all(|pair| pair[1].rms < pair[0].rms + pair[1].noise), "{:?}", rows[0]);
    // The plot must have a line per row, with a dot for each size and one in the legend.
    let svg = std::fs::read_to_string(out.path().join("footprints.svg")).expect("a plot");
    let asked = rows.iter().filter(|row| !row.footprints.is_empty());
    assert_eq!(svg.matches("<circle").count(), asked.clone().count() * (FOOTPRINTS.len() + 1));
    assert!(asked.clone().all(|row| svg.contains(&row.technique)), "{svg}");
    // The axis of errors, on the left, must be logarithmic.
    let labels: Vec<(f64, f64)> = svg.split("<text ").filter_map(left_label).collect();
    assert!(labels.len() >= 3, "{labels:?}");
    let (low, high) = (labels[0], labels[labels.len() - 1]);
    for (y, value) in &labels {
        let expected = low.0 + (high.0 - low.0) * (value / low.1).ln() / (high.1 / low.1).ln();
        assert!((y - expected).abs() <= 1.5, "{value} at {y}, not {expected}");
    }
    let errors = || asked.clone().flat_map(|row| &row.footprints).map(|error| error.rms);
    let [least, most] = [errors().fold(1.0, f64::min), errors().fold(0.0, f64::max)];
    let [below, above] =
        [labels.iter().map(|l| l.1).fold(1.0, f64::min), labels.iter().map(|l| l.1).fold(0.0, f64::max)];
    assert!(below < 2.0 * least && above > most / 2.0, "{below} to {above} of {least} to {most}");
}

/// Returns the height and the value of a number that ends at the left axis.
fn left_label(element: &str) -> Option<(f64, f64)> {
    let (attributes, rest) = element.split_once('>')?;
    let words = rest.split('<').next()?.trim().parse().ok()?;
    let (_, y) = attributes.split_once(" y=\"").or_else(|| attributes.split_once("y=\""))?;
    let y = y.split('"').next()?.parse().ok()?;
    attributes.contains("text-anchor=\"end\"").then_some((y, words))
}
