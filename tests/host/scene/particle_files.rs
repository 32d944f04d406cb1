//! Particle files: valid ones must load, others must be refused.

use crate::scene::*;
use gobo::scene::{MAX_OPTICAL_DEPTH, Particle};

#[test]
fn particles_survive_each_encoding() {
    let rows = [[1.0, -2.5, 3.25, 0.5, 0.75], [0.0, 1e-3, -4e6, 2.0, 0.0]];
    let expected = rows.map(|row| row.map(|value| value as f32)).map(|[x, y, z, radius, extinction]| Particle {
        position: [x, y, z],
        radius,
        extinction,
    });
    for order in [Order::Little, Order::Big] {
        for number in ["float", "double"] {
            assert_eq!(particles(&binary_ply(order, number, &FIELDS, &rows)).expect("binary"), expected);
        }
    }
    assert_eq!(particles(&ascii_ply(&FIELDS, &rows)).expect("ASCII"), expected);
    assert!(particles(&ascii_ply(&FIELDS, &[])).expect("an empty file is an empty list").is_empty());
}

#[test]
fn rows_of_other_elements_are_passed_over() {
    let text = "ply\nformat ascii 1.0\nelement other 2\nproperty list uchar float values\nelement vertex 1\n\
        property uchar red\nproperty float x\nproperty float y\nproperty float z\nproperty double radius\n\
        property double extinction\nend_header\n2 1 2\n0\n\n255 1 2 3 4 5";
    let expected = Particle { position: [1.0, 2.0, 3.0], radius: 4.0, extinction: 5.0 };
    assert_eq!(particles(text.as_bytes()).expect("odd but right"), [expected]);
}

#[test]
fn opacity_becomes_extinction() {
    let fields = ["x", "y", "z", "radius", "opacity"];
    let opacities = [0.0, 1e-9, 0.05, 0.5, 0.999, 1.0];
    let rows = opacities.map(|opacity| [0.0, 0.0, 0.0, 0.25, opacity]);
    let loaded = particles(&binary_ply(Order::Little, "double", &fields, &rows)).expect("opacity");
    for (opacity, particle) in opacities.iter().zip(&loaded) {
        // (1−o) = exp(−σ·2r)
        let optical_depth = f64::from(particle.extinction) * 2.0 * 0.25;
        if *opacity < 1.0 {
            let error = (-(-optical_depth).exp_m1() - opacity).abs();
            assert!(error <= 1e-6 * opacity, "opacity {opacity} came back {error} off");
        } else {
            assert_eq!(optical_depth as f32, MAX_OPTICAL_DEPTH);
        }
    }
    for opacity in [-0.01, 1.01, f64::NAN] {
        let bytes = binary_ply(Order::Big, "double", &fields, &[[0.0, 0.0, 0.0, 1.0, opacity]]);
        message(particles(&bytes), "smoke.ply", "particle 0 (the first is 0): opacity");
    }
}

#[test]
fn broken_particles_are_refused_by_number() {
    let good = [0.0, 0.0, 0.0, 1.0, 1.0];
    for (column, value, word) in [
        (0, f64::NAN, "position"),
        (1, f64::INFINITY, "position"),
        (2, 1e300, "position"),
        (2, -2e18, "position"),
        (3, 0.0, "radius"),
        (3, -1.0, "radius"),
        (3, f64::NAN, "radius"),
        (3, 1e-60, "radius"),
        (3, 2e18, "radius"),
        (4, -0.5, "extinction"),
        (4, f64::INFINITY, "extinction"),
        (4, f64::NAN, "extinction"),
    ] {
        let mut bad = good;
        bad[column] = value;
        let bytes = binary_ply(Order::Little, "double", &FIELDS, &[good, good, bad, good]);
        message(particles(&bytes), "smoke.ply", &format!("particle 2 (the first is 0): {word}"));
    }
    message(particles(&ascii_ply(&FIELDS, &[good, [f64::NAN; 5]])), "smoke.ply", "cannot read vertex 1");
}

#[test]
fn broken_particle_files_are_refused() {
    let row = [0.0, 0.0, 0.0, 1.0, 1.0];
    for missing in 0..4 {
        let mut fields = FIELDS;
        fields[missing] = "other";
        let words = format!("lacks the property {}", FIELDS[missing]);
        message(particles(&ascii_ply(&fields, &[row])), "smoke.ply", &words);
    }
    let fields = ["x", "y", "z", "radius", "other"];
    let text = message(particles(&ascii_ply(&fields, &[row])), "smoke.ply", "extinction");
    assert!(text.contains("opacity"), "{text}");

    let whole = binary_ply(Order::Little, "float", &FIELDS, &[row; 10]);
    message(particles(&whole[..whole.len() - 1]), "smoke.ply", "truncated");
    let whole = ascii_ply(&FIELDS, &[row; 10]);
    message(particles(&whole[..whole.len() - 7]), "smoke.ply", "truncated");
    let whole = ascii_ply(&FIELDS, &[[0.25, 0.25, 0.25, 1.0, 1.0]; 10]);
    message(particles(&whole[..whole.len() - 7]), "smoke.ply", "vertex 9");
    for garbage in [&b""[..], b"\0\0\0", b"ply", b"ply\n", b"ply\nformat ascii 1.0\nend_header\n", b"\xff\xfe\n"] {
        message(particles(garbage), "smoke.ply", "smoke.ply");
    }
}

#[test]
fn hostile_counts_are_refused_before_anything_is_allocated() {
    let row = [0.0, 0.0, 0.0, 1.0, 1.0];
    let big = u64::MAX.to_string();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["4000000000", &big, "99999999999999999999999"] {
            let mut bytes =
                header(format, "float", &FIELDS, 1).replace("vertex 1", &format!("vertex {count}")).into_bytes();
            bytes.extend(binary_ply(Order::Little, "float", &FIELDS, &[row]));
            message(particles(&bytes), "smoke.ply", "smoke.ply");
            // Rows without bytes would never end.
            let text = header(format, "float", &FIELDS, 0);
            let text = text.replace("element vertex", &format!("element nothing {count}\nelement vertex"));
            message(particles(text.as_bytes()), "smoke.ply", "smoke.ply");
        }
    }
    let mut list =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uint double x\nproperty float y\n\
        property float z\nend_header\n"
            .to_vec();
    list.extend([0xff; 64]);
    message(particles(&list), "smoke.ply", "property x");
    let mut face = TRIANGLE_PLY.split_once("4 0 1").expect("faces").0.replace("ascii", "binary_little_endian");
    face = face.replace("uchar int", "uint int").replace("vertex 5", "vertex 0").replace("face 2", "face 1");
    let mut face = face.split_once("end_header\n").expect("a header").0.as_bytes().to_vec();
    face.extend(b"end_header\n\xff\xff\xff\xff\0\0\0\0");
    message(meshes("tri.ply", &face), "tri.ply", "face 0");
}
