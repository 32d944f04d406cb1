//! The one list of techniques.

use super::{Entry, avsm, beer_shadow_map, psm, translucency_map, uncompressed};

/// Every technique.
pub const REGISTRY: &[&Entry] = &[
    &avsm::ENTRY,
    &psm::ENTRY,
    &translucency_map::ENTRY,
    &beer_shadow_map::ENTRY,
    &uncompressed::ENTRY,
];
