//! `gobo voxels` with a single cuboid, whose voxels and shadow have closed forms.

use super::rgb8;
use crate::support::log;
use crate::{folder, ok, runs, text};
use glam::{DVec2, DVec3};
use gobo::scene::{Scene, View};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const SIZE: [u32; 2] = [720, 480];
/// Corners of the cuboid.
const LOW: DVec3 = DVec3::new(-0.913, -0.527, 0.311);
const HIGH: DVec3 = DVec3::new(0.741, 0.633, 1.127);
/// Height of a plate in the cuboid's shadow, so that the shadow's volume continues below the cuboid.
const PLATE: f64 = -1.03;

/// Writes the scene, seen from `camera` and lit along `light`, with or without the plate.
fn write(folder: &Path, camera: [f64; 3], light: [f64; 3], plate: bool) -> PathBuf {
    let head = |vertices: usize, faces: usize| {
        let properties = ["x", "y", "z"].map(|p| format!("property float {p}\n")).concat();
        format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\n{properties}element face {faces}\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { HIGH[axis] } else { LOW[axis] });
    let row = |p: [f64; 3]| format!("{} {} {}\n", p[0], p[1], p[2]);
    let corners: String = (0..8).map(|i| row(corner(i))).collect();
    let faces = "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n";
    std::fs::write(folder.join("cuboid.ply"), head(8, 6) + &corners + faces).expect("written");
    let square: String = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]].map(|[x, y]| row([x, y, PLATE])).concat();
    std::fs::write(folder.join("plate.ply"), head(4, 1) + &square + "4 0 1 2 3\n").expect("written");
    let more = if plate { "[[meshes]]\nfile = \"plate.ply\"\n" } else { "" };
    let scene = format!(
        "[[meshes]]\nfile = \"cuboid.ply\"\n{more}[light]\nkind = \"directional\"\ndirection = {light:?}\n[camera]\n\
         position = {camera:?}\ntarget = [0.0, 0.0, 0.2]\nup = [0.0, 0.0, 1.0]\nfov_y_degrees = 40.0\n"
    );
    let path = folder.join("cuboid.toml");
    std::fs::write(&path, scene).expect("written");
    path
}

/// Returns where a ray enters a box: the axis of the side that it enters through, and the distance.
fn enters(origin: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> Option<(usize, f64)> {
    let (a, b) = ((low - origin) / direction, (high - origin) / direction);
    let (near, far) = (a.min(b), a.max(b));
    let axis = (0..3).max_by(|i, j| near[*i].total_cmp(&near[*j])).expect("three");
    (near[axis] <= far.min_element() && near[axis] > 0.0).then_some((axis, near[axis]))
}

/// Returns the result that all rays around a pixel's centre agree on.
fn agreed<T: PartialEq>(camera: &View, i: usize, of: impl Fn(DVec3, DVec3) -> T) -> Option<T> {
    let at = DVec2::new((i as u32 % SIZE[0]).into(), (i as u32 / SIZE[0]).into()) + 0.5;
    let [middle, others @ ..] = [[0.0, 0.0], [-0.6, -0.6], [0.6, -0.6], [-0.6, 0.6], [0.6, 0.6]].map(|offset| {
        let ray = camera.ray(at + DVec2::from(offset));
        of(ray.origin, ray.direction)
    });
    others.iter().all(|other| *other == middle).then_some(middle)
}

/// Returns the camera, and the picture that `gobo voxels --plain` makes of `scene`.
fn painted(scene: &Path, out: &Path, more: &[&str]) -> (View, Vec<[u8; 3]>) {
    let picture = SIZE.map(|side| side.to_string()).join("x");
    let common = ["--plain", "--technique", "none", "--picture", &picture, "--out", text(out)];
    ok(&[&["voxels", text(scene), "--size", "64"][..], &common, more].concat());
    let loaded = Scene::load(text(scene), 20.0).expect("written");
    let (size, pixels) = rgb8(out);
    assert_eq!(size, SIZE);
    (View::camera(&loaded.camera, &loaded, SIZE), pixels)
}

/// The voxels along the cuboid's sides must look like one box from outside, divided at voxel borders like a chessboard.
#[test]
fn voxels_are_those_that_the_cuboid_meets() {
    log("exercised", "voxels_are_those_that_the_cuboid_meets", &runs("beer-shadow-map", "binned").0);
    let folder = folder();
    let scene = write(folder.path(), [2.9, -3.4, 2.6], [-0.3, 0.5, -0.8], false);
    let (camera, pixels) = painted(&scene, &folder.path().join("voxels.png"), &[]);
    // Along its longest axis, x, the cuboid spans 62 of 64 voxels, centred.
    let voxel = (HIGH - LOW).max_element() / 62.0;
    let origin = 0.5 * (LOW + HIGH) - 32.0 * voxel;
    let (first, last) = (((LOW - origin) / voxel).floor(), ((HIGH - origin) / voxel).floor());
    // The sides across x lie on voxel borders: rounding decides whether the voxels beyond are hit.
    let boxes = [[0.0, 64.0], [1.0, 64.0], [0.0, 63.0], [1.0, 63.0]].map(|[low, high]| {
        let (low, high) = (DVec3::new(low, first.y, first.z), DVec3::new(high, last.y + 1.0, last.z + 1.0));
        (origin + low * voxel, origin + high * voxel)
    });
    // Returns the side and the voxel that a ray hits.
    let meets = |origin_of: DVec3, direction: DVec3| {
        boxes.map(|(low, high)| {
            let (axis, at) = enters(origin_of, direction, low, high)?;
            let mut voxel = ((origin_of + at * direction - origin) / voxel).floor();
            let outer = if direction[axis] < 0.0 { last[axis] } else { first[axis] };
            voxel[axis] = outer;
            Some((axis, voxel.as_i64vec3()))
        })
    };
    let (sky, mut colors, mut compared) = (pixels[0], BTreeMap::<_, BTreeMap<[u8; 3], usize>>::new(), [0; 2]);
    for (i, pixel) in pixels.iter().enumerate() {
        let Some(met) = agreed(&camera, i, meets) else { continue };
        if met.iter().any(|other| *other != met[0]) {
            continue;
        }
        assert_eq!(met[0].is_none(), *pixel == sky, "pixel {i}: {pixel:?}, and a ray meets {:?}", met[0]);
        compared[usize::from(met[0].is_some())] += 1;
        if let Some((axis, voxel)) = met[0] {
            *colors.entry((axis, voxel.element_sum() % 2)).or_default().entry(*pixel).or_default() += 1;
        }
    }
    println!("{compared:?} pixels of sky and of voxels, {colors:?}");
    assert!(compared[0] > 1000 && compared[1] > 3000, "{compared:?}");
    // Each side must have two colors, one per parity, uniform over the side.
    for axis in [1, 2] {
        let [even, odd] = [0, 1].map(|parity| &colors[&(axis, parity)]);
        assert!(even.len() == 1 && odd.len() == 1, "{axis}: {even:?}, {odd:?}");
        let [even, odd] = [even, odd].map(|of| *of.first_key_value().expect("one").0);
        assert!(even[0] > odd[0] + 5, "{axis}: {even:?} and {odd:?}: the even ones are lighter");
    }
}

/// The space below the cuboid and above a plate in its shadow is dark: nodes must fill that volume, in more than one size, and nothing
/// beside it.
#[test]
fn nodes_fill_the_shadow() {
    log("exercised", "nodes_fill_the_shadow", &runs("beer-shadow-map", "binned").0);
    let folder = folder();
    let scene = write(folder.path(), [3.1, -4.2, 0.3], [0.0, 0.0, -1.0], true);
    let (camera, pixels) = painted(&scene, &folder.path().join("tree.png"), &["--tree"]);
    // The upper bound of a voxel's size: twice the longest side of the scene, divided by the number of voxels.
    let voxel = 2.0 * (HIGH - DVec3::new(LOW.x, LOW.y, PLATE)).max_element() / 64.0;
    let shadow = (DVec3::new(LOW.x, LOW.y, PLATE), DVec3::new(HIGH.x, HIGH.y, LOW.z));
    let all = (shadow.0 - voxel, HIGH + voxel);
    let inside = (shadow.0 + voxel, shadow.1 - voxel);
    let (sky, mut compared, mut colors) = (pixels[0], [0; 2], BTreeSet::new());
    // Meshes are grey.
    let is_node =
        |pixel: &[u8; 3]| *pixel != sky && pixel.iter().max().expect("three") - pixel.iter().min().expect("three") > 20;
    for (i, pixel) in pixels.iter().enumerate() {
        // It is dark below the plate too, so the tree's volume may continue there.
        let meets = |origin: DVec3, direction: DVec3| {
            let meets = |(low, high): (DVec3, DVec3)| enters(origin, direction, low, high).map(|(_, at)| at);
            let endless = (all.0 - DVec3::Z * 3.0, all.1);
            let cuboid = meets((LOW - voxel, HIGH + voxel));
            (meets(endless).is_some(), meets(inside).is_some() && cuboid.is_none())
        };
        match agreed(&camera, i, meets) {
            Some((false, _)) => {
                assert_eq!(*pixel, sky, "pixel {i}: beside all that is dark");
                compared[0] += 1;
            }
            Some((_, true)) => {
                assert!(is_node(pixel), "pixel {i}: {pixel:?}, in the middle of a shadow");
                colors.insert(*pixel);
                compared[1] += 1;
            }
            _ => {}
        }
    }
    println!("{compared:?} pixels beside and in the shadow, in {} colors", colors.len());
    assert!(compared[0] > 1000 && compared[1] > 300 && colors.len() > 1, "{compared:?}, {colors:?}");
}
