//! The one list of techniques.

use super::{Entry, avsm, psm, uncompressed};

/// Every technique.
pub const REGISTRY: &[&Entry] = &[
    &avsm::ENTRY,
    &psm::ENTRY,
    &uncompressed::ENTRY,
];
