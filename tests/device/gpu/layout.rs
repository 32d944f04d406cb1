//! Every buffer block and push-constant block of every shader, as laid out in SPIR-V, against the Rust struct that is copied into it.
//!
//! The build strips names from the SPIR-V, so the struct at each binding and the names of its members are read from the GLSL, while types,
//! offsets and strides come from the SPIR-V. Both have to agree with Rust. The text of a push-constant block is in [`Shader::push`], which
//! a kernel compares with its Rust struct on creation; here that text is compared with the SPIR-V, and with every push_struct! in src/,
//! including those of kernels that no test creates.

use crate::support::spirv::without_constant_choices;
use gobo::gpu::Shader;
use gobo::grid::{GridData, ListTotals};
use gobo::lights::indirect::ViewPointData;
use gobo::maps::{
    BinTotals, Extents, ItemData, Map, OpaqueDraw, OpaqueItem, OpaqueTotals, SegmentData, Survey, TilePart,
};
use gobo::scene::{Body, Caster, Jet, Law, View};
use gobo::shaders::ALL;
use gobo::shading::{FieldData, PaintTotals, PartData, PatchData, ReservoirData, SlotData};
use gobo::shading::{many_lights::FrameData, many_lights::QueueData};
use gobo::technique::{ClusterData, DeepState, LevelCounts, NodeData, PointData, PointsData, TreeData};
use gobo::world::{GatherTotals, LightData, TriangleData};
use spirq::ReflectConfig;
use spirq::ty::{ScalarType, Type};
use spirq::var::Variable;
use std::collections::{BTreeMap, BTreeSet};
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A field of a Rust struct: name, offset, type.
type Field = (&'static str, usize, &'static str);

/// A Rust struct: size and fields.
struct Twin {
    size: usize,
    fields: Vec<Field>,
}

fn type_of<S, T>(_: fn(&S) -> &T) -> &'static str {
    std::any::type_name::<T>()
}

macro_rules! twin {
    ($type:ty, $($field:ident),+) => {
        Twin {
            size: size_of::<$type>(),
            fields: vec![$((stringify!($field), offset_of!($type, $field), type_of(|s: &$type| &s.$field))),+],
        }
    };
}

/// A triangle read in three loads: the bytes of [`TriangleData`], whose corners come first.
#[repr(C)]
struct TriangleRows {
    rows: [[f32; 4]; 3],
}

const _: () = assert!(size_of::<TriangleRows>() == size_of::<TriangleData>() && offset_of!(TriangleData, corners) == 0);

/// GLSL struct → Rust struct.
fn twins() -> BTreeMap<&'static str, Twin> {
    BTreeMap::from([
        (
            "Light",
            twin!(LightData, position, kind, direction, cos_cone, radiance, falloff, first_map, map_count, has_opaque),
        ),
        ("ViewPoint", twin!(ViewPointData, position, area, normal, weight, is_open)),
        ("Reservoir", twin!(ReservoirData, light, weight, frames, z, normal)),
        ("FieldPlace", twin!(FieldData, origin, extinction, rows, size, first_slot, color, last_slot, first_block)),
        ("FieldSlot", twin!(SlotData, block, number)),
        ("Map", twin!(Map, caster_view, opaque)),
        ("IsmPoint", twin!(PointData, position, normal)),
        ("IsmCluster", twin!(ClusterData, middle, reach, normal, spread, sides, thick, closed)),
        ("IsmPoints", twin!(PointsData, scale, total, radius, area)),
        ("Extents", twin!(Extents, low, high)),
        ("Item", twin!(ItemData, key, index)),
        ("Part", twin!(PartData, tile, number, count, slot)),
        ("Patch", twin!(PatchData, corners, first, parts)),
        (
            "PaintTotals",
            twin!(
                PaintTotals,
                entries,
                entry_groups,
                wanted,
                most_wanted,
                sorted,
                part_entries,
                slots,
                parts,
                part_groups,
                split,
                split_groups
            ),
        ),
        (
            "BinTotals",
            twin!(
                BinTotals,
                entries,
                entries_high,
                tiles_used,
                parts,
                groups_x,
                groups_y,
                groups_z,
                cut_short,
                fullest
            ),
        ),
        ("GatherTotals", twin!(GatherTotals, asked, refused)),
        ("OpaqueDraw", twin!(OpaqueDraw, vertex_count, instance_count, first_vertex, first_instance)),
        ("OpaqueItem", twin!(OpaqueItem, triangle, map_share)),
        ("OpaqueTotals", twin!(OpaqueTotals, items, groups_x, groups_y, groups_z)),
        ("Survey", twin!(Survey, cells, edges, optical_depth)),
        ("TilePart", twin!(TilePart, tile, map_part, first, count)),
        ("View", twin!(View, origin, projection, right, scale_x, up, scale_y, forward, near, far, width, height)),
        ("Caster", twin!(Caster, position, radius, axis, density)),
        ("Segment", twin!(SegmentData, entry, exit, optical_depth, next)),
        ("Node", twin!(NodeData, depth, value)),
        ("Triangle", twin!(TriangleData, corners, albedo)),
        ("TriangleRows", twin!(TriangleRows, rows)),
        (
            "Tree",
            twin!(
                TreeData,
                origin,
                size,
                right,
                levels,
                up,
                root,
                forward,
                root_at,
                shortcuts,
                at,
                pointer_bits,
                perspective,
                first,
                faces
            ),
        ),
        ("Frame", twin!(FrameData, camera, corner, across, down, edge)),
        ("Queue", twin!(QueueData, groups_x, groups_y, groups_z, jobs, demanded, end)),
        ("Grid", twin!(GridData, origin, voxel, per_unit, size, low, high)),
        ("DeepState", twin!(DeepState, nodes, covered, error, low, high)),
        ("ListTotals", twin!(ListTotals, pairs, voxels, overflowed)),
        ("Body", twin!(Body, place, speed)),
        ("Jet", twin!(Jet, position, width, speed, spread)),
        (
            "Law",
            twin!(
                Law, low, high, gravity, drag, pull, reach, bounce, slide, rest, fastest, radius, extinction, appear,
                vanish, life
            ),
        ),
        (
            "LevelCounts",
            twin!(
                LevelCounts,
                candidates,
                demanded,
                base,
                unique,
                units,
                at,
                pointer_bits,
                lost,
                groups,
                blocks,
                unique_groups,
                unique_blocks
            ),
        ),
    ])
}

/// Returns the file of a shader, and the technique it was built for.
fn place(shader: &str) -> (&str, Option<&str>) {
    let is_file = |file: &str| glsl().join(file).is_file();
    // technique/avsm/unpack.comp/4 is technique/avsm/unpack.comp with ATTACHMENTS 4.
    let file = match shader.rsplit_once('/') {
        Some((file, _)) if is_file(file) => file,
        _ => shader,
    };
    // avsm/query/points.comp is query/points.comp, built with technique/avsm/visibility.glsl.
    match file.split_once('/') {
        Some((technique, rest)) if !is_file(file) => (rest, Some(technique)),
        _ => (file, None),
    }
}

fn glsl() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl")
}

/// [`read_source`] of every shader, read once each.
static SOURCES: LazyLock<BTreeMap<&str, String>> =
    LazyLock::new(|| ALL.iter().map(|shader| (shader.name, read_source(shader.name))).collect());

fn source(shader: &str) -> &'static str {
    &SOURCES[shader]
}

/// Returns the GLSL of a shader with all its includes, without comments, and with named bindings of a set expanded.
fn read_source(shader: &str) -> String {
    let (glsl, (file, technique)) = (glsl(), place(shader));
    let (mut text, mut seen, mut open) = (String::new(), BTreeSet::new(), vec![file.to_owned()]);
    let mut bindings = BTreeMap::new();
    while let Some(file) = open.pop() {
        let path = match technique {
            Some(technique) if file == "visibility.glsl" => glsl.join("technique").join(technique).join(&file),
            _ => glsl.join(&file),
        };
        if !seen.insert(path.clone()) {
            continue;
        }
        for line in std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())).lines() {
            if let Some(included) = line.strip_prefix("#include \"") {
                open.push(included.trim_end_matches('"').to_owned());
            }
            if let Some(macro_of) = line.strip_prefix("#define ") {
                // A macro declares nothing by itself.
                if let Some((head, declaration)) = macro_of.split_once(" layout(set") {
                    let name = head.trim_end_matches("(access)").to_owned();
                    bindings.insert(name, format!("layout(set{declaration}"));
                }
                continue;
            }
            text += line.split("//").next().unwrap_or_default();
            text.push('\n');
        }
    }
    let written_out = |line: &str| {
        let (name, access) = line.split_once('(').map_or((line, ""), |(name, rest)| (name, rest.trim_end_matches(')')));
        bindings
            .get(name)
            .map_or(line.to_owned(), |declaration| declaration.replace(" access ", &format!(" {access} ")))
    };
    text.lines().map(|line| written_out(line.trim()) + "\n").collect()
}

/// GLSL type and name of each member.
type Members = Vec<(String, String)>;

/// Returns the members between the braces after `at`. An array's type includes its length: `vec3[3]`.
fn members(text: &str, at: usize) -> Members {
    let open = at + text[at..].find('{').expect("{");
    let close = open + text[open..].find('}').expect("}");
    let mut all = Vec::new();
    for declaration in text[open + 1..close].split(';').map(str::trim).filter(|d| !d.is_empty()) {
        let (kind, name) = declaration.split_once(' ').unwrap_or_else(|| panic!("{declaration}"));
        let (name, array) = name.split_once('[').map_or((name, String::new()), |(n, a)| (n, format!("[{a}")));
        all.push((format!("{kind}{array}"), name.trim().to_owned()));
    }
    all
}

/// Returns the buffer blocks that a text declares: set and binding → members.
fn blocks(text: &str) -> BTreeMap<(u32, u32), Members> {
    let mut all = BTreeMap::new();
    for (at, _) in text.match_indices("layout(") {
        let close = at + text[at..].find(')').expect(")");
        let rest = &text[close + 1..];
        let head = rest.split(['{', ';']).next().unwrap_or_default();
        let number = |key: &str| {
            let value = text[at + 7..close].split(',').find_map(|p| p.split_once('=').filter(|(k, _)| k.trim() == key));
            value.map(|(_, v)| match v.trim() {
                "GOBO_SET" => 1,
                v => v.parse().unwrap_or_else(|_| panic!("{key} = {v}")),
            })
        };
        if let (Some(set), Some(binding)) = (number("set"), number("binding"))
            && head.contains(" buffer ")
        {
            all.insert((set, binding), members(text, close));
        }
    }
    all
}

/// Returns the Rust name of a SPIR-V type that is not a struct.
fn rust_name(ty: &Type) -> String {
    match ty {
        Type::Scalar(ScalarType::Float { bits: 32 }) => "f32".into(),
        Type::Scalar(ScalarType::Integer { bits: 32, is_signed: false }) => "u32".into(),
        Type::Scalar(ScalarType::Integer { bits: 32, is_signed: true }) => "i32".into(),
        Type::Scalar(ScalarType::Integer { bits: 64, is_signed: false }) => "u64".into(),
        Type::Vector(v) => format!("[{}; {}]", rust_name(&Type::Scalar(v.scalar_ty.clone())), v.nscalar),
        Type::Array(a) => {
            let (stride, size) = (a.stride.expect("a stride"), size(&a.element_ty));
            assert_eq!(stride, size, "Rust arrays have no padding");
            format!("[{}; {}]", rust_name(&a.element_ty), a.nelement.expect("a length"))
        }
        other => panic!("no Rust type for {other:?}"),
    }
}

/// Returns the bytes of a type, including padding between members but not after the last.
fn size(ty: &Type) -> usize {
    match ty {
        Type::Scalar(ScalarType::Integer { bits, .. }) => *bits as usize / 8,
        Type::Scalar(_) => 4,
        Type::Vector(v) => 4 * v.nscalar as usize,
        Type::Array(a) => a.stride.expect("a stride") * a.nelement.expect("a length") as usize,
        Type::Struct(s) => s.members.last().map_or(0, |m| m.offset.expect("an offset") + size(&m.ty)),
        other => panic!("{other:?} has no size"),
    }
}

/// Checks a value of the GLSL type `glsl` against its twin, and records which structs were seen.
fn check(what: &str, glsl: &str, ty: &Type, seen: &mut BTreeMap<String, usize>) {
    if let (Type::Array(a), Some((of, _))) = (ty, glsl.split_once('['))
        && matches!(*a.element_ty, Type::Struct(_))
    {
        assert_eq!(a.stride, Some(size(&a.element_ty)), "{what}: Rust arrays have no padding");
        return check(what, of, &a.element_ty, seen);
    }
    let Type::Struct(s) = ty else {
        let known = match glsl {
            "float" => "f32",
            "int" => "i32",
            "uint" => "u32",
            "uint64_t" => "u64",
            "uvec2" => "[u32; 2]",
            "uvec3" => "[u32; 3]",
            "uvec4" => "[u32; 4]",
            "uint[15]" => "[u32; 15]",
            "uint[3]" => "[u32; 3]",
            "uint[6]" => "[u32; 6]",
            "vec2" => "[f32; 2]",
            "vec3" => "[f32; 3]",
            "vec4" => "[f32; 4]",
            "vec3[3]" => "[[f32; 3]; 3]",
            "vec4[3]" => "[[f32; 4]; 3]",
            _ => panic!("{what}: {glsl} has no Rust type here"),
        };
        assert_eq!(rust_name(ty), known, "{what}: {glsl}");
        return;
    };
    let all = twins();
    let twin = all.get(glsl).unwrap_or_else(|| panic!("{what}: struct {glsl} has no twin in this test; add it"));
    *seen.entry(glsl.into()).or_default() += 1;
    let text = struct_source(glsl);
    assert_eq!(s.members.len(), text.len(), "{what}: {glsl} in SPIR-V and in GLSL");
    assert_eq!(s.members.len(), twin.fields.len(), "{what}: {glsl} in SPIR-V and in Rust");
    for ((member, (kind, name)), (field, offset, rust)) in s.members.iter().zip(&text).zip(&twin.fields) {
        assert_eq!(name, field, "{what}: {glsl}");
        assert_eq!(member.offset, Some(*offset), "{what}: {glsl}.{name}");
        if matches!(member.ty, Type::Struct(_)) {
            assert!(rust.ends_with(&format!("::{kind}")), "{what}: {glsl}.{name} is {rust} in Rust");
        } else {
            assert_eq!(rust_name(&member.ty), *rust, "{what}: {glsl}.{name}");
        }
        check(&format!("{what}: {glsl}.{name}"), kind, &member.ty, seen);
    }
    assert_eq!(size(ty), twin.size, "{what}: size of {glsl}");
}

/// Returns the members of a GLSL struct, wherever it is declared.
fn struct_source(name: &str) -> Members {
    let head = format!("struct {name} {{");
    let text = SOURCES.values().find(|text| text.contains(&head)).expect("some shader declares it");
    members(text, text.find(&head).expect("found above"))
}

fn variables(shader: &Shader) -> Vec<Variable> {
    let mut config = ReflectConfig::new();
    let entry_points = config.spv(without_constant_choices(shader.words())).ref_all_rscs(true).reflect();
    entry_points.unwrap_or_else(|e| panic!("{}: {e}", shader.name)).remove(0).vars
}

#[test]
fn structs_lie_as_the_shaders_read_them() {
    let mut seen = BTreeMap::new();
    for shader in ALL {
        let blocks = blocks(source(shader.name));
        for variable in variables(shader) {
            let Variable::Descriptor { desc_bind, ty: Type::Struct(block), .. } = &variable else { continue };
            let place = (desc_bind.set(), desc_bind.bind());
            let what = format!("{} at {place:?}", shader.name);
            let declared = blocks.get(&place).unwrap_or_else(|| panic!("{what}: not declared in the GLSL"));
            assert_eq!(block.members.len(), declared.len(), "{what}");
            for (member, (kind, name)) in block.members.iter().zip(declared) {
                let what = format!("{what}: {name}");
                match (&member.ty, kind.strip_suffix("[]")) {
                    // A runtime array: the stride equals that of `[T]` in Rust.
                    (Type::Array(a), Some(element)) => {
                        assert_eq!((member.offset, a.nelement), (Some(0), None), "{what}");
                        assert_eq!(a.stride, Some(size(&a.element_ty)), "{what}: stride");
                        check(&what, element, &a.element_ty, &mut seen);
                    }
                    (ty, _) => check(&what, kind, ty, &mut seen),
                }
            }
        }
    }
    for name in twins().keys() {
        assert!(seen.contains_key(*name), "struct {name} is in no shader: the test proves nothing of it");
    }
}

/// Collects every push_struct! under a folder of Rust files by name: the GLSL block of the same name has to match.
fn push_structs(folder: &Path, all: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            push_structs(&path, all);
            continue;
        }
        if path.extension().is_none_or(|ending| ending != "rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        let code: Vec<_> = text.lines().map(|l| l.split("//").next().unwrap_or_default()).collect();
        for after in code.join(" ").split("push_struct! {").skip(1) {
            let (head, rest) = after.split_once('{').expect("{");
            let name = head.split_whitespace().last().expect("a name");
            let member = |declared: &str| {
                let (name, kind) = declared.split_once(':').unwrap_or_else(|| panic!("{name}: {declared}"));
                let kind = match kind.trim() {
                    "u32" => "uint",
                    "f32" => "float",
                    "[u32; 2]" => "uvec2",
                    "[f32; 3]" => "vec3",
                    other => panic!("{name}: {other} has no GLSL type here; add it"),
                };
                format!("{kind} {};", name.split_whitespace().last().expect("a name"))
            };
            let members = rest.split('}').next().expect("}").split(',').map(str::trim).filter(|m| !m.is_empty());
            let block = format!("{name} {{ {} }}", members.map(member).collect::<Vec<_>>().join(" "));
            let before = all.insert(name.to_owned(), block.clone());
            assert!(before.is_none_or(|before| before == block), "{name} is declared twice, and not alike");
        }
    }
}

/// The text that a kernel compares with its Rust struct matches the SPIR-V: consecutive numbers without padding, as in Rust. Each block has
/// one Rust struct, and each such struct occurs in some shader.
#[test]
fn push_constants_lie_as_the_shaders_read_them() {
    let mut structs = BTreeMap::new();
    push_structs(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut structs);
    let (mut used, mut read) = (BTreeSet::new(), BTreeSet::new());
    for shader in ALL {
        let (what, push) = (shader.name, shader.push);
        let declared = source(what).contains("push_constant");
        assert_eq!(declared, !push.is_empty(), "{what}: the build found {push:?}");
        let mut found = variables(shader).into_iter().filter_map(|v| match v {
            Variable::PushConstant { ty, .. } => Some(ty),
            _ => None,
        });
        let (in_spirv, second) = (found.next(), found.next());
        assert!(second.is_none(), "{what}: two blocks of push constants");
        if push.is_empty() {
            assert!(in_spirv.is_none(), "{what}: push constants that the build did not find");
            continue;
        }
        let name = push.split_whitespace().next().expect("a name");
        assert_eq!(structs.get(name).map(String::as_str), Some(push), "{what}: no push_struct! of src/ is this block");
        used.insert(name);
        // Declared in an include but never read: the SPIR-V keeps nothing of it.
        let Some(ty) = in_spirv else { continue };
        read.insert(name);
        let Type::Struct(block) = &ty else { panic!("{what}: {ty:?}") };
        let declared = members(push, 0);
        assert_eq!(block.members.len(), declared.len(), "{what}: {push}");
        let mut offset = 0;
        for (member, (kind, name)) in block.members.iter().zip(&declared) {
            assert_eq!(member.offset, Some(offset), "{what}: {name}");
            check(&format!("{what}: {name}"), kind, &member.ty, &mut BTreeMap::new());
            offset += size(&member.ty);
        }
        assert!(size(&ty) == offset && offset <= 128, "{what}: {offset} bytes, and kernels declare 128");
    }
    for name in structs.keys().map(String::as_str) {
        assert!(used.contains(name), "push_struct! {name} is pushed to no shader");
        assert!(read.contains(name), "push_struct! {name} is read by no shader: the test proves nothing of it");
    }
}
