//! Fault injection: the n-th allocation, mapping, creation, submission, wait or write fails (`GOBO_TEST_FAULT`), for every n. Each time
//! there must be one line per error, no leak, no partial file, and earlier measurements must be on disk.

use crate::resume::{rows_and_times_apart, unfinished};
use crate::support::{all, log};
use crate::{folder, gobo, results, runs, small_scene, text};
use gobo::bench::{Results, Status};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

/// Kinds of faults, with the words that must be reported.
const FAULTS: [(&str, &str); 6] = [
    ("allocation", "Out of memory"),
    ("map", "Failed to map memory"),
    ("creation", "ERROR_OUT_OF_HOST_MEMORY"),
    ("submission", "ERROR_DEVICE_LOST"),
    ("wait", "ERROR_DEVICE_LOST"),
    ("write", "no storage space"),
];

/// Longer than any of these commands takes on the slowest driver; anything slower hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// How many values of n to try per kind.
#[derive(Clone, Copy)]
enum Walk {
    /// This many, spread evenly from the first on.
    Some(u64),
    Every,
}

/// Returns the walk of a usual run, which tries few values of n.
fn usual() -> Walk {
    Walk::Some(if all() { 12 } else { 1 })
}

impl Walk {
    fn of(self, calls: u64) -> BTreeSet<u64> {
        match self {
            Self::Every => (1..=calls).collect(),
            Self::Some(few) => (0..few).map(|i| 1 + i * (calls - 1) / few).collect(),
        }
    }
}

/// Runs the program with that fault until it exits.
fn with_fault(arguments: &[&str], fault: &str) -> Output {
    let mut command = gobo();
    command.args(arguments).env("GOBO_TEST_FAULT", fault);
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let start = Instant::now();
    // The program's output fits into a pipe's buffer, so nothing has to read it meanwhile.
    while child.try_wait().expect("asked").is_none() {
        if start.elapsed() > PATIENCE {
            child.kill().expect("killed");
            panic!("{fault}: hangs: {arguments:?}");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.wait_with_output().expect("what it said")
}

/// Returns the number of calls of a kind, which the program reports when it exits.
fn calls(output: &Output, kind: &str) -> u64 {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let counts = said.lines().last().and_then(|line| line.strip_prefix("GOBO_TEST_FAULT: "));
    let of_kind = counts.and_then(|counts| counts.split(", ").find_map(|count| count.strip_prefix(kind)));
    of_kind.and_then(|count| count.trim().parse().ok()).unwrap_or_else(|| panic!("no count in {said}"))
}

/// Fails the n-th call of each kind, for each n of the walk, passes the outcome to `check`, and prints the number of faults.
fn walk(name: &str, arguments: &[&str], out: &Path, walk: Walk, check: impl Fn(&str, &Output)) {
    let none = with_fault(arguments, "write:0");
    for (kind, words) in FAULTS {
        let count = calls(&none, kind);
        assert!(count > 0, "no {kind} in {arguments:?}");
        let all = walk.of(count);
        let (mut met, mut lived) = (0, 0);
        for n in &all {
            clear(out);
            let fault = format!("{kind}:{n}");
            let output = with_fault(arguments, &fault);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            if calls(&output, kind) < *n {
                // The number of timed runs depends on how long they take.
                assert!(output.status.success(), "{fault}: {said}");
                continue;
            }
            met += 1;
            if kind == "allocation" && output.status.success() {
                // A build survives the loss of one buffer: it gives all tiles the same capacity, and then counts each tile's entries.
                lived += 1;
                assert!(lived <= 2, "{fault}: {said}");
                check(&fault, &output);
                continue;
            }
            // A panic gives another exit code, and a signal gives none.
            assert_eq!(output.status.code(), Some(1), "{fault}: {}\n{said}", output.status);
            let errors: Vec<_> = said.lines().filter(|line| line.starts_with("gobo: ")).collect();
            assert!(errors.iter().any(|line| line.contains(words)), "{fault}: {said}");
            let known = |line: &str| ["gobo: ", "[", "GOBO_TEST_FAULT: "].iter().any(|start| line.starts_with(start));
            assert!(said.lines().all(known), "{fault}: not a line for each error:\n{said}");
            // Leaks and messages of the layer are reported once the device is closed.
            assert!(!said.contains("gobo-leak") && !said.contains("VUID"), "{fault}: {said}");
            assert_eq!(unfinished(out), [""; 0], "{fault}");
            check(&fault, &output);
        }
        assert!(met > 0, "no fault of {kind}");
        println!("{name}: {met} of {count} faults of {kind}");
    }
}

fn clear(folder: &Path) {
    for entry in std::fs::read_dir(folder).expect("there") {
        std::fs::remove_file(entry.expect("an entry").path()).expect("removed");
    }
}

/// Compares two rows: a failed row must say so or be absent, a measured one must be as usual, and `--resume` must measure the rest.
fn compare(name: &str, how_many: Walk) {
    log("exercised", name, &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let validation = if matches!(how_many, Walk::Every) { &["--validation"][..] } else { &[] };
    let arguments =
        ["compare", text(&scene), "--quick", "--frames", "1", "--picture", "16x16", "--out", text(out.path())];
    let techniques = ["beer-shadow-map:path=binned,size=16", "translucency-map:path=raster,size=16"];
    let techniques = techniques.iter().flat_map(|spec| ["--technique", spec]);
    let arguments: Vec<&str> = arguments.into_iter().chain(techniques).chain(validation.iter().copied()).collect();
    with_fault(&arguments, "none");
    let whole = results(out.path());
    assert_eq!(whole.rows.iter().map(|row| row.status).collect::<Vec<_>>(), [Status::Ok; 2]);
    walk(name, &arguments, out.path(), how_many, |fault, output| {
        let file = out.path().join("results.json");
        let left = if file.exists() { results(out.path()) } else { Results::default() };
        assert!(left.rows.len() <= 2, "{fault}");
        let ended: Vec<_> = left.rows.iter().map(|row| row.status).collect();
        let failed = ended.iter().filter(|status| **status == Status::Failed).count();
        if fault.starts_with("submission") || fault.starts_with("wait") {
            // Nothing may be measured on a lost device.
            assert!(
                failed <= 1 && ended.iter().rev().skip(1).all(|status| *status == Status::Ok),
                "{fault}: {ended:?}"
            );
        } else if !fault.starts_with("write") {
            let lived = output.status.success() && failed == 0;
            assert!(ended.is_empty() || lived || (ended.len(), failed) == (2, 1), "{fault}: {ended:?}");
        }
        let good = |all: &Results| all.rows.iter().filter(|row| row.status == Status::Ok).cloned().collect::<Vec<_>>();
        for row in good(&left) {
            let (expected, _) = whole
                .rows
                .iter()
                .map(rows_and_times_apart)
                .find(|(r, _)| r.technique == row.technique)
                .expect("its row");
            assert_eq!(rows_and_times_apart(&row).0, expected, "{fault}");
            assert!(fault.starts_with("write") || out.path().join(row.picture.expect("drawn")).exists(), "{fault}");
        }
        if !left.rows.is_empty() && !fault.starts_with("write") {
            let table = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(left.rows.iter().all(|row| table.contains(&row.technique)), "{fault}: {table}");
            let csv = std::fs::read_to_string(out.path().join("results.csv")).expect("written");
            assert_eq!(csv.lines().count(), 1 + left.rows.len(), "{fault}");
        }
        // Resuming must always measure the rest; tests this for one fault in six.
        let n: u64 = fault.split(':').nth(1).and_then(|n| n.parse().ok()).expect("a number");
        if n.is_multiple_of(6) || fault == "write:1" {
            let kept: Vec<_> = good(&left);
            let resumed = with_fault(&[&arguments[..], &["--resume"]].concat(), "none");
            assert!(resumed.status.success(), "{fault}: {resumed:?}");
            let after = results(out.path());
            let compared = |all: &Results| all.rows.iter().map(|row| rows_and_times_apart(row).0).collect::<Vec<_>>();
            assert_eq!(compared(&after), compared(&whole), "{fault}");
            if !fault.starts_with("write") {
                assert!(kept.iter().all(|row| after.rows.contains(row)), "{fault}: measured again");
            }
        }
    });
}

/// Writes one file, which must be complete or absent.
fn one_file(name: &str, command: &[&str], file: &str, how_many: Walk) {
    log("exercised", name, &runs("beer-shadow-map", "binned").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let file = out.path().join(file);
    let validation = if matches!(how_many, Walk::Every) { &["--validation"][..] } else { &[] };
    let arguments = [&command[..1], &[text(&scene), "--out", text(&file)], &command[1..], validation].concat();
    assert!(with_fault(&arguments, "none").status.success());
    let whole = std::fs::read(&file).expect("written");
    walk(name, &arguments, out.path(), how_many, |fault, output| match std::fs::read(&file) {
        // Nothing failed, or only something after the file was written.
        Ok(bytes) => {
            assert!(bytes == whole && (output.status.success() || fault.starts_with("write")), "{fault}: it is there");
        }
        Err(_) => assert!(std::fs::read_dir(out.path()).expect("there").next().is_none(), "{fault}: something else is"),
    });
}

const RENDER: [&str; 5] = ["render", "--picture", "16x16", "--technique", "avsm:size=16,path=binned"];
const BAKE: [&str; 3] = ["bake", "--technique", "voxelized:size=64"];

#[test]
fn faults_in_a_comparison() {
    if crate::support::is_costly("faults_in_a_comparison") {
        return;
    }
    compare("faults_in_a_comparison", usual());
}

#[test]
fn faults_in_a_picture() {
    if crate::support::is_costly("faults_in_a_picture") {
        return;
    }
    one_file("faults_in_a_picture", &RENDER, "out.png", usual());
}

#[test]
fn faults_in_a_bake() {
    one_file("faults_in_a_bake", &BAKE, "out.gobo", usual());
}

/// Tries all faults under the validation layer, which detects undestroyed objects. Takes minutes; run by hand.
#[test]
#[ignore = "minutes"]
fn every_fault() {
    one_file("every_fault", &RENDER, "out.png", Walk::Every);
    one_file("every_fault", &BAKE, "out.gobo", Walk::Every);
    compare("every_fault", Walk::Every);
}

/// A command whose standard output is full must report it, but still write its files.
#[test]
fn a_full_disk_behind_standard_output() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else {
        return crate::support::skipped("a_full_disk_behind_standard_output", "no /dev/full");
    };
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let arguments =
        ["compare", text(&scene), "--quick", "--frames", "1", "--picture", "16x16", "--no-truth", "--technique"];
    let mut command = gobo();
    command.args(arguments).args(["translucency-map:path=raster,size=16", "--out", text(out.path())]);
    let output = command.stdin(Stdio::null()).stdout(full).stderr(Stdio::piped()).output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.lines().last().is_some_and(|line| line.starts_with("gobo: cannot write stdout: ")), "{said}");
    assert!(out.path().join("report.html").exists() && results(out.path()).rows.len() == 1);
}

/// Without `--test-hooks`, variables that happen to have the same names must have no effect.
#[test]
fn without_the_option_no_variable_of_tests_is_read() {
    let command = |option: Option<&str>| {
        let mut command = gobo();
        let (program, arguments) = (command.get_program().to_owned(), command.get_args().map(ToOwned::to_owned));
        let arguments: Vec<_> = arguments.filter(|argument| argument != "--test-hooks").collect();
        command = std::process::Command::new(program);
        command.args(arguments).args(option).arg("devices").env("GOBO_TEST_FAULT", "creation:1");
        command.stdin(Stdio::null()).output().expect("the program starts")
    };
    assert!(!command(Some("--test-hooks")).status.success(), "the first creation is to fail");
    let output = command(None);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}
