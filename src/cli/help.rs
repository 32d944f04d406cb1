//! The text after the options in `--help`, and the text of `gobo help TECHNIQUE`. Both are generated from the entries
//! of techniques alone.

use crate::cli::hooks::OPTION;
use crate::error::did_you_mean;
use crate::scene::known;
use crate::shading::KEYS;
use crate::technique::keys::EVERY;
use crate::technique::{Entry, Key, Lifetime, Promises, REGISTRY, Spec, Values};
use crate::{Error, Result};

/// Number of characters per line of help.
pub const WIDTH: usize = 100;

/// The meaning of the exit status.
const EXIT: &str = "Exit status: 0 where all that was asked for was done (a row that the device refuses is done, unless all are); 1 where \
    something failed, of which a line on standard error says what and the way out; 2 where the command line is wrong, whatever files and \
    devices there are: an option, a technique, its key or value, a scene that is neither built in nor a file. A file that is missing is 1.";

/// Returns the text about technique specs, keys and scenes.
pub fn techniques() -> String {
    let mut text = fill(
        "",
        "Technique specs, NAME:key=value,key=value; several values as a|b make a sweep. `gobo help avsm` says more of one:",
    );
    for entry in REGISTRY {
        text += &format!("\n{}", about(entry));
        text += &keys(entry.keys.iter());
    }
    text +=
        &format!("\n  every technique:\n{}", keys(EVERY.iter().chain(KEYS.iter().filter(|key| key.with.is_none()))));
    text +=
        &format!("\n  every technique, with shading=tiled:\n{}", keys(KEYS.iter().filter(|key| key.with.is_some())));
    let known = known();
    let (files, built_in) = known.split_once(" or one of ").unwrap_or((&known, ""));
    text += &format!("\nScenes: {files} or one of\n{}\n{}", fill("  ", built_in), fill("", EXIT));
    text
}

/// Returns the help page of the technique that the arguments request, if they request one: `gobo help avsm`. `commands`
/// are the names of the program's commands, which have help pages too.
///
/// # Errors
/// [`Error::Usage`] if the word is neither a technique nor a command, but similar to one.
pub fn asked<'a>(commands: impl Iterator<Item = &'a str>) -> Result<Option<String>> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != OPTION).collect();
    let [_, name] = &arguments[..] else { return Ok(None) };
    if arguments[0] != "help" {
        return Ok(None);
    }
    if let Some(entry) = REGISTRY.iter().find(|entry| entry.name == name) {
        return Ok(Some(page(entry)));
    }
    let known: Vec<&str> = commands.chain(REGISTRY.iter().map(|entry| entry.name)).collect();
    let meant = if known.contains(&name.as_str()) { String::new() } else { did_you_mean(name, known) };
    match meant.is_empty() {
        true => Ok(None),
        false => {
            let cause = format!("neither a command nor a technique{meant}");
            Err(Error::usage(format!("help {name}"), cause, "gobo --help lists both"))
        }
    }
}

fn page(entry: &'static Entry) -> String {
    let mut text = format!("{}\n  paths, and what a device needs for each\n", about(entry));
    for path in entry.paths {
        let needs: Vec<_> = path.requires.iter().map(|needed| needed.name()).collect();
        let needs = if needs.is_empty() { "nothing beyond Vulkan 1.3".into() } else { needs.join(", ") };
        text += &fill(&format!("    {:<12} ", path.name), &needs);
    }
    text += "\n  what it promises of its answers with the default keys, and gobo stress checks\n";
    for plan in Spec::new(entry, &[]).plans() {
        text += &fill(&format!("    {:<12} ", plan.path.name), &promised(&plan.promises));
    }
    text += "\n  keys\n";
    text += &keys(entry.keys.iter());
    text += "\n  keys of every technique\n";
    text += &keys(EVERY.iter().chain(KEYS));
    let runs = entry
        .runs
        .compare
        .iter()
        .chain(entry.runs.many_lights)
        .chain(entry.runs.stress_smoke)
        .chain(entry.runs.stress_meshes);
    let example = runs
        .map(|keys| if keys.is_empty() { entry.name.into() } else { format!("{}:{keys}", entry.name) })
        .find(|spec| !spec.contains('|'));
    let example = example.unwrap_or_else(|| entry.name.into());
    text + &format!("\n  such as\n    gobo compare --quick --technique {example}\n")
}

fn promised(promises: &Promises) -> String {
    let most = |what: &str, value: Option<f64>| value.map(|value| format!("{what} at most {value}"));
    let all = [
        most("mean error on a texel's ray", promises.mean),
        most("off behind all smoke by", promises.tail),
        most("rises along a ray by", promises.rise),
        most("differs with the casters' order by", promises.order),
        most("steps by", promises.step),
        promises.wrong.map(|count| format!("{count} leaks and false shadows beyond its resolution")),
        promises.repeats.then(|| "the same bytes each time".into()),
        promises.skips_alike.then(|| "the same bytes with skip=off".into()),
    ];
    let all: Vec<String> = all.into_iter().flatten().collect();
    if all.is_empty() { "nothing".into() } else { all.join(", ") }
}

fn about(entry: &Entry) -> String {
    let lifetime = match entry.lifetime {
        Lifetime::Frame => "built each frame",
        Lifetime::Baked => "baked once",
    };
    let about = fill(&format!("  {}: ", entry.name), entry.about);
    about + &fill("    ", &format!("casts from {}; {lifetime}", entry.casts.names()))
}

/// Formats a paragraph per key.
fn keys<'a>(keys: impl Iterator<Item = &'a Key>) -> String {
    let line = |key: &Key| {
        let values = match key.values {
            Values::OneOf(words) => words.join("|"),
            Values::Number(low, high) => format!("{low}..{high}"),
            Values::Multiple(step, low, high) => format!("{low}..{high} by {step}"),
            Values::Path(_) => "FILE without commas and |".into(),
        };
        fill(&format!("    {:<9} ", key.name), &format!("{} (default {}; {values})", key.about, key.default))
    };
    keys.map(line).collect()
}

/// Wraps `words` into lines of [`WIDTH`] characters. The first line begins with `first`; the others are indented to the
/// text after `first`.
pub fn fill(first: &str, words: &str) -> String {
    // A paragraph below its own heading is indented by four.
    let indent = if first.ends_with(": ") { 4 } else { first.chars().count() };
    let (mut text, mut line, mut is_empty) = (String::new(), first.to_owned(), true);
    for word in words.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            text += &format!("{line}\n");
            (line, is_empty) = (" ".repeat(indent), true);
        }
        let space = if is_empty { "" } else { " " };
        line += &format!("{space}{word}");
        is_empty = false;
    }
    text + &format!("{line}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_filled() {
        let words = "word ".repeat(60);
        let text = fill("    key       ", &words);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= WIDTH));
        assert!(lines[0].starts_with("    key       word") && lines[1].starts_with("              word"));
        assert_eq!(text.split_whitespace().filter(|word| *word == "word").count(), 60);
    }

    /// Every technique's page must list all keys of its settings.
    #[test]
    fn a_page_has_all_keys() {
        for entry in REGISTRY {
            let page = page(entry).split_whitespace().collect::<Vec<_>>().join(" ");
            for key in entry.all_keys() {
                assert!(
                    page.contains(&format!("{} {} (default {}; ", key.name, key.about, key.default)),
                    "{}",
                    key.name
                );
            }
            entry.paths.iter().for_each(|path| assert!(page.contains(path.name)));
            let spec = page.rsplit(' ').next().expect("an example");
            assert!(crate::shading::parse(spec).is_ok_and(|specs| specs.len() == 1), "{spec}");
        }
    }
}
