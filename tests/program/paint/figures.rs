//! Recreates the documentation's pictures with the commands next to them. To rewrite all of them, run
//!
//!     GOBO_WRITE_PICTURES=1 cargo test --release --test program figures
//!
//! `GOBO_WRITE_PICTURES=fog,hair.png` rewrites those whose names begin with one of these words.

use super::plot::Plot;
use super::rgb8;
use crate::support::{log, shared_data, skipped, some};
use crate::{folder, run, runs, text};
use std::path::{Path, PathBuf};

/// A picture in results/pictures, the page with its command, the start of that command and, for a file that shows two pictures, the column
/// where this one begins.
struct Figure(&'static str, &'static str, &'static str, u32);

/// Quick ones first.
const FIGURES: [Figure; 65] = [
    Figure("glass.png", "docs/notebook/glass.md", "gobo render glasshouse ", 0),
    Figure("glass-colored.png", "docs/notebook/glass.md", "gobo render glasshouse:colored=1", 0),
    Figure("grove-alpha.png", "docs/notebook/foliage.md", "gobo render grove", 0),
    Figure("curve.svg", "docs/notebook/avsm.md", "gobo curve plume_8k", 0),
    Figure("three-emitters-slice.png", "docs/reference/results.md", "gobo slice three-emitters", 0),
    Figure(
        "ism-map.png",
        "docs/notebook/ism.md",
        "gobo map cornell --vpls 256 --light 100 --technique ism:adaptive=off,fill=off",
        0,
    ),
    Figure(
        "ism-map.png",
        "docs/notebook/ism.md",
        "gobo map cornell --vpls 256 --light 100 --technique ism:adaptive=off,fill=on",
        260,
    ),
    Figure("hair-curve.svg", "docs/notebook/avsm.md", "gobo curve hair", 0),
    Figure("steps.png", "docs/notebook/fog.md", "gobo render houses", 0),
    Figure("fog.png", "docs/notebook/fog.md", "gobo render shafts", 0),
    Figure(
        "three-emitters-translucency-map.png",
        "docs/notebook/translucency-map.md",
        "gobo render three-emitters --technique translucency-map",
        0,
    ),
    Figure(
        "three-emitters-beer-shadow-map.png",
        "docs/notebook/beer-shadow-map.md",
        "gobo render three-emitters --technique beer-shadow-map",
        0,
    ),
    Figure("three-emitters-layers.png", "docs/notebook/layers.md", "gobo render three-emitters --technique layers", 0),
    Figure(
        "plume-stochastic-plain.png",
        "docs/notebook/stochastic.md",
        "gobo render plume_8k --technique stochastic:samples=16,sampling=plain",
        0,
    ),
    Figure("plume-half-angle.png", "docs/notebook/half-angle.md", "gobo render plume_8k --technique half-angle", 0),
    Figure(
        "three-emitters-density-grid.png",
        "docs/techniques/density-grid.md",
        "gobo render three-emitters --technique density-grid",
        0,
    ),
    Figure("big-optical-depth-grid.png", "docs/techniques/optical-depth-grid.md", "gobo render big-8k", 0),
    Figure("houses-shadow-map.png", "docs/techniques/shadow-map.md", "gobo render houses", 0),
    Figure("terrain-voxelized.png", "docs/techniques/voxelized.md", "gobo render terrain", 0),
    Figure("mohawk-grid-query.png", "docs/techniques/grid-query.md", "gobo render mohawk", 0),
    Figure("lantern-ray-query.png", "docs/techniques/ray-query.md", "gobo render lantern", 0),
    Figure("plume-deep-shadow-map.svg", "docs/techniques/deep-shadow-map.md", "gobo curve plume_8k", 0),
    Figure("hair-uncompressed.svg", "docs/techniques/uncompressed.md", "gobo curve hair", 0),
    Figure("three-emitters.png", "README.md", "gobo render three-emitters", 0),
    Figure("hair.png", "docs/notebook/avsm.md", "gobo render hair --technique avsm:nodes=16", 0),
    Figure("lantern.png", "docs/reference/lights-and-filters.md", "gobo render lantern", 0),
    Figure("lantern-vertices-wireframe.png", "docs/notebook/lighting.md", "gobo render lantern", 0),
    Figure("lantern-vertices.png", "docs/notebook/lighting.md", "gobo render lantern", 0),
    Figure("courtyard.png", "docs/notebook/many-lights.md", "gobo render courtyard --picture", 0),
    Figure("fountain-density.png", "docs/notebook/particles.md", "gobo render fountain:particles=300000", 0),
    Figure("fountain-speed.png", "docs/notebook/particles.md", "gobo render fountain:particles=1000000", 0),
    Figure("fountain.gif", "docs/notebook/particles.md", "gobo render fountain:particles=100000 ", 0),
    Figure("splats.png", "docs/notebook/splats.md", "gobo render splats --technique avsm:nodes=16 ", 0),
    Figure("ink.png", "docs/notebook/color.md", "gobo render ink --technique avsm:nodes=16 ", 0),
    Figure("cloud.png", "docs/notebook/volumes.md", "gobo render cloud --picture", 0),
    Figure("failures-none.png", "docs/notebook/failures.md", "gobo render failures --technique none", 0),
    Figure(
        "failures-translucency-map.png",
        "docs/notebook/failures.md",
        "gobo render failures --technique translucency-map",
        0,
    ),
    Figure("failures-beer.png", "docs/notebook/failures.md", "gobo render failures --technique beer-shadow-map", 0),
    Figure("failures-layers.png", "docs/notebook/failures.md", "gobo render failures --technique layers", 0),
    Figure("failures-wavelet.png", "docs/notebook/failures.md", "gobo render failures --technique wavelet", 0),
    Figure("failures-fourier.png", "docs/notebook/failures.md", "gobo render failures --technique fourier", 0),
    Figure("failures-moments.png", "docs/notebook/failures.md", "gobo render failures --technique moments", 0),
    Figure(
        "failures-stochastic.png",
        "docs/notebook/failures.md",
        "gobo render failures --technique stochastic:samples",
        0,
    ),
    Figure("failures-hash.png", "docs/notebook/failures.md", "gobo render failures --technique stochastic:sampling", 0),
    Figure("failures-psm.png", "docs/notebook/failures.md", "gobo render failures --technique psm", 0),
    Figure("failures-avsm.png", "docs/notebook/failures.md", "gobo render failures --technique avsm", 0),
    Figure("failures-marched.png", "docs/notebook/failures.md", "gobo render failures --technique marched", 0),
    Figure(
        "failures-deep-shadow-map.png",
        "docs/notebook/failures.md",
        "gobo render failures --technique deep-shadow-map",
        0,
    ),
    Figure(
        "failures-density-grid.png",
        "docs/notebook/failures.md",
        "gobo render failures --technique density-grid",
        0,
    ),
    Figure(
        "failures-optical-depth-grid.png",
        "docs/notebook/failures.md",
        "gobo render failures --technique optical-depth-grid",
        0,
    ),
    Figure("failures-half-angle.png", "docs/notebook/failures.md", "gobo render failures --technique half-angle", 0),
    Figure("failures-reference.png", "docs/notebook/failures.md", "gobo render failures --technique reference", 0),
    Figure("indirect-cornell.png", "docs/notebook/ism.md", "gobo render cornell --vpls 256", 0),
    Figure("indirect-courtyard.png", "docs/notebook/ism.md", "gobo render courtyard --vpls 256", 0),
    Figure("opaque-town.png", "docs/notebook/opaque.md", "gobo render town --picture 320", 0),
    Figure("opaque-courtyard.png", "docs/notebook/opaque.md", "gobo render courtyard --picture 320", 0),
    Figure("opaque-cornell.png", "docs/notebook/opaque.md", "gobo render cornell --picture 320", 0),
    Figure("many-lights.png", "docs/notebook/many-lights.md", "gobo render courtyard --columns", 0),
    Figure(
        "plume-stochastic-stratified.png",
        "docs/notebook/stochastic.md",
        "gobo render plume_8k --technique stochastic:samples=16,sampling=stratified",
        0,
    ),
    Figure(
        "plume-stochastic-hash.png",
        "docs/notebook/stochastic.md",
        "gobo render plume_8k --technique stochastic:samples=16,sampling=hash",
        0,
    ),
    Figure("fountain-color.png", "docs/guide/gallery.md", "gobo render fountain:particles=300000", 0),
    Figure("voxels.png", "docs/guide/gallery.md", "gobo voxels town", 0),
    Figure("tree.png", "docs/guide/gallery.md", "gobo voxels houses", 0),
    Figure("panels.png", "docs/guide/gallery.md", "gobo render three-emitters --picture", 0),
    Figure("town.png", "docs/guide/gallery.md", "gobo render town", 0),
];

/// Figures that take a software driver more than a few seconds: [`figures_that_take_long`].
const SLOW: [&str; 25] = [
    "glass.png",
    "glass-colored.png",
    "grove-alpha.png",
    "cloud.png",
    "courtyard.png",
    "fog.png",
    "fountain-color.png",
    "fountain-density.png",
    "fountain-speed.png",
    "fountain.gif",
    "hair.png",
    "indirect-cornell.png",
    "indirect-courtyard.png",
    "ink.png",
    "lantern.png",
    "many-lights.png",
    "opaque-cornell.png",
    "opaque-courtyard.png",
    "opaque-town.png",
    "panels.png",
    "plume-deep-shadow-map.svg",
    "splats.png",
    "three-emitters-density-grid.png",
    "three-emitters.png",
    "town.png",
];

/// Pictures that no single command of a page creates: composed of the pictures of several commands (hair-footprints.png by
/// results/hair-pictures.py), created by examples/engine, from files that the repository does not include, or captured from a screen (of
/// the window, with a panel of times that differ in every run).
const PUT_TOGETHER: [&str; 12] = [
    "biker.png",
    "devices.png",
    "embed.png",
    "hair-footprints.png",
    "hair-levels.png",
    "rank-cloud-psm.png",
    "rank-cloud.png",
    "rank-fountain.png",
    "rank-plume_8k.png",
    "report.png",
    "view.gif",
    "view.png",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the words of the page's command that begins with `begins`: in a line of text up to its backtick, in a block up to the end of the
/// first line that is not continued.
fn command(page: &str, begins: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(page)).unwrap_or_else(|e| panic!("{page}: {e}"));
    let start = text.find(begins).unwrap_or_else(|| panic!("{page} has no command `{begins}…`"));
    let rest = &text[start..];
    let end = match text[..start].ends_with('`') {
        true => rest.find('`').expect("a closing backtick"),
        false => rest.match_indices('\n').find(|(at, _)| !rest[..*at].ends_with('\\')).map_or(rest.len(), |(at, _)| at),
    };
    let words = rest[..end].split(" #").next().expect("a command").replace("\\\n", " ").replace('\'', "");
    words.split_whitespace().skip(1).map(str::to_owned).collect()
}

/// Runs a figure's command into `folder`; returns `None` if it needs data that is missing, or a driver refuses it.
fn made(Figure(picture, page, begins, _): &Figure, folder: &Path) -> Option<PathBuf> {
    let mut words = command(page, begins);
    if *picture == "lantern-vertices.png" {
        words.retain(|word| word != "--wireframe");
    }
    if words.iter().any(|word| word.ends_with(".toml")) {
        let data = shared_data(&format!("figures, {picture}"))?;
        let of_data = words.iter_mut().filter(|word| word.ends_with(".toml") && !word.contains('/'));
        of_data.for_each(|word| *word = text(&data.join(&**word)).to_owned());
    }
    let out = folder.join(Path::new(picture).with_extension(if picture.ends_with("svg") { "svg" } else { "png" }));
    match words.iter().position(|word| word == "-o") {
        Some(at) => words[at + 1] = text(&out).to_owned(),
        None => words.extend(["-o".to_owned(), text(&out).to_owned()]),
    }
    // Paths in a page's commands are relative to the repository.
    let in_root =
        |word: &String| if word.starts_with("tests/") { text(&root().join(word)).to_owned() } else { word.clone() };
    let words: Vec<String> = words.iter().map(in_root).collect();
    let output = run(&words.iter().map(String::as_str).collect::<Vec<_>>());
    let error = String::from_utf8_lossy(&output.stderr);
    if let Some((_, needs)) = error.split_once("refused: ") {
        skipped(&format!("figures, {picture}"), needs.trim());
        return None;
    }
    assert!(output.status.success(), "{words:?}: {error}");
    Some(out.with_extension(Path::new(picture).extension().expect("of a file")))
}

/// Compares lines and dots of two plots by value, in pixels of the committed one.
fn same_plots(picture: &str, shown: &Plot, made: &Plot) {
    assert_eq!(shown.names, made.names, "{picture}");
    for (i, (shown_line, made_line)) in shown.drawn.iter().zip(&made.drawn).enumerate() {
        let apart = shown.apart(&shown_line.line, &made_line.line);
        let far = |dot: &&glam::DVec2| made_line.dots.iter().all(|other| (*other - **dot).length() > 2.0);
        let moved = shown_line.dots.iter().filter(far).count();
        println!("{picture}, {}: {apart:.2} pixels apart", shown.names[i]);
        assert!(apart < 2.0, "{picture}, {}: {apart} pixels apart", shown.names[i]);
        assert_eq!((shown_line.dots.len(), moved), (made_line.dots.len(), 0), "{picture}, {}", shown.names[i]);
        assert!(shown.off(&shown_line.dots, &shown_line.line) < 2.0, "{picture}: dots are on their line");
    }
    // The axes must have the same numbers.
    let ends = [(0.0, 0.0), (1.0, 1.0)].map(|point| (shown.pixel(point) - made.pixel(point)).length());
    assert!(ends.iter().all(|apart| *apart < 20.0), "{picture}: other axes");
}

/// Compares two pictures, with tolerances for rounding by drivers: a few pixels at edges, and on average half a level of 255.
fn same_pictures(picture: &str, (shown, made): (&Path, &Path), from: u32) {
    let (shown, made) = (rgb8(shown), rgb8(made));
    let [width, height] = made.0;
    assert!(shown.0[0] >= from + width && shown.0[1] == height, "{picture}: {:?} and {:?}", shown.0, made.0);
    assert!(shown.0[0] == width || picture == "ism-map.png", "{picture}: {:?} and {:?}", shown.0, made.0);
    let (mut sum, mut far) = (0.0, 0);
    for (i, pixel) in made.1.iter().enumerate() {
        let (x, y) = (i as u32 % width + from, i as u32 / width);
        let other = shown.1[(y * shown.0[0] + x) as usize];
        let apart = pixel.iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(b)));
        far += usize::from(apart.clone().fold(0.0, f64::max) > 8.0);
        sum += apart.sum::<f64>() / 3.0;
    }
    let (mean, far) = (sum / made.1.len() as f64, far as f64 / made.1.len() as f64);
    println!("{picture}: {mean:.3} of 255 in the mean, {:.3} % by more than 8", 100.0 * far);
    assert!(mean < 0.5 && far < 0.01, "{picture}: {mean} of 255 in the mean, {} % by more than 8", 100.0 * far);
}

/// Creates a figure, and compares it with the committed one.
fn compared(figure: &Figure, folder: &Path) {
    let Some(out) = made(figure, folder) else { return };
    let shown = root().join("results/pictures").join(figure.0);
    match figure.0.ends_with(".svg") {
        true => same_plots(figure.0, &Plot::read(&shown), &Plot::read(&out)),
        false => same_pictures(figure.0, (&shown, &out), figure.3),
    }
}

/// Replaces the committed pictures; if a file shows two of them, it replaces both.
fn write(names: &str, folder: &Path) {
    let wanted = |figure: &&Figure| names == "1" || names.split(',').any(|name| figure.0.starts_with(name));
    for figure in FIGURES.iter().filter(wanted) {
        let Some(out) = made(figure, folder) else { continue };
        let place = root().join("results/pictures").join(figure.0);
        if figure.0 != "ism-map.png" {
            std::fs::copy(&out, &place).unwrap_or_else(|e| panic!("{}: {e}", figure.0));
            println!("{} is written", figure.0);
            continue;
        }
        let mut both = image::open(&place).expect("two pictures").to_rgb8();
        image::imageops::replace(&mut both, &image::open(&out).expect("one").to_rgb8(), figure.3.into(), 0);
        both.save(&place).expect("written");
    }
}

/// Each figure must show what its command creates.
#[test]
fn figures_are_what_their_commands_make() {
    const NAME: &str = "figures_are_what_their_commands_make";
    let (device, two_pass) = runs("avsm", "two-pass");
    if !two_pass {
        return skipped(NAME, "needs fragmentStoresAndAtomics");
    }
    log("exercised", NAME, &device);
    let folder = folder();
    if let Some(names) = std::env::var_os("GOBO_WRITE_PICTURES") {
        return write(&names.into_string().expect("names"), folder.path());
    }
    let quick = FIGURES.iter().filter(|figure| !SLOW.contains(&figure.0));
    some(quick, 3).into_iter().for_each(|figure| compared(figure, folder.path()));
    skipped(
        NAME,
        &format!("{} pictures take long: figures_that_take_long, which is ignored, compares them", SLOW.len()),
    );
}

/// Checks the slow figures, which takes many minutes.
#[test]
#[ignore = "takes many minutes on a software driver"]
fn figures_that_take_long() {
    log("exercised", "figures_that_take_long", &runs("avsm", "two-pass").0);
    let folder = folder();
    FIGURES.iter().filter(|figure| SLOW.contains(&figure.0)).for_each(|figure| compared(figure, folder.path()));
}

/// Every picture must have a command or a page that shows it.
#[test]
fn pictures_are_of_commands() {
    let folder = |name| std::fs::read_dir(root().join(name)).expect("the pages");
    let pages: String = folder("docs")
        .chain(folder("docs/guide"))
        .chain(folder("docs/reference"))
        .chain(folder("docs/techniques"))
        .chain(folder("docs/notebook"))
        .map(|page| page.expect("a page").path())
        .chain([root().join("README.md")])
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .map(|path| std::fs::read_to_string(path).expect("a page"))
        .collect();
    let pictures = std::fs::read_dir(root().join("results/pictures")).expect("the pictures");
    for name in pictures.map(|file| file.expect("a picture").file_name().into_string().expect("UTF-8")) {
        assert!(pages.contains(&format!("results/pictures/{name}")), "{name} is on no page");
        let made = FIGURES.iter().any(|figure| figure.0 == name) || PUT_TOGETHER.contains(&name.as_str());
        assert!(made, "{name}: nothing says which command makes it");
    }
    FIGURES.iter().for_each(|Figure(_, page, begins, _)| drop(command(page, begins)));
}
