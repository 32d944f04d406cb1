//! How results reach a reader, through the public API: the store is tested here; plots, tables and the page in the modules.

use gobo::bench::{
    DeviceFacts, FramesError, ImageError, PartError, PassTiming, PointError, Results, Row, RowError, SCHEMA, Status,
    Timing,
};
use gobo::report::{Store, page, plots, table};
use std::collections::BTreeMap;

mod page;
mod plots;

fn row(scene: &str, technique: &str, nodes: u32, milliseconds: f64, error: f64) -> Row {
    let ns = milliseconds * 1e6;
    let point = PointError {
        points: Some(640),
        mean_abs: error,
        bias: Some(-error / 2.0),
        rms: Some(error * 2.0),
        p99: Some(error * 4.0),
        max: Some(error * 8.0),
        ..PointError::default()
    };
    let image = ImageError { rmse: 0.25, flip_mean: 0.125, bounce_rmse: Some(0.0625), bounce_noise: None };
    Row {
        scene: scene.into(),
        technique: technique.into(),
        variant: [("nodes", nodes.to_string()), ("curve", "linear".into())].map(|(k, v)| (k.to_owned(), v)).into(),
        path: "two-pass".into(),
        status: Status::Ok,
        reason: String::new(),
        frame_ns: Some(ns * 3.0),
        standard_error: Some(error / 50.0),
        host_ns: Some(Timing { median: ns * 1.5, p05: ns, p95: ns * 2.0, samples: 30 }),
        build_ns: Some(Timing { median: ns, p05: ns * 0.9, p95: ns * 1.2, samples: 30 }),
        lookup_ns_per_million: Some(Timing { median: 3e6, p05: 2e6, p95: 4e6, samples: 30 }),
        draw_ns: Some(Timing { median: 5e6, p05: 4e6, p95: 7e6, samples: 12 }),
        passes: vec![PassTiming {
            name: format!("{technique}.resolve"),
            median_ns: ns,
            p05_ns: ns,
            p95_ns: ns,
            raster: None,
        }],
        draw_passes: vec![PassTiming {
            name: "shading.gbuffer".into(),
            median_ns: 7.0,
            p05_ns: 6.0,
            p95_ns: 8.0,
            raster: None,
        }],
        bytes_resident: Some(1 << 20),
        bytes_transient: Some(1 << 10),
        counters: [("fragments".to_owned(), 12)].into(),
        error: Some(RowError {
            seen: None,
            map: Some(point),
            space: Some(point),
            surface: None,
            casters: None,
            image: Some(image),
        }),
        limit_mean_abs: Some(error / 2.0),
        ..Row::default()
    }
}

fn refused(scene: &str, reason: &str) -> Row {
    let measured = row(scene, "avsm", 8, 1.0, 0.01);
    let Row { scene, technique, variant, path, .. } = measured;
    Row { scene, technique, variant, path, status: Status::Refused, reason: reason.into(), ..Row::default() }
}

fn results(rows: Vec<Row>) -> Results {
    Results {
        schema: SCHEMA,
        gobo: "0.1.0".into(),
        commit: None,
        changed: None,
        conditions: Default::default(),
        command: "gobo compare".into(),
        shard: None,
        device: DeviceFacts { name: "llvmpipe".into(), driver: "Mesa".into(), ..DeviceFacts::default() },
        rows,
        executables: Vec::new(),
    }
}

/// Builds a row of a moving world with meshes, with a distinct number in every field that not all rows have.
fn opaque(scene: &str, technique: &str) -> Row {
    let mut row = row(scene, technique, 8, 2.0, 0.01);
    let points = |base: u64| PointError {
        points: Some(10 * base),
        mean_abs: base as f64 / 1e4,
        leaks: Some(base + 1),
        false_shadows: Some(base + 2),
        within: Some(PartError {
            points: base + 3,
            mean_abs: Some(base as f64 / 2e3),
            leaks: base / 100 + 4,
            false_shadows: base / 100 + 5,
        }),
        ..PointError::default()
    };
    let image = None;
    let surface = Some(points(300));
    row.error =
        Some(RowError { seen: None, map: Some(points(100)), space: Some(points(200)), surface, casters: None, image });
    (row.standard_error, row.flicker_rms, row.frame_ns) = (Some(0.000_312), Some(0.0625), Some(7_250_000.0));
    row.frames = Some(FramesError { rmse: 0.5, flicker_rms: 0.375 });
    row
}

/// Reads the file's records as maps from name to field.
fn records(results: &Results) -> Vec<BTreeMap<String, String>> {
    let dir = tempfile::tempdir().expect("a folder");
    Store::open(dir.path()).expect("opened").write(results).expect("written");
    let mut csv = csv::Reader::from_path(dir.path().join("results.csv")).expect("there");
    csv.deserialize().map(|record| record.expect("as long as the heading")).collect()
}

/// Returns the names in the folder, sorted.
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
    written.rows[0].bytes_on_disk = Some(12_345);
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
    assert_eq!(at(0, "draw_pass_median_ns"), "shading.gbuffer=7");
    assert_eq!(at(0, "build_median_ns").parse::<f64>().ok(), written.rows[0].build_ns.map(|timing| timing.median));
    assert_eq!(at(0, "host_median_ns").parse::<f64>().ok(), written.rows[0].host_ns.map(|timing| timing.median));
    assert_eq!([at(0, "samples"), at(0, "map_bias"), at(0, "space_max")], ["30", "-0.05", "0.8"]);
    assert_eq!([at(0, "map_points"), at(0, "bytes_transient"), at(1, "bytes_transient")], ["640", "1024", ""]);
    assert_eq!([at(0, "bytes_on_disk"), at(1, "bytes_on_disk")], ["12345", ""]);
    assert_eq!([at(0, "counter_fragments"), at(0, "counter_overflowed")], ["12", ""]);
    assert_eq!([at(1, "counter_fragments"), at(1, "counter_overflowed")], ["", "7"]);
    assert_eq!([at(1, "status"), at(1, "build_median_ns"), at(1, "map_max")], ["refused", "", ""]);
    assert_eq!([at(1, "reason"), at(1, "variant")], ["needs, \"this\"\nthing", "avsm:curve=linear,nodes=8"]);
}

/// Every digit of a number must be read as written: rows that `--resume` keeps are written again.
#[test]
fn every_digit_comes_back() {
    let dir = tempfile::tempdir().expect("a folder");
    let store = Store::open(dir.path()).expect("opened");
    let rows =
        (1..2000).map(|i| row("plume", "avsm", 8, f64::from(i).sqrt(), f64::from(i).sin().abs() * 1e-7)).collect();
    let written = results(rows);
    store.write(&written).expect("written");
    assert!(Results::read(&dir.path().join("results.json")).expect("valid") == written);
}

/// Device, times and errors of schema 1 must be kept; what it lacked must be absent. The file is from the first edition.
#[test]
fn files_of_schema_1_are_read() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/report/schema-1.json");
    let read = Results::read(&path).expect("in the repository");
    assert_eq!((read.schema, read.rows.len(), read.device.name.as_str()), (SCHEMA, 2, "NVIDIA H200"));
    let row = &read.rows[0];
    assert_eq!((row.scene.as_str(), row.technique.as_str(), row.path.as_str()), ("plume_8k", "avsm", "two-pass"));
    assert_eq!((row.host_ns, row.build_ns.map(|t| t.median)), (None, Some(2_034_560.0)));
    assert_eq!((row.bytes_resident, row.bytes_transient), (Some(2_101_252), Some(44_028_556)));
    assert_eq!(row.bytes_on_disk, None);
    let map = row.error.as_ref().and_then(|error| error.map).expect("measured");
    assert!(map.points.is_none() && (map.mean_abs - 0.013_997_554_370_264_169).abs() < 1e-15, "{map:?}");

    // A technique that was never built has unknown bytes, not 0 bytes.
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
    // The rest of the file may be anything.
    assert!(told("newer.json", Some(r#"{ "schema": 5, "rows": 7 }"#)).contains("schema 5"));
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

    // A folder blocks the CSV's name: the JSON must be complete, the folder unchanged, and no temporary file may remain.
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

/// Every measured number must have its own column in the file.
#[test]
fn every_number_is_in_the_csv() {
    let records = records(&results(vec![opaque("room", "psm"), refused("room", "no")]));
    let mut expected: Vec<(String, String)> =
        [("standard_error", "0.000312"), ("flicker_rms", "0.0625"), ("frame_ns", "7250000"), ("image_rmse", "")]
            .into_iter()
            .chain([("frames_rmse", "0.5"), ("frames_flicker_rms", "0.375")])
            .map(|(name, value)| (name.into(), value.into()))
            .collect();
    for (kind, base) in [("map", 100), ("space", 200), ("surface", 300)] {
        let class = base / 100;
        let counts = [
            ("points", 10 * base),
            ("leaks", base + 1),
            ("false_shadows", base + 2),
            ("within_points", base + 3),
            ("within_leaks", class + 4),
            ("within_false_shadows", class + 5),
            ("beyond_leaks", base + 1 - (class + 4)),
            ("beyond_false_shadows", base + 2 - (class + 5)),
        ];
        expected.extend(counts.map(|(name, count)| (format!("{kind}_{name}"), count.to_string())));
        expected.push((format!("{kind}_mean_abs"), format!("0.0{class}")));
        expected.push((format!("{kind}_within_mean_abs"), (f64::from(base) / 2e3).to_string()));
    }
    for (name, value) in expected {
        assert_eq!((&records[0][&name], records[1][&name].as_str()), (&value, ""), "{name}");
    }
}

/// Reads rows from before the numbers of moving and opaque worlds were measured.
#[test]
fn earlier_files_of_schema_2_are_read() {
    let mut row = row("plume", "avsm", 8, 2.0, 0.01);
    (row.frame_ns, row.standard_error) = (None, None);
    let expected = results(vec![row]);
    let mut json = serde_json::to_value(&expected).expect("JSON");
    let without = |value: &mut serde_json::Value, keys: &[&str]| {
        let map = value.as_object_mut().expect("an object");
        keys.iter().for_each(|key| assert!(map.remove(*key).is_some(), "{key}"));
    };
    let row = &mut json["rows"][0];
    without(row, &["frame_ns", "standard_error", "flicker_rms", "first_ns", "first_host_ns", "steadiness"]);
    without(&mut row["error"], &["surface"]);
    for points in ["map", "space"] {
        without(&mut row["error"][points], &["leaks", "false_shadows", "within"]);
    }
    json["schema"] = 2.into();
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("results.json");
    std::fs::write(&path, json.to_string()).expect("written");
    let read = Results::read(&path).expect("read");
    assert_eq!(read, expected);
    assert_eq!(plots(&read).len(), 1);
    assert!(page(&read, dir.path()).is_ok() && !table(&read).contains("frame ms"));
}

/// Schema 2 excluded points within a technique's resolution from the error: reading must include them again, and statistics that are
/// unknown for all points must be absent, in the file's columns too.
#[test]
fn errors_of_schema_2_are_over_all_points_once_they_are_read() {
    let mut json = serde_json::to_value(results(vec![opaque("room", "psm")])).expect("JSON");
    json["schema"] = 2.into();
    for points in ["map", "space", "surface"] {
        let points = &mut json["rows"][0]["error"][points];
        let map = points.as_object_mut().expect("an error");
        let boundary = map.remove("within").expect("opaque casters");
        map.insert("boundary".into(), boundary);
        map.insert("max".into(), 0.5.into());
    }
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("results.json");
    std::fs::write(&path, json.to_string()).expect("written");
    let read = Results::read(&path).expect("read");
    let surface = read.rows[0].error.as_ref().and_then(|error| error.surface).expect("measured");
    assert_eq!((surface.points, surface.leaks, surface.max), (Some(3303), Some(301 + 7), None));
    assert!((surface.mean_abs - (3000.0 * 0.03 + 303.0 * 0.15) / 3303.0).abs() < 1e-12, "{surface:?}");
    assert_eq!(surface.beyond().map(|beyond| (beyond.points, beyond.leaks)), Some((3000, 301)));
    assert_eq!(read.rows[0].standard_error, None, "it was of a part of the points");
    assert_eq!(records(&read)[0]["surface_max"], "");
}
