//! Values: a shader built from a technique's file, in an engine's set with the technique's descriptors and constants, returns the same bits
//! as the project's own.

use super::engine::{Stage, compile_for};
use super::shapes;
use crate::support::{self, gpu_test, scenes, some, spec};
use ash::vk::DescriptorType;
use gobo::gpu::{
    Bindings, Border, Buffer, Constant, Constants, Context, Format, Image, ImageUse, Kernel, Memory, Resource, Shader,
    Spirv, groups,
};
use gobo::query::Query;
use gobo::reference::truth::space_points;
use gobo::scene::Scene;
use gobo::technique::{Answer, Opened, open};
use gobo::world::World;
use shaderc::OptimizationLevel;

/// First binding of the look-up in the engine's set, after the engine's own.
const FIRST: u32 = 2;
/// First constant of the look-up among the engine's.
const FIRST_ID: u32 = 40;
/// Extinction of a queried color.
const COLOR: f32 = 0.4;
/// Number of query points.
const POINTS: usize = 2048;

/// Returns the engine's shader, with its own two bindings and then the look-up's in the same set. With an `extinction` it looks up a color.
fn shader(answer: &Answer, light: usize, extinction: Option<f32>) -> Shader {
    let file = answer.file();
    let name = file.technique.replace('-', "_");
    let upper = name.to_uppercase();
    let visibility = format!("gobo_{name}_visibility({light}u, points[i].xyz)");
    let answered = extinction.map_or(visibility.clone(), |extinction| {
        format!("gobo_{name}_colors({visibility}, vec3(1.0, {extinction:?}, 0.0)).y")
    });
    let text = format!(
        "#version 460\n#define size not a size\nstruct Light {{ vec4 color; }};\nfloat texel = 1.0;\n\
         #define GOBO_{upper}_SET 0\n#define GOBO_{upper}_BINDING {FIRST}\n#define GOBO_{upper}_CONSTANT {FIRST_ID}\n{}\
         layout(local_size_x = 64) in;\n\
         layout(set = 0, binding = 0, std430) readonly buffer Points {{ vec4 points[]; }};\n\
         layout(set = 0, binding = 1, std430) writeonly buffer Answers {{ float answers[]; }};\n\
         void main() {{\n\
         uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;\n\
         if (i < points.length()) {{ answers[i] = {answered}; }}\n}}\n",
        file.text
    );
    let spirv = compile_for(&text, Stage::Compute, OptimizationLevel::Performance).expect(file.technique);
    let words: Vec<u32> = spirv.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let bytes: &'static [u8] = bytemuck::cast_slice(words.leak());
    // SAFETY: `Spirv` has a single field, this slice, and requires the alignment of the words it was cast from.
    let spirv = unsafe { &*(std::ptr::from_ref(bytes) as *const Spirv) };
    // Pipelines are identified by their shader's name.
    Shader { name: format!("engine/{name}/{light}/{extinction:?}").leak(), push: "", spirv }
}

/// Creates a placeholder of this kind, to fill the engine's set until the look-up's own resource is written.
fn other(context: &Context, kind: DescriptorType) -> Resource {
    match kind {
        DescriptorType::STORAGE_BUFFER => {
            Resource::Buffer(Buffer::new(context, "other", 256, Memory::Device).expect("a buffer"))
        }
        DescriptorType::COMBINED_IMAGE_SAMPLER => {
            let image = Image::new(context, "other", Format::R16G16B16A16_SFLOAT, [1, 1], ImageUse::Storage);
            Resource::Sampled(image.expect("an image"), Border::Zero)
        }
        DescriptorType::SAMPLED_IMAGE => {
            let image = Image::new(context, "other", Format::R16G16B16A16_SFLOAT, [1, 1], ImageUse::Storage);
            Resource::Texture(image.expect("an image"))
        }
        DescriptorType::STORAGE_IMAGE => {
            let image = Image::new(context, "other", Format::R32_UINT, [1, 1], ImageUse::Storage);
            Resource::StorageImage(image.expect("an image"))
        }
        kind => panic!("{kind:?}"),
    }
}

/// Returns the look-ups of the engine's shader for light `light` at `points`, or of a color with this extinction.
fn asked(context: &Context, answer: &Answer, light: usize, points: &[[f32; 3]], extinction: Option<f32>) -> Vec<f32> {
    let padded: Vec<_> = points.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
    let answers = Buffer::new(context, "answers", 4 * points.len() as u64, Memory::Device).expect("a buffer");
    let mut resources = vec![
        Resource::Buffer(Buffer::with_data(context, "points", &padded).expect("a buffer")),
        Resource::Buffer(answers.clone()),
    ];
    let layout = answer.layout(FIRST);
    for (binding, slot) in (FIRST..).zip(&layout) {
        assert_eq!((slot.binding, slot.descriptor_count), (binding, 1));
        resources.push(other(context, slot.descriptor_type));
    }
    let set = Bindings::new(context, "engine", &resources).expect("a set");
    // SAFETY: the set belongs to this device and has the bindings of `layout` from FIRST on; no recorded command uses it yet.
    unsafe { answer.write_into(set.set(), FIRST) };
    let constants = answer.specialization(FIRST_ID).into_iter().fold(Constants::new(), |all, (id, word)| {
        assert!(((FIRST_ID..).zip(answer.file().constants)).any(|(own, _)| own == id), "{id}");
        all.set(Constant::new(id), word)
    });
    let kernel: Kernel =
        Kernel::compute(context, &shader(answer, light, extinction), &[&set], &constants).expect("a kernel");
    let [x, y] = groups((points.len() as u64).div_ceil(64));
    context
        .submit(|commands| commands.pass("engine", |pass| pass.dispatch(&kernel, &(), [x, y, 1])))
        .expect("submitted");
    answers.read(points.len()).expect("read")
}

/// Asserts that both look-ups of `text` for `scene` agree bit for bit.
fn answers_alike(context: &Context, scene: &Scene, text: &str) {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened: Opened = support::opened(open(context, &world, &spec(text)), text);
    opened.build(&world).expect(text);
    let answer = opened.technique.answer();
    for light in 0..scene.lights.len() {
        let points = space_points(scene, light, POINTS);
        let own = Query::new(context, light, &points).expect("room").ask(&answer).expect("answered");
        let theirs = asked(context, &answer, light, &points, None);
        let bits = |all: &[f32]| all.iter().map(|a| a.to_bits()).collect::<Vec<_>>();
        let off = bits(&own).iter().zip(bits(&theirs)).filter(|(a, b)| **a != *b).count();
        assert_eq!(off, 0, "{text}, {}, light {light}: of {} answers", scene.name, own.len());
        if answer.file().text.contains("_colors(") {
            let query = Query::new(context, light, &points).expect("room");
            query.query(&query.color_kernel(&answer, COLOR).expect("a kernel")).expect("asked");
            let theirs = asked(context, &answer, light, &points, Some(COLOR));
            // Only one of the two shaders knows the exponent at compile time, so their results may differ by rounding.
            let apart =
                query.answers().expect("read").iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-6, "{text}, {}, light {light}: colors are {apart} apart", scene.name);
        }
        let partly = own.iter().filter(|a| **a > 0.01 && **a < 0.99).count();
        println!("{text}, {}, light {light}: {} points, {partly} in penumbra", scene.name, own.len());
    }
}

#[test]
fn smoke_is_answered_alike() {
    if crate::support::is_long("smoke_is_answered_alike") {
        return;
    }
    gpu_test("smoke_is_answered_alike", |context| {
        // Files of techniques that see smoke have colors; those of techniques for meshes alone do not.
        for (technique, has) in [("avsm", true), ("density-grid", true), ("shadow-map", false), ("none", false)] {
            let file = gobo::glsl::file(technique).expect("a file");
            let name = format!("vec3 gobo_{}_colors(float", technique.replace('-', "_"));
            assert_eq!(file.text.contains(&name), has, "{technique}");
        }
        let first = [
            "avsm",
            "avsm:nodes=4,storage=packed,curve=linear",
            "psm:slices=64",
            "beer-shadow-map",
            "translucency-map",
            "layers:range=front,storage=r16",
            "fourier:coefficients=7",
            "wavelet:range=scene",
            "moments:basis=trigonometric,storage=r16",
            "uncompressed:size=64",
            "stochastic:samples=4",
            "density-grid:size=64,direction=mean",
            "marched:size=64,grid=64,nodes=4",
            "optical-depth-grid:cells=32",
            "grid-query",
            "deep-shadow-map:size=64",
        ];
        let others = [
            "avsm:nodes=16,filter=gaussian,radius=3",
            "psm:slices=64,filter=box",
            "layers:layers=8",
            "fourier:storage=r16f",
            "moments:moments=8",
            "density-grid:size=64,march=ratio",
        ];
        let texts = some(first.into_iter().chain(others), first.len());
        for text in crate::support::every_third("smoke_is_answered_alike", texts) {
            answers_alike(context, &scenes::random(), text);
        }
        answers_alike(context, &scenes::four_lights(), "avsm:detail=even");
        answers_alike(context, &scenes::four_lights(), "beer-shadow-map");
    });
}

/// Ray queries are excluded: the placeholder for an acceleration structure before the set is written would have to be one.
#[test]
fn meshes_are_answered_alike() {
    if crate::support::is_costly("meshes_are_answered_alike") {
        return;
    }
    gpu_test("meshes_are_answered_alike", |context| {
        for scene in [shapes::houses(), shapes::soup()] {
            for text in [
                "shadow-map",
                "shadow-map:filter=3",
                "voxel-grid:size=64",
                "voxel-grid:size=64,cell=mask",
                "voxelized:size=256",
                "voxelized:size=256,filter=3",
            ] {
                answers_alike(context, &scene, text);
            }
        }
    });
}
