//! A look-up as one text: includes are inserted, conditions evaluated and macros expanded. Only the preprocessor features used in glsl/ are
//! supported; any other is reported as an error by name.

use crate::{LOOK_UP, Sources, included};
use std::collections::BTreeMap;

/// A line of a file; empty if the line is a directive.
pub struct Line {
    pub file: String,
    pub text: String,
}

/// Lines, with the extensions that they require.
#[derive(Default)]
pub struct Preprocessed {
    pub lines: Vec<Line>,
    pub extensions: Vec<String>,
}

struct Macro {
    /// `None` for a macro without parentheses.
    parameters: Option<Vec<String>>,
    body: Vec<String>,
}

struct Reader<'s> {
    sources: &'s Sources,
    technique: &'s String,
    macros: BTreeMap<String, Macro>,
    out: Preprocessed,
}

/// Preprocesses the look-up of a technique, with `set` in place of GOBO_SET.
pub fn preprocess(sources: &Sources, technique: &String, set: &str) -> Result<Preprocessed, String> {
    let set = Macro { parameters: None, body: vec![set.into()] };
    let macros = BTreeMap::from([("GOBO_SET".to_owned(), set)]);
    let mut reader = Reader { sources, technique, macros, out: Preprocessed::default() };
    reader.read(&included(Some(technique), LOOK_UP))?;
    Ok(reader.out)
}

/// Splits text into words, runs of white space, comments, and single characters for everything else.
pub fn tokens(text: &str) -> Vec<&str> {
    let (mut rest, mut all) = (text, Vec::new());
    while let Some(first) = rest.chars().next() {
        let run = |is: fn(char) -> bool| rest.find(|c| !is(c)).unwrap_or(rest.len());
        let length = match first {
            _ if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            _ if is_of_word(first) => run(is_of_word),
            _ if first.is_whitespace() => run(char::is_whitespace),
            _ => first.len_utf8(),
        };
        let (token, after) = rest.split_at(length);
        all.push(token);
        rest = after;
    }
    all
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Returns whether a token is a name rather than a number or punctuation.
pub fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

impl Reader<'_> {
    fn read(&mut self, file: &str) -> Result<(), String> {
        let text = self.sources.get(file).ok_or_else(|| format!("{file}: no such file"))?.replace("\\\n", " ");
        // For each open #ifdef or #ifndef: whether the lines of its present branch are kept, and whether any branch so far was kept.
        let mut open: Vec<(bool, bool)> = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let fail = |what: &str| format!("glsl/{file}:{}: error: {what} in a look-up: {line}", number + 1);
            let counts = open.iter().all(|(counts, _)| *counts);
            let Some(directive) = line.trim_start().strip_prefix('#') else {
                if counts {
                    let text = self.replaced(line, &[]).map_err(|what| fail(&what))?;
                    self.out.lines.push(Line { file: file.into(), text });
                }
                continue;
            };
            let (word, rest) = directive.trim().split_once(' ').unwrap_or((directive.trim(), ""));
            let rest = rest.split("//").next().unwrap_or_default().trim();
            match word {
                "ifdef" | "ifndef" => {
                    let holds = self.macros.contains_key(rest) == (word == "ifdef");
                    open.push((holds, holds));
                }
                "else" => {
                    let (_, before) = open.pop().ok_or_else(|| fail("#else without #ifdef"))?;
                    open.push((!before, true));
                }
                "endif" => _ = open.pop().ok_or_else(|| fail("#endif without #ifdef"))?,
                "if" | "elif" => return Err(fail("#if is not known")),
                _ if !counts => {}
                "include" => self.read(&included(Some(self.technique), rest.trim_matches('"')))?,
                "define" => self.define(rest),
                "undef" => _ = self.macros.remove(rest),
                "extension" => {
                    if !self.out.extensions.iter().any(|e| e == rest) {
                        self.out.extensions.push(rest.into());
                    }
                }
                _ => return Err(fail("an unknown directive")),
            }
            // The lines before and after a directive are not adjacent.
            self.out.lines.push(Line { file: file.into(), text: String::new() });
        }
        Ok(())
    }

    fn define(&mut self, text: &str) {
        let name_end = text.find(|c| !is_of_word(c)).unwrap_or(text.len());
        let (name, rest) = text.split_at(name_end);
        let (parameters, body) = match rest.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
            Some((list, body)) => (Some(list.split(',').map(|p| p.trim().to_owned()).collect()), body),
            None => (None, rest),
        };
        let body = tokens(body.trim()).into_iter().map(str::to_owned).collect();
        self.macros.insert(name.into(), Macro { parameters, body });
    }

    /// Expands the macros of a line, except those in `within`, which are already being expanded.
    fn replaced(&self, line: &str, within: &[&str]) -> Result<String, String> {
        let line = tokens(line);
        let (mut text, mut at) = (String::new(), 0);
        while let Some(&token) = line.get(at) {
            at += 1;
            let known = self.macros.get(token).filter(|_| !within.contains(&token));
            let Some(known) = known else {
                text.push_str(token);
                continue;
            };
            let body = match &known.parameters {
                None => known.body.concat(),
                Some(_) if line.get(at) != Some(&"(") => {
                    text.push_str(token);
                    continue;
                }
                Some(parameters) => {
                    let (given, length) = arguments(&line[at..]).ok_or("a macro's parentheses end in another line")?;
                    at += length;
                    filled(&known.body, parameters, &given)
                }
            };
            text.push_str(&self.replaced(&body, &[within, &[token]].concat())?);
        }
        Ok(text)
    }
}

/// Returns the arguments in the parentheses that start the tokens, and how many tokens these take up.
fn arguments(line: &[&str]) -> Option<(Vec<String>, usize)> {
    let (mut depth, mut all) = (0, vec![String::new()]);
    for (i, token) in line.iter().enumerate() {
        depth += i32::from(*token == "(") - i32::from(*token == ")");
        match *token {
            ")" if depth == 0 => return Some((all.iter().map(|a| a.trim().to_owned()).collect(), i + 1)),
            "(" if i == 0 => {}
            "," if depth == 1 => all.push(String::new()),
            _ => all.last_mut()?.push_str(token),
        }
    }
    None
}

/// Returns a macro's body with its arguments filled in.
fn filled(body: &[String], parameters: &[String], given: &[String]) -> String {
    let of = |token: &String| parameters.iter().position(|p| p == token).and_then(|i| given.get(i));
    let text: String = body.iter().map(|token| of(token).unwrap_or(token).as_str()).collect();
    let mut parts = text.split("##");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all.trim_end().to_owned() + part.trim_start())
}
