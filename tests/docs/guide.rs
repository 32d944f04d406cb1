//! Pages of the guide: their length, their structure, and explanations of words where a new reader meets them first.

use crate::prose::{prose, without_comments, without_targets};
use crate::tables::{name, pages};
use gobo::technique::REGISTRY;
use std::path::Path;

/// Largest number of words in the whole guide with the pages of techniques, and in README.md.
const GUIDE: usize = 15_000;
const README: usize = 900;
/// Reading speed, in words per minute.
const PER_MINUTE: f64 = 240.0;

/// Headings of a technique's page, in order.
const HEADINGS: [&str; 6] =
    ["## What a ", "## How it is built", "## Keys", "## Good and bad at", "## Cost", "## Sources"];
/// Maximum number of sentences on how a technique is built, and minimum number of figures on its strengths and weaknesses.
const SENTENCES: usize = 5;
const FIGURES: usize = 3;

/// Words of the glossary that have their everyday meaning on these pages.
const EVERYDAY: [&str; 9] = ["adaptive", "build", "filter", "map", "path", "promise", "truth", "within", "frame"];

/// Length of a text.
#[derive(Clone, Copy, Default, PartialEq, Debug)]
struct Length {
    /// Words that a reader reads, without bars of tables and blocks of code.
    words: usize,
    /// Words as counted by `wc -w`, without blocks of code.
    prose: usize,
    /// Words as counted by `wc -w`.
    all: usize,
}

impl Length {
    fn of(text: &str) -> Self {
        let text = without_comments(text);
        let mut is_code = false;
        let mut length = Self { all: text.split_whitespace().count(), ..Self::default() };
        for line in text.lines() {
            let is_fence = line.starts_with("```");
            is_code ^= is_fence;
            if !is_code && !is_fence && !line.starts_with("    ") {
                length.prose += line.split_whitespace().count();
                length.words += line.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count();
            }
        }
        length
    }

    fn and(self, other: Self) -> Self {
        Self { words: self.words + other.words, prose: self.prose + other.prose, all: self.all + other.all }
    }
}

/// Returns all pages with their lengths.
fn lengths(root: &Path) -> Vec<(String, Length)> {
    let length = |page: &Path| Length::of(&std::fs::read_to_string(page).expect("a page"));
    pages(root).iter().map(|page| (name(root, page), length(page))).collect()
}

/// Whether a page belongs to the guide, which includes the pages of techniques and the index.
pub fn is_guide(name: &str) -> bool {
    ["docs/guide/", "docs/techniques/"].iter().any(|folder| name.starts_with(folder)) || name == "docs/README.md"
}

#[test]
fn guide_is_short() {
    let all = lengths(Path::new(env!("CARGO_MANIFEST_DIR")));
    let guide: Vec<&(String, Length)> = all.iter().filter(|(name, _)| is_guide(name)).collect();
    assert!(guide.len() > 30, "{} pages: where are the others?", guide.len());
    let sum = guide.iter().fold(Length::default(), |sum, (_, length)| sum.and(*length));
    println!("{sum:?} in {} pages", guide.len());
    assert!(sum.prose <= GUIDE, "{sum:?}, at most {GUIDE}");
    let readme = all.iter().find(|(name, _)| name == "README.md").expect("README.md").1;
    assert!(readme.words <= README, "{readme:?}, at most {README}");
}

/// Checks the counts in docs/notebook/words.md. The comment before its table has a line per row: label, earlier length, and the pages as
/// files, folders that end in `/`, or the longest of them.
#[test]
fn words_are_counted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("docs/notebook/words.md");
    let text = std::fs::read_to_string(&path).expect("the page");
    let all = lengths(root);
    let (before, rest) = text.split_once("<!-- words\n").expect("a recipe");
    let (recipe, rest) = rest.split_once("-->\n").expect("a comment ends");
    let (old, after) = rest.split_once("<!-- /words -->").expect("a table ends");
    let mut new = old.lines().take(2).map(|line| format!("{line}\n")).collect::<String>();
    for line in recipe.lines() {
        let [label, was, of] = line.split(" | ").collect::<Vec<_>>()[..] else { panic!("{line}") };
        let is_one =
            |name: &str| of.split(' ').any(|what| name == what || what.ends_with('/') && name.starts_with(what));
        let lengths = all.iter().filter(|(name, _)| is_one(name)).map(|(_, length)| *length);
        let length = match of.starts_with("longest ") {
            true => lengths.max_by_key(|length| length.words).expect("a page"),
            false => lengths.fold(Length::default(), Length::and),
        };
        let Length { words, prose, all } = length;
        let minutes = (words as f64 / PER_MINUTE).round();
        new += &format!("| {label} | {was} | {words} | {prose} | {all} | {minutes} |\n");
    }
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        return std::fs::write(&path, format!("{before}<!-- words\n{recipe}-->\n{new}<!-- /words -->{after}"))
            .expect("write");
    }
    assert_eq!(old, new, "GOBO_WRITE_TABLES=1 cargo test --release --test docs words_are_counted writes them anew");
}

#[test]
fn lengths_of_a_text() {
    let text = "# One\n\nTwo [three](four.md)\nfive.\n\n    six\n\n```text\nseven\n```\n<!-- rows\neight\n-->\n| nine | – |\n1. Ten\n";
    assert_eq!(Length::of(text), Length { words: 7, prose: 12, all: 16 });
}

/// Returns the text under a heading.
fn section<'a>(text: &'a str, heading: &str) -> &'a str {
    text.split(heading).nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap_or_default()
}

/// Returns a text without code and link targets.
fn without_code(text: &str) -> String {
    without_targets(text).split('`').step_by(2).collect::<Vec<_>>().join(" ")
}

/// Returns the number of sentences in a paragraph.
fn sentences(text: &str) -> usize {
    let ends = |word: &&str| word.ends_with(['.', '!', '?']) || word.ends_with(".)");
    without_code(text).split_whitespace().filter(ends).count()
}

/// Each technique must have one page, all with the same structure.
#[test]
fn each_technique_has_its_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/techniques");
    for entry in REGISTRY {
        let page = folder.join(entry.name).with_extension("md");
        let text = std::fs::read_to_string(&page).unwrap_or_else(|cause| panic!("{}: {cause}", page.display()));
        let name = entry.name;
        assert!(text.starts_with(&format!("# `{name}`: ")), "{name}");
        let headings: Vec<&str> = text.lines().filter(|line| line.starts_with("## ")).collect();
        let alike = headings.iter().zip(HEADINGS).all(|(is, begins)| is.starts_with(begins));
        assert!(headings.len() == HEADINGS.len() && alike, "{name}: {headings:?}");
        let first = text.split("\n## ").next().unwrap_or_default();
        assert!(first.contains("!["), "{name}: no picture");
        let built = section(&text, "## How it is built");
        let count = sentences(built.split("```").next().unwrap_or_default());
        assert!((1..=SENTENCES).contains(&count), "{name}: built in {count} sentences");
        assert!(built.contains("```text"), "{name}: no drawing");
        // Figures on strengths and weaknesses must also be in the cost table, which is checked against the rows.
        assert!(text.contains("<!-- rows "), "{name}: no figures that are checked");
        let cost = section(&text, "## Cost");
        let cells: Vec<&str> =
            cost.lines().filter(|l| l.starts_with('|')).flat_map(|l| l.split('|').map(str::trim)).collect();
        let said = without_code(section(&text, "## Good and bad at"));
        let numbers = said.split_whitespace().map(|word| word.trim_matches(['.', ',', ':', ';', '(', ')']));
        let numbers: Vec<&str> = numbers.filter(|word| word.parse::<f64>().is_ok()).collect();
        let held = numbers.iter().filter(|number| cells.contains(number)).count();
        assert!(held >= FIGURES, "{name}: {held} figures of what it is good and bad at");
        for number in numbers.iter().filter(|number| number.contains('.')) {
            assert!(cells.contains(number), "{name}: {number} is not in the table of its cost");
        }
        // Each listed key must exist; keys that all techniques share are described together.
        let keys: Vec<&str> = section(&text, "## Keys").lines().filter_map(|line| line.strip_prefix("- `")).collect();
        assert!(!keys.is_empty(), "{name}: no keys");
        for line in keys {
            let said = line.split('`').next().unwrap_or_default();
            let key = said.split(['=', ',']).next().unwrap_or_default();
            let is_common = ["lighting", "skip", "shading"].contains(&key);
            assert!(is_common || entry.keys.iter().any(|known| known.name == key), "{name}: {key}");
        }
    }
    for page in std::fs::read_dir(folder).expect("pages").map(|page| page.expect("a page").path()) {
        let name = page.file_stem().expect("a name").to_string_lossy().into_owned();
        assert!(REGISTRY.iter().any(|entry| entry.name == name), "{name} is no technique");
    }
}

#[test]
fn sentences_are_counted() {
    assert_eq!(sentences("One has `a.b` 1.5 texels. Two (as [before](x.md).) Three?"), 3);
}

/// Words of the glossary: the first paragraph with such a word (or its table, or the text right before that table) must link the glossary
/// or explain the word in italics.
#[test]
fn words_are_explained_where_they_come_first() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let glossary = std::fs::read_to_string(root.join("docs/guide/glossary.md")).expect("the glossary");
    let rows = glossary.lines().filter(|line| line.starts_with("| ")).skip(1);
    let terms: Vec<&str> =
        rows.flat_map(|row| row.split('|').nth(1).unwrap_or_default().split(',')).map(str::trim).collect();
    assert!(terms.len() > 40, "{terms:?}");
    let is_mark = |c: char| !c.is_alphanumeric() && c != '-';
    let mut off = Vec::new();
    for page in ["README.md", "docs/guide/choose.md", "docs/guide/start.md"] {
        let text = without_comments(&std::fs::read_to_string(root.join(page)).expect(page));
        let blocks: Vec<&str> = text.split("\n\n").filter(|block| !block.starts_with("    ")).map(str::trim).collect();
        let bare = |block: &&str| {
            let text = without_code(&prose(block).join(" ")).to_lowercase();
            format!(" {} ", text.split(is_mark).filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" "))
        };
        let bare: Vec<String> = blocks.iter().map(bare).collect();
        for term in terms.iter().filter(|term| !EVERYDAY.contains(term)).map(|term| term.to_lowercase()) {
            let has = |block: &String| ["", "s"].iter().any(|end| block.contains(&format!(" {term}{end} ")));
            let Some(at) = bare.iter().position(has) else { continue };
            let lead = if blocks[at].starts_with('|') && at > 0 { blocks[at - 1] } else { "" };
            let is_meaning = |block: &str| block.to_lowercase().contains(&format!("*{term}"));
            let is_said = |block: &str| block.contains("glossary.md") || is_meaning(block);
            if !is_said(blocks[at]) && !is_said(lead) {
                off.push(format!("{page}: {term}: {}", blocks[at].lines().next().unwrap_or_default()));
            }
        }
    }
    assert!(off.is_empty(), "no link to the glossary where these come first:\n{}", off.join("\n"));
}
