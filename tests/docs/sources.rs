//! Extracts sentences from sources: comments as one line per paragraph, and quoted texts, each with the number of its first line.

use std::path::{Path, PathBuf};

/// Returns the comment marks of a file, or `None` if it is not a source.
fn marks(file: &Path) -> Option<&'static [&'static str]> {
    let ending = file.extension().unwrap_or(file.file_name()?).to_str()?;
    match ending {
        "rs" => Some(&["///", "//!", "//"]),
        "glsl" | "comp" | "vert" | "frag" | "tesc" | "tese" | "geom" | "js" => Some(&["//"]),
        "sh" | "py" | "toml" | "yml" | "run" | "txt" | "script" => Some(&["#"]),
        _ => None,
    }
}

/// Returns the sources in a folder, or the given file itself, in order.
pub fn sources(place: &Path) -> Vec<PathBuf> {
    if !place.is_dir() {
        return if marks(place).is_some() { vec![place.to_owned()] } else { vec![] };
    }
    let within = std::fs::read_dir(place).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut within: Vec<PathBuf> = within.filter(|path| !path.ends_with("fuzz/target")).collect();
    within.sort();
    within.iter().flat_map(|path| sources(path)).collect()
}

/// Returns the comments of a source, one line per paragraph: consecutive lines with one mark, and comments after code with the lines below
/// that start in the same column.
pub fn comments(file: &Path, text: &str) -> Vec<(usize, String)> {
    let known = marks(file).expect("a source");
    let mut all: Vec<(usize, String)> = Vec::new();
    // Column and mark of the previous line, if it is a comment that may continue.
    let (mut before, mut is_code): (Option<(usize, &str)>, bool) = (None, false);
    for (number, line) in text.lines().enumerate().map(|(at, line)| (at + 1, line)) {
        let trimmed = line.trim_start();
        let Some(mark) = known.iter().copied().find(|mark| trimmed.starts_with(mark)) else {
            (before, is_code) = (None, false);
            let last = known[known.len() - 1];
            if let Some(at) = line.find(&format!(" {last} ")) {
                all.push((number, line[at + last.len() + 2..].trim().to_owned()));
                before = Some((at + 1, last));
            }
            continue;
        };
        let said = &trimmed[mark.len()..];
        let is_fence = said.trim_start().starts_with("```");
        is_code ^= is_fence;
        if is_code || is_fence || said.starts_with("     ") {
            before = None;
            continue;
        }
        let (here, said) = ((line.len() - trimmed.len(), mark), said.trim());
        let is_begin = said.is_empty() || ["#", "|", "- ", "* "].iter().any(|begin| said.starts_with(begin));
        match all.last_mut() {
            Some((_, last)) if before == Some(here) && !is_begin => *last += &format!(" {said}"),
            _ => all.push((number, said.to_owned())),
        }
        before = (!said.is_empty()).then_some(here);
    }
    all.retain(|(_, line)| !line.is_empty());
    all
}

/// Returns quoted texts of a Rust source that contain a blank: messages, help, headings. A `\` at a line's end joins it to the next.
pub fn texts(source: &str) -> Vec<(usize, String)> {
    let (mut all, mut line) = (Vec::new(), 1);
    let mut rest = source.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\n' => line += 1,
            '/' if rest.peek() == Some(&'/') => {
                for c in rest.by_ref() {
                    if c == '\n' {
                        line += 1;
                        break;
                    }
                }
            }
            // A quotation mark as a character.
            '\'' if rest.peek() == Some(&'"') => _ = rest.next(),
            '"' => {
                let (at, mut said) = (line, String::new());
                while let Some(c) = rest.next().filter(|c| *c != '"') {
                    line += usize::from(c == '\n');
                    match (c, c == '\\') {
                        (_, true) => match rest.next() {
                            Some('\n') => {
                                line += 1;
                                while rest.peek().is_some_and(|c| c.is_whitespace()) {
                                    line += usize::from(rest.next() == Some('\n'));
                                }
                            }
                            Some('n') => said.push(' '),
                            other => said.extend(other),
                        },
                        (c, false) => said.push(c),
                    }
                }
                if said.trim().contains(' ') {
                    all.push((at, said));
                }
            }
            _ => {}
        }
    }
    all
}

/// Returns the texts between tags of a page or its template that contain a blank.
pub fn between_tags(page: &str) -> Vec<(usize, String)> {
    let (mut all, mut line) = (Vec::new(), 1);
    for part in page.split('<') {
        let (tag, said) = part.split_once('>').unwrap_or(("", part));
        line += tag.matches('\n').count();
        if said.trim().contains(' ') {
            all.push((line, said.to_owned()));
        }
        line += said.matches('\n').count();
    }
    all
}
