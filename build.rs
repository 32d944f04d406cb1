//! Compiles every shader under glsl/ to SPIR-V and generates `shaders.rs`, which src/shaders.rs includes: one constant for each shader,
//! each specialization constant and each technique. Nothing is listed here: everything is read from glsl/.
//!
//! - A technique is a folder with a visibility.glsl. A shader that includes "visibility.glsl" is built once per technique.
//! - A technique counts the steps of its look-ups if they contain `#ifdef LOOK_UP_STEPS`.
//! - `CONSTANT(type, NAME, value)` declares a specialization constant. Each name has one id, ID_NAME, in all shaders.
//! - `// variants: LANES 0 1` at the top of a shader builds it once for each value of that macro.
//! - Each technique's look-up is also written as a single file for other programs: see build/flat.rs.
//! - SPIR-V that an earlier build compiled from the same texts is reused: see build/cache.rs.
//! - `// set 1: bins` names a descriptor set: see build/sets.rs.

#[path = "build/cache.rs"]
mod cache;
#[path = "build/commit.rs"]
mod commit;
#[path = "build/flat.rs"]
mod flat;
#[path = "build/head.rs"]
mod head;
#[path = "build/preprocess.rs"]
mod preprocess;
#[path = "build/sets.rs"]
mod sets;
#[path = "build/units.rs"]
mod units;

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, thread};

/// The included name that resolves to a file of the technique's own folder.
const LOOK_UP: &str = "visibility.glsl";

fn main() {
    if let Err(message) = build() {
        // Cargo shows the standard error of a failed build script; its lines read file:line: error: …
        eprintln!("{message}");
        std::process::exit(1);
    }
}

/// Texts of the files in glsl/, by path within it.
type Sources = BTreeMap<String, String>;

/// A shader to compile, once per technique or variant for which it is built.
struct Job {
    /// Path in glsl/: `technique/avsm/cells.comp`.
    file: String,
    kind: ShaderKind,
    /// Technique whose visibility.glsl is meant if the shader includes "visibility.glsl".
    technique: Option<String>,
    /// A macro and its value.
    variant: Option<(String, String)>,
}

fn build() -> Result<(), String> {
    // A folder covers all files in it, so that included files are tracked too.
    commit::SOURCES.iter().for_each(|source| println!("cargo:rerun-if-changed={source}"));
    commit::tell();
    let mut sources = Sources::new();
    collect(Path::new("glsl"), &mut sources)?;
    let out = PathBuf::from(env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let (stamp, is) = (out.join("stamp"), stamp(&sources)?);
    if fs::read_to_string(&stamp).is_ok_and(|was| was == is) {
        return Ok(());
    }
    let techniques: Vec<_> =
        sources.keys().filter_map(|f| f.strip_suffix(LOOK_UP)?.strip_suffix('/')).map(str::to_owned).collect();
    let constants = constants(&sources)?;
    let jobs: Vec<_> = sources
        .iter()
        .filter_map(|(f, s)| Some((f, s, kind(f)?)))
        .flat_map(|(f, s, k)| jobs(f, s, k, &techniques))
        .collect();
    let spirv = compile_all(&out, &sources, &jobs, &constants)?;
    let table = table(&out, &sources, &techniques, &constants, &jobs, &spirv)? + &sets::module(&sources)?;
    write(&out.join("shaders.rs"), table.as_bytes())?;
    write(&out.join("glsl.rs"), flat_files(&out, &sources, &techniques)?.as_bytes())?;
    write(&stamp, is.as_bytes())
}

/// Returns a stamp that changes if shaders have to be compiled again: a hash of their texts and of this program.
fn stamp(sources: &Sources) -> Result<String, String> {
    let mut hasher = DefaultHasher::new();
    sources.hash(&mut hasher);
    let this = env::current_exe().and_then(fs::metadata).map_err(|e| e.to_string())?;
    (this.len(), this.modified().map_err(|e| e.to_string())?).hash(&mut hasher);
    Ok(hasher.finish().to_string())
}

/// Returns the text that src/glsl.rs includes: the technique files, in the order of the folders' paths.
fn flat_files(out: &Path, sources: &Sources, techniques: &[String]) -> Result<String, String> {
    let mut text = String::from("/// A file for each technique.\npub static FILES: &[File] = &[\n");
    for (i, technique) in techniques.iter().enumerate() {
        let flat = flat::flat(sources, technique)?;
        write(&out.join(format!("{i}.glsl")), flat.text.as_bytes())?;
        let name = technique.rsplit('/').next().unwrap_or(technique).replace('_', "-");
        let flat::Flat { first_binding, first_constant, .. } = flat;
        let _ = writeln!(
            text,
            "File {{ technique: {name:?}, text: include_str!(concat!(env!(\"OUT_DIR\"), \"/{i}.glsl\")), first_binding: {first_binding}, first_constant: {first_constant}, bindings: &["
        );
        for flat::Binding { number, name, descriptor, glsl, stride, about } in &flat.bindings {
            let _ = writeln!(
                text,
                "    Binding {{ number: {number}, name: {name:?}, descriptor: vk::DescriptorType::{descriptor}, glsl: {glsl:?}, stride: {stride}, about: {about:?} }},"
            );
        }
        text.push_str("], constants: &[\n");
        for flat::Constant { name, glsl, default, about } in &flat.constants {
            let _ = writeln!(
                text,
                "    Constant {{ name: {name:?}, glsl: {glsl:?}, default: {default:?}, about: {about:?}, inside: constant::{name}.id() }},"
            );
        }
        text.push_str("] },\n");
    }
    text.push_str("];\n");
    Ok(text)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(path, bytes).map_err(|e| format!("cannot write {}: {e}", path.display()))
}

fn collect(folder: &Path, sources: &mut Sources) -> Result<(), String> {
    let fail = |path: &Path, e: std::io::Error| format!("cannot read {}: {e}", path.display());
    for entry in fs::read_dir(folder).map_err(|e| fail(folder, e))? {
        let path = entry.map_err(|e| fail(folder, e))?.path();
        if path.is_dir() {
            collect(&path, sources)?;
        } else {
            let name = path.strip_prefix("glsl").map_err(|e| e.to_string())?.to_string_lossy().into_owned();
            sources.insert(name, fs::read_to_string(&path).map_err(|e| fail(&path, e))?);
        }
    }
    Ok(())
}

/// Returns the shader stage, or `None` for a file that is only included.
fn kind(file: &str) -> Option<ShaderKind> {
    match file.rsplit('.').next() {
        Some("vert") => Some(ShaderKind::Vertex),
        Some("frag") => Some(ShaderKind::Fragment),
        Some("tesc") => Some(ShaderKind::TessControl),
        Some("tese") => Some(ShaderKind::TessEvaluation),
        Some("geom") => Some(ShaderKind::Geometry),
        Some("comp") => Some(ShaderKind::Compute),
        _ => None,
    }
}

/// Returns name → Rust type of the specialization constants, in the order of their ids.
fn constants(sources: &Sources) -> Result<BTreeMap<String, &'static str>, String> {
    let mut all = BTreeMap::new();
    for (file, text) in sources {
        for line in text.lines().filter_map(|l| l.strip_prefix("CONSTANT(")) {
            let mut words = line.split([',', ')']).map(str::trim);
            let (glsl, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default().to_owned());
            let rust = match glsl {
                "uint" | "int" => "u32",
                "bool" => "bool",
                "float" => "f32",
                _ => return Err(format!("{file}: CONSTANT({line}: {glsl} is no type of a constant")),
            };
            if all.insert(name.clone(), rust).is_some_and(|before| before != rust) {
                return Err(format!("{file}: error: the constant {name} has another type elsewhere"));
            }
        }
        // Workgroup sizes: `local_size_x_id = ID_NAME`.
        for name in text.split("_id = ID_").skip(1) {
            all.insert(name.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default().into(), "u32");
        }
    }
    Ok(all)
}

fn jobs(file: &str, text: &str, kind: ShaderKind, techniques: &[String]) -> Vec<Job> {
    let job =
        |technique: Option<&String>, variant| Job { file: file.into(), kind, technique: technique.cloned(), variant };
    if text.contains("#include \"visibility.glsl\"") {
        return techniques.iter().map(|t| job(Some(t), None)).collect();
    }
    let Some(line) = text.lines().find_map(|l| l.strip_prefix("// variants: ")) else { return vec![job(None, None)] };
    let mut words = line.split_whitespace().map(str::to_owned);
    let name = words.next().unwrap_or_default();
    words.map(|value| job(None, Some((name.clone(), value)))).collect()
}

/// Returns the path to which `wanted` resolves in a shader built for `technique`.
fn included(technique: Option<&String>, wanted: &str) -> String {
    match technique {
        Some(technique) if wanted == LOOK_UP => format!("{technique}/{wanted}"),
        _ => wanted.into(),
    }
}

/// Compiles the shaders that are not in the cache, on one thread per processor, since a first build spends most of its time here.
fn compile_all(
    out: &Path,
    sources: &Sources,
    jobs: &[Job],
    constants: &BTreeMap<String, &'static str>,
) -> Result<Vec<Vec<u8>>, String> {
    let cache = cache::Cache::open(out);
    let key = |job: &Job| {
        // Everything else that `compile` does is in this file.
        let options = (include_str!("build.rs"), format!("{:?}", job.kind), constants, &job.technique, &job.variant);
        cache.as_ref().map(|cache| cache.key(&(&job.file, whole(sources, &job.file, job.technique.as_ref()), options)))
    };
    let keys: Vec<Option<String>> = jobs.iter().map(key).collect();
    let next = AtomicUsize::new(0);
    let work = || -> Result<Vec<(usize, Vec<u8>)>, String> {
        let (mut compiler, mut made) = (None, Vec::new());
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some((job, key)) = jobs.get(i).zip(keys.get(i)) else { return Ok(made) };
            let kept = cache.as_ref().zip(key.as_ref());
            if let Some(spirv) = kept.and_then(|(cache, key)| cache.get(key)) {
                made.push((i, spirv));
                continue;
            }
            let compiler = match &mut compiler {
                Some(compiler) => compiler,
                none => none.insert(Compiler::new().map_err(|e| format!("cannot start shaderc: {e}"))?),
            };
            let spirv = compile(compiler, sources, job, constants)?;
            if let Some((cache, key)) = kept {
                cache.put(key, &spirv);
            }
            made.push((i, spirv));
        }
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let shares: Result<Vec<_>, String> = thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        running.into_iter().map(|t| t.join().unwrap_or_else(|_| Err("a compiling thread panicked".into()))).collect()
    });
    let mut all: Vec<_> = shares?.into_iter().flatten().collect();
    all.sort_by_key(|(i, _)| *i);
    if let Some(cache) = &cache {
        cache.keep_only(&keys.into_iter().flatten().collect::<Vec<_>>());
    }
    Ok(all.into_iter().map(|(_, spirv)| spirv).collect())
}

fn compile(
    compiler: &Compiler,
    sources: &Sources,
    job: &Job,
    constants: &BTreeMap<String, &'static str>,
) -> Result<Vec<u8>, String> {
    let mut options = CompileOptions::new().map_err(|e| format!("cannot start shaderc: {e}"))?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    options.add_macro_definition(
        "CONSTANT(type, name, value)",
        Some("layout(constant_id = ID_##name) const type name = value;"),
    );
    for (id, name) in constants.keys().enumerate() {
        options.add_macro_definition(&format!("ID_{name}"), Some(&id.to_string()));
    }
    if let Some((name, value)) = &job.variant {
        options.add_macro_definition(name, Some(value));
    }
    let texts = whole(sources, &job.file, job.technique.as_ref());
    options.set_include_callback(move |wanted, _, _, _| {
        let place = included(job.technique.as_ref(), wanted);
        // Files included in any other way would be missing from the cache's keys.
        let missing = || format!("no file glsl/{place}, or its line does not begin with #include");
        let content = texts.get(&place).ok_or_else(missing)?;
        Ok(ResolvedInclude { resolved_name: format!("glsl/{place}"), content: (*content).to_owned() })
    });
    compiler
        .compile_into_spirv(&sources[&job.file], job.kind, &format!("glsl/{}", job.file), "main", Some(&options))
        .map(|spirv| spirv.as_binary_u8().to_vec())
        .map_err(|e| match &job.technique {
            Some(technique) => format!("with {technique}/{LOOK_UP}: {e}"),
            None => e.to_string(),
        })
}

/// Returns a constant's name: `RESOLVE` for a compute shader, `CAPTURE_FRAG` for the others, `CELLS_LANES_1` for a variant.
fn constant_name(job: &Job) -> String {
    let file = job.file.rsplit('/').next().unwrap_or(&job.file);
    let name = file.strip_suffix(".comp").unwrap_or(file).replace(['.', '-'], "_").to_uppercase();
    match &job.variant {
        Some((variant, value)) => format!("{name}_{variant}_{value}"),
        None => name,
    }
}

/// Returns the name of the module for a folder of glsl/, at any depth.
fn module_name(folder: &str) -> String {
    folder.rsplit('/').next().unwrap_or(folder).replace('-', "_")
}

fn table(
    out: &Path,
    sources: &Sources,
    techniques: &[String],
    constants: &BTreeMap<String, &'static str>,
    jobs: &[Job],
    spirv: &[Vec<u8>],
) -> Result<String, String> {
    // Folder → (name → items of that name).
    let mut modules: BTreeMap<String, BTreeMap<String, Vec<String>>> = BTreeMap::new();
    let mut all = String::new();
    for (i, (job, words)) in jobs.iter().zip(spirv).enumerate() {
        write(&out.join(format!("{i}.spv")), words)?;
        let folder = module_name(job.file.rsplit_once('/').map_or("", |(folder, _)| folder));
        let mut name = job.file.clone();
        name = job.technique.as_ref().map_or(name.clone(), |t| format!("{}/{name}", module_name(t)));
        name = job.variant.as_ref().map_or(name.clone(), |(_, value)| format!("{name}/{value}"));
        let push = push_block(sources, job);
        let shader = format!(
            "Shader {{ name: {name:?}, push: {push:?}, spirv: &Spirv(*include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{i}.spv\"))) }}"
        );
        let constant = constant_name(job);
        let place = modules.entry(folder.clone()).or_default().entry(constant.clone()).or_default();
        let index = place.len();
        place.push(shader);
        let of = if job.technique.is_some() { format!(".0[{index}]") } else { String::new() };
        let _ = writeln!(all, "    &{folder}::{constant}{of},");
    }
    let mut text = String::new();
    for (folder, shaders) in &modules {
        let _ = writeln!(text, "/// Shaders of the folder {folder} in glsl/.\npub mod {folder} {{\n    use super::*;");
        for (name, of) in shaders {
            let asks = jobs.iter().any(|j| {
                j.technique.is_some()
                    && constant_name(j) == *name
                    && j.file.rsplit_once('/').is_some_and(|(of, _)| module_name(of) == *folder)
            });
            let (kind, value) = match &of[..] {
                _ if asks => ("PerTechnique", format!("PerTechnique(&[{}])", of.join(", "))),
                [one] => ("Shader", one.clone()),
                _ => return Err(format!("glsl/{folder}: two shaders of the name {name}")),
            };
            let _ = writeln!(text, "    /// {name}\n    pub static {name}: {kind} = {value};");
        }
        text.push_str("}\n");
    }
    let folders: Vec<_> = techniques.iter().map(|t| module_name(t)).collect();
    let _ = write!(
        text,
        "/// Hands the folders of glsl/ that answer to a macro.\nmacro_rules! with_folders {{ ($then:ident) => {{ $then! {{ {} }} }}; }}\npub(crate) use with_folders;\n",
        folders.join(", ")
    );
    text.push_str(
        "/// The folders of glsl/ that answer: each has a visibility.glsl.\npub mod folder {\n    use super::*;\n",
    );
    for (i, technique) in techniques.iter().enumerate() {
        let word = module_name(technique);
        let name = word.to_uppercase();
        let counts = whole(sources, &format!("{technique}/{LOOK_UP}"), Some(technique))
            .into_values()
            .any(|text| text.contains("#ifdef LOOK_UP_STEPS"));
        let _ = writeln!(
            text,
            "    /// glsl/{technique}/\n    pub const {name}: Folder = Folder {{ place: {i}, name: {word:?}, counts_steps: {counts} }};"
        );
    }
    let all_folders = techniques.iter().map(|t| format!("folder::{}", module_name(t).to_uppercase()));
    let _ = write!(
        text,
        "}}\n/// All of them.\npub static FOLDERS: &[Folder] = &[{}];\n",
        all_folders.collect::<Vec<_>>().join(", ")
    );
    text.push_str(
        "/// Specialization constants, by their names in GLSL.\npub mod constant {\n    use crate::gpu::Constant;\n",
    );
    for (id, (name, rust)) in constants.iter().enumerate() {
        let _ = writeln!(text, "    /// {name}\n    pub const {name}: Constant<{rust}> = Constant::new({id});");
    }
    let _ = write!(text, "}}\n/// Every shader of the program.\npub static ALL: &[&Shader] = &[\n{all}];\n");
    Ok(text)
}

/// Returns the push constant block of a shader and its includes, `Name { type member; … }` on one line; empty if there is none. gpu::Kernel
/// checks the Rust struct against it.
fn push_block(sources: &Sources, job: &Job) -> String {
    for text in whole(sources, &job.file, job.technique.as_ref()).into_values() {
        let code: Vec<_> = text.lines().map(|l| l.split("//").next().unwrap_or_default().trim()).collect();
        if let Some((_, block)) = code.join(" ").split_once("layout(push_constant, scalar) uniform ") {
            let block = block.split('}').next().unwrap_or_default();
            return format!("{} }}", block.split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
    String::new()
}

/// Returns the texts of a file and of everything that it includes, by path.
fn whole<'s>(sources: &'s Sources, file: &str, technique: Option<&String>) -> BTreeMap<String, &'s str> {
    let (mut open, mut texts) = (vec![file.to_owned()], BTreeMap::new());
    while let Some(file) = open.pop() {
        let Some(text) = sources.get(&file).filter(|_| !texts.contains_key(&file)) else { continue };
        let includes = text.lines().filter_map(|l| l.strip_prefix("#include \""));
        open.extend(includes.map(|l| included(technique, l.trim_end_matches('"'))));
        texts.insert(file, &text[..]);
    }
    texts
}
