//! Specs such as `avsm:nodes=4|8,curve=linear`: which technique, with which settings.

use super::keys::{Key, SHADING, ShadingKind, TILED, Values, Word};
use super::{Entry, REGISTRY};
use crate::error::did_you_mean;
use crate::{Error, Result, WayOut};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The most variants that a sweep may be: each more key multiplies them, and a line of text has room for many keys.
const MOST_VARIANTS: usize = 4096;

/// A technique with every setting spelt out.
#[derive(Clone)]
pub struct Spec {
    /// The technique.
    pub entry: &'static Entry,
    values: BTreeMap<&'static str, String>,
}

impl Spec {
    /// The value of a key of this technique; empty for keys it does not have, and for those that it leaves to a file.
    pub fn value(&self, key: &str) -> &str {
        self.values.get(key).map_or("", String::as_str)
    }

    /// The value of a numeric key; 0 where it is a word or not a key.
    pub fn number(&self, key: &str) -> u32 {
        self.value(key).parse().unwrap_or(0)
    }

    /// What the word of a key means; none for words that a `T` does not have, such as `auto`.
    pub fn word<T: Word>(&self, key: &str) -> Option<T> {
        T::ALL.iter().find(|(word, _)| *word == self.value(key)).map(|(_, value)| *value)
    }

    /// Whether a key of two words, yes and no, says yes.
    pub fn is_on(&self, key: &str) -> bool {
        self.value(key) == "on"
    }

    /// Sets a key that this technique has to a value that it knows; others are left alone.
    pub fn set(&mut self, key: &str, value: &str) {
        if let Some(known) = self.entry.all_keys().find(|k| k.name == key && check(k, value).is_ok()) {
            self.values.insert(known.name, value.to_owned());
            self.settle_tiled();
        }
    }

    /// What is said of tiles stands where the meshes are shaded in tiles, and nowhere else.
    fn settle_tiled(&mut self) {
        if self.word(SHADING.name) == Some(ShadingKind::Tiled) {
            for key in TILED {
                self.values.entry(key.name).or_insert_with(|| key.default.to_owned());
            }
        } else {
            self.values.retain(|name, _| TILED.iter().all(|key| key.name != *name));
        }
    }

    /// The files that it names.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        let is_named = |key: &&Key| matches!(key.values, Values::Path(_)) && self.value(key.name) != key.default;
        self.entry.all_keys().filter(is_named).map(|key| self.value(key.name))
    }

    /// Keys that a file has which the spec names.
    fn in_files(&self) -> Vec<&'static str> {
        let of = |key: &'static Key| match key.values {
            Values::Path(in_file) if self.value(key.name) != key.default => in_file,
            _ => &[],
        };
        self.entry.all_keys().flat_map(of).copied().collect()
    }

    /// Forgets those, unless they are `given`.
    fn leave_to_files(&mut self, given: &[&str]) {
        let in_files = self.in_files();
        self.values.retain(|name, _| given.contains(name) || !in_files.contains(name));
    }

    /// The technique and what differs from the defaults, `avsm:nodes=4`; and whatever is to be held against a file.
    pub fn short(&self) -> String {
        let in_files = self.in_files();
        let default = |key: &str| self.entry.all_keys().find(|k| k.name == key).map_or("", |k| k.default);
        let says = |key: &str, value: &str| default(key) != value || in_files.contains(&key);
        let pairs: Vec<_> = self.values.iter().filter(|(k, v)| says(k, v)).map(|(k, v)| format!("{k}={v}")).collect();
        if pairs.is_empty() { self.entry.name.into() } else { format!("{}:{}", self.entry.name, pairs.join(",")) }
    }

    /// Key → value, as results list them.
    pub fn variant(&self) -> BTreeMap<String, String> {
        self.values.iter().map(|(k, v)| ((*k).to_owned(), v.clone())).collect()
    }
}

/// `avsm:capacity=auto,curve=exponential,…`
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

/// Reads a spec. Several values with `|` make a sweep: every combination, the last key varying fastest.
///
/// # Errors
/// [`Error::Input`] that lists the known techniques, keys or values.
pub fn parse(text: &str) -> Result<Vec<Spec>> {
    let (name, settings) = text.split_once(':').unwrap_or((text, ""));
    let line = |text: &str| text.replace(char::is_control, "?");
    let fail = |cause: String, way_out: String| Error::input(line(text), line(&cause), line(&way_out));
    let each = |cause: String, specs: Vec<String>| fail(cause, String::new()).with_way_out(WayOut::Each(specs));
    let entry = *REGISTRY.iter().find(|e| e.name == name).ok_or_else(|| {
        let known: Vec<_> = REGISTRY.iter().map(|e| e.name).collect();
        let meant = did_you_mean(name, known.iter().copied());
        let cause = format!("no technique \"{name}\"{meant}");
        match name.split_once(',') {
            None => fail(cause, format!("choose one of: {}", known.join(", "))),
            // It is a list, of keys or of techniques.
            Some((first, rest)) if rest.contains('=') => {
                fail(cause, format!("write a colon behind the technique: {first}:{rest}"))
            }
            Some(_) => each(cause, name.split(',').map(line).collect()),
        }
    })?;
    let defaults = entry.all_keys().map(|k| (k.name, k.default.to_owned())).collect();
    let mut specs = vec![Spec { entry, values: defaults }];
    let mut seen = Vec::new();
    let is_path = |name: &&str| entry.all_keys().any(|k| k.name == *name && matches!(k.values, Values::Path(_)));
    for setting in settings.split(',').filter(|s| !s.is_empty()) {
        let known = || entry.all_keys().map(|k| k.name).collect::<Vec<_>>().join(", ");
        if is_technique(setting.split(':').next().unwrap_or_default()) {
            let cause = format!("\"{setting}\" is another technique");
            return Err(each(cause, Vec::new()));
        }
        let (name, values) = setting.split_once('=').ok_or_else(|| {
            let hint = if seen.iter().any(is_path) { ", and no comma in a file's name" } else { "" };
            fail(format!("\"{setting}\" has no value"), format!("write key=value{hint}; keys: {}", known()))
        })?;
        let key = entry.all_keys().find(|k| k.name == name).ok_or_else(|| {
            let meant = did_you_mean(name, entry.all_keys().map(|k| k.name));
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
        spec.settle_tiled();
        spec.leave_to_files(&seen);
    }
    let of_tiles = |name: &&&str| TILED.iter().any(|key| key.name == **name);
    if let (Some(name), true) = (seen.iter().find(of_tiles), specs.iter().all(|s| s.value("shading") != "tiled")) {
        return Err(fail(format!("{name}= is about tiles, and there are none"), "add shading=tiled".into()));
    }
    // Of those that are not tiled, a sweep over what is said of tiles makes one.
    let mut different = BTreeSet::new();
    specs.retain(|spec| different.insert(spec.values.clone()));
    Ok(specs)
}

fn is_technique(name: &str) -> bool {
    REGISTRY.iter().any(|entry| entry.name == name)
}

/// What would be right, if `value` is not.
fn check(key: &Key, value: &str) -> std::result::Result<(), String> {
    match key.values {
        Values::OneOf(words) if words.contains(&value) || value == key.default => Ok(()),
        Values::OneOf(words) => {
            let default = Some(&key.default).filter(|default| !words.contains(default));
            let known: Vec<_> = default.into_iter().chain(words).copied().collect();
            Err(format!("choose one of: {}", known.join(", ")))
        }
        // Leading zeros or signs would make two names for one variant.
        Values::Number(low, high) => match value.parse::<u32>() {
            Ok(n) if (low..=high).contains(&n) && n.to_string() == value => Ok(()),
            _ if value == key.default => Ok(()),
            _ if key.default.parse::<u32>().is_err() => {
                Err(format!("give a whole number from {low} to {high}, or {}", key.default))
            }
            _ => Err(format!("give a whole number from {low} to {high}")),
        },
        Values::Multiple(step, low, high) => match value.parse::<u32>() {
            Ok(n) if (low..=high).contains(&n) && n.is_multiple_of(step) && n.to_string() == value => Ok(()),
            _ => Err(format!("give a whole number from {low} to {high} that is divisible by {step}")),
        },
        Values::Path(_) if value.is_empty() || value.contains(char::is_control) => {
            Err("give the name of a file, without commas, | and line breaks".into())
        }
        Values::Path(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_is_every_combination() {
        let specs = parse("avsm:nodes=4|8,curve=linear|exponential").expect("valid");
        let picked: Vec<_> = specs.iter().map(|s| (s.number("nodes"), s.value("curve"))).collect();
        assert_eq!(picked, [(4, "linear"), (4, "exponential"), (8, "linear"), (8, "exponential")]);
        assert!(specs.iter().all(|s| s.number("size") == 256), "unset keys take their defaults");
    }

    /// What a file has is no default's, but what the spec gives stays, to be held against the file.
    #[test]
    fn a_file_has_its_own_settings() {
        let specs = parse("voxelized:size=512,file=none|a=b:c.gobo,filter=3").expect("valid");
        let picked: Vec<_> =
            specs.iter().map(|s| ["file", "size", "structure", "filter"].map(|key| s.value(key))).collect();
        assert_eq!(picked, [["none", "512", "dag", "3"], ["a=b:c.gobo", "512", "", "3"]]);
        for text in ["voxelized:file=a", "voxelized:file=a,size=1024"] {
            assert_eq!(parse(text).expect("valid")[0].short(), text, "1024 is the default, and not of a file");
        }
    }

    /// What is said of tiles is in specs of tiles alone.
    #[test]
    fn tiles_have_keys_of_their_own() {
        let specs = parse("avsm:shading=forward|tiled,dither=none|noise").expect("valid");
        let picked: Vec<_> = specs.iter().map(|s| ["shading", "dither", "blur"].map(|key| s.value(key))).collect();
        assert_eq!(picked, [["forward", "", ""], ["tiled", "none", "on"], ["tiled", "noise", "on"]]);
        let mut spec = parse("avsm").expect("valid").remove(0);
        assert!(!spec.variant().contains_key("history"));
        spec.set("shading", "tiled");
        assert_eq!((spec.value("history"), spec.short().as_str()), ("on", "avsm:shading=tiled"));
    }

    /// A line of text is no reason to fill the memory.
    #[test]
    fn sweeps_end_somewhere() {
        let values = |count: u32| (1..=count).map(|n| n.to_string()).collect::<Vec<_>>().join("|");
        assert_eq!(parse(&format!("avsm:size={}", values(4096))).expect("as many as may be").len(), 4096);
        let text = format!("avsm:size={},nodes=4|8", values(2049));
        let error = parse(&text).expect_err("4,098").to_string();
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
            ("avsm:blur=off", "add shading=tiled"),
            ("avsm:shading=deferred,dither=noise", "add shading=tiled"),
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
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(known) && error.contains(text) && !error.contains('\n'), "{error}");
        }
    }
}
