//! Number of points that each cull removes.

use crate::ism::maps::{points, stand};
use crate::ism::{built, scenes};
use crate::support::{all, gpu_test};
use glam::DVec3;
use gobo::lights::indirect::{VplsBy, lit_by_vpls};
use gobo::reference::truth::Casters;
use gobo::reference::twin::ism::splat::{Culling, Taken, is_before, is_seen};
use gobo::scene::Scene;

/// Point counts, summed over all lights: points taken; of these, points behind the light's plane; of the rest, near sides of closed meshes;
/// of the remainder, points outside the viewer's frustum, and points hidden from the viewer.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    taken: usize,
    behind: usize,
    near_sides: usize,
    out_of_view: usize,
    hidden: usize,
}

impl Counts {
    fn add(&mut self, scene: &Scene, casters: &Casters, light: usize, Taken { point, .. }: &Taken) {
        let (origin, normal) = stand(scene, light);
        let offset = [0, 1, 2].map(|i| point.position[i] - origin[i]);
        self.taken += 1;
        if !is_before(origin, normal, offset) {
            self.behind += 1;
        } else if !is_seen(point, normal, offset, Culling { on: true, far: false, slide: false }) {
            self.near_sides += 1;
        } else {
            let (eye, at) = (scene.camera.position, DVec3::from(point.position.map(f64::from)));
            let forward = (scene.camera.target - eye).normalize();
            let right = forward.cross(scene.camera.up).normalize();
            let way = at - eye;
            let [x, y, z] = [right, right.cross(forward), forward].map(|axis| axis.dot(way));
            let high = z * (scene.camera.fov_y_degrees.to_radians() / 2.0).tan();
            let first = || casters.meshes.hit(eye, way.normalize()).map_or(f64::INFINITY, |hit| hit.distance);
            if z <= 0.0 || y.abs() > high || 9.0 * x.abs() > 16.0 * high {
                self.out_of_view += 1;
            } else if first() < 0.999 * way.length() {
                self.hidden += 1;
            }
        }
    }

    fn seen(&self) -> usize {
        self.taken - self.behind - self.near_sides
    }
}

/// The points that remain are those that the device sees: `culling=off` removes only points behind a light's plane and points that face
/// away from it. If lights choose their points, fewer of these are culled.
#[test]
fn culls_take_what_they_say() {
    gpu_test("ism::culls_take_what_they_say", |context| {
        let lit = |name: &str| {
            lit_by_vpls(context, &Scene::load(name, 0.0).expect("built in"), 64, VplsBy::Flux)
                .expect("its lights shine on meshes")
        };
        let mut cases = vec![scenes::soup(), scenes::room()];
        if all() {
            cases.extend(["cornell", "courtyard", "town"].map(lit));
        }
        for scene in &cases {
            let casters = Casters::new(scene);
            let [even, adaptive] = ["off", "on"].map(|adaptive| {
                let text = |culling: &str| format!("ism:points=8192,adaptive={adaptive},culling={culling},path=atomic");
                let ism = built(context, scene, &text("on"));
                let seen = ism.atlas().seen().expect("counted");
                let mut counts = Counts::default();
                for (light, seen) in seen.iter().enumerate() {
                    let before = counts.seen();
                    points(&ism, light).iter().for_each(|taken| counts.add(scene, &casters, light, taken));
                    let here = counts.seen() - before;
                    assert!(here.abs_diff(*seen as usize) <= 2, "{}, light {light}: {seen}, not {here}", scene.name);
                }
                if adaptive == "off" {
                    let seen: u32 = built(context, scene, &text("off")).atlas().seen().expect("counted").iter().sum();
                    let wanted = counts.taken - counts.behind;
                    assert!(
                        wanted.abs_diff(seen as usize) <= 2 * scene.lights.len(),
                        "{}: {seen}, not {wanted}",
                        scene.name
                    );
                }
                println!("{}, adaptive={adaptive}: {counts:?}", scene.name);
                counts
            });
            let share = |counts: &Counts| counts.seen() as f64 / counts.taken as f64;
            assert!(share(&adaptive) > share(&even), "{}: {adaptive:?}, not {even:?}", scene.name);
        }
    });
}
