//! Checks the documentation: its commands must run, and its tables must match the measurements.

#![cfg(feature = "program")]

mod support;

#[path = "docs/choices.rs"]
mod choices;
#[path = "docs/commands.rs"]
mod commands;
#[path = "docs/english.rs"]
mod english;
#[path = "docs/fronts.rs"]
mod fronts;
#[path = "docs/guide.rs"]
mod guide;
#[path = "docs/links.rs"]
mod links;
#[path = "docs/list.rs"]
mod list;
#[path = "docs/prose.rs"]
mod prose;
#[path = "docs/ranks.rs"]
mod ranks;
#[path = "docs/recommended.rs"]
mod recommended;
#[path = "docs/rows.rs"]
mod rows;
#[path = "docs/sources.rs"]
mod sources;
#[path = "docs/stressed.rs"]
mod stressed;
#[path = "docs/tables.rs"]
mod tables;
#[path = "docs/workflows.rs"]
mod workflows;
