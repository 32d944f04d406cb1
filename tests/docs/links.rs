//! Links between pages lead somewhere: the file is there, and so is the heading.

use crate::tables::{name, pages};
use std::path::{Path, PathBuf};

/// What GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    // A link in a heading is its text alone.
    let mut text = heading.to_owned();
    while let Some((start, end)) = text.find("](").and_then(|at| Some((at, at + text[at..].find(')')?))) {
        text.replace_range(start..=end, "");
    }
    let kept = text.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

/// Anchors of a page's headings, numbered where one is there again.
fn anchors(text: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        if let Some(heading) = line.strip_prefix('#').filter(|_| !is_code) {
            let base = anchor(heading.trim_start_matches('#').trim());
            let before = all.iter().filter(|one| **one == base).count();
            all.push(if before == 0 { base } else { format!("{base}-{before}") });
        }
    }
    all
}

/// What links in running text name.
fn targets(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let after = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target.to_owned()));
    after.filter(|target| !target.contains(' ') && !target.contains("://")).collect()
}

/// Why a link of a page leads nowhere, if it does.
fn broken(page: &Path, text: &str, target: &str) -> Option<String> {
    let (path, heading) = target.split_once('#').unwrap_or((target, ""));
    let to: PathBuf = if path.is_empty() { page.to_owned() } else { page.parent()?.join(path) };
    if !to.exists() {
        return Some(format!("{target}: there is no such file"));
    }
    if heading.is_empty() || to.extension().is_none_or(|ending| ending != "md") {
        return None;
    }
    let there = if path.is_empty() { text.to_owned() } else { std::fs::read_to_string(&to).ok()? };
    (!anchors(&there).iter().any(|one| one == heading)).then(|| format!("{target}: no such heading"))
}

#[test]
fn links_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let others = ["CONTRIBUTING.md", "CHANGELOG.md", "tests/README.md", "results/community/README.md"];
    let (mut count, mut off) = (0, Vec::new());
    for page in pages(root).into_iter().chain(others.map(|page| root.join(page))) {
        let text = std::fs::read_to_string(&page).expect("a page");
        for target in targets(&text) {
            count += 1;
            off.extend(broken(&page, &text, &target).map(|why| format!("{}: {why}", name(root, &page))));
        }
    }
    assert!(count > 500, "{count} links: where are the others?");
    assert!(off.is_empty(), "{} of {count} lead nowhere:\n{}", off.len(), off.join("\n"));
}

#[test]
fn a_broken_link_is_found() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let text = "# One `two`: [three](x.md)\n\n## Again\n\n## Again\n\n[a](#one-two-three) [b](#again-1) [c](docs/none.md) [d](#two)\n\n```\n[e](f)\n```\n";
    let found: Vec<_> = targets(text).iter().filter_map(|target| broken(&page, text, target)).collect();
    assert_eq!(found, ["x.md: there is no such file", "docs/none.md: there is no such file", "#two: no such heading"]);
}

/// Questions of a new user, as docs/notebook/words.md has them: the page that answers is README.md or one that README.md links, and it has
/// the words that are quoted.
#[test]
fn questions_are_answered_two_pages_from_readme() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let words = std::fs::read_to_string(root.join("docs/notebook/words.md")).expect("the page");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README");
    let linked: Vec<PathBuf> =
        targets(&readme).iter().map(|to| root.join(to.split('#').next().unwrap_or(to))).collect();
    let section =
        words.split("## Five questions").nth(1).and_then(|rest| rest.split("\n## ").next()).expect("questions");
    let mut count = 0;
    for row in section.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| question")) {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [question, way, answer] = cells[..] else { panic!("{row}") };
        let page = targets(way).last().map_or(root.join("README.md"), |to| {
            root.join("docs/notebook").join(to.split('#').next().unwrap_or(to)).canonicalize().expect(to)
        });
        let is_near =
            page.ends_with("README.md") || linked.iter().any(|to| to.canonicalize().is_ok_and(|to| to == page));
        assert!(is_near, "{question}: README.md has no link to {}", page.display());
        let text = std::fs::read_to_string(&page).expect("a page").split_whitespace().collect::<Vec<_>>().join(" ");
        let quoted = answer.trim_matches('"');
        assert!(text.contains(quoted), "{question}: {} does not say {quoted:?}", page.display());
        count += 1;
    }
    assert_eq!(count, 5, "questions");
}
