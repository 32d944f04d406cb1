//! Meshes, splats, lights and cameras of glTF 2.0 files.

use crate::scene::files::contents::Contents;
use crate::scene::files::gltf_accessor;
use crate::scene::files::gltf_alpha::{AlphaReader, Surface};
use crate::scene::files::gltf_animation::GltfAnimation;
use crate::scene::files::gltf_document::{self, GltfDocument};
use crate::scene::files::gltf_motion::{Motion, Source};
use crate::scene::files::gltf_nodes::{self, Nodes, PlacedNode};
use crate::scene::files::gltf_splat_rows;
use crate::scene::files::gltf_vertices::{self, Vertices};
use crate::scene::files::placement::Placement;
use crate::scene::files::splat_file::{Row, SplatCollector};
use crate::scene::{Alpha, Mesh, files::gltf_stage, files::input, files::mesh_file};
use crate::{Error, Result};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use std::path::Path;
use std::sync::Arc;

/// The largest number of triangles, and of vertices, that one file may expand to. A small glTF file can place a large mesh many times, and
/// use the same vertices in many primitives.
pub(in crate::scene) const MOST: usize = 1 << 26;

/// The largest number of splats of one file, which may place the same ones many times.
const MOST_SPLATS: usize = 1 << 25;

const WAY_OUT: &str = "export the splats again, or correct the file";

/// What a file has that casts nothing, or is not as the file says.
#[derive(Default)]
struct Left {
    /// Primitives of points or lines.
    lines: usize,
    /// Primitives without positions.
    shapeless: usize,
    /// Hidden nodes that have a mesh or a light.
    hidden: usize,
    /// Primitives with a color beyond [0, 1].
    bright: usize,
    /// Spot lights that fade from an inner cone.
    cones: usize,
}

/// Loads and places the scene of a `.gltf` or `.glb` file: a mesh for each primitive placed by a node, the lights
/// (KHR_lights_punctual), and the first perspective camera, all at rest. Meshes that the animation of that name moves, or the first, come with
/// their [`Motion`]. Textures are ignored but for their alpha.
///
/// # Errors
/// [`Error::Input`] as for [`gltf_document::open`], and if a position is not finite, a vertex index is out of range, or a light or a camera
/// fails the checks of [`crate::scene::files::stage`]; if the alpha of a material or a vertex is not in [0, 1], or a texture that alpha
/// needs cannot be read.
pub(in crate::scene) fn load(path: &Path, placement: &Placement, animation: Option<&str>) -> Result<Contents> {
    let file = Arc::new(gltf_document::open(path)?);
    let animation =
        GltfAnimation::read(&file, animation).map_err(|cause| input::error(path, cause, "correct the file"))?;
    let mut alphas = AlphaReader::new(path, &file);
    let nodes = Nodes::new(path, &file, &[])?;
    let mut sources = Vec::new();
    let (mut taken, mut of_splats) = (SplatCollector::default(), Vec::new());
    let mut contents = Contents::default();
    let mut left = Left::default();
    let [mut triangles, mut vertices] = [0_usize; 2];
    for placed in &nodes.all {
        let node = &placed.node;
        let wrong = |cause| input::error(path, format!("node {}: {cause}", node.index()), "correct the file");
        if contents.camera.is_none() {
            let camera = gltf_stage::camera(&file.document, node, placed.to_world).map_err(wrong)?;
            contents.camera = camera.map(|camera| placement.camera(&camera)).transpose().map_err(wrong)?;
        }
        if placed.hidden {
            left.hidden += usize::from(node.mesh().is_some() || node.light().is_some());
            continue;
        }
        if let Some(light) = node.light() {
            left.cones += usize::from(gltf_stage::has_soft_edge(&light));
            let light = gltf_stage::light(&light, placed.to_world).and_then(|light| placement.light(light));
            contents.lights.push(light.map_err(wrong)?);
        }
        for splats in file.splats.iter().filter(|splats| node.mesh().is_some_and(|mesh| mesh.index() == splats.mesh)) {
            let wrong = |cause| input::error(path, format!("splats of mesh {}: {cause}", splats.mesh), WAY_OUT);
            for place in gltf_nodes::places(&file, placed).map_err(wrong)? {
                let take = |number: usize, row: &Row| taken.add(number, row, placement);
                gltf_splat_rows::load(&file, splats, place, &mut of_splats, take).map_err(wrong)?;
                if taken.count() > MOST_SPLATS {
                    return Err(input::error(path, format!("more than {MOST_SPLATS} splats"), "give a smaller file"));
                }
            }
        }
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives().map(move |part| (mesh, part))) {
            let source = Source { node: node.index(), primitive: primitive.1.index() };
            let Some(mesh) =
                read_primitive(path, &file, (&nodes, placed), placement, &mut alphas, &mut left, primitive)?
            else {
                continue;
            };
            triangles = triangles.saturating_add(mesh.triangles.len());
            vertices = vertices.saturating_add(mesh.positions.len());
            for (count, what) in [(triangles, "triangles"), (vertices, "vertices")] {
                if count > MOST {
                    return Err(input::error(path, format!("more than {MOST} {what}"), "give a smaller file"));
                }
            }
            if !mesh.triangles.is_empty() {
                contents.meshes.push(mesh);
                sources.push(source);
            }
        }
    }
    of_splats.dedup();
    let mut splat_notes: Vec<_> = of_splats.iter().map(|note| format!("{}: {note}", input::file_name(path))).collect();
    match taken.finish(path, &mut splat_notes) {
        Ok(splats) => contents.splats = splats,
        // Its meshes are good.
        Err(Error::Input { cause, .. }) if !contents.meshes.is_empty() => {
            splat_notes.push(format!("{}: all splats are left out; {cause}", input::file_name(path)));
        }
        Err(error) => return Err(error),
    }
    gltf_stage::balance(&mut contents, placement.scale);
    contents.notes = notes(path, &left);
    contents.notes.extend(alphas.notes(path));
    contents.notes.extend(splat_notes);
    drop(alphas);
    drop(nodes);
    if let Some(animation) = animation {
        let motion = Motion::new(path, file, *placement, animation, sources)?;
        contents.notes.extend(motion.notes());
        contents.motions.extend(motion.moves().then_some(motion));
    }
    Ok(contents)
}

/// Returns what a file has that is left out, one line per kind.
fn notes(path: &Path, left: &Left) -> Vec<String> {
    let line = |count: usize, one: &str, many: &str| input::note(path, count, one, many);
    let all = [
        line(left.lines, "primitive of points or lines casts nothing", "primitives of points or lines cast nothing"),
        line(left.shapeless, "primitive without positions casts nothing", "primitives without positions cast nothing"),
        line(left.hidden, "hidden node casts nothing", "hidden nodes cast nothing"),
        line(
            left.bright,
            "mesh has a color beyond [0, 1], which is cut off",
            "meshes have a color beyond [0, 1], which is cut off",
        ),
        line(
            left.cones,
            "spot light fades from an inner cone, which is not read",
            "spot lights fade from an inner cone, which is not read",
        ),
    ];
    all.into_iter().flatten().collect()
}

/// Reads and places one primitive; `None` if it casts nothing.
fn read_primitive(
    path: &Path,
    file: &GltfDocument,
    (nodes, placed): (&Nodes, &PlacedNode),
    placement: &Placement,
    alphas: &mut AlphaReader,
    left: &mut Left,
    (mesh, primitive): (&gltf::Mesh, gltf::Primitive),
) -> Result<Option<Mesh>> {
    let unnamed = || format!("{}#{}", input::stem(path), mesh.index());
    let name = mesh.name().map_or_else(unnamed, input::one_line);
    let fail = |cause: String, way_out: &str| -> Error {
        input::error(path, format!("mesh {name} primitive {}: {cause}", primitive.index()), way_out)
    };
    let way_out = "export the mesh again as plain triangles";
    if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        left.lines += 1;
        return Ok(None);
    }
    let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
        left.shapeless += 1;
        return Ok(None);
    };
    let count = positions.count();
    if count > MOST {
        return Err(input::error(path, format!("more than {MOST} vertices"), "give a smaller file"));
    }
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => {
            let types = [DataType::U8, DataType::U16, DataType::U32];
            let elements = gltf_accessor::elements(file, &accessor, Dimensions::Scalar, &types)
                .map_err(|cause| fail(format!("its index accessor {cause}"), way_out))?;
            let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, &byte| index << 8 | u32::from(byte));
            elements.iter().map(number).collect()
        }
        None => (0..count as u32).collect(),
    };
    let triangles = triangles(primitive.mode(), &indices).map_err(|cause| fail(cause, way_out))?;
    let vertices =
        gltf_vertices::read(file, nodes, placed, &primitive, placement, MOST).map_err(|cause| fail(cause, way_out))?;
    let Vertices { positions, mirrored } = vertices;
    if triangles.len().saturating_mul(mirrored.len()) > MOST {
        return Err(input::error(path, format!("more than {MOST} triangles"), "give a smaller file"));
    }
    let albedo = match primitive.material() {
        material if material.index().is_none() => mesh_file::DEFAULT_ALBEDO,
        material => {
            let [red, green, blue, _] = material.pbr_metallic_roughness().base_color_factor();
            [red, green, blue]
        }
    };
    left.bright += usize::from(!albedo.iter().all(|value| (0.0..=1.0).contains(value)));
    let alpha = match alphas.read(&primitive, count).map_err(|wrong| fail(wrong.cause, wrong.way_out))? {
        Surface::Invisible => return Ok(None),
        Surface::Opaque => None,
        Surface::Alpha(alpha) => Some(Alpha {
            factors: alpha.factors.repeat(mirrored.len()),
            uvs: alpha.uvs.repeat(mirrored.len()),
            ..alpha
        }),
    };
    // A mirroring transform flips the winding of triangles (glTF 2.0, 3.5.3).
    let copy = |(number, mirrored): (usize, &bool)| {
        let (first, mirrored) = ((number * count) as u32, *mirrored);
        let placed = move |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        triangles.iter().map(move |triangle| placed(triangle.map(|index| index.saturating_add(first))))
    };
    // An index beyond a copy's vertices would be one of the next copy.
    if let Some(index) = triangles.as_flattened().iter().find(|index| **index as usize >= count) {
        return Err(fail(format!("vertex index {index} of {count} vertices"), way_out));
    }
    let triangles = mirrored.iter().enumerate().flat_map(copy).collect();
    let albedo = albedo.map(|value| value.clamp(0.0, 1.0));
    let mesh = Mesh { name: name.clone(), positions, triangles, albedo, solid: false, alpha };
    mesh_file::check(path, &mesh)?;
    Ok(Some(mesh))
}

/// Returns the triangles of a primitive's indices (glTF 2.0, 3.7.2.1). Strips are joined by triangles that use an index twice; these are
/// left out.
fn triangles(mode: Mode, indices: &[u32]) -> std::result::Result<Vec<[u32; 3]>, String> {
    let is_whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    Ok(match mode {
        Mode::TriangleStrip => {
            let turned = |(i, corners): (usize, &[u32])| match *corners {
                [a, b, c] if i % 2 == 0 => Some([a, b, c]),
                [a, b, c] => Some([b, a, c]),
                _ => None,
            };
            indices.windows(3).enumerate().filter_map(turned).filter(is_whole).collect()
        }
        Mode::TriangleFan => {
            let Some((first, rest)) = indices.split_first() else { return Ok(Vec::new()) };
            let spread = |corners: &[u32]| if let [a, b] = *corners { Some([*first, a, b]) } else { None };
            rest.windows(2).filter_map(spread).filter(is_whole).collect()
        }
        _ => match indices.as_chunks::<3>() {
            (triangles, []) => triangles.to_vec(),
            _ => return Err(format!("{} indices are not whole triangles", indices.len())),
        },
    })
}
