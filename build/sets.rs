//! Descriptor sets by name. A comment `// set 1: bins` in a file of glsl/ names the set 1 whose bindings that file declares. From it, this
//! module generates the Rust struct `shaders::set::Bins`, with one field per binding: the buffer's member or the image, by its name in
//! GLSL. A set declared in several files is named in each. The set that look-ups read, GOBO_SET, is named after the folder (`AvsmLookUp`).
//! If a set's only binding is numbered by a macro, `binding = i`, its field is a list whose element i goes to binding i. If a look-up
//! includes glsl/maps/look_up_set.glsl, its own set starts after the bindings of `MapsLookUp`.

use crate::Sources;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Binding → field, Rust type and kind of resource. A list is stored at EACH.
type Set = BTreeMap<u32, Slot>;

/// Key of a slot that is declared once and created for each of several resources.
const EACH: u32 = u32::MAX;

#[derive(PartialEq, Eq)]
struct Slot {
    field: String,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Buffer,
    StorageImage,
    Texture,
    /// A `sampler…` in GLSL. The caller passes a resource, and so decides how it is sampled.
    Sampler,
    AccelerationStructure,
}

impl Kind {
    fn rust(self) -> &'static str {
        match self {
            Self::Buffer => "Buffer",
            Self::StorageImage | Self::Texture => "Image",
            Self::Sampler => "Resource",
            Self::AccelerationStructure => "AccelerationStructure",
        }
    }

    /// Returns the Rust expression that turns `of` into a resource.
    fn resource(self, of: &str) -> String {
        match self {
            Self::Buffer => format!("Resource::Buffer({of}.clone())"),
            Self::StorageImage => format!("Resource::StorageImage({of}.clone())"),
            Self::Texture => format!("Resource::Texture({of}.clone())"),
            Self::Sampler => format!("{of}.clone()"),
            Self::AccelerationStructure => format!("Resource::AccelerationStructure({of}.clone())"),
        }
    }
}

/// Returns the sets as a Rust module.
pub fn module(sources: &Sources) -> Result<String, String> {
    let mut sets: BTreeMap<String, Set> = BTreeMap::new();
    for (file, text) in sources {
        let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
        let mut names: Vec<(&str, String)> = Vec::new();
        for line in text.lines().filter_map(|l| l.strip_prefix("// set ")) {
            let Some((number, all)) = line.split_once(": ") else { continue };
            names.extend(all.split_whitespace().map(|name| (number, name.to_owned())));
        }
        let word = folder.rsplit('/').next().unwrap_or(folder).replace('-', "_");
        names.push(("GOBO_SET", format!("{word}_look_up")));
        for line in text.lines() {
            let Some((number, binding, slot)) = declared(line) else { continue };
            for (_, name) in names.iter().filter(|(of, _)| *of == number) {
                let set = sets.entry(name.clone()).or_default();
                let slot = Slot { field: slot.field.clone(), kind: slot.kind };
                if set.get(&binding).is_some_and(|before| *before != slot) {
                    return Err(format!(
                        "glsl/{file}: error: binding {binding} of the set {name} is declared otherwise elsewhere"
                    ));
                }
                set.insert(binding, slot);
            }
        }
    }
    let mut text = String::from(
        "/// Sets by their names in glsl/: a field a binding.\npub mod set {\n    use crate::Result;\n    #[allow(unused_imports)]\n    use crate::gpu::{AccelerationStructure, Bindings, Buffer, Context, Image, Resource};\n",
    );
    for (name, set) in &sets {
        written(&mut text, name, set)?;
    }
    text.push_str("}\n");
    Ok(text)
}

/// Returns the set, the binding and its slot, if the line declares a binding.
fn declared(line: &str) -> Option<(&str, u32, Slot)> {
    let (_, rest) = line.split_once("layout(set = ")?;
    let (number, rest) = rest.split_once(',')?;
    let (layout, declaration) = rest.split_once(')')?;
    let (_, place) = layout.split_once("binding = ")?;
    let place = place.split(',').next()?.trim();
    let digits = place.rsplit(|c: char| !c.is_ascii_digit()).next()?;
    let binding = if place == "i" { EACH } else { digits.parse().ok()? };
    let declaration = declaration.split("//").next()?;
    let (kind, name) = if let Some((head, block)) = declaration.split_once('{') {
        // Name of the buffer's member; if the block spans several lines, the end of the block's name, from its last capital letter on.
        let member = block.split(';').next().unwrap_or_default().split_whitespace().last();
        let block_name = head.split_whitespace().last().unwrap_or_default();
        let short = block_name.rfind(|c: char| c.is_uppercase()).map_or(block_name, |at| &block_name[at..]);
        (Kind::Buffer, member.unwrap_or(short).trim_end_matches("[]").to_lowercase())
    } else {
        let words: Vec<_> = declaration.split_whitespace().collect();
        let kind = |word: &&str| match word.trim_start_matches('u') {
            w if w.starts_with("image") => Some(Kind::StorageImage),
            w if w.starts_with("texture") => Some(Kind::Texture),
            w if w.starts_with("sampler") => Some(Kind::Sampler),
            "accelerationStructureEXT" => Some(Kind::AccelerationStructure),
            _ => None,
        };
        (words.iter().find_map(kind)?, words.last()?.trim_end_matches(';').to_owned())
    };
    let field =
        name.trim_start_matches("visibility_").trim_start_matches("look_up_").trim_end_matches("_##i").to_owned();
    Some((number, binding, Slot { field, kind }))
}

fn written(text: &mut String, name: &str, set: &Set) -> Result<(), String> {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let structure: String = name.split('_').map(capital).collect();
    if let Some(Slot { field, kind }) = set.get(&EACH).filter(|_| set.len() == 1) {
        list(text, &structure, field, *kind);
        return Ok(());
    }
    let first = set.keys().next().copied().unwrap_or_default();
    if !set.keys().copied().eq(first..first + set.len() as u32) {
        return Err(format!("glsl: error: the set {name} has no binding between two others"));
    }
    let _ = writeln!(text, "    /// The set {name}.\n    #[derive(Clone, Copy)]\n    pub struct {structure}<'a> {{");
    for (binding, Slot { field, kind }) in set {
        let _ = writeln!(text, "        /// Binding {binding}.\n        pub {field}: &'a {},", kind.rust());
    }
    let _ = writeln!(text, "    }}\n    impl {structure}<'_> {{");
    for (binding, Slot { field, .. }) in set {
        let constant = field.to_uppercase();
        let _ =
            writeln!(text, "        /// The binding of `{field}`.\n        pub const {constant}: usize = {binding};");
    }
    let resource = |Slot { field, kind }: &Slot| kind.resource(&format!("self.{field}"));
    let resources: Vec<_> = set.values().map(resource).collect();
    let _ = writeln!(
        text,
        "        /// What each binding is given, from binding {first} on.\n        pub fn resources(&self) -> [Resource; {}] {{\n            [{}]\n        }}",
        set.len(),
        resources.join(", ")
    );
    if first == 0 {
        text.push_str(BIND);
    }
    text.push_str("    }\n");
    Ok(())
}

/// Writes a set with as many bindings as the list has elements.
fn list(text: &mut String, structure: &str, field: &str, kind: Kind) {
    let (rust, resource) = (kind.rust(), kind.resource("one"));
    let _ = write!(
        text,
        "    /// A set of as many bindings as there are.\n    #[derive(Clone, Copy)]\n    pub struct {structure}<'a> {{\n        /// From binding 0 on.\n        pub {field}: &'a [{rust}],\n    }}\n    impl {structure}<'_> {{\n        /// What each binding is given.\n        pub fn resources(&self) -> Vec<Resource> {{\n            self.{field}.iter().map(|one| {resource}).collect()\n        }}\n{BIND}    }}\n"
    );
}

/// The method that creates the set.
const BIND: &str = "        /// The set, ready to be given to a kernel.\n        ///\n        /// # Errors\n        /// [`crate::Error::Gpu`] where the driver runs out of memory.\n        pub fn bind(&self, context: &Context, name: &str) -> Result<Bindings> {\n            Bindings::new(context, name, &self.resources())\n        }\n";
