//! Tables of docs are made from results/*.csv by a recipe in the comment before each. `GOBO_WRITE_TABLES=1` rewrites them; otherwise a
//! differing cell fails the test.
//!
//! ```text
//! <!-- rows nvidia-h200/results
//! two = avsm:nodes=$K,path=two-pass
//! list = uncompressed in nvidia-h200/hair of hair
//! scene=plume_8k,big-8k K=4,8 | $scene | $K | {build two} / {build list} | {map.error two / map.error list}
//! -->
//! | scene | K | build, ms | error, ratio |
//! |---|---|---|---|
//! <!-- /rows -->
//! ```
//!
//! The first line names the file. Then come short names for specs, possibly of another file or scene. Then comes a line per row: values for
//! the variables that `$` refers to, each in turn if there are several (`;` in a value is a comma), and the cells; `"` repeats the previous
//! row's cells. Braces contain a column and a spec ([`Rows`] lists the columns), optionally with a unit, or several of them with operators
//! in between, evaluated from left to right.

use super::rows::{Rows, Which};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Results of checking tables.
#[derive(Default)]
struct Counted {
    tables: usize,
    cells: usize,
    /// Lines that name differing cells.
    off: Vec<String>,
    /// Recipes that refer to something missing, which rewriting does not fix.
    wrong: Vec<String>,
}

/// Locked by tests that write pages: tests run in parallel, and one could overwrite what another has read.
pub static WRITING: std::sync::Mutex<()> = std::sync::Mutex::new(());

#[test]
fn tables_are_their_rows() {
    let _alone = WRITING.lock();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let writes = std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty());
    let mut counted = Counted::default();
    let mut files = BTreeMap::new();
    for page in pages(root) {
        let text = std::fs::read_to_string(&page).expect("a page");
        let name = name(root, &page);
        let new = remade(&text, &name, &mut counted, &mut |file: &str, which: &Which, column: &str| {
            if !files.contains_key(file) {
                files.insert(file.to_owned(), Rows::read(root, file)?);
            }
            files[file].value(which, column)
        });
        if writes && new != text {
            std::fs::write(&page, new).expect("write a page");
        }
    }
    assert!(counted.wrong.is_empty(), "{}", counted.wrong.join("\n"));
    println!("{} tables, {} cells, {} off", counted.tables, counted.cells, counted.off.len());
    assert!(counted.tables > 20, "{} tables: where are the others?", counted.tables);
    let way_out = "GOBO_WRITE_TABLES=1 cargo test --release --test docs tables writes them anew";
    assert!(counted.off.is_empty() || writes, "{}\n{way_out}", counted.off.join("\n"));
}

/// Returns README.md and all pages of docs.
pub fn pages(root: &Path) -> Vec<PathBuf> {
    let (mut pages, mut folders) = (vec![root.join("README.md")], vec![root.join("docs")]);
    while let Some(folder) = folders.pop() {
        let within = std::fs::read_dir(folder).expect("docs").map(|entry| entry.expect("a page").path());
        for path in within {
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|ending| ending == "md") => pages.push(path),
                false => {}
            }
        }
    }
    pages.sort();
    pages
}

/// Returns a page's path in the repository: `docs/guide/start.md`.
pub fn name(root: &Path, page: &Path) -> String {
    page.strip_prefix(root).expect("a page of the repository").to_string_lossy().into_owned()
}

/// Looks up a value by file, row and column.
type Ask<'a> = dyn FnMut(&str, &Which, &str) -> Result<f64, String> + 'a;

/// Returns a page with its tables as they should be.
fn remade(text: &str, name: &str, counted: &mut Counted, ask: &mut Ask) -> String {
    let mut new = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("<!-- rows ") {
        let (recipe, after) = after.split_once("-->\n").expect("a comment ends");
        let (table, after) = after.split_once("<!-- /rows -->").unwrap_or_else(|| panic!("{name}: no <!-- /rows -->"));
        counted.tables += 1;
        let (head, old) = table.match_indices('\n').nth(1).map_or((table, ""), |(at, _)| table.split_at(at + 1));
        let body = match body(recipe, counted, ask) {
            Ok(body) => body,
            Err(cause) => {
                counted.wrong.push(format!("{name}: {cause}"));
                old.to_owned()
            }
        };
        compare(name, old, &body, &mut counted.off);
        new += &format!("{before}<!-- rows {recipe}-->\n{head}{body}<!-- /rows -->");
        rest = after;
    }
    new + rest
}

/// Lists the differences between two tables.
fn compare(name: &str, old: &str, new: &str, off: &mut Vec<String>) {
    let lines = |text: &str| text.lines().map(|line| line.split('|').map(|c| c.trim().to_owned()).collect()).collect();
    let (old, new): (Vec<Vec<String>>, Vec<Vec<String>>) = (lines(old), lines(new));
    if old.len() != new.len() {
        off.push(format!("{name}: {} rows, and there should be {}", old.len(), new.len()));
    }
    for (old, new) in old.iter().zip(&new) {
        for (a, b) in old.iter().zip(new).filter(|(a, b)| a != b) {
            off.push(format!("{name}: {}: {a}, and it should be {b}", new[..3.min(new.len())].join(" ").trim()));
        }
        if old.len() != new.len() {
            off.push(format!("{name}: {old:?} should have {} cells", new.len()));
        }
    }
}

/// Repeats the cells of the row before.
const DITTO: &str = "\"";

/// Meaning of a short name for a spec.
struct Short<'a> {
    spec: &'a str,
    file: &'a str,
    scene: Option<&'a str>,
}

/// Returns the lines of a table.
fn body(recipe: &str, counted: &mut Counted, ask: &mut Ask) -> Result<String, String> {
    let mut lines = recipe.lines();
    let file = lines.next().unwrap_or_default().trim();
    let mut shorts: BTreeMap<&str, Short> = BTreeMap::new();
    let (mut body, mut last) = (String::new(), String::new());
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let Some((variables, cells)) = line.split_once('|') else {
            let (name, what) = line.split_once(" = ").ok_or_else(|| format!("{line:?} is neither a row nor a spec"))?;
            let (what, scene) = what.split_once(" of ").map_or((what, None), |(what, scene)| (what, Some(scene)));
            let (spec, file) = what.split_once(" in ").unwrap_or((what, file));
            shorts.insert(name.trim(), Short { spec, file, scene });
            continue;
        };
        if cells.trim() != DITTO {
            last = cells.to_owned();
        }
        for variables in combinations(variables)? {
            let filled =
                |text: &str| variables.iter().fold(text.to_owned(), |t, (k, v)| t.replace(&format!("${k}"), v));
            let mut cells = filled(&last);
            while let Some((start, end)) = cells.find('{').zip(cells.find('}')) {
                let asked = &cells[start + 1..end];
                let shown = worked_out(asked, &mut |column, name| {
                    let short = shorts.get(name);
                    let spec = filled(short.map_or(name, |short| short.spec));
                    let scene = filled(short.and_then(|short| short.scene).unwrap_or("$scene"));
                    let file = filled(short.map_or(file, |short| short.file));
                    ask(&file, &Which { scene: &scene, spec: &spec }, column)
                })?;
                counted.cells += 1;
                cells.replace_range(start..=end, &shown);
            }
            body += &format!("|{cells}{}\n", if cells.trim_end().ends_with('|') { "" } else { " |" });
        }
    }
    Ok(body)
}

/// Expands `a=1,2 b=3` to a=1 b=3 and a=2 b=3. The last variable varies fastest.
fn combinations(text: &str) -> Result<Vec<Vec<(String, String)>>, String> {
    let mut all = vec![Vec::new()];
    for pair in text.split_whitespace() {
        let (key, values) = pair.split_once('=').ok_or_else(|| format!("{pair:?} is no name=values"))?;
        let longer = |so_far: &Vec<(String, String)>| {
            let with = |value: &str| [&so_far[..], &[(key.to_owned(), value.replace(';', ","))]].concat();
            values.split(',').map(with).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    // Longest names first, so that no name is mistaken for the start of another.
    all.iter_mut().for_each(|variables| variables.sort_by_key(|(key, _)| std::cmp::Reverse(key.len())));
    Ok(all)
}

/// Units after a spec, relative to the unit of the columns.
const UNITS: [(&str, f64); 6] =
    [("KiB", 1024.0), ("MiB", 1048576.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("%", 0.01)];

/// Parts of the names of columns that contain counts.
const COUNTS: [&str; 7] = ["counter_", ".points", ".leaks", ".false", "resident", "transient", "disk"];

/// Evaluates an expression in braces, formatted for a reader.
fn worked_out(asked: &str, ask: &mut dyn FnMut(&str, &str) -> Result<f64, String>) -> Result<String, String> {
    let mut words = asked.split_whitespace().peekable();
    let mut value = None;
    let mut sign = "";
    let (mut is_whole, mut has_sign) = (true, false);
    while let Some(word) = words.next() {
        if ["/", "+", "-", "*"].contains(&word) {
            sign = word;
            continue;
        }
        let number = word.parse::<f64>();
        is_whole &= sign != "/"
            && (number.is_ok() || !word.starts_with("pass.") && COUNTS.iter().any(|name| word.contains(name)));
        let mut term = match number {
            Ok(number) => number,
            Err(_) => ask(word, words.next().ok_or_else(|| format!("{asked:?}: {word} of what?"))?)?,
        };
        has_sign |= word.ends_with(".bias");
        if let Some((_, unit)) = UNITS.iter().find(|(name, _)| words.peek() == Some(name)) {
            words.next();
            term /= unit;
            is_whole = false;
        }
        value = Some(match (value, sign) {
            (None, _) => term,
            (Some(before), "/") => before / term,
            (Some(before), "+") => before + term,
            (Some(before), "-") => before - term,
            (Some(before), _) => before * term,
        });
    }
    let value: f64 = value.ok_or("nothing in braces")?;
    let plus = if has_sign && value > 0.0 { "+" } else { "" };
    Ok(format!("{plus}{}", shown(value, is_whole)).replace('-', "−").replace("e−", "e-"))
}

/// Formats whole numbers in full and others with three digits; thousands are separated.
fn shown(value: f64, is_whole: bool) -> String {
    let scientific = format!("{value:.2e}");
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if value == 0.0 {
        return "0".into();
    }
    if !is_whole && exponent < -4 {
        return scientific;
    }
    if !is_whole && exponent < 3 {
        return format!("{value:.*}", (2 - exponent) as usize);
    }
    let digits = format!("{value:.0}");
    let groups = |i: usize| i > 0 && i.is_multiple_of(3);
    let apart = digits.chars().rev().enumerate();
    let reversed: String = apart.flat_map(|(i, c)| groups(i).then_some(',').into_iter().chain([c])).collect();
    reversed.chars().rev().collect::<String>().replace("-,", "-")
}

#[test]
fn numbers_as_a_reader_wants_them() {
    for (value, is_whole, text) in [
        (0.0, false, "0"),
        (5.0, true, "5"),
        (1234567.0, true, "1,234,567"),
        (1695.4, false, "1,695"),
        (0.06701, false, "0.0670"),
        (9.996, false, "10.0"),
        (1.57e-7, false, "1.57e-7"),
        (237_732.0, true, "237,732"),
        (-0.285, false, "-0.285"),
    ] {
        assert_eq!(shown(value, is_whole), text);
    }
}

/// Recipes must expand as documented, and a cell with a different number must be found.
#[test]
fn recipes() {
    let page = "<!-- rows a/b\nx = avsm:nodes=$K\ny = psm in c/d of hair\n\
        scene=s,t K=4,16 | $scene | $K | {build x} / {build y} | {disk x MiB} | {build y / build x} |\n-->\n\
        | scene | K | ms | MiB | times |\n|---|---|---|---|---|\n\
        | s | 4 | 0.500 / 2.00 | 3.00 | 4.00 |\n| s | 16 | 0.500 / 2.00 | 3.00 | 4.00 |\n\
        | t | 4 | 0.500 / 2.00 | 3.00 | 4.00 |\n| t | 16 | 0.500 / 2.01 | 3.00 | 4.00 |\n<!-- /rows -->\nend\n";
    let mut asked = Vec::new();
    let mut ask = |file: &str, which: &Which, column: &str| {
        asked.push(format!("{file} {} {} {column}", which.scene, which.spec));
        Ok(match (file, column) {
            ("c/d", _) => 2.0,
            (_, "disk") => 3.0 * 1048576.0,
            _ => 0.5,
        })
    };
    let mut counted = Counted::default();
    let new = remade(page, "page", &mut counted, &mut ask);
    assert_eq!((counted.tables, counted.cells), (1, 16));
    assert_eq!(counted.off, ["page: t 16: 0.500 / 2.01, and it should be 0.500 / 2.00"]);
    assert_eq!(new, page.replace("2.01", "2.00"));
    assert_eq!(asked[..2], ["a/b s avsm:nodes=4 build", "c/d hair psm build"]);
    // A recipe that refers to something missing must be reported in one line, and its table must stay unchanged.
    let (mut counted, none) = (Counted::default(), |_: &str, _: &Which, _: &str| Err("no column".to_owned()));
    assert_eq!(remade(page, "page", &mut counted, &mut { none }), page);
    assert_eq!(counted.wrong, ["page: no column"]);
    assert!(asked.contains(&"a/b t avsm:nodes=16 disk".to_owned()));
}
