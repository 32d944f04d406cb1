//! TressFX files: valid ones must load, others must be refused.

use crate::scene::*;
use crate::support::shared_data;

/// For each version: number, offsets in the header of the points and of the thickness, size of the header, and floats per point.
const VERSIONS: [(f32, usize, usize, usize, usize); 2] = [(3.0, 144, 148, 296, 3), (4.0, 12, 24, 160, 4)];

/// Returns a file whose thicknesses, if any, follow the points.
pub(crate) fn tressfx(version: f32, strands: u32, points: u32, positions: &[f32], thickness: &[f32]) -> Vec<u8> {
    let (_, positions_at, thickness_at, header, floats) = VERSIONS[version as usize - 3];
    let mut bytes = version.to_le_bytes().to_vec();
    bytes.extend([strands, points].iter().flat_map(|n| n.to_le_bytes()));
    bytes.resize(header, 0);
    bytes[positions_at..][..4].copy_from_slice(&(header as u32).to_le_bytes());
    for position in positions.chunks(3) {
        // Version 4 appends the inverse mass.
        bytes.extend(position.iter().chain(&[7.0]).take(floats).flat_map(|n| n.to_le_bytes()));
    }
    if !thickness.is_empty() {
        let end = bytes.len() as u32;
        bytes[thickness_at..][..4].copy_from_slice(&end.to_le_bytes());
        bytes.extend(thickness.iter().flat_map(|n| n.to_le_bytes()));
    }
    bytes
}

/// Two strands of three points, up to 16 units tall; the second begins with a segment of zero length.
const POINTS: [f32; 18] = [
    0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, //
    4.0, 0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 16.0, 0.0,
];

pub(crate) fn samples() -> [Vec<u8>; 4] {
    [(3.0, &[][..]), (3.0, &[0.5, 0.25]), (4.0, &[]), (4.0, &[0.5, 0.25])]
        .map(|(version, thickness)| tressfx(version, 2, 3, &POINTS, thickness))
}

fn load_tfx(bytes: &[u8], keys: &str) -> gobo::Result<Vec<Strand>> {
    Ok(load_caster("hair", "head.TFX", bytes, keys)?.strands)
}

#[test]
fn both_versions_load() {
    let strand = |start, end, radius| Strand { start, radius, end, opacity: 0.5 };
    let expected = |first, second| {
        [
            strand([0.0; 3], [0.0, 1.0, 0.0], first),
            strand([0.0, 1.0, 0.0], [0.0, 2.0, 0.0], first),
            strand([4.0, 0.0, 0.0], [4.0, 16.0, 0.0], second),
        ]
    };
    let [old, old_thick, new, new_thick] = samples();
    for (plain, thick) in [(old, old_thick), (new, new_thick)] {
        // The width of a hair without thickness is 1/400 of the longest side.
        assert_eq!(load_tfx(&plain, "").expect("no thickness"), expected(0.02, 0.02));
        assert_eq!(load_tfx(&thick, "").expect("with thickness"), expected(0.25, 0.125));
        let placed = load_tfx(&thick, "scale = 2.0\ntranslate = [0.0, 0.0, 1.0]").expect("placed");
        assert_eq!(placed[0], strand([0.0, 0.0, 1.0], [0.0, 2.0, 1.0], 0.5));
        let placed = load_tfx(&plain, "scale = 2.0").expect("placed");
        assert_eq!(placed[0].radius, 0.04);
        let over = load_tfx(&thick, "scale = 2.0\nradius = 0.125\nopacity = 1.0").expect("overridden");
        assert_eq!((over[1].radius, over[1].opacity), (0.125, 1.0));
    }
    assert!(load_tfx(&tressfx(4.1, 2, 3, &POINTS, &[]), "").is_ok(), "4.1 has the layout of 4.0");
}

#[test]
fn broken_tressfx_is_refused() {
    if crate::support::is_costly("broken_tressfx_is_refused") {
        return;
    }
    for (sample, header) in samples().iter().zip([296, 296, 160, 160]) {
        for end in 0..sample.len() {
            let words = if end >= header { " from " } else { "truncated" };
            message(load_tfx(&sample[..end], ""), "head.TFX", words);
        }
    }
    for version in [3.0, 4.0] {
        for (strands, points, words) in [
            (0, 3, "0 strands of 3 points"),
            (2, 0, "2 strands of 0 points"),
            (2, 1, "2 strands of 1 points"),
            (3, 3, "truncated"),
            (2, 4, "truncated"),
            (u32::MAX, 3, "truncated"),
            (2, u32::MAX, "truncated"),
            (u32::MAX, u32::MAX, "truncated"),
            (0x8000_0001, 0x8000_0000, "truncated"),
        ] {
            message(load_tfx(&tressfx(version, strands, points, &POINTS, &[]), ""), "head.TFX", words);
        }
    }
    // Invalidates one number at a time.
    let [_, _, _, whole] = samples();
    let (points, thickness) = (160, 160 + 6 * 16);
    for (at, bits, words) in [
        (0, 2.0_f32.to_bits(), "version reads as 2.0"),
        (0, 5.0_f32.to_bits(), "version reads as 5.0"),
        (0, f32::NAN.to_bits(), "version reads as NaN"),
        (12, 0, "points begin inside the header, at byte 0"),
        (12, 159, "points begin inside the header, at byte 159"),
        (12, 200, "96 bytes of points from 200, 264 bytes in all"),
        (12, u32::MAX, "truncated"),
        (24, 8, "thicknesses begin inside the header"),
        (24, u32::MAX, "8 bytes of thicknesses from 4294967295"),
        (points, f32::NAN.to_bits(), "strand 0, point 0 (the first is 0): position [NaN"),
        (points + 5 * 16 + 8, f32::INFINITY.to_bits(), "strand 1, point 2 (the first is 0): position"),
        (thickness + 4, f32::NAN.to_bits(), "strand 1 (the first is 0): thickness NaN"),
        (thickness, (-0.5_f32).to_bits(), "strand 0 (the first is 0): thickness -0.5"),
        (thickness, 0.0_f32.to_bits(), "strand 0 (the first is 0): radius 0"),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&bits.to_le_bytes());
        message(load_tfx(&bytes, ""), "head.TFX", words);
    }
    message(load_tfx(b"numStrands 1000\nnumVerts 16\n", ""), "head.TFX", "no TressFX file of version 3 or 4");
    message(load_tfx(&whole, "scale = 1e60"), "head.TFX", "strand 0 (the first is 0): position");
    let mut long = tressfx(4.0, 1, 2, &[f32::MIN, 0.0, 0.0, f32::MAX, 0.0, 0.0], &[]);
    message(load_tfx(&long, ""), "head.TFX", "exceeds 1e18");
    long = tressfx(4.0, 1, 2, &[1.0; 6], &[]);
    message(load_tfx(&long, ""), "head.TFX", "radius 0");
}

#[test]
fn real_tressfx_loads() {
    let Some(folder) = shared_data("real_tressfx_loads") else { return };
    let path = folder.join("mohawk.tfx");
    let scene = scene_file(&format!("[[hair]]\nfile = {path:?}\n{LIGHT}{CAMERA}")).expect("real hair");
    assert_eq!(scene.strands.len(), 2_228 * 31);
    let ends = || scene.strands.iter().flat_map(|strand| [strand.start, strand.end]);
    let low = [0, 1, 2].map(|axis| ends().map(|end| end[axis]).fold(f32::INFINITY, f32::min));
    let high = [0, 1, 2].map(|axis| ends().map(|end| end[axis]).fold(f32::NEG_INFINITY, f32::max));
    // Bounds measured in the file by another program.
    assert_eq!((low, high), ([-0.095_123_42, 0.214_275_58, -0.335_795_76], [0.117_329_426, 1.109_868_5, 0.270_923_17]));
    assert!(scene.strands.iter().all(|strand| (strand.radius - (1.109_868_5 - 0.214_275_58) / 800.0).abs() < 1e-9));
    // A strand's segments must be connected, which shows that points are read along strands, not across.
    let joints = scene.strands.windows(2).filter(|pair| pair[0].end == pair[1].start).count();
    assert_eq!(joints, 2_228 * 30);
}
