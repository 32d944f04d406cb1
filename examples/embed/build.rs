//! Compiles the example's shaders for the package's build script, which has a compiler at hand: as a dependency of the example
//! it would be built a second time. An engine has its own way from GLSL to SPIR-V.

use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};
use std::fs;
use std::path::Path;

const FOLDER: &str = "examples/embed/shaders";

/// Shaders, and whether they ask for shadows: those are built once for each of `TECHNIQUES`.
const SHADERS: [(&str, ShaderKind, bool); 7] = [
    ("move.comp", ShaderKind::Compute, false),
    ("sort.comp", ShaderKind::Compute, false),
    ("ask.comp", ShaderKind::Compute, true),
    ("ground.vert", ShaderKind::Vertex, false),
    ("ground.frag", ShaderKind::Fragment, true),
    ("smoke.vert", ShaderKind::Vertex, false),
    ("smoke.frag", ShaderKind::Fragment, true),
];

const TECHNIQUES: [&str; 3] = ["avsm", "psm", "beer_shadow_map"];

/// Writes `out`/embed/SHADER.spv and `out`/embed/TECHNIQUE/SHADER.spv; nothing where the package has no examples. `file` gives the
/// text that `gobo glsl TECHNIQUE` writes.
pub fn build(out: &Path, file: impl Fn(&str) -> Result<String, String>) -> Result<(), String> {
    if !Path::new(FOLDER).is_dir() {
        return Ok(());
    }
    println!("cargo:rerun-if-changed={FOLDER}");
    let compiler = Compiler::new().map_err(|e| format!("cannot start shaderc: {e}"))?;
    for (shader, kind, asks) in SHADERS {
        for technique in if asks { &TECHNIQUES[..] } else { &[""] } {
            let path = out.join("embed").join(technique).join(format!("{shader}.spv"));
            let gobo = if asks { file(technique)? } else { String::new() };
            let spirv = compile(&compiler, shader, kind, (technique, &gobo))?;
            fs::create_dir_all(path.parent().unwrap_or(out)).map_err(|e| e.to_string())?;
            fs::write(&path, spirv).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
        }
    }
    Ok(())
}

/// A technique's file is included as gobo.glsl. It has set 1 to itself, and its constants the ids from 0 on, whichever technique it is.
fn compile(
    compiler: &Compiler,
    shader: &str,
    kind: ShaderKind,
    (technique, gobo): (&str, &str),
) -> Result<Vec<u8>, String> {
    let read = |name: &str| fs::read_to_string(format!("{FOLDER}/{name}")).map_err(|e| format!("{name}: {e}"));
    let mut options = CompileOptions::new().map_err(|e| format!("cannot start shaderc: {e}"))?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_warnings_as_errors();
    options.set_include_callback(move |name, _, _, _| {
        let content = if name == "gobo.glsl" { gobo.into() } else { read(name)? };
        Ok(ResolvedInclude { resolved_name: name.into(), content })
    });
    let upper = technique.to_uppercase();
    for (name, value) in [("SET", "1"), ("BINDING", "0"), ("CONSTANT", "0")] {
        options.add_macro_definition(&format!("GOBO_{upper}_{name}"), Some(value));
    }
    for name in ["visibility", "receiver"] {
        options.add_macro_definition(&format!("gobo_{name}"), Some(&format!("gobo_{technique}_{name}")));
    }
    let text = fs::read_to_string(format!("{FOLDER}/{shader}")).map_err(|e| format!("{shader}: {e}"))?;
    let file = format!("{FOLDER}/{shader}");
    let spirv = compiler.compile_into_spirv(&text, kind, &file, "main", Some(&options));
    spirv.map(|s| s.as_binary_u8().to_vec()).map_err(|e| format!("with {technique}: {e}"))
}
