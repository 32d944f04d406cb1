//! `gobo slice`: each pixel must be the truth at its point in the light's view.

use super::rgb8;
use crate::support::{gpu_test_needing, some};
use crate::{folder, ok, small_scene, text};
use glam::DVec2;
use gobo::gpu::Requirement;
use gobo::maps::OpaqueMaps;
use gobo::reference::truth::{Casters, Meshes};
use gobo::report::Paper;
use gobo::scene::{FACES, Projection, Scene, View};
use image::AnimationDecoder;

/// Encodes a linear value by IEC 61966-2-1, in eight bits.
fn srgb8(linear: f64) -> f64 {
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Pixels per side, equal to the map's texels: at texel centres the exact list has the truth.
const SIZE: u32 = 48;

/// Returns the slice that a map must show, in eight bits per pixel, where it is known: in a face's margin another face is queried, and in
/// the boundary of a mesh's shadow the answer is ambiguous.
fn truth(casters: &Casters, light: usize, map: usize, depth: f64) -> Vec<Option<f64>> {
    let scene = casters.scene();
    let (view, opaque) = (View::volumes(scene, SIZE)[map], View::opaques(scene, OpaqueMaps::SHARED.size)[map]);
    let resolution = OpaqueMaps::SHARED.resolution(opaque);
    let at = |i: u32| {
        let pixel = DVec2::new((i % SIZE).into(), (i / SIZE).into()) + 0.5;
        let point = view.ray(pixel).at(view.z(depth));
        let asked = scene.first_map(light) + scene.lights[light].map_at(point.as_vec3().into());
        let known = asked == map && !(scene.has_triangles() && casters.in_boundary(light, &resolution, point));
        known.then(|| srgb8(casters.visibility(light, point)))
    };
    (0..SIZE * SIZE).map(at).collect()
}

/// Returns the largest error of known pixels, their number, and the darkest of them.
fn compared(painted: &[[u8; 3]], truth: &[Option<f64>]) -> (f64, usize, f64) {
    let known = painted.iter().zip(truth).filter_map(|(pixel, truth)| truth.map(|truth| (pixel, truth)));
    known.fold((0.0, 0, 255.0), |(off, count, darkest), (pixel, truth)| {
        assert!(pixel.iter().all(|c| *c == pixel[0]), "grey: {pixel:?}");
        (f64::max(off, (f64::from(pixel[0]) - truth).abs()), count + 1, f64::min(darkest, truth))
    })
}

/// Checks single slices and sweeps, for each kind of light, with meshes and without.
#[test]
fn slices_are_the_truth() {
    if crate::support::is_costly("slices_are_the_truth") {
        return;
    }
    gpu_test_needing("slices_are_the_truth", &[Requirement::FragmentStores], |_| {
        let folder = folder();
        let small = small_scene(folder.path());
        let cases = [(text(&small), 0, None), ("lantern", 0, Some("+y")), ("lantern", 1, None), ("hair", 0, None)];
        for (name, light, face) in some(cases, 3) {
            let scene = Scene::load(name, 20.0).expect("loaded");
            let casters = Casters::new(&scene);
            let place = face.map_or(0, |face| FACES.iter().position(|(name, _)| *name == face).expect("a face"));
            let map = scene.first_map(light) + place;
            let (size, picture, light_text) = (SIZE.to_string(), format!("{SIZE}x{SIZE}"), light.to_string());
            let technique = format!("uncompressed:size={size}");
            let mut slice = vec![
                "slice",
                name,
                "--plain",
                "--technique",
                &technique,
                "--picture",
                &picture,
                "--light",
                &light_text,
            ];
            slice.extend(face.into_iter().flat_map(|face| ["--face", face]));
            let (one, sweep) = (folder.path().join("one.png"), folder.path().join("sweep.png"));
            ok(&[&slice[..], &["--depth", "0.62", "--out", text(&one)]].concat());
            ok(&[&slice[..], &["--frames", "4", "--out", text(&sweep)]].concat());
            let file = std::fs::File::open(sweep.with_extension("gif")).expect("an animation");
            let gif = image::codecs::gif::GifDecoder::new(std::io::BufReader::new(file)).expect("a GIF");
            let animated = gif.into_frames().collect_frames().expect("frames");
            assert_eq!(animated.len(), 4);

            let mut painted = vec![(f64::from(0.62f32), rgb8(&one))];
            for frame in 0..4 {
                painted.push((f64::from(frame) / 3.0, rgb8(&folder.path().join(format!("sweep-{frame}.png")))));
            }
            let mut darkest = 255.0f64;
            for (i, (depth, (size, pixels))) in painted.iter().enumerate() {
                assert_eq!(*size, [SIZE; 2]);
                let truth = truth(&casters, light, map, *depth);
                let (off, known, dark) = compared(pixels, &truth);
                println!(
                    "{name}, light {light}, depth {depth:.2}: {known} pixels, off by {off:.2} of 255, to {dark:.0}"
                );
                assert!(2 * known > truth.len(), "{name}, depth {depth}: {known} pixels are known");
                assert!(off < 1.0, "{name}, light {light}, depth {depth}: off by {off} of 255");
                darkest = darkest.min(dark);
                if i > 0 {
                    // An animation has 256 colors, here greys.
                    let frame = animated[i - 1].buffer();
                    let rgb: Vec<[u8; 3]> = frame.pixels().map(|p| [p.0[0], p.0[1], p.0[2]]).collect();
                    let off = rgb.iter().zip(pixels).map(|(a, b)| a[0].abs_diff(b[0])).max();
                    assert!(off <= Some(4), "{name}, frame {}: the animation is off by {off:?} of 255", i - 1);
                }
            }
            assert!(darkest < 160.0, "{name}: no shadow is seen");
        }
    });
}

/// Returns whether the ray through each pixel hits something; `None` if rays a millionth of a pixel away disagree.
fn met(view: &View, meets: impl Fn(DVec2) -> bool) -> Vec<Option<bool>> {
    let at = |i: u32| {
        let middle = DVec2::new((i % SIZE).into(), (i / SIZE).into()) + 0.5;
        let all =
            [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|way| meets(middle + 1e-6 * DVec2::from(way)));
        all.iter().all(|is| *is == all[0]).then_some(all[0])
    };
    assert_eq!([view.width, view.height], [SIZE; 2]);
    (0..SIZE * SIZE).map(at).collect()
}

/// Returns whether each pixel is hit while a neighbour is not.
fn rim(met: &[Option<bool>]) -> Vec<Option<bool>> {
    let at = |i: u32| {
        let (x, y) = (i % SIZE, i / SIZE);
        let beside = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        let inside = beside.into_iter().filter(|(x, y)| *x < SIZE && *y < SIZE);
        let beside: Option<Vec<bool>> = inside.map(|(x, y)| met[(y * SIZE + x) as usize]).collect();
        Some(met[i as usize]? && beside?.contains(&false))
    };
    (0..SIZE * SIZE).map(at).collect()
}

/// The caption of a slice must name the scene, the light if there are several, and the technique; a plain slice has no caption.
#[test]
fn a_slice_says_what_it_shows() {
    gpu_test_needing("a_slice_says_what_it_shows", &[Requirement::FragmentStores], |_| {
        let folder = folder();
        let out = folder.path().join("slice.png");
        let small = small_scene(folder.path());
        let technique = "uncompressed:size=16,skip=off";
        for (name, more, words) in [
            (text(&small), &[][..], ["small", technique]),
            ("lantern", &["--light", "0", "--face", "+x"], ["lantern, light 0, face +x", technique]),
        ] {
            let slice = ["slice", name, "--technique", technique, "--picture", "400x400", "--out", text(&out)];
            ok(&[&slice[..], more].concat());
            let ([width, height], pixels) = rgb8(&out);
            let below: Vec<u8> = pixels[(width * 400) as usize..].concat();
            let mut from = 0;
            for line in words {
                let mut paper = Paper::new([width, 16]);
                paper.write([6, 0], width - 6, line);
                let place = (from..=height - 400 - 16).find(|row| {
                    let at = (3 * width * row) as usize;
                    below[at..at + paper.rgb8.len()] == paper.rgb8
                });
                from = place.unwrap_or_else(|| panic!("{name}: {line} is not below the slice")) + 16;
            }
            ok(&[&slice[..], more, &["--plain"]].concat());
            assert_eq!(rgb8(&out).0, [400, 400]);
        }
    });
}

/// The outline of a volume must be orange and that of each mesh blue, where the f64 reference's rays begin to hit them.
#[test]
fn outlines_are_where_rays_begin_to_meet_casters() {
    gpu_test_needing("outlines_are_where_rays_begin_to_meet_casters", &[Requirement::FragmentStores], |_| {
        const ORANGE: [u8; 3] = [213, 94, 0];
        const BLUE: [u8; 3] = [0, 114, 178];
        let folder = folder();
        for (name, face) in some([("cloud", None), ("hair", None), ("lantern", Some("-z"))], 2) {
            let scene = Scene::load(name, 20.0).expect("built in");
            let map = face.map_or(0, |face| FACES.iter().position(|(name, _)| *name == face).expect("a face"));
            let (view, casters) = (View::volumes(&scene, SIZE)[map], Casters::new(&scene));
            let (size, out) = (SIZE.to_string(), folder.path().join("slice.png"));
            let (technique, picture) = (format!("uncompressed:size={size}"), format!("{SIZE}x{SIZE}"));
            let mut slice = vec!["slice", name, "--technique", &technique, "--picture", &picture, "--depth", "0.5"];
            slice.extend(face.into_iter().flat_map(|face| ["--face", face]));
            ok(&[&slice[..], &["--out", text(&out)]].concat());
            let painted = &rgb8(&out).1[..(SIZE * SIZE) as usize];
            let begins = if view.projection() == Projection::Parallel { -1e3 } else { 0.0 };
            let mut rims = Vec::new();
            for mesh in &scene.meshes {
                let meshes = Meshes::new(std::slice::from_ref(mesh));
                let hits = |pixel: DVec2| {
                    let ray = view.ray(pixel);
                    meshes.hit(ray.at(begins), ray.direction).is_some()
                };
                rims.push(rim(&met(&view, hits)));
            }
            let dense =
                |pixel| casters.true_curve(map, &view, &view.ray(pixel)).0.volumes.iter().any(|v| !v.is_empty());
            let of_volumes = (!scene.volumes.is_empty()).then(|| rim(&met(&view, dense)));
            let mut counts = [0; 2];
            for (i, pixel) in painted.iter().enumerate() {
                if let Some(is) = of_volumes.as_ref().and_then(|rim| rim[i]) {
                    assert_eq!(*pixel == ORANGE, is, "{name}, pixel {i}: {pixel:?}");
                    counts[0] += usize::from(is);
                }
                // Smoke and hair are outlined over meshes.
                if *pixel == ORANGE || rims.iter().any(|rim| rim[i].is_none()) {
                    continue;
                }
                let is = rims.iter().any(|rim| rim[i] == Some(true));
                assert_eq!(*pixel == BLUE, is, "{name}, pixel {i}: {pixel:?}");
                counts[1] += usize::from(is);
            }
            println!("{name}: {counts:?} pixels of outlines of volumes, of meshes");
            assert!(counts[usize::from(scene.volumes.is_empty())] > 20, "{name}: {counts:?}");
        }
    });
}
