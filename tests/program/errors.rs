//! Every user error must end with one line that names its cause.

use crate::{folder, ok, run, small_scene, text, write_scene};
use std::process::Output;

/// Asserts that the command fails with one line on standard error that contains all `words`, and with nothing on standard output.
#[track_caller]
pub fn fails(arguments: &[&str], words: &[&str]) {
    one_line(arguments, run(arguments), words);
}

/// Same as [`fails`], for a command that has already run.
#[track_caller]
pub fn one_line(arguments: &[&str], output: Output, words: &[&str]) {
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(!output.status.success(), "{arguments:?} must fail");
    assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?}: not one line:\n{error}");
    for word in words {
        assert!(error.contains(word), "{arguments:?}: {error:?} does not say {word:?}");
    }
    assert!(output.stdout.is_empty(), "{arguments:?}: {:?}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn a_scene_that_is_not_there() {
    for command in ["compare", "render", "slice"] {
        fails(&[command, "/nowhere/absent.toml"], &["/nowhere/absent.toml"]);
        fails(&[command, "no-such-scene"], &["no-such-scene", "three-emitters", "*.tfx"]);
        fails(&[command, "fountain:particles=0"], &["fountain:particles=0", "give particles=1..4000000"]);
        fails(&[command, "fountain:particles=4000001"], &["particles=4000001", "give particles=1..4000000"]);
        fails(&[command, "town:particles=3"], &["no key \"particles\"", "town takes no numbers"]);
    }
}

#[test]
fn a_broken_particle_file() {
    let folder = folder();
    for (name, row, words) in [
        ("nan", "0 nan 0 1 1", "1 (the first is 0)"),
        ("radius", "0 0 0 -1 1", "radius"),
        ("infinite", "0 0 0 1 inf", "1 (the first is 0)"),
        ("short", "0 0 0", "truncated"),
    ] {
        let scene = write_scene(folder.path(), name, &["0 0 0 1 1".to_owned(), row.to_owned()]);
        let out = folder.path().join("out");
        let file = format!("{name}.ply");
        fails(&["compare", text(&scene), "--out", text(&out)], &[&file, words]);
        assert!(!out.exists(), "nothing is written for a scene that cannot be read");
    }
}

/// A misspelt word must be answered with the word that was meant, wherever the program accepts words.
#[test]
fn what_was_meant() {
    for (arguments, words) in [
        (&["render", "big-8k", "--technique", "avms"][..], &["did you mean avsm?", "choose one of"][..]),
        (&["render", "big-8k", "--technique", "avsm:node=4"], &["did you mean nodes?"]),
        (&["render", "big-8k", "--technique", "avsm:curve=lineal"], &["did you mean linear?"]),
        (&["render", "big8k"], &["big8k", "did you mean big-8k?"]),
        (&["stress", "extincton"], &["did you mean extinction?"]),
        (&["stress", "corneli"], &["did you mean cornell?"]),
        (&["compare", "big-8k", "--technique", "avsm,psm"], &["--technique avsm --technique psm"]),
        (&["compare", "big-8k", "--technique", "avsm,size=8"], &["avsm:size=8"]),
        (&["compare", "big-8k", "--technique", "avsm:size=8,psm:size=8"], &["a --technique for each"]),
    ] {
        fails(arguments, words);
    }
}

/// A picture must be a PNG and a plot an SVG, whatever their names; folders are not created for them.
#[test]
fn a_file_of_another_kind_or_in_no_folder() {
    let folder = folder();
    let scene = small_scene(folder.path());
    for (command, more, right) in
        [("render", &[][..], "png"), ("slice", &[], "png"), ("map", &[], "png"), ("curve", &["--texel", "4,4"], "svg")]
    {
        let jpg = folder.path().join("x.jpg");
        let named = format!("name {}", text(&jpg.with_extension(right)));
        fails(&[&[command, text(&scene), "-o", text(&jpg)][..], more].concat(), &["x.jpg", &named]);
        let absent = folder.path().join("nodir");
        let out = absent.join(format!("out.{right}"));
        let words = [text(&out), "cannot write", &format!("there is no folder {}", text(&absent)), "make it"];
        fails(&[&[command, text(&scene), "-o", text(&out)][..], more].concat(), &words);
        assert!(!jpg.exists() && !absent.exists());
    }
}

#[test]
fn a_technique_that_is_not_known() {
    for (spec, words) in [
        ("vsm", &["vsm", "avsm", "psm", "uncompressed"][..]),
        ("avsm:knots=4", &["knots", "nodes"]),
        ("avsm:nodes=5", &["nodes=5", "4, 8, 16"]),
        ("avsm:nodes", &["nodes", "key=value"]),
        ("avsm:size=0", &["size=0", "from 1 to"]),
        ("avsm:size=99999999999", &["size=99999999999"]),
        ("psm:size=1024", &["size=1024", "from 8 to 512"]),
        ("psm:slices=512", &["slices=512", "from 4 to 256"]),
        ("psm:slices=6", &["slices=6", "divisible by 4"]),
        ("psm:storage=r8", &["storage=r8", "rgba16f"]),
    ] {
        for command in ["compare", "render", "slice"] {
            fails(&[command, "big-8k", "--technique", spec], words);
        }
    }
    for command in ["render", "slice"] {
        fails(&[command, "big-8k", "--technique", "avsm:nodes=4|8"], &["avsm:nodes=4|8", "sweep"]);
    }
}

#[test]
fn a_device_that_is_not_there() {
    let folder = folder();
    let scene = small_scene(folder.path());
    let out = folder.path().join("out.png");
    for device in ["no such device", "99"] {
        for command in ["compare", "render", "slice"] {
            let arguments = [command, text(&scene), "--device", device, "--out", text(&out)];
            fails(&arguments, &["--device", device, "0 = "]);
            assert!(!out.exists());
        }
    }
}

/// A path that the device cannot run must be a refused row in a comparison, and an error if a single picture was requested.
#[test]
fn a_path_that_is_refused() {
    if crate::runs("avsm", "interlock").1 || !crate::runs("avsm", "two-pass").1 {
        return crate::support::skipped(
            "a_path_that_is_refused",
            "the device runs every path, or lacks more than interlock",
        );
    }
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.png"));
    let arguments = ["render", text(&scene), "--technique", "avsm:path=interlock", "--out", text(&out)];
    fails(&arguments, &["fragmentShaderPixelInterlock"]);
}

/// Imperfect shadow maps need virtual lights, so every device refuses their rows here. Refused rows beside measured ones are no failure; a
/// run with refused rows only measures nothing and must fail. A shard may consist of such rows, but a joined run may not.
#[test]
fn a_run_of_refused_rows() {
    let (folder, out) = (folder(), folder());
    let scene = small_scene(folder.path());
    let quick = ["compare", text(&scene), "--quick", "--frames", "2", "--picture", "16x16"];
    let run = |specs: &[&str], more: &[&str], out: &std::path::Path| {
        let specs = specs.iter().flat_map(|spec| ["--technique", spec]);
        let all: Vec<_> =
            quick.into_iter().chain(specs).chain(more.iter().copied()).chain(["--out", text(out)]).collect();
        let output = run(&all);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let refused = ["ism:points=1024", "ism:points=2048"];
    let (code, said) = run(&refused, &[], out.path());
    let last = said.lines().last().expect("a line");
    assert!(code == Some(1) && last.contains("nothing is measured") && last.contains("2 rows"), "{said}");
    assert!(last.contains("refused: needs") && said.matches("nothing is measured").count() == 1, "{said}");
    let (code, said) = run(&["none", refused[0]], &[], out.path());
    assert!(code == Some(0) && !said.contains("nothing is measured"), "{said}");
    let shards = ["1/2", "2/2"].map(|shard| {
        let out = out.path().join(shard.replace('/', "-"));
        let (code, said) = run(&refused, &["--shard", shard], &out);
        assert_eq!(code, Some(0), "{said}");
        out
    });
    let joined = out.path().join("joined");
    let output = crate::run(&["join", text(&shards[0]), text(&shards[1]), "--out", text(&joined)]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("nothing is measured"), "{said}");
}

#[test]
fn a_place_that_cannot_be_written() {
    let folder = folder();
    let scene = small_scene(folder.path());
    let file = folder.path().join("file");
    std::fs::write(&file, "a regular file").expect("write");
    // Permissions would not stop the superuser from writing.
    let under = file.join("out");
    let quick = ["--technique", "avsm:size=8"];
    for out in [&under, &file] {
        let arguments = [&["compare", text(&scene), "--quick", "--out", text(out)][..], &quick].concat();
        fails(&arguments, &[text(out), "cannot write"]);
    }
    for command in ["render", "slice"] {
        let out = under.with_extension("png");
        let arguments = [&[command, text(&scene), "--out", text(&out)][..], &quick].concat();
        fails(&arguments, &[text(&out), "cannot write"]);
    }
    assert_eq!(std::fs::read_to_string(&file).expect("still there"), "a regular file");
}

/// Only lighting=vertex creates triangles whose edges could be drawn.
#[test]
fn a_wireframe_of_nothing() {
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.png"));
    for technique in ["avsm:size=8", "psm:size=8,lighting=fragment", "reference"] {
        let arguments = ["render", text(&scene), "--technique", technique, "--wireframe", "--out", text(&out)];
        fails(&arguments, &["--wireframe", technique, "lighting=vertex"]);
        assert!(!out.exists());
    }
}

/// A technique that counts no steps must be refused.
#[test]
fn steps_of_who_does_not_count() {
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.png"));
    for technique in ["beer-shadow-map", "reference"] {
        let arguments = ["render", text(&scene), "--technique", technique, "--steps", "--out", text(&out)];
        fails(&arguments, &[technique, "steps"]);
        assert!(!out.exists());
    }
}

#[test]
fn fog_of_no_extinction() {
    for extinction in ["-1", "nan", "inf", "-inf"] {
        for technique in ["avsm:size=8", "reference"] {
            let arguments = ["render", "sparse", "--technique", technique, "--fog", extinction];
            fails(&arguments, &["--fog", "extinction from 0 on"]);
        }
    }
}

#[test]
fn a_depth_outside_the_range() {
    for depth in ["2", "-0.5", "nan", "inf"] {
        let argument = format!("--depth={depth}");
        let words = ["--depth", "from 0 to 1"];
        fails(&["slice", "big-8k", &argument], &words);
    }
}

#[test]
fn a_light_or_a_face_that_is_not_there() {
    for (more, words) in [
        (&["--light", "3"][..], &["--light 3", "3 lights"][..]),
        (&["--light", "0"], &["--light 0", "six maps", "+x, -x"]),
        (&["--light", "0", "--face", "-w"], &["--face -w", "no such face"]),
        (&["--light", "1", "--face", "+x"], &["--face +x", "no point light"]),
    ] {
        fails(&[&["slice", "lantern"][..], more].concat(), words);
        fails(&[&["curve", "lantern", "--texel", "20,20"][..], more].concat(), words);
    }
    let gutter = ["curve", "lantern", "--texel", "0,0", "--face", "-z", "--technique", "avsm:size=32"];
    fails(&gutter, &["texel 0,0", "margin"]);
}

/// Only courtyard has a configurable number of lights, within limits.
#[test]
fn a_number_of_lights_that_cannot_be() {
    let folder = folder();
    let scene = small_scene(folder.path());
    let bake = ["bake", "town", "--lights", "4"];
    fails(&bake, &["town", "lights are not a number to choose", "courtyard"]);
    for command in ["compare", "render", "slice"] {
        for (name, file) in [("lantern", "lantern"), (text(&scene), "small")] {
            let words = [file, "lights are not a number to choose", "leave their number out", "courtyard"];
            fails(&[command, name, "--lights", "4"], &words);
        }
        for lights in ["0", "1025", "4294967297"] {
            fails(&[command, "courtyard", "--lights", lights], &["courtyard", lights, "1 to 1024"]);
        }
    }
    fails(&["compare", "courtyard", "lantern", "--lights", "4"], &["lantern", "lights are not a number to choose"]);
    fails(&["slice", "courtyard", "--lights", "2", "--light", "2"], &["--light 2", "2 lights"]);
}

/// Virtual lights need meshes that reflect light, and their number is limited.
#[test]
fn virtual_lights_that_cannot_be() {
    let folder = folder();
    let out = folder.path().join("out");
    for command in ["compare", "render"] {
        for count in ["0", "63", "4097"] {
            fails(&[command, "cornell", "--vpls", count, "--out", text(&out)], &["--vpls", count, "64 to 4096"]);
        }
        fails(&[command, "big-8k", "--vpls", "64", "--out", text(&out)], &["big-8k", "no mesh", "--vpls"]);
    }
    let reference = ["render", "big-8k", "--vpls", "64", "--technique", "reference", "--out", text(&out)];
    fails(&reference, &["big-8k", "no mesh"]);
    // A bounce is compared with virtual lights only, and in scenes of meshes only.
    let bounce = ["compare", "cornell", "--bounce", "8", "--out", text(&out)];
    let said = crate::run(&bounce);
    assert!(!said.status.success() && String::from_utf8_lossy(&said.stderr).contains("--vpls"), "{said:?}");
    fails(&["compare", "lantern", "--vpls", "64", "--bounce", "8", "--out", text(&out)], &["lantern", "smoke or hair"]);
    assert!(!out.exists());
}

#[test]
fn a_map_larger_than_the_device() {
    if !crate::runs("avsm", "two-pass").1 {
        return crate::support::skipped("a_map_larger_than_the_device", "needs fragmentStoresAndAtomics");
    }
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.png"));
    for (technique, words) in [
        ("avsm:size=16384,nodes=16,path=two-pass,skip=off", ["avsm.nodes", "maxStorageBufferRange"]),
        ("avsm:size=16384,nodes=16,path=two-pass", ["bins.parts", "at most"]),
    ] {
        fails(&["render", text(&scene), "--technique", technique, "--out", text(&out)], &words);
    }
}

#[test]
fn help_says_what_there_is() {
    let all = ok(&["--help"]);
    for command in [
        "compare",
        "recommend",
        "render",
        "slice",
        "curve",
        "map",
        "bake",
        "voxels",
        "stress",
        "glsl",
        "devices",
        "completions",
        "man",
    ] {
        assert!(all.contains(command), "{all}");
        let help = ok(&[command, "--help"]) + &ok(&[command, "-h"]);
        assert!(help.contains("Usage: gobo"), "{help}");
        assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    }
    let help = ok(&["compare", "--help"]);
    for word in ["avsm", "uncompressed", "nodes", "three-emitters", "--quick", "--out"] {
        assert!(help.contains(word), "{word} is not in:\n{help}");
    }
    assert!(ok(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
}

/// Invalid changes of a scene.
#[test]
fn a_scene_that_is_otherwise() {
    for command in ["render", "slice"] {
        fails(&[command, "shafts", "--direction", "0,0,-1"], &["shafts", "none of its lights has a direction"]);
        fails(&[command, "plume_8k", "--direction", "0,0,0"], &["plume_8k", "of no length"]);
        fails(&[command, "plume_8k", "--extinction", "-1"], &["plume_8k", "an extinction below 0"]);
    }
    fails(
        &["render", "plume_8k", "--eye", "1,2,3", "--target", "1,2,3"],
        &["plume_8k", "looks along its up, or nowhere"],
    );
}

#[cfg(not(feature = "view"))]
#[test]
fn a_window_needs_its_feature() {
    fails(&["view", "plume_8k"], &["gobo view", "no window", "rebuild with --features view"]);
}
