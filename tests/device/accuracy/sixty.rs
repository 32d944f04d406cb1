//! How well the error over 60 texels represents the error over all of them.

use crate::support::{ask, built, gpu_test, scenes::Random};
use glam::DVec2;
use gobo::reference::truth::{Casters, map_truths};
use gobo::scene::{Scene, View};

/// Sums on smoke by someone else's prototype, f64: mean error over 60 random covered texels of 128², 96 depths each. The texels' mean
/// optical depth was 3.08. (../shared/COMPARATORS.md)
const PROTOTYPE: [(&str, f64); 14] = [
    ("fourier:path=binned,coefficients=7,size=128", 0.0048),
    ("fourier:path=binned,coefficients=15,size=128", 0.0017),
    ("fourier:path=binned,coefficients=7,range=scene,size=128", 0.0164),
    ("fourier:path=binned,coefficients=15,range=scene,size=128", 0.0060),
    ("layers:path=binned,layers=4,size=128", 0.0095),
    ("layers:path=binned,layers=8,size=128", 0.0041),
    ("layers:path=binned,layers=16,size=128", 0.0014),
    ("moments:path=binned,moments=4,overestimation=50,size=128", 0.019),
    ("moments:path=binned,moments=6,overestimation=50,size=128", 0.010),
    ("moments:path=binned,moments=8,overestimation=50,size=128", 0.009),
    ("moments:path=binned,moments=4,overestimation=50,range=scene,size=128", 0.019),
    ("moments:path=binned,moments=6,overestimation=50,range=scene,size=128", 0.010),
    ("moments:path=binned,moments=8,overestimation=50,range=scene,size=128", 0.009),
    ("wavelet:path=binned,rank=3,size=128", 0.0020),
];
const OPTICAL_DEPTH: f64 = 3.08;
const TEXELS: usize = 60;
const DEPTHS: u32 = 96;

/// Number of random draws of 60 texels.
const DRAWS: usize = 20_000;

/// Returns each draw's mean error per texel, and the draw's mean optical depth.
fn draws(texels: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut random = Random::new(60);
    let mut draw = || {
        let drawn = (0..TEXELS).map(|_| texels[random.bits() as usize % texels.len()]);
        drawn.fold([0.0; 2], |sum, texel| [0, 1].map(|i| sum[i] + texel[i] / TEXELS as f64))
    };
    (0..DRAWS).map(|_| draw()).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Prints a table for docs/notebook/all.md.
#[test]
#[ignore = "measures"]
fn sixty_texels_and_all() {
    gpu_test("sixty_texels_and_all", |context| {
        let scene = Scene::load("plume_8k", 0.0).expect("built in");
        let (casters, view) = (Casters::new(&scene), View::volumes(&scene, 128)[0]);
        let truth = map_truths(&casters, &scene, &[view]).remove(0);
        let (mut points, mut visibility, mut optical_depths) = (Vec::new(), Vec::new(), Vec::new());
        for texel in &truth.texels {
            let [x, y] = [texel % view.width, texel / view.width].map(|at| f64::from(at) + 0.5);
            let ray = view.ray(DVec2::new(x, y));
            let curve = casters.true_curve(0, &view, &ray).0;
            for k in 0..DEPTHS {
                let depth = f64::from(k) / f64::from(DEPTHS - 1);
                points.push(ray.at(view.z(depth)).as_vec3().into());
                visibility.push(curve.transmittance(depth));
            }
            optical_depths.push(curve.optical_depth(1.0));
        }
        let segments = truth.segments as f64 / truth.texels.len() as f64;
        let optical_depth = mean(optical_depths.iter().copied());
        println!("{} texels, {segments:.2} segments and {optical_depth:.3} of optical depth each", truth.texels.len());
        println!(
            "| spec | 60 texels of the prototype | all | ratio | 60 of ours, 95 % of draws | as dark as the prototype's | ratio |"
        );
        for (text, prototype) in PROTOTYPE {
            let answers = ask(context, built(context, &scene, text).as_ref(), 0, &points);
            let errors: Vec<f64> =
                answers.iter().zip(&visibility).map(|(answer, truth)| (f64::from(*answer) - truth).abs()).collect();
            let texels: Vec<[f64; 2]> = errors
                .chunks(DEPTHS as usize)
                .zip(&optical_depths)
                .map(|(errors, depth)| [mean(errors.iter().copied()), *depth])
                .collect();
            let all = mean(texels.iter().map(|texel| texel[0]));
            let mut drawn = draws(&texels);
            drawn.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let [low, high] = [0.025, 0.975].map(|share| drawn[(share * DRAWS as f64) as usize][0]);
            let alike: Vec<f64> =
                drawn.iter().filter(|draw| (draw[1] - OPTICAL_DEPTH).abs() < 0.05).map(|draw| draw[0]).collect();
            let (count, alike) = (alike.len(), mean(alike.into_iter()));
            println!(
                "| `{text}` | {prototype} | {all:.5} | {:.2} | {low:.5} to {high:.5} | {alike:.5} ({count}) | {:.2} |",
                all / prototype,
                alike / prototype
            );
        }
    });
}
