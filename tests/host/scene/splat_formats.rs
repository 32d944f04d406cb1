//! Splats of a closed form, as the formats' own tools wrote them (splat_formats/make.sh): every number of every splat, to what the format
//! rounds it to.

use crate::scene::*;
use gobo::animate::AnimatedScene;
use gobo::scene::Splat;

const COUNT: usize = 300;

/// Rounding of floats: positions are below 100 and logarithms below 10.
const FLOAT: f64 = 8e-6;

/// The splat of a number, of `count`, as in make.py. The rotation is x, y, z, w.
struct Expected {
    position: [f64; 3],
    deviations: [f64; 3],
    rotation: [f64; 4],
    opacity: f64,
    color: [f64; 3],
}

fn expected(i: usize, count: usize) -> Expected {
    let whole = |factor: usize, modulus: usize, less: f64| ((i * factor) % modulus) as f64 - less;
    let turn = [whole(7, 11, 4.75), whole(5, 13, 5.75), whole(3, 17, 7.75), whole(11, 19, 8.75)];
    let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    Expected {
        position: [
            whole(37, 101, 50.0) * 0.37 + 0.001 * i as f64,
            whole(53, 89, 44.0) * 0.11 - 0.003 * i as f64,
            whole(71, 97, 48.0) * 1.7,
        ],
        deviations: [5, 11, 23].map(|k| 10f64.powf(-4.0 + 5.0 * whole(k, 64, 0.0) / 63.0)),
        rotation: [turn[1], turn[2], turn[3], turn[0]].map(|x| x / length),
        opacity: 0.01 + 0.989 * whole(29, count, 0.0) / (count - 1) as f64,
        color: [3, 7, 17].map(|k| whole(k, 41, 0.0) / 40.0),
    }
}

fn seeds(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(path)
}

fn here(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/host/scene/splat_formats").join(path)
}

fn read(path: &Path) -> (Vec<Splat>, Vec<String>) {
    let loaded = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    let notes = loaded.notes.into_iter().filter(|note| !note.contains("taken for up"));
    (loaded.scene.splats, notes.collect())
}

/// Puts splats in the order of the closed form, each to the nearest position. No two may go to one.
fn sorted(splats: &[Splat]) -> Vec<Splat> {
    let mut sorted = vec![None; splats.len()];
    for splat in splats {
        let distance = |i: &usize| {
            let of = expected(*i, splats.len()).position;
            (0..3).map(|axis| (of[axis] - f64::from(splat.position[axis])).powi(2)).sum::<f64>()
        };
        let nearest = (0..splats.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("splats");
        assert!(sorted[nearest].replace(*splat).is_none(), "two for {nearest}");
    }
    sorted.into_iter().map(|splat| splat.expect("each")).collect()
}

/// Asserts that a number is in a range around another.
#[track_caller]
fn near(what: &str, number: f32, expected: f64, [below, above]: [f64; 2]) {
    let difference = f64::from(number) - expected;
    assert!(-below <= difference && difference <= above, "{what}: {number} for {expected}, {difference:e} apart");
}

/// Asserts that a rotation is within an angle, in radians, of another; from the distance, since a small angle's cosine has few digits.
#[track_caller]
fn turned(splat: &Splat, expected: &Expected, most: f64) {
    let found = splat.rotation.map(f64::from);
    let distance = |sign: f64| (0..4).map(|i| (found[i] - sign * expected.rotation[i]).powi(2)).sum::<f64>().sqrt();
    let angle = 4.0 * (distance(1.0).min(distance(-1.0)) / 2.0).min(1.0).asin();
    assert!(angle <= most + FLOAT, "{found:?} for {:?}: {angle}", expected.rotation);
}

/// The greatest angle for an error of three components of a quaternion. The greatest component, which follows, is at least 1/2, so that its
/// error is at most the sum of the others'. An angle is twice the distance of quaternions.
fn most_turned(error: f64) -> f64 {
    2.0 * 12f64.sqrt() * error * 1.01
}

/// How far each property may be below and above what it should be.
struct Rounding {
    position: [f64; 2],
    /// The deviations' logarithms.
    deviation: [f64; 2],
    color: [f64; 2],
    opacity: [f64; 2],
    turn: f64,
}

#[track_caller]
fn check(splats: &[Splat], rounding: &Rounding) {
    for (i, splat) in splats.iter().enumerate() {
        let expected = expected(i, splats.len());
        for axis in 0..3 {
            near("position", splat.position[axis], expected.position[axis], rounding.position);
            let [found, should] = [f64::from(splat.deviations[axis]), expected.deviations[axis]].map(f64::ln);
            near("deviation", found as f32, should, rounding.deviation);
            near("color", splat.color[axis], expected.color[axis], rounding.color);
        }
        near("opacity", splat.opacity, expected.opacity, rounding.opacity);
        turned(splat, &expected, rounding.turn);
    }
}

fn half(quantum: f64) -> [f64; 2] {
    [quantum / 2.0 + FLOAT; 2]
}

/// Positions in 1/4096, logarithms of deviations in 1/16, opacities in 1/255, coefficients of colors in 1/255/0.15; rotations have steps of
/// 1/(511 √2) in three components. Versions 3 and 4 hold the same.
#[test]
fn spz_has_the_closed_form() {
    let color = half(0.282_094_79 / 255.0 / 0.15);
    let turn = most_turned(0.5 / 511.0 / 2f64.sqrt());
    let rounding =
        Rounding { position: half(1.0 / 4096.0), deviation: half(1.0 / 16.0), color, opacity: half(1.0 / 255.0), turn };
    let (four, notes) = read(&seeds("spz/ok-version-4.spz"));
    assert_eq!((four.len(), notes.len()), (COUNT, 0));
    check(&four, &rounding);
    assert_eq!(read(&seeds("spz/ok-closed-3.spz")).0, four);
    check(&read(&seeds("spz/ok-version-4-harmonics.spz")).0, &rounding);
}

/// The format's own writer wraps positions beyond its range around. Those that are at its end by chance are told.
#[test]
fn spz_tells_positions_at_its_end() {
    let (splats, notes) = read(&seeds("spz/ok-far.spz"));
    for (splat, x) in splats.iter().zip([0.0, 2047.9, -2048.0, -2048.0, -2047.5, -1096.0, -2048.0, 2047.5, -904.0]) {
        near("position", splat.position[0], x, half(1.0 / 4096.0 + 5e-4));
    }
    assert!(notes[0].ends_with("3 of 12 splats are at 2048 or -2048, where positions end"), "{notes:?}");
}

/// The writer cuts fractions off. Positions have 16 bits of ln(1 + |x|) between bounds; scales and colors are the nearest of 256 numbers, and so
/// at most half as far off as the closed form's 64 and 41 are from each other; opacities have 8 bits, and rotations 8 bits from −1/√2 to 1/√2
/// in three components.
#[test]
fn sog_has_the_closed_form() {
    let (splats, notes) = read(&seeds("sog/ok-closed.sog"));
    assert_eq!((splats.len(), notes.len()), (COUNT, 0));
    let turn = most_turned(2f64.sqrt() / 255.0);
    // Coordinates are below 82, where a step of the logarithm is 83 times as large.
    let position = [83.0 * 2.0 * 83f64.ln() / 65535.0; 2];
    let opacity = [1.0 / 255.0 + FLOAT, FLOAT];
    let (deviation, color) = (half(10f64.ln() * 5.0 / 63.0), half(1.0 / 40.0));
    check(&sorted(&splats), &Rounding { position, deviation, color, opacity, turn });
}

/// A folder of version 1: 8 bits between the closed form's bounds, but for the logistic function of opacities.
#[test]
fn the_first_sog_has_the_closed_form() {
    let (splats, notes) = read(&here("sog_1/meta.json"));
    assert_eq!((splats.len(), notes.len()), (COUNT, 0));
    let deviation = half(10f64.ln() * 5.0 / 255.0);
    let (color, turn) = (half(1.0 / 255.0), most_turned(0.5 * 2f64.sqrt() / 255.0));
    check(&splats, &Rounding { position: half(0.02), deviation, color, opacity: half(0.012), turn });
}

/// Level 0 has floats, levels 1 and 2 halves that are cut off and positions of 16 bits per 40, the size of a block. The maker's reader of
/// PLY cuts colors and opacities off to 8 bits.
#[test]
fn ksplat_has_the_closed_form() {
    for (name, position, share) in [
        ("ok-level-0", 0.0, 0.0),
        ("ok-level-1", 40.0 / 65534.0, 1.0 / 1024.0),
        ("ok-level-2", 40.0 / 65534.0, 1.0 / 1024.0),
        ("ok-harmonics", 40.0 / 65534.0, 1.0 / 1024.0),
    ] {
        let (splats, notes) = read(&seeds(&format!("ksplat/{name}.ksplat")));
        assert_eq!((splats.len(), notes.len()), (if name == "ok-harmonics" { 40 } else { COUNT }, 0));
        let byte = [1.0 / 255.0 + FLOAT, FLOAT];
        let deviation = [share + FLOAT, FLOAT];
        check(
            &sorted(&splats),
            &Rounding { position: half(position), deviation, color: byte, opacity: byte, turn: 2.0 * share },
        );
    }
}

/// What is missing or lies elsewhere is named.
#[test]
fn a_folder_without_its_images_is_refused() {
    let folder = TempDir::new().expect("a folder");
    let meta = std::fs::read_to_string(here("sog_1/meta.json")).expect("there");
    let path = folder.path().join("meta.json");
    let refused = |meta: String, words: &str| {
        std::fs::write(&path, meta).expect("written");
        message(load(&path).map(|_| ()), "meta.json", words);
    };
    refused(meta.clone(), "means_l.webp: ");
    refused(meta.replace("means_l.webp", "../means_l.webp"), "which is not beside it");
    refused(meta.replacen('{', "{\"version\":3,", 1), "version 3, which is not read");
    refused("{}".into(), "missing field");
}

/// splat-transform's glTF: three splats by the formulas of gltf_compressed/make.mjs, which it turns by half about z.
#[test]
fn gltf_has_splats() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/host/scene/gltf_compressed/splats.glb");
    let (splats, notes) = read(&path);
    assert_eq!((splats.len(), notes.len()), (3, 0), "{notes:?}");
    for (i, splat) in splats.iter().enumerate() {
        let n = i as f64;
        let length = (0.75 + (n - 0.5).powi(2)).sqrt();
        let rotation = [-0.5, 0.5, 0.5, 0.5 - n].map(|x| x / length);
        let color = [0.1, 0.2, 0.3].map(|of| 0.5 + 0.282_094_79 * of * n);
        let deviations = [-1.0 - n, -2.0 - n, -3.0 - n].map(f64::exp);
        let opacity = 1.0 / (1.0 + (1.0 - n).exp());
        let expected = Expected { position: [-n, -10.0 - n, 100.0 + n], deviations, rotation, opacity, color };
        for axis in 0..3 {
            near("position", splat.position[axis], expected.position[axis], half(1e-5));
            near("deviation", splat.deviations[axis], expected.deviations[axis], half(1e-6));
            near("color", splat.color[axis], expected.color[axis], half(1e-5));
        }
        near("opacity", splat.opacity, expected.opacity, half(1e-5));
        turned(splat, &expected, 1e-5);
    }
    // In a scene file they are a mesh file's, placed as that is.
    let text = format!("[[meshes]]\nfile = {path:?}\nscale = 2.0\ntranslate = [1, 0, 0]\n{LIGHT}{CAMERA}");
    let placed = scene_file(&text).expect("a scene").splats;
    for (placed, splat) in placed.iter().zip(&splats) {
        let [x, y, z] = splat.position;
        assert_eq!(placed.position, [2.0 * x + 1.0, 2.0 * y, 2.0 * z]);
        assert_eq!(placed.deviations, splat.deviations.map(|d| 2.0 * d));
    }
}

/// Instances of a node repeat its splats.
#[test]
fn splats_are_repeated_by_instances() {
    let mut file = gltf_shapes::File::new();
    let places = file.floats("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 20.0, 0.0]);
    let turns = file.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0]; 3].concat());
    let sizes = file.floats("VEC3", &[0.5; 9]);
    let opacities = file.floats("SCALAR", &[0.25, 0.5, 0.75]);
    let part = file.primitive();
    *part = serde_json::json!({
        "mode": 0,
        "attributes": {
            "POSITION": 0, "COLOR_0": sizes, "KHR_gaussian_splatting:ROTATION": turns,
            "KHR_gaussian_splatting:SCALE": sizes, "KHR_gaussian_splatting:OPACITY": opacities,
        },
        "extensions": {"KHR_gaussian_splatting": {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}},
    });
    file.root["nodes"][0]["extensions"] =
        serde_json::json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    let splats = file.load().expect("a scene").scene.splats;
    let found: Vec<_> = splats.iter().map(|splat| (splat.position, splat.opacity)).collect();
    let corners = [([0.0, 0.0, 0.0], 0.25), ([1.0, 0.0, 0.0], 0.5), ([0.0, 1.0, 0.0], 0.75)];
    let expected: Vec<_> = [[0.0, 0.0], [10.0, 0.0], [0.0, 20.0]]
        .into_iter()
        .flat_map(|[x, y]| corners.map(|([a, b, c], opacity)| ([a + x, b + y, c], opacity)))
        .collect();
    assert_eq!(found, expected);
}
