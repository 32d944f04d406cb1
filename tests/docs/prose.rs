//! English of all pages, comments, messages and help, by the rules of `english.rs`.

use crate::english::wrong;
use crate::sources::{between_tags, comments, sources, texts};
use crate::tables::{name, pages};
use gobo::technique::REGISTRY;
use std::path::Path;
use std::process::Command;

/// Returns a page without comments, so that recipes of tables are not checked.
pub fn without_comments(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some((start, end)) = text.find("<!--").and_then(|at| Some((at, at + text[at..].find("-->")? + 3))) {
        text.replace_range(start..end, "");
    }
    text
}

/// Returns a page without code, comments and link targets: one line per paragraph, row and item.
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
        // Beginnings of a paragraph, a heading, an item or a row.
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

/// Returns a line without its link targets.
pub fn without_targets(line: &str) -> String {
    let mut line = line.trim().to_owned();
    while let Some((start, end)) = line.find("](").and_then(|at| Some((at, at + line[at..].find(')')?))) {
        line.replace_range(start..=end, "");
    }
    line
}

#[test]
fn pages_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = ["CHANGELOG.md", "CONTRIBUTING.md", "tests/README.md", "results/community/README.md"];
    let (mut lines, mut off) = (0, Vec::new());
    for page in pages(root).into_iter().chain(others.map(|page| root.join(page))) {
        let (name, mut text) = (name(root, &page), std::fs::read_to_string(&page).expect("a page"));
        // That page quotes former mistakes.
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

/// Folders and files with sources, including scripts and settings of tools.
const PLACES: [&str; 18] = [
    "src",
    "glsl",
    "tests",
    "build",
    "build.rs",
    "examples",
    "fuzz",
    "Cargo.toml",
    "rustfmt.toml",
    "setup.sh",
    ".cargo/config.toml",
    ".ci/run",
    ".github/workflows",
    "results/commands.txt",
    "results/files",
    "results/measure.sh",
    "results/recommend.sh",
    "results/baseline.sh",
];

#[test]
fn comments_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut count, mut off) = (0, Vec::new());
    for file in PLACES.iter().flat_map(|place| sources(&root.join(place))) {
        let all = comments(&file, &std::fs::read_to_string(&file).expect("a source"));
        count += all.len();
        let wrong = all.iter().flat_map(|(line, said)| wrong(said).into_iter().map(move |what| (line, what)));
        off.extend(wrong.map(|(line, what)| format!("{}:{line}: {what}", name(root, &file))));
    }
    assert!(count > 11_000, "{count} comments: where are the others?");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// Checks errors, help, headings and column meanings in the sources, heads of GLSL files, and page templates.
#[test]
fn messages_are_plain() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut count, mut off) = (0, Vec::new());
    let rust = ["src", "build"].iter().flat_map(|place| sources(&root.join(place)));
    let rust = rust.filter(|file| file.extension().is_some_and(|is| is == "rs"));
    let templates = ["page/page", "page/stress", "page/soak", "devices/page"]
        .map(|name| root.join(format!("src/report/{name}.html")));
    for file in &rust.chain(templates).collect::<Vec<_>>() {
        let text = std::fs::read_to_string(file).expect("a source");
        let is_page = file.extension().is_some_and(|is| is == "html");
        let all = if is_page { between_tags(&text) } else { texts(&text) };
        count += all.len();
        let wrong = all.iter().flat_map(|(line, said)| wrong(said).into_iter().map(move |what| (line, what)));
        off.extend(wrong.map(|(line, what)| format!("{}:{line}: {what}", name(root, file))));
    }
    assert!(count > 2_000, "{count} messages: where are the others?");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

/// Checks what the program prints: help of each command and option, and of each technique with its keys.
#[test]
fn help_is_plain() {
    let help = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_gobo")).args(arguments).output().expect("the program runs");
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let all = help(&["--help"]);
    let listed = all.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| line.starts_with("  "));
    let first = listed.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    let commands: Vec<&str> = first.filter(|name| *name != "help").collect();
    assert!(commands.len() >= 11, "{all}");
    let mut pages: Vec<(&str, String)> = commands.iter().map(|name| (*name, help(&[name, "--help"]))).collect();
    pages.extend(REGISTRY.iter().map(|entry| (entry.name, help(&["help", entry.name]))));
    pages.push(("gobo", all.clone()));
    let (mut count, mut off) = (0, Vec::new());
    for (name, page) in &pages {
        // A paragraph ends at an empty line or before an option.
        let mut said: Vec<String> = vec![String::new()];
        for line in page.lines().map(str::trim) {
            match said.last_mut() {
                Some(last) if !line.is_empty() && !line.starts_with('-') => *last += &format!(" {line}"),
                _ => said.push(line.to_owned()),
            }
        }
        count += said.len();
        off.extend(said.iter().flat_map(|line| wrong(line)).map(|what| format!("{name}: {what}")));
    }
    for entry in REGISTRY {
        for about in entry.keys.iter().map(|key| key.about).chain([entry.about]) {
            assert!(!about.starts_with("of "), "{}: {about}", entry.name);
        }
    }
    assert!(count > 500, "{count} paragraphs: where are the others?");
    assert!(off.is_empty(), "{}", off.join("\n"));
}

#[test]
fn bad_sentences_are_found() {
    for bad in [
        "It ends. Of two, fewer are timed.",
        "| size | Of the map |",
        "- Of two, the first.",
        "A technique who has no depth promises nothing.",
        "Who draws the depths of meshes.",
        "It takes 8 bytes a texel and more.",
        "Four a texel, in slices.",
        "The manual, a page a command.",
        "Name one value a key.",
        "Samples a pixel: 1 to 16.",
        "A small list a row.",
        "The lists are dear to ask.",
        "A map has 256 texels a side.",
        "The size of what is drawn.",
        "The value of that which is drawn.",
    ] {
        assert_eq!(wrong(bad).len(), 1, "{bad}: {:?}", wrong(bad));
    }
    for good in [
        "Often it is so. The share of light, of which half is left.",
        "Users who take a technique read this, and those who do not.",
        "It takes 8 bytes per texel. A node is a texel's. It maps a light. Half a texel is less.",
        "Not code: `Of`, `who`, `8 bytes a texel`.",
        "Built in 0.12 ms, a frame in 2.7 ms. What is left of the bytes a texel's nodes take.",
        "Which voxels a triangle meets; how many bytes a texel has. It reaches a point; it says what a row is.",
    ] {
        assert!(wrong(good).is_empty(), "{good}: {:?}", wrong(good));
    }
    let page = "# One\n\nTwo [three](four.md)\nfive.\n\n    six\n\n```text\nseven\n```\n<!-- rows\neight\n-->\n| nine | – |\n1. Ten\n";
    assert_eq!(prose(page), ["# One", "Two [three five.", "| nine | – |", "1. Ten"]);
}

/// Comments and texts must be joined across the ends of their lines.
#[test]
fn sources_are_read() {
    let said = |file: &str, text: &str| {
        let found = comments(Path::new(file), text);
        found.into_iter().map(|(line, said)| format!("{line} {said}")).collect::<Vec<_>>()
    };
    let source = "//! One\n//! two.\n\n/// Three.\nlet four = 5; // six\n    // seven\n    // eight\n// nine\n/// ```\n/// ten\n/// ```\n";
    assert_eq!(said("a.rs", source), ["1 One two.", "4 Three.", "5 six", "6 seven eight", "8 nine"]);
    assert_eq!(said("a.tese", "int a;  // one\n        // two\nint b;\n// three\n"), ["1 one two", "4 three"]);
    assert_eq!(said("a.toml", "# one\n# two\nthree = 4 # five\n"), ["1 one two", "3 five"]);
    let source = "f(\"one \\\n   two\", 'a', '\"', \"three\"); // \"four five\"\ng(\"six\\nseven\")";
    assert_eq!(texts(source), [(1, "one two".to_owned()), (3, "six seven".to_owned())]);
    assert_eq!(between_tags("<p\n>one two</p>\n<b>three</b>"), [(2, "one two".to_owned())]);
}

/// Draws a hundred comments of `src` and `glsl` with ten words or more, seeded by `GOBO_SEED`, for a person to read
/// (docs/notebook/words.md). `--nocapture` prints them.
#[test]
fn a_sample_of_comments() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let seed: u64 = std::env::var("GOBO_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    let (mut all, mut drawn) = (Vec::new(), Vec::new());
    for file in ["src", "glsl"].iter().flat_map(|place| sources(&root.join(place))) {
        let found = comments(&file, &std::fs::read_to_string(&file).expect("a source"));
        let long = found.into_iter().filter(|(_, said)| said.split_whitespace().count() >= 10);
        all.extend(long.map(|(line, said)| format!("{}:{line}: {said}", name(root, &file))));
    }
    let mut state = seed;
    while drawn.len() < 100 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let one = &all[(state >> 33) as usize % all.len()];
        if !drawn.contains(&one) {
            println!("{} {one}", drawn.len() + 1);
            drawn.push(one);
        }
    }
    assert!(all.len() > 4_000, "{} comments: where are the others?", all.len());
}

/// Thirty bad sentences quoted in docs/notebook/words.md: no page may still contain one, and some page must contain each replacement.
#[test]
fn the_worst_sentences_are_gone() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // The text as a reader sees it, without link targets and line ends.
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
