//! `gobo stress`: its cases, what it sees of techniques, and the program with its files.

mod support;

use gobo::stress::{Outcome, Results, Subject, Sweep, ask, cases, verdicts};
use std::process::{Command, Output, Stdio};
use support::{gpu_test, spec, those_that_run};

/// The same scene each time; numbers that files may have, up to an angle that they may not; something at the mildest value.
#[test]
fn cases_are_scenes() {
    let mut names = Vec::new();
    for case in cases() {
        assert!(!names.contains(&case.name), "{} twice", case.name);
        names.push(case.name);
        assert!(case.values.len() > 2 && !case.about.is_empty() && !case.swept.is_empty(), "{}", case.name);
        for &value in case.values.iter().filter(|value| **value <= 1e5) {
            let scene = (case.scene)(value);
            assert!(scene == (case.scene)(value), "{} {value:e}: another scene", case.name);
            for p in &scene.particles {
                let finite =
                    p.position.iter().all(|c| c.is_finite()) && p.radius.is_finite() && p.extinction.is_finite();
                assert!(finite && p.radius > 0.0 && p.extinction >= 0.0, "{} {value:e}: {p:?}", case.name);
            }
            let corners = scene.meshes.iter().flat_map(|mesh| &mesh.positions).flatten();
            assert!(corners.copied().all(f32::is_finite), "{} {value:e}", case.name);
        }
        let mildest = (case.scene)(case.values[0]);
        assert!(!mildest.casters().is_empty() || mildest.has_triangles(), "{}", case.name);
    }
    // On software devices something is left of each.
    assert!(cases().all(|case| Sweep::of(case).values(true).count() > 1));
}

/// Lists lose nothing, so that what they answer is the filtered truth up to rounding: on rays, behind all smoke and while it
/// moves, under each kind of light. What is shuffled is the same to the bit where paths promise it.
#[test]
fn who_loses_nothing_holds() {
    const TEST: &str = "who_loses_nothing_holds";
    gpu_test(TEST, |context| {
        let cases =
            [("extinction", 1e4), ("depth-range", 1e2), ("point-light", 0.3), ("strands", 0.5), ("texels", 32.0)];
        for (name, value) in cases {
            let case = cases_named(name);
            let scene = (case.scene)(value);
            let subject = Subject::new(&scene);
            for text in those_that_run(TEST, context, ["uncompressed:size=32", "avsm:path=binned,size=32"]) {
                let row = ask(context, &subject, (name, value), &spec(text));
                assert_eq!(row.outcome, Outcome::Answered, "{name}: {}", row.reason);
                let figures = row.figures.clone().expect("answered");
                println!("{name} {value:e} {text}: {figures:?}");
                let map = figures.map.expect("smoke in maps");
                let exact = text.starts_with("uncompressed");
                assert!(map.points > 1000);
                assert!(map.error.expect("points").mean_abs < if exact { 1e-5 } else { 1e-2 }, "{name}: {text}");
                assert!(figures.tail.expect("tails") < 1e-3 && figures.rise.expect("rays") < 1e-4, "{name}: {text}");
                assert!(figures.step_rms.expect("steps") < if exact { 1e-4 } else { 2e-2 }, "{name}: {text}");
                assert!(figures.order_spread.expect("orders") <= if exact { 1e-5 } else { 0.0 }, "{name}: {text}");
                assert_eq!(verdicts(&[row])[0].verdict, "holds", "{name}: {text}");
            }
        }
    });
}

/// What a technique leaves out of its answers is seen: one texel that knows no depth, before and in smoke.
#[test]
fn who_has_no_depth_does_not_hold() {
    const TEST: &str = "who_has_no_depth_does_not_hold";
    gpu_test(TEST, |context| {
        let scene = (cases_named("few").scene)(2.0);
        let subject = Subject::new(&scene);
        for text in those_that_run(TEST, context, ["translucency-map:path=binned,size=32"]) {
            let row = ask(context, &subject, ("few", 2.0), &spec(text));
            let figures = row.figures.expect("answered");
            let map = figures.map.and_then(|map| map.error).expect("points");
            assert!(map.mean_abs > 0.05 && map.bias < -0.05, "{map:?}");
            // Behind all smoke it is right, up to its eight bits.
            assert!(figures.tail.expect("tails") < 0.01);
        }
    });
}

fn cases_named(name: &str) -> &'static gobo::stress::Case {
    gobo::stress::Case::named(name).expect("a case")
}

/// The program, on the driver that this test was started on.
fn run(arguments: &[&str]) -> Output {
    let mut command = match std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty()) {
        Some(runner) => {
            let mut command = Command::new(runner);
            command.arg(env!("CARGO_BIN_EXE_gobo"));
            command
        }
        None => Command::new(env!("CARGO_BIN_EXE_gobo")),
    };
    command.arg("stress").args(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

/// Smoke and meshes; a table, JSON, CSV and a page that say the same.
#[test]
fn the_program_writes_what_it_finds() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let out = folder.path().to_str().expect("UTF-8");
    let techniques = ["--technique", "avsm:path=binned,size=32", "--technique", "voxel-grid:size=64,march=exact"];
    let output = run(&[&["few", "duplicated", "--out", out][..], &techniques].concat());
    let (said, heard) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{}\n{said}\n{heard}", output.status);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
    let results: Results = serde_json::from_str(&read("stress.json")).expect("JSON");
    assert_eq!(verdicts(&results.rows), results.verdicts);
    // Both are asked about both.
    assert_eq!((results.verdicts.len(), results.rows.len()), (4, 2 * 3 + 2 * 4));
    assert_eq!(read("stress.csv").lines().count(), 1 + results.rows.len());
    let page = read("stress.html");
    for verdict in &results.verdicts {
        let word = verdict.verdict.as_str();
        assert!(said.contains(word) && page.contains(word) && page.contains(&verdict.technique), "{verdict:?}");
        assert_eq!(verdict.verdict, "holds", "{verdict:?}");
    }
}

/// Nobody answers in no time: rows that say so, and no failure of the run.
#[test]
fn who_does_not_answer_in_time_is_a_row() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = run(&["few", "--limit", "0.001", "--technique", "avsm:path=binned,size=32", "--out", out]);
    assert!(output.status.success(), "{output:?}");
    let json = std::fs::read_to_string(folder.path().join("stress.json")).expect("JSON");
    let results: Results = serde_json::from_str(&json).expect("JSON");
    let [row] = &results.rows[..] else { panic!("who has not answered is asked no more: {:?}", results.rows) };
    assert_eq!((row.outcome, row.reason.as_str()), (Outcome::NoAnswer, "no answer within 0.001 s"));
}

#[test]
fn what_cannot_be_asked_is_one_line() {
    let all: [(&[&str], &str); 4] = [
        (&["no-such-case"], "no such case"),
        (&["few", "--technique", "nobody"], "no technique \"nobody\""),
        (&["few", "--device", "no such device", "--technique", "uncompressed", "--out", "/tmp"], "no such device"),
        (&["few", "--out", "/dev/null/under"], "cannot write /dev/null/under"),
    ];
    for (arguments, words) in all {
        let output = run(arguments);
        let heard = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && heard.lines().count() == 1 && heard.contains(words),
            "{arguments:?}: {heard}"
        );
    }
}
