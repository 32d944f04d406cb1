//! Splat files: valid ones must load, others must be refused. The files are written here number by number, as their formats specify.

use crate::scene::*;
use flate2::{Compression, write::GzEncoder};
use glam::{DQuat, DVec3};
use gobo::animate::AnimatedScene;
use gobo::scene::{Caster, Splat};
use std::f64::consts::LN_2;
use std::io::Write;

const OPEN: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2",
    "rot_3",
];

/// A splat at (1, 2, 3), 0.5, 0.25 and 0.125 wide, with opacity 3/4, a quarter turn about x, dark red.
const ROW: [f64; 14] = [
    1.0,
    2.0,
    3.0,
    1.772_453_85,
    0.0,
    -1.772_453_85,
    1.098_612_289,
    -LN_2,
    -2.0 * LN_2,
    -3.0 * LN_2,
    3.0,
    3.0,
    0.0,
    0.0,
];

fn splats(name: &str, bytes: &[u8]) -> gobo::Result<Vec<Splat>> {
    Ok(load_caster("splats", name, bytes, "")?.splats)
}

/// Asserts that it is the splat of [`ROW`], up to `rounding`.
#[track_caller]
fn is_it(found: &Splat, rounding: f32) {
    let near = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= rounding);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!(near(&found.position, &[1.0, 2.0, 3.0]), "{found:?}");
    assert!(near(&found.deviations, &[0.5, 0.25, 0.125]), "{found:?}");
    assert!(near(&found.rotation, &[half, 0.0, 0.0, half]), "{found:?}");
    assert!(near(&found.color, &[1.0, 0.5, 0.0]) && (found.opacity - 0.75).abs() <= rounding, "{found:?}");
}

pub(super) fn splat(position: [f32; 3], deviations: [f32; 3], color: [u8; 4], turn: [u8; 4]) -> Vec<u8> {
    let floats = position.into_iter().chain(deviations).flat_map(f32::to_le_bytes);
    floats.chain(color).chain(turn).collect()
}

fn spz(version: u32, count: u32, arrays: &[u8]) -> Vec<u8> {
    let mut bytes: Vec<u8> = [0x5053_474e, version, count].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend([0, 12, 0, 0]);
    bytes.extend(arrays);
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&bytes).expect("into memory");
    gzip.finish().expect("into memory")
}

/// Returns the arrays of one splat with this rotation: positions in 4096ths, logarithms of scales in 16ths from −10.
fn arrays(turn: &[u8]) -> Vec<u8> {
    let places = [1i32, 2, 3].into_iter().flat_map(|x| (x << 12).to_le_bytes().into_iter().take(3));
    let scales = [149, 138, 127];
    places.chain([191]).chain([255, 128, 0]).chain(scales).chain(turn.iter().copied()).collect()
}

#[test]
fn every_format_holds_the_same_splat() {
    for order in [Order::Little, Order::Big] {
        is_it(&splats("a.ply", &binary_ply(order, "float", &OPEN, &[ROW])).expect("binary")[0], 1e-6);
    }
    is_it(&splats("a.ply", &ascii_ply(&OPEN, &[ROW, ROW])).expect("ASCII")[1], 1e-6);

    let row = splat([1.0, 2.0, 3.0], [0.5, 0.25, 0.125], [255, 128, 0, 191], [219, 219, 128, 128]);
    is_it(&splats("a.splat", &row.repeat(3)).expect("three")[2], 4e-3);

    // 127.5 · (1 + 1/√2) = 217.7; w follows from x, y and z.
    is_it(&splats("a.spz", &spz(2, 1, &arrays(&[218, 128, 128]))).expect("version 2")[0], 1e-2);
    // The largest component is w, number 3; x is 511 of 511, y and z are 0.
    let turn = (3u32 << 30 | 511 << 20).to_le_bytes();
    is_it(&splats("a.spz", &spz(3, 1, &arrays(&turn))).expect("version 3")[0], 1e-2);
    // x again, but negative, so the whole quaternion is negated: w is −1/√2, which is the same rotation.
    let turn = (3u32 << 30 | 1023 << 20).to_le_bytes();
    let other = splats("a.spz", &spz(3, 1, &arrays(&turn))).expect("version 3")[0];
    assert!(other.rotation[0] < -0.7 && other.rotation[3] > 0.7, "{other:?}");
}

/// 257 splats in two chunks, with bounds from 0 to 1, 2, 3, …; all values of the last one are at their maximum.
#[test]
fn compressed_splats_stand_between_the_bounds_of_their_chunk() {
    let bounds =
        ["min", "max"].map(|end| ["x", "y", "z"].map(|axis| format!("property float {end}_{axis}\n")).concat());
    let scales =
        ["min", "max"].map(|end| ["x", "y", "z"].map(|axis| format!("property float {end}_scale_{axis}\n")).concat());
    let words =
        ["position", "rotation", "scale", "color"].map(|word| format!("property uint packed_{word}\n")).concat();
    let file = |chunks: usize, splats: usize| {
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement chunk {chunks}\n{}{}{}{}element vertex {splats}\n{words}end_header\n",
            bounds[0], bounds[1], scales[0], scales[1]
        );
        for chunk in 0..chunks {
            let high = chunk as f32 + 1.0;
            text += &format!("0 0 0 {high} {} {} -2 -2 -2 -1 -1 -1\n", 2.0 * high, 3.0 * high);
        }
        for splat in 0..splats {
            // The largest of w, x, y, z is the first; a code of 512 out of 1023 is 0 for the other three, up to rounding.
            let turn = 512u32 << 20 | 512 << 10 | 512;
            text += &if splat == 256 {
                format!("{} {turn} {} {}\n", u32::MAX, u32::MAX, 0xFF80_00C0u32)
            } else {
                format!("{} {turn} 0 {}\n", 1023u32 << 11, 0x8080_8080u32)
            };
        }
        text.into_bytes()
    };
    let found = splats("a.ply", &file(2, 257)).expect("two chunks");
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(
        close(found[0].position, [0.0, 2.0, 0.0]) && close(found[0].deviations, [(-2f32).exp(); 3]),
        "{:?}",
        found[0]
    );
    assert!(close(found[256].position, [2.0, 4.0, 6.0]), "{:?}", found[256]);
    assert!(close(found[256].deviations, [(-1f32).exp(); 3]) && close(found[256].color, [1.0, 128.0 / 255.0, 0.0]));
    assert!((found[256].opacity - 192.0 / 255.0).abs() < 1e-6 && found[256].rotation[3] > 0.999, "{:?}", found[256]);
    message(splats("a.ply", &file(1, 257)), "a.ply", "fewer than one for each 256");
}

/// Loads a file by itself, and returns its splats and notes without the file's name.
fn noted(name: &str, bytes: &[u8]) -> (Vec<Splat>, Vec<String>) {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    let loaded = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("splats");
    let notes = loaded.notes.iter().filter(|note| !note.contains("taken for up"));
    let notes = notes.map(|note| note.split_once(": ").expect("a name").1.to_owned()).collect();
    (loaded.scene.splats.clone(), notes)
}

/// One bad row never costs a file: it is left out, and a note counts it and names the first.
#[test]
fn broken_splats_are_left_out() {
    for (column, value, word) in [
        (0, f64::NAN, "position"),
        (1, 1e30, "position"),
        (6, f64::NAN, "opacity"),
        (7, f64::NAN, "deviations"),
        (8, 200.0, "deviations"),
        (9, -200.0, "deviations"),
        (3, f64::INFINITY, "color"),
        (10, f64::NAN, "quaternion"),
    ] {
        let mut row = ROW;
        row[column] = value;
        let (found, notes) = noted("a.ply", &binary_ply(Order::Little, "double", &OPEN, &[ROW, row, row, ROW]));
        found.iter().for_each(|splat| is_it(splat, 1e-6));
        let start = "2 of 4 splats are left out; splat 1 (the first is 0): ";
        assert!(found.len() == 2 && notes.len() == 1 && notes[0].starts_with(start), "{notes:?}");
        assert!(notes[0].contains(word), "{notes:?}");
        let said = message(splats("a.ply", &binary_ply(Order::Little, "double", &OPEN, &[row])), "a.ply", "splat 0");
        assert!(said.contains(word), "{said}");
    }
}

/// A splat without a thickness casts what a thin one of its opacity casts.
#[test]
fn flat_splats_have_a_thickness() {
    let mut row = ROW;
    row[9] = f64::NEG_INFINITY;
    let mut without = OPEN;
    without[9] = "other";
    for bytes in [
        binary_ply(Order::Little, "double", &OPEN, &[row, ROW]),
        binary_ply(Order::Little, "float", &without, &[ROW, ROW]),
        splat([1.0, 2.0, 3.0], [0.5, 0.25, 0.0], [255, 128, 0, 191], [219, 219, 128, 128]),
    ] {
        let name = if bytes.starts_with(b"ply") { "a.ply" } else { "a.splat" };
        let (found, notes) = noted(name, &bytes);
        assert!((found[0].deviations[2] - 0.0005).abs() < 1e-9 && found[0].deviations[1] == 0.25, "{found:?}");
        let depth = |g: &Splat| Caster::from(g).density * g.deviations[2];
        let thick = Splat { deviations: [0.5, 0.25, 0.125], ..found[0] };
        assert!((depth(&found[0]) / depth(&thick) - 1.0).abs() < 1e-3);
        assert!(notes[0].contains("as thick as"), "{notes:?}");
    }
    // A splat without any size is none.
    message(splats("a.splat", &splat([1.0; 3], [0.0; 3], [255; 4], [255; 4])), "a.splat", "deviations");
}

/// Colors may be bytes; a splat without any is grey.
#[test]
fn colors_may_be_bytes() {
    let mut fields = OPEN;
    (fields[3], fields[4], fields[5]) = ("red", "green", "blue");
    let mut row = ROW;
    row[3..6].copy_from_slice(&[255.0, 51.0, 0.0]);
    let (found, notes) = noted("a.ply", &binary_ply(Order::Little, "float", &fields, &[row]));
    assert_eq!((found[0].color, notes.len()), ([1.0, 0.2, 0.0], 0));
    (fields[3], fields[4], fields[5]) = ("a", "b", "c");
    assert_eq!(noted("a.ply", &binary_ply(Order::Little, "float", &fields, &[row])).0[0].color, [0.5; 3]);
}

/// A filter widens a splat, which absorbs as much in all as before.
#[test]
fn filters_are_folded_in() {
    let fields: [&str; 15] = std::array::from_fn(|i| if i < 14 { OPEN[i] } else { "filter_3D" });
    let row: [f64; 15] = std::array::from_fn(|i| if i < 14 { ROW[i] } else { 0.3 });
    let (found, notes) = noted("a.ply", &binary_ply(Order::Little, "float", &fields, &[row]));
    let widened = [0.5_f64, 0.25, 0.125].map(|deviation| deviation.hypot(0.3));
    let opacity = 0.75 * (0.5 * 0.25 * 0.125) / widened.iter().product::<f64>();
    for (found, expected) in found[0].deviations.iter().zip(widened) {
        assert!((f64::from(*found) - expected).abs() < 1e-6);
    }
    assert!((f64::from(found[0].opacity) - opacity).abs() < 1e-6, "{} for {opacity}", found[0].opacity);
    assert_eq!(notes, ["each splat is widened by its filter_3D"]);
}

/// Marks of an antialiased rasterizer are told, and so are sizes that can hardly be meant.
#[test]
fn what_is_unusual_is_told() {
    let text = String::from_utf8(ascii_ply(&OPEN, &[ROW])).expect("ASCII");
    let marked = text.replacen("comment test", "comment SplatRenderMode: mip", 1);
    assert_ne!(marked, text);
    let told = "its splats are of an antialiased rasterizer";
    assert_eq!(noted("a.ply", marked.as_bytes()).1, [told]);
    let mut bytes: Vec<u8> = [0x5053_474e, 3, 1_u32].into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend([0, 12, 1, 0]);
    bytes[14] = 1;
    bytes.extend(arrays(&(3u32 << 30).to_le_bytes()));
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&bytes).expect("into memory");
    assert_eq!(noted("a.spz", &gzip.finish().expect("into memory")).1, [told]);
    let place = |i: usize| {
        let mut row = ROW;
        row[0] = i as f64 / 20.0;
        row
    };
    let rows: Vec<[f64; 14]> = (0..20).map(place).collect();
    let (found, notes) = noted("a.ply", &binary_ply(Order::Little, "float", &OPEN, &rows));
    assert!(found.len() == 20 && notes[0].starts_with("20 splats are larger than a tenth of the scene"), "{notes:?}");
}

#[test]
fn broken_files_of_splats_are_refused() {
    let mut row = ROW;
    row[10..].fill(0.0);
    message(splats("a.ply", &binary_ply(Order::Little, "float", &OPEN, &[row])), "a.ply", "no quaternion");
    let mut fields = OPEN;
    fields[13] = "turn";
    message(splats("a.ply", &binary_ply(Order::Little, "float", &fields, &[ROW])), "a.ply", "rot_3");
    let bytes = binary_ply(Order::Little, "float", &OPEN, &[ROW, ROW]);
    message(splats("a.ply", &bytes[..bytes.len() - 1]), "a.ply", "truncated");

    let row = splat([1.0; 3], [0.5; 3], [255; 4], [255; 4]);
    message(splats("a.splat", &row[..31]), "a.splat", "truncated");
    message(splats("a.splat", &splat([1.0; 3], [0.5; 3], [255; 4], [128; 4])), "a.splat", "no quaternion");
    message(splats("a.splat", &splat([f32::NAN; 3], [0.5; 3], [255; 4], [255; 4])), "a.splat", "position");
    message(splats("a.splat", &splat([1.0; 3], [0.5, -0.5, 0.5], [255; 4], [255; 4])), "a.splat", "deviations");

    let good = arrays(&[218, 128, 128]);
    message(splats("a.spz", &spz(4, 1, &good)), "a.spz", "version 4");
    message(splats("a.spz", &spz(2, 2, &good)), "a.spz", "truncated: an array has 1 of its 2 bytes");
    message(splats("a.spz", b"PK not gzip"), "a.spz", "no gzip");
    let whole = spz(2, 1, &good);
    message(splats("a.spz", &whole[..whole.len() / 2]), "a.spz", "gzip");
    // All splats are present, but the checksum is missing.
    message(splats("a.spz", &whole[..whole.len() - 5]), "a.spz", "no whole gzip");
    // Version 4 does not compress its header.
    message(splats("a.spz", b"NGSP\x04\0\0\0\x08\0\0\0"), "a.spz", "no whole header is there");
    message(splats("a.gs", &row), "a.gs", "unknown kind of splat file");
}

/// Counts in a header must not be believed. A file that is small because its splats are alike is read.
#[test]
fn no_file_takes_more_than_it_accounts_for() {
    message(
        splats("a.spz", &spz(2, u32::MAX, &arrays(&[218, 128, 128]))),
        "a.spz",
        "truncated: an array has 19 of its 38654705655 bytes",
    );
    let alike: Vec<u8> = [(9, 1), (1, 191), (3, 128), (3, 100), (3, 128)]
        .into_iter()
        .flat_map(|(bytes, value)| std::iter::repeat_n(value, 50_000 * bytes))
        .collect();
    let bytes = spz(2, 50_000, &alike);
    assert!(bytes.len() * 256 < alike.len(), "{} bytes", bytes.len());
    let found = splats("a.spz", &bytes).expect("splats that are alike");
    assert!(found.len() == 50_000 && found.iter().all(|splat| *splat == found[0]));
    let text = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n{}end_header\n",
        OPEN.map(|name| format!("property float {name}\n")).concat()
    );
    message(splats("a.ply", text.as_bytes()), "a.ply", "truncated");
}

/// A file of splats by itself is a scene; placed, its splats must be scaled and equally dark.
#[test]
fn splats_are_placed() {
    let row = splat([1.0, 2.0, 3.0], [0.5, 0.25, 0.125], [255, 128, 0, 191], [219, 219, 128, 128]);
    let scene = load_caster("splats", "a.splat", &row, "scale = 2.0\ntranslate = [0.0, 0.0, 1.0]").expect("placed");
    let placed = scene.splats[0];
    assert_eq!((placed.position, placed.deviations), ([2.0, 4.0, 7.0], [1.0, 0.5, 0.25]));
    let alone = splats("a.splat", &row).expect("as it stands")[0];
    let depth = |g: &Splat| Caster::from(g).density * g.deviations[2];
    assert!((depth(&placed) - depth(&alone)).abs() < 1e-6);

    // A rotated splat must have the same exponent at rotated points: the value at x moves to R x.
    let row = splat([1.0, 2.0, 3.0], [0.5, 0.25, 0.125], [255, 128, 0, 191], [200, 150, 90, 140]);
    let alone = splats("a.splat", &row).expect("as it stands")[0];
    let turned = load_caster("splats", "a.splat", &row, "rotate = [1.0, 2.0, -1.0, 70.0]").expect("turned").splats[0];
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 70_f64.to_radians());
    let exponent = |g: &Splat, x: DVec3| {
        let away = x - DVec3::from_array(g.position.map(f64::from));
        let own = DQuat::from_array(g.rotation.map(f64::from)).conjugate() * away;
        (own / DVec3::from_array(g.deviations.map(f64::from))).length_squared()
    };
    for x in [DVec3::new(1.2, 2.0, 3.1), DVec3::new(0.9, 2.3, 2.8), DVec3::new(1.0, 1.8, 3.2)] {
        let (before, after) = (exponent(&alone, x), exponent(&turned, turn * x));
        assert!((before - after).abs() < 1e-4 * before, "{before} {after}");
    }

    let folder = TempDir::new().expect("a folder");
    for (name, bytes) in [
        ("a.splat", row.clone()),
        ("a.ply", binary_ply(Order::Little, "float", &OPEN, &[ROW])),
        ("a.spz", spz(2, 1, &arrays(&[218, 128, 128]))),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let scene = load(&path).expect(name);
        assert_eq!((scene.splats.len(), scene.casters().len(), scene.lights.len()), (1, 1, 1), "{name}");
    }
}
