//! English of README.md and the guide: rules that a program can decide, each with its words; and how long pages may be.

use crate::tables::{name, pages};
use gobo::technique::REGISTRY;
use std::path::Path;

/// Words of a technique's page, of the whole guide, and of README.md, at most.
const TECHNIQUE: usize = 700;
const GUIDE: usize = 15_000;
const README: usize = 900;

/// Things that are *it*: none of them is followed by "who".
const THINGS: [&str; 16] = [
    "technique",
    "techniques",
    "path",
    "paths",
    "code",
    "shader",
    "shaders",
    "pass",
    "passes",
    "row",
    "rows",
    "driver",
    "drivers",
    "device",
    "devices",
    "file",
];

/// Before "a" and a unit these make a rate: *8 bytes a texel* is *8 bytes per texel*.
const COUNTED: [&str; 9] = ["bytes", "byte", "bits", "bit", "nodes", "texels", "casters", "ms", "MiB"];
const UNITS: [&str; 14] = [
    "texel", "light", "frame", "pixel", "voxel", "node", "map", "row", "caster", "slice", "sample", "particle", "ray",
    "layer",
];

/// Words that readers had to look up.
const RARE: [&str; 4] = ["whereof", "thereof", "otherwise than", "dear to"];

/// A technique's page has these headings, in this order.
const HEADINGS: [&str; 6] =
    ["## What a ", "## How it is built", "## Keys", "## Good and bad at", "## Cost", "## Sources"];

/// A page without code, comments and targets of links: paragraphs, rows and items, each a line.
fn prose(text: &str) -> Vec<String> {
    let mut text = text.to_owned();
    while let Some((start, end)) = text.find("<!--").and_then(|at| Some((at, at + text[at..].find("-->")? + 3))) {
        text.replace_range(start..end, "");
    }
    let (mut all, mut is_code) = (vec![String::new()], false);
    for line in text.lines() {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        if is_code || is_fence || line.starts_with("    ") {
            continue;
        }
        let trimmed = line.trim();
        // What begins a paragraph, a heading, an item or a row.
        let is_begin = trimmed.is_empty()
            || ["#", "|", "- ", "* "].iter().any(|mark| trimmed.starts_with(mark))
            || trimmed.split_once(". ").is_some_and(|(number, _)| number.parse::<u32>().is_ok());
        match all.last_mut() {
            Some(last) if !is_begin => *last += &format!(" {trimmed}"),
            _ => all.push(trimmed.to_owned()),
        }
    }
    all.iter().map(|line| without_targets(line)).filter(|line| !line.is_empty()).collect()
}

fn without_targets(line: &str) -> String {
    let mut line = line.trim().to_owned();
    while let Some((start, end)) = line.find("](").and_then(|at| Some((at, at + line[at..].find(')')?))) {
        line.replace_range(start..=end, "");
    }
    line
}

/// What is wrong with a line.
fn wrong(line: &str) -> Vec<String> {
    let mut found = Vec::new();
    // Ends of sentences, cells and marks of items; `.`, `:` and the like end one where a blank follows.
    let starts = line.split(['|', '•']).flat_map(|cell| cell.split(". ")).flat_map(|part| part.split(": "));
    for sentence in starts.map(|start| start.trim_start_matches([' ', '-', '*', '#', '_', '"'])) {
        if sentence.starts_with("Of ") {
            found.push(format!("begins with \"Of\": {sentence}"));
        }
    }
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_owned();
    let words: Vec<String> = line.split_whitespace().map(bare).collect();
    for pair in words.windows(2).filter(|pair| pair[1] == "who" && THINGS.contains(&pair[0].to_lowercase().as_str())) {
        found.push(format!("{} is \"it\": {line}", pair[0]));
    }
    for three in words.windows(3) {
        if three[1] == "a" && COUNTED.contains(&three[0].as_str()) && UNITS.contains(&three[2].as_str()) {
            found.push(format!("\"per\", not \"a\": {} in {line}", three.join(" ")));
        }
    }
    let lower = line.to_lowercase();
    found.extend(RARE.iter().filter(|rare| lower.contains(*rare)).map(|rare| format!("{rare:?}: {line}")));
    found
}

/// Words of a page as a reader meets them: in paragraphs and tables, not in code.
fn words(text: &str) -> usize {
    let is_word = |word: &&str| word.chars().any(char::is_alphanumeric);
    prose(text).iter().map(|line| line.split_whitespace().filter(is_word).count()).sum()
}

#[test]
fn guide_is_plain_and_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut off, mut guide, mut read) = (Vec::new(), 0, 0);
    for page in pages(root) {
        let (name, text) = (name(root, &page), std::fs::read_to_string(&page).expect("a page"));
        let is_guide = name.starts_with("docs/guide/") || name == "docs/README.md";
        if !is_guide && name != "README.md" {
            continue;
        }
        read += 1;
        off.extend(prose(&text).iter().flat_map(|line| wrong(line)).map(|what| format!("{name}: {what}")));
        let count = words(&text);
        guide += if is_guide { count } else { 0 };
        let limit = match name.as_str() {
            "README.md" => README,
            _ if name.starts_with("docs/guide/techniques/") => TECHNIQUE,
            _ => GUIDE,
        };
        if count > limit {
            off.push(format!("{name}: {count} words, at most {limit}"));
        }
    }
    println!("{guide} words in {read} pages");
    assert!(read > 30, "{read} pages: where are the others?");
    assert!(guide <= GUIDE, "the guide has {guide} words, at most {GUIDE}");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// One page a technique, all alike.
#[test]
fn each_technique_has_its_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/techniques");
    for entry in REGISTRY {
        let page = folder.join(entry.name).with_extension("md");
        let text = std::fs::read_to_string(&page).unwrap_or_else(|cause| panic!("{}: {cause}", page.display()));
        assert!(text.starts_with(&format!("# `{}`: ", entry.name)), "{}", entry.name);
        let headings: Vec<&str> = text.lines().filter(|line| line.starts_with("## ")).collect();
        let alike = headings.iter().zip(HEADINGS).all(|(is, begins)| is.starts_with(begins));
        assert!(headings.len() == HEADINGS.len() && alike, "{}: {headings:?}", entry.name);
        assert!(text.contains("<!-- rows "), "{}: no figures that are checked", entry.name);
        // What is said to be a key is one; those of all techniques are said together.
        let keys = text.split("## Keys").nth(1).and_then(|rest| rest.split("## ").next()).unwrap_or_default();
        for line in keys.lines().filter_map(|line| line.strip_prefix("- `")) {
            let said = line.split('`').next().unwrap_or_default();
            let key = said.split(['=', ',']).next().unwrap_or_default();
            let is_common = ["lighting", "skip", "shading"].contains(&key);
            assert!(is_common || entry.keys.iter().any(|known| known.name == key), "{}: {key}", entry.name);
        }
    }
    for page in std::fs::read_dir(folder).expect("pages").map(|page| page.expect("a page").path()) {
        let name = page.file_stem().expect("a name").to_string_lossy().into_owned();
        assert!(REGISTRY.iter().any(|entry| entry.name == name), "{name} is no technique");
    }
}

#[test]
fn bad_sentences_are_found() {
    for bad in [
        "It ends. Of what is baked fewer are timed.",
        "| size | Of the map |",
        "- Of two, the first.",
        "A technique who has no depth promises nothing.",
        "It takes 8 bytes a texel and more.",
        "The lists are dear to ask.",
    ] {
        assert_eq!(wrong(bad).len(), 1, "{bad}: {:?}", wrong(bad));
    }
    for good in [
        "Often it is so. The share of light, of which half is left.",
        "Users who take a technique read this.",
        "It takes 8 bytes per texel. A node is a texel's. It maps a light.",
        "Not code: `Of`.",
    ] {
        assert!(wrong(good).is_empty(), "{good}: {:?}", wrong(good));
    }
    let page = "# One\n\nTwo [three](four.md)\nfive.\n\n    six\n\n```text\nseven\n```\n<!-- rows\neight\n-->\n| nine | – |\n1. Ten\n";
    assert_eq!(prose(page), ["# One", "Two [three five.", "| nine | – |", "1. Ten"]);
    assert_eq!(words(page), 7);
}
