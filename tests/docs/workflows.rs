//! The workflows of .github: everything that they run must exist, and the one for users to copy must work as described.

use crate::commands::run;
use crate::support::ASKED;
use std::path::Path;

fn workflow(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(".github/workflows").join(name);
    std::fs::read_to_string(path).expect(name)
}

/// Returns the commands that a workflow runs, in order.
fn commands(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.trim().strip_prefix("- run: ")).flat_map(|line| line.split(" && ")).collect()
}

/// The new program must be compared with the earlier one, in that order, with options that exist, and uploaded files must be written.
#[test]
fn the_workflow_to_copy_runs() {
    let text = workflow("compare.yml");
    assert!(text.lines().count() <= 18, "short enough to copy");
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let mut ran = Vec::new();
    for command in commands(&text) {
        let words: Vec<&str> = command.split_whitespace().collect();
        if words[0].starts_with("./") {
            assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(words[0]).is_file(), "{command}");
        }
        let Some(program) = words[0].strip_prefix("/tmp/") else { continue };
        let built = commands(&text).iter().any(|other| *other == format!("cp target/release/gobo /tmp/{program}"));
        assert!(built, "{command}: it was not built");
        let (said, error, is_ok) = run(folder.path(), &format!("gobo {}", words[1..].join(" ")));
        assert!(is_ok, "{command}: {said}{error}");
        ran.push(program);
    }
    assert_eq!(ran, ["before", "change"]);
    for name in ["report.html", "results.json", "junit.xml", "bencher.json"] {
        assert!(folder.path().join("report").join(name).is_file(), "{name} is not uploaded");
    }
}

/// The released program must be the one described in docs/guide/start.md: without the window.
#[test]
fn a_release_is_what_start_says() {
    let text = workflow("release.yml");
    let all = commands(&text);
    assert!(all.contains(&"cargo build --release --locked"), "{all:?}");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let packed = all.iter().find(|command| command.starts_with("tar ")).expect("it is packed");
    assert!(packed.contains("README.md") && packed.contains("LICENSE-*") && root.join("LICENSE-MIT").is_file());
    let start = std::fs::read_to_string(root.join("docs/guide/start.md")).expect("a page");
    assert!(start.contains("release.yml") && start.contains("without `view`"));
}

/// Tests that take seconds are skipped unless requested, so each CI stage that runs tests must request them.
#[test]
fn stages_of_ci_ask_for_costly_tests() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/run")).expect(".ci/run");
    let text = text.replace("\\\n", " ");
    let asks = |line: &str| ASKED.iter().any(|name| line.contains(&format!("GOBO_TEST_{name}=")));
    let cases: Vec<&str> = text.lines().filter(|line| line.contains("cases=(")).collect();
    assert!(cases.len() == 2 && cases.iter().all(|line| asks(line)), "{cases:?}");
    let stages: Vec<&str> = text.lines().map(str::trim).filter(|line| line.starts_with("tests \"")).collect();
    assert!(stages.len() >= 9, "{stages:?}");
    for stage in stages {
        assert!(asks(stage) || stage.contains("\"${cases[@]}\""), "{stage}");
    }
}
