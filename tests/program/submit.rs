//! `submit`: contents of its file and its table, reasons to mark a file, and the files of results/community.

use crate::errors::fails;
use crate::support::{all, gpu_test, log};
use crate::{folder, gobo, ok, run, runs, text};
use gobo::bench::{Results, Row, Status, Submission, answers_hash, standard};
use gobo::report::submission_table;
use std::path::{Path, PathBuf};
use std::process::Output;

/// Returns earlier submissions, at least one.
fn community() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/community");
    let entries = std::fs::read_dir(folder).expect("there").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|ending| ending == "json")).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

/// Runs a small submission with an environment variable set.
fn submitted(out: &Path, variable: (&str, &str), more: &[&str]) -> (Submission, Output) {
    let mut command = gobo();
    command.args(["submit", "-o", text(out)]).args(more).env("GOBO_TEST_LITTLE", "1").env(variable.0, variable.1);
    let output = command.output().expect("it starts");
    (Submission::read(out).unwrap_or_else(|error| panic!("{error}: {output:?}")), output)
}

#[test]
fn a_file_and_a_table() {
    if crate::support::is_costly("a_file_and_a_table") {
        return;
    }
    log("exercised", "a_file_and_a_table", &runs("avsm", "two-pass").0);
    let folder = folder();
    let out = folder.path().join("mine.json");
    let (submission, output) = submitted(&out, ("VK_INSTANCE_LAYERS", ""), &[]);
    let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{complained}");
    let Results { rows, device, command, .. } = &submission.results;
    assert_eq!(submission.answers, rows.iter().map(answers_hash).collect::<Vec<_>>());
    assert!(!rows.is_empty() && rows.iter().all(|row| row.status != Status::Failed));
    assert!(submission.seconds > 0.0 && submission.failed.is_empty() && submission.layers.is_empty());
    let is_hash = submission.commit.len() == 40 && submission.commit.chars().all(|c| c.is_ascii_hexdigit());
    assert!(is_hash || submission.commit == "unknown", "{}", submission.commit);
    // All lines of the table must have the same number of columns, and one line per row.
    let table: Vec<&str> = said.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(table.len(), rows.len() + 2);
    assert!(table.iter().all(|line| line.replace("\\|", "").matches('|').count() == 10), "{said}");
    for (row, line) in rows.iter().zip(&table[2..]) {
        assert!(line.starts_with(&format!("| {} | {}", row.scene, row.technique)), "{line}");
    }
    assert!(said.starts_with(&format!("**{}**", device.name)) && said.contains(&submission.commit), "{said}");
    assert!(said.contains("results/community/") && said.contains("Nothing was sent"), "{said}");
    // The file must not depend on its location; the program must say that so small a file is listed but not counted.
    let json = std::fs::read_to_string(&out).expect("written");
    assert!(command == "gobo submit" && !json.contains(text(folder.path())));
    assert!(complained.contains("listed and not counted: it has no row of hair"), "{complained}");

    // Anything that changes features must be reported; with `--json`, the file itself must be printed.
    let (lesser, output) = submitted(&out, ("GOBO_TEST_LIMITS", "lowest"), &["--json"]);
    assert_eq!(serde_json::from_slice::<Submission>(&output.stdout).expect("JSON alone"), lesser);
    assert!(lesser.layers.iter().any(|tool| tool.changes_features), "{:?}", lesser.layers);
    assert!(lesser.marks().expect("built in").iter().any(|mark| mark.contains("may change features")));
    assert!(submission_table(&lesser).contains("; layers: tests of Gobo"));
}

/// Applies every kind of change for which a file that counts must be marked.
#[test]
fn what_is_marked() {
    if crate::support::is_costly("what_is_marked") {
        return;
    }
    let counted =
        |path: &PathBuf| Submission::read(path).ok().filter(|s| s.marks().is_ok_and(|marks| marks.is_empty()));
    let good = community().iter().find_map(counted).expect("a file that counts");
    /// Changes a submission.
    type Change = fn(&mut Submission);
    let error_of =
        |row: &mut Row| row.error.as_mut().and_then(|error| error.space.as_mut()).map(|space| space.mean_abs *= 2.0);
    let cases: [(&str, Change); 10] = [
        ("no commit", |s| s.commit = "unknown".into()),
        ("no commit", |s| s.changed = true),
        ("the layer VK_LAYER_x, which may change features", |s| s.environment.push("VK_LAYER_x".into())),
        ("tool may change features", |s| {
            s.layers.push(gobo::gpu::Tool { name: "tool".into(), version: "1".into(), changes_features: true });
        }),
        ("under the validation layer", |s| s.validation = true),
        ("VUID-x: wrong", |s| s.failed.push("VUID-x: wrong".into())),
        ("1 rows failed", |s| s.results.rows[0].status = Status::Failed),
        ("scene hair was 0", |s| drop(s.results.conditions.insert("scene hair".into(), "0".into()))),
        ("--frames was not known", |s| drop(s.results.conditions.remove("--frames"))),
        ("no row of houses", |s| {
            let kept = |row: &Row| row.scene != "houses";
            let keep: Vec<bool> = s.results.rows.iter().map(kept).collect();
            s.results.rows.retain(kept);
            let mut keep = keep.into_iter();
            s.answers.retain(|_| keep.next() == Some(true));
        }),
    ];
    for (mark, change) in cases {
        let mut changed = good.clone();
        change(&mut changed);
        let marks = changed.marks().expect("built in");
        assert!(marks.len() == 1 && marks[0].contains(mark), "{mark}: {marks:?}");
    }
    // An error edited by hand, then one with its hash edited too.
    let mut forged = good.clone();
    let place = forged.results.rows.iter().position(|row| row.status == Status::Ok).expect("measured");
    error_of(&mut forged.results.rows[place]);
    assert_eq!(
        forged.marks().expect("built in"),
        [format!("the errors of row {} are not those that were hashed", place + 1)]
    );
    forged.answers[place] = answers_hash(&forged.results.rows[place]);
    assert!(forged.marks().expect("built in").is_empty());
    let folder = folder();
    let path = folder.path().join("forged.json");
    std::fs::write(&path, serde_json::to_string(&forged).expect("JSON")).expect("written");
    let output =
        gobo().args(["submit", "--check", text(&path)]).env("GOBO_TEST_LITTLE", "1").output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success() && said.matches("marked:").count() == 1, "{output:?}");
    assert!(said.contains("mean space error"), "{said}");

    let write = |text: &str| std::fs::write(&path, text).expect("written");
    write("{");
    fails(&["submit", "--check", text(&path)], &["forged.json", "no whole submission"]);
    write(&serde_json::to_string(&Submission { submission: 9, ..good.clone() }).expect("JSON"));
    fails(&["submit", "--check", text(&path)], &["forged.json", "format 9", "gobo submit"]);
    // Nothing may be measured if the results cannot be written.
    fails(&["submit", "-o", text(&folder.path().join("none/f.json"))], &["none/f.json", "its folder is not there"]);
    fails(&["submit", "-o", text(folder.path())], &["it is a folder"]);
    assert_eq!(run(&["submit", "--check", text(&path), "-o", "x"]).status.code(), Some(2));
    assert!(ok(&["help", "submit"]).contains("--check"));
}

/// Each file of results/community must be valid, its errors are recomputed here, and the README must list what counts.
#[test]
fn community_files() {
    if crate::support::is_costly("community_files") {
        return;
    }
    let files = community();
    let read: Vec<Submission> = files.iter().map(|path| Submission::read(path).expect("a submission")).collect();
    let few: Option<(usize, &[&str])> = if all() { None } else { Some((2, &["plume_8k", "cornell"])) };
    gpu_test("community_files", |context| {
        let again = standard::again(context, &read.iter().collect::<Vec<_>>(), few).expect("measured");
        let mut table = String::from("| file | device | driver | rows | took | counts |\n|---|---|---|---|---|---|\n");
        for ((path, submission), again) in files.iter().zip(&read).zip(&again) {
            let mut marks = submission.marks().expect("built in");
            println!("{}: {} rows agree\n{}", path.display(), again.agree, again.against.join("\n"));
            assert!(again.agree + again.against.len() > 0, "{}", path.display());
            if !again.against.is_empty() {
                marks.push("errors are others by now".into());
            }
            let counts = if marks.is_empty() { "yes".into() } else { format!("no: {}", marks.join("; ")) };
            let (name, device) = (path.file_name().expect("a name").to_string_lossy(), &submission.results.device);
            let measured = submission.results.rows.iter().filter(|row| row.status == Status::Ok).count();
            table += &format!(
                "| [{name}]({name}) | {} | {} | {measured} | {:.0} s | {counts} |\n",
                device.name, device.driver, submission.seconds
            );
        }
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/community/README.md");
        let text = std::fs::read_to_string(&page).expect("there");
        let (before, rest) = text.split_once("<!-- files -->\n").expect("where the table begins");
        let (_, after) = rest.split_once("<!-- /files -->").expect("where it ends");
        let new = format!("{before}<!-- files -->\n{table}<!-- /files -->{after}");
        if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
            std::fs::write(&page, &new).expect("written");
        } else {
            assert!(
                new == text,
                "GOBO_WRITE_TABLES=1 cargo test --release --test program community writes it anew:\n{table}"
            );
        }
    });
}
