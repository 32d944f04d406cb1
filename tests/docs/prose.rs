//! English of all pages, comments and help texts: rules that a program can decide, each with its words.

use crate::tables::{name, pages};
use gobo::technique::REGISTRY;
use std::path::{Path, PathBuf};

/// Things that are *it*: none of them is followed by "who".
const THINGS: [&str; 26] = [
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
    "thread",
    "threads",
    "caster",
    "casters",
    "kernel",
    "map",
    "maps",
    "light",
    "lights",
    "program",
];

/// Before "a" and a unit these make a rate: eight bytes *a texel* are eight bytes *per texel*.
const COUNTED: [&str; 15] = [
    "bytes", "byte", "bits", "bit", "nodes", "texels", "voxels", "cells", "columns", "words", "threads", "numbers",
    "casters", "ms", "MiB",
];
const UNITS: [&str; 18] = [
    "texel",
    "light",
    "frame",
    "pixel",
    "voxel",
    "node",
    "map",
    "row",
    "caster",
    "slice",
    "sample",
    "particle",
    "ray",
    "layer",
    "side",
    "channel",
    "thread",
    "workgroup",
];

/// Words that readers had to look up.
const RARE: [&str; 4] = ["whereof", "thereof", "otherwise than", "dear to"];

/// A page without comments: recipes of tables are not read.
pub fn without_comments(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some((start, end)) = text.find("<!--").and_then(|at| Some((at, at + text[at..].find("-->")? + 3))) {
        text.replace_range(start..end, "");
    }
    text
}

/// A page without code, comments and targets of links: paragraphs, rows and items, each a line.
pub fn prose(text: &str) -> Vec<String> {
    let text = without_comments(text);
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

pub fn without_targets(line: &str) -> String {
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
    // A comma between them ends the rate before it begins, and a texel's bytes are no rate.
    let all: Vec<&str> = line.split_whitespace().collect();
    for three in all.windows(3) {
        let [many, a, unit] = [three[0], three[1], three[2]];
        let is_rate = COUNTED.contains(&many.trim_start_matches(|c: char| !c.is_alphanumeric()))
            && UNITS.contains(&unit.trim_end_matches(|c: char| !c.is_alphanumeric()));
        if a == "a" && is_rate {
            found.push(format!("\"per\", not \"a\": {} in {line}", three.join(" ")));
        }
    }
    let lower = line.to_lowercase();
    found.extend(RARE.iter().filter(|rare| lower.contains(*rare)).map(|rare| format!("{rare:?}: {line}")));
    found
}

/// Comments of a source, each paragraph a line: whole lines of one mark, and what stands behind code.
fn comments(text: &str) -> Vec<String> {
    let (mut all, mut mark_before): (Vec<String>, Option<(usize, &str)>) = (Vec::new(), None);
    let mut is_code = false;
    for line in text.lines() {
        let trimmed = line.trim_start();
        let Some(mark) = ["///", "//!", "//"].into_iter().find(|mark| trimmed.starts_with(mark)) else {
            (mark_before, is_code) = (None, false);
            all.extend(line.split_once(" // ").map(|(_, said)| said.trim().to_owned()));
            continue;
        };
        let said = &trimmed[mark.len()..];
        let is_fence = said.trim_start().starts_with("```");
        is_code ^= is_fence;
        if is_code || is_fence || said.starts_with("     ") {
            mark_before = None;
            continue;
        }
        let (here, said) = ((line.len() - trimmed.len(), mark), said.trim());
        let is_begin = said.is_empty() || ["#", "|", "- ", "* "].iter().any(|begin| said.starts_with(begin));
        match all.last_mut() {
            Some(last) if mark_before == Some(here) && !is_begin => *last += &format!(" {said}"),
            _ => all.push(said.to_owned()),
        }
        mark_before = (!said.is_empty()).then_some(here);
    }
    all.retain(|line| !line.is_empty());
    all
}

/// Files below a folder whose names end so.
fn sources(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let within = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let found = |path: PathBuf| match path.is_dir() {
        true => sources(&path, endings),
        false if endings.iter().any(|ending| path.extension().is_some_and(|is| is == *ending)) => vec![path],
        false => vec![],
    };
    within.flat_map(found).collect()
}

#[test]
fn pages_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = ["CHANGELOG.md", "CONTRIBUTING.md", "tests/README.md", "results/community/README.md"];
    let (mut lines, mut off) = (0, Vec::new());
    for page in pages(root).into_iter().chain(others.map(|page| root.join(page))) {
        let (name, mut text) = (name(root, &page), std::fs::read_to_string(&page).expect("a page"));
        // That page quotes what was wrong.
        if name == "docs/notebook/words.md" {
            text.truncate(text.find("\n## Sentences before").expect("the quotations"));
        }
        let prose = prose(&text);
        lines += prose.len();
        off.extend(prose.iter().flat_map(|line| wrong(line)).map(|what| format!("{name}: {what}")));
    }
    assert!(lines > 4_000, "{lines} lines: where are the others?");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

#[test]
fn comments_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["src", "glsl", "tests", "build", "examples"];
    let all = folders.iter().flat_map(|folder| sources(&root.join(folder), &["rs", "glsl", "comp", "vert", "frag"]));
    let (mut count, mut off) = (0, Vec::new());
    for file in all {
        let text = comments(&std::fs::read_to_string(&file).expect("a source"));
        count += text.len();
        off.extend(text.iter().flat_map(|line| wrong(line)).map(|what| format!("{}: {what}", name(root, &file))));
    }
    assert!(count > 8_000, "{count} comments: where are the others?");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// What `gobo help` says of techniques and their keys.
#[test]
fn help_is_plain() {
    for entry in REGISTRY {
        for about in entry.keys.iter().map(|key| key.about).chain([entry.about]) {
            assert!(wrong(about).is_empty() && !about.starts_with("of "), "{}: {about}", entry.name);
        }
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
        "A map has 256 texels a side.",
        "A map who has none.",
    ] {
        assert_eq!(wrong(bad).len(), 1, "{bad}: {:?}", wrong(bad));
    }
    for good in [
        "Often it is so. The share of light, of which half is left.",
        "Users who take a technique read this.",
        "It takes 8 bytes per texel. A node is a texel's. It maps a light.",
        "Not code: `Of`.",
        "Built in 0.12 ms, a frame in 2.7 ms. What is left of the bytes a texel's nodes take.",
    ] {
        assert!(wrong(good).is_empty(), "{good}: {:?}", wrong(good));
    }
    let page = "# One\n\nTwo [three](four.md)\nfive.\n\n    six\n\n```text\nseven\n```\n<!-- rows\neight\n-->\n| nine | – |\n1. Ten\n";
    assert_eq!(prose(page), ["# One", "Two [three five.", "| nine | – |", "1. Ten"]);
    let source = "//! One\n//! two.\n\n/// Three.\nlet four = 5; // six\n    // seven\n    // eight\n// nine\n/// ```\n/// ten\n/// ```\n";
    assert_eq!(comments(source), ["One two.", "Three.", "six", "seven eight", "nine"]);
}

/// Thirty bad sentences of docs/notebook/words.md: no page has them any more, and some page has what stands in their place.
#[test]
fn the_worst_sentences_are_gone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // As a reader sees it: no targets of links, no line ends.
    let plain = |text: &str| {
        let text = without_targets(text).replace("[", "").replace("**", "").to_lowercase();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let (mut said, mut quotes) = (String::new(), String::new());
    for page in pages(root) {
        let text = std::fs::read_to_string(&page).expect("a page");
        match name(root, &page) == "docs/notebook/words.md" {
            true => quotes = text,
            false => said += &plain(&text),
        }
    }
    let table = quotes.split("\n## Sentences before").nth(1).expect("the quotations");
    let rows = table.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| before"));
    let mut count = 0;
    for row in rows {
        let (before, after) = row.trim_matches(['|', ' ']).split_once(" | ").expect(row);
        assert!(!said.contains(&plain(before)), "still there: {before}");
        assert!(said.contains(&plain(after)), "nowhere: {after}");
        count += 1;
    }
    assert_eq!(count, 30, "sentences");
}
