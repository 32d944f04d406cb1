//! `gobo stress`: its cases, what it detects in techniques, and the program with its files.

use crate::support::{all, gpu_test, spec, those_that_run};
use gobo::bench::stress::{Outcome, Results, Soaked, Subject, Sweep, ask, cases, round, verdicts};
use gobo::gpu::{Buffer, Memory};
use gobo::scene::Particle;
use std::io::{Read, Write};
use std::process::{Command, Output, Stdio};

/// Cases must give the same scene each time, with finite numbers for all values up to 1e5, and with casters at the mildest value.
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
    // Each sweep must have several values left on software devices.
    assert!(cases().all(|case| Sweep::of(case).values(true).count() > 1));
}

/// Lists lose nothing, so their answers must be the filtered truth up to rounding: on rays, behind all smoke and while it moves, under each
/// kind of light. Shuffled casters must give the same bits on paths that promise it.
#[test]
fn who_loses_nothing_holds() {
    if crate::support::is_costly("who_loses_nothing_holds") {
        return;
    }
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

/// Seen error: exact techniques must have none, and without shadows all of it must be surplus light.
#[test]
fn seen_error_is_of_what_the_camera_sees() {
    const TEST: &str = "seen_error_is_of_what_the_camera_sees";
    gpu_test(TEST, |context| {
        let scene = (cases_named("few").scene)(2.0);
        let subject = Subject::new(&scene);
        let seen = |text: &str| {
            let row = ask(context, &subject, ("few", 2.0), &spec(text));
            row.figures.and_then(|figures| figures.seen).unwrap_or_else(|| panic!("{text}: {}", row.reason))
        };
        let (exact, none) = (seen("grid-query:size=64"), seen("none"));
        assert!(exact.points > 100 && exact.mean < 1e-5, "{exact:?}");
        assert!(none.mean > 0.01 && (none.mean - none.bias).abs() < 1e-9, "{none:?}");
    });
}

/// The stress test must detect missing information: here, texels without depth, which are wrong in front of the smoke and inside it.
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
            assert!(map.mean_abs > 0.05 && map.bias.is_some_and(|bias| bias < -0.05), "{map:?}");
            // Behind all smoke the technique must be right, up to its eight bits.
            assert!(figures.tail.expect("tails") < 0.01);
        }
    });
}

fn cases_named(name: &str) -> &'static gobo::bench::stress::StressCase {
    gobo::bench::stress::StressCase::named(name).expect("a case")
}

fn run(arguments: &[&str]) -> Output {
    program(arguments).stdin(Stdio::null()).output().expect("the program starts")
}

/// Returns a command for the program on the driver that runs this test.
fn program(arguments: &[&str]) -> Command {
    let mut command = match std::env::var_os("GOBO_RUNNER").filter(|runner| !runner.is_empty()) {
        Some(runner) => {
            let mut command = Command::new(runner);
            command.arg(env!("CARGO_BIN_EXE_gobo"));
            command
        }
        None => Command::new(env!("CARGO_BIN_EXE_gobo")),
    };
    command.args(["--test-hooks", "stress"]).args(arguments);
    command
}

/// Runs cases of smoke and of meshes; the table, JSON, CSV and page must agree.
#[test]
fn the_program_writes_what_it_finds() {
    if crate::support::is_costly("the_program_writes_what_it_finds") {
        return;
    }
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let out = folder.path().to_str().expect("UTF-8");
    let techniques = ["--technique", "avsm:path=binned,size=32", "--technique", "voxel-grid:size=64,march=exact"];
    let output = run(&[&["few", "duplicated", "--out", out][..], &techniques].concat());
    let (said, heard) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{}\n{said}\n{heard}", output.status);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
    let results: Results = serde_json::from_str(&read("stress.json")).expect("JSON");
    assert_eq!(verdicts(&results.rows), results.verdicts);
    // Two techniques are tested with two cases.
    assert_eq!((results.verdicts.len(), results.rows.len()), (4, 2 * 3 + 2 * 4));
    assert_eq!(read("stress.csv").lines().count(), 1 + results.rows.len());
    let page = read("stress.html");
    for verdict in &results.verdicts {
        let word = verdict.verdict.as_str();
        assert!(said.contains(word) && page.contains(word) && page.contains(&verdict.technique), "{verdict:?}");
        assert_eq!(verdict.verdict, "holds", "{verdict:?}");
    }
}

/// No technique can meet this time limit: rows must say so, and the run must not fail.
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
    assert_eq!(results.verdicts[0].verdict, "no answer within 0.001 s");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("  no answer within 0.001 s\n") && !said.contains("breaks"), "{said}");
}

/// Rounds of random scenes and techniques must pass and leave nothing on the device; a seed must give the same round, whatever came before.
#[test]
fn rounds_hold_and_leave_nothing() {
    if crate::support::is_costly("rounds_hold_and_leave_nothing") {
        return;
    }
    gpu_test("rounds_hold_and_leave_nothing", |context| {
        let rounds = |seeds: std::ops::Range<u64>| -> Vec<_> {
            let one = |seed| {
                let mut asked = Vec::new();
                let of = round(context, seed, |spec| {
                    asked.push(spec.to_string());
                    Ok(())
                });
                (of.expect("a round"), asked)
            };
            seeds.map(one).collect()
        };
        let all = rounds(0..if all() { 40 } else { 6 });
        for (round, asked) in &all {
            println!("{round:?}: {asked:?}");
            assert!(round.failures.is_empty() && round.asked == asked.len() as u64, "{round:?}");
            // Allocations kept while the device is open must exist from the beginning.
            assert_eq!(round.device_bytes, all[0].0.device_bytes);
        }
        assert!(all.iter().any(|(round, _)| round.asked > round.refused), "somebody answered");
        let again = rounds(3..4).remove(0);
        assert_eq!((again.1, again.0.refused), (all[3].1.clone(), all[3].0.refused));
        // Leftover memory must be found and reported with its seed.
        let mut kept = None;
        let left = round(context, 3, |_| {
            kept = Some(Buffer::new(context, "kept", 4096, Memory::Device)?);
            Ok(())
        });
        let failures = left.expect("a round").failures;
        assert!(failures.len() == 1 && failures[0].seed == 3 && failures[0].broken.contains("of device memory before"));
    });
}

/// Runs one round by its seed and checks its files. Memory held must be reported, unless the system does not tell.
#[test]
fn a_soak_writes_what_it_finds() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = run(&["--soak", "0", "--seed", "3", "--out", out]);
    assert!(output.status.success(), "{output:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
    let soaked: Soaked = serde_json::from_str(&read("soak.json")).expect("JSON");
    let [life] = &soaked.lives[..] else { panic!("one device: {soaked:?}") };
    assert_eq!((soaked.seed, soaked.rounds, life.rounds, soaked.processes), (3, 1, 1, 1));
    assert!(soaked.asked > 0 && soaked.failures.is_empty() && life.host_bytes.is_some() == cfg!(target_os = "linux"));
    assert!(read("soak.html").contains("1 rounds from seed 3") && soaked.is_flat.is_none());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("1 rounds") && said.contains("0 failures"), "{said}");
}

/// A sweep of a scene must start from the scene itself, and apply changes to it only.
#[test]
fn scenes_are_swept() {
    let of = |scene: &str, change: &str, value: f64| {
        let sweeps = Sweep::named(scene).expect("a scene").0;
        sweeps.iter().find(|sweep| sweep.name == format!("{scene}/{change}")).expect(change).scene(value)
    };
    let plain = of("big-8k", "as-it-is", 1.0);
    assert!(plain.particles.len() > 8000);
    for (change, mildest) in [("extinction", 1.0), ("extinction-low", 1.0), ("origin", 0.0), ("radius-large", 1.0)] {
        assert!(of("big-8k", change, mildest) == plain, "{change}");
    }
    let (thick, wide) = (of("big-8k", "extinction", 1e38), of("big-8k", "radius-small", 0.5));
    let pairs = || plain.particles.iter().zip(thick.particles.iter().zip(&wide.particles));
    // Capped at the largest float.
    let most = |p: &Particle| (1e38 * f64::from(p.extinction)).min(f32::MAX.into()) as f32;
    assert!(pairs().all(|(p, (t, _))| t.extinction == most(p) && t.extinction > 1e3 * p.extinction));
    assert!(pairs().all(|(p, (t, w))| t.radius == p.radius && w.radius == 0.5 * p.radius && t.position == p.position));
    let mixed = of("big-8k", "extinction-mixed", 1e3);
    assert!(mixed.particles.chunks_exact(2).all(|pair| (pair[0].extinction, pair[1].extinction) == (1e3, 0.0)));
    // Doubling the hair's extinction must square its transmittance.
    let (hair, twice) = (of("hair", "as-it-is", 1.0), of("hair", "extinction", 2.0));
    for (one, two) in hair.strands.iter().zip(&twice.strands) {
        assert!(((1.0 - one.opacity).powi(2) - (1.0 - two.opacity)).abs() < 1e-6, "{one:?} {two:?}");
    }
    // Light and camera must move with the scene; a scene of meshes alone has no extinction to sweep.
    let far = of("cornell", "origin", 10.0);
    let near = of("cornell", "as-it-is", 1.0);
    let by = far.camera.position - near.camera.position;
    assert!(
        by.length() > 10.0 && far.lights[0].position().zip(near.lights[0].position()).is_none_or(|(a, b)| a - b == by)
    );
    assert!(Sweep::named("cornell").expect("a scene").0.iter().all(|sweep| !sweep.name.contains("extinction")));
    // The name of a case must not expand to changes of a scene.
    assert_eq!(Sweep::named("few").expect("a case").0.len(), 1);
}

/// A technique that casts from nothing in the scene must be refused, and the row must name what it casts from.
#[test]
fn who_casts_from_nothing_is_refused() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = run(&["few", "--technique", "shadow-map:size=32", "--out", out]);
    assert!(output.status.success(), "{output:?}");
    let json = std::fs::read_to_string(folder.path().join("stress.json")).expect("JSON");
    let results: Results = serde_json::from_str(&json).expect("JSON");
    let [row] = &results.rows[..] else { panic!("once: {:?}", results.rows) };
    assert_eq!(row.outcome, Outcome::Refused);
    assert!(row.reason.contains("needs meshes in the scene"), "{}", row.reason);
    assert!(String::from_utf8_lossy(&output.stdout).contains(&row.reason));
}

/// A worker that panics must say so in its last line, which becomes the reason of its row.
#[test]
fn a_panic_is_one_line() {
    let job = r#"{"Value":{"sweep":"duplicated","given":null,"value":1e300,"techniques":[]}}"#;
    let mut worker = program(&["--worker"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let worker = worker.as_mut().expect("the program starts");
    let mut jobs = worker.stdin.take().expect("a pipe");
    writeln!(jobs, "{job}").expect("it listens");
    drop(jobs);
    let (mut heard, mut said) = (String::new(), String::new());
    worker.stdout.take().expect("a pipe").read_to_string(&mut said).expect("UTF-8");
    worker.stderr.take().expect("a pipe").read_to_string(&mut heard).expect("UTF-8");
    assert!(!worker.wait().expect("it ends").success() && said.lines().count() == 1, "{said}");
    let last = heard.lines().last().unwrap_or_default();
    assert!(last.contains("panicked at") && last.contains("capacity overflow"), "{heard}");
}

#[test]
fn what_cannot_be_asked_is_one_line() {
    let all: [(&[&str], &str); 5] = [
        (&["no-such-case"], "no such case or scene; choose one of: extinction"),
        (&["no-such-file.ply"], "no-such-file.ply"),
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
