//! Compiles every shader under glsl/ to SPIR-V and embeds it. A shader that does not compile fails the build.

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The one list of variants: a shader that includes "visibility.glsl" is built once for each of these folders, from
/// which it takes that file and so `light_visibility`. All other shaders are built once.
const TECHNIQUES: &[&str] = &["avsm", "psm", "uncompressed"];

/// A shader that includes "avsm/attachments.glsl" is built once for each of these values of ATTACHMENTS.
const ATTACHMENTS: &[u32] = &[2, 4, 8];

/// A shader that includes "psm/format.glsl" is built once for each of these values of BITS.
const BITS: &[u32] = &[8, 16];

/// A shader that includes "bins/batch.glsl" is built once for each of these values of LANES.
const LANES: &[u32] = &[0, 1];

fn main() {
    if let Err(message) = build() {
        // Cargo shows standard error of a failed build script; the lines read file:line: error: …
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn build() -> Result<(), String> {
    // The folder stands for all files in it, so that included files are tracked too.
    println!("cargo:rerun-if-changed=glsl");
    let mut files = Vec::new();
    collect(Path::new("glsl"), &mut files)?;
    files.sort();
    let compiler = Compiler::new().map_err(|e| format!("cannot start shaderc: {e}"))?;
    let mut table = String::from("/// Every shader of the program.\npub const SHADERS: &[Shader] = &[\n");
    for file in &files {
        let name = file.strip_prefix("glsl").map_err(|e| e.to_string())?.to_string_lossy().into_owned();
        let Some(kind) = kind(&name) else { continue };
        let source = fs::read_to_string(file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
        if source.contains("#include \"visibility.glsl\"") {
            for technique in TECHNIQUES {
                let name = format!("{technique}/{name}");
                compile(&compiler, file, &source, kind, Variant::Technique(technique), &name, &mut table)?;
            }
        } else if source.contains("#include \"avsm/attachments.glsl\"") {
            for count in ATTACHMENTS {
                let name = format!("{name}/{count}");
                let variant = Variant::Defined("ATTACHMENTS", *count);
                compile(&compiler, file, &source, kind, variant, &name, &mut table)?;
            }
        } else if source.contains("#include \"psm/format.glsl\"") {
            for bits in BITS {
                let variant = Variant::Defined("BITS", *bits);
                compile(&compiler, file, &source, kind, variant, &format!("{name}/{bits}"), &mut table)?;
            }
        } else if source.contains("#include \"bins/batch.glsl\"") {
            for lanes in LANES {
                let variant = Variant::Defined("LANES", *lanes);
                compile(&compiler, file, &source, kind, variant, &format!("{name}/{lanes}"), &mut table)?;
            }
        } else {
            compile(&compiler, file, &source, kind, Variant::Only, &name, &mut table)?;
        }
    }
    table.push_str("];\n");
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?).join("shaders.rs");
    fs::write(&out, table).map_err(|e| format!("cannot write {}: {e}", out.display()))
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let fail = |e: std::io::Error| format!("cannot read {}: {e}", folder.display());
    for entry in fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

/// The stage, or nothing for a file that is only included.
fn kind(name: &str) -> Option<ShaderKind> {
    match name.rsplit('.').next() {
        Some("vert") => Some(ShaderKind::Vertex),
        Some("frag") => Some(ShaderKind::Fragment),
        Some("tesc") => Some(ShaderKind::TessControl),
        Some("tese") => Some(ShaderKind::TessEvaluation),
        Some("geom") => Some(ShaderKind::Geometry),
        Some("comp") => Some(ShaderKind::Compute),
        _ => None,
    }
}

/// What a shader is built for.
#[derive(Clone, Copy)]
enum Variant {
    Only,
    Technique(&'static str),
    /// A macro and its value.
    Defined(&'static str, u32),
}

fn compile(
    compiler: &Compiler,
    file: &Path,
    source: &str,
    kind: ShaderKind,
    variant: Variant,
    name: &str,
    table: &mut String,
) -> Result<(), String> {
    let mut options = CompileOptions::new().map_err(|e| format!("cannot start shaderc: {e}"))?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    if let Variant::Defined(name, value) = variant {
        options.add_macro_definition(name, Some(&value.to_string()));
    }
    options.set_include_callback(move |wanted, _, _, _| {
        let path = match variant {
            Variant::Technique(technique) if wanted == "visibility.glsl" => {
                Path::new("glsl").join(technique).join(wanted)
            }
            _ => Path::new("glsl").join(wanted),
        };
        let content = fs::read_to_string(&path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        Ok(ResolvedInclude { resolved_name: path.to_string_lossy().into_owned(), content })
    });
    let spirv = compiler
        .compile_into_spirv(source, kind, &file.to_string_lossy(), "main", Some(&options))
        .map_err(|e| format!("{name}: {e}"))?;
    let _ = write!(table, "    Shader {{ name: {name:?}, words: &[");
    for word in spirv.as_binary() {
        let _ = write!(table, "{word:#x},");
    }
    table.push_str("] },\n");
    Ok(())
}
