//! What the error depends on.

use crate::ism::answers::{ask_on_surfaces, on_surfaces};
use crate::ism::{built, scenes};
use crate::support::gpu_test;
use gobo::reference::truth::Casters;

/// The error on surfaces, over all points everywhere, falls with more points and with more texels.
#[test]
fn errors_fall_with_points_and_size() {
    gpu_test("ism::errors_fall_with_points_and_size", |context| {
        let scene = scenes::room();
        let casters = Casters::new(&scene);
        let asked: Vec<_> = (0..scene.lights.len()).map(|light| on_surfaces(&casters, &scene, light, 200)).collect();
        let error = |points: u32, size: u32| {
            let text = format!("ism:points={points},size={size},path=atomic,adaptive=on");
            let ism = built(context, &scene, &text);
            let (mut off, mut all) = (0.0, 0);
            for (light, points) in asked.iter().enumerate() {
                for (answer, p) in ask_on_surfaces(context, &ism, light, points).into_iter().zip(points) {
                    off += (f64::from(answer) - casters.visibility(light, p.position)).abs();
                    all += 1;
                }
            }
            println!("{text}: {:.4} of {all}", off / f64::from(all));
            off / f64::from(all)
        };
        let by_points = [1024, 4096, 16384].map(|points| error(points, 64));
        let by_size = [32, 64, 128].map(|size| error(16384, size));
        for errors in [by_points, by_size] {
            assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
        }
    });
}
