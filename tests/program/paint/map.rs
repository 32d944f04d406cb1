//! `gobo map`: a virtual light's map against rays in f64.

use super::rgb8;
use crate::support::{gpu_test_needing, some};
use crate::{folder, ok, text};
use glam::DVec3;
use gobo::lights::indirect::{VplsBy, lit_by_vpls};
use gobo::reference::truth::Meshes;
use gobo::scene::{LightKind, Mesh, Scene};
use std::f64::consts::PI;

/// Returns the light's axes perpendicular to its normal: Duff et al. 2017.
fn across(normal: DVec3) -> [DVec3; 2] {
    let side = if normal.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    let right = DVec3::new(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x);
    [right, DVec3::new(b, side + normal.y * normal.y * a, -normal.y)]
}

const ORANGE: [u8; 3] = [213, 94, 0];

/// Texels per side of a map.
const SIDE: usize = 64;

/// Number of points per light.
const POINTS: f64 = 8192.0;

/// Pixels per side of a texel.
const SCALE: usize = 2;

/// What a ray finds; nothing behind the light's plane is ever queried.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Behind,
    Nothing,
    At(f64),
}

/// Traces a ray per texel of the paraboloid over the light's half space (Brabec, Annen and Seidel 2002). With `culling`, closed meshes cast
/// from where a ray leaves them.
fn rays(meshes: &Meshes, position: DVec3, normal: DVec3, culling: bool) -> Vec<Seen> {
    let [right, up] = across(normal);
    let of = |i: usize| {
        let [x, y] = [i % SIDE, i / SIDE].map(|t| (t as f64 + 0.5) / (SIDE as f64 / 2.0) - 1.0);
        let square = x * x + y * y;
        if square >= 1.0 {
            return Seen::Behind;
        }
        let way = (2.0 * x * right + 2.0 * y * up + (1.0 - square) * normal) / (1.0 + square);
        let mut gone = 0.0;
        while let Some(hit) = meshes.hit(position + gone * way, way) {
            gone += hit.distance;
            if !(culling && hit.closed && hit.normal.dot(way) < 0.0) {
                return Seen::At(gone);
            }
        }
        Seen::Nothing
    };
    (0..SIDE * SIDE).map(of).collect()
}

/// Whether the texels up to two away find nearly the same distance: points are sparse, and a disc covers neighbouring texels.
fn is_even(seen: &[Seen], texel: usize) -> bool {
    let (x, y) = ((texel % SIDE) as i32, (texel / SIDE) as i32);
    let about = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| [x + dx, y + dy]));
    about.filter(|at| at.iter().all(|i| (0..SIDE as i32).contains(i))).all(|[x, y]| {
        match (seen[texel], seen[y as usize * SIDE + x as usize]) {
            (Seen::At(a), Seen::At(b)) => (a / b - 1.0).abs() < 0.15,
            (a, b) => a == b,
        }
    })
}

/// Returns the probability that no disc covers a texel's centre, for points at random positions with one per `share` of area. The radius of
/// a disc is 1.25 times that of a circle with area `share`, plus 0.3 texels of the level on which it is at most 3 texels wide. Also returns
/// this probability times the expected number of uncovered texels around an uncovered one: a disc moved by s covers an additional area of 2
/// R s, which must contain no point, in every direction.
fn missing(share: f64, distance: f64, texel: usize) -> [f64; 2] {
    let [x, y] = [texel % SIDE, texel / SIDE].map(|t| (t as f64 + 0.5) / (SIDE as f64 / 2.0) - 1.0);
    let finest = 2.0 * 2.0 * distance / (1.0 + x * x + y * y) / SIDE as f64;
    let radius = 1.25 * (share / PI).sqrt();
    let mut wide = finest;
    while radius > 3.0 * wide {
        wide *= 2.0;
    }
    let reach = radius + 0.3 * wide;
    let likely = (-PI * reach * reach / share).exp();
    [likely, likely * (0.5 * PI * (share / (reach * finest)).powi(2)).max(1.0)]
}

/// Grey must be the length of a ray relative to the largest, which the command prints; orange must be where the ray never ends, and the few
/// holes.
#[test]
fn a_map_is_what_rays_find() {
    gpu_test_needing("a_map_is_what_rays_find", &[], |context| {
        let scene = Scene::load("cornell", 20.0).expect("built in");
        let meshes = Meshes::new(&scene.meshes);
        let corners = |mesh: &Mesh, t: &[u32; 3]| t.map(|i| DVec3::from(mesh.positions[i as usize].map(f64::from)));
        let of = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        let area: f64 =
            scene.meshes.iter().flat_map(|mesh| mesh.triangles.iter().map(move |t| of(corners(mesh, t)))).sum();
        let lights = lit_by_vpls(context, &scene, 64, VplsBy::Flux).expect("lit").lights;
        let folder = folder();
        let out = folder.path().join("map.png");
        let specs = [("fill=on", true), ("fill=off,culling=off", false), ("fill=off", true)];
        let cases = [9, 23, 40, 61].into_iter().flat_map(|light| specs.map(|spec| (light, spec)));
        for (light, (spec, culling)) in some(cases, 5) {
            let LightKind::Virtual { position, normal, .. } = lights[light].kind else { panic!("a virtual light") };
            let (scale, number, spec) =
                (SCALE.to_string(), light.to_string(), format!("ism:path=atomic,adaptive=off,{spec}"));
            let map = ["map", "cornell", "--vpls", "64", "--scale", &scale, "--technique", &spec];
            let said = ok(&[&map[..], &["--light", &number, "--out", text(&out)]].concat());
            let (size, pixels) = rgb8(&out);
            assert_eq!(size, [(SIDE * SCALE) as u32; 2]);
            let painted: Vec<[u8; 3]> =
                (0..SIDE * SIDE).map(|i| pixels[i / SIDE * SCALE * SIDE * SCALE + i % SIDE * SCALE]).collect();
            for (i, pixel) in pixels.iter().enumerate() {
                let [x, y] = [i % (SIDE * SCALE), i / (SIDE * SCALE)].map(|p| p / SCALE);
                assert_eq!(*pixel, painted[y * SIDE + x], "a texel is one color");
                assert!(*pixel == ORANGE || pixel.iter().all(|c| *c == pixel[0]), "grey or orange: {pixel:?}");
            }
            let empty = painted.iter().filter(|p| **p == ORANGE).count();
            assert!(said.contains(&format!("{empty} of {} texels empty", SIDE * SIDE)), "{said}");
            let farthest: f64 = said.trim().rsplit(' ').next().expect("a word").parse().expect("a distance");

            let seen = rays(&meshes, position, normal, culling);
            let ([mut behind, mut open, mut holes], mut off, mut missed) = ([[0u32; 2]; 3], Vec::new(), [0.0; 2]);
            for (texel, pixel) in painted.iter().enumerate().filter(|(texel, _)| is_even(&seen, *texel)) {
                let is_orange = usize::from(*pixel == ORANGE);
                match seen[texel] {
                    Seen::Behind => behind[is_orange] += 1,
                    Seen::Nothing => open[is_orange] += 1,
                    Seen::At(distance) => {
                        holes[is_orange] += 1;
                        let more = missing(area / POINTS, distance, texel);
                        missed = [missed[0] + more[0], missed[1] + more[1]];
                        if *pixel != ORANGE {
                            off.push((f64::from(pixel[0]) / 255.0 * farthest - distance).abs() / distance);
                        }
                    }
                }
            }
            off.sort_unstable_by(f64::total_cmp);
            let share = |s: f64| off[(s * (off.len() - 1) as f64) as usize];
            let [half, most] = [share(0.5), share(0.9)];
            let [by_chance, apart] = [missed[0], missed[1].sqrt()];
            println!(
                "light {light}, {spec}: grey and orange behind {behind:?}, in the open {open:?}, on meshes {holes:?} and by chance {by_chance:.0} and {apart:.0}, \
                 off by {half:.4}, {most:.4}, {:.3}",
                share(1.0)
            );
            // Discs reach past the map's circle, and filled texels farther still: nothing is looked up there.
            assert!(behind[1] > 150 && holes[0] > 500, "light {light}, {spec}: {behind:?}, {holes:?}");
            assert!(50 * open[0] <= open[1], "light {light}, {spec}: {open:?} in the open");
            // There may be no more holes than points at random positions leave, within three standard deviations, and next to none if they
            // are filled.
            let allowed = if spec.contains("fill=on") { holes[0] as f64 / 20.0 } else { by_chance + 3.0 * apart };
            assert!(f64::from(holes[1]) <= allowed, "light {light}, {spec}: {holes:?} holes, not {allowed}");
            // Through a hole in a near side its far side is visible, unless it is culled.
            let through = if culling { 0.0 } else { allowed };
            let wrong = off.iter().filter(|off| **off > 0.06).count() as f64;
            assert!(half < 0.02, "light {light}, {spec}: off by {half}");
            assert!(wrong <= 0.1 * off.len() as f64 + through, "light {light}, {spec}: {wrong} of {}", off.len());
        }
    });
}
