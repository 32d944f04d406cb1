//! An engine's shaders around Gobo's GLSL files, compiled as such engines do, without access to this project's folders.

use gobo::glsl::File;
use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};
use std::collections::BTreeSet;
use std::fmt::Write;

#[derive(Clone, Copy, Debug)]
pub enum Stage {
    Fragment,
    Compute,
}

/// Names that the engine declares ahead of the files.
#[derive(Clone, Copy, Debug)]
pub enum Names {
    /// A few declarations with names that files would use without their prefixes.
    Few,
    /// Each of these names is a constant of the engine.
    Declared,
    /// Each of these names is a macro that expands to garbage.
    Macros,
}

/// Returns the words of the code, without comments and directives.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    let code = text.lines().filter(|line| !line.starts_with('#')).flat_map(|line| line.split("//").next());
    let words = code.flat_map(|code| code.split(|c: char| !c.is_alphanumeric() && c != '_'));
    words.filter(|word| word.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

/// Returns a file's names without their prefixes, as in glsl/.
pub fn names_of(file: &File) -> BTreeSet<String> {
    let prefix = format!("gobo_{}_", file.technique.replace('-', "_"));
    let name = |word: &str| word.strip_prefix(&prefix).or_else(|| word.strip_prefix("gobo_")).map(str::to_owned);
    words(file.text).filter_map(name).filter(|name| !is_glsl(name)).collect()
}

/// Returns whether a word belongs to the language: a keyword, a type, a function, a qualifier, vector components.
pub fn is_glsl(word: &str) -> bool {
    const WORDS: &str = "if else for while break continue return const void in out inout struct true false precise \
        float int uint bool vec2 vec3 vec4 ivec2 ivec3 ivec4 uvec2 uvec3 uvec4 bvec2 bvec3 bvec4 \
        sampler2D sampler3D texture2D uimage2D accelerationStructureEXT rayQueryEXT \
        layout set binding scalar std430 r32ui constant_id readonly buffer uniform \
        abs all any atan bitCount clamp cross distance dot equal exp exp2 findLSB floatBitsToUint floor fract \
        greaterThan greaterThanEqual imageLoad inversesqrt length lessThan lessThanEqual log log2 max min mix normalize notEqual pow \
        round sign sqrt step texelFetch textureGather textureLod textureSize uintBitsToFloat unpackHalf2x16 \
        unpackSnorm2x16 unpackUnorm2x16 \
        rayQueryInitializeEXT rayQueryProceedEXT rayQueryGetIntersectionPrimitiveIndexEXT rayQueryConfirmIntersectionEXT \
        rayQueryGetIntersectionTypeEXT rayQueryGetIntersectionBarycentricsEXT gl_RayFlagsTerminateOnFirstHitEXT gl_RayFlagsNoOpaqueEXT \
        gl_RayQueryCommittedIntersectionNoneEXT";
    let is_part = |parts: &str| word.len() <= 4 && word.chars().all(|c| parts.contains(c));
    WORDS.split_whitespace().any(|known| known == word) || is_part("xyzw") || is_part("rgba")
}

/// Returns the names declared outside all braces, found as a reader would: the word before `(`, `=`, `{`, `[` or `;` in an unindented line.
pub fn globals(text: &str) -> Vec<&str> {
    let mut all = Vec::new();
    for line in text.lines().filter(|line| line.starts_with(|c: char| c.is_alphabetic()) && !line.ends_with(':')) {
        let rest = if line.starts_with("layout") { line.split_once(") ").expect("a layout").1 } else { line };
        // A function may return an array, whose type has brackets of its own.
        let rest = match rest.split_once("] ") {
            Some((kind, named)) if kind.split_once('[').is_some_and(|(word, _)| is_glsl(word)) => named,
            _ => rest,
        };
        let head = rest.split(['(', '=', '{', '[', ';']).next().unwrap_or_default();
        all.extend(words(head).last());
    }
    all
}

/// Returns an engine's shader that queries each of `files` at the same point, preceded by `macros`.
pub fn shader(files: &[&File], stage: Stage, names: Names, macros: &str) -> String {
    let mut text = format!("#version 460\n{macros}");
    let mut own: BTreeSet<_> = files.iter().flat_map(|file| names_of(file)).collect();
    match names {
        Names::Few => {
            text += "#define size 7 of them\n#define NODES\n#define MAP_TRANSMITTANCE nothing\n\
                 struct Light { vec4 color; };\nstruct View { mat4 matrix; };\nfloat texel = 0.5;\n\
                 float light_visibility(float light) { return light * texel; }\n"
        }
        Names::Declared => {
            own.remove("lit");
            own.iter().for_each(|name| _ = writeln!(text, "const int {name} = 1;"));
        }
        Names::Macros => own.iter().for_each(|name| _ = writeln!(text, "#define {name} }} not GLSL (")),
    }
    files.iter().for_each(|file| text += file.text);
    let asks: String = files
        .iter()
        .map(|file| {
            let name = file.technique.replace('-', "_");
            format!(
                "e_lit *= gobo_{name}_visibility(e_which, gobo_{name}_receiver(e_which, e_where.xyz, e_where.www));\n"
            )
        })
        .collect();
    text += &match stage {
        Stage::Fragment => format!(
            "layout(set = 0, binding = 0) uniform E_Frame {{ uint e_which; }};\nlayout(location = 0) in vec4 e_where;\n\
             layout(location = 0) out vec4 e_color;\n\
             void main() {{\nfloat e_lit = 1.0;\n{asks}e_color = vec4(e_lit);\n}}\n"
        ),
        Stage::Compute => format!(
            "layout(local_size_x = 64) in;\n\
             layout(set = 0, binding = 0, std430) readonly buffer E_Points {{ uint e_which; uint e_count; vec4 e_points[]; }};\n\
             layout(set = 0, binding = 1, std430) writeonly buffer E_Answers {{ float e_answers[]; }};\n\
             void main() {{\nif (gl_GlobalInvocationID.x >= e_count) {{ return; }}\n\
             vec4 e_where = e_points[gl_GlobalInvocationID.x];\nfloat e_lit = 1.0;\n{asks}\
             e_answers[gl_GlobalInvocationID.x] = e_lit;\n}}\n"
        ),
    };
    text
}

/// Compiles a shader to SPIR-V, without includes and with warnings as errors.
pub fn compile(text: &str, stage: Stage) -> Result<Vec<u8>, String> {
    compile_for(text, stage, OptimizationLevel::Zero)
}

/// Same as [`compile`], at the given optimization level.
pub fn compile_for(text: &str, stage: Stage, level: OptimizationLevel) -> Result<Vec<u8>, String> {
    let compiler = Compiler::new().expect("shaderc");
    let mut options = CompileOptions::new().expect("shaderc");
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(level);
    options.set_warnings_as_errors();
    let kind = match stage {
        Stage::Fragment => ShaderKind::Fragment,
        Stage::Compute => ShaderKind::Compute,
    };
    let spirv = compiler.compile_into_spirv(text, kind, "engine", "main", Some(&options));
    spirv.map(|spirv| spirv.as_binary_u8().to_vec()).map_err(|e| e.to_string())
}
