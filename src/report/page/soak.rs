//! The page of `gobo stress --soak`.

use crate::Result;
use crate::bench::stress::Soaked;
use crate::report::format::{NOTHING, bytes};
use crate::report::page::stress::render;
use minijinja::value::{Serde, Value};
use serde::Serialize;

/// All data for the template, which escapes it.
#[derive(Serialize)]
struct Page<'a> {
    soaked: &'a Soaked,
    /// One line per life: its first seed, rounds, seconds, process and bytes.
    lives: Vec<[String; 7]>,
    seconds: String,
    failures: usize,
    flat: &'static str,
}

/// Renders the page: failures with their seeds, and memory held, in one self-contained file.
///
/// # Errors
/// Only if the template itself is broken, which a test rules out.
pub fn soak_page(soaked: &Soaked) -> Result<String> {
    let held = |count: Option<u64>| count.map_or_else(|| NOTHING.into(), bytes);
    let lives = soaked.lives.iter().map(|life| {
        let (seconds, device) = (format!("{:.0}", life.seconds), bytes(life.device_bytes));
        let [seed, rounds, process] = [life.seed, life.rounds, life.process.into()].map(|n| n.to_string());
        [seed, rounds, seconds, process, held(life.most_host_bytes), held(life.host_bytes), device]
    });
    let flat = match soaked.is_flat {
        Some(true) => "flat",
        Some(false) => "growing",
        None => "not to be told: too few openings of the device, or a system that does not say",
    };
    let (seconds, failures) = (format!("{:.0}", soaked.seconds), soaked.failures.len());
    let page = Page { soaked, lives: lives.collect(), seconds, failures, flat };
    render("soak.html", include_str!("soak.html"), &Value::from(Serde(&page)))
}
