//! Follows docs/guide/add-a-technique.md to the letter in a copy of the repository: the toy technique must appear in `compare` and keep its
//! promises; a variant that breaks a promise must be caught.

#![cfg(feature = "program")]

mod support;

use std::path::Path;
use std::process::Command;
use support::{all, log, skipped};

/// Returns the page's code blocks: the line before each, which names where it goes, and its text.
fn blocks(page: &str) -> Vec<(String, String)> {
    let (mut blocks, mut said, mut open): (Vec<(String, String)>, String, Option<String>) = Default::default();
    for line in page.lines() {
        match (&mut open, line.starts_with("```")) {
            (None, true) => open = Some(String::new()),
            (Some(text), true) => {
                blocks.push((said.clone(), std::mem::take(text)));
                open = None;
            }
            (Some(text), false) => *text += &format!("{line}\n"),
            (None, false) if !line.trim().is_empty() => said = line.to_owned(),
            (None, false) => {}
        }
    }
    blocks
}

/// Splits the line at backquotes, and returns piece `at`; piece 0 is the text before the first backquote.
fn quoted(line: &str, at: usize) -> &str {
    line.split('`').nth(at).unwrap_or_else(|| panic!("{line}: no name in backquotes"))
}

/// Writes the page's blocks into the copy of the repository.
fn follow(page: &str, toy: &Path) {
    let mut files = Vec::new();
    for (said, text) in blocks(page) {
        if said.starts_with('`') && said.ends_with("`:") {
            let file = toy.join(quoted(&said, 1));
            std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
            assert!(!file.exists(), "{} is there already", file.display());
            std::fs::write(&file, text).expect("written");
            files.push(quoted(&said, 1).to_owned());
        } else {
            // In `FILE`, after the line `LINE`:
            assert!(said.starts_with("In `") && said.contains(", after the line `"), "{said}: where does this go?");
            let (file, line) = (toy.join(quoted(&said, 1)), format!("{}\n", quoted(&said, 3)));
            let before = std::fs::read_to_string(&file).expect("there");
            assert_eq!(before.matches(&line).count(), 1, "{said}");
            std::fs::write(&file, before.replace(&line, &format!("{line}{text}"))).expect("written");
            assert_eq!(text.lines().count(), 1, "one line of the registry: {text}");
        }
    }
    assert_eq!(files.len(), 3, "{files:?}");
}

fn copy(from: &Path, to: &Path) {
    // Hard links suffice: linked files are not built again, so nothing writes into them.
    let done = Command::new("cp").args(["-al"]).arg(from).arg(to).status().expect("cp");
    assert!(done.success(), "cp -al {} {}", from.display(), to.display());
}

#[test]
fn a_toy_technique_is_found_and_stressed() {
    let name = "a_toy_technique_is_found_and_stressed";
    if !all() {
        return skipped(name, "it builds the crate once more; GOBO_TEST_ALL=1 runs it");
    }
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    // The copy is next to the target folder, where hard links work.
    let program = Path::new(env!("CARGO_BIN_EXE_gobo"));
    let release = program.parent().expect("a folder");
    let folder = tempfile::tempdir_in(release).expect("a folder");
    let toy = folder.path().join("toy");
    std::fs::create_dir_all(toy.join("target/release")).expect("a folder");
    for file in ["Cargo.toml", "Cargo.lock", "build.rs", "build", "src", "glsl", "examples", ".cargo"] {
        let done = Command::new("cp").arg("-r").arg(repository.join(file)).arg(&toy).status().expect("cp");
        assert!(done.success(), "{file}");
    }
    // Cargo can reuse the dependencies built for this test. The copied manifest names an example but no tests.
    for built in ["build", "deps"] {
        copy(&release.join(built), &toy.join("target/release").join(built));
    }
    // Copied rather than linked, because cargo writes into these files.
    let done = Command::new("cp").arg("-a").arg(release.join(".fingerprint")).arg(toy.join("target/release")).status();
    assert!(done.expect("cp").success(), "the fingerprints are copied");
    // Shaders are not recompiled either. Links are safe here, because the build script replaces files in that folder and never writes into
    // them.
    if release.join("shaders").exists() {
        copy(&release.join("shaders"), &toy.join("target/release/shaders"));
    }
    // Files that are rebuilt must be copies rather than hard links: cargo reuses these folders, and our build script writes into existing
    // files, which would change the repository's own.
    for folder in [".fingerprint", "build", "deps"] {
        for entry in std::fs::read_dir(toy.join("target/release").join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy();
            if name.starts_with("gobo-") || name.starts_with("libgobo-") {
                if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) }
                    .expect("removed");
            }
        }
    }
    if repository.join(".shaderc").exists() {
        copy(&repository.join(".shaderc"), &toy.join(".shaderc"));
    }
    let page = std::fs::read_to_string(repository.join("docs/guide/add-a-technique.md")).expect("the page");
    follow(&page, &toy);
    // Adds a variant that makes the same promises, but uses only the darkest caster.
    let names = [("brute_force", "dim_force"), ("brute-force", "dim-force"), ("BruteForce", "DimForce")];
    let dim = names.iter().fold(page.clone(), |page, (from, to)| page.replace(from, to));
    let sum = "sum += optical_depth;";
    assert_eq!(dim.matches(sum).count(), 1, "{sum}");
    follow(&dim.replace(sum, "sum = max(sum, optical_depth);"), &toy);

    let run = |command: &mut Command| {
        let output = command.current_dir(&toy).output().expect("started");
        let told = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{command:?}\n{told}\n{}", String::from_utf8_lossy(&output.stderr));
        told
    };
    // With this build's features, so that dependencies are not built again.
    let features = if cfg!(feature = "view") { "program,view" } else { "program" };
    // Also builds an example: without one, cargo omits features that tests request of dependencies, and builds those again. Our own code is
    // slightly optimized, since the truth of `stress` otherwise takes minutes.
    let targets = ["--bin", "gobo", "--example", "engine"];
    let [fast, bare] = ["opt-level=1", "debug=false"].map(|setting| format!("profile.release.package.gobo.{setting}"));
    let build = ["build", "--release", "--offline", "--features", features, "--config", &fast, "--config", &bare];
    let build = build.into_iter().chain(targets);
    run(Command::new(env!("CARGO")).args(build).env_remove("CARGO_TARGET_DIR"));
    let toy_program = toy.join("target/release/gobo");
    let gobo = |arguments: &str| {
        let mut gobo = match std::env::var_os("GOBO_RUNNER") {
            Some(runner) => {
                let mut command = Command::new(runner);
                command.arg(&toy_program);
                command
            }
            None => Command::new(&toy_program),
        };
        gobo.args(arguments.split_whitespace());
        gobo
    };
    let commands: Vec<_> = page.lines().filter_map(|l| l.strip_prefix("    cargo run --release -- ")).collect();
    let [compare, stress] = commands[..] else { panic!("two commands: {commands:?}") };
    let table = run(gobo(compare).arg("--validation"));
    let row = table.lines().find(|l| l.contains("brute-force")).unwrap_or_else(|| panic!("no such row:\n{table}"));
    assert!(row.contains("compute"), "{row}");
    let verdicts = |table: &str, of: &str| -> Vec<String> {
        table.lines().filter(|line| line.trim_start().starts_with(of)).map(str::to_owned).collect()
    };
    let held = verdicts(&run(&mut gobo(stress)), "brute-force:size=32");
    assert!(held.len() == 3 && held.iter().all(|line| line.ends_with("  holds")), "{held:?}");
    // The toy technique must be stressed even if it is not named.
    assert_eq!(verdicts(&run(&mut gobo("stress few")), "brute-force:size=32").len(), 1);
    let dim = gobo(&stress.replace("brute-force", "dim-force")).current_dir(&toy).output().expect("started");
    let caught = verdicts(&String::from_utf8_lossy(&dim.stdout), "dim-force:size=32");
    assert!(!dim.status.success() && caught.iter().any(|line| line.contains("tail off by")), "{caught:?}");
    log("exercised", name, "the device of `gobo compare`");
}
