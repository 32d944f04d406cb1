//! A file in other languages: what naga and spirv-cross make of a compute shader that calls it.

use super::engine::{Names, Stage, compile, shader};
use crate::support::skipped;
use gobo::glsl::{FILES, File};
use naga::back::{hlsl, wgsl};
use naga::front::spv;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use std::panic::catch_unwind;
use std::path::Path;
use std::process::Command;

/// Success, or the start of the error.
type Made = Result<String, String>;

/// Compiles a file's shader; with `fixed`, specialization constants become plain constants.
fn spirv(file: &File, fixed: bool) -> Vec<u8> {
    let text = shader(&[file], Stage::Compute, Names::Few, "");
    let line = |line: &str| match line.split_once(") const ") {
        Some((layout, rest)) if fixed && layout.contains("constant_id") => format!("const {rest}\n"),
        _ => format!("{line}\n"),
    };
    compile(&text.lines().map(line).collect::<String>(), Stage::Compute).expect("compiled")
}

/// Converts a file's shader with `make`, after naga has parsed and validated it.
fn by_naga(file: &File, fixed: bool, make: fn(&Module, &ModuleInfo) -> Made) -> Made {
    let spirv = spirv(file, fixed);
    let made = catch_unwind(|| {
        let module = spv::parse_u8_slice(&spirv, &spv::Options::default()).map_err(|e| e.to_string())?;
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator.validate(&module).map_err(|e| causes(e.as_inner()))?;
        make(&module, &info)
    });
    made.unwrap_or_else(|_| Err("naga panics".into()))
}

fn causes(error: &dyn std::error::Error) -> String {
    let mut all = vec![error.to_string()];
    let mut next = error.source();
    while let Some(error) = next {
        all.push(error.to_string());
        next = error.source();
    }
    all.join(": ")
}

fn to_wgsl(module: &Module, info: &ModuleInfo) -> Made {
    wgsl::write_string(module, info, wgsl::WriterFlags::empty()).map_err(|e| causes(&e))
}

fn to_hlsl(module: &Module, info: &ModuleInfo) -> Made {
    let entry = Some((ShaderStage::Compute, "main"));
    let (module, info) = naga::back::pipeline_constants::process_overrides(module, info, entry, &Default::default())
        .map_err(|e| causes(&e))?;
    let (options, pipeline, mut text) = (hlsl::Options::default(), hlsl::PipelineOptions::default(), String::new());
    let mut writer = hlsl::Writer::new(&mut text, &options, &pipeline);
    writer.write(&module, &info, None).map_err(|e| causes(&e))?;
    Ok(text)
}

/// Converts with spirv-cross, or returns `None` if it is not installed.
fn by_spirv_cross(file: &File, language: &[&str]) -> Option<Made> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shader.spv");
    std::fs::write(&path, spirv(file, false)).expect("written");
    let run = Command::new("spirv-cross").arg(&path).args(language).output().ok()?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().replace('\n', " ");
    Some(if run.status.success() { Ok(text(&run.stdout)) } else { Err(text(&run.stderr)) })
}

/// Header of the table: target languages and their converters.
const HEAD: &str =
    "| technique | SPIR-V (shaderc) | HLSL 6.5 (spirv-cross) | MSL 2.3 (spirv-cross) | WGSL (naga) | HLSL (naga) |
|---|---|---|---|---|---|
";

fn row(file: &File) -> String {
    let either = |make| by_naga(file, false, make).or_else(|_| by_naga(file, true, make));
    let cells = [
        ("SPIR-V", Some(Ok(format!("{} bytes", spirv(file, false).len())))),
        ("HLSL by spirv-cross", by_spirv_cross(file, &["--hlsl", "--shader-model", "65"])),
        ("MSL by spirv-cross", by_spirv_cross(file, &["--msl", "--msl-version", "20300"])),
        ("WGSL by naga", Some(either(to_wgsl))),
        ("HLSL by naga", Some(either(to_hlsl))),
    ];
    let mut row = format!("| `{}` |", file.technique);
    for (language, made) in cells {
        row += match made {
            None => " ? |",
            Some(Ok(_)) => " yes |",
            Some(Err(why)) => {
                println!("{}: {language}: {why}", file.technique);
                " no |"
            }
        };
    }
    row + "\n"
}

/// Checks the table of docs/reference/glsl.md; `GOBO_WRITE_TABLES=1` rewrites it.
#[test]
fn what_compiles_to_what() {
    let table: String = FILES.iter().map(row).collect();
    println!("{HEAD}{table}");
    if table.contains('?') {
        return skipped("what_compiles_to_what", "spirv-cross is not installed; ./setup.sh installs it");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/glsl.md");
    let page = std::fs::read_to_string(&path).expect("docs/reference/glsl.md");
    let begin = page.find("| technique | SPIR-V").expect("the table");
    let end = page[begin..].find("\n\n").map_or(page.len(), |length| begin + length + 1);
    if std::env::var_os("GOBO_WRITE_TABLES").is_some_and(|value| !value.is_empty()) {
        std::fs::write(&path, format!("{}{HEAD}{table}{}", &page[..begin], &page[end..]))
            .expect("write docs/reference/glsl.md");
    } else {
        assert_eq!(
            &page[begin..end],
            format!("{HEAD}{table}"),
            "docs/reference/glsl.md; GOBO_WRITE_TABLES=1 writes it anew"
        );
    }
}
