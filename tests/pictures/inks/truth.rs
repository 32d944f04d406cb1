//! The truth for each color of light, and closed forms for all techniques.

use super::{Both, all_kinds, points, smoke};
use crate::support::{ask, built, gpu_test, scenes, those_that_run};
use glam::{DVec2, DVec3};
use gobo::reference::truth::Casters;
use gobo::scene::{ExtinctionGroup, Particle, Scene, Strand, View};

/// The truth of each color equals the truth of the grey scene scaled by hand, for points and for texels.
#[test]
fn the_truth_is_that_of_scenes_made_by_hand() {
    let mut scene = all_kinds();
    scene.lights.extend(smoke().lights.into_iter().skip(1));
    let both = Both::of(scene, 4);
    let casters = Casters::new(&both.inks);
    let points = points(3, 300);
    for (color, grey) in both.grey.iter().enumerate() {
        let by_hand = Casters::new(grey);
        let mut dark = 0;
        for light in 0..both.lights {
            for point in &points {
                let at = DVec3::from(point.map(f64::from));
                let (found, expected) =
                    (casters.visibility(color * both.lights + light, at), by_hand.visibility(light, at));
                // Extinctions and opacities scaled by hand are rounded to f32.
                assert!(
                    (found - expected).abs() < 2e-6,
                    "color {color}, light {light}, {point:?}: {found}, {expected}"
                );
                dark += usize::from(expected < 0.5);
            }
        }
        assert!(dark > 50, "{dark} points");
        let views = View::volumes(grey, 16);
        let [found, expected] = [(&casters, &both.inks, color * views.len()), (&by_hand, grey, 0)].map(|all| {
            let (casters, _, first) = all;
            let of = |(map, view): (usize, &View)| {
                let ray = view.ray(DVec2::new(8.5, 8.5));
                let (curve, met) = casters.true_curve(first + map, view, &ray);
                (0..8).map(|i| curve.transmittance(f64::from(i) / 7.0)).chain([f64::from(met)]).collect::<Vec<_>>()
            };
            views.iter().enumerate().flat_map(of).collect::<Vec<_>>()
        });
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 2e-6),
            "color {color}: {found:?}, {expected:?}"
        );
    }
}

/// Two balls of ink, one above the other: below both balls the transmittance of each color is exp(−(a + b)).
pub fn two_balls() -> Scene {
    let ball = |z: f32, extinction| Particle { position: [0.0, 0.0, z], radius: 0.5, extinction };
    let scene = scenes::directional("balls", [0.0, 0.0, -1.0], vec![ball(0.6, 1.0), ball(-0.6, 2.0)]);
    let inks = [
        ExtinctionGroup { casters: 1, ratio: [1.0, 0.3, 0.0] },
        ExtinctionGroup { casters: 1, ratio: [0.1, 0.5, 1.0] },
    ];
    scene.with_inks(&inks).expect("inks")
}

#[test]
fn two_inks_over_each_other_are_a_closed_form() {
    let test = "two_inks_over_each_other_are_a_closed_form";
    gpu_test(test, |context| {
        let scene = two_balls();
        let casters = Casters::new(&scene);
        let places = [(0.01f32, 0.02f32), (-0.1, 0.05), (0.2, -0.1)];
        let expected = |color: usize, (x, y): (f32, f32), upper_alone: bool| {
            let chord = 2.0 * (0.25 - f64::from(x).powi(2) - f64::from(y).powi(2)).sqrt();
            let [a, b] = [[1.0, 0.3, 0.0], [0.2, 1.0, 2.0]].map(|k: [f64; 3]| k[color]);
            (-chord * if upper_alone { a } else { a + b }).exp()
        };
        let texts = ["uncompressed:size=256", "avsm:path=binned,nodes=16,size=256", "layers:size=256"];
        for text in those_that_run(test, context, texts) {
            let technique = built(context, &scene, text);
            for color in 0..3 {
                for (z, upper_alone) in [(0.0, true), (-1.5, false)] {
                    let below = places.map(|(x, y)| [x, y, z]);
                    for (place, found) in places.iter().zip(ask(context, technique.as_ref(), color, &below)) {
                        let expected = expected(color, *place, upper_alone);
                        let wrong = (f64::from(found) - expected).abs();
                        assert!(wrong < 3e-3, "{text}, color {color} at {place:?}, {z}: {found}, not {expected}");
                        let at = DVec3::new(place.0.into(), place.1.into(), z.into());
                        assert!((casters.visibility(color, at) - expected).abs() < 1e-6, "the truth");
                    }
                }
            }
        }
    });
}

/// A strand's optical depth scales with its ink's ratio, same as any caster's.
#[test]
fn a_strand_has_an_extinction_for_each_color() {
    let strand = Strand { start: [0.0; 3], radius: 0.1, end: [1.0, 0.0, 0.0], opacity: 0.75 };
    let mut scene = scenes::directional("strands", [0.0, 0.0, -1.0], Vec::new());
    scene.strands = vec![strand, strand];
    let inks = [
        ExtinctionGroup { casters: 1, ratio: [1.0, 0.5, 0.0] },
        ExtinctionGroup { casters: 1, ratio: [0.5, 0.5, 1.0] },
    ];
    let scene = scene.with_inks(&inks).expect("inks");
    let casters = Casters::new(&scene);
    let left = [0, 1, 2].map(|color| casters.visibility(color, DVec3::new(0.5, 0.0, -1.0)));
    // 0.25^(1 + 0.5), 0.25^(0.5 + 0.5) and 0.25^(0 + 1).
    for (found, expected) in left.into_iter().zip([0.125, 0.25, 0.25]) {
        assert!((found - expected).abs() < 1e-6, "{left:?}");
    }
}
