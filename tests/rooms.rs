//! Which room of src/ uses which: an arrow that the design does not have fails, so that none leads up and none back.

#![cfg(feature = "program")]

use std::collections::BTreeSet;
use std::path::Path;

/// Every room and those that it may use; errors are everyone's.
const ARROWS: [(&str, &[&str]); 17] = [
    ("scene", &[]),
    ("gpu", &[]),
    ("shaders", &["gpu"]),
    ("reference", &["scene"]),
    ("world", &["gpu", "scene", "shaders"]),
    ("maps", &["gpu", "scene", "shaders", "world"]),
    ("grid", &["gpu", "scene", "shaders", "world"]),
    ("simulate", &["gpu", "grid", "scene", "shaders", "world"]),
    ("lights", &["gpu", "maps", "scene", "shaders", "world"]),
    ("technique", &["gpu", "grid", "maps", "scene", "shaders", "world"]),
    ("glsl", &["gpu", "shaders", "technique"]),
    ("consume", &["gpu", "maps", "scene", "shaders", "technique", "world"]),
    ("measure", &["consume", "gpu", "maps", "reference", "scene", "shaders", "simulate", "technique", "world"]),
    ("stress", &["consume", "gpu", "measure", "reference", "scene", "technique", "world"]),
    ("report", &["consume", "gpu", "measure", "stress", "technique"]),
    ("view", &["consume", "gpu", "measure", "reference", "report", "scene", "shaders", "technique", "world"]),
    (
        "cli",
        &[
            "consume",
            "glsl",
            "gpu",
            "lights",
            "measure",
            "reference",
            "report",
            "scene",
            "simulate",
            "stress",
            "technique",
            "view",
            "world",
        ],
    ),
];

/// What a file of Rust uses of the crate, without comments: the first names of paths from `crate`. Unit tests are as bound as what they
/// test: one that needs a room below stands in tests/.
fn used(text: &str) -> BTreeSet<String> {
    let code: Vec<_> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join(" ").replace("$crate::", "");
    let mut names = BTreeSet::new();
    for after in code.split("crate::").skip(1) {
        let listed = after.strip_prefix('{').map_or(after, |list| list.split('}').next().unwrap_or_default());
        let count = if listed.len() == after.len() { 1 } else { usize::MAX };
        for item in listed.split(',').take(count) {
            let name = item.trim().split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default();
            names.insert(name.to_owned());
        }
    }
    names
}

fn is_known(room: &str) -> bool {
    ARROWS.iter().any(|(known, _)| *known == room)
}

/// Every arrow of the Rust files under a folder, as lines of user and used.
fn arrows(folder: &Path, room: Option<&str>, all: &mut BTreeSet<String>, rooms: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("a name").to_owned();
        // Files beside the rooms are the crate's root, but for those that have a line above.
        let (in_room, room) = (room.is_some(), room.unwrap_or(&stem));
        if path.is_dir() {
            arrows(&path, Some(room), all, rooms);
        } else if path.extension().is_some_and(|ending| ending == "rs") && (in_room || is_known(room)) {
            rooms.insert(room.to_owned());
            let text = std::fs::read_to_string(&path).expect("UTF-8");
            all.extend(used(&text).into_iter().filter(|to| to != room).map(|to| format!("{room} → {to}")));
        }
    }
}

#[test]
fn no_arrow_leads_up() {
    let (mut all, mut rooms) = (BTreeSet::new(), BTreeSet::new());
    arrows(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), None, &mut all, &mut rooms);
    assert!(rooms.iter().all(|room| is_known(room)), "a room that has no line here: {rooms:?}");
    let allowed: BTreeSet<_> =
        ARROWS.iter().flat_map(|(room, may)| may.iter().map(move |to| format!("{room} → {to}"))).collect();
    // What is not a room is an item of the crate's root, an error or a macro.
    let is_room = |arrow: &&String| rooms.contains(arrow.split(" → ").nth(1).unwrap_or_default());
    let wrong: Vec<_> = all.iter().filter(is_room).filter(|arrow| !allowed.contains(*arrow)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all.len() > 50, "too few to be all: {all:?}");

    // The list itself has no circle: each room uses only those above it here.
    for (i, (room, may)) in ARROWS.iter().enumerate() {
        for to in *may {
            assert!(ARROWS[..i].iter().any(|(before, _)| before == to), "{room} → {to} leads up");
        }
    }
}
