//! Plots of made-up results.

use crate::{refused, results, row};
use gobo::measure::Row;
use gobo::report::time_versus_error;

/// Numbers of attributes such as `x="12"`, and whether each is within the picture.
fn stays_inside(svg: &str) -> bool {
    let size = |name: &str| -> f64 {
        let start = svg.find(&format!(" {name}=\"")).expect(name) + name.len() + 3;
        svg[start..].split('"').next().and_then(|text| text.parse().ok()).expect("a number")
    };
    let (width, height) = (size("width"), size("height"));
    svg.lines().filter(|line| line.starts_with("<text")).count() > 0
        && svg.split("<text ").skip(1).all(|element| {
            let attribute = |name: &str| {
                let start = element.find(&format!("{name}=\"")).expect(name) + name.len() + 2;
                element[start..].split('"').next().expect("a value")
            };
            let number = |name: &str| attribute(name).parse::<f64>().expect("a number");
            let content = element.split('>').nth(1).and_then(|rest| rest.split('<').next()).unwrap_or("").trim();
            // Half an em a character on average, in common fonts.
            let advance = content.chars().count() as f64 * number("font-size") * 0.5;
            let (mut left, mut right) = match attribute("text-anchor") {
                "start" => (number("x"), number("x") + advance),
                "middle" => (number("x") - advance / 2.0, number("x") + advance / 2.0),
                _ => (number("x") - advance, number("x")),
            };
            if element.contains("rotate(") {
                (left, right) = (number("x"), number("x"));
            }
            left >= 0.0 && right <= width && number("y") >= 0.0 && number("y") <= height
        })
}

#[test]
fn plot_of_one_row_and_of_none() {
    assert_eq!(time_versus_error(&results(vec![])), None);
    assert_eq!(time_versus_error(&results(vec![refused("plume", "no")])), None);
    let svg = time_versus_error(&results(vec![row("plume", "avsm", 8, 2.0, 0.01)])).expect("one row is enough");
    for part in ["plume", "llvmpipe", "avsm two-pass linear", "build time, ms", "8 nodes"] {
        assert!(svg.contains(part), "{part}");
    }
    assert!(stays_inside(&svg) && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn plot_of_zero_error_says_where_zero_stands() {
    let mut rows = vec![row("plume", "avsm", 8, 2.0, 0.01), row("plume", "avsm", 16, 4.0, 0.0)];
    rows.push(row("void", "avsm", 4, 0.0, 0.0));
    let svg = time_versus_error(&results(rows)).expect("measured");
    // Half of 0.01 lies between 0.001 and 0.01; with zeros alone it is the rounding of 32-bit visibility.
    assert!(svg.contains("0.001 or less, zero included") && svg.contains("1e-7 or less, zero included"), "{svg}");
    assert!(stays_inside(&svg) && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn plot_of_thirty_rows_with_long_names_stays_inside_and_is_the_same_again() {
    let name = "a-technique-with-a-name-that-does-not-know-when-to-stop";
    let rows: Vec<Row> = (0..30u32)
        .map(|i| {
            let scene = "a scene <called> & named at a length that no panel has room for, not even one as wide as this";
            let step = f64::from(i);
            row(scene, &format!("{name}-{}", i / 2), 4 << (i % 2), 0.1 + step * step / 9.0, 0.3 / (1.0 + step))
        })
        .collect();
    let mut results = results(rows);
    results.device.name = "A GPU of the Grand Unified Family ".repeat(12);
    let svg = time_versus_error(&results).expect("measured");
    assert!(stays_inside(&svg), "{svg}");
    assert!(svg.contains("&lt;called&gt; &amp; named") && !svg.contains("<called>"), "{svg}");
    assert_eq!(Some(svg), time_versus_error(&results));
}
