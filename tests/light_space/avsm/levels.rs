//! levels=: each level against its twin, computed from the level below; look-ups against the nodes they read; and look-ups over squares
//! against the truth.

use crate::avsm::TOLERANCE;
use crate::support::{ask, built_avsm, gpu_test, is_long, nodes_of, scenes, some, spec};
use crate::twin::{DEPTHS, build, depth, look_up};
use glam::DVec3;
use gobo::gpu::Context;
use gobo::maps::level_size;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::Casters;
use gobo::reference::twin::avsm::levels::{cost, merged};
use gobo::scene::{Camera, FARTHEST, Fog, Projection, Scene, Strand, View};
use gobo::shading::{Lighting, Renderer, Shading, Tiled};
use gobo::technique::{Avsm, NodeData, Technique};
use gobo::world::World;

/// The curves of all maps, level by level; empty if nothing casts.
struct Levels {
    avsm: Box<Avsm>,
    views: Vec<View>,
    /// One entry per level: map after map, rows of texels.
    curves: Vec<Vec<Vec<NodeData>>>,
}

impl Levels {
    fn new(context: &Context, scene: &Scene, text: &str, count: u32) -> Self {
        let avsm = built_avsm(context, scene, text);
        let views: Vec<View> = avsm.inspect().maps().iter().map(|map| map.caster_view).collect();
        let size = [views[0].width, views[0].height];
        let texels = |level: u32| level_size(size, level).iter().product::<u32>() as usize * views.len();
        let nodes = nodes_of(&avsm, text, (0..count).map(texels).sum());
        let mut curves = nodes.chunks_exact(build(&spec(text)).nodes);
        let used = |curve: &[NodeData]| curve.iter().filter(|n| n.depth < FARTHEST).copied().collect::<Vec<_>>();
        let mut curves: Vec<Vec<_>> =
            (0..count).map(|level| curves.by_ref().take(texels(level)).map(used).collect()).collect();
        let bins = avsm.bins().expect("bins");
        for (curve, _) in curves[0].iter_mut().zip(bins.texels_in_use(size).expect("counts")).filter(|(_, used)| !used)
        {
            curve.clear();
        }
        Self { avsm, views, curves }
    }

    fn size(&self, level: u32) -> [u32; 2] {
        level_size([self.views[0].width, self.views[0].height], level)
    }

    /// Returns the curve of a texel, empty past the edge.
    fn curve(&self, level: u32, map: usize, [x, y]: [u32; 2]) -> &[NodeData] {
        let [width, height] = self.size(level);
        let is_there = x < width && y < height;
        if is_there { &self.curves[level as usize][((map as u32 * height + y) * width + x) as usize] } else { &[] }
    }
}

fn transmittance(curve: &[NodeData], depth: f32, text: &str) -> f32 {
    if curve.is_empty() { 1.0 } else { look_up(curve, depth, build(&spec(text)).interpolation) }
}

/// Each texel of a level equals the twin's merge of the device's four texels below it, and absorbs as much light in total as their mean.
#[test]
fn levels_are_means_of_those_below() {
    gpu_test("levels_are_means_of_those_below", |context| {
        let cases = vec![
            (scenes::random(), "path=binned,size=20"),
            (scenes::locks(), "path=binned,size=21,nodes=4,texel=area"),
            (scenes::locks(), "path=binned,size=20,curve=linear"),
            (scenes::inside(), "path=binned,size=32"),
            (scenes::opaque(), "path=binned,size=20,storage=packed"),
        ];
        for (scene, settings) in some(cases, 2) {
            let text = format!("avsm:{settings},levels=4");
            let all = Levels::new(context, &scene, &text, 4);
            let build = build(&spec(&text));
            let (mut astray, mut others, mut compared) = (0, 0, 0);
            for level in 1..4 {
                let [width, height] = all.size(level);
                for i in 0..width * height * all.views.len() as u32 {
                    let (map, x, y) = ((i / (width * height)) as usize, i % width, i / width % height);
                    let what = format!("{}, {text}, level {level}, map {map}, texel {x}, {y}", scene.name);
                    let curve = all.curve(level, map, [x, y]);
                    let below = [0, 1, 2, 3].map(|i| all.curve(level - 1, map, [2 * x + i % 2, 2 * y + i / 2]));
                    let mean = |depth| below.iter().map(|c| transmittance(c, depth, &text)).sum::<f32>() / 4.0;
                    // Merging drops the remaining nodes once no light is left.
                    let (tail, whole) = (transmittance(curve, 2.0, &text), mean(2.0));
                    assert!((tail - whole).abs() < 1e-4, "{what}: {tail} of all light, not {whole}");
                    let nodes = below.map(|c| c.iter().map(|n| (n.depth, n.value)).collect::<Vec<_>>());
                    let twin = merged([0, 1, 2, 3].map(|i| &nodes[i][..]), build);
                    let off = |of: &dyn Fn(f32) -> f32| {
                        let at = |i| (transmittance(curve, depth(i), &text) - of(depth(i))).abs();
                        (0..DEPTHS).map(at).sum::<f32>() / DEPTHS as f32
                    };
                    let apart = off(&|depth| twin.transmittance(depth));
                    // A curve other than the twin's is accepted if its cost is about the same.
                    let below = || [0, 1, 2, 3].map(|i| &nodes[i][..]);
                    let [its, twins] = [
                        cost(below(), build, |depth| transmittance(curve, depth, &text)),
                        cost(below(), build, |depth| twin.transmittance(depth)),
                    ];
                    // The first and last compared depths are nodes, where rounding a depth puts it before a step or behind it.
                    let is_good = apart <= TOLERANCE || (its - twins).abs() < 1e-4 + 0.01 * twins;
                    astray += u32::from(!is_good);
                    others += u32::from(apart > TOLERANCE);
                    let from_mean = off(&mean);
                    assert!(from_mean < 0.03, "{what}: {from_mean} from the mean");
                    compared += u32::from(!twin.nodes().is_empty());
                }
            }
            println!("{}, {text}: {astray} of {compared} astray, {others} other curves", scene.name);
            assert!(compared > 30 && 50 * astray <= compared, "{}: {astray} of {compared}", scene.name);
            assert!(10 * others <= compared, "{}: {others} of {compared} are others than the twin's", scene.name);
        }
    });
}

/// Returns points in the view, each with a square `texels` texels wide.
fn squares(view: &View, texels: f64) -> (Vec<[f32; 3]>, Vec<f32>) {
    let mut random = scenes::Random::new(9);
    let mut point = |_| {
        let at = [view.width, view.height].map(|side| f64::from(side) * f64::from(random.between(0.02, 0.98)));
        view.ray(at.into()).at(view.z(f64::from(random.between(0.05, 1.05)))).as_vec3().to_array()
    };
    let points: Vec<_> = (0..600).map(&mut point).collect();
    let side = |point: &[f32; 3]| {
        let [a, b] = view.texel_at(DVec3::from(point.map(f64::from))).map(DVec3::length);
        ((a * b).sqrt() * texels) as f32
    };
    let sides = points.iter().map(side).collect();
    (points, sides)
}

fn asked(context: &Context, avsm: &Avsm, points: &[[f32; 3]], sides: &[f32]) -> Vec<f32> {
    let asked = [PointBatch { light: 0, points, normals: &[] }];
    let query = Query::of_areas(context, &asked, sides).expect("room");
    query.ask(&avsm.answer()).expect("answered")
}

/// A square's look-up blends the two levels whose texels are closest to its width, each filtered bilinearly; a point's look-up uses the
/// finest map.
#[test]
fn squares_are_answered_by_levels() {
    gpu_test("squares_are_answered_by_levels", |context| {
        for scene in [scenes::random(), scenes::locks()] {
            let text = "avsm:path=binned,size=40,levels=4";
            let all = Levels::new(context, &scene, text, 4);
            let view = all.views[0];
            assert_eq!(view.projection(), Projection::Parallel);
            let plain = built_avsm(context, &scene, "avsm:path=binned,size=40");
            let (points, _) = squares(&view, 0.0);
            assert_eq!(ask(context, &*all.avsm, 0, &points), ask(context, &*plain, 0, &points), "points");
            for texels in [0.5, 2.0, 5.0, 40.0] {
                let (points, sides) = squares(&view, texels);
                let level = (texels.log2() - 0.5).clamp(0.0, 3.0);
                let mut off = 0;
                for (point, answer) in points.iter().zip(asked(context, &all.avsm, &points, &sides)) {
                    let (at, z) = view.project(DVec3::from(point.map(f64::from)));
                    let depth = view.depth(z) as f32;
                    let of = |level: u32| {
                        let place = at / f64::from(1 << level) - 0.5;
                        let (corner, rest) = (place.floor(), place - place.floor());
                        let texel = |i: u32| {
                            let [x, y] = [corner.x + f64::from(i % 2), corner.y + f64::from(i / 2)];
                            let weight = [rest.x, 1.0 - rest.x][usize::from(i.is_multiple_of(2))]
                                * [rest.y, 1.0 - rest.y][usize::from(i / 2 == 0)];
                            let curve =
                                if x < 0.0 || y < 0.0 { &[] } else { all.curve(level, 0, [x as u32, y as u32]) };
                            weight * f64::from(transmittance(curve, depth, text))
                        };
                        (0..4).map(texel).sum::<f64>()
                    };
                    let share = level - level.floor();
                    let near = level.floor() as u32;
                    let expected = of(near) * (1.0 - share) + if share > 0.0 { share * of(near + 1) } else { 0.0 };
                    off += u32::from((expected - f64::from(answer)).abs() > 1e-3);
                }
                // A point may lie at a step of a curve, on either side.
                assert!(off <= 6, "{}, {texels} texels: {off} of {}", scene.name, points.len());
            }
        }
    });
}

/// The look-up of a square wider than a texel is nearer to the mean of the truth over the square than the look-up of a point.
#[test]
fn squares_see_means() {
    gpu_test("squares_see_means", |context| {
        let scene = scenes::locks();
        let casters = Casters::new(&scene);
        let avsm = built_avsm(context, &scene, "avsm:path=binned,size=64,levels=5");
        let view = avsm.inspect().maps()[0].caster_view;
        for texels in [4.0, 10.0] {
            let (points, sides) = squares(&view, texels);
            let mean = |point: &[f32; 3]| {
                let centre = DVec3::from(point.map(f64::from));
                let across = view.texel_at(centre).map(|side| side * texels / 8.0);
                let ray = |i: u32| {
                    let [x, y] = [i % 8, i / 8].map(|i| f64::from(i) - 3.5);
                    casters.visibility(0, centre + across[0] * x + across[1] * y)
                };
                (0..64).map(ray).sum::<f64>() / 64.0
            };
            let means: Vec<f64> = points.iter().map(mean).collect();
            let rms = |answers: Vec<f32>| {
                let squares = answers.iter().zip(&means).map(|(a, mean)| (f64::from(*a) - mean).powi(2));
                (squares.sum::<f64>() / points.len() as f64).sqrt()
            };
            let [by_points, by_squares] =
                [rms(ask(context, &*avsm, 0, &points)), rms(asked(context, &avsm, &points, &sides))];
            println!("{texels} texels: {by_squares:.4} instead of {by_points:.4}");
            assert!(by_squares < 0.6 * by_points, "{texels} texels: {by_squares}, {by_points} by points");
        }
    });
}

/// Two lattices under a light from above, each strand of the lower one behind a strand of the upper: the second absorbs light that the
/// first has already absorbed. Strands are about a texel wide and cover texels partially; averaging each strand separately would leave 0.39
/// of the light in the mean instead of 0.505.
#[test]
fn areas_see_strands_behind_each_other() {
    gpu_test("areas_see_strands_behind_each_other", |context| {
        let (pitch, opacity) = (0.07f32, 0.9f32);
        let mut scene = scenes::directional("behind", [0.0, 0.0, -1.0], Vec::new());
        let strand = |i: i32, z: f32| {
            let x = pitch * i as f32;
            Strand { start: [x, -2.0, z], end: [x, 2.0, z], radius: pitch / 4.0, opacity }
        };
        scene.strands = (-28..=28).flat_map(|i| [strand(i, 1.0), strand(i, 3.0)]).collect();
        let avsm = built_avsm(context, &scene, "avsm:path=binned,size=128,levels=6,texel=area");
        let through = 1.0 - opacity;
        for (z, expected) in [(3.5, 1.0), (2.0, 0.5 + 0.5 * through), (0.0, 0.5 + 0.5 * through * through)] {
            let at = |i: i32| 0.13 * i as f32;
            let points: Vec<_> = (-7..=7).flat_map(|i| (-7..=7).map(move |k| [at(i), at(k), z])).collect();
            let answers = asked(context, &avsm, &points, &vec![28.0 / 32.0; points.len()]);
            let mean = answers.iter().sum::<f32>() / answers.len() as f32;
            println!("at {z}: {mean}, in truth {expected}");
            // A cell is a quarter as wide as a strand; within it the overlap is a matter of chance. Along each strand's two edges, half a
            // cell wide on average, the transmittance for a covered fraction c is (1 - 0.9 c)² instead of 1 - 0.99 c, which is 0.135 less
            // in the mean: 0.03 in total.
            assert!((mean - expected).abs() < 0.05, "at {z}: {mean}, not {expected}");
        }
    });
}

/// Pixels of a floor under a lattice of strands thinner than a pixel: each queries a square of its own width and sees the mean.
#[test]
fn pixels_see_means() {
    if is_long("pixels_see_means") {
        return;
    }
    gpu_test("pixels_see_means", |context| {
        let mut scene = scenes::directional("lattice", [0.3, 0.2, -1.0], Vec::new());
        scene.meshes.push(scenes::level(0.0, 4.0, [0.0; 2]));
        // The strands are above the camera's view.
        let strand = |i: i32| {
            let x = 0.06 * i as f32;
            Strand { start: [x, -6.0, 4.0], end: [x, 6.0, 4.0], radius: 0.02, opacity: 1.0 }
        };
        scene.strands = (-100..100).map(strand).collect();
        scene.camera =
            Camera { position: DVec3::new(0.0, -6.0, 1.5), target: DVec3::ZERO, up: DVec3::Z, fov_y_degrees: 20.0 };
        let size = [32, 18];
        let camera = View::camera(&scene.camera, &scene, size);
        let world = World::new(context, &scene).expect("room");
        let renderer = Renderer::new(context, &world, &camera).expect("a renderer");
        let avsm =
            [1, 8].map(|levels| built_avsm(context, &scene, &format!("avsm:path=binned,size=512,levels={levels}")));
        let picture =
            |avsm: &Avsm, shading| renderer.picture(&avsm.answer(), shading, Lighting::Fragment).expect("drawn").pixels;
        // Neighbours in a row see the same lattice: any difference between them is noise, caused by where exactly their rays hit.
        let unrest = |pixels: &[[f32; 3]]| {
            let of = |row: &[[f32; 3]]| row.windows(2).map(|pair| (pair[0][1] - pair[1][1]).abs()).sum::<f32>();
            pixels.chunks_exact(size[0] as usize).map(of).sum::<f32>()
        };
        let calmer = |what: &str, [points, pixels]: [Vec<[f32; 3]>; 2]| {
            let [points, pixels] = [unrest(&points), unrest(&pixels)];
            println!("{what}: {pixels} of {points}");
            assert!(pixels < 0.7 * points, "{what}: {pixels} of {points}");
        };
        for shading in [Shading::Forward, Shading::Deferred, Shading::Interleaved, Shading::Reservoir] {
            calmer(&format!("{shading:?}"), avsm.each_ref().map(|avsm| picture(avsm, shading)));
        }
        // Isolates the light scattered by the air between the eye and the ground: the difference that fog makes to the picture.
        let in_air = avsm.each_ref().map(|avsm| {
            let clear = picture(avsm, Shading::Forward);
            renderer.fog(&avsm.answer(), &Fog::new(0.1, 8).expect("fog")).expect("drawn");
            let foggy = renderer.read().expect("read").pixels;
            foggy.iter().zip(&clear).map(|(foggy, clear)| [0, 1, 2].map(|i| foggy[i] - clear[i])).collect()
        });
        calmer("fog", in_air);
        // Tiled shading decides lit or dark for each pixel, consistently with the light in the deferred picture.
        let deferred = picture(&avsm[1], Shading::Deferred);
        let tiled = picture(&avsm[1], Shading::Tiled(Tiled::BARE));
        let ends =
            |less: fn(f32, f32) -> bool| tiled.iter().map(|p| p[1]).reduce(|a, b| if less(a, b) { a } else { b });
        let [dark, lit] = [ends(|a, b| a < b), ends(|a, b| a > b)].map(|end| end.expect("pixels"));
        let [mut both, mut wrong] = [[0; 2], [0; 2]];
        for (deferred, tiled) in deferred.iter().zip(&tiled) {
            let visibility = (deferred[1] - dark) / (lit - dark);
            let is_lit = tiled[1] > 0.5 * (dark + lit);
            if (visibility - 0.5).abs() > 0.01 {
                both[usize::from(is_lit)] += 1;
                wrong[usize::from(is_lit)] += usize::from(is_lit != (visibility > 0.5));
            }
        }
        println!("tiled: {both:?} pixels dark and lit, {wrong:?} wrong");
        assert!(wrong == [0; 2] && both[0] + both[1] > 400, "{both:?}, {wrong:?}");
    });
}
