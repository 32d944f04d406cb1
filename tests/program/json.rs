//! `--json`: printed values must be those behind the tables and in the files.

use crate::recommend::{line, made_up};
use crate::support::log;
use crate::{folder, gobo, ok, results, runs, small_scene, text};
use gobo::bench::stress::Soaked;
use gobo::bench::{Change, Margins, Results, changes};
use gobo::report::{casters, changes_table, footprints, passes, stress_table};
use serde_json::Value;

/// Compares and joins with `--json`, with and without a baseline. Resumed rows are printed twice, as tables and as JSON.
#[test]
fn compared_and_joined() {
    if crate::support::is_costly("compared_and_joined") {
        return;
    }
    log("exercised", "compared_and_joined", &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let of = |name: &str| out.path().join(name);
    let (shard, joined, again, baseline) = (of("shard"), of("joined"), of("again"), of("baseline.json"));
    let mut arguments =
        vec!["compare", text(&scene), "--quick", "--frames", "6", "--picture", "16x16", "--out", text(&shard)];
    arguments.extend(["--shard", "1/1", "--passes", "--casters", "--footprints"]);
    let specs = ["beer-shadow-map:path=binned,size=8|16", "avsm:path=interlock,size=8"];
    arguments.extend(specs.into_iter().flat_map(|spec| ["--technique", spec]));
    let printed: Results = serde_json::from_str(&ok(&[&arguments[..], &["--json"]].concat())).expect("JSON alone");
    assert_eq!(printed, results(&shard));
    assert_eq!(printed.rows.len(), 3);
    // An earlier run with half of each error.
    let mut before = printed.clone();
    for error in before.rows.iter_mut().filter_map(|row| row.error.as_mut()) {
        [&mut error.map, &mut error.space, &mut error.surface].into_iter().flatten().for_each(|e| e.mean_abs /= 2.0);
    }
    std::fs::write(&baseline, serde_json::to_vec(&before).expect("JSON")).expect("written");
    arguments.extend(["--resume", "--baseline", text(&baseline)]);

    let json = ok(&[&arguments[..], &["--json"]].concat());
    let now: Results = serde_json::from_str(&json).expect("JSON alone");
    assert_eq!(now.rows, printed.rows);
    let tables = ok(&arguments);
    // The tables show the copy rate of the last run, since each run measures it anew.
    let written = results(&shard);
    assert_eq!(written.rows, now.rows);
    let changed = changes(&before, &now, Margins::default());
    for table in [passes(&written), casters(&written), footprints(&written), changes_table(&changed, &now)] {
        assert!(tables.contains(&table), "{table}\nis not in\n{tables}");
    }
    let document: Value = serde_json::from_str(&json).expect("JSON");
    let listed = document["changes"].as_array().expect("changes");
    assert_eq!(listed.len(), changed.len());
    let mut worse = 0;
    for (listed, change) in listed.iter().zip(&changed) {
        assert_eq!(listed["spec"], change.row().spec());
        let Change::Both { figures, .. } = change else { panic!("{change:?}") };
        let listed = listed["figures"].as_array().expect("figures");
        assert_eq!(listed.len(), figures.len());
        for (listed, figure) in listed.iter().zip(figures) {
            assert_eq!((&listed["what"], listed["now"].as_f64()), (&figure.name.into(), Some(figure.now)));
            assert_eq!((listed["before"].as_f64(), listed["share"].as_f64()), (Some(figure.before), figure.share()));
            worse += usize::from(listed["verdict"] == "worse");
        }
    }
    assert!(worse > 0 && worse == tables.matches("WORSE").count(), "{worse}: {tables}");

    // The table must show the printed rows: reading them must give it again.
    std::fs::write(shard.join("results.json"), &json).expect("written");
    let table = ok(&["join", text(&shard), "--out", text(&joined)]);
    let table = table.trim_end().rsplit_once('\n').expect("a table and a path").0;
    // Between the table and the recommendation, `compare` prints the changes since the baseline.
    let mut lines = tables.lines();
    assert!(table.lines().all(|line| lines.any(|other| other == line)), "{table}\nis not in\n{tables}");
    assert!(table.contains("best balanced"), "{table}");
    let json = ok(&["join", text(&shard), "--out", text(&again), "--json"]);
    assert_eq!(serde_json::from_str::<Results>(&json).expect("JSON alone"), results(&again));
}

#[test]
fn recommended() {
    let folder = folder();
    let path = made_up(folder.path(), &["a", "b"]);
    let (said, json) = (ok(&["recommend", "--from", &path]), ok(&["recommend", "--from", &path, "--json"]));
    let answers: Vec<Value> = serde_json::from_str(&json).expect("JSON alone");
    assert_eq!(answers.iter().map(|answer| &answer["scene"]).collect::<Vec<_>>(), ["a", "b"]);
    let answer = &answers[0];
    assert_eq!((&answer["device"], &answer["error"]), (&"d".into(), &"seen error".into()));
    for what in ["fastest", "closest", "smallest"] {
        let words = line(&said, what);
        assert_eq!(answer[what]["spec"], words[words.len() - 1]);
        for (key, word) in ["time_ms", "error", "flip"].into_iter().zip(&words[1..]) {
            assert_eq!(answer[what][key].as_f64(), word.parse().ok(), "{what}: {key}");
        }
        let unit = if words[5] == "KiB" { 1024.0 } else { 1_048_576.0 };
        assert_eq!(answer[what]["bytes_resident"].as_f64(), words[4].parse::<f64>().ok().map(|n| n * unit));
    }
    let mut lines = said.lines();
    let (best, closer) = (lines.next().expect("a sentence"), lines.next().expect("what is closer"));
    assert!(best.contains(answer["best"]["spec"].as_str().expect("a spec")), "{best}");
    assert!(closer.contains(answer["closer"]["spec"].as_str().expect("a spec")), "{closer}");
}

#[test]
fn stressed_and_soaked() {
    log("exercised", "stressed_and_soaked", &runs("beer-shadow-map", "binned").0);
    let out = folder();
    let run = |arguments: &[&str]| {
        let mut command = gobo();
        command.args(["stress", "--out", text(out.path())]).args(arguments).env("GOBO_TEST_LITTLE", "1");
        String::from_utf8(command.output().expect("it starts").stdout).expect("UTF-8")
    };
    let read = |file: &str| std::fs::read_to_string(out.path().join(file)).expect("written");
    let arguments = ["extinction", "--technique", "beer-shadow-map:path=binned,size=8"];
    let json = run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(json, read("stress.json"));
    let printed: gobo::bench::stress::Results = serde_json::from_str(&json).expect("JSON alone");
    let tables = run(&arguments);
    let table = stress_table(&printed, &printed.verdicts[0].case);
    assert!(!printed.verdicts.is_empty() && tables.contains(&table), "{table}\nis not in\n{tables}");

    let json = run(&["--soak", "0", "--json"]);
    assert_eq!(json, read("soak.json"));
    assert!(serde_json::from_str::<Soaked>(&json).is_ok_and(|soaked| soaked.rounds == 1), "{json}");
}
