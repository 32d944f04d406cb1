//! Sentences of sources: comments, each paragraph a line, and texts in quotation marks, with the number of the line where each begins.

use std::path::{Path, PathBuf};

/// How comments of a file begin, or `None` where it is no source.
fn marks(file: &Path) -> Option<&'static [&'static str]> {
    let ending = file.extension().unwrap_or(file.file_name()?).to_str()?;
    match ending {
        "rs" => Some(&["///", "//!", "//"]),
        "glsl" | "comp" | "vert" | "frag" | "tesc" | "tese" | "geom" | "js" => Some(&["//"]),
        "sh" | "py" | "toml" | "yml" | "run" | "txt" | "script" => Some(&["#"]),
        _ => None,
    }
}

/// Sources below a folder, or the one that it is, in order.
pub fn sources(place: &Path) -> Vec<PathBuf> {
    if !place.is_dir() {
        return if marks(place).is_some() { vec![place.to_owned()] } else { vec![] };
    }
    let within = std::fs::read_dir(place).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut within: Vec<PathBuf> = within.filter(|path| !path.ends_with("fuzz/target")).collect();
    within.sort();
    within.iter().flat_map(|path| sources(path)).collect()
}

/// Comments of a source, each paragraph a line: whole lines of one mark, and what stands behind code with the lines below it that begin
/// in the same column.
pub fn comments(file: &Path, text: &str) -> Vec<(usize, String)> {
    let known = marks(file).expect("a source");
    let mut all: Vec<(usize, String)> = Vec::new();
    // Column and mark of the line before, where it is a comment that goes on.
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

/// Texts in quotation marks of a Rust source that have a blank: messages, help, headings. A `\` at a line's end joins it to the next.
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

/// Texts of a page or its template that have a blank, between one tag and the next.
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
