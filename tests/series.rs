//! Techniques of sums a texel, Fourier series, moments and wavelets: figures of their twins.

#![cfg(feature = "program")]

use gobo::reference::truth::{Casters, MAP_DEPTHS, sample_maps};
use gobo::reference::twin::moments::Basis;
use gobo::reference::twin::segment::{Segment, texel_segment};
use gobo::reference::twin::{fourier, moments, wavelet};
use gobo::scene::View;

fn figures(name: &str, size: u32) {
    let scene = support_scene(name);
    let views = View::volumes(&scene, size);
    let casters = Casters::new(&scene);
    let all = scene.casters();
    let (truths, _) = sample_maps(&casters, &scene, &views, 300);
    let mut rays: Vec<(Vec<Segment>, Vec<(f32, f64)>)> = vec![];
    for truth in &truths {
        let view = views[truth.map];
        for (i, texel) in truth.texels.iter().enumerate() {
            let at = [texel % view.width, texel / view.width];
            let segments: Vec<_> =
                all.iter().filter_map(|c| texel_segment(&view, at, c)).filter(|s| s.optical_depth > 0.0).collect();
            let n = MAP_DEPTHS as usize;
            let points: Vec<_> = (i * n..(i + 1) * n)
                .map(|j| {
                    let p = truth.points[j].map(f64::from);
                    (view.depth(view.project(p.into()).1) as f32, truth.visibility[j])
                })
                .collect();
            rays.push((segments, points));
        }
    }
    println!("{name} {size}: {} rays", rays.len());
    let mean = |what: &str, decode: &dyn Fn(&[Segment]) -> Box<dyn Fn(f32) -> f32>| {
        let (mut sum, mut bias, mut count, mut most, mut rise) = (0.0, 0.0, 0, 0f64, 0f32);
        for (segments, points) in &rays {
            let f = decode(segments);
            let mut last = 1f32;
            for (depth, truth) in points {
                let t = (-f(*depth)).exp();
                assert!(t.is_finite());
                rise = rise.max(t - last);
                last = t;
                let off = f64::from(t) - truth;
                sum += off.abs();
                bias += off;
                most = most.max(off.abs());
                count += 1;
            }
        }
        println!(
            "{what}: mean {:.5} bias {:.5} max {most:.3} rise {rise:.1e}",
            sum / f64::from(count),
            bias / f64::from(count)
        );
    };
    let range = |s: &[Segment], whole: bool| {
        if whole {
            [0.0, 1.0]
        } else {
            [s.iter().map(|s| s.entry).fold(1.0, f32::min), s.iter().map(|s| s.exit).fold(0.0, f32::max)]
        }
    };
    let share = |z: f32, [f, b]: [f32; 2]| if b > f { ((z - f) / (b - f)).clamp(0.0, 1.0) } else { 0.0 };
    for whole in [false, true] {
        for k in [7u32, 15, 31] {
            for margin in [0.0f32, 0.01, 0.02] {
                let inside = move |z: f32| margin + (1.0 - 2.0 * margin) * z;
                mean(&format!("fourier {k} whole={whole} margin {margin}"), &|s| {
                    let r = range(s, whole);
                    let mut sums = vec![0.0; k as usize];
                    s.iter().for_each(|s| {
                        fourier::parts([inside(share(s.entry, r)), inside(share(s.exit, r))], s.optical_depth, k)
                            .iter()
                            .zip(&mut sums)
                            .for_each(|(v, s)| *s += v)
                    });
                    Box::new(move |z| {
                        if z >= r[1] {
                            sums[0]
                        } else if z <= r[0] {
                            0.0
                        } else {
                            fourier::optical_depth(&sums, inside(share(z, r)))
                        }
                    })
                });
            }
        }
        for rank in [2usize, 3, 4] {
            mean(&format!("wavelet {rank} whole={whole}"), &|s| {
                let r = range(s, whole);
                let mut sums = vec![0.0; (2 << rank) + 1];
                s.iter().for_each(|s| {
                    wavelet::parts([share(s.entry, r), share(s.exit, r)], s.optical_depth, 2 << rank)
                        .iter()
                        .zip(&mut sums)
                        .for_each(|(v, s)| *s += v)
                });
                Box::new(move |z| {
                    if z >= r[1] {
                        *sums.last().unwrap()
                    } else if z <= r[0] {
                        0.0
                    } else {
                        wavelet::optical_depth(&sums, share(z, r))
                    }
                })
            });
        }
        for basis in [Basis::Power, Basis::Trigonometric] {
            for m in [4u32, 6, 8] {
                for (beta, over) in [(1e-5f32, 0.3), (1e-5, 0.35), (1e-5, 0.4), (1e-5, 0.45), (1e-5, 0.5), (3e-4, 0.4)]
                {
                    mean(&format!("moments {basis:?} {m} whole={whole} bias {beta} over {over}"), &|s| {
                        let r = range(s, whole);
                        let mut sums = vec![0.0; m as usize + 1];
                        s.iter().for_each(|s| {
                            moments::parts([share(s.entry, r), share(s.exit, r)], s.optical_depth, basis, m)
                                .iter()
                                .zip(&mut sums)
                                .for_each(|(v, s)| *s += v)
                        });
                        let total = sums[0];
                        let mut means: Vec<f32> = sums.iter().map(|b| (1.0 - beta) * b / total).collect();
                        means[0] = 1.0;
                        Box::new(move |z| {
                            if z >= r[1] {
                                total
                            } else if z <= r[0] {
                                0.0
                            } else {
                                total * moments::share(&means, basis, over, share(z, r))
                            }
                        })
                    });
                }
            }
        }
    }
}

fn support_scene(name: &str) -> gobo::scene::Scene {
    println!("{name}");
    gobo::scene::Scene::load(name, if name == "hair" { 20.0 } else { 1.0 }).expect("built in")
}

#[test]
fn prototype() {
    let scene = std::env::var("SCENE").unwrap_or("plume_8k".into());
    figures(&scene, 64);
}
