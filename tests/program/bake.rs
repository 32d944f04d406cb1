//! `gobo bake`, and use of the files that it writes.

use crate::errors::{fails, one_line};
use crate::support::log;
use crate::{folder, gobo, ok, results, runs, small_scene, text, write_scene};
use std::path::Path;

fn bake(scene: &Path, technique: &str, out: &Path) -> Vec<u8> {
    ok(&["bake", text(scene), "--technique", technique, "--validation", "--out", text(out)]);
    std::fs::read(out).expect("written")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("there");
    let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// An opened bake must give the same picture, and in a comparison the same row except for build figures.
#[test]
fn a_bake_is_opened_again() {
    if crate::support::is_costly("a_bake_is_opened_again") {
        return;
    }
    log("exercised", "a_bake_is_opened_again", &runs("voxelized", "tiles").0);
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let file = out.path().join("small.gobo");
    let technique = "voxelized:size=64,free=exit";
    let bytes = bake(&scene, technique, &file);
    assert_eq!(names(out.path()), ["small.gobo"], "nothing temporary is left");
    assert_eq!(bytes, bake(&scene, technique, &file), "over the old one, and the same");

    let from_file = format!("voxelized:file={}", text(&file));
    let [direct, opened] = [("direct.png", technique), ("file.png", &from_file)].map(|(name, technique)| {
        let out = out.path().join(name);
        let size = ["--picture", "80x60", "--validation"];
        ok(&[&["render", text(&scene), "--technique", technique, "--out", text(&out)][..], &size].concat());
        std::fs::read(out).expect("written")
    });
    assert_eq!(direct, opened);

    let report = out.path().join("report");
    let mut arguments =
        vec!["compare", text(&scene), "--quick", "--frames", "2", "--picture", "80x60", "--out", text(&report)];
    [technique, &from_file, "avsm:size=8"].iter().for_each(|spec| arguments.extend(["--technique", spec]));
    let table = ok(&arguments);
    assert!(table.contains("on disk"), "{table}");
    let rows = results(&report).rows;
    let disk: Vec<_> = rows.iter().map(|row| row.bytes_on_disk).collect();
    assert_eq!(disk, [Some(bytes.len() as u64), Some(bytes.len() as u64), None]);
    let [baked, opened] = [&rows[0], &rows[1]];
    assert_eq!((opened.path.as_str(), opened.build_ns, opened.passes.len()), ("file", None, 0));
    // Without timestamps, pass times are unknown.
    let untimed = std::env::var_os("GOBO_TEST_FEATURES").is_some();
    assert_eq!((baked.path.as_str(), baked.passes.is_empty()), ("tiles", untimed));
    assert!(baked.host_ns.is_some());
    assert_eq!(opened.error, baked.error);
    for key in ["size", "structure", "closed", "free", "coverage"] {
        assert_eq!(opened.variant[key], baked.variant[key], "{key}");
    }
}

#[test]
fn a_file_that_cannot_be_opened() {
    if crate::support::is_costly("a_file_that_cannot_be_opened") {
        return;
    }
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.png"));
    let file = folder.path().join("small.gobo");
    let good = bake(&scene, "voxelized:size=64", &file);
    let render = |scene: &Path, technique: &str, words: &[&str]| {
        fails(&["render", text(scene), "--technique", technique, "--out", text(&out)], words);
        assert!(!out.exists());
    };
    let spec = format!("voxelized:file={}", text(&file));

    let other = folder.path().join("other.toml");
    let turned = std::fs::read_to_string(&scene).expect("there").replace("0.5, 0.3,", "0.5, 0.4,");
    std::fs::write(&other, turned).expect("written");
    render(
        &other,
        &spec,
        &["small.gobo", "baked from a scene whose meshes or lights differ from those of other now", "gobo bake"],
    );
    for (key, was) in [
        ("size=512", "size=64"),
        ("structure=svo", "structure=dag"),
        ("closed=off", "closed=on"),
        ("coverage=conservative", "coverage=middle"),
    ] {
        render(&scene, &format!("{spec},{key}"), &["small.gobo", key, was, "leave"]);
    }
    ok(&["render", text(&scene), "--technique", &format!("{spec},size=64,filter=3"), "--out", text(&out)]);
    std::fs::remove_file(&out).expect("written");

    let absent = folder.path().join("absent.gobo");
    render(&scene, &format!("voxelized:file={}", text(&absent)), &["absent.gobo", "gobo bake"]);
    render(&scene, &format!("voxelized:file={}", text(folder.path())), &["not a regular file", "gobo bake"]);
    render(&scene, "voxelized:file=a,b.gobo", &["b.gobo", "no comma"]);
    render(&scene, "voxelized:file=", &["without commas"]);

    let changed = |at: std::ops::Range<usize>, with: &[u8]| {
        let mut bytes = good.clone();
        bytes[at].copy_from_slice(with);
        bytes
    };
    let middle = good.len() / 2;
    for (bytes, words) in [
        (vec![], ["cut off", "bake it again"]),
        (good[..20].to_vec(), ["cut off", "bake it again"]),
        (good[..good.len() - 1].to_vec(), ["cut off", "bake it again"]),
        ([&good[..], b"more"].concat(), ["damaged", "bake it again"]),
        (changed(middle..middle + 1, &[!good[middle]]), ["checksum", "bake it again"]),
        (std::fs::read(&scene).expect("there"), ["does not begin as a bake", "write one with gobo bake"]),
        (changed(8..12, &[1, 0, 0, 0]), ["version 1, and version 3 is read here", "read it with what wrote it"]),
        (changed(8..12, &[0, 0, 0, 1]), ["version 16777216", "read it with what wrote it"]),
        (changed(12..16, &[0xff; 4]), ["checksum", "bake it again"]),
        // Counts of trees and words that no file could hold.
        (changed(32..36, &[0xff; 4]), ["cut off", "bake it again"]),
        (changed(48..56, &[0xff; 8]), ["cut off", "bake it again"]),
    ] {
        std::fs::write(&file, bytes).expect("written");
        render(&scene, &spec, &["small.gobo", words[0], words[1]]);
    }
}

#[test]
fn a_bake_that_cannot_be_made() {
    let folder = folder();
    let (scene, out) = (small_scene(folder.path()), folder.path().join("out.gobo"));
    let file = folder.path().join("small.gobo");
    bake(&scene, "voxelized:size=64", &file);
    let from_file = format!("voxelized:file={}", text(&file));
    let empty = write_scene(folder.path(), "empty", &[]);
    let with_ground = std::fs::read_to_string(&empty).expect("there");
    std::fs::write(&empty, with_ground.replace("[[meshes]]\nfile = \"ground.ply\"\n", "")).expect("written");
    for (scene, technique, words) in [
        (text(&scene), "avsm:size=8", &["avsm:size=8", "built each frame", "voxelized"][..]),
        (text(&scene), "voxelized:size=64|128", &["sweep"]),
        (text(&scene), &from_file, &["small.gobo", "not baked here", "leave file= out"]),
        ("big-8k", "voxelized:size=64", &["meshes in the scene", "big-8k"]),
        (text(&empty), "voxelized:size=64", &["meshes in the scene", "empty has none"]),
    ] {
        fails(&["bake", scene, "--technique", technique, "--out", text(&out)], words);
        assert!(!out.exists());
    }
    // Neither a folder nor a device can be replaced by a file.
    let under = file.join("out.gobo");
    for place in [folder.path(), &under, Path::new("/dev/null")] {
        let arguments = ["bake", text(&scene), "--technique", "voxelized:size=64", "--out", text(place)];
        fails(&arguments, &["cannot write"]);
    }
    assert!(!std::fs::metadata("/dev/null").expect("there").is_file());
}

/// With file sizes limited to one block, the old file must stay, and no other file may appear beside it.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let (scenes, out) = (folder(), folder());
    let scene = small_scene(scenes.path());
    let file = out.path().join("small.gobo");
    let arguments = ["bake", text(&scene), "--technique", "voxelized:size=512,structure=svo", "--out", text(&file)];
    std::fs::write(&file, "what was there").expect("written");
    let program = gobo();
    let limited = |arguments: &[&str]| {
        std::process::Command::new("sh")
            .args(["-c", "ulimit -f 8; trap '' XFSZ; exec \"$0\" \"$@\""])
            .arg(program.get_program())
            .args(program.get_args())
            .args(arguments)
            .output()
            .expect("a shell")
    };
    // Newer Mesa backs device memory with files, and dies by a signal if these may not grow.
    let tiny = out.path().join("tiny.gobo");
    let small = ["bake", text(&scene), "--technique", "voxelized:size=64", "--out", text(&tiny)];
    if limited(&small).status.code().is_none() {
        return crate::support::skipped("a_full_disk_leaves_what_was_there", "the driver itself needs larger files");
    }
    let _ = std::fs::remove_file(&tiny);
    one_line(&arguments, limited(&arguments), &["cannot write", "small.gobo", "free space"]);
    assert_eq!(std::fs::read_to_string(&file).expect("still there"), "what was there");
    assert_eq!(names(out.path()), ["small.gobo"]);
    ok(&arguments);
    assert!(std::fs::metadata(&file).expect("written").len() > 8 * 1024, "more than the disk had room for");
}
