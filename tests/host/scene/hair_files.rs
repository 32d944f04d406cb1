//! HAIR files: valid ones must load, others must be refused.

use crate::scene::*;
use gobo::animate::AnimatedScene;

/// Returns a file as the format's page describes it. `arrays` are the bytes of the arrays that `bits` declare.
pub(crate) fn hair(hairs: u32, points: u32, bits: u32, segments: u32, arrays: &[&[u8]]) -> Vec<u8> {
    let mut bytes = b"HAIR".to_vec();
    bytes.extend([hairs, points, bits, segments].iter().flat_map(|n| n.to_le_bytes()));
    // Thickness, transparency, color.
    bytes.extend(floats(&[0.5, 0.25, 0.1, 0.2, 0.3]));
    bytes.extend([b' '; 88]);
    assert_eq!(bytes.len(), 128);
    bytes.extend(arrays.concat());
    bytes
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn shorts(numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

const ZIGZAG: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 6.0];

/// Returns files with two hairs, of two segments and of one: with defaults, with every array, and with two hairs of one segment each.
pub(crate) fn samples() -> [Vec<u8>; 3] {
    let every = [
        shorts(&[2, 1]),
        floats(&ZIGZAG),
        floats(&[0.2, 0.4, 0.6, 1.0, 0.0]),
        floats(&[0.0, 1.0, 0.5, 0.25, 0.25]),
        floats(&[0.5; 15]),
    ];
    [
        hair(2, 5, 3, 9, &[&every[0], &every[1]]),
        hair(2, 5, 31, 9, &every.each_ref().map(|a| a.as_slice())),
        hair(2, 4, 2, 1, &[&floats(&ZIGZAG[..12])]),
    ]
}

fn strand(start: [f32; 3], end: [f32; 3], radius: f32, opacity: f32) -> Strand {
    Strand { start, radius, end, opacity }
}

#[test]
fn hair_loads_with_defaults_and_with_arrays() {
    let [plain, whole, even] = samples();
    let (a, b, c, d, e) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [5.0; 3], [5.0, 5.0, 6.0]);
    // Thickness is a diameter; opacity is 1 minus transparency.
    let expected = [strand(a, b, 0.25, 0.75), strand(b, c, 0.25, 0.75), strand(d, e, 0.25, 0.75)];
    assert_eq!(strands(&plain, "").expect("defaults"), expected);
    let expected = [strand(a, b, 0.15, 0.5), strand(b, c, 0.25, 0.25), strand(d, e, 0.25, 0.75)];
    assert_eq!(strands(&whole, "").expect("every array"), expected);
    let expected = [strand(a, b, 0.25, 0.75), strand(c, d, 0.25, 0.75)];
    assert_eq!(strands(&even, "").expect("as many segments each"), expected);
    assert!(strands(&hair(0, 0, 2, 0, &[]), "").expect("no hair is no strand").is_empty());
}

#[test]
fn scene_files_place_their_hair() {
    let [plain, _, _] = samples();
    let placed = strands(&plain, "scale = 2.0\ntranslate = [0.0, 0.0, 1.0]").expect("placed");
    assert_eq!(placed[0], strand([0.0, 0.0, 1.0], [2.0, 0.0, 1.0], 0.5, 0.75));
    let over = strands(&plain, "scale = 2.0\nradius = 0.125\nopacity = 1.0").expect("overridden");
    assert_eq!(over[1], strand([2.0, 0.0, 0.0], [2.0, 2.0, 0.0], 0.125, 1.0));
    for (keys, words) in [
        ("radius = 0.0", "hair head.hair: radius 0"),
        ("radius = -1.0", "hair head.hair: radius"),
        ("radius = nan", "hair head.hair: radius"),
        ("radius = 1e-60", "hair head.hair: radius"),
        ("opacity = 1.5", "hair head.hair: opacity 1.5"),
        ("opacity = nan", "hair head.hair: opacity"),
        ("scale = 0.0", "hair head.hair: scale"),
        ("translate = [0.0, nan, 0.0]", "hair head.hair: translate"),
        ("density = 1.0", "unknown field `density`"),
    ] {
        message(strands(&plain, keys), "scene.toml", words);
    }
    message(strands(&plain, "scale = 1e60"), "head.hair", "hair 0 (the first is 0), segment 0: position");
}

/// A segment of zero length covers nothing.
#[test]
fn segments_of_no_length_are_left_out() {
    let mut points = ZIGZAG;
    points.copy_within(0..3, 3);
    let bytes = hair(2, 5, 3, 0, &[&shorts(&[2, 1]), &floats(&points)]);
    let loaded = strands(&bytes, "").expect("two are left");
    assert_eq!(loaded.iter().map(|s| s.end).collect::<Vec<_>>(), [[1.0, 1.0, 0.0], [5.0, 5.0, 6.0]]);
}

#[test]
fn broken_hair_is_refused() {
    let [plain, whole, _] = samples();
    for end in 0..whole.len() {
        message(strands(&whole[..end], ""), "head.hair", if end < 4 { "HAIR" } else { "truncated" });
    }
    for (bytes, words) in [
        (hair(2, 5, 1, 0, &[&shorts(&[2, 1])]), "no points"),
        (hair(2, 5, 3, 0, &[&shorts(&[2, 2]), &floats(&ZIGZAG)]), "2 hairs have 6 points by their segments, 5 by"),
        (hair(2, 5, 3, 0, &[&shorts(&[1, 1]), &floats(&ZIGZAG)]), "2 hairs have 4 points"),
        (hair(2, 5, 2, 2, &[&floats(&ZIGZAG)]), "2 hairs have 6 points"),
        // Counts that would exhaust memory, never end, or overflow.
        (hair(u32::MAX, 5, 3, 0, &[&floats(&ZIGZAG)]), "truncated"),
        (hair(2, u32::MAX, 3, 0, &[&floats(&ZIGZAG)]), "truncated"),
        (hair(u32::MAX, 5, 2, u32::MAX, &[&floats(&ZIGZAG)]), "18446744069414584320 points"),
        (hair(u32::MAX, 0, 2, 0, &[]), "4294967295 points"),
    ] {
        message(strands(&bytes, ""), "head.hair", words);
    }
    // Invalidates one number of the arrays at a time.
    let (points, thickness, transparency) = (128 + 4, 128 + 4 + 60, 128 + 4 + 80);
    for (at, value, words) in [
        (points, f32::NAN, "hair 0 (the first is 0), segment 0: position"),
        (points + 12 * 4, f32::INFINITY, "hair 1 (the first is 0), segment 0: position"),
        (thickness + 16, f32::NAN, "hair 1 (the first is 0), segment 0: thickness NaN"),
        (thickness + 16, -0.25, "segment 0: thickness -0.25 is not from 0"),
        (thickness + 8, f32::INFINITY, "hair 0 (the first is 0), segment 1: thickness inf"),
        (transparency + 16, 1.5, "segment 0: transparency 1.5 is not from 0 to 1"),
        (transparency + 16, -0.1, "segment 0: transparency -0.1"),
        (transparency, f32::NAN, "hair 0 (the first is 0), segment 0: transparency NaN"),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        message(strands(&bytes, ""), "head.hair", words);
    }
    // Overridden numbers must not be checked.
    let mut bytes = whole;
    bytes[thickness..thickness + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(strands(&bytes, "radius = 0.5").expect("overridden")[0].radius, 0.5);
    let mut long = plain;
    long[points..points + 4].copy_from_slice(&f32::MIN.to_le_bytes());
    long[points + 12..points + 16].copy_from_slice(&f32::MAX.to_le_bytes());
    message(strands(&long, ""), "head.hair", "exceeds 1e18");
}

/// Loads a file by itself, and returns its strands and notes without the file's name.
fn noted(bytes: &[u8]) -> (Vec<Strand>, Vec<String>) {
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join("head.hair");
    std::fs::write(&path, bytes).expect("written");
    let loaded = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("hair");
    let notes = loaded.notes.iter().filter(|note| !note.contains("taken for up"));
    let notes = notes.map(|note| note.split_once(": ").expect("a name").1.to_owned()).collect();
    (loaded.scene.strands.clone(), notes)
}

/// Arrays of further bits stand behind those of the format: they are skipped, and a note counts them.
#[test]
fn further_arrays_are_skipped() {
    let (plain, bits) = ([&shorts(&[2, 1])[..], &floats(&ZIGZAG)], 3);
    let expected = noted(&hair(2, 5, bits, 0, &plain));
    for (more, told) in [
        (1 << 5, "1 array beyond the format's five is skipped"),
        (1 << 5 | 1 << 31, "2 arrays beyond the format's five are skipped"),
    ] {
        let (found, notes) = noted(&hair(2, 5, bits | more, 0, &[plain[0], plain[1], &[7; 40]]));
        assert_eq!((found, &notes[0][..]), (expected.0.clone(), told));
    }
}

/// Hair without a width gets one by its extent; a width that hides the head is noted.
#[test]
fn widths_fit_the_head() {
    let file = |thickness: f32| {
        let points: Vec<f32> = ZIGZAG.iter().map(|at| 4.0 * at).collect();
        let mut bytes = hair(2, 5, 3, 0, &[&shorts(&[2, 1]), &floats(&points)]);
        bytes[20..24].copy_from_slice(&thickness.to_le_bytes());
        bytes
    };
    let (found, notes) = noted(&file(0.0));
    assert_eq!(notes, ["no width: hairs are 1/400 of the longest side wide"]);
    assert!(found.iter().all(|strand| (strand.radius - 24.0 / 800.0).abs() < 1e-6), "{found:?}");
    let (found, notes) = noted(&file(1.0));
    assert!(
        found.iter().all(|strand| strand.radius == 0.5)
            && notes[0].starts_with("hairs are up to 1 wide on a longest side of 24")
    );
    assert!(noted(&file(0.25)).1.is_empty());
    // A scene file's radius holds, and then nothing is to be told.
    assert_eq!(strands(&file(0.0), "radius = 0.5").expect("hair")[0].radius, 0.5);
}
