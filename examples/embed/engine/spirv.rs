//! The shaders, compiled as the renderer opens. Those that ask for shadows include the file of Gobo's technique as gobo.glsl.

use super::Result;
use gobo::glsl;
use shaderc::{CompileOptions, Compiler, EnvVersion, ResolvedInclude, ShaderKind, TargetEnv};

/// A shader of the renderer's.
#[derive(Clone, Copy)]
pub struct Shader {
    name: &'static str,
    text: &'static str,
    kind: ShaderKind,
}

macro_rules! shader {
    ($name:literal, $kind:ident) => {
        Shader { name: $name, text: include_str!(concat!("../shaders/", $name)), kind: ShaderKind::$kind }
    };
}

pub const MOVE: Shader = shader!("move.comp", Compute);
pub const SORT: Shader = shader!("sort.comp", Compute);
pub const ASK: Shader = shader!("ask.comp", Compute);
pub const GROUND_VERT: Shader = shader!("ground.vert", Vertex);
pub const GROUND_FRAG: Shader = shader!("ground.frag", Fragment);
pub const SMOKE_VERT: Shader = shader!("smoke.vert", Vertex);
pub const SMOKE_FRAG: Shader = shader!("smoke.frag", Fragment);

/// Shaders that others include.
const SHARED: [(&str, &str); 2] =
    [("scene.glsl", include_str!("../shaders/scene.glsl")), ("shadow.glsl", include_str!("../shaders/shadow.glsl"))];

/// Compiles them for one technique. As long as there is one, what GLSL has built in is read once.
pub struct Shaders {
    compiler: Compiler,
    gobo: &'static glsl::File,
}

impl Shaders {
    pub fn new(gobo: &'static glsl::File) -> Result<Self> {
        Ok(Self { compiler: Compiler::new()?, gobo })
    }

    /// A shader's SPIR-V. The technique's file has set 1 to itself, and its constants the ids from 0 on, whichever technique it is.
    pub fn compile(&self, shader: Shader) -> Result<Vec<u32>> {
        let (gobo, mut options) = (self.gobo, CompileOptions::new()?);
        options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
        options.set_warnings_as_errors();
        options.set_include_callback(|name, _, _, _| {
            let shared = SHARED.iter().find(|(shared, _)| *shared == name).map(|(_, text)| *text);
            let content = shared.or_else(|| (name == "gobo.glsl").then_some(gobo.text));
            let content = content.ok_or_else(|| format!("no file {name}"))?.into();
            Ok(ResolvedInclude { resolved_name: name.into(), content })
        });
        let technique = gobo.technique.replace('-', "_");
        for (name, value) in [("SET", "1"), ("BINDING", "0"), ("CONSTANT", "0")] {
            options.add_macro_definition(&format!("GOBO_{}_{name}", technique.to_uppercase()), Some(value));
        }
        for name in ["visibility", "receiver"] {
            options.add_macro_definition(&format!("gobo_{name}"), Some(&format!("gobo_{technique}_{name}")));
        }
        let spirv = self.compiler.compile_into_spirv(shader.text, shader.kind, shader.name, "main", Some(&options));
        Ok(spirv.map_err(|e| format!("with {technique}: {e}"))?.as_binary().to_vec())
    }
}
