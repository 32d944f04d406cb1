//! `gobo glsl`: its files must equal the library's, and each mistake must give one line.

use super::errors::fails;
use crate::{folder, ok, text};
use gobo::glsl::{FILES, file};

#[test]
fn files_are_handed_out() {
    let avsm = file("avsm").expect("avsm").text;
    assert_eq!(ok(&["glsl", "avsm"]), avsm);
    let folder = folder();
    let out = folder.path().join("made/gobo");
    let all: Vec<_> = FILES.iter().map(|file| file.technique).collect();
    ok(&["glsl", &all.join(","), "-o", text(&out)]);
    for technique in all {
        let written = std::fs::read_to_string(out.join(format!("{technique}.glsl"))).expect(technique);
        assert_eq!(written, file(technique).expect(technique).text);
    }
}

#[test]
fn mistakes_are_said_in_one_line() {
    fails(&["glsl", "avms"], &["\"avms\"", "did you mean avsm?", "choose from: avsm, beer-shadow-map"]);
    fails(&["glsl", "avsm,"], &["\"\"", "choose from"]);
    fails(&["glsl", "avsm,psm,avsm"], &["avsm is there twice"]);
    fails(&["glsl", "psm:slices=64"], &["psm:slices=64", "write psm"]);
    fails(&["glsl", "many-lights"], &["many-lights", "no technique has such a look-up"]);
    let folder = folder();
    let file = folder.path().join("file");
    std::fs::write(&file, "a regular file").expect("written");
    fails(&["glsl", "avsm", "-o", text(&file)], &["cannot write", "file"]);
    std::fs::create_dir_all(folder.path().join("there/psm.glsl")).expect("a folder");
    fails(&["glsl", "avsm,psm", "-o", text(&folder.path().join("there"))], &["psm.glsl", "not a regular file"]);
    assert!(!folder.path().join("there/avsm.glsl").exists(), "all places are looked at before one is written");
}
