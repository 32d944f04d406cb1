//! Tables and the page for made-up results.

use crate::report::{opaque, records, refused, results, row};
use gobo::bench::{PassTiming, Results, StageRates, Submission};
use gobo::report::{Store, page, passes, plots, submission_table, table};
use std::collections::{BTreeMap, BTreeSet};

/// A technique that paints its picture has no points: it must have no dot and no place on the front, but dashes.
#[test]
fn what_a_row_does_not_have_is_absent() {
    let mut painted = row("plume", "half-angle", 8, 0.5, 0.0);
    painted.limit_mean_abs = None;
    (painted.bytes_resident, painted.bytes_transient, painted.host_ns) = (None, None, None);
    let error = painted.error.as_mut().expect("measured");
    (error.map, error.space) = (None, None);
    assert_eq!(plots(&results(vec![painted.clone()])), []);

    let alone = results(vec![row("plume", "avsm", 8, 2.0, 0.01)]);
    let mut both = results(vec![row("plume", "avsm", 8, 2.0, 0.01), painted]);
    both.device.copy_bytes_per_second = Some(1e12);
    assert_eq!(plots(&both), plots(&alone));
    let table = table(&both);
    let line = table.lines().find(|line| line.contains("half-angle")).expect("the row");
    // Cells: build, host, look-ups, draw, frame; two of memory, six at map points, one in space; three of the image.
    let cells = ["0.500 [0.450–0.600]", "–", "3.00", "5.00", "1.50"]
        .into_iter()
        .chain(["–"; 9])
        .chain(["0.250", "0.125", "0.0625"]);
    let shown = line.split("  ").map(str::trim).filter(|c| !c.is_empty()).skip(2);
    assert_eq!(shown.collect::<Vec<_>>(), cells.collect::<Vec<_>>());
    let floor = passes(&both).lines().nth(2).map(|line| line.trim_end().ends_with('–'));
    assert_eq!(floor, Some(true), "no bytes, no floor");

    let dir = tempfile::tempdir().expect("a folder");
    let html = page(&both, dir.path()).expect("a page");
    for front in ["front1", "front2"] {
        let marks = html.matches(&format!("<span class=\"front {front}\" role=\"img\"")).count();
        assert_eq!(marks, 1, "only the row with an error is on {front}");
    }
    assert_eq!(html.matches("<th scope=\"row\">mean abs</th>").count(), 1, "no table of nothing");
    for name in ["host_median_ns", "bytes_resident", "map_points", "map_mean_abs", "space_max", "limit_mean_abs"] {
        assert_eq!(records(&both)[1][name], "", "{name}");
    }
}

/// The times of a marked row, and no other cells, must have a mark with the reason; the CSV must contain the reason, and a submission's
/// table the mark.
#[test]
fn marked_times_are_shown_with_their_reason() {
    let mut rows = vec![row("plume", "avsm", 8, 2.0, 0.01), row("plume", "psm", 8, 2.0, 0.02)];
    rows[1].marks = vec!["81 % raster work, on 4 of 132 processors".into()];
    let mut made = results(rows);
    made.device.stages =
        Some(StageRates { fragment_slowdown: 32.9, fragment_processors: Some(4), processors: Some(132) });
    let dir = tempfile::tempdir().expect("a folder");
    let html = page(&made, dir.path()).expect("a page");
    let sentence = "fragments run on 4 of 132 processors, 33 times slower";
    assert_eq!(html.matches(&format!(" · {sentence} · gobo ")).count(), 1, "beside the device");
    assert!(html.contains("1 row is marked †: more than a quarter of its time is raster work"), "{html}");
    let mark = "<span class=\"warning\" title=\"81 % raster work, on 4 of 132 processors\">†</span>";
    let lines: Vec<&str> = html.lines().filter(|line| line.contains(mark)).collect();
    // Marked cells: build, host, look-ups, draw, frame.
    assert!(lines.len() == 1 && lines[0].matches(mark).count() == 5, "{lines:#?}");
    let records = records(&made);
    assert_eq!([&records[0]["marks"], &records[1]["marks"]], ["", "81 % raster work, on 4 of 132 processors"]);
    let submission = submission_table(&Submission { results: made, ..Submission::default() });
    assert!(submission.lines().next().is_some_and(|line| line.ends_with(sentence)), "{submission}");
    let marked = |technique: &str| {
        let line = submission.lines().find(|line| line.contains(technique)).expect("the row");
        line.matches('†').count()
    };
    // Marked cells: build, look-ups, draw. One more mark is in the note.
    assert_eq!((marked("| avsm"), marked("| psm"), submission.matches('†').count()), (0, 3, 4), "{submission}");
}

#[test]
fn columns_without_any_value_are_not_there() {
    let fixed = table(&results(vec![row("plume", "avsm", 8, 2.0, 0.01), refused("plume", "no")]));
    let moving = table(&results(vec![row("plume", "avsm", 8, 2.0, 0.01), opaque("room", "psm")]));
    for heading in ["flicker", "surface |err|", "surface leaks/false", "space leaks/false"] {
        assert!(!fixed.contains(heading) && moving.contains(heading), "{heading}");
    }
    let line = moving.lines().find(|line| line.contains("psm")).expect("the row");
    for cell in ["7.25", "0.0100 ±0.0003", "201 / 202", "0.0300", "301 / 302", "0.0625"] {
        assert!(line.contains(&format!("  {cell}")), "{cell} is not in {line}");
    }

    let dir = tempfile::tempdir().expect("a folder");
    let html = |results: &Results| {
        // Searches the body only, since the styles before it contain words of their own.
        let page = page(results, dir.path()).expect("a page");
        page.split("<body").nth(1)?.split("What the numbers").next().map(String::from)
    };
    let fixed = html(&results(vec![row("plume", "avsm", 8, 2.0, 0.01)])).expect("a table");
    let moving = html(&results(vec![opaque("room", "psm")])).expect("a table");
    for part in ["flicker", "On surfaces", "leaks", "within"] {
        assert!(!fixed.contains(part) && moving.contains(part), "{part}");
    }
    for (name, values) in [
        ("leaks", ["101", "201", "301"]),
        ("false shadows", ["102", "202", "302"]),
        ("within: points", ["103", "203", "303"]),
        ("within: share", ["10 %", "10 %", "10 %"]),
        ("within: mean abs", ["0.0500", "0.100", "0.150"]),
        ("within: leaks", ["5", "6", "7"]),
        ("within: false shadows", ["6", "7", "8"]),
        // 103 of 1,000 points are within: (1000 × 0.01 − 103 × 0.05) / 897, and so on.
        ("beyond: mean abs", ["0.00541", "0.0110", "0.0165"]),
        ("beyond: leaks", ["96", "195", "294"]),
        ("beyond: false shadows", ["96", "195", "294"]),
    ] {
        let cells: String = values.iter().map(|value| format!("<td>{value}</td>")).collect();
        assert!(moving.contains(&format!("<th scope=\"row\">{name}</th>{cells}")), "{name}");
    }
    // Nothing was built: the only cell must contain the reason.
    let html = page(&results(vec![refused("plume", "no")]), dir.path()).expect("a page");
    assert!(html.contains("colspan=\"1\">refused: no</td>"));
}

/// Compares the style sheet's classes and colors with the classes of each pass's bars.
#[test]
fn each_pass_has_a_color_of_its_own_in_all_scenes() {
    let pass =
        |i: usize| PassTiming { name: format!("pass {i};"), median_ns: 1e6, p05_ns: 1e6, p95_ns: 1e6, raster: None };
    let mut rows = vec![row("a", "one", 8, 1.0, 0.1), row("a", "two", 8, 1.0, 0.1), row("b", "two", 8, 1.0, 0.1)];
    rows[0].passes = (0..25).map(pass).collect();
    rows[1].passes = (20..40).map(pass).collect();
    // The third row has some of the passes, in another order.
    rows[2].passes = (3..38).rev().map(pass).collect();
    let dir = tempfile::tempdir().expect("a folder");
    let html = page(&results(rows), dir.path()).expect("a page");
    let colors: BTreeMap<&str, &str> = html
        .lines()
        .filter_map(|line| line.strip_prefix(".c")?.split_once(" { background: #"))
        .map(|(class, rest)| (class, &rest[..6]))
        .collect();
    assert_eq!(colors.values().collect::<BTreeSet<_>>().len(), 40, "{colors:?}");
    let mut classes: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for bar in html.split("<i class=\"c").skip(1) {
        let (class, rest) = bar.split_once('"').expect("a class");
        let name = rest.split("title=\"").nth(1).and_then(|title| title.split(';').next()).expect("a title");
        classes.entry(name).or_default().push(class);
    }
    assert_eq!((classes.len(), classes.values().map(Vec::len).sum::<usize>()), (40, 25 + 20 + 35));
    assert!(
        classes.values().all(|of| of.iter().all(|class| *class == of[0] && colors.contains_key(class))),
        "{classes:?}"
    );
    assert_eq!(classes.values().map(|of| of[0]).collect::<BTreeSet<_>>().len(), 40);
}

#[test]
fn page_escapes_what_it_shows() {
    let dir = tempfile::tempdir().expect("a folder");
    let attack = "<script>alert('x')</script>\" onload=\"x";
    let mut rows = vec![row(attack, attack, 8, 1.0, 0.1), refused(attack, attack)];
    rows[0].reason = attack.into();
    rows[0].passes[0].name = attack.into();
    rows[0].counters = [(attack.to_owned(), 1)].into();
    rows[0].picture = Some(attack.into());
    let mut results = results(rows);
    results.device.features = [(attack.to_owned(), serde_json::Value::String(attack.into()))].into();
    results.command = attack.into();
    let html = page(&results, dir.path()).expect("a page");
    assert_eq!(html.matches("<script>").count(), 1, "only the page's own");
    assert!(html.contains("&lt;script&gt;alert("));
    assert!(!html.contains("\" onload=\""));
}

#[test]
fn page_embeds_pictures_and_notes_missing_ones() {
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("opened");
    store.write_picture("plume-reference.png", 1, 1, &[1, 2, 3]).expect("written");
    store.write_picture("plume-0.png", 1, 1, &[4, 5, 6]).expect("written");
    store.write_text("notes.png", "no PNG").expect("written");
    let mut measured = row("plume", "avsm", 8, 1.0, 0.1);
    measured.picture = Some("plume-0.png".into());
    measured.difference = Some("gone.png".into());
    let mut other = row("plume", "psm", 8, 1.0, 0.1);
    other.picture = Some("notes.png".into());
    other.difference = Some("../../etc/passwd".into());
    let results = results(vec![measured, other, refused("plume", "needs shaderFloat64")]);
    let html = page(&results, dir.path()).expect("a page");
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 2, "the reference and one picture");
    for note in ["gone.png: ", "notes.png is not a PNG", "passwd is not in the output folder", "needs shaderFloat64"] {
        assert!(html.contains(note), "{note}");
    }
    // The XML namespace is a name, not an address that is fetched.
    assert!(!html.replace("http://www.w3.org/2000/svg", "").contains("://"), "no address at all");
    assert!(!html.split("<img ").skip(1).any(|image| !image.split('>').next().is_some_and(|i| i.contains("alt="))));
    assert_eq!(page(&results, dir.path()).expect("again"), html, "same input, same bytes");
}

#[test]
fn page_and_table_of_an_interrupted_run() {
    let dir = tempfile::tempdir().expect("a folder");
    let empty = results(vec![]);
    assert!(page(&empty, dir.path()).expect("a page").contains("No plot"));
    assert!(table(&empty).contains("nothing measured"));
}

#[test]
fn passes_stand_in_columns_with_the_whole_build() {
    let mut rows = vec![row("a", "psm", 4, 3.5, 0.01), row("a", "psm", 8, 2.0, 0.01), refused("a", "no geometry")];
    let pass = |name: &str, ms: f64| PassTiming {
        name: name.into(),
        median_ns: ms * 1e6,
        p05_ns: 0.0,
        p95_ns: 0.0,
        raster: None,
    };
    rows[0].passes = vec![pass("maps.opaque", 0.125), pass("psm.clear", 0.25), pass("psm.propagate", 1.75)];
    rows[1].passes = vec![pass("psm.fused", 1.5)];
    rows[0].draw_passes.clear();
    rows[1].draw_passes = vec![pass("shading.gbuffer", 0.5), pass("many_lights.shade", 0.125)];
    let text = passes(&results(rows));
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines.len(), 5, "a heading and the measured rows, and another where drawing has passes: {text}");
    assert_eq!(lines[0][..4], ["a:", "passes,", "ms", "path"]);
    assert_eq!(lines[0][4..], ["maps.opaque", "psm.clear", "psm.propagate", "psm.fused", "shared", "own", "total"]);
    assert_eq!(lines[1][2..], ["0.125", "0.250", "1.75", "–", "0.125", "2.00", "3.50"]);
    assert_eq!(lines[2][2..], ["–", "–", "–", "1.50", "0", "1.50", "2.00"]);
    assert_eq!(lines[3], ["a:", "drawing,", "ms", "path", "shading.gbuffer", "many_lights.shade", "total"]);
    assert_eq!(lines[4][2..], ["0.500", "0.125", "5.00"]);
}
