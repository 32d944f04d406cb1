//! Receivers: flat ones do not shadow themselves, at any angle, and objects on them still cast shadows.

use crate::support::{gpu_test, is_usual, scenes::Random, some};
use crate::voxelized::{PLAIN, Settings, baked, shapes};
use gobo::gpu::Context;
use gobo::query::{PointBatch, Query};
use gobo::reference::truth::{Casters, SurfacePoint, surface_points};
use gobo::scene::{Scene, View};
use gobo::technique::{Coverage, Opened, Technique, Voxelized};

/// Returns the look-ups at points of surfaces that face `normal`.
fn ask(context: &Context, opened: &Opened<Voxelized>, points: &[[f32; 3]], normal: [f32; 3]) -> Vec<f32> {
    let normals = vec![normal; points.len()];
    let query = Query::of_lights(context, &[PointBatch { light: 0, points, normals: &normals }]).expect("room");
    query.ask(&opened.technique.answer()).expect("asked")
}

/// Error bound for the rounding of a depth and a position, in voxels. Twin: ROUNDING in glsl/technique/voxelized/visibility.glsl.
const ROUNDING: f64 = 1.0 / 32.0;

/// Light directions from overhead to 3° above the plane.
const LIGHTS: [[f64; 3]; 5] =
    [[0.0, 0.0, -1.0], [0.4, 0.35, -0.8], [1.0, 1.0, -0.7], [1.0, 0.4, -0.15], [1.0, 0.2, -0.06]];

/// A plane of two triangles or many, and the top of a closed slab, at every angle, size, filter and coverage: no point is shadowed.
#[test]
fn a_flat_receiver_never_shadows_itself() {
    gpu_test("a_flat_receiver_never_shadows_itself", |context| {
        let mut random = Random::new(6);
        let scenes = |light| [shapes::flat(light, false), shapes::flat(light, true), shapes::tessellated(light)];
        let all = LIGHTS.into_iter().flat_map(|light| scenes(light).map(|scene| (light, scene)));
        for ((direction, scene), coverage) in
            all.flat_map(|all| [(all.clone(), Coverage::Middle), (all, Coverage::Conservative)])
        {
            for (size, filter) in some([(64, 1), (512, 9), (1024, 1), (256, 5)], if is_usual() { 1 } else { 2 }) {
                let opened = baked(context, &scene, Settings { size, filter, coverage, keep_columns: false, ..PLAIN });
                let points: Vec<_> =
                    (0..4000).map(|_| [random.between(-0.95, 0.95), random.between(-0.95, 0.95), 0.0]).collect();
                let answers = ask(context, &opened, &points, [0.0, 0.0, 1.0]);
                let shadowed = answers.iter().filter(|answer| **answer < 1.0).count();
                let what = format!("{}, light {direction:?}, size {size}, filter {filter}, {coverage:?}", scene.name);
                assert_eq!(shadowed, 0, "{what}");
            }
        }
    });
}

/// Surfaces facing away from the sun are dark, even near the rim of their mesh, where columns miss it. Queried as if they faced the sun,
/// some would leak.
#[test]
fn what_looks_away_is_dark() {
    gpu_test("what_looks_away_is_dark", |context| {
        let scene = shapes::houses();
        let (casters, camera) = (Casters::new(&scene), View::camera(&scene.camera, &scene, [64, 64]));
        let away = |p: &SurfacePoint| p.looks_away(&scene.lights[0]);
        let points: Vec<_> = surface_points(&casters, &scene, 0, &camera, 4000).into_iter().filter(away).collect();
        let positions: Vec<[f32; 3]> = points.iter().map(|p| p.position.as_vec3().into()).collect();
        let opened = baked(context, &scene, PLAIN);
        let lit = |normals: Vec<[f32; 3]>| {
            let asked = PointBatch { light: 0, points: &positions, normals: &normals };
            let query = Query::of_lights(context, &[asked]).expect("room");
            let answers = query.ask(&opened.technique.answer()).expect("asked");
            answers.into_iter().filter(|answer| *answer > 0.0).count()
        };
        let facing = lit(points.iter().map(|p| p.normal.as_vec3().into()).collect());
        let asked = lit(points.iter().map(|p| p.asked(&scene.lights[0])).collect());
        println!("of {} points that look away {facing} leak by their columns, {asked} as they are asked", points.len());
        assert!(asked == 0 && facing > 20 && points.len() > 200, "{facing} and {asked} of {}", points.len());
    });
}

/// A thin wall eight voxels high on a plane, under light at 45 degrees with a shadow of equal length: behind its foot, no more ground is
/// lit than rounding explains. In voxels, across the light u = (x + z) / √2 and along it w = (x − z) / √2, the wall's depth is −u; a point
/// at x, moved by any distance along the normal, still has w + u = √2 x. Its column's centre is up to half a voxel nearer to the foot,
/// where the wall is half a voxel deeper, and that depth is rounded to a voxel: lit only if √2 x < ½ + ½. With conservative coverage the
/// wall's depth is the least in the column: √2 x < ½.
#[test]
fn contact_shadows_are_kept() {
    gpu_test("contact_shadows_are_kept", |context| {
        let size = 256;
        let scene: Scene = shapes::wall(8.0);
        for coverage in [Coverage::Middle, Coverage::Conservative] {
            let opened = baked(context, &scene, Settings { size, coverage, keep_columns: false, ..PLAIN });
            let tree = opened.technique.trees().expect("read")[0];
            let voxels = f64::from(tree.right.iter().map(|v| v * v).sum::<f32>()).sqrt();
            let mut random = Random::new(7);
            let mut lost = 0.0f64;
            let mut far = 0;
            for _ in 0..4 {
                let points: Vec<_> = (0..4000)
                    .map(|_| [random.between(0.0, (7.0 / voxels) as f32), random.between(-0.8, 0.8), 0.0])
                    .collect();
                for (point, answer) in points.iter().zip(ask(context, &opened, &points, [0.0, 0.0, 1.0])) {
                    let away = f64::from(point[0]) * voxels;
                    if answer > 0.5 {
                        lost = lost.max(away);
                    }
                    far += usize::from(away > 2.0);
                }
            }
            println!("{coverage:?}: contact is lost up to {lost:.2} voxels from the wall");
            assert!(far > 8000, "{far} points away from the wall");
            let rounded = if coverage == Coverage::Middle { 1.0 } else { 0.5 };
            let most = (rounded + ROUNDING) / 2f64.sqrt();
            assert!(lost < most, "{coverage:?}: the ground is lit {lost} voxels behind the wall, not {most}");
        }
    });
}
