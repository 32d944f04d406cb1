//! Points that lights choose by what they and the viewer see.

use crate::ism::maps::{point, stand};
use crate::ism::{built, refusal, scenes};
use crate::support::{gpu_test, scenes::cuboid};
use glam::DVec3;
use gobo::reference::twin::ism::adapt::{Choice, halved, taken, taken_index};
use gobo::reference::twin::ism::clusters::{CLUSTER, Cluster, cluster};
use gobo::reference::twin::ism::points::{area, point_along, sums};
use gobo::reference::twin::ism::splat::{Culling, is_before, is_seen};
use gobo::scene::Scene;
use gobo::technique::{ClusterData, Ism};
use std::collections::BTreeSet;

/// Returns the points that each light takes, without empty slots.
fn lists(ism: &Ism, lights: usize) -> Vec<Vec<u32>> {
    let (_, all) = ism.taken().expect("what lights take").expect("adaptive points");
    let own = |list: &[u32]| {
        let count = list.iter().position(|code| *code == u32::MAX).unwrap_or(list.len());
        assert!(list[count..].iter().all(|code| *code == u32::MAX), "nothing is taken after the last");
        list[..count].to_vec()
    };
    all.chunks_exact(all.len() / lights).map(own).collect()
}

pub fn of_device(data: &ClusterData) -> Cluster {
    let ClusterData { middle, reach, normal, spread, sides, thick, closed } = *data;
    Cluster { middle, reach, normal, spread, sides, thick, closed: closed == 1 }
}

fn choice(scene: &Scene, area: f32, size: u32, points: u32, culling: Culling) -> Choice {
    let camera = &scene.camera;
    let near = camera.position.distance(camera.target) as f32;
    Choice { size, points, area, eye: camera.position.as_vec3().to_array(), near, culling }
}

/// Compares three stages with their twins: the order of points along the triangles, the clusters' bounds, and the lights' choice of points.
/// Each twin starts from the device's own previous stage. Where rounding decides, a cluster may get another rank, or a point may land on
/// the next triangle.
#[test]
fn adaptive_points_equal_their_twin() {
    gpu_test("ism::adaptive_points_equal_their_twin", |context| {
        let cases = [
            ("culling=on", Culling { on: true, far: false, slide: false }),
            ("culling=off", Culling { on: false, far: false, slide: false }),
            ("culling=far", Culling { on: true, far: true, slide: false }),
            ("facing=slide", Culling { on: true, far: false, slide: true }),
        ];
        for scene in [scenes::soup(), scenes::room()] {
            for ((case, culling), points) in cases.into_iter().zip([1024, 2048, 1024, 1024]) {
                let text = format!("ism:adaptive=on,points={points},size=32,path=atomic,{case}");
                let ism = built(context, &scene, &text);
                let (head, pool) = ism.points().expect("the points");
                let triangles = crate::ism::points::triangles(&scene);
                let sums = sums(&triangles.iter().map(|t| area(*t)).collect::<Vec<_>>(), head.scale);
                // Rounded areas shift a point along the curve by a few of 2^30 units of weight, and in space by the square root of that
                // fraction.
                let far = 0.1 * (f64::from(head.area) / pool.len() as f64).sqrt();
                let moved = (0..).zip(&pool).filter(|(i, got)| {
                    let (_, wanted) = point_along(&triangles, &sums, *i, points).expect("there is area");
                    DVec3::from(got.position.map(f64::from)).distance(wanted.map(f64::from).into()) > far
                });
                let moved = moved.count();
                assert!(moved * 500 < pool.len(), "{text}: {moved} of {} points stand elsewhere", pool.len());

                let (clusters, _) = ism.taken().expect("them").expect("adaptive points");
                let pool: Vec<_> = pool.iter().map(point).collect();
                for (got, own) in clusters.iter().map(of_device).zip(pool.chunks_exact(CLUSTER)) {
                    let wanted = cluster(own);
                    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
                    let same =
                        (0..3).all(|i| near(got.middle[i], wanted.middle[i]) && near(got.normal[i], wanted.normal[i]));
                    let same = same && (0..3).all(|i| near(got.sides[i], wanted.sides[i]));
                    let bounds = near(got.reach, wanted.reach) && near(got.thick, wanted.thick);
                    assert!(same && bounds && near(got.spread, wanted.spread), "{text}: {got:?}, not {wanted:?}");
                    assert_eq!(got.closed, wanted.closed);
                }

                let clusters: Vec<_> = clusters.iter().map(of_device).collect();
                let choice = choice(&scene, head.area, 32, points, culling);
                let (mut others, mut all) = (0, 0);
                for (light, got) in lists(&ism, scene.lights.len()).into_iter().enumerate() {
                    let (origin, normal) = stand(&scene, light);
                    let wanted: BTreeSet<_> =
                        taken(&choice, light as u32, origin, normal, &clusters).into_iter().collect();
                    let got: BTreeSet<_> = got.into_iter().collect();
                    others += got.symmetric_difference(&wanted).count();
                    all += wanted.len();
                }
                assert!(others * 50 <= all, "{text}: {others} of {all} points are others");
            }
        }
    });
}

/// A light takes at most its number of points, and none twice. A point stands for a share of its cluster: in each cluster, the shares of
/// the taken points add up to the whole cluster or to nothing, and to nothing only if the light sees none of its points.
#[test]
fn lights_take_of_all_that_they_see() {
    gpu_test("ism::lights_take_of_all_that_they_see", |context| {
        for scene in [scenes::soup(), scenes::room()] {
            let sees = |on, far, slide| Culling { on, far, slide };
            for (culling, case) in [
                (sees(true, false, false), "facing=exact"),
                (sees(true, false, true), "facing=slide"),
                (sees(false, false, false), "culling=off"),
                (sees(true, true, false), "culling=far"),
            ] {
                let points = 1024;
                let text = format!("ism:adaptive=on,points={points},path=atomic,{case}");
                let ism = built(context, &scene, &text);
                let pool: Vec<_> = ism.points().expect("the points").1.iter().map(point).collect();
                let mut unseen = 0;
                for (light, list) in lists(&ism, scene.lights.len()).into_iter().enumerate() {
                    assert!(list.len() <= points && !list.is_empty(), "{text}: {} points", list.len());
                    let mut shares = vec![0; pool.len() / CLUSTER];
                    let mut met = BTreeSet::new();
                    for code in list {
                        assert!(met.insert(taken_index(code)), "{text}, light {light}: {code:x} twice");
                        shares[taken_index(code) / CLUSTER] += CLUSTER >> halved(code);
                    }
                    let (origin, normal) = stand(&scene, light);
                    for (share, own) in shares.into_iter().zip(pool.chunks_exact(CLUSTER)) {
                        assert!(share == 0 || share == CLUSTER, "{text}, light {light}: {share} of {CLUSTER}");
                        let seen = own.iter().any(|p| {
                            let offset = [0, 1, 2].map(|i| p.position[i] - origin[i]);
                            is_before(origin, normal, offset) && is_seen(p, normal, offset, culling)
                        });
                        assert!(!seen || share > 0, "{text}, light {light}: nothing of what it sees");
                        unseen += usize::from(share == 0);
                    }
                }
                assert!(unseen > 0, "{text}: lights leave out what they do not see");
            }
        }
    });
}

/// Sheets of the same size in front of a light, one three times as far away: on the axis the near one covers nine times as many texels of
/// the map, and the light takes nine times as many of its points. If both sheets are equally far from the light, the light takes four times
/// as many points from the sheet nearer to the viewer.
#[test]
fn points_follow_what_is_seen() {
    gpu_test("ism::points_follow_what_is_seen", |context| {
        let sheet = |x: f32, z: f32| cuboid([x - 0.1, -0.1, z], [x + 0.1, 0.1, z + 0.001]);
        let counts = |near: [f32; 2], far: [f32; 2], eye: DVec3, target: f64| {
            // Sheets that the light does not see, so that there are points to redistribute.
            let rest = (0..6).map(|i| sheet(i as f32, -2.0));
            let meshes = [sheet(near[0], near[1]), sheet(far[0], far[1])].into_iter().chain(rest).collect();
            let mut scene = scenes::under("sheets", meshes, vec![scenes::light(DVec3::ZERO, DVec3::Z)]);
            scene.camera.position = eye;
            scene.camera.target = eye + target * DVec3::Z;
            let ism = built(context, &scene, "ism:adaptive=on,points=1024,path=atomic");
            let pool = ism.points().expect("the points").1;
            let count = |at: [f32; 2]| {
                let here = |code: &&u32| {
                    let [x, _, z] = pool[taken_index(**code)].position;
                    (x - at[0]).abs() < 0.11 && (z - at[1]).abs() < 0.01
                };
                lists(&ism, 1)[0].iter().filter(here).count() as f64
            };
            (count(near), count(far))
        };
        let (near, far) = counts([0.0, 0.5], [0.0, 1.5], DVec3::new(0.0, 0.0, 1.0), 1.0);
        assert!((6.0..=12.0).contains(&(near / far)), "{near} and {far}");
        let (near, far) = counts([-0.3, 0.3], [0.3, 0.3], DVec3::new(-0.3, 0.0, 0.3), 0.3);
        assert!((3.0..=5.0).contains(&(near / far)), "{near} and {far}");
        let (near, far) = counts([-0.3, 0.3], [0.3, 0.3], DVec3::new(0.0, 0.0, 5.0), 1.0);
        assert!((0.8..=1.25).contains(&(near / far)), "{near} and {far}");
    });
}

/// A light that moves a little takes nearly the same points; one that moves far takes different ones.
#[test]
fn lights_that_move_a_little_take_the_same_points() {
    gpu_test("ism::lights_that_move_a_little_take_the_same_points", |context| {
        let scene = scenes::room();
        let taken = |by: f64| {
            let mut moved = scene.clone();
            for light in &mut moved.lights {
                if let gobo::scene::LightKind::Virtual { position, normal, .. } = &mut light.kind {
                    *position += by * normal.any_orthonormal_vector();
                }
            }
            let ism = built(context, &moved, "ism:adaptive=on,points=2048,path=atomic,size=32");
            let lists = lists(&ism, scene.lights.len());
            lists.into_iter().map(|list| list.into_iter().map(taken_index).collect()).collect::<Vec<BTreeSet<_>>>()
        };
        let (still, little, far) = (taken(0.0), taken(0.004), taken(1.0));
        let kept = |others: &[BTreeSet<usize>]| {
            let both: usize = still.iter().zip(others).map(|(a, b)| a.intersection(b).count()).sum();
            both as f64 / still.iter().map(BTreeSet::len).sum::<usize>() as f64
        };
        println!("a thousandth of the room: {:.3} stay; a quarter: {:.3}", kept(&little), kept(&far));
        assert!(kept(&little) > 0.97, "{} of all stay", kept(&little));
        assert!(kept(&far) < 0.9, "{} of all stay", kept(&far));
    });
}

/// If the meshes have no area, no points are taken; if memory is short, the refusal names what is lacking.
#[test]
fn adaptive_points_need_room() {
    gpu_test("ism::adaptive_points_need_room", |context| {
        let scene = scenes::under("nothing", Vec::new(), scenes::lights(3));
        let ism = built(context, &scene, "ism:adaptive=on,points=1024,path=atomic,size=32");
        assert!(lists(&ism, 3).iter().all(Vec::is_empty));

        let needed = 4 * 2049 * 16384;
        let scene = scenes::under("many", vec![cuboid([0.0; 3], [1.0; 3])], scenes::lights(2049));
        let has = context.features().max_storage_buffer_range;
        match refusal(context, &scene, "ism:adaptive=on,points=16384,path=atomic,size=32") {
            Some(needs) => {
                assert!(has < needed && needs.to_string().contains(&format!("{needed} for adaptive points")), "{needs}")
            }
            None => assert!(has >= needed, "{has}"),
        }
    });
}
