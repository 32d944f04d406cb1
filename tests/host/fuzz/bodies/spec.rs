//! Specs: a parsed spec must print as text that parses to the same spec.

use super::assert_one_line;
use super::memory::bounded;
use gobo::shading::parse;
use gobo::technique::Spec;

/// Number of specs of a sweep that are printed.
const PRINTED: usize = 16;

/// Fuzzes the argument of `--technique`.
pub fn spec(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    // A sweep may be long; it must be refused before it uses more memory than this.
    let specs = match bounded(text.len() + (16 << 10), || parse(text)) {
        Ok(specs) => specs,
        Err(error) => {
            assert_one_line(&error, "; ");
            return false;
        }
    };
    assert!(!specs.is_empty());
    for spec in specs.iter().take(PRINTED) {
        for printed in [spec.to_string(), spec.short()] {
            let again = parse(&printed).unwrap_or_else(|error| panic!("{text:?} is {printed:?}: {error}"));
            let variants: Vec<_> = again.iter().map(Spec::variant).collect();
            assert!(again[0].entry.name == spec.entry.name && variants == [spec.variant()], "{text:?} is {printed:?}");
        }
    }
    true
}
