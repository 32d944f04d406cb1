//! Where a volume's shadow meets the ground, any error comes from the ground's map, not from the volume.

use crate::support::{ask, built, gpu_test};
use crate::volumes::left_by_cells;
use glam::DVec3;
use gobo::reference::truth::{Casters, sample_maps};
use gobo::scene::{Scene, View};

/// At texel centres, `uncompressed` equals the cells' transmittance up to rounding, and below the ground it is zero. But the ground's depth
/// is only as precise as its map: within the height that the ground rises across a look-up's footprint, above or below it, either value is
/// possible.
#[test]
fn volumes_over_a_ground_are_wrong_at_it_alone() {
    gpu_test("volumes_over_a_ground_are_wrong_at_it_alone", |context| {
        let scene = Scene::load("cloud:samples=24", 0.0).expect("built in");
        let casters = Casters::new(&scene);
        let technique = built(context, &scene, "uncompressed:size=128");
        let views: Vec<View> = technique.inspect().maps().iter().map(|map| map.caster_view).collect();
        let truth = sample_maps(&casters, &scene, &views, 1500).0.remove(0);
        let answers = ask(context, technique.as_ref(), 0, &truth.points);
        let opaque = technique.inspect().maps()[0].opaque;
        let texel = 2.0 / f64::from(opaque.scale_x.abs().min(opaque.scale_y.abs())) / f64::from(opaque.width);
        // A texel to each side for the bilinear filter, plus a 16th, to which corners are rounded (truth.md), along the diagonal.
        // Perpendicular to the light's rays the ground rises by the tangent; the height is that times the cosine.
        let sine = scene.lights[0].towards(DVec3::ZERO).truncate().length();
        let reach = (1.0 + 1.0 / 16.0) * 2f64.sqrt() * texel * sine;
        let (mut near, mut above, mut below) = (0.0f64, Vec::new(), 0.0f32);
        for (i, (point, answer)) in truth.points.iter().zip(&answers).enumerate() {
            let height = f64::from(point[2]);
            match () {
                () if height.abs() <= reach => near = near.max((f64::from(*answer) - truth.visibility[i]).abs()),
                () if height < 0.0 => below = below.max(*answer),
                () if i % 16 == 0 => above.push((*point, f64::from(*answer))),
                () => {}
            }
        }
        let (points, found): (Vec<_>, Vec<_>) = above.into_iter().unzip();
        let apart = left_by_cells(&scene, &points).into_iter().zip(found).map(|(a, b)| (a - b).abs());
        let most = apart.fold(0.0, f64::max);
        println!("within {reach:.4} of the ground {near:.3}; above {most:.1e} from what cells leave, below {below}");
        assert!(near > 0.3, "points at the ground are among them: {near}");
        assert!(most < 2e-3 && below == 0.0, "{most} above, {below} below");
    });
}
