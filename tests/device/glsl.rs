//! GLSL for other programs: files compile alone and together amid an engine's own names, declare their inputs, keep their numbers, and give
//! the technique's look-ups.

mod engine;
mod languages;
mod numbers;
#[allow(dead_code, reason = "voxelized asks for more of them")]
#[path = "../world_space/shapes.rs"]
mod shapes;
mod values;

use crate::support::some;
use engine::{Names, Stage, compile, names_of, shader, words};
use gobo::glsl::{FILES, File};
use gobo::technique::REGISTRY;
use std::collections::BTreeSet;

/// Compiles a fragment and a compute shader that call all of `files`.
fn compiles(files: &[&File], names: Names) {
    for stage in [Stage::Fragment, Stage::Compute] {
        let text = shader(files, stage, names, "");
        let techniques: Vec<_> = files.iter().map(|file| file.technique).collect();
        compile(&text, stage).unwrap_or_else(|e| panic!("{techniques:?}, {stage:?}, {names:?}: {e}"));
    }
}

#[test]
fn every_technique_has_a_file() {
    let techniques: Vec<_> = REGISTRY.iter().map(|entry| entry.name).collect();
    let files: Vec<_> = FILES.iter().map(|file| file.technique).collect();
    assert_eq!(files, techniques);
    for technique in techniques {
        assert_eq!(gobo::glsl::file(technique).expect(technique).technique, technique);
    }
}

#[test]
fn what_is_no_technique_is_an_error_that_helps() {
    for (name, words) in [
        ("avms", &["\"avms\"", "did you mean avsm?", "beer-shadow-map"][..]),
        ("avsm:nodes=4", &["avsm:nodes=4", "write avsm"]),
        ("", &["\"\"", "avsm"]),
        ("many-lights\n", &["many-lights?"]),
    ] {
        let error = gobo::glsl::file(name).expect_err(name).to_string();
        assert!(words.iter().all(|word| error.contains(word)) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn one_file_compiles_among_names_of_an_engine() {
    if crate::support::is_costly("one_file_compiles_among_names_of_an_engine") {
        return;
    }
    for file in FILES {
        for names in [Names::Few, Names::Declared, Names::Macros] {
            compiles(&[file], names);
        }
    }
}

/// Compiles each file with the next and with one far from it; a full run compiles every pair.
#[test]
fn two_files_compile_in_one_shader() {
    if crate::support::is_costly("two_files_compile_in_one_shader") {
        return;
    }
    let apart = some([1, FILES.len() / 2].into_iter().chain(2..FILES.len()), 2);
    for (i, first) in FILES.iter().enumerate() {
        for second in apart.iter().filter_map(|apart| FILES.get(i + apart)) {
            compiles(&[first, second], Names::Few);
        }
    }
}

#[test]
fn all_files_compile_in_one_shader() {
    let all: Vec<_> = FILES.iter().collect();
    for names in [Names::Few, Names::Declared, Names::Macros] {
        compiles(&all, names);
    }
    // A file that is included twice is declared once.
    compiles(&[all[0], all[0]], Names::Few);
}

/// All identifiers except GLSL's own begin with gobo_ or GOBO_; macros and global names also carry the technique's name.
#[test]
fn every_name_is_prefixed() {
    for file in FILES {
        let technique = file.technique.replace('-', "_");
        let (prefix, macros) = (format!("gobo_{technique}_"), format!("GOBO_{}_", technique.to_uppercase()));
        for word in words(file.text) {
            let is_own = word.starts_with("gobo_") || word.starts_with(&macros);
            assert!(is_own || engine::is_glsl(word), "{technique}: {word}");
        }
        for name in engine::globals(file.text) {
            assert!(name.starts_with(&prefix), "{technique}: {name}");
        }
        for line in file.text.lines().filter(|line| line.starts_with("#define")) {
            assert!(line.starts_with(&format!("#define {macros}")), "{technique}: {line}");
        }
        assert!(!file.text.contains("#include"), "{technique}");
    }
}

/// Each file describes its bindings and constants, in its head comment and to Rust.
#[test]
fn all_is_said() {
    for file in FILES {
        let technique = file.technique;
        let top = file.text.split("#ifndef").next().expect("a comment");
        assert!(top.lines().all(|line| line.starts_with("//") && line.chars().count() <= 120), "{technique}:\n{top}");
        let name = technique.replace('-', "_");
        for word in ["visibility(uint light, vec3 position)", "receiver(uint light, vec3 position, vec3 normal)"] {
            assert!(top.contains(&format!("gobo_{name}_{word}")), "{technique} says nothing of {word}");
        }
        // Joined into one line, since descriptions wrap.
        let said = top.lines().map(|line| line.trim_start_matches('/').trim()).collect::<Vec<_>>().join(" ");
        for binding in file.bindings {
            assert!(!binding.about.is_empty(), "{technique}: {} has no text", binding.name);
            let line = format!("({}): {}", binding.name, binding.about);
            assert!(said.contains(&line), "{technique} says not: {line}");
        }
        for constant in file.constants {
            assert!(!constant.about.is_empty(), "{technique}: {} has no text", constant.name);
            let line = format!("{} gobo_{name}_{}, by default {}", constant.glsl, constant.name, constant.default);
            assert!(said.contains(&line), "{technique} says not: {line}");
        }
        assert_eq!(top.contains("scalarBlockLayout"), file.text.contains("scalar)"), "{technique}");
    }
}

/// The engine's names are those that the files would use without their prefixes.
#[test]
fn the_names_of_the_engine_are_hostile() {
    let names: BTreeSet<_> = FILES.iter().flat_map(names_of).collect();
    for name in ["Light", "View", "size", "texel", "position", "light_map", "NODES", "visibility_nodes", "at"] {
        assert!(names.contains(name), "{name}");
    }
}
