//! Plots of made-up results.

use crate::report::{refused, results, row};
use gobo::bench::{Results, Row, SeenError, Timing, Unshadowed};
use gobo::report::{page, plots};

fn build_plot(results: &Results) -> Option<String> {
    plot(results, "time-vs-error.svg")
}

/// Returns the plot with that file name.
fn plot(results: &Results, file: &str) -> Option<String> {
    plots(results).into_iter().find(|(name, _)| *name == file).map(|(_, svg)| svg)
}

/// Whether all coordinates in attributes such as `x="12"` are within the picture.
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
            // Half an em per character on average, in common fonts.
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
    assert_eq!(plots(&results(vec![])), []);
    assert_eq!(plots(&results(vec![refused("plume", "no")])), []);
    let svg = build_plot(&results(vec![row("plume", "avsm", 8, 2.0, 0.01)])).expect("one row is enough");
    for part in ["plume", "llvmpipe", "avsm two-pass linear", "build time, ms", "8 nodes"] {
        assert!(svg.contains(part), "{part}");
    }
    assert!(stays_inside(&svg) && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

#[test]
fn plot_of_zero_error_says_where_zero_stands() {
    let rows = vec![row("plume", "avsm", 8, 2.0, 0.01), row("plume", "avsm", 16, 4.0, 0.0)];
    let svg = build_plot(&results(rows)).expect("measured");
    // Half of 0.01, the smallest error above 0, lies between 0.001 and 0.01.
    assert!(svg.contains("0.001 or less, zero included"), "{svg}");
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
    let svg = build_plot(&results).expect("measured");
    assert!(stays_inside(&svg), "{svg}");
    assert!(svg.contains("&lt;called&gt; &amp; named") && !svg.contains("<called>"), "{svg}");
    assert_eq!(Some(svg), build_plot(&results));
}

#[test]
fn each_plot_has_its_own_times_errors_and_front() {
    // Build ms, map error, frame ms, space error: a technique that builds in no time leaves the work to its look-ups.
    let measured = [
        ("uncompressed", 1.0, 0.0001, 600.0, 0.005),
        ("avsm", 10.0, 0.01, 20.0, 0.01),
        ("psm", 12.0, 0.02, 10.0, 0.02),
        ("translucency-map", 14.0, 0.03, 30.0, 0.008),
        ("slow", 40.0, 0.04, 40.0, 0.04),
    ];
    let rows = measured.map(|(technique, build, map, frame, space)| {
        let mut row = row("plume", technique, 8, build, map);
        (row.frame_ns, row.limit_mean_abs) = (Some(frame * 1e6), Some(5e-5));
        if let Some(points) = row.error.as_mut().and_then(|error| error.space.as_mut()) {
            points.mean_abs = space;
        }
        row
    });
    let mut results = results(rows.into());
    let drawn = plots(&results);
    assert_eq!(drawn.iter().map(|(file, _)| *file).collect::<Vec<_>>(), ["time-vs-error.svg", "frame-vs-error.svg"]);
    let (build, frame) = (&drawn[0].1, &drawn[1].1);
    for (svg, own, others) in [
        (build, ["Build time against map error", "build time, ms", "(map points)"], frame),
        (frame, ["Time of a frame against space error", "time of a frame, ms", "(in space)"], build),
    ] {
        assert!(own.iter().all(|words| svg.contains(words) && !others.contains(words)), "{own:?}");
        assert!(stays_inside(svg) && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
    let label = |svg: &str| svg.split("aria-label=\"").nth(1).and_then(|rest| rest.split('"').next()).map(String::from);
    assert!(label(build).is_some() && label(frame).is_some() && label(build) != label(frame));
    // The limit applies to map errors.
    assert!(build.contains("limit of that many nodes") && !frame.contains("limit of that many nodes"));
    // Points on the front have rings of this size: uncompressed beats all others by its build alone, but per frame only `slow` is beaten.
    let rings = |svg: &str| svg.matches("r=\"9\"").count();
    assert_eq!((rings(build), rings(frame)), (1, 4));
    let dir = tempfile::tempdir().expect("a folder");
    let marks = |html: &str, front: &str| html.matches(&format!("\"front {front}\" role=\"img\"")).count();
    let html = page(&results, dir.path()).expect("a page");
    assert_eq!((marks(&html, "front1"), marks(&html, "front2")), (1, 4));
    assert!(html.contains(label(build).expect("a label").as_str()) && html.contains(&label(frame).expect("a label")));

    // Files from before frame times were measured must have neither this plot nor its front.
    results.rows.iter_mut().for_each(|row| row.frame_ns = None);
    assert_eq!(plots(&results), [("time-vs-error.svg", build.clone())]);
    let html = page(&results, dir.path()).expect("a page");
    assert_eq!((marks(&html, "front1"), marks(&html, "front2")), (1, 0));

    // Cost against seen error must be plotted if rows have both. Costs below the noise of the unshadowed picture are raised to it.
    for (row, (cost, seen)) in
        results.rows.iter_mut().zip([(-9.0, 0.1), (1.0, 0.2), (2.0, 0.05), (3.0, 0.01), (4.0, 0.02)])
    {
        let draw_ns = Some(Timing { median: 50e6, p05: 49.8e6, p95: 50.2e6, samples: 9 });
        row.unshadowed = Some(Unshadowed { draw_ns, seen: Some(0.5), flip_mean: None });
        row.cost_ns = Some(1e6 * cost);
        row.error.as_mut().expect("an error").seen = Some(SeenError { mean: seen, ..SeenError::default() });
    }
    let drawn = plots(&results);
    assert_eq!(drawn[0].0, "cost-vs-seen.svg");
    assert_eq!(rings(&drawn[0].1), 3);
    let html = page(&results, dir.path()).expect("a page");
    assert_eq!(marks(&html, "front0"), 3);
    assert!(!html.contains("frame time and space error"));
}

/// There must be a plot by surface error if there are surfaces, unless all rows have the same error or none at all.
#[test]
fn a_plot_is_there_to_choose_by() {
    use crate::report::opaque;
    let with_errors = |errors: [f64; 2]| {
        let mut rows = [opaque("room", "psm"), opaque("room", "avsm")];
        for (row, mean_abs) in rows.iter_mut().zip(errors) {
            let error = row.error.as_mut().expect("measured");
            for points in [&mut error.map, &mut error.space, &mut error.surface] {
                points.as_mut().expect("asked").mean_abs = mean_abs;
            }
        }
        results(rows.into())
    };
    let names = |results: &Results| plots(results).iter().map(|(name, _)| *name).collect::<Vec<_>>();
    let all = ["time-vs-error.svg", "frame-vs-error.svg", "frame-vs-surface.svg"];
    assert_eq!(names(&with_errors([0.01, 0.02])), all);
    assert_eq!(names(&with_errors([0.0, 0.02])), all, "one of them is exact");
    assert_eq!(names(&with_errors([0.0, 0.0])), [] as [&str; 0]);
    assert_eq!(names(&with_errors([0.25, 0.25])), [] as [&str; 0], "smoke that neither of them sees");
    let dir = tempfile::tempdir().expect("a folder");
    let html = page(&with_errors([0.25, 0.25]), dir.path()).expect("a page");
    assert!(html.contains("No plot") && !html.contains("Pareto front of"), "no front either");
}
