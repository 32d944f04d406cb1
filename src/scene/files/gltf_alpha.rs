//! Alpha of glTF meshes: holes, glass and transmission.
//!
//! Alpha is the product of the base color's texture, its factor and the vertex color. Materials and textures are read
//! from the file's JSON, each only if a mesh needs it: a texture without effect on shadows never costs the file.

use crate::scene::files::gltf_accessor::{self, NUMBERS};
use crate::scene::files::gltf_document::GltfDocument;
use crate::scene::files::gltf_texture::{Checked, Fault, Textures, index, label};
use crate::scene::files::input;
use crate::scene::{Alpha, AlphaMode, MAX_OPTICAL_DEPTH, Scene};
use glam::{DAffine2, DVec2};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Primitive, Semantic};
use serde_json::Value;
use std::path::Path;

/// The cutoff of a material without its own.
const CUTOFF: f64 = 0.5;

const CORRECT: &str = "correct the material";
const EXPORT_AGAIN: &str = "export the mesh again with its texture coordinates";

/// What alpha makes of a mesh.
pub(in crate::scene) enum Surface {
    Opaque,
    Alpha(Alpha),
    /// The whole mesh is a hole.
    Invisible,
}

/// A material's alpha mode.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Opaque,
    /// `MASK`, with a cutoff in (0, 1].
    Cut(f32),
    Blend,
    /// `MASK` with a cutoff above 1.
    Invisible,
}

/// Reads the alpha of the meshes of one file.
pub(in crate::scene) struct AlphaReader<'a> {
    file: &'a GltfDocument,
    textures: Textures<'a>,
    /// The number of meshes that are invisible.
    invisible: usize,
    /// The number of meshes whose transmission has a texture.
    textured_transmissions: usize,
    /// The number of meshes whose transmission is colored by a texture or by vertices.
    textured_tints: usize,
    /// The number of meshes that have a cutoff and let light through.
    cut_transmissions: usize,
}

impl<'a> AlphaReader<'a> {
    pub(in crate::scene) fn new(path: &'a Path, file: &'a GltfDocument) -> Self {
        Self {
            file,
            textures: Textures::new(path, file),
            invisible: 0,
            textured_transmissions: 0,
            textured_tints: 0,
            cut_transmissions: 0,
        }
    }

    /// Reads the alpha of a primitive of `vertices` vertices.
    pub(in crate::scene) fn read(&mut self, primitive: &Primitive, vertices: usize) -> Checked<Surface> {
        let Some(index) = primitive.material().index() else { return Ok(Surface::Opaque) };
        let material = &self.file.appearance["materials"][index];
        self.of_material(material, primitive, vertices)
            .map_err(|fault| fault.within(&label("material", index, material)))
    }

    fn of_material(&mut self, material: &Value, primitive: &Primitive, vertices: usize) -> Checked<Surface> {
        let (mode, passed) = (mode(material)?, self.transmission(material)?);
        let alpha_mode = match mode {
            Mode::Invisible => {
                self.invisible += 1;
                return Ok(Surface::Invisible);
            }
            Mode::Opaque if passed == 0.0 => return Ok(Surface::Opaque),
            Mode::Cut(cutoff) if passed == 0.0 => AlphaMode::Cut(cutoff),
            _ => AlphaMode::SeeThrough,
        };
        self.cut_transmissions += usize::from(matches!(mode, Mode::Cut(_)) && passed > 0.0);
        // A share 1 − alpha passes beside the surface. Transmission passes t times its color of the rest: 1 − (1 − t color) alpha in all.
        let absorbed = self.tint(material, primitive, passed)?.map(|color| 1.0 - passed * color);
        let factor = absorbed.into_iter().fold(0.0, f64::max);
        let extinction_ratio = extinction_ratio(absorbed);
        let mut alpha = Alpha { extinction_ratio, ..Alpha::constant(alpha_mode, factor as f32, vertices) };
        if mode != Mode::Opaque {
            self.read_color(&mut alpha, material, primitive, factor, vertices)?;
        }
        let is_opaque = alpha.texture.is_none()
            && extinction_ratio == Scene::GREY
            && alpha.factors.iter().all(|factor| *factor == 1.0);
        Ok(if is_opaque { Surface::Opaque } else { Surface::Alpha(alpha) })
    }

    /// Reads the alpha of the color of a material and a primitive, times a factor.
    fn read_color(
        &mut self,
        alpha: &mut Alpha,
        material: &Value,
        primitive: &Primitive,
        factor: f64,
        vertices: usize,
    ) -> Checked<()> {
        let (color, texture) = color(material);
        let factor = factor * fraction(&color[3], "the alpha of its color", 1.0)?;
        alpha.factors = match self.vertex_alphas(primitive, vertices)? {
            Some(alphas) => alphas.iter().map(|alpha| (alpha * factor) as f32).collect(),
            None => vec![factor as f32; vertices],
        };
        if texture.is_null() {
            return Ok(());
        }
        let number = index(&texture["index"]).ok_or_else(|| Fault::new("its texture has no index", CORRECT))?;
        alpha.texture = self.textures.read(number)?;
        if alpha.texture.is_some() {
            alpha.uvs = self.uvs(texture, primitive, vertices)?;
        }
        Ok(())
    }

    /// Returns the share of the light that a material transmits. The texture of the transmission is not read.
    fn transmission(&mut self, material: &Value) -> Checked<f64> {
        let extension = &material["extensions"]["KHR_materials_transmission"];
        let passed = fraction(&extension["transmissionFactor"], "transmissionFactor", 0.0)?;
        self.textured_transmissions += usize::from(passed > 0.0 && !extension["transmissionTexture"].is_null());
        Ok(passed)
    }

    /// Returns the color of the light that a material transmits; white if it transmits none. Colors of textures and vertices are not read.
    fn tint(&mut self, material: &Value, primitive: &Primitive, passed: f64) -> Checked<[f64; 3]> {
        if passed == 0.0 {
            return Ok([1.0; 3]);
        }
        let (color, texture) = color(material);
        self.textured_tints += usize::from(!texture.is_null() || primitive.get(&Semantic::Colors(0)).is_some());
        // A color beyond [0, 1] is noted where the mesh's albedo is read.
        let of = |channel: usize| number(&color[channel], "its color", 1.0).map(|color| color.clamp(0.0, 1.0));
        Ok([of(0)?, of(1)?, of(2)?])
    }

    /// Returns the alphas of a primitive's vertex colors, if it has them.
    fn vertex_alphas(&self, primitive: &Primitive, vertices: usize) -> Checked<Option<Vec<f64>>> {
        const TYPES: [DataType; 3] = [DataType::F32, DataType::U8, DataType::U16];
        let Some(accessor) = primitive.get(&Semantic::Colors(0)) else { return Ok(None) };
        if accessor.dimensions() == Dimensions::Vec3 {
            return Ok(None);
        }
        let colors = self.attribute("COLOR_0", &accessor, Dimensions::Vec4, &TYPES, vertices)?;
        let alphas: Vec<f64> = colors.into_iter().map(|[_, _, _, alpha]: [f64; 4]| alpha).collect();
        match alphas.iter().zip(0..).find(|(alpha, _)| !(0.0..=1.0).contains(*alpha)) {
            None => Ok(Some(alphas)),
            Some((alpha, vertex)) => Err(Fault::new(
                format!("COLOR_0 of vertex {vertex} (the first is 0) has an alpha of {alpha}, not in [0, 1]"),
                "correct the vertex colors",
            )),
        }
    }

    /// Returns the places of a primitive's vertices in its texture.
    fn uvs(&self, texture: &Value, primitive: &Primitive, vertices: usize) -> Checked<Vec<[f32; 2]>> {
        let transform = &texture["extensions"]["KHR_texture_transform"];
        let set = [&transform["texCoord"], &texture["texCoord"]].into_iter().find_map(Value::as_u64).unwrap_or(0);
        let name = format!("TEXCOORD_{set}");
        let accessor = u32::try_from(set).ok().and_then(|set| primitive.get(&Semantic::TexCoords(set)));
        let accessor = accessor.ok_or_else(|| Fault::new(format!("its mesh has no {name}"), EXPORT_AGAIN))?;
        let to_texture = to_texture(transform)?;
        let uvs = self.attribute(&name, &accessor, Dimensions::Vec2, &NUMBERS, vertices)?;
        let place = |uv| to_texture.transform_point2(DVec2::from_array(uv)).as_vec2().to_array();
        let uvs: Vec<[f32; 2]> = uvs.into_iter().map(place).collect();
        match uvs.iter().position(|uv| !uv.iter().all(|coordinate| coordinate.is_finite())) {
            None => Ok(uvs),
            Some(vertex) => {
                Err(Fault::new(format!("{name} of vertex {vertex} (the first is 0) is not finite"), EXPORT_AGAIN))
            }
        }
    }

    /// Returns the numbers of an attribute, per vertex.
    fn attribute<const N: usize>(
        &self,
        name: &str,
        accessor: &gltf::Accessor,
        dimensions: Dimensions,
        types: &[DataType],
        vertices: usize,
    ) -> Checked<Vec<[f64; N]>> {
        let wrong = |cause| Fault::new(format!("{name} {cause}"), EXPORT_AGAIN);
        if accessor.count() != vertices {
            return Err(wrong(format!("has {} elements for {vertices} vertices", accessor.count())));
        }
        let elements = gltf_accessor::elements(self.file, accessor, dimensions, types).map_err(wrong)?;
        Ok(elements.iter().map(|element| gltf_accessor::numbers(accessor, element)).collect())
    }

    /// Returns what the file has that is not seen in its meshes, one line per kind.
    pub(in crate::scene) fn notes(&self, path: &Path) -> Vec<String> {
        let line = |count: usize, one: &str, many: &str| {
            let meshes = if count == 1 { format!("1 mesh has {one}") } else { format!("{count} meshes have {many}") };
            (count > 0).then(|| format!("{}: {meshes}", input::file_name(path)))
        };
        let invisible = line(self.invisible, "a cutoff above 1 and is left out", "a cutoff above 1 and are left out");
        let transmission = "a transmission texture, which is not read";
        let cutoff = "a cutoff beside its transmission, which is not read";
        let cutoffs = "a cutoff beside their transmission, which is not read";
        let textured = line(self.textured_transmissions, transmission, transmission);
        let tint = "a color by texture or by vertex on its transmission, which is not read";
        let tints = "a color by texture or by vertex on their transmission, which is not read";
        let tinted = line(self.textured_tints, tint, tints);
        invisible
            .into_iter()
            .chain(textured)
            .chain(tinted)
            .chain(line(self.cut_transmissions, cutoff, cutoffs))
            .collect()
    }
}

/// Returns a material's alpha mode. A cutoff of 0 hides nothing.
fn mode(material: &Value) -> Checked<Mode> {
    match (&material["alphaMode"], material["alphaMode"].as_str()) {
        (Value::Null, _) | (_, Some("OPAQUE")) => return Ok(Mode::Opaque),
        (_, Some("BLEND")) => return Ok(Mode::Blend),
        (_, Some("MASK")) => {}
        (other, _) => {
            return Err(Fault::new(format!("alphaMode is {other}, not \"OPAQUE\", \"MASK\" or \"BLEND\""), CORRECT));
        }
    }
    let cutoff = number(&material["alphaCutoff"], "alphaCutoff", CUTOFF)?;
    match cutoff as f32 {
        _ if cutoff < 0.0 => Err(Fault::new(format!("alphaCutoff {cutoff} is negative"), CORRECT)),
        0.0 => Ok(Mode::Opaque),
        cutoff if cutoff > 1.0 => Ok(Mode::Invisible),
        cutoff => Ok(Mode::Cut(cutoff)),
    }
}

/// Returns the factors of the optical depth for red, green and blue light, of a surface that absorbs these shares of them. A tint of less than
/// a step of 8 bits is no color.
fn extinction_ratio(absorbed: [f64; 3]) -> [f32; 3] {
    let [least, most] = [absorbed.into_iter().fold(1.0, f64::min), absorbed.into_iter().fold(0.0, f64::max)];
    if most - least < 1.0 / 255.0 {
        return Scene::GREY;
    }
    let optical_depth = |absorbed: f64| (-(-absorbed).ln_1p()).min(MAX_OPTICAL_DEPTH.into());
    absorbed.map(|absorbed| (optical_depth(absorbed) / optical_depth(most)) as f32)
}

/// Returns the factor and the texture of a material's color. KHR_materials_pbrSpecularGlossiness replaces the plain ones.
fn color(material: &Value) -> (&Value, &Value) {
    let (plain, replaced) =
        (&material["pbrMetallicRoughness"], &material["extensions"]["KHR_materials_pbrSpecularGlossiness"]);
    match replaced.is_object() {
        true => (&replaced["diffuseFactor"], &replaced["diffuseTexture"]),
        false => (&plain["baseColorFactor"], &plain["baseColorTexture"]),
    }
}

/// Returns the transform from texture coordinates to the texture (KHR_texture_transform). It turns them counter-clockwise as the
/// texture is seen, whose second coordinate points down.
fn to_texture(transform: &Value) -> Checked<DAffine2> {
    let pair = |key: &str, default: f64| -> Checked<DVec2> {
        let one = |axis: usize| number(&transform[key][axis], &format!("KHR_texture_transform {key}"), default);
        Ok(DVec2::new(one(0)?, one(1)?))
    };
    let rotation = number(&transform["rotation"], "KHR_texture_transform rotation", 0.0)?;
    Ok(DAffine2::from_scale_angle_translation(pair("scale", 1.0)?, -rotation, pair("offset", 0.0)?))
}

/// Returns a number of the JSON; `default` if there is none.
fn number(value: &Value, name: &str, default: f64) -> Checked<f64> {
    let wrong = || Fault::new(format!("{name} {value} is not a number"), CORRECT);
    if value.is_null() { Ok(default) } else { value.as_f64().ok_or_else(wrong) }
}

/// Returns a number in [0, 1] of the JSON; `default` if there is none.
fn fraction(value: &Value, name: &str, default: f64) -> Checked<f64> {
    let number = number(value, name, default)?;
    let wrong = || Fault::new(format!("{name}, {number}, is not in [0, 1]"), CORRECT);
    (0.0..=1.0).contains(&number).then_some(number).ok_or_else(wrong)
}
