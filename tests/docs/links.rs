//! Links between pages must lead to an existing file and heading.

use crate::guide::is_guide;
use crate::tables::{name, pages};
use std::path::{Path, PathBuf};

/// Returns the anchor that GitHub derives from a heading.
fn anchor(heading: &str) -> String {
    // A link in a heading contributes its text only.
    let mut text = heading.to_owned();
    while let Some((start, end)) = text.find("](").and_then(|at| Some((at, at + text[at..].find(')')?))) {
        text.replace_range(start..=end, "");
    }
    let kept = text.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

/// Returns the anchors of a page's headings; repeated ones are numbered.
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

/// Returns the targets of links in running text.
fn targets(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let after = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target.to_owned()));
    after.filter(|target| !target.contains(' ') && !target.contains("://")).collect()
}

/// Returns why a link of a page leads nowhere, if it does.
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

/// Every page must be linked from README.md, the index or a page of the guide.
#[test]
fn every_page_is_linked() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = pages(root);
    let leads = |page: &&PathBuf| {
        let name = name(root, page);
        is_guide(&name) || name == "README.md"
    };
    let linked: Vec<PathBuf> = all
        .iter()
        .filter(leads)
        .flat_map(|page| {
            let text = std::fs::read_to_string(page).expect("a page");
            let to = |target: String| page.parent()?.join(target.split('#').next()?).canonicalize().ok();
            targets(&text).into_iter().filter_map(to).filter(|to| to != page).collect::<Vec<_>>()
        })
        .collect();
    let is_lost =
        |page: &&PathBuf| **page != root.join("README.md") && !linked.contains(&page.canonicalize().expect("a page"));
    let lost: Vec<String> = all.iter().filter(is_lost).map(|page| name(root, page)).collect();
    assert!(lost.is_empty(), "nothing leads to {lost:?}");
}

#[test]
fn a_broken_link_is_found() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let text = "# One `two`: [three](x.md)\n\n## Again\n\n## Again\n\n[a](#one-two-three) [b](#again-1) [c](docs/none.md) [d](#two)\n\n```\n[e](f)\n```\n";
    let found: Vec<_> = targets(text).iter().filter_map(|target| broken(&page, text, target)).collect();
    assert_eq!(found, ["x.md: there is no such file", "docs/none.md: there is no such file", "#two: no such heading"]);
}

/// Returns the text under a heading, up to the next heading of the same rank; without a heading, the whole page.
fn under<'a>(text: &'a str, heading: &str) -> Option<&'a str> {
    if heading.is_empty() {
        return Some(text);
    }
    // `#version` in a block of code is not a heading.
    let rank = |line: &str| line.find(' ').filter(|at| line[..*at].chars().all(|c| c == '#')).unwrap_or(0);
    let mut at = 0;
    let (mut begin, mut own) = (None, 0);
    for line in text.split_inclusive('\n') {
        let is = rank(line);
        match begin {
            Some(begin) if is > 0 && is <= own => return Some(&text[begin..at]),
            None if is > 0 && anchor(line.trim_start_matches('#').trim()) == heading => {
                (begin, own) = (Some(at), is);
            }
            _ => {}
        }
        at += line.len();
    }
    Some(&text[begin?..])
}

/// Questions of a new user, listed in docs/notebook/words.md: README.md must link the page that answers, under the heading named in
/// italics, if any; that page must contain the quoted words under the heading that the link names.
#[test]
fn questions_are_answered_two_pages_from_readme() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let words = std::fs::read_to_string(root.join("docs/notebook/words.md")).expect("the page");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README");
    let section = under(&words, "five-questions-of-a-new-user").expect("questions");
    let mut count = 0;
    for row in section.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| question")) {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [question, way, answer] = cells[..] else { panic!("{row}") };
        let from = way.split('*').nth(1).map_or(Some(&readme[..]), |heading| under(&readme, &anchor(heading)));
        let from = from.unwrap_or_else(|| panic!("{question}: README.md has no such heading: {way}"));
        let to = targets(way).pop().unwrap_or_else(|| panic!("{question}: no link"));
        let (path, heading) = to.split_once('#').unwrap_or((&to, ""));
        let page = root.join("docs/notebook").join(path).canonicalize().expect(path);
        let is_it = |to: &String| {
            let to = root.join(to.split('#').next().unwrap_or(to)).canonicalize();
            to.is_ok_and(|to| to == page)
        };
        assert!(targets(from).iter().any(is_it), "{question}: README.md has no link to {} there", page.display());
        let text = std::fs::read_to_string(&page).expect("a page");
        let there = under(&text, heading).unwrap_or_else(|| panic!("{question}: {to}: there is no such heading"));
        let there = there.split_whitespace().collect::<Vec<_>>().join(" ");
        let quoted = answer.trim_matches('"');
        assert!(there.contains(quoted), "{question}: {to} does not say {quoted:?}");
        count += 1;
    }
    assert_eq!(count, 5, "questions");
}

#[test]
fn what_stands_under_a_heading() {
    let text = "# One\na\n## Two\nb\n### Three\nc\n## Four\nd\n";
    assert_eq!(under(text, "two"), Some("## Two\nb\n### Three\nc\n"));
    assert_eq!((under(text, "four"), under(text, "five")), (Some("## Four\nd\n"), None));
    assert_eq!(under(text, ""), Some(text));
}
