//! A camera that orbits its target and flies.

use super::state::State;
use crate::animate::AnimatedScene;
use crate::scene::{Camera, View};
use glam::{DQuat, DVec2, DVec3};

/// Smallest angle between the viewing direction and the up direction, in radians.
const POLE: f64 = 0.02;

/// Returns the scene's camera with the changes made by `state`.
pub fn camera(state: &State, scene: &Camera) -> Camera {
    let position = state.eye.unwrap_or(scene.position);
    Camera { position, target: state.target.unwrap_or(scene.target), ..*scene }
}

/// Orbits the camera around its target by the given angles to the right and up, in radians.
pub fn orbit(state: &mut State, scene: &Camera, right: f64, up: f64) {
    let is = camera(state, scene);
    let offset = is.position - is.target;
    let axis = is.up.normalize();
    // Angle to the up direction after the move, kept away from both poles.
    let angle = offset.angle_between(axis);
    let tilt = (angle - up).clamp(POLE, std::f64::consts::PI - POLE) - angle;
    let side = axis.cross(offset).normalize_or(DVec3::X);
    let turned = DQuat::from_axis_angle(axis, -right) * DQuat::from_axis_angle(side, tilt) * offset;
    state.eye = Some(is.target + turned);
}

/// Multiplies the camera's distance to its target by `factor`.
pub fn zoom(state: &mut State, scene: &Camera, factor: f64) {
    let is = camera(state, scene);
    state.eye = Some(is.target + (is.position - is.target) * factor);
}

/// Moves the camera and its target right, up and forward, in units of the distance between them.
pub fn fly(state: &mut State, scene: &Camera, [right, up, forward]: [f64; 3]) {
    let is = camera(state, scene);
    let offset = is.target - is.position;
    let ahead = offset.normalize_or(DVec3::X);
    let side = ahead.cross(is.up).normalize_or(DVec3::X);
    let way = (side * right + side.cross(ahead) * up + ahead * forward) * offset.length();
    (state.eye, state.target) = (Some(is.position + way), Some(is.target + way));
}

/// Returns the direction in which a key flies, in units of the distance between camera and target.
pub fn way(key: &str) -> Option<[f64; 3]> {
    let step = 0.05;
    match key {
        "w" => Some([0.0, 0.0, step]),
        "s" => Some([0.0, 0.0, -step]),
        "a" => Some([-step, 0.0, 0.0]),
        "d" => Some([step, 0.0, 0.0]),
        "q" => Some([0.0, -step, 0.0]),
        "e" => Some([0.0, step, 0.0]),
        _ => None,
    }
}

/// Returns the position of a fountain's attractor; `None` for any other scene.
pub fn attractor(state: &State, scene: &AnimatedScene) -> Option<DVec3> {
    let fountain = scene.fountain()?;
    let wanders = || DVec3::from(fountain.attractor(fountain.step_at(state.time_s)).map(f64::from));
    Some(state.attractor.unwrap_or_else(wanders))
}

/// Moves the attractor so that it appears at `pixel`, at the same depth as before. Returns whether the scene has an attractor.
pub fn pull(state: &mut State, animated: &AnimatedScene, size: [u32; 2], pixel: [f64; 2]) -> bool {
    let Some(is) = attractor(state, animated) else { return false };
    let scene = &animated.scene;
    let view = View::camera(&camera(state, &scene.camera), scene, size);
    let to = view.ray(DVec2::from(pixel)).at(view.project(is).1);
    // Millimetres are precise enough, and keep commands short.
    state.attractor = Some((to * 1e3).round() / 1e3);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        position: DVec3::new(3.0, -4.0, 2.0),
        target: DVec3::new(0.0, 0.0, 1.0),
        up: DVec3::Z,
        fov_y_degrees: 40.0,
    };

    fn state() -> State {
        State::new("plume_8k", 0.0, None)
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_its_poles() {
        let mut state = state();
        let distance = CAMERA.position.distance(CAMERA.target);
        for (right, up) in [(0.3, 0.0), (0.0, 0.2), (-7.0, 9.0), (1.0, -20.0)] {
            orbit(&mut state, &CAMERA, right, up);
            let is = camera(&state, &CAMERA);
            assert!((is.position.distance(is.target) - distance).abs() < 1e-9);
            assert!((is.position - is.target).cross(is.up).length() > 0.01 * distance, "not along its up");
        }
        assert_eq!(state.target, None, "what it looks at stays");
    }

    /// Orbiting up must move the camera up, and orbiting right must move it right.
    #[test]
    fn an_orbit_goes_where_it_is_sent() {
        let mut state = state();
        orbit(&mut state, &CAMERA, 0.0, 0.1);
        assert!(state.eye.expect("moved").z > CAMERA.position.z);
        let forward = (CAMERA.target - CAMERA.position).normalize();
        let mut state = self::state();
        orbit(&mut state, &CAMERA, -0.1, 0.0);
        assert!((state.eye.expect("moved") - CAMERA.position).dot(forward.cross(CAMERA.up)) > 0.0);
    }

    /// The attractor must appear where it was dropped, as far away as before. In a scene that is not simulated nothing may move.
    #[test]
    fn the_attractor_follows_the_pointer() {
        let animated = AnimatedScene::load("fountain:particles=10", 1.0).expect("built in");
        let mut state = State::new("fountain", 1.0, None);
        let view = View::camera(&animated.scene.camera, &animated.scene, [400, 300]);
        let before = attractor(&state, &animated).expect("wanders");
        assert!(pull(&mut state, &animated, [400, 300], [300.0, 100.0]));
        let (seen, z) = view.project(state.attractor.expect("stands"));
        assert!(seen.distance(DVec2::new(300.0, 100.0)) < 0.1, "{seen}");
        assert!((z - view.project(before).1).abs() < 2e-3, "{z}");
        let plume = AnimatedScene::load("plume_8k", 0.0).expect("built in");
        assert!(!pull(&mut state, &plume, [400, 300], [1.0, 1.0]));
    }

    #[test]
    fn flying_takes_the_target_along() {
        let mut state = state();
        fly(&mut state, &CAMERA, [0.1, -0.2, 0.5]);
        let is = camera(&state, &CAMERA);
        let before = CAMERA.target - CAMERA.position;
        assert!((is.target - is.position - before).length() < 1e-9);
        let way = is.position - CAMERA.position;
        assert!((way.dot(before.normalize()) - 0.5 * before.length()).abs() < 1e-9, "forward is forward");
        assert!(way.dot(before.cross(CAMERA.up)) > 0.0, "and right is right");
        zoom(&mut state, &CAMERA, 0.5);
        let is = camera(&state, &CAMERA);
        assert!((is.position.distance(is.target) - 0.5 * before.length()).abs() < 1e-9);
    }
}
