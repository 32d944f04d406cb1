//! Results on their way to a reader: the store, the plot and the page, through the public API.

use gobo::measure::{DeviceFacts, ImageError, PassTiming, PointError, Results, Row, RowError, SCHEMA, Status, Timing};
use gobo::report::{Store, page, passes, table, time_versus_error};

fn row(scene: &str, technique: &str, nodes: u32, milliseconds: f64, error: f64) -> Row {
    let ns = milliseconds * 1e6;
    let point = PointError {
        points: Some(640),
        mean_abs: error,
        bias: -error / 2.0,
        rms: error * 2.0,
        p99: error * 4.0,
        max: error * 8.0,
        ..PointError::default()
    };
    let image = ImageError { rmse: 0.25, flip_mean: 0.125 };
    Row {
        scene: scene.into(),
        technique: technique.into(),
        variant: [("nodes", nodes.to_string()), ("curve", "linear".into())].map(|(k, v)| (k.to_owned(), v)).into(),
        path: "two-pass".into(),
        status: Status::Ok,
        reason: String::new(),
        frame_ns: Some(ns * 3.0),
        standard_error: Some(error / 50.0),
        flicker_rms: None,
        host_ns: Some(Timing { median: ns * 1.5, p05: ns, p95: ns * 2.0, samples: 30 }),
        build_ns: Some(Timing { median: ns, p05: ns * 0.9, p95: ns * 1.2, samples: 30 }),
        lookup_ns_per_million: Some(Timing { median: 3e6, p05: 2e6, p95: 4e6, samples: 30 }),
        draw_ns: Some(Timing { median: 5e6, p05: 4e6, p95: 7e6, samples: 12 }),
        passes: vec![PassTiming { name: format!("{technique}.resolve"), median_ns: ns, p05_ns: ns, p95_ns: ns }],
        bytes_resident: Some(1 << 20),
        bytes_transient: Some(1 << 10),
        counters: [("fragments".to_owned(), 12)].into(),
        error: Some(RowError { map: Some(point), space: Some(point), surface: None, image: Some(image) }),
        limit_mean_abs: Some(error / 2.0),
        picture: None,
        difference: None,
    }
}

fn refused(scene: &str, reason: &str) -> Row {
    let measured = row(scene, "avsm", 8, 1.0, 0.01);
    Row {
        status: Status::Refused,
        reason: reason.into(),
        host_ns: None,
        frame_ns: None,
        standard_error: None,
        flicker_rms: None,
        build_ns: None,
        lookup_ns_per_million: None,
        draw_ns: None,
        passes: vec![],
        bytes_resident: None,
        bytes_transient: None,
        error: None,
        limit_mean_abs: None,
        ..measured
    }
}

fn results(rows: Vec<Row>) -> Results {
    Results {
        schema: SCHEMA,
        gobo: "0.1.0".into(),
        command: "gobo compare".into(),
        device: DeviceFacts { name: "llvmpipe".into(), driver: "Mesa".into(), ..DeviceFacts::default() },
        rows,
    }
}

/// Names in the folder, sorted.
fn names(dir: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(dir).expect("the folder is there");
    let mut names: Vec<_> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn results_come_back_as_they_were() {
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(&dir.path().join("deep/er")).expect("created with those above it");
    let mut written =
        results(vec![row("plume", "avsm", 8, 1.0 / 3.0, 0.1), refused("plume", "needs, \"this\"\nthing")]);
    written.rows[1].counters = [("overflowed".to_owned(), 7)].into();
    store.write(&written).expect("written");
    store.write(&written).expect("written over");
    assert_eq!(names(store.dir()), ["results.csv", "results.json"], "nothing temporary is left");

    assert_eq!(Results::read(&store.dir().join("results.json")).expect("valid"), written);

    let mut csv = csv::Reader::from_path(store.dir().join("results.csv")).expect("there");
    let names = csv.headers().expect("a heading").clone();
    let records: Vec<_> = csv.records().map(|record| record.expect("as long as the heading")).collect();
    assert_eq!(records.len(), 2);
    let at = |line: usize, name: &str| &records[line][names.iter().position(|n| n == name).expect(name)];
    assert_eq!(at(0, "draw_p95_ns").parse::<f64>().ok(), written.rows[0].draw_ns.map(|timing| timing.p95));
    assert_eq!(at(0, "draw_samples"), "12");
    assert_eq!(at(0, "build_median_ns").parse::<f64>().ok(), written.rows[0].build_ns.map(|timing| timing.median));
    assert_eq!(at(0, "host_median_ns").parse::<f64>().ok(), written.rows[0].host_ns.map(|timing| timing.median));
    assert_eq!([at(0, "samples"), at(0, "map_bias"), at(0, "space_max")], ["30", "-0.05", "0.8"]);
    assert_eq!([at(0, "map_points"), at(0, "bytes_transient"), at(1, "bytes_transient")], ["640", "1024", ""]);
    assert_eq!([at(0, "counter_fragments"), at(0, "counter_overflowed")], ["12", ""]);
    assert_eq!([at(1, "counter_fragments"), at(1, "counter_overflowed")], ["", "7"]);
    assert_eq!([at(1, "status"), at(1, "build_median_ns"), at(1, "map_max")], ["refused", "", ""]);
    assert_eq!([at(1, "reason"), at(1, "variant")], ["needs, \"this\"\nthing", "avsm:curve=linear,nodes=8"]);
}

/// Device, times and errors of schema 1 stay; what it did not have is absent. The file is the first edition's.
#[test]
fn files_of_schema_1_are_read() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/report/schema-1.json");
    let read = Results::read(&path).expect("in the repository");
    assert_eq!((read.schema, read.rows.len(), read.device.name.as_str()), (SCHEMA, 2, "NVIDIA H200"));
    let row = &read.rows[0];
    assert_eq!((row.scene.as_str(), row.technique.as_str(), row.path.as_str()), ("plume_8k", "avsm", "two-pass"));
    assert_eq!((row.host_ns, row.build_ns.map(|t| t.median)), (None, Some(2_034_560.0)));
    assert_eq!((row.bytes_resident, row.bytes_transient), (Some(2_101_252), Some(44_028_556)));
    let map = row.error.as_ref().and_then(|error| error.map).expect("measured");
    assert!(map.points.is_none() && (map.mean_abs - 0.013_997_554_370_264_169).abs() < 1e-15, "{map:?}");

    // Zero bytes of what was never built are no bytes at all.
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("results.json");
    let mut old = results(vec![refused("plume", "no")]);
    (old.schema, old.rows[0].bytes_resident) = (1, Some(0));
    std::fs::write(&path, serde_json::to_vec(&old).expect("JSON")).expect("written");
    assert_eq!(Results::read(&path).expect("read"), results(vec![refused("plume", "no")]));
}

#[test]
fn files_that_cannot_be_read_are_one_line() {
    let dir = tempfile::tempdir().expect("a folder");
    let told = |name: &str, json: Option<&str>| {
        let path = dir.path().join(name);
        if let Some(json) = json {
            std::fs::write(&path, json).expect("written");
        }
        let error = Results::read(&path).expect_err(name);
        assert!(matches!(error, gobo::Error::Input { .. }), "{error:?}");
        let told = error.to_string();
        assert!(told.starts_with(&*path.to_string_lossy()) && told.lines().count() == 1, "{told}");
        assert!(told.contains("gobo compare"), "a way out: {told}");
        told
    };
    let whole = serde_json::to_string_pretty(&results(vec![row("plume", "avsm", 8, 1.0, 0.1)])).expect("JSON");
    told("missing.json", None);
    assert!(told("half.json", Some(&whole[..whole.len() / 2])).contains("EOF"));
    assert!(told("empty.json", Some("")).contains("EOF"));
    assert!(told("other.json", Some("{}")).contains("`schema`"));
    // What else is in it may be anything.
    assert!(told("newer.json", Some(r#"{ "schema": 3, "rows": 7 }"#)).contains("schema 3"));
    assert!(told("older.json", Some(r#"{ "schema": 0 }"#)).contains("schema 0"));
}

#[cfg(unix)]
#[test]
fn results_are_as_readable_as_any_file() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("opened");
    store.write_text("report.html", "x").expect("written");
    std::fs::write(dir.path().join("plain"), "x").expect("written");
    let mode = |name: &str| std::fs::metadata(dir.path().join(name)).expect("there").permissions().mode();
    assert_eq!(mode("report.html"), mode("plain"));
}

#[test]
fn a_write_that_fails_changes_nothing() {
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("opened");
    store.write(&results(vec![row("plume", "avsm", 8, 1.0, 0.1)])).expect("written");
    let json = std::fs::read(dir.path().join("results.json")).expect("there");

    // The CSV cannot take its name: the JSON is whole, the folder keeps what it had, nothing temporary stays.
    std::fs::remove_file(dir.path().join("results.csv")).expect("removed");
    std::fs::create_dir(dir.path().join("results.csv")).expect("a folder in its place");
    let error = store.write(&results(vec![row("plume", "avsm", 8, 1.0, 0.1)])).expect_err("a folder is in the way");
    let told = error.to_string();
    assert!(told.contains("results.csv") && told.lines().count() == 1, "{told}");
    assert_eq!(std::fs::read(dir.path().join("results.json")).expect("there"), json);
    assert_eq!(names(dir.path()), ["results.csv", "results.json"]);

    // A name must not lead out of the folder.
    let error = store.write_text("../outside.html", "x").expect_err("outside");
    assert!(error.to_string().contains("output folder"), "{error}");

    std::fs::remove_dir_all(dir.path()).expect("removed");
    let error = store.write_text("report.html", "x").expect_err("no folder").to_string();
    assert!(error.contains("report.html") && !error.contains(".report.html."), "{error}");
}

#[test]
fn a_file_in_the_place_of_the_folder_is_one_line() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let told = Store::open(file.path()).expect_err("a file").to_string();
    assert!(told.contains(&*file.path().to_string_lossy()) && told.lines().count() == 1, "{told}");
}

#[test]
fn pictures_keep_their_pixels() {
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("opened");
    let rgb8 = [255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3, 4, 5, 6, 7, 8, 9];
    store.write_picture("a.png", 3, 2, &rgb8).expect("written");
    let read = image::open(dir.path().join("a.png")).expect("a PNG").into_rgb8();
    assert_eq!((read.width(), read.height(), read.as_raw().as_slice()), (3, 2, &rgb8[..]));
    assert!(store.write_picture("b.png", 3, 3, &rgb8).is_err(), "too few bytes");
}

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

/// A technique that paints its picture has no points: no dot, no place on the front, dashes.
#[test]
fn what_a_row_does_not_have_is_absent() {
    let mut painted = row("plume", "half-angle", 8, 0.5, 0.0);
    painted.limit_mean_abs = None;
    (painted.bytes_resident, painted.bytes_transient, painted.host_ns) = (None, None, None);
    let error = painted.error.as_mut().expect("measured");
    (error.map, error.space) = (None, None);
    assert_eq!(time_versus_error(&results(vec![painted.clone()])), None);

    let alone = results(vec![row("plume", "avsm", 8, 2.0, 0.01)]);
    let mut both = results(vec![row("plume", "avsm", 8, 2.0, 0.01), painted]);
    both.device.copy_bytes_per_second = Some(1e12);
    assert_eq!(time_versus_error(&both), time_versus_error(&alone));
    let table = table(&both);
    let line = table.lines().find(|line| line.contains("half-angle")).expect("the row");
    // Build, host, look-ups, draw, two of memory, six at map points, one in space, two of the image.
    let cells = ["0.500 [0.450–0.600]", "–", "3.00", "5.00", "–", "–", "–", "–", "–", "–", "–", "–", "–", "0.250"];
    assert_eq!(line.split("  ").map(str::trim).filter(|c| !c.is_empty()).skip(2).collect::<Vec<_>>()[..14], cells);
    let floor = passes(&both).lines().nth(2).map(|line| line.trim_end().ends_with('–'));
    assert_eq!(floor, Some(true), "no bytes, no floor");

    let dir = tempfile::tempdir().expect("a folder");
    let html = page(&both, dir.path()).expect("a page");
    let front = "<td><span class=\"front\"";
    assert_eq!(html.matches(front).count(), 1, "only the row with an error is on the front");
    assert_eq!(html.matches("<th scope=\"row\">mean abs</th>").count(), 1, "no table of nothing");
    let mut csv = csv::Reader::from_reader(std::io::Cursor::new({
        let store = Store::open(dir.path()).expect("opened");
        store.write(&both).expect("written");
        std::fs::read(dir.path().join("results.csv")).expect("there")
    }));
    let names = csv.headers().expect("a heading").clone();
    let record = csv.records().nth(1).expect("a row").expect("as long as the heading");
    for name in ["host_median_ns", "bytes_resident", "map_points", "map_mean_abs", "space_max", "limit_mean_abs"] {
        assert_eq!(names.iter().zip(&record).find(|(n, _)| *n == name), Some((name, "")));
    }
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
    // The XML namespace is a name, not an address that anything is fetched from.
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
    let pass = |name: &str, ms: f64| PassTiming { name: name.into(), median_ns: ms * 1e6, p05_ns: 0.0, p95_ns: 0.0 };
    rows[0].passes = vec![pass("psm.clear", 0.25), pass("psm.propagate", 1.75)];
    rows[1].passes = vec![pass("psm.fused", 1.5)];
    let text = passes(&results(rows));
    let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(lines.len(), 3, "a heading and the measured rows: {text}");
    assert_eq!(lines[0], ["a:", "passes,", "ms", "path", "psm.clear", "psm.propagate", "psm.fused", "total"]);
    assert_eq!(lines[1][2..], ["0.250", "1.75", "–", "3.50"]);
    assert_eq!(lines[2][2..], ["–", "–", "1.50", "2.00"]);
}
