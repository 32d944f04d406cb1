//! Formats numbers, units and specs for readers.

use crate::bench::{Row, Status, Timing};
use crate::shading::keys;
use crate::technique::REGISTRY;
use std::collections::{BTreeMap, BTreeSet};

/// Text for a missing value.
pub(super) const NOTHING: &str = "–";

/// Formats three significant digits: `0.0142`, `1.20`, `4.70e-5`; `0` for exactly zero.
pub(super) fn significant(value: f64) -> String {
    if !value.is_finite() {
        return NOTHING.into();
    }
    if value == 0.0 {
        return "0".into();
    }
    // The formatter rounds first, so that 9.996 becomes 10.0 and not 9.996.
    let scientific = format!("{value:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or(0);
    match exponent {
        -4..=5 => format!("{value:.*}", (2 - exponent).max(0) as usize),
        _ => scientific,
    }
}

/// Formats one significant digit, for a number that only tells how far to trust another: `0.00003`, `2`, `4e-6`.
pub(super) fn one_digit(value: f64) -> String {
    let scientific = format!("{value:.0e}");
    match scientific.parse::<f64>() {
        Ok(rounded) if rounded == 0.0 || rounded >= 1e-5 => rounded.to_string(),
        _ => scientific,
    }
}

/// Same as [`significant`], but with a sign unless the value is zero.
pub(super) fn signed(value: f64) -> String {
    match value {
        v if v > 0.0 => format!("+{}", significant(v)),
        v if v < 0.0 => format!("−{}", significant(-v)),
        v => significant(v),
    }
}

/// Formats nanoseconds as milliseconds, without the unit.
pub(super) fn milliseconds(nanoseconds: f64) -> String {
    significant(nanoseconds / 1e6)
}

/// Formats `[p05–p95]` in milliseconds.
pub(super) fn spread_milliseconds(timing: &Timing) -> String {
    format!("[{}–{}]", milliseconds(timing.p05), milliseconds(timing.p95))
}

/// Formats a share as a percentage, with two digits or more: `6.2 %`, `59 %`, `0 %`.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".into(),
        p if p < 0.05 => "<0.1 %".into(),
        p if p < 9.95 => format!("{p:.1} %"),
        p => format!("{p:.0} %"),
    }
}

/// Returns the path that ran, and the scene's casters that the technique does not see: `map, smoke is not seen`.
pub(super) fn path(row: &Row) -> String {
    let unseen = row.unseen.join(" and ");
    let verb = if unseen.ends_with('s') || row.unseen.len() > 1 { "are" } else { "is" };
    let note = if unseen.is_empty() { String::new() } else { format!("{unseen} {verb} not seen") };
    // A refused row took no path.
    let said: Vec<_> = [row.path.as_str(), &note].into_iter().filter(|said| !said.is_empty()).collect();
    one_line(&said.join(", "))
}

/// Formats bytes in the largest binary unit that gives at least one.
pub(super) fn bytes(count: u64) -> String {
    let value = count as f64;
    match count {
        0 => "0".into(),
        1..1024 => format!("{count} B"),
        1024..0x10_0000 => format!("{} KiB", significant(value / 1024.0)),
        0x10_0000..0x4000_0000 => format!("{} MiB", significant(value / 1_048_576.0)),
        _ => format!("{} GiB", significant(value / 1_073_741_824.0)),
    }
}

/// Groups digits by threes with narrow no-break spaces.
pub(super) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Returns one line without characters that would move a terminal's cursor or break XML.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().trim().to_owned()
}

/// Shortens text to `limit` characters by cutting out the middle, since specs differ at both ends.
pub(super) fn shortened(text: &str, limit: usize) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= limit {
        return text.to_owned();
    }
    let kept = limit.saturating_sub(1);
    let head = kept.div_ceil(2);
    let tail = &characters[characters.len() - (kept - head)..];
    characters[..head].iter().chain(&['…']).chain(tail).collect()
}

/// Formats `refused: …` or `failed: …`, without repeating the word.
pub(super) fn outcome(row: &Row) -> String {
    let status = status_word(row.status);
    let reason = one_line(&row.reason);
    match reason.as_str() {
        "" => status.into(),
        told if told.starts_with(status) => reason,
        _ => format!("{status}: {reason}"),
    }
}

/// Returns the status as `results.json` spells it.
pub(super) fn status_word(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Refused => "refused",
        Status::Failed => "failed",
    }
}

/// Splits spec keys into those that distinguish rows and those stated once above the table.
pub(super) struct Specs {
    /// Key, value, and the techniques that have them; no techniques if every row has them.
    shared: Vec<(String, String, Vec<String>)>,
    /// Techniques with the keys that do not distinguish any of their rows.
    silent: BTreeSet<(String, String)>,
}

/// Returns the default of a technique's key.
fn default(technique: &str, key: &str) -> Option<&'static str> {
    let entry = REGISTRY.iter().find(|entry| entry.name == technique)?;
    keys(entry).find(|known| known.name == key).map(|known| known.default)
}

impl Specs {
    /// Finds the keys that rows share. A shared key is left out of the rows' specs: either all rows with the key agree on its value, or all
    /// rows of a technique have its default. Other techniques may have other values, since the techniques' names already distinguish their
    /// rows. A single row shares nothing: its spec has all keys that differ from their defaults.
    pub(super) fn of(rows: &[Row]) -> Self {
        let mut specs = Self { shared: Vec::new(), silent: BTreeSet::new() };
        // Maps each value as the row spells it to today's spelling. A default under an older spelling is still the default, unless one
        // table has rows with both spellings.
        let mut keys: BTreeMap<&str, BTreeMap<&str, BTreeMap<&str, &str>>> = BTreeMap::new();
        for row in rows {
            // The path that ran has its own column, whatever the spec asked for.
            for (key, value) in row.variant.iter().filter(|(key, _)| *key != "path") {
                let now = row.value(key).unwrap_or(value);
                keys.entry(key).or_default().entry(&row.technique).or_default().insert(value, now);
            }
        }
        for (key, techniques) in keys {
            let all: BTreeSet<&str> = techniques.values().flat_map(BTreeMap::values).copied().collect();
            let agree = rows.len() > 1 && all.len() == 1;
            for value in all {
                let is_said = |technique: &str, values: &BTreeMap<&str, &str>| {
                    let only = values.len() == 1 && values.values().all(|now| *now == value);
                    only && (agree || default(technique, key) == Some(value))
                };
                let said = techniques.iter().filter(|(technique, values)| is_said(technique, values));
                let named: Vec<String> = said.map(|(technique, _)| (*technique).to_owned()).collect();
                specs.silent.extend(named.iter().map(|technique| (technique.clone(), key.to_owned())));
                let everywhere = agree && rows.iter().all(|row| row.variant.contains_key(key));
                if rows.len() > 1 && !named.is_empty() {
                    specs.shared.push((key.into(), value.into(), if everywhere { Vec::new() } else { named }));
                }
            }
        }
        specs
    }

    /// Returns the keys that differ between rows, except the path, with this row's values.
    pub(super) fn differing<'a>(&'a self, row: &'a Row) -> impl Iterator<Item = (&'a str, &'a str)> {
        let tells = |key: &str| key != "path" && !self.silent.contains(&(row.technique.clone(), key.to_owned()));
        row.variant.iter().filter(move |(key, _)| tells(key)).map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Formats `avsm:curve=linear,nodes=8`, with only the keys that distinguish this row from others.
    pub(super) fn compact(&self, row: &Row) -> String {
        let keys: Vec<_> = self.differing(row).map(|(key, value)| format!("{key}={value}")).collect();
        let colon = if keys.is_empty() { "" } else { ":" };
        one_line(&format!("{}{colon}{}", row.technique, keys.join(",")))
    }

    /// Formats `size=256, order=sorted (avsm)`; `None` if every key differs.
    pub(super) fn shared_line(&self) -> Option<String> {
        let keys: Vec<_> = self
            .shared
            .iter()
            .map(|(key, value, techniques)| match techniques.is_empty() {
                true => format!("{key}={value}"),
                false => format!("{key}={value} ({})", techniques.join(", ")),
            })
            .collect();
        (!keys.is_empty()).then(|| one_line(&keys.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_significant_digits() {
        let cases = [
            (0.0142, "0.0142"),
            (9.996, "10.0"),
            (0.00047, "0.000470"),
            (0.000047, "4.70e-5"),
            (1.0, "1.00"),
            (123_456.0, "123456"),
            (0.0, "0"),
            (f64::NAN, NOTHING),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
        assert_eq!([signed(0.5), signed(-0.5), signed(0.0)], ["+0.500", "−0.500", "0"]);
    }

    #[test]
    fn a_row_without_a_path_begins_with_what_it_does_not_see() {
        let of = |row_path: &str, unseen: &[&str]| {
            let unseen = unseen.iter().map(|word| (*word).to_owned()).collect();
            path(&Row { path: row_path.into(), unseen, ..Row::default() })
        };
        assert_eq!(of("map", &["smoke"]), "map, smoke is not seen");
        assert_eq!(of("", &["smoke", "hair"]), "smoke and hair are not seen");
        assert_eq!([of("map", &[]), of("", &[])], ["map", ""]);
    }

    #[test]
    fn one_digit_of_a_standard_error() {
        let cases = [(0.0000312, "0.00003"), (0.000996, "0.001"), (4.4e-6, "4e-6"), (17.0, "20"), (0.0, "0")];
        for (value, text) in cases {
            assert_eq!(one_digit(value), text);
        }
    }

    #[test]
    fn binary_units() {
        assert_eq!([bytes(0), bytes(1023), bytes(1024), bytes(3 << 20)], ["0", "1023 B", "1.00 KiB", "3.00 MiB"]);
    }

    #[test]
    fn digits_in_threes() {
        let blank = '\u{202f}';
        let expected = ["0".into(), "999".into(), format!("1{blank}000"), format!("12{blank}345{blank}678")];
        assert_eq!([0, 999, 1000, 12_345_678].map(grouped), expected);
    }

    fn row(spec: &str) -> Row {
        let spec = crate::shading::parse(spec).expect(spec).remove(0);
        Row { technique: spec.entry.name.into(), variant: spec.variant(), ..Row::default() }
    }

    fn labels(specs: &[&str]) -> (Vec<String>, String) {
        let rows: Vec<_> = specs.iter().map(|spec| row(spec)).collect();
        let specs = Specs::of(&rows);
        (rows.iter().map(|row| specs.compact(row)).collect(), specs.shared_line().unwrap_or_default())
    }

    #[test]
    fn one_row_spells_no_defaults() {
        assert_eq!(labels(&["avsm"]), (vec!["avsm".into()], String::new()));
        assert_eq!(labels(&["avsm:nodes=4,size=64"]).0, ["avsm:nodes=4,size=64"]);
    }

    /// `storage=` has different values for two techniques, but only one value for each, so no label may contain it.
    #[test]
    fn what_only_one_technique_has_is_no_label() {
        let (names, shared) = labels(&["avsm:nodes=4", "avsm:nodes=8", "psm", "translucency-map:size=64"]);
        assert_eq!(names, ["avsm:nodes=4", "avsm:nodes=8", "psm", "translucency-map:size=64"]);
        for words in ["storage=rgba8 (psm)", "storage=auto (avsm)", "size=256 (avsm, psm)", "skip=on"] {
            assert!(shared.contains(words), "{words} is not in {shared}");
        }
        assert!(!shared.contains("size=64") && !shared.contains("nodes=") && !shared.contains("skip=on ("), "{shared}");
        // A key that differs between a technique's own rows is part of the label.
        let names = labels(&["psm", "psm:storage=rgba16f", "avsm"]).0;
        assert_eq!(names, ["psm:storage=rgba8", "psm:storage=rgba16f", "avsm"]);
        // A key on which all rows agree is not, at its default or otherwise.
        let (names, shared) = labels(&["avsm:size=64", "psm:size=64"]);
        assert!(names == ["avsm", "psm"] && shared.contains("size=64"), "{names:?}, {shared}");
    }

    /// `storage=full` was the default of avsm, and `auto` now means the same, so neither may be in a label; a sweep over both must still
    /// distinguish its rows.
    #[test]
    fn an_old_word_of_a_default_is_no_label() {
        assert_eq!(labels(&["avsm:storage=full"]).0, ["avsm"]);
        let (names, shared) = labels(&["avsm:storage=full,nodes=4", "avsm:storage=full", "psm"]);
        assert_eq!(names, ["avsm:nodes=4", "avsm:nodes=8", "psm"]);
        assert!(shared.contains("storage=auto (avsm)") && !shared.contains("full"), "{shared}");
        let (names, _) = labels(&["avsm:storage=full", "avsm"]);
        assert_eq!(names, ["avsm:storage=full", "avsm:storage=auto"]);
        let adaptive = "avsm:detail=adaptive,path=binned,storage=";
        let (names, _) = labels(&[&format!("{adaptive}full"), &format!("{adaptive}packed")]);
        assert_eq!(names, ["avsm:storage=full", "avsm:storage=packed"]);
    }

    #[test]
    fn the_middle_goes() {
        assert_eq!(shortened("abcdefghij", 5), "ab…ij");
        assert_eq!(shortened("abcde", 5), "abcde");
        assert_eq!(one_line("a\u{1b}[31m\nb"), "a [31m b");
    }
}
