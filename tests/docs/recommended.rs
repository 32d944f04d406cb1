//! The tables of docs/reference/recommend.md must equal the output of results/recommend.sh in results/*/recommend.txt, with specs
//! shortened.

use gobo::shading::parse;
use std::path::Path;

/// Returns the table's lines, without default keys in the answer's cell.
fn table(printed: &str) -> String {
    let short = |cell: &str| match cell.trim().strip_prefix('`').and_then(|cell| cell.strip_suffix('`')) {
        Some(spec) => format!(" `{}` ", parse(spec).expect(spec)[0].short()),
        None => cell.to_owned(),
    };
    let line = |line: &str| line.split('|').map(short).collect::<Vec<_>>().join("|") + "\n";
    printed.lines().filter(|line| line.starts_with('|')).map(line).collect()
}

#[test]
fn what_was_recommended_is_what_was_printed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = root.join("docs/reference/recommend.md");
    let text = std::fs::read_to_string(&page).expect("the page");
    let (mut new, mut rest, mut tables) = (String::new(), text.as_str(), 0);
    while let Some((before, after)) = rest.split_once("<!-- recommended ") {
        let (folder, after) = after.split_once(" -->\n").expect("a comment ends");
        let (_, after) = after.split_once("<!-- /recommended -->").expect("a table ends");
        let printed = std::fs::read_to_string(root.join("results").join(folder).join("recommend.txt")).expect(folder);
        new += &format!("{before}<!-- recommended {folder} -->\n{}<!-- /recommended -->", table(&printed));
        (rest, tables) = (after, tables + 1);
    }
    new += rest;
    assert!(tables > 0);
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(&page, &new).expect("written");
    } else {
        assert!(new == text, "GOBO_WRITE_TABLES=1 cargo test --release --test docs recommended writes it anew:\n{new}");
    }
}
