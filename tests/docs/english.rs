//! Rules of English that a program can check in a sentence. `sources.rs` extracts the sentences of sources.

/// Words for people, which may precede `who`; code is *it*.
const PERSONS: &str = "anyone artist artists author authors caller callers engineer engineers everyone maintainers people person \
    programmer programmers reader readers researchers reviewers someone stranger strangers student those user users \
    visitors";

/// Words that form a rate before "a" and a unit: eight bytes *a texel* should be eight bytes *per texel*.
const COUNTED: &str = "bytes byte bits bit nodes texels voxels cells columns words threads numbers casters ms seconds microseconds µs \
    ns KiB MiB GiB GB frames pixels values floats triangles invocations workgroups registers entries dispatches \
    particles strands vertices pages rays slices commands megabytes times samples curves fragments segments lists \
    layers levels keys bins groups tiles blocks edges corners indices roundings squares patches directions lines units \
    views instances quads faces pairs queries look-ups";

/// Units after "per".
const UNITS: &str = "texel light frame pixel voxel node map row caster slice sample particle ray layer side channel thread workgroup \
    byte technique page scene cell receiver key command strand triangle block tile vertex point column group step \
    second curve brick leaf level word line view picture device grid axis face mesh instance volume segment bin warp \
    lane pass test splat coordinate component color color plane degree cluster patch facet edge corner cascade object entry \
    quad run build query draw dispatch job case file machine minute hour dimension paragraph program world optical further field unit";

/// Number words, and words that act as one: `four a texel`, `one value a key`.
const NUMBERS: &str = "a an another one two three four five six seven eight nine ten eleven twelve sixteen twenty thirty forty fifty \
    hundred thousand million dozen once twice thrice many few several no some";

/// Words between a number and "a" that are never the thing counted.
const NOT_COUNTED: &str = "is are was in of for to as at with by from on and or nor than that where when if then but so gives give has have \
    takes take makes make holds such what per not which be like until after before behind over within without into \
    up off through under between beside along across because while since only each about draws lights reaches reach \
    meets meet enters sees share measure covers cover around near inside outside lack half whether shows";

/// Words that readers had to look up, and phrases whose noun a reader has to guess.
const RARE: [&str; 7] = ["whereof", "thereof", "otherwise than", "dear to", "of what", "of that which", "with what of"];

fn is_in(words: &str, word: &str) -> bool {
    words.split(' ').any(|known| known == word)
}

fn is_number(word: &str) -> bool {
    let plain = word.trim_end_matches(['²', '³']);
    is_in(NUMBERS, &plain.to_lowercase())
        || plain.starts_with(|c: char| c.is_ascii_digit())
            && plain.chars().all(|c| c.is_ascii_digit() || ",.×".contains(c))
}

/// Whether "a" at this position forms a rate: `bytes a texel`, `four a texel`, `a small list a row`.
fn is_rate(words: &[&str], at: usize) -> bool {
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric() && c != '²').to_owned();
    let ends = |word: &str| word.ends_with(|c: char| !c.is_alphanumeric() && !"`)*²".contains(c));
    let unit = words.get(at + 1).map(|word| bare(word));
    if words[at] != "a" && words[at] != "an" || at == 0 || !unit.is_some_and(|unit| is_in(UNITS, &unit)) {
        return false;
    }
    // A comma before "a" ends the phrase, and a texel's bytes are no rate.
    if ends(words[at - 1]) {
        return false;
    }
    // `Which voxels a triangle meets`, `how many bytes a texel has`: no rate.
    if words[at.saturating_sub(3)..at]
        .iter()
        .any(|word| ["which", "whose", "how", "what"].contains(&bare(word).to_lowercase().as_str()))
    {
        return false;
    }
    let counted = bare(words[at - 1]);
    if is_in(COUNTED, &counted.to_lowercase()) || is_number(&counted) && !["a", "an"].contains(&counted.as_str()) {
        return true;
    }
    let is_noun = |word: &str| {
        !word.is_empty() && word.chars().all(char::is_alphabetic) && !is_in(NOT_COUNTED, &word.to_lowercase())
    };
    // `A workgroup builds a tile` describes an action.
    let is_verb = |number: &str| is_in("a an one another no", number) && counted.ends_with('s');
    let has_number = |back: usize| {
        at >= back
            && words[at - back..at].iter().all(|word| !ends(word))
            && is_number(&bare(words[at - back]))
            && !is_verb(&bare(words[at - back]).to_lowercase())
    };
    let all_nouns = |back: usize| words[at + 1 - back..at].iter().all(|word| is_noun(&bare(word)));
    (2..=4).any(|back| has_number(back) && all_nouns(back))
}

/// Blanks out words in backticks, which are code or quoted.
fn without_code(line: &str) -> String {
    let parts = line.split('`').enumerate().map(|(at, part)| if at % 2 == 0 { part } else { "code" });
    if line.matches('`').count().is_multiple_of(2) { parts.collect() } else { line.to_owned() }
}

/// Returns what is wrong with a line.
pub fn wrong(line: &str) -> Vec<String> {
    let mut found = Vec::new();
    let line = &without_code(line);
    let words: Vec<&str> = line.split_whitespace().collect();
    for at in 0..words.len() {
        if words[at].trim_start_matches(['(', '"', '*', '_']) == "Of" {
            found.push(format!("begins with \"Of\": {line}"));
        }
        let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
        let before = at.checked_sub(1).map(|before| bare(words[before])).unwrap_or_default();
        if bare(words[at]) == "who" && !is_in(PERSONS, &before) {
            found.push(format!("code is \"it\", and \"who\" stands behind a person: {line}"));
        }
        if is_rate(&words, at) {
            found.push(format!("\"per\", not \"a\": {} in {line}", words[at - 1..=at + 1].join(" ")));
        }
    }
    let lower = format!(" {} ", line.to_lowercase().replace(|c: char| !c.is_alphanumeric(), " "));
    let has = |rare: &&&str| lower.contains(&format!(" {rare} "));
    found.extend(RARE.iter().filter(has).map(|rare| format!("{rare:?}: {line}")));
    found
}
