//! Specs such as `avsm:nodes=4|8,curve=linear`: a technique and its settings.

use super::keys::{Key, Name, Values, check};
use super::settings::Keyed;
use super::{Entry, REGISTRY};
use crate::error::did_you_mean;
use crate::{Error, Result, WayOut};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Maximum number of variants in a sweep. Each further key multiplies their number, and a line of text has room for many keys.
const MOST_VARIANTS: usize = 4096;

/// A technique with every setting spelt out, and with the settings of the command that uses it.
#[derive(Clone)]
pub struct Spec {
    /// The technique.
    pub entry: &'static Entry,
    /// Keys of the command that uses it.
    more: &'static [Key],
    values: BTreeMap<&'static str, String>,
}

impl Spec {
    /// Creates a spec with the defaults of the technique's own keys and of the keys `more`.
    pub fn new(entry: &'static Entry, more: &'static [Key]) -> Self {
        let mut spec = Self { entry, more, values: BTreeMap::new() };
        spec.values = spec.keys().map(|key| (key.name, key.default.to_owned())).collect();
        spec.settle();
        spec
    }

    /// Returns the spec's values for the fields of `S`. Fields without a key, or left to a file, keep their defaults.
    pub fn settings<S: Keyed>(&self) -> S {
        let mut settings = S::default();
        for (key, text) in &self.values {
            settings.set(key, text);
        }
        settings
    }

    /// Returns the spec with the values of `settings`, for the keys that the spec may have.
    #[must_use]
    pub fn with<S: Keyed>(mut self, settings: &S) -> Self {
        let texts = settings.texts();
        for key in self.keys() {
            if let Some((_, text)) = texts.iter().find(|(name, _)| *name == key.name) {
                self.values.insert(key.name, text.clone());
            }
        }
        self.settle();
        self.leave_to_files(&[]);
        self
    }

    /// Returns all keys that the spec may have.
    pub fn keys(&self) -> impl Iterator<Item = &'static Key> + use<> {
        self.entry.all_keys().chain(self.more)
    }

    /// Returns the text of a key; empty for keys that the spec does not have or leaves to a file.
    pub fn text(&self, key: impl Into<Name>) -> &str {
        self.values.get(key.into().text()).map_or("", String::as_str)
    }

    /// Returns whether work is skipped if nothing has changed.
    pub fn skips(&self) -> bool {
        self.text(Name::SKIP) == "on"
    }

    /// Sets a key to `value`. Does nothing if the spec may not have that key, or if the key does not allow that value.
    pub fn set(&mut self, key: impl Into<Name>, value: &str) {
        let name = key.into().text();
        if let Some(known) = self.keys().find(|k| k.name == name && check(k, value).is_ok()) {
            self.values.insert(known.name, value.to_owned());
            self.settle();
        }
    }

    /// Adds keys that require a word of another key if that key has the word; otherwise removes them.
    fn settle(&mut self) {
        for key in self.keys() {
            let Some((other, word)) = key.with else { continue };
            if self.values.get(other).is_some_and(|value| value == word) {
                self.values.entry(key.name).or_insert_with(|| key.default.to_owned());
            } else {
                self.values.remove(key.name);
            }
        }
    }

    /// Returns the files that the spec names.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let is_named = |key: &&Key| matches!(key.values, Values::Path(_)) && self.text(*key) != key.default;
        self.keys().filter(is_named).map(|key| self.text(key))
    }

    /// Returns the keys whose values are in a file that the spec names.
    fn in_files(&self) -> Vec<&'static str> {
        let of = |key: &'static Key| match key.values {
            Values::Path(in_file) if self.text(key) != key.default => in_file,
            _ => &[],
        };
        self.keys().flat_map(of).copied().collect()
    }

    /// Removes the keys whose values are in a file, unless they are in `given`.
    fn leave_to_files(&mut self, given: &[&str]) {
        let in_files = self.in_files();
        self.values.retain(|name, _| given.contains(name) || !in_files.contains(name));
    }

    /// Returns the technique and the values that differ from defaults, such as `avsm:nodes=4`. If the spec names a file, this includes
    /// values that must agree with the file, even if they are defaults.
    pub fn short(&self) -> String {
        let in_files = self.in_files();
        let default = |key: &str| self.keys().find(|k| k.name == key).map_or("", |k| k.default);
        let says = |key: &str, value: &str| default(key) != value || in_files.contains(&key);
        let pairs: Vec<_> = self.values.iter().filter(|(k, v)| says(k, v)).map(|(k, v)| format!("{k}={v}")).collect();
        if pairs.is_empty() { self.entry.name.into() } else { format!("{}:{}", self.entry.name, pairs.join(",")) }
    }

    /// Returns keys and values as listed in results.
    pub fn variant(&self) -> BTreeMap<String, String> {
        self.values.iter().map(|(k, v)| ((*k).to_owned(), v.clone())).collect()
    }
}

/// Writes the full spec: `avsm:capacity=auto,curve=exponential,…`
impl fmt::Display for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs: Vec<_> = self.values.iter().map(|(k, v)| format!("{k}={v}")).collect();
        write!(f, "{}:{}", self.entry.name, pairs.join(","))
    }
}

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Parses a spec, which may have the keys `more` of the command that uses it besides the technique's own. Several values separated by `|`
/// make a sweep: every combination, with the last key varying fastest.
///
/// # Errors
/// [`Error::Usage`], listing the known techniques, keys or values.
pub fn parse(text: &str, more: &'static [Key]) -> Result<Vec<Spec>> {
    let (name, settings) = text.split_once(':').unwrap_or((text, ""));
    let line = |text: &str| text.replace(char::is_control, "?");
    let fail = |cause: String, way_out: String| Error::usage(line(text), line(&cause), line(&way_out));
    let each = |cause: String, specs: Vec<String>| fail(cause, String::new()).with_way_out(WayOut::Each(specs));
    let entry = *REGISTRY.iter().find(|e| e.name == name).ok_or_else(|| {
        let known: Vec<_> = REGISTRY.iter().map(|e| e.name).collect();
        let meant = did_you_mean(name, known.iter().copied());
        let cause = format!("no technique \"{name}\"{meant}");
        match name.split_once(',') {
            None => fail(cause, format!("choose one of: {}", known.join(", "))),
            // A list, of keys or of techniques.
            Some((first, rest)) if rest.contains('=') => {
                fail(cause, format!("write a colon behind the technique: {first}:{rest}"))
            }
            Some(_) => each(cause, name.split(',').map(line).collect()),
        }
    })?;
    let keys = || entry.all_keys().chain(more);
    let mut specs = vec![Spec::new(entry, more)];
    let mut seen = Vec::new();
    let is_path = |name: &&str| keys().any(|k| k.name == *name && matches!(k.values, Values::Path(_)));
    for setting in settings.split(',').filter(|s| !s.is_empty()) {
        let known = || keys().map(|k| k.name).collect::<Vec<_>>().join(", ");
        if is_technique(setting.split(':').next().unwrap_or_default()) {
            let cause = format!("\"{setting}\" is another technique");
            return Err(each(cause, Vec::new()));
        }
        let (name, values) = setting.split_once('=').ok_or_else(|| {
            let hint = if seen.iter().any(is_path) { ", and no comma in a file's name" } else { "" };
            fail(format!("\"{setting}\" has no value"), format!("write key=value{hint}; keys: {}", known()))
        })?;
        let key = keys().find(|k| k.name == name).ok_or_else(|| {
            let meant = did_you_mean(name, keys().map(|k| k.name));
            fail(format!("no key \"{name}\"{meant}"), format!("choose one of: {}", known()))
        })?;
        if seen.contains(&key.name) {
            return Err(fail(format!("key \"{name}\" is given twice"), "write several values as a|b".into()));
        }
        seen.push(key.name);
        if specs.len().saturating_mul(values.split('|').count()) > MOST_VARIANTS {
            let cause = format!("more than {MOST_VARIANTS} variants");
            return Err(fail(cause, "give fewer values, or several sweeps".into()));
        }
        let mut next = Vec::new();
        for spec in &specs {
            for value in values.split('|') {
                check(key, value).map_err(|known| {
                    let words = if let Values::OneOf(words) = key.values { words } else { &[] };
                    let meant = did_you_mean(value, words.iter().copied());
                    fail(format!("{name}={value} is not known{meant}"), known)
                })?;
                let mut spec = spec.clone();
                spec.values.insert(key.name, value.to_owned());
                next.push(spec);
            }
        }
        specs = next;
    }
    for spec in &mut specs {
        spec.settle();
        spec.leave_to_files(&seen);
    }
    let is_idle = |key: &&Key| seen.contains(&key.name) && specs.iter().all(|spec| !spec.values.contains_key(key.name));
    if let Some((key, (other, word))) = keys().find(is_idle).and_then(|key| key.with.map(|with| (key, with))) {
        let cause = format!("{}= has a meaning only with {other}={word}", key.name);
        return Err(fail(cause, format!("add {other}={word}")));
    }
    // If a key has no meaning with a value of another key, a sweep over it gives equal specs; only one is kept.
    let mut different = BTreeSet::new();
    specs.retain(|spec| different.insert(spec.values.clone()));
    Ok(specs)
}

fn is_technique(name: &str) -> bool {
    REGISTRY.iter().any(|entry| entry.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::avsm;
    use crate::technique::keys::word_of;

    fn texts<const N: usize>(spec: &Spec, keys: [&str; N]) -> [String; N] {
        keys.map(|key| spec.variant().get(key).cloned().unwrap_or_default())
    }

    #[test]
    fn a_sweep_is_every_combination() {
        let specs = parse("avsm:nodes=4|8,curve=linear|exponential", &[]).expect("valid");
        let settings: Vec<avsm::Settings> = specs.iter().map(Spec::settings).collect();
        let picked: Vec<_> = settings.iter().map(|s| (s.nodes, word_of(s.curve))).collect();
        assert_eq!(picked, [(4, "linear"), (4, "exponential"), (8, "linear"), (8, "exponential")]);
        assert!(settings.iter().all(|s| s.size == 256), "unset keys take their defaults");
    }

    /// Asserts that a spec with a file has no defaults for the keys that the file states, but keeps values that are given in the spec, even
    /// defaults, to be compared with the file's.
    #[test]
    fn a_file_has_its_own_settings() {
        let specs = parse("voxelized:size=512,file=none|a=b:c.gobo,filter=3", &[]).expect("valid");
        let picked: Vec<_> = specs.iter().map(|s| texts(s, ["file", "size", "structure", "filter"])).collect();
        assert_eq!(picked, [["none", "512", "dag", "3"], ["a=b:c.gobo", "512", "", "3"]]);
        for text in ["voxelized:file=a", "voxelized:file=a,size=1024"] {
            assert_eq!(parse(text, &[]).expect("valid")[0].short(), text, "1024 is the default, and not of a file");
        }
    }

    /// Asserts that a sweep of 4,096 variants is parsed and a larger one is refused, so that a short line of text cannot exhaust memory.
    #[test]
    fn sweeps_end_somewhere() {
        let values = |count: u32| (1..=count).map(|n| n.to_string()).collect::<Vec<_>>().join("|");
        assert_eq!(parse(&format!("avsm:size={}", values(4096)), &[]).expect("as many as may be").len(), 4096);
        let text = format!("avsm:size={},nodes=4|8", values(2049));
        let error = parse(&text, &[]).expect_err("4,098").to_string();
        assert!(error.contains("more than 4096 variants"), "{error}");
    }

    #[test]
    fn errors_list_what_is_known() {
        for (text, known) in [
            ("vsm", "avsm"),
            ("avsm:knots=4", "nodes"),
            ("avsm:nodes=5", "4, 8, 16"),
            ("avsm:nodes", "key=value"),
            ("avsm:size=0", "whole number"),
            ("avsm:size=0256", "whole number"),
            ("avsm:capacity=-1", "auto"),
            ("avsm:nodes=4,nodes=8", "a|b"),
            ("avsm:nodes=", "4, 8, 16"),
            ("voxelized:file=", "without commas"),
            ("voxelized:file=a,b.gobo", "no comma in a file's name"),
            ("avsn", "did you mean avsm?"),
            ("avsm:node=4", "did you mean nodes?"),
            ("avsm:curve=lineal", "did you mean linear?"),
            ("avsm,psm", "each alone: avsm; psm"),
            ("avsm,size=8", "avsm:size=8"),
            ("avsm:size=8,psm:size=8", "each technique alone"),
            ("avsm:size=8,psm", "each technique alone"),
        ] {
            let error = parse(text, &[]).expect_err(text).to_string();
            assert!(error.contains(known) && error.contains(text) && !error.contains('\n'), "{error}");
        }
    }
}
