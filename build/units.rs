//! Splits a GLSL text into declarations, finds the names that each declares, and selects the declarations that a look-up needs.

use crate::preprocess::{Line, is_name, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// Kind of a declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Comment lines that belong to no declaration.
    Comment,
    /// `CONSTANT(type, NAME, value)`
    Constant,
    Struct,
    Function,
    /// A buffer.
    Block,
    /// A constant, a variable, an image or a sampler.
    Variable,
}

/// A declaration at the top level of a file.
pub struct Unit {
    pub file: String,
    pub kind: Kind,
    /// The comment lines directly above the declaration.
    pub comment: Vec<String>,
    /// The declaration's tokens, including comments and white space.
    pub tokens: Vec<String>,
    /// The comment at the end of the declaration's last line.
    pub trailing: Option<String>,
    /// Whether the declaration follows an empty line.
    pub apart: bool,
    /// The names declared.
    pub names: Vec<String>,
}

/// Splits `lines` into declarations, in order.
pub fn units(lines: &[Line]) -> Result<Vec<Unit>, String> {
    let mut units = Vec::new();
    for part in lines.chunk_by(|a, b| a.file == b.file) {
        let text: Vec<_> = part.iter().map(|l| l.text.trim_end()).collect();
        let file = &part[0].file;
        units_of(file, &text.join("\n"), &mut units).map_err(|e| format!("glsl/{file}: error: {e}"))?;
    }
    Ok(units)
}

fn units_of(file: &str, text: &str, units: &mut Vec<Unit>) -> Result<(), String> {
    let all = tokens(text);
    let (mut at, mut apart, mut comment) = (0, true, Vec::new());
    let new = |kind, comment, tokens, trailing, apart, names| Unit {
        file: file.into(),
        kind,
        comment,
        tokens,
        trailing,
        apart,
        names,
    };
    while let Some(token) = all.get(at) {
        if token.trim().is_empty() {
            if token.matches('\n').count() > 1 {
                if !comment.is_empty() {
                    units.push(new(Kind::Comment, std::mem::take(&mut comment), vec![], None, true, vec![]));
                }
                apart = true;
            }
            at += 1;
        } else if token.starts_with("//") {
            comment.push((*token).to_owned());
            at += 1;
        } else {
            let length = length_of(&all[at..]).ok_or("a declaration does not end in its file")?;
            let own: Vec<_> = all[at..at + length].iter().map(|t| (*t).to_owned()).collect();
            at += length;
            let trailing = match all[at..] {
                [space, comment, ..] if comment.starts_with("//") && !space.contains('\n') => Some(comment.to_owned()),
                _ => None,
            };
            at += if trailing.is_some() { 2 } else { 0 };
            let (kind, names) = declared(&own).ok_or_else(|| format!("what is declared by {}", own.concat()))?;
            units.push(new(kind, std::mem::take(&mut comment), own, trailing, apart, names));
            apart = false;
        }
    }
    if !comment.is_empty() {
        units.push(new(Kind::Comment, comment, vec![], None, true, vec![]));
    }
    Ok(())
}

/// Returns the number of tokens in the declaration that `all` starts with.
fn length_of(all: &[&str]) -> Option<usize> {
    let (mut depth, mut before, mut is_function) = (0, "", false);
    for (i, token) in all.iter().enumerate().filter(|(_, t)| is_code(t)) {
        match *token {
            "{" | "(" | "[" => {
                is_function |= *token == "{" && depth == 0 && before == ")";
                depth += 1;
            }
            "}" | ")" | "]" => depth -= 1,
            _ => {}
        }
        let ends = match *token {
            ";" => true,
            "}" => is_function,
            ")" => all[0] == "CONSTANT",
            _ => false,
        };
        if ends && depth == 0 {
            return Some(i + 1);
        }
        before = token;
    }
    None
}

fn is_code(token: &str) -> bool {
    !token.starts_with("//") && !token.trim().is_empty()
}

/// A token with its nesting depth: the number of open parentheses and square brackets (`round`) and of open braces (`curly`).
struct Placed<'t> {
    text: &'t str,
    round: i32,
    curly: i32,
}

/// Returns the tokens without comments and white space.
fn placed(tokens: &[String]) -> Vec<Placed<'_>> {
    let (mut round, mut curly) = (0, 0);
    let mut all = Vec::new();
    for token in tokens.iter().filter(|t| is_code(t)) {
        let text = token.as_str();
        round -= i32::from(matches!(text, ")" | "]"));
        curly -= i32::from(text == "}");
        all.push(Placed { text, round, curly });
        round += i32::from(matches!(text, "(" | "["));
        curly += i32::from(text == "{");
    }
    all
}

/// Returns the arguments of the `layout(…)` at the start of a declaration, and the tokens after it.
pub fn layout(tokens: &[String]) -> (Vec<&str>, Vec<&str>) {
    let code: Vec<_> = tokens.iter().filter(|t| is_code(t)).map(String::as_str).collect();
    match code.iter().position(|t| *t == ")") {
        Some(end) if code[0] == "layout" => (code[2..end].to_vec(), code[end + 1..].to_vec()),
        _ => (Vec::new(), code),
    }
}

fn declared(tokens: &[String]) -> Option<(Kind, Vec<String>)> {
    let code = layout(tokens).1;
    let at = |mark: &str| code.iter().position(|t| *t == mark).unwrap_or(usize::MAX);
    let name = |i: usize| code.get(i).map(|n| vec![(*n).to_owned()]);
    let (brace, round, equals) = (at("{"), at("("), at("="));
    match code[0] {
        "CONSTANT" => return Some((Kind::Constant, name(4)?)),
        "struct" => return Some((Kind::Struct, name(1)?)),
        _ => {}
    }
    if round < equals && round < brace {
        return Some((Kind::Function, name(round.checked_sub(1)?)?));
    }
    if brace < equals {
        let mut names = name(brace.checked_sub(1)?)?;
        match code[code.len() - 2] {
            "}" => names.extend(member_names(tokens).into_iter().map(str::to_owned)),
            instance => names.push(instance.to_owned()),
        }
        return Some((Kind::Block, names));
    }
    let code = placed(tokens);
    let (mut names, mut is_value) = (Vec::new(), false);
    for pair in code.windows(2).filter(|pair| pair[0].round == 0 && pair[0].curly == 0) {
        is_value = match pair[0].text {
            "=" => true,
            "," => false,
            _ => is_value,
        };
        if !is_value && is_name(pair[0].text) && matches!(pair[1].text, "=" | ";" | "," | "[") {
            names.push(pair[0].text.to_owned());
        }
    }
    Some((Kind::Variable, names))
}

/// Returns the names of the members of a struct or a buffer; a name that is declared several times is listed several times.
pub fn member_names(tokens: &[String]) -> Vec<&str> {
    let all = placed(tokens);
    let is_member = |pair: &&[Placed]| {
        let [before, name] = pair else { return false };
        name.curly == 1
            && name.round == 0
            && is_name(name.text)
            && (is_name(before.text) || matches!(before.text, "," | "]"))
    };
    all.windows(2).filter(is_member).map(|pair| pair[1].text).collect()
}

/// Returns the members of a struct or a buffer with their types, `(type, name, array)`.
pub fn members(tokens: &[String]) -> Vec<(String, String, String)> {
    let code: Vec<_> = tokens.iter().filter(|t| is_code(t)).map(String::as_str).collect();
    let (Some(start), Some(end)) = (code.iter().position(|t| *t == "{"), code.iter().rposition(|t| *t == "}")) else {
        return Vec::new();
    };
    let all = code[start + 1..end].split(|t| *t == ";").filter(|member| member.len() > 1);
    all.map(|member| (member[0].to_owned(), member[1].to_owned(), member[2..].concat())).collect()
}

/// Returns whether a word is a built-in GLSL type.
fn is_type(word: &str) -> bool {
    const OTHERS: [&str; 5] = ["float", "int", "uint", "bool", "rayQueryEXT"];
    let is_some =
        |of: &str| word.trim_start_matches(['i', 'u', 'b']).strip_prefix(of).is_some_and(|rest| rest.len() < 4);
    OTHERS.contains(&word) || ["vec", "mat", "image", "sampler", "texture"].into_iter().any(is_some)
}

/// Returns the names that a function declares: parameters and local variables. `structs` holds the types that the text defines.
pub fn local_names<'t>(tokens: &'t [String], structs: &BTreeSet<&str>) -> BTreeSet<&'t str> {
    const QUALIFIERS: [&str; 5] = ["in", "out", "inout", "const", "precise"];
    let is_type = |word: &str| is_type(word) || structs.contains(word);
    // A name after a comma declares a variable, unless it is the next parameter's type.
    let is_new = |word: &str| !is_type(word) && !QUALIFIERS.contains(&word);
    let (code, mut names, mut declaring) = (placed(tokens), BTreeSet::new(), None);
    for pair in code.windows(2) {
        let [first, second] = [&pair[0], &pair[1]];
        match first.text {
            ";" => declaring = None,
            ")" if declaring.is_some_and(|round| first.round < round) => declaring = None,
            text if is_type(text) && is_name(second.text) => {
                declaring = Some(first.round);
                names.insert(second.text);
            }
            "," if declaring == Some(first.round) && is_name(second.text) && is_new(second.text) => {
                names.insert(second.text);
            }
            _ => {}
        }
    }
    names
}

/// Returns which units are needed, directly or indirectly, by `roots`.
pub fn needed(units: &[Unit], roots: &[&str]) -> Vec<bool> {
    let mut of: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (i, name) in units.iter().enumerate().flat_map(|(i, unit)| unit.names.iter().map(move |n| (i, n))) {
        of.entry(name).or_default().push(i);
    }
    let mut open: Vec<&str> = roots.to_vec();
    let (mut seen, mut is_needed) = (BTreeSet::new(), vec![false; units.len()]);
    while let Some(name) = open.pop() {
        if !seen.insert(name) {
            continue;
        }
        for &i in of.get(name).into_iter().flatten() {
            is_needed[i] = true;
            open.extend(units[i].tokens.iter().map(String::as_str).filter(|t| of.contains_key(t)));
        }
    }
    is_needed
}
