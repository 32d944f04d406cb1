//! Pareto fronts: rows that no other row beats in both an error and a cost. Checks the marks after frame times and the table of all fronts
//! in docs/notebook/all.md, and the fronts of opaque casters in docs/notebook/opaque.md. `GOBO_WRITE_TABLES=1` writes the tables.

use super::rows::{Rows, Which};
use super::tables::WRITING;
use std::path::{Path, PathBuf};

/// A scene's letter in the table's recipe, its name, and the file with its rows.
const SCENES: [(&str, &str, &str); 5] = [
    ("p", "plume_8k", "nvidia-h200/all"),
    ("k", "plume_64k", "nvidia-h200/all"),
    ("b", "big-8k", "nvidia-h200/all"),
    ("m", "three-emitters", "nvidia-h200/all-moving"),
    ("h", "hair", "nvidia-h200/all"),
];

const PLANES: [(&str, &str); 6] = [
    ("map.error", "build"),
    ("map.error", "frame"),
    ("map.error", "resident"),
    ("space.error", "build"),
    ("space.error", "frame"),
    ("space.error", "resident"),
];

const BEGIN: &str = "<!-- fronts -->\n";
const END: &str = "<!-- /fronts -->";

/// The scenes of docs/notebook/opaque.md: letter, name, and file in the device's folder.
const OPAQUE_SCENES: [(&str, &str, &str); 9] = [
    ("h", "houses", "meshes"),
    ("l", "leaves", "meshes"),
    ("t", "town", "meshes"),
    ("g", "terrain", "meshes"),
    ("y", "courtyard", "meshes"),
    ("c", "cornell", "meshes"),
    ("b", "bunny", "mesh-files"),
    ("f", "FlightHelmet", "mesh-files"),
    ("p", "PalmTree", "mesh-files"),
];

const OPAQUE_SPECS: [&str; 9] = [
    "voxel-grid:cell=solid",
    "voxel-grid:cell=mask",
    "voxel-grid:cell=triangles",
    "voxelized:size=1024",
    "voxelized:size=4096",
    "shadow-map:size=1024",
    "shadow-map:size=4096",
    "shadow-map:size=512,cascades=4",
    "shadow-map:size=1024,filter=5",
];

/// Pairs of an error and a cost, which is a sum of columns.
const OPAQUE_PLANES: [(&str, &[&str]); 6] = [
    ("surface.error", &["resident"]),
    ("surface.error", &["build"]),
    ("surface.error", &["look-up"]),
    ("surface.error", &["build", "look-up"]),
    ("image_flip_mean", &["resident"]),
    ("image_flip_mean", &["build", "look-up"]),
];

/// A row of the table of times.
struct Line {
    spec: String,
    label: String,
    cells: String,
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/notebook/all.md")
}

fn specs(lines: &[Line]) -> Vec<&str> {
    lines.iter().map(|line| line.spec.as_str()).collect()
}

/// Returns the letters of the scenes whose front contains the row with this number.
fn letters<'a>(fronts: impl Iterator<Item = (&'a str, Vec<bool>)>, row: usize) -> String {
    let names: Vec<_> = fronts.filter(|(_, on)| on[row]).map(|(letter, _)| letter).collect();
    names.join(" ")
}

/// Compares the table between two marks of a page with the expected table, or replaces it.
fn holds(page: &Path, [begin, end]: [&str; 2], table: &str) {
    let _alone = WRITING.lock();
    let text = std::fs::read_to_string(page).expect("the page");
    let (before, rest) = text.split_once(begin).expect("the beginning");
    let (old, after) = rest.split_once(end).expect("the end");
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(page, format!("{before}{begin}{table}{end}{after}")).expect("write the page");
    } else {
        assert_eq!(old, table, "GOBO_WRITE_TABLES=1 cargo test --release --test docs fronts writes it anew");
    }
}

fn lines(text: &str) -> Vec<Line> {
    let recipe = text.split("<!-- rows nvidia-h200/all\n").nth(1).and_then(|rest| rest.split("-->").next());
    let line = |line: &str| {
        let (spec, rest) = line.strip_prefix("t=")?.split_once(" | ")?;
        let (label, cells) = rest.split_once(" | ")?;
        Some(Line { spec: spec.replace(';', ","), label: label.to_owned(), cells: cells.to_owned() })
    };
    recipe.expect("the table").lines().filter_map(line).collect()
}

/// Returns whether each spec is on the front of its scene: no other spec has less error at no more cost, or costs less with no more error.
/// Costs whose relative difference is at most `same` count as equal; a row off the front can still beat other rows. Rows without the error
/// or the cost are on no front, nor is `none`, which casts no shadow. A cost is a sum of columns.
fn front(specs: &[&str], rows: &Rows, scene: &str, (error, cost): (&str, &[&str]), same: f64) -> Vec<bool> {
    let figures = |spec: &&str| {
        let value = |column: &str| rows.value(&Which { scene, spec }, column).ok();
        let cost = cost.iter().map(|column| value(column)).sum::<Option<f64>>();
        (*spec != "none").then(|| Some((cost?, value(error)?))).flatten()
    };
    let all: Vec<Option<(f64, f64)>> = specs.iter().map(figures).collect();
    let beats = |other: (f64, f64), own: (f64, f64)| {
        other.1 < own.1 && other.0 <= own.0 * (1.0 + same) || other.1 <= own.1 && other.0 * (1.0 + same) < own.0
    };
    let beaten = |own: (f64, f64)| all.iter().flatten().any(|other| beats(*other, own));
    all.iter().map(|own| own.is_some_and(|own| !beaten(own))).collect()
}

#[test]
fn marks_are_of_the_front() {
    let text = std::fs::read_to_string(page()).expect("the page");
    let lines = lines(&text);
    let mut marks = 0;
    for (letter, scene, file) in SCENES {
        let rows = Rows::read(Path::new(env!("CARGO_MANIFEST_DIR")), file).expect(file);
        for (line, on) in lines.iter().zip(front(&specs(&lines), &rows, scene, ("space.error", &["frame"]), 0.0)) {
            let marked = line.cells.contains(&format!("{{frame {letter}}} *"));
            assert_eq!(marked, on, "{} on {scene}", line.spec);
            marks += usize::from(marked);
        }
    }
    assert!(lines.len() > 20 && marks > 20, "{marks} marks in {} lines", lines.len());
}

#[test]
fn fronts_are_those_of_the_rows() {
    let text = std::fs::read_to_string(page()).expect("the page");
    let lines = lines(&text);
    let files: Vec<Rows> =
        SCENES.map(|(_, _, file)| Rows::read(Path::new(env!("CARGO_MANIFEST_DIR")), file).expect(file)).into();
    // Indexed by plane, then scene, then line.
    let fronts = PLANES.map(|(error, cost)| {
        let of = |((_, scene, _), rows): (&(&str, &str, &str), &Rows)| {
            front(&specs(&lines), rows, scene, (error, &[cost]), 0.0)
        };
        SCENES.iter().zip(&files).map(of).collect::<Vec<_>>()
    });
    let mut table = String::from(
        "| technique | at texels, build | frame | bytes | in space, build | frame | bytes |\n|---|---|---|---|---|---|---|\n",
    );
    for (i, line) in lines.iter().enumerate() {
        let of = |plane: &Vec<Vec<bool>>| {
            letters(SCENES.iter().zip(plane).map(|((letter, ..), on)| (*letter, on.clone())), i)
        };
        let cells: Vec<String> = fronts.iter().map(of).collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            table += &format!("| {} | {} |\n", line.label, cells.join(" | "));
        }
    }
    holds(&page(), [BEGIN, END], &table);
    // An exact technique must be on each front of errors in space, whatever it costs.
    let exact = lines.iter().position(|line| line.spec == "grid-query").expect("grid-query");
    assert!(fronts[3..].iter().all(|plane| plane.iter().all(|scene| scene[exact])));
}

#[test]
fn opaque_fronts_are_those_of_the_rows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // On a software device only the fronts of bytes are checked: its times are not representative.
    let bytes = OPAQUE_PLANES.iter().copied().filter(|(_, cost)| *cost == ["resident"]).collect::<Vec<_>>();
    for (device, of_courtyard, planes) in
        [("nvidia-h200", "meshes", OPAQUE_PLANES.to_vec()), ("lavapipe-22.3", "meshes-courtyard", bytes)]
    {
        let files = OPAQUE_SCENES.map(|(_, scene, file)| {
            let file = if scene == "courtyard" { of_courtyard } else { file };
            Rows::read(root, &format!("{device}/{file}")).expect(file)
        });
        // Rows that do not exist: cascades under lamps, 4096² maps for 32 lamps, and, on lavapipe, a 4096² bake for 32 lamps.
        let missing = |scene: &str, spec: &str| match scene {
            "courtyard" => {
                spec.contains("cascades")
                    || spec.contains("4096") && (device != "nvidia-h200" || !spec.starts_with("voxelized"))
            }
            "cornell" => spec.contains("cascades"),
            _ => false,
        };
        for ((_, scene, _), rows) in OPAQUE_SCENES.iter().zip(&files) {
            for spec in OPAQUE_SPECS {
                let is_there = rows.value(&Which { scene, spec }, "surface.error").is_ok();
                assert_eq!(is_there, !missing(scene, spec), "{device}: {spec} on {scene}");
            }
        }
        let fronts: Vec<_> = planes
            .iter()
            .map(|(error, cost)| {
                let of = |((letter, scene, _), rows): (&(&'static str, &str, &str), &Rows)| {
                    (*letter, front(&OPAQUE_SPECS, rows, scene, (error, cost), 0.02))
                };
                OPAQUE_SCENES.iter().zip(&files).map(of).collect::<Vec<_>>()
            })
            .collect();
        let heads = planes.iter().map(|(error, cost)| {
            let error = if *error == "surface.error" { "surface error" } else { "FLIP" };
            format!("{error}, {}", cost.join(" and ").replace("resident", "bytes"))
        });
        let mut table = format!(
            "| technique | {} |\n|{}\n",
            heads.collect::<Vec<_>>().join(" | "),
            "---|".repeat(planes.len() + 1)
        );
        for (i, spec) in OPAQUE_SPECS.iter().enumerate() {
            let cells: Vec<_> = fronts.iter().map(|plane| letters(plane.iter().cloned(), i)).collect();
            table += &format!("| `{spec}` | {} |\n", cells.join(" | "));
        }
        let begin = format!("<!-- fronts {device} -->\n");
        holds(&root.join("docs/notebook/opaque.md"), [&begin, END], &table);
        // Testing triangles must give the smallest error on surfaces, whatever it costs.
        let exact = OPAQUE_SPECS.iter().position(|spec| *spec == "voxel-grid:cell=triangles").expect("a row");
        for (plane, (error, _)) in fronts.iter().zip(&planes).filter(|(_, (error, _))| *error == "surface.error") {
            assert!(plane.iter().all(|(_, on)| on[exact]), "{device}, {error}");
        }
    }
}
