//! Checks the choices in docs/guide/choose.md: no other row of the same scene, device and kind of picture that is within the budget may
//! have both a shorter time for a build and look-ups and a smaller seen error.

use super::list::commands;
use super::rows::{Rows, Which};
use gobo::technique::{Lifetime, REGISTRY};
use std::collections::BTreeMap;
use std::path::Path;

/// Relative difference between runs of one row.
const NOISE: f64 = 0.02;
/// Largest error that counts as exact: rounding only.
const EXACT: f64 = 1e-4;
/// Options of `gobo compare` that change what a frame is: times are only compared if these agree.
const FRAMES: [&str; 7] = ["--picture", "--moving", "--turn", "--lights", "--vpls", "--bounce", "--quick"];

/// A row of the page.
struct Choice<'a> {
    need: &'a str,
    budget: &'a str,
    spec: &'a str,
    scene: &'a str,
    folder: &'a str,
    file: &'a str,
}

/// Time, seen error and bytes.
type Figures = [f64; 3];

/// Parses the choices from the recipes of a page.
fn choices(page: &str) -> Vec<Choice<'_>> {
    let mut all = Vec::new();
    for recipe in page.split("<!-- rows ").skip(1).filter_map(|rest| rest.split("-->").next()) {
        let shorts: BTreeMap<&str, (&str, &str)> = recipe
            .lines()
            .filter(|line| !line.contains('|'))
            .filter_map(|line| line.split_once(" = "))
            .filter_map(|(name, what)| Some((name, what.split_once(" in ")?)))
            .collect();
        for line in recipe.lines().filter(|line| line.starts_with("scene=")) {
            let cells: Vec<&str> = line.split(" | ").map(str::trim).collect();
            let [scene, need, budget, shown, named, ..] = cells[..] else { panic!("{line}") };
            let name = line.split("{cost ").nth(1).and_then(|rest| rest.split('}').next()).expect(line);
            let (spec, path) = shorts[name];
            let (folder, file) = path.split_once('/').expect(path);
            let scene = scene.trim_start_matches("scene=");
            assert_eq!(shown.split('`').nth(1), Some(spec), "{need}: the row is of another spec");
            let device = folder.trim_start_matches("nvidia-").to_uppercase();
            assert_eq!(named, format!("{scene}, {device}"), "{need}");
            all.push(Choice { need, budget, spec, scene, folder, file });
        }
    }
    all
}

/// Whether figures are within a budget: `4 MiB`, `2 ms` or `exact`. Since budgets are rounded, figures may exceed them by 2 %.
fn is_within(budget: &str, [time, error, bytes]: Figures) -> bool {
    let (number, unit) = budget.split_once(' ').unwrap_or(("", budget));
    let limit = || 1.02 * number.parse::<f64>().expect(budget);
    match unit {
        "MiB" => bytes / 1048576.0 <= limit(),
        "ms" => time <= limit(),
        "exact" => error < EXACT,
        _ => panic!("{budget} is no budget"),
    }
}

/// Whether figures are better in both time and error.
fn beats(other: Figures, own: Figures) -> bool {
    (0..2).all(|i| other[i] < own[i] * (1.0 - NOISE))
}

/// Returns the options that change what a frame is, with their values, from the command that made a file.
fn kind(arguments: &str) -> Vec<String> {
    let words: Vec<&str> = arguments.split_whitespace().collect();
    let found = |option: &&str| {
        let at = words.iter().position(|word| word == option)?;
        let value = words.get(at + 1).filter(|word| !word.starts_with("--")).copied().unwrap_or_default();
        Some(format!("{option} {value}"))
    };
    FRAMES.iter().filter_map(found).collect()
}

#[test]
fn no_row_beats_a_choice() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/guide/choose.md")).expect("the page");
    let list = std::fs::read_to_string(root.join("results/commands.txt")).expect("the list");
    let kinds: BTreeMap<String, Vec<String>> = commands(&list)
        .into_iter()
        .filter(|(devices, ..)| devices.split(',').any(|device| device == "gpu"))
        .map(|(_, name, arguments)| (name, kind(&arguments)))
        .collect();
    let mut files: BTreeMap<String, Rows> = BTreeMap::new();
    let mut off = Vec::new();
    let choices = choices(&page);
    for choice in &choices {
        let Choice { need, budget, spec, scene, folder, file } = *choice;
        let columns = ["painted", "seen_mean", "resident"];
        let in_folder = std::fs::read_dir(root.join("results").join(folder)).expect(folder);
        let names = in_folder
            .filter_map(|entry| entry.expect("an entry").file_name().to_str()?.strip_suffix(".csv").map(str::to_owned));
        let alike: Vec<String> =
            names.filter(|name| kinds[name] == kinds[file]).map(|n| format!("{folder}/{n}")).collect();
        for path in &alike {
            files.entry(path.clone()).or_insert_with(|| Rows::read(root, path).expect(path));
        }
        let rows = &files[&format!("{folder}/{file}")];
        let own = columns.map(|column| rows.value(&Which { scene, spec }, column).expect(spec));
        if !is_within(budget, own) {
            off.push(format!("{need}: {spec} is not within {budget}: {own:?}"));
        }
        for path in &alike {
            for (variant, _, figures) in files[path].all(scene, columns) {
                let name = variant.split(':').next().unwrap_or_default();
                let entry = REGISTRY.iter().find(|entry| entry.name == name);
                let moves =
                    matches!(entry.map(|entry| entry.lifetime), Some(Lifetime::Baked)) && !need.contains("still");
                if !moves && name != "none" && is_within(budget, figures) && beats(figures, own) {
                    off.push(format!("{need}, {budget}: {spec} {own:?} is beaten by {path}: {variant} {figures:?}"));
                }
            }
        }
    }
    assert!(choices.len() > 12, "{} choices: where are the others?", choices.len());
    assert!(off.is_empty(), "{}", off.join("\n"));
    // The techniques that README.md names first must be among the choices.
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let answer = readme.split("## The answer first").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("it");
    let named: Vec<&str> = answer.split('`').skip(1).step_by(2).collect();
    assert!(named.len() > 4, "{named:?}");
    for name in named {
        let is_choice = |choice: &Choice| choice.spec.split(':').next() == name.split(':').next();
        assert!(choices.iter().any(is_choice), "README.md names {name}, and choose.md does not");
    }
}

#[test]
fn a_better_row_is_found() {
    let own = [2.0, 0.01, 4.0 * 1048576.0];
    assert!(beats([1.9, 0.009, 1e9], own));
    assert!(!beats([1.99, 0.001, 0.0], own) && !beats([1.0, 0.01, 0.0], own));
    assert!(is_within("4 MiB", own) && is_within("2 ms", own));
    assert!(!is_within("3.9 MiB", own) && !is_within("1.9 ms", own) && !is_within("exact", own));
    assert_eq!(kind("compare a --quick --frames 3 --moving 20..21 --technique x"), ["--moving 20..21", "--quick "]);
}
