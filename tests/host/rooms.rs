//! Dependencies between the folders ("rooms") of src/: an arrow that the design does not list fails the test, so that no room depends on a
//! higher one and there are no cycles.

use std::collections::BTreeSet;
use std::path::Path;

/// Every room and the rooms that it may use; every room may use errors.
const ARROWS: [(&str, &[&str]); 17] = [
    ("scene", &[]),
    ("gpu", &[]),
    ("shaders", &["gpu"]),
    ("reference", &["scene"]),
    ("world", &["gpu", "scene", "shaders"]),
    ("maps", &["gpu", "scene", "shaders", "world"]),
    ("grid", &["gpu", "scene", "shaders", "world"]),
    ("animate", &["gpu", "grid", "scene", "shaders", "world"]),
    ("lights", &["gpu", "maps", "scene", "shaders", "world"]),
    ("technique", &["gpu", "grid", "maps", "scene", "shaders", "world"]),
    ("glsl", &["gpu", "shaders", "technique"]),
    ("query", &["gpu", "scene", "shaders", "technique"]),
    ("shading", &["gpu", "maps", "query", "scene", "shaders", "technique", "world"]),
    ("bench", &["animate", "gpu", "maps", "query", "reference", "scene", "shaders", "shading", "technique", "world"]),
    ("report", &["bench", "gpu", "shading", "technique"]),
    (
        "view",
        &[
            "animate",
            "bench",
            "gpu",
            "query",
            "reference",
            "report",
            "scene",
            "shaders",
            "shading",
            "technique",
            "world",
        ],
    ),
    (
        "cli",
        &[
            "animate",
            "bench",
            "glsl",
            "gpu",
            "lights",
            "query",
            "reference",
            "report",
            "scene",
            "shading",
            "technique",
            "view",
            "world",
        ],
    ),
];

/// Returns what a Rust file uses of the crate: the first names of paths from `crate`, without comments. Unit tests follow the same rules as
/// the code that they test: one that needs a lower room belongs in tests/.
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

/// Collects every arrow of the Rust files under a folder, as `user → used`.
fn arrows(folder: &Path, room: Option<&str>, all: &mut BTreeSet<String>, rooms: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("a name").to_owned();
        // Files next to the rooms belong to the crate's root, except those listed above.
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
    // A name that is not a room is an item of the crate's root, an error or a macro.
    let is_room = |arrow: &&String| rooms.contains(arrow.split(" → ").nth(1).unwrap_or_default());
    let wrong: Vec<_> = all.iter().filter(is_room).filter(|arrow| !allowed.contains(*arrow)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(all.len() > 50, "too few to be all: {all:?}");

    // The list itself must not have cycles: each room uses only those above it here.
    for (i, (room, may)) in ARROWS.iter().enumerate() {
        for to in *may {
            assert!(ARROWS[..i].iter().any(|(before, _)| before == to), "{room} → {to} leads up");
        }
    }
}

/// Returns the quoted texts of a Rust file, without comments.
fn texts(code: &str) -> Vec<String> {
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code: String = lines.flat_map(|line| [line, "\n"]).collect();
    let (mut texts, mut open, mut rest) = (Vec::new(), None::<String>, code.chars());
    while let Some(c) = rest.next() {
        match (c, &mut open) {
            // A quote as a character.
            ('\'', None) if rest.as_str().starts_with("\"'") => rest.by_ref().take(2).for_each(drop),
            ('"', None) => open = Some(String::new()),
            ('"', Some(_)) => texts.extend(open.take()),
            ('\\', Some(text)) => text.extend(rest.next()),
            (_, Some(text)) => text.push(c),
            _ => {}
        }
    }
    texts
}

/// Whether a text tells the user what to type: an option, or a command after the program's name.
fn says_what_to_type(text: &str) -> bool {
    let begins = |after: &str| after.starts_with(|c: char| c.is_ascii_lowercase());
    text.split("--").skip(1).any(begins) || text.split("gobo ").skip(1).any(begins)
}

/// Messages of the core must not mention the program, since engines show them too.
#[test]
fn the_core_says_no_word_of_the_program() {
    let core = ["glsl", "gpu", "grid", "lights", "maps", "query", "scene", "shaders", "shading", "technique", "world"];
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut found, mut wrong) = (core.map(|room| src.join(room)).to_vec(), 0, Vec::new());
    let mut files = core.map(|room| src.join(format!("{room}.rs"))).to_vec();
    files.push(src.join("error.rs"));
    folders.retain(|folder| folder.is_dir());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    for file in files.iter().filter(|file| file.is_file() && file.extension().is_some_and(|ending| ending == "rs")) {
        let texts = texts(&std::fs::read_to_string(file).expect("UTF-8"));
        found += texts.len();
        wrong.extend(texts.into_iter().filter(|text| says_what_to_type(text)).map(|text| (file.clone(), text)));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(found > 2000, "too few to be all: {found}");
    for typed in [r#"say("leave --lights out");"#, r#"say("what gobo bake wrote")"#, r#"['"', "run `gobo devices`"]"#] {
        assert!(texts(typed).iter().any(|text| says_what_to_type(text)), "{typed}");
    }
    assert!(!texts("// \"--no\"\nlet a = \"gobo-leak -- so\";").iter().any(|text| says_what_to_type(text)));
}

/// Former names of types, files and parts of identifiers, for which the field has a better word.
const TYPES: [&str; 38] = [
    "Asked",
    "Beside",
    "Broken",
    "Case",
    "Chosen",
    "Colours",
    "Counted",
    "Developed",
    "Drawn",
    "Filled",
    "Finer",
    "Fineness",
    "Found",
    "Gaussian",
    "Grown",
    "Holds",
    "Ink",
    "Kept",
    "Listed",
    "Made",
    "Of",
    "PartsSeen",
    "Pressed",
    "Ran",
    "Said",
    "Settled",
    "Shown",
    "Sliced",
    "Standing",
    "Stands",
    "Stood",
    "Stressed",
    "Theirs",
    "TilesSeen",
    "Told",
    "Viewed",
    "Way",
    "Whose",
];
const FILES: [&str; 20] = [
    "asked",
    "beside",
    "choice",
    "colours",
    "copy",
    "drawn",
    "first_look",
    "little",
    "parts",
    "place",
    "placed",
    "rank",
    "seen_parts",
    "serve",
    "sliced",
    "standing",
    "stood",
    "strewn",
    "theirs",
    "wording",
];
// A Gaussian is a filter; scenes contain splats. Names of glTF extensions are not ours.
const PARTS: [&str; 5] = ["colour", "a_map", "gaussian_", "is_gaussian", "gaussians"];

/// Allowed exceptions: names in one file whose meaning is clear, or of a library.
const KNOWN: [(&str, &str); 6] = [
    ("src/reference/twin/area.rs", "Case"),
    ("src/reference/twin/many_lights/shade.rs", "Found"),
    ("src/reference/twin/stochastic.rs", "Drawn"),
    ("src/reference/twin/voxelized/mod.rs", "Kept"),
    ("src/scene/files/animation.rs", "Kept"),
    ("src/view/present.rs", "Shown"),
];

/// Returns the identifiers in a line of code.
fn identifiers(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Names must let a reader who knows graphics, but not this code, guess types and files.
#[test]
fn names_are_the_fields() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut wrong, mut read) = (Vec::new(), 0);
    let mut folders = vec![root.join("src"), root.join("glsl")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(root).expect("within").to_string_lossy().into_owned();
            let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
            if FILES.contains(&stem.as_str()) && name.starts_with("src/") {
                wrong.push(name.clone());
            }
            let Ok(text) = std::fs::read_to_string(&path) else { continue };
            read += 1;
            for line in text.lines() {
                let code = line.split("//").next().unwrap_or_default();
                let words: Vec<&str> = identifiers(code).collect();
                for pair in words.windows(2) {
                    let is_declared = ["struct", "enum", "type", "trait"].contains(&pair[0]);
                    if is_declared && TYPES.contains(&pair[1]) && !KNOWN.contains(&(name.as_str(), pair[1])) {
                        wrong.push(format!("{name}: {}", pair[1]));
                    }
                }
                let own = words.iter().filter(|word| !word.starts_with("KHR_"));
                let parts = own.filter(|word| PARTS.iter().any(|part| word.to_lowercase().contains(part)));
                wrong.extend(parts.map(|word| format!("{name}: {word}")));
            }
        }
    }
    assert!(read > 500, "{read} files");
    assert!(wrong.is_empty(), "names with a better one (CONTRIBUTING.md): {wrong:#?}");
}
