//! Rows of results/*.csv for the tables of docs: the file's columns by name, and a few derived from them.

use gobo::shading::parse;
use gobo::technique::settings::AUTO;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Rows of a file, as maps from column to text.
pub struct Rows {
    file: String,
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<BTreeMap<String, String>>,
}

/// Selects a row.
pub struct Which<'a> {
    pub scene: &'a str,
    /// Spec as a user gives it: omitted keys have their defaults.
    pub spec: &'a str,
}

/// Technique, key and former default of a key whose default is now `auto`; the two are the same except with detail=adaptive.
const WAS: (&str, &str, &str) = ("avsm", "storage", "full");

impl Rows {
    /// Reads a file: `nvidia-h200/psm` is results/nvidia-h200/psm.csv.
    pub fn read(root: &Path, file: &str) -> Result<Self, String> {
        let path = root.join("results").join(file).with_extension("csv");
        let wrong = |cause: csv::Error| format!("{}: {cause}", path.display());
        let mut reader = csv::Reader::from_path(&path).map_err(wrong)?;
        let columns: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_owned).collect();
        let rows = reader.deserialize().collect::<Result<_, _>>().map_err(wrong)?;
        Ok(Self { file: file.to_owned(), path, columns, rows })
    }

    /// Returns the number in a column of a row: times in milliseconds, sizes in bytes.
    pub fn value(&self, which: &Which, column: &str) -> Result<f64, String> {
        self.of_row(self.row(which)?, column)
    }

    /// Returns technique, path and numbers of all rows of a scene that have numbers in all of these columns.
    pub fn all<const N: usize>(&self, scene: &str, columns: [&str; N]) -> Vec<(String, String, [f64; N])> {
        let is_it = |row: &&BTreeMap<String, String>| row.get("scene").is_some_and(|name| name == scene);
        let figures = |row: &BTreeMap<String, String>| {
            let mut numbers = [0.0; N];
            for (number, column) in numbers.iter_mut().zip(columns) {
                *number = self.of_row(row, column).ok()?;
            }
            let text = |name: &str| row.get(name).cloned().unwrap_or_default();
            Some((text("variant"), text("path"), numbers))
        };
        self.rows.iter().filter(is_it).filter_map(figures).collect()
    }

    fn of_row(&self, row: &BTreeMap<String, String>, column: &str) -> Result<f64, String> {
        let at = |name: &str| self.number(row, name);
        let ms = |name: &str| Ok(at(name)? / 1e6);
        match column {
            "build" | "host" => ms(&format!("{column}_median_ns")),
            "draw" => ms("draw_median_ns"),
            "frame" => ms("frame_ns"),
            "look-up" => ms("lookup_median_ns_per_million"),
            "cost" => ms("cost_ns"),
            // Cost of a row whose picture is painted in compute, and whose build does not draw.
            "painted" => match row.get("painter").map(String::as_str) {
                Some("compute") if row["marks"].is_empty() => ms("cost_ns"),
                _ => Err(format!("{} is drawn", row["variant"])),
            },
            // Time of a build and a million look-ups, if neither draws; for a bake, of the look-ups alone.
            "compute" => match row.get("path").map(String::as_str) {
                Some("raster" | "two-pass" | "interlock" | "raster-order" | "list") => {
                    Err(format!("{} draws", row["variant"]))
                }
                _ if row["technique"] == "voxelized" => ms("lookup_median_ns_per_million"),
                _ => Ok(ms("build_median_ns")? + ms("lookup_median_ns_per_million")?),
            },
            "resident" | "transient" => at(&format!("bytes_{column}")),
            "disk" => at("bytes_on_disk"),
            // Build time relative to copying as many bytes as the build leaves resident.
            "floor" => Ok(at("build_median_ns")? * self.copy_gb_per_second()? / at("bytes_resident")?),
            _ => match column.split_once('.') {
                Some(("pass", prefix)) => self.passes(row, prefix),
                Some((points @ ("map" | "space" | "surface"), what)) => self.error(row, points, what),
                _ => at(column),
            },
        }
    }

    /// Returns the only row with this scene and spec.
    fn row(&self, which: &Which) -> Result<&BTreeMap<String, String>, String> {
        let Which { scene, spec } = which;
        let [wanted] = &parse(spec).map_err(|error| error.to_string())?[..] else {
            return Err(format!("{spec} is a sweep"));
        };
        let wanted_keys = wanted.variant();
        // The row must have the keys that the spec names. A key that the spec omits may be newer than the row, which was then measured with
        // its default.
        let named: Vec<&str> = spec
            .split(':')
            .skip(1)
            .flat_map(|keys| keys.split(','))
            .filter_map(|pair| Some(pair.split_once('=')?.0))
            .collect();
        let is_it = |row: &&BTreeMap<String, String>| {
            let variant = row.get("variant").map_or("", String::as_str);
            let (name, keys) = variant.split_once(':').unwrap_or((variant, ""));
            let keys = keys.split(',').filter_map(|pair| pair.split_once('='));
            let same = |(key, value): (&str, &str)| {
                let was = !variant.contains("detail=adaptive")
                    && (name, key, value) == WAS
                    && wanted_keys.get(key).is_some_and(|wanted| wanted == AUTO);
                was || wanted_keys.get(key).is_none_or(|wanted| wanted == value)
            };
            let says = |key: &&str| keys.clone().any(|(said, _)| said == *key);
            let is_scene = row.get("scene").is_some_and(|name| name == scene);
            is_scene && name == wanted.entry.name && keys.clone().all(same) && named.iter().all(says)
        };
        let mut found = self.rows.iter().filter(is_it);
        match (found.next(), found.next()) {
            (Some(row), None) => Ok(row),
            (None, _) => Err(format!("{}.csv has no row of {scene}, {}", self.file, wanted.short())),
            _ => Err(format!("{}.csv has several rows of {scene}, {}", self.file, wanted.short())),
        }
    }

    fn number(&self, row: &BTreeMap<String, String>, column: &str) -> Result<f64, String> {
        let text = row.get(column).ok_or_else(|| format!("{}.csv has no column {column}", self.file))?;
        text.parse().map_err(|_| format!("{}.csv: {column} of {}: {text:?} is no number", self.file, row["variant"]))
    }

    /// Returns the copy rate printed with the rows.
    fn copy_gb_per_second(&self) -> Result<f64, String> {
        let path = self.path.with_extension("txt");
        let text = std::fs::read_to_string(&path).map_err(|cause| format!("{}: {cause}", path.display()))?;
        let rate = text.rsplit_once(" GB/s").and_then(|(before, _)| before.rsplit(' ').next());
        rate.and_then(|rate| rate.parse().ok()).ok_or_else(|| format!("{}: no rate of copying", path.display()))
    }

    /// Returns the time of all passes, of builds and pictures, whose names begin with `prefix`.
    fn passes(&self, row: &BTreeMap<String, String>, prefix: &str) -> Result<f64, String> {
        let texts = ["pass_median_ns", "draw_pass_median_ns"].map(|name| row.get(name).map_or("", String::as_str));
        let pairs = texts.iter().flat_map(|text| text.split(' ')).filter_map(|pair| pair.split_once('='));
        // Older rows of simulated scenes list the draw passes in both columns.
        let mut seen = BTreeSet::new();
        let of = pairs.filter(|(name, _)| name.starts_with(prefix) && seen.insert(name.to_owned()));
        let times: Vec<f64> = of.filter_map(|(_, ns)| ns.parse().ok()).collect();
        match times.is_empty() {
            true => Err(format!("{}.csv: no pass {prefix} of {}", self.file, row["variant"])),
            false => Ok(times.iter().sum::<f64>() / 1e6),
        }
    }

    /// Returns `error`, `points`, `leaks` or `false` over all points, or, with the prefix `within.` or `beyond.`, over those within or
    /// beyond the technique's own resolution. Files of schema 2 have the points beyond in the plain columns, and those within as
    /// *boundary*; the plain columns of later files cover all points.
    fn error(&self, row: &BTreeMap<String, String>, points: &str, what: &str) -> Result<f64, String> {
        let is_old = self.columns.iter().any(|column| column.starts_with(&format!("{points}_boundary_")));
        let within = if is_old { "boundary" } else { "within" };
        // An exact technique, or a scene without meshes, has no points within the resolution.
        let part = |name: &str| match row.get(&format!("{points}_{within}_{name}")) {
            Some(text) if text.is_empty() => Ok(0.0),
            _ => self.number(row, &format!("{points}_{within}_{name}")),
        };
        let plain = |name: &str| self.number(row, &format!("{points}_{name}"));
        let (which, what) = what.split_once('.').unwrap_or(("all", what));
        // Returns a column's totals over all points and over the points within: counts as they are or, if `weighted`, means times their
        // numbers of points.
        let sums = |name: &str, weighted: bool| -> Result<[f64; 2], String> {
            let weight = |count: f64| if weighted { count } else { 1.0 };
            let (own, inner) = (plain(name)? * weight(plain("points")?), part(name)? * weight(part("points")?));
            Ok(if is_old { [own + inner, inner] } else { [own, inner] })
        };
        let of = |[all, inner]: [f64; 2]| match which {
            "all" => Ok(all),
            "within" => Ok(inner),
            "beyond" => Ok(all - inner),
            _ => Err(format!("{points}.{which} is no part of all points")),
        };
        match what {
            "points" => of(sums("points", false)?),
            "leaks" => of(sums("leaks", false)?),
            "false" => of(sums("false_shadows", false)?),
            "share" => Ok(of(sums("points", false)?)? / sums("points", false)?[0]),
            "error" => Ok(of(sums("mean_abs", true)?)? / of(sums("points", false)?)?),
            _ => plain(what),
        }
    }
}
