//! Splats of a glTF file (KHR_gaussian_splatting), as accessors or as an SPZ file in a buffer view
//! (KHR_gaussian_splatting_compression_spz_2).

use serde_json::{Map, Value};

type Checked<T> = std::result::Result<T, String>;

const NAME: &str = "KHR_gaussian_splatting";

/// The names that SPZ in splats has had: that of the draft, and the one before it.
const SPZ: [&str; 2] = ["KHR_gaussian_splatting_compression_spz_2", "KHR_gaussian_splatting_compression_spz"];

/// What had both in one, in files of 2025.
const FIRST: &str = "KHR_spz_gaussian_splats_compression";

/// The splats of a primitive.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Splats {
    /// The index of the mesh that has them; its nodes place them.
    pub mesh: usize,
    /// Whether colors are linear, not as a display takes them (sRGB).
    pub is_linear: bool,
    pub source: Source,
}

/// Where the splats' properties are.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) enum Source {
    /// Indices of accessors, with an element for each splat.
    Accessors {
        /// 3 numbers.
        position: usize,
        /// Quaternion x, y, z, w; floats or normalized signed integers.
        rotation: usize,
        /// Standard deviations, not their logarithms; floats or unsigned integers, normalized or not.
        scale: usize,
        opacity: Opacity,
        color: Color,
    },
    /// The index of a view with an SPZ file. Its axes are the node's: writers turn the node if SPZ's are others.
    Spz { view: usize },
}

/// The accessor of opacities from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) enum Opacity {
    /// One number: a float or a normalized unsigned integer.
    Alone(usize),
    /// The fourth of `COLOR_0`.
    OfColor(usize),
}

/// The accessor of colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) enum Color {
    /// Three coefficients of the zeroth spherical harmonic.
    Harmonic(usize),
    /// Red, green and blue of `COLOR_0`, from 0 to 1.
    Plain(usize),
}

/// Takes primitives with splats out of a document, so that those left are triangles, lines and points, and the names of
/// splats' attributes are gone. Removes the extensions from the lists of those used and required.
///
/// # Errors
/// If a property of the splats is missing, or they are of an unknown kind; the message gives the primitive.
pub(super) fn take(root: &mut Value) -> Checked<Vec<Splats>> {
    let mut taken = Vec::new();
    for (mesh, of_mesh) in root.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
        let Some(parts) = of_mesh.get_mut("primitives").and_then(Value::as_array_mut) else { continue };
        for (number, part) in parts.iter().enumerate().filter(|(_, part)| has_splats(part)) {
            let splats = of_part(mesh, part).map_err(|cause| format!("mesh {mesh}: primitive {number} {cause}"))?;
            taken.push(splats);
        }
        parts.retain(|part| !has_splats(part));
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(list) = root.get_mut(list).and_then(Value::as_array_mut) {
            list.retain(|name| name != NAME && name != FIRST && !SPZ.iter().any(|spz| name == spz));
        }
    }
    Ok(taken)
}

fn has_splats(part: &Value) -> bool {
    [NAME, FIRST].iter().any(|name| part["extensions"].get(name).is_some())
}

fn index(of: &Value) -> Option<usize> {
    usize::try_from(of.as_u64()?).ok()
}

fn of_part(mesh: usize, part: &Value) -> Checked<Splats> {
    let extension = &part["extensions"][NAME];
    let none = Map::new();
    let inner = extension["extensions"].as_object().unwrap_or(&none);
    let spz = SPZ.iter().find_map(|name| inner.get(*name)).or_else(|| part["extensions"].get(FIRST));
    // Files from before there was a choice have none.
    let kernel = extension.get("kernel").map_or(Some("ellipse"), Value::as_str);
    if kernel != Some("ellipse") {
        return Err(format!("has splats with the unknown kernel {}", extension["kernel"]));
    }
    let is_linear = match extension.get("colorSpace").map_or(Some("srgb_rec709_display"), Value::as_str) {
        Some("srgb_rec709_display") => false,
        Some("lin_rec709_display") => true,
        _ => return Err(format!("has splats with the unknown color space {}", extension["colorSpace"])),
    };
    if let Some(spz) = spz {
        let view = index(&spz["bufferView"]).ok_or("has no buffer view with its splats")?;
        return Ok(Splats { mesh, is_linear, source: Source::Spz { view } });
    }
    if let Some((name, _)) = inner.iter().next() {
        return Err(format!("has splats that {name} changes or compresses, which is not known here"));
    }
    let attributes = &part["attributes"];
    let own = |name: &str| index(&attributes[format!("{NAME}:{name}")]);
    let missing = |name: &str| format!("has splats without {name}");
    let plain = index(&attributes["COLOR_0"]);
    let color = own("SH_DEGREE_0_COEF_0").map(Color::Harmonic).or(plain.map(Color::Plain));
    let opacity = own("OPACITY").map(Opacity::Alone).or(plain.map(Opacity::OfColor));
    let source = Source::Accessors {
        position: index(&attributes["POSITION"]).ok_or_else(|| missing("POSITION"))?,
        rotation: own("ROTATION").ok_or_else(|| missing("ROTATION"))?,
        scale: own("SCALE").ok_or_else(|| missing("SCALE"))?,
        opacity: opacity.ok_or_else(|| missing("OPACITY"))?,
        color: color.ok_or_else(|| missing("a color"))?,
    };
    Ok(Splats { mesh, is_linear, source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn splats_without_an_own_color_have_that_of_points() {
        let document = |extension: Value, attributes: Value| {
            json!({"extensionsUsed": ["KHR_gaussian_splatting", "EXT_other"], "meshes": [{"primitives": [
            {"mode": 0, "attributes": attributes, "extensions": {"KHR_gaussian_splatting": extension}}]}]})
        };
        let mut attributes = json!({"POSITION": 4, "COLOR_0": 1, "KHR_gaussian_splatting:ROTATION": 2,
        "KHR_gaussian_splatting:SCALE": 3});
        let linear = json!({"kernel": "ellipse", "colorSpace": "lin_rec709_display"});
        let mut root = document(linear.clone(), attributes.clone());
        let taken = take(&mut root).unwrap();
        let (opacity, color) = (Opacity::OfColor(1), Color::Plain(1));
        let source = Source::Accessors { position: 4, rotation: 2, scale: 3, opacity, color };
        assert_eq!(taken, [Splats { mesh: 0, is_linear: true, source }]);
        assert_eq!(root, json!({"extensionsUsed": ["EXT_other"], "meshes": [{"primitives": []}]}));
        let refused =
            |extension: Value, attributes: &Value| take(&mut document(extension, attributes.clone())).unwrap_err();
        let cause = refused(json!({"kernel": "box"}), &attributes);
        assert_eq!(cause, "mesh 0: primitive 0 has splats with the unknown kernel \"box\"");
        let cause = refused(json!({"kernel": "ellipse", "extensions": {"EXT_new": {}}}), &attributes);
        assert_eq!(cause, "mesh 0: primitive 0 has splats that EXT_new changes or compresses, which is not known here");
        attributes.as_object_mut().unwrap().remove("COLOR_0");
        assert_eq!(refused(linear, &attributes), "mesh 0: primitive 0 has splats without OPACITY");
    }

    #[test]
    fn spz_is_found_under_each_of_its_names() {
        let spz = |name: &str| json!({"extensions": {name: {"bufferView": 7}}});
        let newest = json!({"KHR_gaussian_splatting": spz("KHR_gaussian_splatting_compression_spz_2")});
        let before = json!({"KHR_gaussian_splatting": spz("KHR_gaussian_splatting_compression_spz")});
        let first = json!({"KHR_spz_gaussian_splats_compression": {"bufferView": 7}});
        for extensions in [newest, before, first] {
            let mut root = json!({"meshes": [{"primitives": [{"mode": 4, "attributes": {"POSITION": 3}}]},
            {"primitives": [{"attributes": {}, "mode": 0, "extensions": extensions}]}]});
            let taken = take(&mut root).unwrap();
            assert_eq!(taken, [Splats { mesh: 1, is_linear: false, source: Source::Spz { view: 7 } }]);
            assert_eq!(root["meshes"][0]["primitives"].as_array().unwrap().len(), 1);
        }
    }
}
