//! Seeds and their mutations: the same bytes each time.

use rand::Rng;
use rand_pcg::Pcg32;
use std::path::Path;

/// A file of fuzz/seeds: names with `ok-` must be accepted, with `bad-` refused.
pub struct Seed {
    pub name: String,
    pub bytes: Vec<u8>,
}

/// Returns the seeds of a body, sorted by name.
pub fn seeds(body: &str) -> Vec<Seed> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(body);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let seed = |path: &Path| Seed {
        name: path.file_name().expect("a file").to_string_lossy().into_owned(),
        bytes: std::fs::read(path).expect("a seed"),
    };
    let mut seeds: Vec<_> = entries.map(|entry| seed(&entry.expect("an entry").path())).collect();
    seeds.retain(|seed| seed.name.starts_with("ok-") || seed.name.starts_with("bad-"));
    seeds.sort_by(|a, b| a.name.cmp(&b.name));
    seeds
}

/// Numbers as in binary files: false counts, and floats that are not finite.
const WORDS: [u32; 10] =
    [0, 1, 0xFFFF_FFFF, 0x7FFF_FFFF, 0x8000_0000, 0x7FC0_0000, 0x7F80_0000, 0xBF80_0000, 0x7F7F_FFFF, 9];

/// The same kinds of numbers as text.
const TEXTS: [&str; 14] = [
    "0",
    "-1",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "nan",
    "inf",
    "3e38",
    "1e39",
    "1e999",
    "1e-40",
    "1e-60",
    "",
];

/// Returns a damaged seed.
pub fn mutated(seeds: &[Seed], random: &mut Pcg32) -> Vec<u8> {
    let mut bytes = seeds[below(random, seeds.len())].bytes.clone();
    for _ in 0..=below(random, 4) {
        edit(&mut bytes, seeds, random);
    }
    bytes
}

fn edit(bytes: &mut Vec<u8>, seeds: &[Seed], random: &mut Pcg32) {
    let at = below(random, bytes.len() + 1);
    let end = (at + 1 + below(random, 32)).min(bytes.len());
    match below(random, 9) {
        0 => bytes.truncate(at),
        1 => bytes.insert(at, random.next_u32() as u8),
        2 => drop(bytes.drain(at..end)),
        3 => {
            let again = bytes[at..end].to_vec();
            bytes.splice(at..at, again);
        }
        4 => {
            let other = &seeds[below(random, seeds.len())].bytes;
            let from = below(random, other.len() + 1);
            bytes.splice(at.., other[from..].iter().copied());
        }
        5 => put(bytes, at, &WORDS[below(random, WORDS.len())].to_le_bytes()),
        6 => {
            // Replaces a whole number within text.
            let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b".+-".contains(byte);
            let begin = bytes[..at].iter().rposition(|byte| !is_part(byte)).map_or(0, |before| before + 1);
            let end = bytes[at..].iter().position(|byte| !is_part(byte)).map_or(bytes.len(), |behind| at + behind);
            bytes.splice(begin..end, TEXTS[below(random, TEXTS.len())].bytes());
        }
        7 => put(bytes, at, &[b'0' + below(random, 10) as u8]),
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << below(random, 8);
            }
        }
    }
}

fn put(bytes: &mut [u8], at: usize, what: &[u8]) {
    bytes[at..].iter_mut().zip(what).for_each(|(byte, new)| *byte = *new);
}

fn below(random: &mut Pcg32, end: usize) -> usize {
    random.next_u32() as usize % end.max(1)
}
