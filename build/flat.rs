//! A technique's look-up as one GLSL file for other programs: includes are resolved, code that the look-up does not need is left out, names
//! are prefixed, and bindings and constants are renumbered. `gobo glsl` writes these files; src/glsl.rs documents what they promise.
//!
//! - `// flat: bindings 8, constants 16: FILTER FILTER_RADIUS` in a visibility.glsl sets where the file's bindings and constants start by
//!   default, and the order in which the constants are numbered; constants that it does not list follow in the order of the text.
//! - `// binding 3 text` describes a binding. A constant is described by the comment above or behind it.

use crate::preprocess::{is_name, preprocess};
use crate::units::{Kind, Unit, layout, local_names, member_names, members, needed, units};
use crate::{LOOK_UP, Sources};
use std::collections::{BTreeMap, BTreeSet};

/// The functions that a technique provides, and their names in its file. The last belongs to techniques that see smoke or hair.
const FUNCTIONS: [(&str, &str); 3] =
    [("light_visibility", "visibility"), ("light_receiver", "receiver"), (COLORS, "colors")];

/// Visibility of each color, for smoke that absorbs some colors more than others.
pub const COLORS: &str = "light_colors";

/// The receiver of a technique that defines none: the point itself.
const RECEIVER: &str = "vec3 light_receiver(uint light, vec3 position, vec3 normal) { return position; }";

/// Description of one binding of a file.
pub struct Binding {
    /// Number, counted from the first binding.
    pub number: u32,
    pub name: String,
    /// Name of its vk::DescriptorType.
    pub descriptor: &'static str,
    /// Type in GLSL: `Light[]`, `sampler2D`.
    pub glsl: String,
    /// Number of bytes of a buffer's element, or of the whole buffer if it is not an array; otherwise 0.
    pub stride: u32,
    pub about: String,
}

/// Description of one specialization constant of a file; ids are consecutive, in the order of the list.
pub struct Constant {
    pub name: String,
    pub glsl: String,
    pub default: String,
    pub about: String,
}

/// A file and its description.
pub struct Flat {
    pub text: String,
    pub first_binding: u32,
    pub first_constant: u32,
    pub bindings: Vec<Binding>,
    pub constants: Vec<Constant>,
}

/// The names used by a technique's file.
struct Names {
    /// `gobo_avsm_`
    prefix: String,
    /// `GOBO_AVSM_`
    macros: String,
    /// Global names, with the name that replaces each.
    renamed: BTreeMap<String, String>,
    structs: BTreeSet<String>,
    /// Fields of structs, and of buffers that have a name of their own.
    members: BTreeSet<String>,
}

/// Prefix of names that are not global: another program may define a macro called `size`.
const LOCAL: &str = "gobo_";

/// Contents of a `// flat:` comment.
#[derive(Default)]
struct Numbers {
    binding: u32,
    constant: u32,
    order: Vec<String>,
}

/// Builds the file of the technique in folder `technique`.
pub fn flat(sources: &Sources, technique: &String) -> Result<Flat, String> {
    let word = technique.rsplit('/').next().unwrap_or(technique).replace('-', "_");
    let mut names = Names {
        prefix: format!("{LOCAL}{word}_"),
        macros: format!("GOBO_{}_", word.to_uppercase()),
        renamed: BTreeMap::new(),
        structs: BTreeSet::new(),
        members: BTreeSet::new(),
    };
    let mut read = preprocess(sources, technique, &format!("{}SET", names.macros))?;
    if !read.lines.iter().any(|line| line.text.contains(" light_receiver(")) {
        let file = read.lines.last().map_or(String::new(), |line| line.file.clone());
        let line = |text: &str| crate::preprocess::Line { file: file.clone(), text: text.into() };
        read.lines.extend([line(""), line("// It answers at every point as it is."), line(RECEIVER)]);
    }
    let all = units(&read.lines)?;
    let is_needed = needed(&all, &FUNCTIONS.map(|(name, _)| name));
    // The comments of a source file are kept if any of its code is.
    let files: BTreeSet<_> =
        all.iter().zip(&is_needed).filter(|(_, needed)| **needed).map(|(u, _)| u.file.clone()).collect();
    let units: Vec<_> = all
        .into_iter()
        .zip(is_needed)
        .filter(|(unit, needed)| *needed || unit.kind == Kind::Comment && files.contains(&unit.file))
        .map(|(unit, _)| unit)
        .collect();
    names.rename(&units)?;
    let numbers = numbers(&sources[&format!("{technique}/{LOOK_UP}")])?;
    let constants = constants(&units, &numbers.order);
    let bindings = bindings(&units, &names)?;
    let mut flat = Flat {
        text: String::new(),
        first_binding: numbers.binding,
        first_constant: numbers.constant,
        bindings,
        constants,
    };
    flat.text = text(&flat, technique, &read.extensions, &units, &names)?;
    Ok(flat)
}

impl Names {
    fn rename(&mut self, units: &[Unit]) -> Result<(), String> {
        let mut taken = BTreeMap::new();
        for name in units.iter().flat_map(|unit| &unit.names) {
            let special = FUNCTIONS.iter().find(|(function, _)| function == name).map(|(_, short)| *short);
            let new = format!("{}{}", self.prefix, special.unwrap_or(name));
            if let Some(other) = taken.insert(new.clone(), name).filter(|other| *other != name) {
                return Err(format!("error: {other} and {name} would both be {new}"));
            }
            self.renamed.insert(name.clone(), new);
        }
        for unit in units.iter().filter(|unit| unit.kind == Kind::Struct) {
            self.structs.insert(unit.names[0].clone());
            self.members.extend(member_names(&unit.tokens).into_iter().map(str::to_owned));
        }
        if let Some(member) = self.members.iter().find(|member| is_swizzle(member)) {
            return Err(format!("error: a member {member} may be parts of a vector"));
        }
        Ok(())
    }

    fn of<'n>(&'n self, name: &'n str) -> &'n str {
        self.renamed.get(name).map_or(name, String::as_str)
    }

    /// Returns a unit's text with the names used by the file.
    fn renamed(&self, unit: &Unit) -> String {
        let structs = self.structs.iter().map(String::as_str).collect();
        let own = match unit.kind {
            Kind::Struct => member_names(&unit.tokens).into_iter().collect(),
            Kind::Function => local_names(&unit.tokens, &structs),
            _ => BTreeSet::new(),
        };
        let (mut text, mut before) = (String::new(), "");
        for (i, token) in unit.tokens.iter().enumerate() {
            let is_called = unit.tokens.get(i + 1).is_some_and(|next| next == "(");
            let is_local = if before == "." { self.members.contains(token) } else { own.contains(token.as_str()) };
            match token.as_str() {
                token if is_local && !is_called => text += &format!("{LOCAL}{token}"),
                token if before == "." || token.starts_with("//") => text += token,
                token => text += self.of(token),
            }
            if !token.trim().is_empty() {
                before = token;
            }
        }
        text
    }
}

/// Returns whether a member could be a swizzle of a vector.
fn is_swizzle(member: &str) -> bool {
    let of = |parts: &str| member.chars().all(|c| parts.contains(c));
    member.len() < 5 && ["xyzw", "rgba", "stpq"].into_iter().any(of)
}

fn numbers(text: &str) -> Result<Numbers, String> {
    let Some(line) = text.lines().find_map(|line| line.strip_prefix("// flat: ")) else {
        return Ok(Numbers::default());
    };
    let fail = || format!("error: write `// flat: bindings 8, constants 16: NAME …`, and not {line}");
    let (bases, order) = line.split_once(':').ok_or_else(fail)?;
    let (bindings, constants) = bases.split_once(", ").ok_or_else(fail)?;
    let number = |text: &str, word: &str| text.strip_prefix(word).and_then(|n| n.trim().parse().ok()).ok_or_else(fail);
    Ok(Numbers {
        binding: number(bindings, "bindings ")?,
        constant: number(constants, "constants ")?,
        order: order.split_whitespace().map(str::to_owned).collect(),
    })
}

/// Joins the lines of a comment into one text.
fn prose(lines: &[String]) -> String {
    let lines: Vec<_> = lines.iter().map(|line| line.trim_start_matches('/').trim()).collect();
    lines.join(" ").trim().to_owned()
}

fn constants(units: &[Unit], order: &[String]) -> Vec<Constant> {
    let mut all: Vec<_> = units.iter().filter(|unit| unit.kind == Kind::Constant).collect();
    all.sort_by_key(|unit| order.iter().position(|name| *name == unit.names[0]).unwrap_or(usize::MAX));
    let constant = |unit: &&Unit| {
        let code = unit.tokens.concat();
        let words: Vec<_> = code.trim_end_matches(')').splitn(3, ',').map(str::trim).collect();
        let comment: Vec<_> = unit.comment.iter().chain(&unit.trailing).cloned().collect();
        Constant {
            name: unit.names[0].clone(),
            glsl: words[0].trim_start_matches("CONSTANT(").to_owned(),
            default: words[2].to_owned(),
            about: prose(&comment),
        }
    };
    all.iter().map(constant).collect()
}

/// Returns the description of each binding, by number: the text of a line `// binding 3 text`, joined with its continuation lines.
fn said_of_bindings(units: &[Unit]) -> BTreeMap<u32, String> {
    let mut said: BTreeMap<u32, String> = BTreeMap::new();
    for unit in units.iter().filter(|unit| unit.kind == Kind::Comment) {
        let mut last = None;
        for line in &unit.comment {
            let text = line.trim_start_matches('/');
            if let Some((number, about)) = text.trim().strip_prefix("binding ").and_then(|rest| rest.split_once("  ")) {
                last = number.parse().ok();
                said.extend(last.map(|number: u32| (number, about.trim().to_owned())));
            } else if let Some(about) = last.and_then(|n| said.get_mut(&n)).filter(|_| text.starts_with("      ")) {
                about.push(' ');
                about.push_str(text.trim());
            } else {
                last = None;
            }
        }
    }
    said
}

/// Returns the number of bytes that a type has in scalar layout, or `None` for a type without a size.
fn bytes(units: &[Unit], glsl: &str, array: &str) -> Option<u32> {
    let each = match glsl {
        "float" | "int" | "uint" => 4,
        _ => match glsl.trim_start_matches(['u', 'i']).strip_prefix("vec") {
            Some(n) => 4 * n.parse::<u32>().ok()?,
            None => {
                let of = units.iter().find(|u| u.kind == Kind::Struct && u.names[0] == glsl)?;
                members(&of.tokens).iter().map(|(glsl, _, array)| bytes(units, glsl, array)).sum::<Option<u32>>()?
            }
        },
    };
    let count = array.trim_matches(['[', ']']);
    if count.is_empty() { Some(each) } else { Some(each * count.parse::<u32>().ok()?) }
}

fn bindings(units: &[Unit], names: &Names) -> Result<Vec<Binding>, String> {
    let said = said_of_bindings(units);
    let mut all = Vec::new();
    for unit in units.iter().filter(|unit| matches!(unit.kind, Kind::Block | Kind::Variable)) {
        let (layout, code) = layout(&unit.tokens);
        let Some(at) = layout.windows(2).position(|pair| pair == ["binding", "="]) else { continue };
        let fail = || format!("glsl/{}: error: what is bound by {}", unit.file, unit.tokens.concat());
        let number: u32 = layout.get(at + 2).and_then(|n| n.parse().ok()).ok_or_else(fail)?;
        let (descriptor, glsl, stride) = if unit.kind == Kind::Block {
            let members = members(&unit.tokens);
            let [(glsl, _, array)] = &members[..] else { return Err(fail()) };
            let stride = bytes(units, glsl, array).ok_or_else(fail)?;
            ("STORAGE_BUFFER", format!("{}{array}", names.of(glsl)), stride)
        } else {
            let glsl = *code.iter().rev().nth(2).ok_or_else(fail)?;
            let format = layout.iter().rfind(|word| is_name(word) && word.starts_with(['r', 'R']));
            match glsl {
                "accelerationStructureEXT" => ("ACCELERATION_STRUCTURE_KHR", glsl.to_owned(), 0),
                _ if glsl.contains("sampler") => ("COMBINED_IMAGE_SAMPLER", glsl.to_owned(), 0),
                _ if glsl.contains("texture") => ("SAMPLED_IMAGE", glsl.to_owned(), 0),
                _ => ("STORAGE_IMAGE", format!("{glsl}, {}", format.ok_or_else(fail)?), 0),
            }
        };
        let name = names.of(unit.names.last().ok_or_else(fail)?).to_owned();
        let about = said.get(&number).cloned().unwrap_or_default();
        all.push(Binding { number, name, descriptor, glsl, stride, about });
    }
    all.sort_by_key(|binding| binding.number);
    Ok(all)
}

/// Returns a unit's code as it appears in the file.
fn written(unit: &Unit, flat: &Flat, names: &Names) -> String {
    let prefix = &names.macros;
    let mut code = match flat.constants.iter().position(|c| unit.kind == Kind::Constant && c.name == unit.names[0]) {
        Some(id) => {
            let Constant { glsl, name, default, .. } = &flat.constants[id];
            format!("layout(constant_id = {prefix}CONSTANT + {id}) const {glsl} {} = {default};", names.of(name))
        }
        None => names.renamed(unit).replacen("binding = ", &format!("binding = {prefix}BINDING + "), 1),
    };
    if let Some(comment) = &unit.trailing {
        code = format!("{code}  {comment}");
    }
    let comment = unit.comment.iter().filter(|line| !line.starts_with("// flat: "));
    comment.cloned().chain(Some(code)).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n") + "\n"
}

/// `#ifndef NAME`, `#define NAME value`, `#endif`
fn default(name: &str, value: u32) -> String {
    format!("#ifndef {name}\n#define {name} {value}\n#endif\n")
}

fn text(flat: &Flat, technique: &str, extensions: &[String], units: &[Unit], names: &Names) -> Result<String, String> {
    let macros = &names.macros;
    let mut text = crate::head::head(flat, technique, extensions, units, (&names.prefix, macros), |u| names.renamed(u));
    text += &format!("#ifndef {macros}GLSL\n#define {macros}GLSL\n");
    extensions.iter().for_each(|extension| text += &format!("#extension {extension}\n"));
    text += &default(&format!("{macros}SET"), 1);
    text += &default(&format!("{macros}BINDING"), flat.first_binding);
    text += &default(&format!("{macros}CONSTANT"), flat.first_constant);
    let mut file = "";
    for unit in units {
        if unit.apart || unit.file != file {
            text.push('\n');
        }
        if unit.file != file {
            file = &unit.file;
            text += &format!("// --- {file}\n");
        }
        text += &written(unit, flat, names);
    }
    // Directives leave empty lines behind.
    while text.contains("\n\n\n") {
        text = text.replace("\n\n\n", "\n\n");
    }
    Ok(text + "#endif\n")
}
