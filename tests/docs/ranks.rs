//! Whether seen error and surface error say what an eye sees: the tables of ranks in docs/notebook/truth.md, from the rows they speak of.

use gobo::measure::spearman;
use std::collections::BTreeMap;
use std::path::Path;

const DEVICES: [(&str, &str, &[&str]); 2] = [
    ("nvidia-h200", "H200", &["opaque", "opaque-vpls"]),
    ("lavapipe-22.3", "lavapipe 22.3", &["opaque", "opaque-courtyard", "opaque-vpls"]),
];

const SCENES: [&str; 6] = ["houses", "town", "courtyard", "cornell", "courtyard-256-vpls", "cornell-256-vpls"];

#[test]
fn ranks_of_surface_error_and_flip() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/notebook/truth.md")).expect("the page");
    for (folder, device, files) in DEVICES {
        let mut scenes: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
        for file in files {
            let path = root.join("results").join(folder).join(file).with_extension("csv");
            for row in csv::Reader::from_path(&path).expect(folder).deserialize() {
                let row: BTreeMap<String, String> = row.expect("a row");
                let number = |column: &str| row[column].parse::<f64>().ok();
                if let (Some(error), Some(flip)) = (number("surface_mean_abs"), number("image_flip_mean")) {
                    scenes.entry(row["scene"].clone()).or_default().push((error, flip));
                }
            }
        }
        assert!(scenes.keys().all(|scene| SCENES.contains(&scene.as_str())), "{folder}: {:?}", scenes.keys());
        let all = scenes.values().flatten().copied().collect::<Vec<_>>();
        let rank = |pairs: &[(f64, f64)]| spearman(pairs).expect("rows that differ");
        assert!(all.len() >= 40 && rank(&all) >= 0.9, "{folder}: {} over {} rows", rank(&all), all.len());
        let single = SCENES.map(|scene| format!(" | {:.2}", rank(&scenes[scene]))).concat();
        let line = format!("| {device} | {:.2} of {} rows{single} |", rank(&all), all.len());
        assert!(page.contains(&line), "docs/notebook/truth.md has no line\n{line}");
    }
}

/// A row's technique, seen error and FLIP.
type Seen = (String, f64, f64);

#[test]
fn ranks_of_seen_error_and_flip() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/notebook/truth.md")).expect("the page");
    let mut scenes: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
    for file in ["seen", "seen-more", "seen-meshes"] {
        let path = root.join("results/nvidia-h200").join(file).with_extension("csv");
        for row in csv::Reader::from_path(&path).expect(file).deserialize() {
            let row: BTreeMap<String, String> = row.expect("a row");
            let number = |column: &str| row[column].parse::<f64>().ok();
            if let (Some(seen), Some(flip)) = (number("seen_mean"), number("image_flip_mean")) {
                scenes.entry(row["scene"].clone()).or_default().push((row["technique"].clone(), seen, flip));
            }
        }
    }
    let rank = |rows: &[Seen], noise: bool| {
        let wanted = rows.iter().filter(|(technique, ..)| noise || technique != "stochastic");
        spearman(&wanted.map(|(_, seen, flip)| (*seen, *flip)).collect::<Vec<_>>()).expect("rows that differ")
    };
    let near = scenes.values().filter(|rows| rank(rows, true) >= 0.95).count();
    assert_eq!((scenes.len(), near), (11, 9));
    for (scene, rows) in &scenes {
        let line = format!("| {scene} | {} | {:.3} | {:.3} |", rows.len(), rank(rows, true), rank(rows, false));
        assert!(page.contains(&line), "docs/notebook/truth.md has no line\n{line}");
    }
}
