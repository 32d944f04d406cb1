//! Whether seen error and surface error agree with the eye: checks the tables of ranks in docs/notebook/truth.md against the measured rows.

use gobo::bench::spearman;
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

/// Devices whose rows have both seen error and FLIP in eleven scenes, their files, and the number of scenes with a rank correlation of at
/// least 0.95.
const SEEN: [(&str, &[&str], usize); 2] =
    [("nvidia-h200", &["seen", "seen-more", "seen-meshes"], 9), ("lavapipe-22.3", &["seen"], 9)];

/// The errors and the FLIP of a row.
struct Seen {
    technique: String,
    error: f64,
    standard_error: f64,
    flip: f64,
}

/// Returns the rank correlation of seen error and FLIP.
fn rank_of<'a>(rows: impl Iterator<Item = &'a Seen>) -> f64 {
    spearman(&rows.map(|row| (row.error, row.flip)).collect::<Vec<_>>()).expect("rows that differ")
}

/// Whether both measures separate two rows: seen errors by more than twice the standard error of their difference, FLIP by more than 2 %.
fn is_clear(a: &Seen, b: &Seen) -> bool {
    (a.error - b.error).abs() > 2.0 * a.standard_error.hypot(b.standard_error)
        && (a.flip - b.flip).abs() > 0.02 * a.flip.max(b.flip)
}

/// Returns the number of clearly separated pairs of rows, and the number of these that both measures rank in the same order.
fn clear_pairs(rows: &[Seen]) -> (usize, usize) {
    let (mut clear, mut same) = (0, 0);
    for (i, a) in rows.iter().enumerate() {
        for b in rows[..i].iter().filter(|b| is_clear(a, b)) {
            clear += 1;
            same += usize::from((a.error < b.error) == (a.flip < b.flip));
        }
    }
    (clear, same)
}

#[test]
fn ranks_of_seen_error_and_flip() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/notebook/truth.md")).expect("the page");
    for (folder, files, wanted) in SEEN {
        let mut scenes: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
        for file in files {
            let path = root.join("results").join(folder).join(file).with_extension("csv");
            for row in csv::Reader::from_path(&path).expect(file).deserialize() {
                let row: BTreeMap<String, String> = row.expect("a row");
                let number = |column: &str| row[column].parse::<f64>().ok();
                let (Some(error), Some(flip)) = (number("seen_mean"), number("image_flip_mean")) else { continue };
                let standard_error = number("seen_standard_error").expect("beside seen error");
                let seen = Seen { technique: row["technique"].clone(), error, standard_error, flip };
                scenes.entry(row["scene"].clone()).or_default().push(seen);
            }
        }
        let near = scenes.values().filter(|rows| rank_of(rows.iter()) >= 0.95).count();
        assert_eq!((scenes.len(), near), (11, wanted), "{folder}");
        for (scene, rows) in &scenes {
            let all = rank_of(rows.iter());
            let without = rank_of(rows.iter().filter(|row| row.technique != "stochastic"));
            let (clear, same) = clear_pairs(rows);
            let share = 100.0 * same as f64 / clear as f64;
            let line =
                format!("| {scene} | {} | {all:.3} | {without:.3} | {same} of {clear} | {share:.1} |", rows.len());
            assert!(page.contains(&line), "docs/notebook/truth.md has no line of {folder}\n{line}");
        }
    }
}
