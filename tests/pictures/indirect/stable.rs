//! Temporal stability: a light that moves a little moves its virtual lights a little.

use super::made;
use crate::support::gpu_test;
use glam::DVec3;
use gobo::scene::{Light, LightKind, Scene};

fn places(lights: &[Light]) -> Vec<(DVec3, DVec3)> {
    let place = |light: &Light| match light.kind {
        LightKind::Virtual { position, normal, .. } => (position, normal),
        _ => panic!("{light:?}"),
    };
    lights.iter().map(place).collect()
}

/// The room's lamp moves sideways in steps of a hundredth of the room: most virtual lights move by a few such steps, and few jump to
/// another surface or far away.
#[test]
fn a_light_that_moves_a_little_moves_them_a_little() {
    gpu_test("a_light_that_moves_a_little_moves_them_a_little", |context| {
        let mut scene = Scene::load("cornell", 0.0).expect("built in");
        let at = |scene: &Scene| places(&made(context, scene, 1024).read().expect("read"));
        let mut before = at(&scene);
        assert_eq!(at(&scene), before, "nothing has moved");
        for step in [0.002, 0.01, 0.02] {
            let LightKind::Spot { position, .. } = &mut scene.lights[0].kind else { panic!("a spot light") };
            position.x += step;
            let now = at(&scene);
            let mut moved: Vec<f64> = now.iter().zip(&before).map(|(a, b)| a.0.distance(b.0)).collect();
            let turned = now.iter().zip(&before).filter(|(a, b)| a.1.dot(b.1) < 0.9).count();
            moved.sort_by(f64::total_cmp);
            let (median, p90) = (moved[512], moved[921]);
            println!("by {step}: median {median:.4}, p90 {p90:.4}, {turned} on another surface");
            // One of 1,024 patches is about 0.07 wide.
            assert!(median < step + 0.04 && p90 < 0.2 && turned < 60, "{step}: {median} {p90} {turned}");
            before = now;
        }
    });
}
