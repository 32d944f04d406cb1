//! results/commands.txt, the list of commands that create the CSV files: it must be complete, and name only things that exist.

use gobo::scene::Scene;
use gobo::shading::parse;
use std::path::Path;

/// Folders of results, and the kind of device that measured them.
const FOLDERS: [(&str, &str); 5] = [
    ("nvidia-h200", "gpu"),
    ("nvidia-h100", "gpu"),
    ("lavapipe-22.3", "lavapipe"),
    ("lavapipe-26.1", "lavapipe"),
    ("swiftshader", "swiftshader"),
];

/// Parses kinds, name and arguments of each command; indented lines continue the previous one.
pub fn commands(text: &str) -> Vec<(String, String, String)> {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
        match (line.starts_with(' '), lines.last_mut()) {
            (true, Some(last)) => *last += line,
            _ => lines.push(line.to_owned()),
        }
    }
    let split = |line: &String| {
        let mut words = line.splitn(3, ' ');
        let mut word = || words.next().unwrap_or_default().to_owned();
        let (kinds, name) = (word(), word());
        (kinds, name.split('=').next().unwrap_or_default().to_owned(), word())
    };
    lines.iter().map(split).collect()
}

#[test]
fn every_csv_has_its_command() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let commands = commands(&std::fs::read_to_string(results.join("commands.txt")).expect("the list"));
    assert!(commands.len() > 40, "{} commands", commands.len());
    for (folder, kind) in FOLDERS {
        for entry in std::fs::read_dir(results.join(folder)).expect(folder) {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|ending| ending == "csv") {
                let stem = path.file_stem().expect("a name").to_string_lossy();
                let makes =
                    |(kinds, name, _): &&(String, String, String)| *name == stem && kinds.split(',').any(|k| k == kind);
                assert_eq!(commands.iter().filter(makes).count(), 1, "{folder}/{stem}.csv");
            }
        }
    }
    let mut scenes = std::collections::BTreeSet::new();
    for (_, name, arguments) in &commands {
        // No quoted word here contains a blank.
        let words: Vec<String> = arguments.split_whitespace().map(|word| word.replace('\'', "")).collect();
        scenes.extend(words.iter().skip(1).take_while(|word| !word.starts_with("--")).cloned());
        for pair in words.windows(2).filter(|pair| pair[0] == "--technique") {
            assert!(parse(&pair[1]).is_ok(), "{name}: {}", pair[1]);
        }
    }
    // Scenes with millions of casters are created elsewhere, and the repository does not contain all of $FILES.
    let elsewhere =
        |scene: &str| scene.starts_with("fountain") || scene.ends_with("-1m") || scene.starts_with("$FILES/");
    for scene in scenes.iter().filter(|scene| !elsewhere(scene)) {
        assert!(Scene::load(scene, 20.0).is_ok(), "{scene}");
    }
}
