//! Scene files: valid ones must load, others must be refused.

use crate::scene::*;
use gobo::animate::AnimatedScene;
use gobo::scene::{ExtinctionGroup, LightKind, Particle, Scene};

#[test]
fn files_that_are_not_files_are_refused() {
    let scene = |file: &str| scene_file(&format!("[[particles]]\nfile = {file:?}\n{LIGHT}{CAMERA}"));
    message(scene("absent.ply"), "absent.ply, which ", "scene.toml names: No such file");
    // Tests every kind of entry with every kind of file.
    for entry in ["particles", "hair", "splats", "volumes", "meshes"] {
        for file in ["absent.ply", "absent.hair", "absent.nrrd", "absent-##.vdb"] {
            let told =
                scene_file(&format!("[[{entry}]]\nfile = {file:?}\n{LIGHT}{CAMERA}")).expect_err("absent").to_string();
            assert!(told.contains(file) && told.contains("scene.toml"), "{entry}: {told}");
        }
    }
    message(scene("."), "not a regular file", "give a file");
    message(Scene::load("/nowhere/absent.toml", 0.0), "/nowhere/absent.toml", "No such file");
    message(Scene::load("unknown", 0.0), "unknown", "three-emitters");
    #[cfg(unix)]
    message(scene("/dev/zero"), "/dev/zero", "not a regular file");
}

#[test]
fn scene_files_place_their_casters() {
    let text = format!(
        "[[particles]]\nfile = \"smoke.ply\"\n[[particles]]\nfile = \"smoke.ply\"\nscale = 2.0\ntranslate = [1, 0.0, 0.0]\n\
         [[meshes]]\nfile = \"tri.ply\"\nscale = 3\ntranslate = [0.0, 0.0, 1.0]\nalbedo = [0.1, 0.2, 0.3]\n\
         [light]\nkind = \"spot\"\nposition = [0.0, 0.0, 9.0]\ntarget = [0.0, 0.0, 1.0]\ncone_degrees = 60\nradiance = [1, 2, 3]\n{CAMERA}"
    );
    let scene = scene_file(&text).expect("a scene");
    assert_eq!(scene.name, "scene");
    let first = Particle { position: [1.0, 2.0, 3.0], radius: 0.5, extinction: 0.8 };
    let second = Particle { position: [3.0, 4.0, 6.0], radius: 1.0, extinction: 0.4 };
    assert_eq!(scene.particles, [first, second]);
    assert_eq!(scene.meshes[0].positions[4], [1.5, 1.5, 4.0]);
    assert_eq!(scene.meshes[0].albedo, [0.1, 0.2, 0.3]);
    assert!(!scene.meshes[0].solid);
    let solid = scene_file(&text.replace("albedo = ", "solid = true\nalbedo = ")).expect("a scene");
    assert!(solid.meshes[0].solid);
    assert_eq!(scene.lights[0].radiance, [1.0, 2.0, 3.0]);
    let LightKind::Spot { direction, cone_degrees, .. } = scene.lights[0].kind else { panic!("a spot light") };
    assert_eq!((direction.to_array(), cone_degrees), ([0.0, 0.0, -1.0], 60.0));

    // A quarter turn about z maps (x, y) to (-y, x), before the translation.
    let turned = text.replace("scale = ", "rotate = [0.0, 0.0, 2.0, 90.0]\nscale = ");
    let turned = scene_file(&turned).expect("turned");
    assert_eq!(turned.particles[0], first);
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(turned.particles[1].position, [-3.0, 2.0, 6.0]), "{:?}", turned.particles[1]);
    assert!(near(turned.meshes[0].positions[4], [-1.5, 1.5, 4.0]), "{:?}", turned.meshes[0].positions[4]);
    for axis in ["[0, 0, 0, 90]", "[0, 0, 1, inf]", "[nan, 0, 1, 90]"] {
        message(scene_file(&text.replace("scale = 3", &format!("rotate = {axis}"))), "scene.toml", "rotate");
    }

    let scene = scene_file(&format!("[[particles]]\nfile = \"smoke.ply\"\n{LIGHT}{CAMERA}")).expect("a scene");
    let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("a directional light") };
    assert_eq!((direction.to_array(), scene.lights[0].radiance), ([0.0, 0.0, -1.0], [1.0; 3]));
    assert_eq!(scene.map_count(), 1);
}

#[test]
fn scene_files_have_several_lights() {
    let light = |kind: &str, keys: &str| format!("[[light]]\nkind = \"{kind}\"\n{keys}\n");
    let text = [
        "[[particles]]\nfile = \"smoke.ply\"\n".to_owned(),
        light("directional", "direction = [0, 0, -3]"),
        light("point", "position = [1, 2, 3]\nradiance = [0.5, 0, 0]\nradius = 2"),
        light("spot", "position = [0, 0, 9]\ntarget = [0, 0, 1]\ncone_degrees = 60"),
        CAMERA.to_owned(),
    ];
    let scene = scene_file(&text.concat()).expect("a scene");
    let [directional, point, spot] = &scene.lights[..] else { panic!("three lights: {:?}", scene.lights) };
    assert!(matches!(directional.kind, LightKind::Directional { .. }));
    assert_eq!(point.kind, LightKind::Point { position: [1.0, 2.0, 3.0].into() });
    assert_eq!((point.radiance, point.radius, directional.radius), ([0.5, 0.0, 0.0], 2.0, f64::INFINITY));
    assert!(matches!(spot.kind, LightKind::Spot { .. }));
    assert_eq!([0, 1, 2, 3].map(|light| scene.first_map(light)), [0, 1, 7, 8]);

    // A single point light as a table.
    let one = text.concat().replace(&text[1], "").replace(&text[3], "").replace("[[light]]", "[light]");
    assert_eq!(scene_file(&one).expect("a scene").lights, [*point]);
    for (from, to, words) in [
        ("kind = \"point\"", "kind = \"point\"\ndirection = [0, 0, 1]", "unknown field `direction`"),
        ("position = [1, 2, 3]", "position = [1, nan, 3]", "not finite"),
        ("position = [1, 2, 3]\n", "", "missing field `position`"),
        ("radius = 2", "radius = 0", "light radius 0 is not greater than 0"),
        ("radius = 2", "radius = nan", "not greater than 0"),
        ("kind = \"point\"", "kind = \"area\"", "area"),
        ("cone_degrees = 60", "cone_degrees = 180", "[1e-6, 170]"),
        ("[[light]]", "[[lights]]", "unknown field `lights`"),
    ] {
        let broken = text.concat().replace(from, to);
        assert_ne!(broken, text.concat());
        message(scene_file(&broken), "scene.toml", words);
    }
    let none = format!("light = []\n{}{CAMERA}", text[0]);
    message(scene_file(&none), "scene.toml", "no light");
    message(scene_file(&none.replace("light = []", "light = 3")), "scene.toml", "[light] or [[light]]");
}

#[test]
fn scene_files_have_a_color() {
    let text = format!("[[particles]]\nfile = \"smoke.ply\"\n{LIGHT}{CAMERA}");
    assert_eq!(scene_file(&text).expect("a scene").extinction_ratio, Scene::GREY);
    let with = |values: &str| scene_file(&format!("{text}[color]\n{values}\n"));
    assert_eq!(with("extinction = [1.0, 0.5, 0]").expect("a scene").extinction_ratio, [1.0, 0.5, 0.0]);
    for (values, words) in [
        ("extinction = [0, 0.0, 0]", "0 in every color"),
        ("extinction = [1e-60, 0, 0]", "0 in every color"),
        ("extinction = [1, -0.1, 1]", "not finite and at least 0"),
        ("extinction = [1, nan, 1]", "not finite"),
        ("extinction = [inf, 1, 1]", "not finite"),
        ("extinction = [1e39, 1, 1]", "not finite"),
        ("extinction = [1, 1]", "line"),
        ("extinction = 1", "line"),
        ("", "missing field `extinction`"),
        ("absorption = [1, 1, 1]", "unknown field `absorption`"),
    ] {
        message(with(values), "scene.toml", words);
    }
    // Animated scenes, and scenes read at another time, must keep it.
    let scene = AnimatedScene::from(with("extinction = [1, 0.5, 0.25]").expect("a scene"));
    assert_eq!(scene.at(3.0).expect("in range").extinction_ratio, scene.scene.extinction_ratio);
}

#[test]
fn scene_files_have_several_inks() {
    let entry = |ratio: &str| format!("[[particles]]\nfile = \"smoke.ply\"\n{ratio}\n");
    let light = LIGHT.replace("[light]\n", "[light]\nradiance = [1, 2, 3]\n");
    let with = |ratios: &[&str], more: &str| {
        let entries: String = ratios.iter().map(|ratio| entry(ratio)).collect();
        scene_file(&format!("{entries}{light}{CAMERA}{more}"))
    };
    let red = "extinction_ratio = [0.5, 1, 1]";
    let scene = with(&[red, ""], "").expect("a scene");
    let count = scene.particles.len() / 2;
    let inks = [
        ExtinctionGroup { casters: count, ratio: [0.5, 1.0, 1.0] },
        ExtinctionGroup { casters: count, ratio: Scene::GREY },
    ];
    assert_eq!((&scene.inks[..], scene.extinction_ratio), (&inks[..], Scene::GREY));
    let radiances: Vec<_> = scene.lights.iter().map(|light| light.radiance).collect();
    assert_eq!(radiances, [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]);
    // Entries without their own ratio use that of [color]; if all agree, the scene has it.
    let color = "[color]\nextinction = [1, 0.5, 0.25]\n";
    assert_eq!(with(&[red, ""], color).expect("a scene").inks[1].ratio, [1.0, 0.5, 0.25]);
    let one = with(&[red, red], color).expect("a scene");
    assert_eq!((one.inks.len(), one.extinction_ratio, one.lights.len()), (0, [0.5, 1.0, 1.0], 1));
    for (ratios, more, words) in [
        (["extinction_ratio = [1, -0.1, 1]", ""], "", "particles smoke.ply: extinction_ratio [1.0, -0.1, 1.0] is not"),
        (["extinction_ratio = [0, 0, 0]", ""], "", "0 in every color"),
        (["extinction_ratio = [1, 1]", ""], "", "line"),
        (["extinction_ratio = [2, 1, 1]", ""], "", "not from 0 to 1"),
        ([red, ""], "[color]\nextinction = [2, 1, 1]\n", "not from 0 to 1"),
    ] {
        let told = with(&ratios, more).expect_err("refused").to_string();
        assert!(told.contains(words) && told.contains("scene.toml") && !told.contains('\n'), "{told}");
    }
}

/// Without a camera, a scene file must get the one that its data file alone would get; a rotated entry must get another.
#[test]
fn scene_files_without_a_camera_have_a_fitted_one() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let seeds = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    let scene = |entry: &str, file: &str, more: &str| {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, format!("[[{entry}]]\nfile = {file:?}\n{more}\n{LIGHT}")).expect("written");
        Scene::load(path.to_str().expect("UTF-8"), 0.0)
    };
    for (entry, file, up) in [
        ("particles", "ply/ok-particles-ascii.ply", [0.0, 0.0, 1.0]),
        ("volumes", "nrrd/ok-bytes.nrrd", [0.0, 0.0, 1.0]),
        ("volumes", "vdb/ok-frame-#.vdb", [0.0, 1.0, 0.0]),
        ("hair", "tressfx/ok-version-4.tfx", [0.0, 1.0, 0.0]),
    ] {
        let file = seeds.join(file);
        let file = file.to_str().expect("UTF-8");
        let (alone, named) = (Scene::load(file, 0.0).expect(file), scene(entry, file, "").expect(file));
        assert_eq!((named.camera, alone.camera.up.to_array()), (alone.camera, up), "{file}");
        // The axis that a quarter turn about x moves from +y must be +z.
        let turned = scene(entry, file, "rotate = [1, 0, 0, 90]").expect(file);
        assert_eq!(turned.camera.up.to_array(), [0.0, 0.0, 1.0], "{file}");
    }
}

#[test]
fn broken_scene_files_are_refused() {
    let particles = "[[particles]]\nfile = \"smoke.ply\"\n";
    let mesh = "[[meshes]]\nfile = \"tri.ply\"\n";
    let spot = "[light]\nkind = \"spot\"\nposition = [0.0, 0.0, 9.0]\ntarget = [0.0, 0.0, 1.0]\ncone_degrees = 60\n";
    let whole = format!("{particles}{mesh}{LIGHT}{CAMERA}");
    let spotted = format!("{particles}{mesh}{spot}{CAMERA}");
    scene_file(&whole).expect("whole");
    scene_file(&spotted).expect("spotted");
    for (text, from, to, words) in [
        (&whole, "file = \"smoke.ply\"\n", "file = \"smoke.ply\"\nopacity = 1.0\n", "line 3: unknown field `opacity`"),
        (&whole, "fov_y_degrees", "fov", "unknown field `fov`"),
        (&whole, "kind =", "radius = 3\nkind =", "unknown field `radius`"),
        (&whole, "[camera]", "[kamera]", "unknown field `kamera`"),
        (&whole, LIGHT, "", "missing field `light`"),
        (&whole, "directional", "area", "area"),
        (&whole, "kind = \"directional\"\n", "", "kind"),
        (&whole, "[light]", "[light", "line 5"),
        (&whole, "[0.0, 0.0, -2.0]", "[0.0, 0.0]", "line"),
        (&whole, "[0.0, 0.0, -2.0]", "[0.0, 0.0, 0.0]", "direction has no length"),
        (&whole, "[0.0, 0.0, -2.0]", "[nan, 0.0, 0.0]", "not finite"),
        (&whole, "[0.0, 0.0, -2.0]", "[inf, 0.0, 0.0]", "not finite"),
        (&whole, "-2.0]\n", "-2.0]\nradiance = [-1.0, 0.0, 0.0]\n", "radiance"),
        (&whole, "-2.0]\n", "-2.0]\nradiance = [1e39, 0.0, 0.0]\n", "radiance"),
        (&whole, "position = [3, 0, 0]", "position = [0, 0, 0]", "same point"),
        (&whole, "up = [0.0, 0.0, 1.0]", "up = [-3.0, 0.0, 0.0]", "parallel"),
        (&whole, "up = [0.0, 0.0, 1.0]", "up = [0.0, 0.0, 0.0]", "up has no length"),
        (&whole, "fov_y_degrees = 40.0", "fov_y_degrees = 0.0", "[1e-6, 180)"),
        (&whole, "fov_y_degrees = 40.0", "fov_y_degrees = 180.0", "[1e-6, 180)"),
        (&whole, "fov_y_degrees = 40.0", "fov_y_degrees = nan", "[1e-6, 180)"),
        (&whole, "smoke.ply\"\n", "smoke.ply\"\nscale = 0\n", "particles smoke.ply: scale"),
        (&whole, "smoke.ply\"\n", "smoke.ply\"\nscale = 1e60\n", "particle 0 (the first is 0)"),
        (&whole, "smoke.ply\"\n", "smoke.ply\"\ntranslate = [0.0, nan, 0.0]\n", "translate"),
        (&whole, "tri.ply\"\n", "tri.ply\"\nscale = -1.0\n", "meshes tri.ply: scale"),
        (&whole, "tri.ply\"\n", "tri.ply\"\nscale = 1e60\n", "exceeds 1e18"),
        (
            &whole,
            "[[particles]]\nfile = \"smoke.ply\"\n",
            "[[volumes]]\nfile = \"a.nrrd\"\nwindow = [400.0, 400.0]\n",
            "window [400.0, 400.0] is not two numbers, the lower first",
        ),
        (&whole, "tri.ply\"\n", "tri.ply\"\nalbedo = [0.0, 1.1, 0.0]\n", "albedo"),
        (&whole, "tri.ply\"\n", "tri.ply\"\nsolid = 1\n", "line 5"),
        (&whole, particles, "", ""),
        (&spotted, "cone_degrees = 60", "cone_degrees = 171", "[1e-6, 170]"),
        (&spotted, "cone_degrees = 60", "cone_degrees = 0", "[1e-6, 170]"),
        (&spotted, "cone_degrees = 60", "cone_degrees = nan", "[1e-6, 170]"),
        (&spotted, "target = [0.0, 0.0, 1.0]", "target = [0.0, 0.0, 9.0]", "same point"),
        (&spotted, "cone_degrees", "direction", "direction"),
    ] {
        let mut broken = text.replace(from, to);
        assert_ne!(&broken, text);
        if from == particles {
            broken = broken.replace(mesh, "");
        }
        message(scene_file(&broken), "scene.toml", words);
    }
}
