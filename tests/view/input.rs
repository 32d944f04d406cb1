//! Keys and mouse.

use crate::*;

/// Returns the numbers of an option in a copied command.
fn option(command: &str, name: &str) -> Option<Vec<f64>> {
    let rest = command.split(&format!(" --{name} ")).nth(1)?;
    rest.split(' ').next()?.split(',').map(|number| number.parse().ok()).collect()
}

/// Keys and mouse must have their documented effects, judged by copied commands, written files, and inaction after the end.
#[test]
fn keys_and_mouse_do_what_they_say() {
    if crate::support::is_costly("keys_and_mouse_do_what_they_say") {
        return;
    }
    let Some(screen) = screen("keys_and_mouse_do_what_they_say") else { return };
    let folder = folder();
    let parts = [
        "key a",
        "key d",
        "key w",
        "key s",
        "key e",
        "key q",
        "key r",
        // Drags over the picture, from left to right; then a drag that starts on the panel, which must not move the camera.
        "move 60 60\npress left\nmove 90 60\nrelease left\nmove 20 20",
        "move 203 60\npress left\nmove 60 60\nrelease left",
        "key r\nmove 60 60\nwheel 2",
        "key r\npress right\nmove 60 84\nrelease right",
        "key r\nkey space\nframes 15\nkey space\nframes 3",
        "frames 6",
        "key v\ngif curve.gif 10",
        "key v\nframes 2",
        "set scene fountain:particles=200\nframes 3\nmove 60 60\npress control\npress left\nmove 90 50\nrelease left\nrelease control",
        "set attractor off\npress left\nmove 80 50\nrelease left",
    ];
    let mut script: String = parts.iter().map(|part| format!("{part}\nkey c\nset gain 8\n")).collect();
    script += "key f12\nkey h\nscreenshot wide.png\nkey escape\nscreenshot never.png\n";
    let script = format!("key c\n{script}");
    let output =
        view(&screen, folder.path(), &[&["plume_8k", "--technique", "avsm:size=32"], &SMALL[..]].concat(), &script);
    let lines = lines(&output);
    let commands: Vec<&String> = lines.iter().filter(|line| line.starts_with("gobo render")).collect();
    assert_eq!(commands.len(), parts.len() + 1, "{lines:#?}");
    let scene = Scene::load("plume_8k", 20.0).expect("built in");
    let own = (scene.camera.position, scene.camera.target);
    let vector = |numbers: Vec<f64>| DVec3::from_slice(&numbers);
    let camera = |i: usize| {
        let read = |name: &str, own: DVec3| option(commands[i], name).map_or(own, vector);
        (read("eye", own.0), read("target", own.1))
    };
    let distance = own.0.distance(own.1);
    let ahead = (own.1 - own.0) / distance;
    let side = ahead.cross(scene.camera.up).normalize();
    let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-6 * distance;
    // Keys must move both eye and target, and back again.
    for (i, way) in [(1, -side), (3, ahead), (5, side.cross(ahead))] {
        let ((eye, target), (eye_back, target_back)) = (camera(i), camera(i + 1));
        let step = 0.05 * distance * way;
        assert!(near(eye, own.0 + step) && near(target, own.1 + step), "{}", commands[i]);
        assert!(near(eye_back, own.0) && near(target_back, own.1), "{}", commands[i + 1]);
    }
    assert!(option(commands[6], "eye").is_some() && option(commands[7], "eye").is_none(), "r: the scene's own camera");
    // Dragging by 30 of 120 pixels must turn the camera by a radian.
    let (eye, target) = camera(8);
    let flat = |v: DVec3| v.reject_from(scene.camera.up.normalize());
    let turned = flat(eye - target).angle_between(flat(own.0 - own.1));
    assert!(
        near(target, own.1) && (eye.distance(target) - distance).abs() < 1e-6 && (turned - 1.0).abs() < 1e-6,
        "{turned}"
    );
    assert_eq!(commands[9], commands[8], "from the panel nothing turns");
    assert!(near(camera(10).0, own.1 + 0.81 * (own.0 - own.1)), "two lines of the wheel: {}", commands[10]);
    let moved = camera(11).1 - own.1;
    assert!((moved.length() - 0.2 * distance).abs() < 1e-6 && near(camera(11).0 - own.0, moved), "{}", commands[11]);
    let time = |i: usize| option(commands[i], "time").expect("a time")[0];
    assert!(time(12) >= 20.0 + 15.0 / 30.0 - 1e-9 && time(13) == time(12), "space: {} {}", time(12), time(13));
    // Each curve's command must follow that of its picture.
    let curves: Vec<bool> =
        lines.iter().filter(|line| line.starts_with("gobo ")).map(|line| line.starts_with("gobo curve")).collect();
    assert_eq!((curves.iter().filter(|is| **is).count(), curves[15]), (1, true), "v: {lines:#?}");
    assert!(option(commands[16], "attractor").is_some() && option(commands[16], "eye").is_none(), "{}", commands[16]);
    assert!(option(commands[17], "attractor").is_none() && option(commands[17], "eye").is_some(), "{}", commands[17]);
    assert_eq!(pixels(&folder.path().join("gobo-view-00.png")).0, [200, 120]);
    assert!(pixels(&folder.path().join("wide.png")).0[0] > 500, "h: the picture has the panel's place");
    assert!(!folder.path().join("never.png").exists(), "escape");
}
