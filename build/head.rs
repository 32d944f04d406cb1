//! The comment at the top of a flat file: what the file computes, its inputs and its requirements.

use crate::flat::{Binding, COLORS, Constant, Flat};
use crate::units::{Kind, Unit};

/// Width of a comment line, in columns.
const WIDTH: usize = 118;

/// Returns the device feature required by a GLSL extension.
fn needs(extension: &str) -> Option<&'static str> {
    match extension {
        "GL_EXT_scalar_block_layout" => Some("scalarBlockLayout"),
        "GL_EXT_ray_query" => {
            Some("rayQuery and accelerationStructure (VK_KHR_ray_query, VK_KHR_acceleration_structure)")
        }
        _ => None,
    }
}

/// Wraps text into comment lines, the first behind `first`, the others indented by `indent`.
fn wrapped(first: &str, indent: usize, text: &str) -> String {
    let (mut all, mut line) = (String::new(), format!("// {first}"));
    for word in text.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            all += line.trim_end();
            all.push('\n');
            line = format!("//{}", " ".repeat(indent));
        }
        if !line.ends_with(' ') {
            line.push(' ');
        }
        line += word;
    }
    all + line.trim_end() + "\n"
}

/// Returns the start of the first comment in a technique's own files, up to an empty line or a list of bindings.
fn answers(units: &[Unit], technique: &str) -> String {
    let own = |unit: &&Unit| unit.kind == Kind::Comment && unit.file.starts_with(&format!("{technique}/"));
    let lines = units.iter().find(own).map(|unit| &unit.comment[..]).unwrap_or_default();
    let lines = lines.iter().map(|line| line.trim_start_matches('/').trim());
    let ends =
        |line: &str| line.is_empty() || ["Binding", "binding", "flat:"].iter().any(|word| line.starts_with(word));
    lines.take_while(|line| !ends(line)).collect::<Vec<_>>().join(" ")
}

fn binding(binding: &Binding) -> String {
    let Binding { number, name, descriptor, glsl, stride, about } = binding;
    let size = match stride {
        0 => String::new(),
        _ if glsl.ends_with("[]") => format!(", {stride} bytes each"),
        _ => format!(", {stride} bytes"),
    };
    let what = if *descriptor == "STORAGE_BUFFER" { "readonly buffer " } else { "" };
    wrapped(&format!("  +{number}"), 6, &format!("{what}{glsl}{size} ({name}): {about}"))
}

fn constant(id: usize, constant: &Constant, prefix: &str) -> String {
    let Constant { name, glsl, default, about } = constant;
    wrapped(&format!("  +{id:<2}"), 6, &format!("{glsl} {prefix}{name}, by default {default}: {about}"))
}

/// Describes a variable that a consumer may set before a look-up.
fn variable(unit: &Unit, renamed: &str) -> Option<String> {
    let about = unit.comment.iter().map(|l| l.trim_start_matches('/').trim()).collect::<Vec<_>>().join(" ");
    let is_free = unit.kind == Kind::Variable
        && !["const", "layout"].iter().any(|word| renamed.starts_with(word))
        && !about.starts_with("Set by each look-up");
    is_free.then(|| wrapped(&format!("  {}", renamed.trim_end_matches(';')), 6, &format!(": {about}")))
}

/// Returns the whole comment. `names` are the prefixes of names and of macros.
pub fn head(
    flat: &Flat,
    technique: &str,
    extensions: &[String],
    units: &[Unit],
    (prefix, macros): (&str, &str),
    renamed: impl Fn(&Unit) -> String,
) -> String {
    let mut text = wrapped("", 1, &answers(units, technique));
    text += "//\n";
    text += &wrapped(
        "",
        1,
        &format!(
            "Made by Gobo {} from glsl/{technique}/; MIT or Apache-2.0. Include it behind #version 460. Every global name begins \
             with {prefix} or {macros}, every other with gobo_; comments say names without that. Files of several techniques may be \
             included in one shader.",
            env!("CARGO_PKG_VERSION")
        ),
    );
    text += "//\n// Functions\n";
    text += &format!("//   float {prefix}visibility(uint light, vec3 position)\n");
    text += "//      How much of light `light` reaches `position`, world units: 1 all of it, 0 none.\n";
    text += &format!("//   vec3 {prefix}receiver(uint light, vec3 position, vec3 normal)\n");
    text += "//      The place at which a surface's point is looked up; `normal`: unit length, on the side that light is asked for.\n";
    if units.iter().any(|unit| unit.names.iter().any(|name| name == COLORS)) {
        text += &format!("//   vec3 {prefix}colors(float visibility, vec3 extinction)\n");
        text += "//      Call it right behind visibility: the same for red, green and blue, whose extinction in smoke and hair is that\n";
        text += "//      multiple of the casters' own. Meshes end all colors alike.\n";
    }
    let free: Vec<_> = units.iter().filter_map(|unit| variable(unit, &renamed(unit))).collect();
    if !free.is_empty() {
        text += &format!("// Variables that may be set before\n{}", free.concat());
    }
    let (set, first) = (format!("{macros}SET"), format!("{macros}BINDING"));
    text += &format!("// Bindings, from {first} on (by default {}) in set {set} (by default 1)\n", flat.first_binding);
    flat.bindings.iter().for_each(|b| text += &binding(b));
    if !flat.constants.is_empty() {
        text += &format!(
            "// Specialization constants, from id {macros}CONSTANT on (by default {}); what is built says each\n",
            flat.first_constant
        );
    }
    flat.constants.iter().enumerate().for_each(|(id, c)| text += &constant(id, c, prefix));
    let names: Vec<_> = extensions.iter().map(|e| e.split_whitespace().next().unwrap_or_default()).collect();
    let features: Vec<_> = names.iter().filter_map(|name| needs(name)).collect();
    let features = if features.is_empty() { "none beyond Vulkan 1.2".into() } else { features.join(", ") };
    let glsl = if names.is_empty() { "no extension".into() } else { names.join(", ") };
    text += &wrapped("Needs", 1, &format!("Vulkan 1.2; features: {features}; GLSL: {glsl}"));
    text
}
