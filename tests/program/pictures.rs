//! `gobo render` and `gobo slice`.

use crate::support::log;
use crate::{decodes, folder, ok, runs, small_scene, text};
use std::path::Path;

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The same command must give the same bytes, forward or deferred, with and without validation.
#[test]
fn render_is_repeatable() {
    log("exercised", "render_is_repeatable", &runs("avsm", "binned").0);
    let folder = folder();
    let scene = small_scene(folder.path());
    let render = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let base = ["render", text(&scene), "--picture", "160x90", "--out", text(&out)];
        let said = ok(&[&base, more].concat());
        assert!(said.is_empty() || said.contains(name), "{said}");
        decodes(&out, [160, 90]);
        bytes(&out)
    };
    let first = render("first.png", &["--technique", "avsm:size=32"]);
    assert_eq!(first, render("second.png", &["--technique", "avsm:size=32", "--validation"]), "another run");
    let thin = render("other.png", &["--technique", "avsm:size=4,nodes=4,curve=linear"]);
    assert_ne!(first, thin, "another map is another picture");
    let deferred = render("deferred.png", &["--technique", "avsm:size=32", "--meshes", "deferred"]);
    render("reference.png", &["--technique", "reference"]);
    let [deferred, forward] = [deferred, first].map(|b| pixels(&b));
    let largest = deferred.iter().zip(&forward).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(largest <= Some(1), "forward and deferred differ by {largest:?} of 255");
}

/// Compares interleaved virtual lights with one bounce of light: the table must list the passes, the results the numbers,
/// and the bounce's picture must be next to the others.
#[test]
fn compare_traces_a_bounce() {
    if crate::support::is_costly("compare_traces_a_bounce") {
        return;
    }
    log("exercised", "compare_traces_a_bounce", &runs("avsm", "binned").0);
    let folder = folder();
    let compare = ["compare", "cornell", "--vpls", "64", "--bounce", "8", "--quick", "--frames", "1", "--passes"];
    let spec = ["--picture", "32x18", "--technique", "shadow-map:size=16,shading=interleaved", "--out"];
    let said = ok(&[&compare[..], &spec, &[text(folder.path())]].concat());
    let mut results = crate::results(folder.path());
    // Without timestamps, pass times are unknown.
    let timed = results.device.features["timestamp_valid_bits"] != 0;
    for word in ["interleaved.ask", "interleaved.gather"] {
        assert_eq!(said.contains(word), timed, "{word} in {said}");
    }
    let error = results.rows.remove(0).error.expect("a truth").image.expect("a picture");
    let (found, noise) = (error.bounce_rmse.expect("asked for"), error.bounce_noise.expect("asked for"));
    assert!(noise > 0.0 && noise < found && found < 0.3, "{error:?}");
    decodes(&folder.path().join("cornell-64-vpls-bounce.png"), [32, 18]);
}

/// Paints a virtual light's map before and after filling holes: they must differ only in texels that were empty, and fewer may be empty
/// after. A technique without such a map must give one line.
#[test]
fn a_map_is_painted() {
    log("exercised", "a_map_is_painted", &runs("avsm", "binned").0);
    let folder = folder();
    let map = |fill: &str| {
        let out = folder.path().join(format!("{fill}.png"));
        let spec = format!("ism:fill={fill},points=1024,path=atomic");
        let arguments = ["map", "cornell", "--vpls", "64", "--light", "9", "--scale", "2", "--technique", &spec];
        ok(&[&arguments[..], &["--out", text(&out)]].concat());
        decodes(&out, [128, 128]);
        pixels(&bytes(&out))
    };
    let empty = |pixels: &[u8]| pixels.chunks(3).filter(|p| p[0] != p[1]).count();
    let [before, after] = ["off", "on"].map(map);
    assert!(empty(&after) < empty(&before), "{} after {}", empty(&after), empty(&before));
    super::errors::fails(&["map", "cornell", "--technique", "shadow-map"], &["shadow-map", "no distances", "ism"]);
    super::errors::fails(
        &["map", "cornell", "--technique", "ism", "--vpls", "64", "--light", "64"],
        &["--light 64", "64 lights"],
    );
}

/// The same fog must always give the same picture, even after other frames; thicker fog must give another, and fog with no extinction none.
#[test]
fn render_fills_fog() {
    if crate::support::is_long("render_fills_fog") {
        return;
    }
    log("exercised", "render_fills_fog", &runs("avsm", "binned").0);
    let folder = folder();
    let render = |name: &str, scene: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let base = ["render", scene, "--plain", "--picture", "64x36", "--validation", "--out", text(&out)];
        ok(&[&base, more].concat());
        out
    };
    let scene = small_scene(folder.path());
    let small = |name: &str, more: &[&str]| pixels(&bytes(&render(name, text(&scene), more)));
    let technique = ["--technique", "avsm:size=32"];
    let with = |more: &[&'static str]| [&technique, more].concat();
    let clear = small("clear.png", &technique);
    assert_eq!(clear, small("none.png", &with(&["--fog", "0"])));
    let foggy = small("foggy.png", &with(&["--fog", "0.1"]));
    assert_eq!(foggy, small("again.png", &with(&["--fog", "0.1"])));
    let deferred = small("deferred.png", &with(&["--fog", "0.1", "--meshes", "deferred"]));
    assert!(foggy.iter().zip(&deferred).all(|(a, b)| a.abs_diff(*b) <= 1), "forward and deferred differ");
    assert_ne!(foggy, small("thick.png", &with(&["--fog", "0.2"])));
    assert_ne!(foggy, small("coarse.png", &with(&["--fog", "0.1", "--fog-steps", "2"])));
    let reference = small("reference.png", &["--technique", "reference", "--fog", "0.1"]);
    let mean =
        |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64;
    let (near, far) = (mean(&foggy, &reference), mean(&clear, &reference));
    assert!(near * 4.0 < far, "{near} of 255 from the reference, and {far} without fog");

    let fog = ["--fog", "0.05", "--fog-steps", "8", "--technique", "avsm:size=32"];
    render("moving.png", "lantern", &[&fog[..], &["--moving", "1..2", "--frames", "2"]].concat());
    let last = render("last.png", "lantern", &[&fog[..], &["--time", "2"]].concat());
    assert_eq!(bytes(&folder.path().join("moving-1.png")), bytes(&last));
    assert_ne!(bytes(&folder.path().join("moving-0.png")), bytes(&last));
}

/// Lighting at vertices must be close to lighting at each pixel; the lines of its triangles must be dark, and on casters only.
#[test]
fn render_draws_lines() {
    if crate::support::is_costly("render_draws_lines") {
        return;
    }
    let (device, runs) = runs("any", "render --wireframe");
    if !runs {
        return crate::support::skipped("render_draws_lines", "needs tessellationShader and fillModeNonSolid");
    }
    log("exercised", "render_draws_lines", &device);
    let folder = folder();
    let scene = small_scene(folder.path());
    let render = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let size = ["--picture", "160x90", "--validation", "--out", text(&out)];
        ok(&[&["render", text(&scene), "--plain"][..], &size, more].concat());
        pixels(&bytes(&out))
    };
    let fragment = render("fragment.png", &["--technique", "avsm:size=32"]);
    let vertex = render("vertex.png", &["--technique", "avsm:size=32,lighting=vertex"]);
    let lines = render("lines.png", &["--technique", "avsm:size=32,lighting=vertex", "--wireframe"]);
    let differing = |a: &[u8], b: &[u8], by: u8| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > by).count();
    assert!(differing(&fragment, &vertex, 0) > 0, "it is another way to light");
    assert_eq!(differing(&fragment, &vertex, 32), 0, "with nearly the same picture");
    let dark = differing(&vertex, &lines, 32);
    assert!(dark > 300 && dark < vertex.len() / 4, "{dark} of {} values are under lines", vertex.len());
    assert!(vertex.iter().zip(&lines).all(|(a, b)| b <= a), "lines are darker than what they are drawn over");
}

fn pixels(png: &[u8]) -> Vec<u8> {
    image::load_from_memory(png).expect("a PNG").to_rgb8().into_raw()
}

/// A sweep must write one PNG per frame and one animation, from full light to what passes through the smoke.
#[test]
fn slice_paints_a_sweep() {
    use image::AnimationDecoder;
    log("exercised", "slice_paints_a_sweep", &runs("avsm", "two-pass").0);
    let folder = folder();
    let scene = small_scene(folder.path());
    let out = folder.path().join("sweep.png");
    let size = ["--picture", "40x40", "--technique", "avsm:size=40", "--plain", "--validation"];
    ok(&[&["slice", text(&scene), "--frames", "4", "--out", text(&out)][..], &size].concat());
    let frames: Vec<_> = (0..4).map(|i| folder.path().join(format!("sweep-{i}.png"))).collect();
    let mean = |path: &Path| {
        decodes(path, [40, 40]);
        let pixels = pixels(&bytes(path));
        pixels.iter().map(|p| f64::from(*p)).sum::<f64>() / pixels.len() as f64
    };
    let means: Vec<_> = frames.iter().map(|f| mean(f)).collect();
    assert_eq!(means[0], 255.0, "nothing is in front of the nearest depth");
    assert!(means.windows(2).all(|m| m[1] < m[0]), "deeper is darker: {means:?}");
    let file = std::io::Cursor::new(bytes(&out.with_extension("gif")));
    let animation = image::codecs::gif::GifDecoder::new(file).expect("a GIF");
    let animated = animation.into_frames().collect_frames().expect("frames");
    assert_eq!(animated.len(), 4);
    assert!(animated.iter().all(|f| f.buffer().dimensions() == (40, 40)));

    let last = folder.path().join("last.png");
    ok(&[&["slice", text(&scene), "--depth", "1", "--out", text(&last)][..], &size].concat());
    assert_eq!(bytes(&last), bytes(&frames[3]), "depth 1 is the last frame of the sweep");
}

/// Slices and curves must support particle shadow maps on every path, same as any technique.
#[test]
fn slices_and_curves_know_psm() {
    let (device, runs) = runs("psm", "raster");
    if !runs {
        return crate::support::skipped(
            "slices_and_curves_know_psm",
            "needs a layer from a vertex or a geometry shader",
        );
    }
    log("exercised", "slices_and_curves_know_psm", &device);
    let folder = folder();
    let scene = small_scene(folder.path());
    let paint = |path: &str| {
        let out = folder.path().join(format!("{path}.png"));
        let technique = format!("psm:path={path},size=40,slices=32,storage=rgba16f");
        let more = ["--picture", "40x40", "--depth", "0.7", "--technique", &technique, "--plain", "--validation"];
        ok(&[&["slice", text(&scene), "--out", text(&out)][..], &more].concat());
        pixels(&bytes(&out))
    };
    let [raster, fused] = ["raster", "fused"].map(paint);
    assert!(raster.iter().any(|p| *p != raster[0]), "a shadow");
    // The 32 slices are blended in half floats by one path and summed by the other.
    let largest = raster.iter().zip(&fused).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(largest <= Some(2), "raster and fused differ by {largest:?} of 255");
    let out = folder.path().join("curve.svg");
    let techniques = ["--technique", "psm:size=40,slices=32", "--technique", "avsm:size=40"];
    ok(&[&["curve", text(&scene), "--texel", "20,20", "--out", text(&out)][..], &techniques].concat());
    let svg = std::fs::read_to_string(&out).expect("an SVG");
    assert!(svg.contains("psm:") && svg.contains("avsm:"), "a line for each");
}

/// A triangle whose tip is at −y: with −y up its wide edge is below in the picture, with y up above.
#[test]
fn a_file_is_drawn_upright() {
    log("exercised", "a_file_is_drawn_upright", &runs("none", "lit").0);
    let folder = folder();
    let tip = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n-1 0 0\n1 0 0\n0 -3 0\n3 0 1 2\n";
    let file = folder.path().join("tip.ply");
    std::fs::write(&file, tip).expect("written");
    // Covered pixels of the upper half and of the lower.
    let halves = |up: &str| {
        let out = folder.path().join("up.png");
        ok(&[
            "render",
            text(&file),
            "--up",
            up,
            "--picture",
            "96x54",
            "--technique",
            "none",
            "--plain",
            "--out",
            text(&out),
        ]);
        let picture = image::open(&out).expect("a picture").to_rgb8();
        let sky = *picture.get_pixel(0, 0);
        let covered = |rows: std::ops::Range<u32>| {
            rows.flat_map(|y| (0..96).map(move |x| (x, y))).filter(|(x, y)| *picture.get_pixel(*x, *y) != sky).count()
        };
        [covered(0..27), covered(27..54)]
    };
    let [[above, below], [upside_above, upside_below]] = [halves("-y"), halves("y")];
    assert!(above > 20 && below > 2 * above, "{above} and {below}");
    assert!(upside_below > 20 && upside_above > 2 * upside_below, "{upside_above} and {upside_below}");
    let refused = crate::run(&["render", "plume_8k", "--up", "y"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("plume_8k is no data file"), "{said}");
}
