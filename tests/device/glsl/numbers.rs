//! Numbers of bindings and constants: as compiled, as the files declare them, and as published.

use super::engine::{Names, Stage, compile, shader};
use crate::support::spirv::without_constant_choices;
use ash::vk::DescriptorType as D;
use gobo::glsl::{FILES, File};
use spirq::ReflectConfig;
use spirq::ty::{DescriptorType, ScalarType, Type};
use spirq::var::Variable;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Returns the inputs of a shader that calls `files`, except the engine's set 0, in the format of published.tsv. Each file counts from its
/// `bases`: its set, its first binding and its first constant.
fn reflected(files: &[&File], macros: &str, bases: &dyn Fn(&File) -> [u32; 3]) -> String {
    let spirv = compile(&shader(files, Stage::Compute, Names::Few, macros), Stage::Compute).expect("compiled");
    let words: Vec<u32> = spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let mut config = ReflectConfig::new();
    let entry = config.spv(without_constant_choices(&words)).ref_all_rscs(true).gen_unique_names(false).reflect();
    let vars = entry.expect("reflected").remove(0).vars;
    let mut lines = BTreeMap::new();
    let place = |name: &str| {
        let of = |file: &&&File| name.starts_with(&format!("gobo_{}_", file.technique.replace('-', "_")));
        files.iter().filter(of).max_by_key(|file| file.technique.len()).unwrap_or_else(|| panic!("whose is {name}?"))
    };
    for var in &vars {
        match var {
            Variable::Descriptor { desc_bind, .. } if desc_bind.set() == 0 => {}
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                // SPIR-V keeps a block's own name, and its only member's name as in the file.
                let (name, stride) = match ty {
                    Type::Struct(block) => (block.members[0].name.clone(), stride(&block.members[0].ty)),
                    _ => (name.clone(), 0),
                };
                let name = name.expect("a name");
                let file = place(&name);
                let [set, first, _] = bases(file);
                assert_eq!(desc_bind.set(), set, "{name}");
                let number = desc_bind.bind() - first;
                let line = format!("{}\tbinding\t{number}\t{name}\t{:?}\t{stride}", file.technique, kind(desc_ty));
                lines.insert((file.technique, 0, number), line);
            }
            Variable::SpecConstant { name, spec_id, ty } => {
                let name = name.clone().expect("a name");
                let file = place(&name);
                let number = spec_id - bases(file)[2];
                let constant = &file.constants[number as usize];
                let line =
                    format!("{}\tconstant\t{number}\t{name}\t{}\t{}", file.technique, scalar(ty), constant.default);
                lines.insert((file.technique, 1, number), line);
            }
            _ => {}
        }
    }
    lines.into_values().map(|line| line + "\n").collect()
}

fn kind(of: &DescriptorType) -> D {
    match of {
        DescriptorType::StorageBuffer(_) => D::STORAGE_BUFFER,
        DescriptorType::CombinedImageSampler() => D::COMBINED_IMAGE_SAMPLER,
        DescriptorType::SampledImage() => D::SAMPLED_IMAGE,
        DescriptorType::StorageImage(_) => D::STORAGE_IMAGE,
        DescriptorType::AccelStruct() => D::ACCELERATION_STRUCTURE_KHR,
        other => panic!("{other:?}"),
    }
}

fn scalar(of: &Type) -> &'static str {
    match of {
        Type::Scalar(ScalarType::Boolean) => "bool",
        Type::Scalar(ScalarType::Integer { is_signed: true, .. }) => "int",
        Type::Scalar(ScalarType::Integer { .. }) => "uint",
        Type::Scalar(ScalarType::Float { .. }) => "float",
        other => panic!("{other:?}"),
    }
}

/// Returns the byte size of an array's element, or of another type.
fn stride(of: &Type) -> usize {
    match of {
        Type::Array(array) => array.stride.expect("a stride"),
        Type::Struct(of) => {
            let last = of.members.last().expect("a member");
            last.offset.expect("an offset") + last.ty.nbyte().expect("a size")
        }
        other => other.nbyte().expect("a size"),
    }
}

/// Returns the numbers that the files declare, in the same format.
fn said(files: &[&File]) -> String {
    let mut text = String::new();
    for file in files {
        for b in file.bindings {
            let glsl = if b.glsl.starts_with("gobo_") { b.glsl.split('_').next_back() } else { Some(b.glsl) };
            assert!(glsl.is_some_and(|glsl| !glsl.is_empty()));
            let _ = writeln!(
                text,
                "{}\tbinding\t{}\t{}\t{:?}\t{}",
                file.technique, b.number, b.name, b.descriptor, b.stride
            );
        }
        for (id, c) in file.constants.iter().enumerate() {
            let name = format!("gobo_{}_{}", file.technique.replace('-', "_"), c.name);
            let _ = writeln!(text, "{}\tconstant\t{id}\t{name}\t{}\t{}", file.technique, c.glsl, c.default);
        }
    }
    text
}

fn by_default(file: &File) -> [u32; 3] {
    [1, file.first_binding, file.first_constant]
}

#[test]
fn files_say_what_they_are_compiled_to() {
    for file in FILES {
        assert_eq!(reflected(&[file], "", &by_default), said(&[file]), "{}", file.technique);
    }
    let all: Vec<_> = FILES.iter().collect();
    assert_eq!(reflected(&all, "", &by_default), said(&all));
}

#[test]
fn sets_bindings_and_ids_begin_where_macros_say() {
    for (i, file) in (0..).zip(FILES) {
        let name = file.technique.replace('-', "_").to_uppercase();
        let bases = [2 + i % 2, 3 * i, 7 * i];
        let macros = format!(
            "#define GOBO_{name}_SET {}\n#define GOBO_{name}_BINDING {}\n#define GOBO_{name}_CONSTANT {}\n",
            bases[0], bases[1], bases[2]
        );
        assert_eq!(reflected(&[file], &macros, &|_| bases), said(&[file]), "{}", file.technique);
    }
}

/// By default no two files share a number.
#[test]
fn numbers_of_two_files_differ() {
    let ranges = |first: fn(&File) -> u32, count: fn(&File) -> usize| {
        let mut all: Vec<_> = FILES.iter().map(|file| (first(file), first(file) + count(file) as u32, file)).collect();
        all.sort_by_key(|(first, ..)| *first);
        for pair in all.windows(2) {
            assert!(pair[0].1 <= pair[1].0, "{} and {}", pair[0].2.technique, pair[1].2.technique);
        }
    };
    ranges(|file| file.first_binding, |file| file.bindings.len());
    ranges(|file| file.first_constant, |file| file.constants.len());
}

/// Programs depend on these numbers. A new constant goes to the end of its file's list (`// flat:` in its visibility.glsl), and its line is
/// added to published.tsv; nothing there ever changes. `GOBO_WRITE_TABLES=1` adds new lines.
#[test]
fn published_numbers_stay() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/device/glsl/published.tsv");
    let published = std::fs::read_to_string(&path).unwrap_or_default();
    let all: Vec<_> = FILES.iter().collect();
    let mut now = String::new();
    for file in &all {
        let _ = writeln!(now, "{}\tfirst\t{}\t\tbinding\t", file.technique, file.first_binding);
        let _ = writeln!(now, "{}\tfirst\t{}\t\tconstant\t", file.technique, file.first_constant);
    }
    now += &said(&all);
    let lost: Vec<_> = published.lines().filter(|line| !now.lines().any(|now| now == *line)).collect();
    assert!(lost.is_empty(), "published, and no longer so:\n{}", lost.join("\n"));
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(&path, &now).expect("write published.tsv");
    } else {
        let new: Vec<_> = now.lines().filter(|line| !published.lines().any(|old| old == *line)).collect();
        assert!(new.is_empty(), "not in tests/device/glsl/published.tsv yet:\n{}", new.join("\n"));
    }
}
