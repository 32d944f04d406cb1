//! `compare --shard` and `join`: shards, one of them interrupted by a signal, must give the rows of one run, also when started by Slurm and
//! CI.

use crate::errors::fails;
use crate::resume::{end, untimed};
use crate::support::{all, is_long, log};
use crate::{folder, gobo, ok, results, run, runs, small_scene, text};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Returns arguments for two scenes with five rows each.
fn arguments<'a>(scenes: [&'a str; 2], out: &'a str) -> Vec<&'a str> {
    let mut all = vec!["compare", scenes[0], scenes[1]];
    all.extend(["--quick", "--frames", "1", "--picture", "16x16", "--out", out]);
    let specs = ["beer-shadow-map:path=binned|raster,size=8|16", "avsm:path=interlock,size=8"];
    all.extend(specs.into_iter().flat_map(|spec| ["--technique", spec]));
    all
}

/// Asserts that both folders have the same results except for times: rows, to the bit and in order, and their pictures.
#[track_caller]
fn are_one_run(joined: &Path, whole: &Path) {
    let (a, b) = (results(joined), results(whole));
    assert_eq!((untimed(&a), &a.conditions, &a.shard), (untimed(&b), &b.conditions, &None));
    assert_eq!(a.rows.len(), 10);
    for name in a.rows.iter().flat_map(|row| [&row.picture, &row.difference]).flatten() {
        let [a, b] = [joined, whole].map(|folder| std::fs::read(folder.join(name)).expect("a picture"));
        assert!(a == b, "{name}");
    }
    let page = std::fs::read_to_string(joined.join("report.html")).expect("written");
    assert!(page.contains("data:image/png;base64,"));
    for file in ["results.csv", "small-reference.png"] {
        assert!(joined.join(file).is_file(), "{file}");
    }
}

#[test]
fn shards_have_the_rows_of_one_run() {
    if crate::support::is_long("shards_have_the_rows_of_one_run") {
        return;
    }
    log("exercised", "shards_have_the_rows_of_one_run", &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let scenes = [text(&scene); 2];
    let of = |name: &str| text(&out.path().join(name)).to_owned();
    let [whole, one, two, joined] = ["whole", "1", "2", "joined"].map(of);
    ok(&arguments(scenes, &whole));
    let shard = |number: &'static str, out: &'static str| [&arguments(scenes, out)[..], &["--shard", number]].concat();
    let start = |arguments: &[&str]| {
        let mut command = gobo();
        command.args(arguments).current_dir(out.path()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().expect("it starts")
    };
    let succeeds = |arguments: &[&str]| {
        let output = start(arguments).wait_with_output().expect("it ends");
        assert!(output.status.success(), "{output:?}");
    };
    // Ends the first shard as soon as it has a row, then resumes it.
    let first = shard("1/2", "1");
    let mut child = start(&first);
    let file = Path::new(&one).join("results.json");
    while !file.exists() && child.try_wait().expect("asked").is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    end(&mut child, "KILL");
    let left = results(Path::new(&one));
    println!("{} of 5 rows when it was ended", left.rows.len());
    if left.rows.len() < 5 {
        fails(&["join", &one, "--out", &joined], &["shard 1/2 has", "of its 5 rows", "--resume"]);
    }
    succeeds(&[&first[..], &["--resume"]].concat());
    assert_eq!(results(Path::new(&one)).rows[..left.rows.len()], left.rows[..]);
    succeeds(&shard("2/2", "2"));
    let (a, b) = (results(Path::new(&one)), results(Path::new(&two)));
    assert_eq!((a.rows.len(), b.rows.len(), &a.conditions), (5, 5, &b.conditions));
    assert!(
        a.rows.iter().all(|row| b.rows.iter().all(|other| (&row.scene, row.spec()) != (&other.scene, other.spec())))
    );

    let table = ok(&["join", &two, &one, "--out", &joined]);
    assert!(table.contains("beer-shadow-map") && table.trim_end().ends_with("report.html"), "{table}");
    are_one_run(Path::new(&joined), Path::new(&whole));
    let command = results(Path::new(&joined)).command;
    assert!(!command.contains("--shard") && !command.contains(&one), "{command}");

    // A report must treat shards as the one run that they are, and print the values of the joined rows.
    let file = |of: &str| format!("{of}/results.json");
    let reported = |files: &[&str]| -> serde_json::Value {
        let files: Vec<String> = files.iter().map(|of| file(of)).collect();
        let files: Vec<&str> = files.iter().map(String::as_str).collect();
        let printed = ok(&[&["report"][..], &files, &["--json", "--out", &of("report")]].concat());
        serde_json::from_str(&printed).expect("JSON alone")
    };
    let report = reported(&[&two, &one]);
    assert_eq!(report["answer"], reported(&[&joined])["answer"]);
    let (lines, rows) = (report["rows"].as_array().expect("rows").clone(), results(Path::new(&joined)).rows);
    assert_eq!(lines.len(), rows.len());
    for row in &rows {
        let is_of = |line: &&serde_json::Value| line["variant"] == row.spec() && line["scene"] == row.scene;
        let line = lines.iter().find(is_of).unwrap_or_else(|| panic!("{} on {}", row.spec(), row.scene));
        assert_eq!(line["build_median_ns"].as_f64(), row.build_ns.map(|timing| timing.median));
        assert_eq!(line["frame_ns"].as_f64(), row.frame_ns);
        let space = row.error.as_ref().and_then(|error| error.space).map(|space| space.mean_abs);
        assert_eq!((line["space_mean_abs"].as_f64(), &line["files"]), (space, &file(&two).into()));
    }
    fails(&["report", &file(&one), "--out", &of("no")], &["shard 2/2 of its run is not there"]);

    // Anything but a complete run must change nothing.
    for (shards, words) in [
        (&[&one][..], &["shard 2/2 of its run is not there"][..]),
        (&[&one, &one], &["shard 1/2 is", "too"]),
        (&[&one, &whole], &["whole: it is no shard"]),
        (&[&one, &joined, &two], &["joined: it is no shard"]),
        (&[&one, &of("none")], &["none/results.json"]),
    ] {
        let arguments = [&["join"][..], &shards.iter().map(|s| s.as_str()).collect::<Vec<_>>(), &["--out", &of("no")]];
        fails(&arguments.concat(), words);
        assert!(!Path::new(&of("no")).exists());
    }
    fails(&["join", &one, &two, "--out", &one], &["--out", "one of the shards"]);
    let picture = results(Path::new(&two)).rows[0].picture.clone().expect("drawn");
    std::fs::remove_file(Path::new(&two).join(&picture)).expect("removed");
    fails(&["join", &one, &two, "--out", &joined], &[&picture, "--resume"]);
    fails(&[&arguments(scenes, &one)[..], &["--shard", "2/2", "--resume"]].concat(), &["--shard 1/2, and this is 2/2"]);
    for wrong in ["0/2", "3/2", "2", "a/b", "1/0"] {
        assert_eq!(run(&["compare", "--shard", wrong]).status.code(), Some(2), "{wrong}");
    }
}

/// With more shards than rows, some have none, which is no failure.
#[test]
fn a_shard_without_rows() {
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let mut shards = Vec::new();
    for number in 1..=3 {
        let (shard, folder) = (format!("{number}/3"), out.path().join(number.to_string()));
        let mut all = vec!["compare", text(&scene), "--quick", "--frames", "1", "--no-truth", "--out", text(&folder)];
        all.extend(["--technique", "beer-shadow-map:path=binned,size=8|16", "--shard", &shard]);
        ok(&all);
        shards.push(folder);
    }
    assert_eq!(shards.iter().map(|folder| results(folder).rows.len()).collect::<Vec<_>>(), [1, 1, 0]);
    let joined = out.path().join("joined");
    let folders: Vec<&str> = shards.iter().map(|folder| text(folder)).collect();
    ok(&[&["join"][..], &folders, &["--out", text(&joined)]].concat());
    assert_eq!(results(&joined).rows.len(), 2);
}

/// Runs examples/slurm.sh and examples/shards.yml, with one process per shard at the same time, and the program as `gobo`.
#[test]
fn slurm_and_ci() {
    if is_long("slurm_and_ci") {
        return;
    }
    log("exercised", "slurm_and_ci", &runs("beer-shadow-map", "binned").0);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let arguments = arguments([text(&scene); 2], "whole");
    let words = arguments.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>();
    let start = |script: &str, variables: &[(&str, String)]| {
        let program = std::env::var("GOBO_RUNNER").unwrap_or_default();
        let script = format!(
            "gobo() {{ {program} {} --test-hooks \"$@\"; }}\nexport -f gobo\n{script}",
            env!("CARGO_BIN_EXE_gobo")
        );
        let mut command = Command::new("bash");
        command.args(["-c", &script]).current_dir(out.path()).envs(variables.iter().map(|(name, value)| (name, value)));
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("bash starts")
    };
    let succeed = |children: Vec<std::process::Child>| {
        for child in children {
            let output = child.wait_with_output().expect("it ends");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    };
    succeed(vec![start(&format!("gobo {}", words.join(" ")), &[])]);

    // `exec` does not run shell functions.
    let slurm = std::fs::read_to_string(root.join("examples/slurm.sh")).expect("there").replace("exec gobo", "gobo");
    std::fs::write(out.path().join("slurm.sh"), slurm).expect("written");
    // Sets the variable of a job array; the script itself sets --out.
    let given = format!("bash slurm.sh 3 {}", [&words[1..8], &words[10..]].concat().join(" "));
    let tasks = (1..=3).map(|task| start(&given, &[("SLURM_ARRAY_TASK_ID", task.to_string())]));
    succeed(tasks.collect());
    succeed(vec![start("gobo join gobo-shards/* --out slurm", &[])]);
    are_one_run(&out.path().join("slurm"), &out.path().join("whole"));

    if !all() {
        return;
    }
    let ci = std::fs::read_to_string(root.join("examples/shards.yml")).expect("there");
    let steps: Vec<&str> = ci.lines().filter_map(|line| line.trim().strip_prefix("- run: ")).collect();
    let [measure, join] = steps[..] else { panic!("{steps:?}") };
    assert!(measure.starts_with("gobo compare plume_8k houses --quick ") && ci.contains("shard: [1, 2, 3]"));
    let measure = measure.replace("compare plume_8k houses --quick", &[&words[..8], &words[10..]].concat().join(" "));
    let jobs = (1..=3).map(|shard| start(&measure.replace("${{ matrix.shard }}", &shard.to_string()), &[]));
    succeed(jobs.collect());
    succeed(vec![start(join, &[])]);
    are_one_run(&out.path().join("gobo-report"), &out.path().join("whole"));
}
