//! Seen error: the share of the light in the picture that is wrong.

use crate::bench::case::points::{FULLY_ASKED, at_once};
use crate::bench::case::truth::Points;
use crate::gpu::Context;
use crate::query::Query;
use crate::reference::truth::{Casters, SeenQuery, seen_points, seen_queries};
use crate::scene::{Scene, View};
use crate::technique::Technique;
use crate::world::World;
use crate::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Errors at points from which light comes to the camera. Each light is weighted by the luminance that it would send to the camera from
/// there if nothing blocked it: color, cosine or phase, fall-off and cone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SeenError {
    /// Number of points. With more than eight lights, each point is queried for one light only.
    pub points: u64,
    /// The mean of weight × |answer − truth| over the mean weight: the share of the light in the picture that is wrong.
    pub mean: f64,
    /// The same mean, signed: positive is too bright.
    pub bias: f64,
    /// The 99th percentile of |answer − truth|, weighted.
    pub p99: f64,
    /// Standard error of the mean, as for points drawn at random. The points are spread more evenly than that, so it is an upper bound.
    /// Absent for fewer than two points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
}

impl SeenError {
    /// Formats it as `seen error 0.0123 ± 0.0004`.
    pub fn words(&self) -> String {
        let off = self.standard_error.map(|off| format!(" ± {off:.4}")).unwrap_or_default();
        format!("seen error {:.4}{off}", self.mean)
    }
}

/// Queries for one light, with the truth at their points.
pub(crate) struct SeenGroup {
    pub points: Points,
    /// Index of each query's point among the seen points.
    places: Vec<u32>,
    /// Luminance, per color, that the light would send to the camera.
    weights: Vec<DVec3>,
}

/// The truth at seen points.
#[derive(Default)]
pub(crate) struct SeenTruth {
    /// Number of points.
    count: usize,
    pub groups: Vec<SeenGroup>,
}

/// Answers at the seen points of one or more frames.
#[derive(Default)]
pub(in crate::bench) struct SeenAnswers {
    /// Sums over the queries of each point: weight, weight × |answer − truth|, weight × (answer − truth).
    sums: Vec<[f64; 3]>,
    /// Weight and |answer − truth| of each query.
    all: Vec<(f64, f64)>,
}

impl SeenTruth {
    /// Computes the truth at `count` points that the scene's camera sees.
    pub fn new(casters: &Casters, scene: &Scene, camera: &View, count: usize, seed: u64) -> Self {
        let points = seen_points(casters, scene, camera, count, seed);
        let mut queries = seen_queries(casters, scene, &points, FULLY_ASKED);
        // One list per light, those without normals first: a query has normals at all of its points, or at none.
        queries.sort_by_key(|query| (query.normal.is_some(), query.light, query.point));
        let alike = |a: &SeenQuery, b: &SeenQuery| (a.light, a.normal.is_some()) == (b.light, b.normal.is_some());
        let groups = queries.chunk_by(alike).map(|queries| SeenGroup::of(casters, scene, queries)).collect();
        Self { count: points.len(), groups }
    }

    /// Returns the points in the order in which a technique is queried, group by group.
    fn points(&self) -> impl Iterator<Item = &Points> {
        self.groups.iter().map(|group| &group.points)
    }

    /// Returns the answers of a technique, built for `world`, at all points: one list, or one per color.
    ///
    /// # Errors
    /// [`Error::Gpu`] if memory runs out or the device is lost.
    pub fn ask(&self, context: &Context, world: &World, technique: &dyn Technique) -> Result<Vec<Vec<f32>>> {
        let ask = |extinction: f32| -> Result<Vec<f32>> {
            let (bare, on_meshes): (Vec<&Points>, Vec<&Points>) = self.points().partition(|p| p.normals.is_empty());
            let mut answers = Vec::new();
            for list in [at_once(bare), at_once(on_meshes)].concat() {
                let query = Query::of_lights(context, &list)?;
                query.query(&query.color_kernel(&technique.answer(), extinction)?)?;
                answers.extend(query.answers()?);
            }
            Ok(answers)
        };
        let ratio = world.extinction_ratio();
        // If casters have inks, each light is listed once per color.
        let ratios = if ratio == Scene::GREY || world.colors() > 1 { &ratio[..1] } else { &ratio[..] };
        ratios.iter().map(|ratio| ask(*ratio)).collect()
    }

    /// Returns the error of `answers`, given as [`SeenTruth::ask`] returns them; `None` if no light is sent to the camera.
    ///
    /// # Errors
    /// Fails if an answer is not a number, naming its point.
    pub fn error(&self, answers: &[Vec<f32>]) -> Result<Option<SeenError>> {
        let mut asked = SeenAnswers::default();
        asked.add(self, answers)?;
        Ok(asked.error())
    }

    /// Returns the seen error of a picture without shadows; `None` without points.
    ///
    /// # Errors
    /// Cannot fail in practice, since the answers without shadows are numbers.
    pub fn unshadowed(&self) -> Result<Option<SeenError>> {
        let answer = |points: &Points| -> Vec<f32> {
            // A closed surface that faces away from the sun is dark without any technique.
            let of = |i| if points.normals.get(i) == Some(&[0.0; 3]) { 0.0 } else { 1.0 };
            (0..points.positions.len()).map(of).collect()
        };
        let grey: Vec<f32> = self.points().flat_map(answer).collect();
        self.error(&[grey])
    }
}

impl SeenGroup {
    fn of(casters: &Casters, scene: &Scene, queries: &[SeenQuery]) -> Self {
        let light = queries[0].light;
        let positions: Vec<[f32; 3]> = queries.iter().map(|query| query.position.as_vec3().into()).collect();
        // On a mesh the truth is computed in f64: a rounded point would lie off the surface and shadow itself.
        let place = |query: &SeenQuery| match query.normal {
            Some(_) => query.position,
            None => query.position.as_vec3().as_dvec3(),
        };
        let visibility = queries.par_iter().map(|query| casters.visibility(light, place(query))).collect();
        let is_grey = scene.extinction_ratio == Scene::GREY;
        let colored = if is_grey { &[] } else { queries };
        let colors = colored.par_iter().map(|query| casters.colors(light, place(query)).to_array()).collect();
        let normals = queries.iter().filter_map(|query| query.normal).collect();
        let mut points = Points::in_space(light, positions, visibility);
        (points.colors, points.normals) = (colors, normals);
        Self {
            points,
            places: queries.iter().map(|query| query.point).collect(),
            weights: queries.iter().map(|query| query.weight).collect(),
        }
    }
}

impl SeenAnswers {
    /// Adds the answers to all queries of one frame: one list for all colors, or one per color.
    ///
    /// # Errors
    /// Fails if an answer is not a number, naming its point.
    pub fn add(&mut self, truth: &SeenTruth, answers: &[Vec<f32>]) -> Result<()> {
        let first = self.sums.len();
        self.sums.resize(first + truth.count, [0.0; 3]);
        let mut next = 0;
        for group in &truth.groups {
            for (i, (place, weight)) in group.places.iter().zip(&group.weights).enumerate() {
                let of_color = |color: usize| (answers[color][next], group.points.colors[i][color], weight[color]);
                let all = match answers.len() {
                    1 => vec![(answers[0][next], group.points.visibility[i], weight.element_sum())],
                    _ => (0..3).map(of_color).collect(),
                };
                next += 1;
                for (answer, true_answer, weight) in all {
                    let difference = f64::from(answer) - true_answer;
                    if !difference.is_finite() {
                        let name = format!("visibility of light {} at a seen point", group.points.light);
                        let cause = format!("{answer} where the truth is {true_answer}");
                        return Err(Error::input(name, cause, "report this as a bug, with the scene"));
                    }
                    let sums = &mut self.sums[first + *place as usize];
                    sums[0] += weight;
                    sums[1] += weight * difference.abs();
                    sums[2] += weight * difference;
                    self.all.push((weight, difference.abs()));
                }
            }
        }
        Ok(())
    }

    /// Returns the error over all points; `None` if no light is sent to the camera.
    pub fn error(&self) -> Option<SeenError> {
        let sum = |of: usize| self.sums.iter().map(|sums| sums[of]).sum::<f64>();
        let (weight, count) = (sum(0), self.sums.len() as f64);
        if weight <= 0.0 {
            return None;
        }
        let mean = sum(1) / weight;
        // The variance of a ratio of two means: Cochran, Sampling Techniques, section 6.3.
        let squares: f64 = self.sums.iter().map(|sums| (sums[1] - mean * sums[0]).powi(2)).sum();
        let standard_error = (count > 1.0).then(|| (squares * count / (count - 1.0)).sqrt() / weight);
        Some(SeenError { points: count as u64, mean, bias: sum(2) / weight, p99: self.p99(weight), standard_error })
    }

    fn p99(&self, weight: f64) -> f64 {
        let mut all = self.all.clone();
        all.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
        let mut left = 0.99 * weight;
        let reached = all.iter().find(|(weight, _)| {
            left -= weight;
            left <= 0.0
        });
        reached.or(all.last()).map_or(0.0, |(_, error)| *error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests::{mesh, on_the_axis};
    use crate::scene::{Camera, Light, LightKind, Mesh};

    fn plate(z: f32) -> Mesh {
        let corners = vec![[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]];
        mesh(corners, vec![[0, 1, 2], [0, 2, 3]])
    }

    /// Returns the seen error without shadows, through a window so narrow that all rays follow the axis from z = 10 down.
    fn unshadowed(scene: &Scene, count: usize, seed: u64) -> SeenError {
        let position = DVec3::new(0.0, 0.0, 10.0);
        let camera = Camera { position, target: DVec3::ZERO, up: DVec3::Y, fov_y_degrees: 0.001 };
        let camera = View::camera(&camera, scene, [64, 64]);
        let truth = SeenTruth::new(&Casters::new(scene), scene, &camera, count, seed);
        truth.unshadowed().expect("numbers").expect("points")
    }

    /// Luminance of smoke's albedo.
    const SMOKE: f64 = 0.2126 * 0.92 + 0.7152 * 0.92 + 0.0722 * 0.95;

    /// Returns a sphere of optical depth D in front of a wall, lit from the camera, and its seen error without shadows. At optical depth τ
    /// inside the sphere, 1 − exp(−τ) of the light is wrong; on the wall, 1 − exp(−D).
    fn sphere_before_a_wall() -> (Scene, f64) {
        let mut scene = on_the_axis(&[(0.0, 1.0, 0.5)]);
        scene.meshes = vec![plate(-3.0)];
        let left = (-1.0f64).exp();
        let wrong = SMOKE * ((1.0 - left) - 0.5 * (1.0 - left * left)) + 0.5 * left * (1.0 - left);
        (scene, wrong / (SMOKE * (1.0 - left) + 0.5 * left))
    }

    #[test]
    fn a_sphere_before_a_wall() {
        let (scene, expected) = sphere_before_a_wall();
        let found = unshadowed(&scene, 16384, 0);
        assert!((found.mean - expected).abs() < 1e-3, "{found:?}, not {expected}");
        assert_eq!((found.points, found.mean), (16384, found.bias));
    }

    /// Endless smoke under a light that comes in at a slant of cosine c: at optical depth τ along the camera's ray, the light has passed an
    /// optical depth of τ / c, so 1 / (1 + c) of all light is wrong.
    #[test]
    fn a_slab_under_a_slanted_light() {
        for cosine in [0.9f64, 0.5] {
            let mut scene = on_the_axis(&[(-1000.0, 1000.0, 200.0)]);
            let direction = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, -cosine);
            scene.lights[0].kind = LightKind::Directional { direction };
            let found = unshadowed(&scene, 16384, 0);
            assert!((found.mean - 1.0 / (1.0 + cosine)).abs() < 2e-3, "{found:?}, for {cosine}");
        }
    }

    /// One of two lights is behind a plate. Its share of the light must be the seen error, whatever its radiance. A light that sends no
    /// light to the camera must not change the result.
    #[test]
    fn two_lights_of_which_one_is_dark() {
        let mut scene = on_the_axis(&[]);
        scene.meshes = vec![plate(-3.0), plate(-5.0)];
        let light = |z: f64, radiance: f32| Light {
            kind: LightKind::Directional { direction: DVec3::new(0.0, 0.0, -z) },
            radiance: [radiance; 3],
            radius: f64::INFINITY,
        };
        for radiance in [0.0, 0.5, 3.0] {
            scene.lights = vec![light(1.0, 1.0), light(-1.0, radiance)];
            let expected = f64::from(radiance) / (1.0 + f64::from(radiance));
            let found = unshadowed(&scene, 512, 0);
            assert!((found.mean - expected).abs() < 1e-9, "{found:?}, not {expected}");
        }
    }

    /// Draws points with a hundred seeds. The error of the mean must agree with the stated standard error, which must fall with the square
    /// root of the number of points.
    #[test]
    fn the_standard_error_holds() {
        let (scene, expected) = sphere_before_a_wall();
        let stated = |count: usize| {
            let all: Vec<SeenError> = (0..100).map(|seed| unshadowed(&scene, count, seed)).collect();
            let error = |found: &SeenError| found.standard_error.expect("more than one point");
            let within = |times: f64| all.iter().filter(|e| (e.mean - expected).abs() < times * error(e)).count();
            assert!(within(1.0) >= 68 && within(2.0) >= 95, "{} and {}", within(1.0), within(2.0));
            all.iter().map(error).sum::<f64>() / 100.0
        };
        let [few, many] = [256, 1024].map(stated);
        assert!((few / many - 2.0).abs() < 0.1, "{few} and {many}");
        let means: Vec<f64> = (0..100).map(|seed| unshadowed(&scene, 256, seed).mean).collect();
        let spread = (means.iter().map(|m| (m - expected).powi(2)).sum::<f64>() / 100.0).sqrt();
        assert!(spread > 0.0 && spread < few, "{spread}, and {few} is stated");
    }

    /// The 99th percentile must be weighted: a point with less than a hundredth of the light must not decide it.
    #[test]
    fn percentiles_are_by_weight() {
        let answers = SeenAnswers { sums: vec![[1.0, 0.2, 0.2]; 4], all: vec![(98.5, 0.1), (0.9, 0.9), (0.6, 0.5)] };
        assert_eq!(answers.p99(100.0), 0.5);
        assert_eq!(SeenAnswers::default().error(), None);
    }
}
