//! Alpha of glTF meshes: modes, factors, textures and places in them must be what the file says, and bad ones must be refused by name.

mod faults;

use crate::scene::*;
use base64::Engine;
use gobo::animate::AnimatedScene;
use gobo::scene::{Alpha, AlphaMode, AlphaTexture, Wrap};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
use serde_json::{Value, json};
use std::io::Cursor;
use std::sync::Arc;

const UVS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A glTF file of a square with one material; the square's vertices and the material may be extended.
#[derive(Clone)]
struct Square {
    root: Value,
    buffer: Vec<u8>,
}

impl Square {
    fn new(material: Value) -> Self {
        let root = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"name": "leaf", "primitives": [{"attributes": {}, "material": 0}]}],
            "materials": [material], "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        let mut square = Self { root, buffer: Vec::new() };
        square.put("indices", "SCALAR", 5121, false, &[0, 1, 2, 0, 2, 3]);
        let position = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut square = square.floats("POSITION", "VEC3", position.as_flattened());
        square.root["accessors"][1]["min"] = json!([0, 0, 0]);
        square.root["accessors"][1]["max"] = json!([1, 1, 0]);
        square
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let begin = self.buffer.len();
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let views = self.root["bufferViews"].as_array_mut().expect("views");
        views.push(json!({"buffer": 0, "byteOffset": begin, "byteLength": bytes.len()}));
        views.len() - 1
    }

    /// Adds an accessor, as the indices or an attribute of every primitive.
    fn put(&mut self, name: &str, kind: &str, component: u32, normalized: bool, bytes: &[u8]) {
        let size = if component == 5121 {
            1
        } else if component == 5123 {
            2
        } else {
            4
        };
        let width = kind.strip_prefix("VEC").map_or(1, |width| width.parse().expect("a width"));
        let view = self.view(bytes);
        let accessors = self.root["accessors"].as_array_mut().expect("accessors");
        let (index, count) = (accessors.len(), bytes.len() / (size * width));
        accessors.push(json!({
            "bufferView": view, "componentType": component, "normalized": normalized, "count": count, "type": kind,
        }));
        for part in self.root["meshes"][0]["primitives"].as_array_mut().expect("primitives") {
            let of = if name == "indices" { &mut *part } else { &mut part["attributes"] };
            of[name] = json!(index);
        }
    }

    fn floats(mut self, name: &str, kind: &str, numbers: &[f32]) -> Self {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.put(name, kind, 5126, false, &bytes);
        self
    }

    fn uvs(self) -> Self {
        self.floats("TEXCOORD_0", "VEC2", UVS.as_flattened())
    }

    /// Sets parts of the root.
    fn with(mut self, parts: Value) -> Self {
        let parts = parts.as_object().expect("an object").clone();
        self.root.as_object_mut().expect("an object").extend(parts);
        self
    }

    /// Adds texture 0, of image 0, embedded.
    fn image(self, bytes: &[u8]) -> Self {
        self.with(json!({"textures": [{"source": 0}], "images": [{"uri": uri(bytes)}]}))
    }

    fn text(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"][0] = json!({"byteLength": self.buffer.len(), "uri": uri(&self.buffer)});
        root.to_string().into_bytes()
    }

    fn load(&self) -> gobo::Result<Vec<Mesh>> {
        meshes("leaf.gltf", &self.text())
    }

    /// Returns the alpha of the only mesh.
    #[track_caller]
    fn alpha(&self) -> Option<Alpha> {
        let mut meshes = self.load().expect("a square");
        assert_eq!(meshes.len(), 1);
        meshes.remove(0).alpha
    }

    /// Returns the texture of the only mesh.
    #[track_caller]
    fn texture(&self) -> Arc<AlphaTexture> {
        self.alpha().expect("alpha").texture.expect("a texture")
    }
}

fn uri(bytes: &[u8]) -> String {
    format!("data:;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.into().write_to(&mut Cursor::new(&mut bytes), format).expect("encoded");
    bytes
}

/// Some number that differs from texel to texel.
fn noise(x: u32, y: u32) -> u16 {
    (((x * 7 + y * 131 + 1) * 40503) >> 3) as u16
}

fn noisy(width: u32, height: u32) -> (Vec<u8>, Vec<u8>) {
    let image = ImageBuffer::from_fn(width, height, |x, y| Rgba([1, 2, 3, noise(x, y) as u8]));
    (encoded(image.clone(), ImageFormat::Png), image.pixels().map(|pixel| pixel.0[3]).collect())
}

fn masked() -> Value {
    json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})
}

fn blended(factor: f64) -> Value {
    json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, factor]}})
}

/// A square whose texture has one row of two texels, of alpha 0 and 1.
fn cut_out() -> Square {
    let image = ImageBuffer::from_fn(2, 1, |x, _| LumaA([9_u8, x as u8 * 255]));
    Square::new(masked()).uvs().image(&encoded(image, ImageFormat::Png))
}

fn flat(mode: AlphaMode, factor: f32) -> Option<Alpha> {
    Some(Alpha::constant(mode, factor, 4))
}

#[test]
fn modes_are_those_of_materials() {
    for (mode, cutoff, expected) in [
        ("MASK", json!(null), flat(AlphaMode::Cut(0.5), 0.25)),
        ("MASK", json!(0.25), flat(AlphaMode::Cut(0.25), 0.25)),
        ("MASK", json!(1), flat(AlphaMode::Cut(1.0), 0.25)),
        ("MASK", json!(0), None),
        ("MASK", json!(1e-60), None),
        ("BLEND", json!(-9), flat(AlphaMode::SeeThrough, 0.25)),
        ("OPAQUE", json!("none"), None),
    ] {
        let mut material = blended(0.25);
        material["alphaMode"] = json!(mode);
        material["alphaCutoff"] = cutoff;
        assert_eq!(Square::new(material.clone()).alpha(), expected, "{material}");
    }
    assert_eq!(Square::new(json!({})).alpha(), None, "no mode");
    // Alpha that is 1 everywhere makes a mesh opaque. What an opaque mesh has is not checked.
    for mode in ["MASK", "BLEND"] {
        assert_eq!(Square::new(json!({"alphaMode": mode})).alpha(), None);
        let ones = Square::new(json!({"alphaMode": mode})).floats("COLOR_0", "VEC4", &[1.0; 16]);
        assert_eq!(ones.alpha(), None);
    }
    let colors = Square::new(json!({})).floats("COLOR_0", "VEC4", &[7.0; 16]);
    assert_eq!(colors.alpha(), None);
}

#[test]
fn vertex_colors_are_factors() {
    let alphas = [0.0_f32, 0.2, 0.6, 1.0];
    let square = || Square::new(blended(0.5));
    let factors = |square: Square| square.alpha().expect("alpha").factors;
    let halves = alphas.map(|alpha| (f64::from(alpha) * 0.5) as f32);
    let four = alphas.map(|alpha| [9.0, 9.0, 9.0, alpha]);
    assert_eq!(factors(square().floats("COLOR_0", "VEC4", four.as_flattened())), halves);
    let near = |found: Vec<f32>| found.iter().zip(halves).all(|(a, b)| (a - b).abs() < 1e-7);
    let mut bytes = square();
    bytes.put("COLOR_0", "VEC4", 5121, true, &[9, 9, 9, 0, 9, 9, 9, 51, 9, 9, 9, 153, 9, 9, 9, 255]);
    assert!(near(factors(bytes)));
    let mut words = square();
    let numbers = [9, 9, 9, 0, 9, 9, 9, 13107, 9, 9, 9, 39321, 9, 9, 9, 65535_u16];
    words.put("COLOR_0", "VEC4", 5123, true, &numbers.map(u16::to_le_bytes).concat());
    assert!(near(factors(words)));
    assert_eq!(factors(square().floats("COLOR_0", "VEC3", &[0.25; 12])), [0.5; 4], "three numbers have no alpha");
}

/// The alpha of every kind of image must come back, whatever its size.
#[test]
fn textures_come_back() {
    for (width, height) in [(1, 1), (2, 3), (17, 5), (64, 1)] {
        let bytes: Vec<u8> = (0..width * height).map(|at| noise(at % width, at / width) as u8).collect();
        let rounded = |at: (u32, u32)| (f64::from(noise(at.0, at.1)) / 257.0).round() as u8;
        let words: Vec<u8> = (0..width * height).map(|at| rounded((at % width, at / width))).collect();
        let rgba = ImageBuffer::from_fn(width, height, |x, y| Rgba([x as u8, 0, 9, noise(x, y) as u8]));
        let gray = ImageBuffer::from_fn(width, height, |x, y| LumaA([x as u8, noise(x, y) as u8]));
        let rgba16 = ImageBuffer::from_fn(width, height, |x, y| Rgba([x as u16, 0, 9, noise(x, y)]));
        let gray16 = ImageBuffer::from_fn(width, height, |x, y| LumaA([x as u16, noise(x, y)]));
        for (name, image, texels) in [
            ("RGBA", encoded(rgba.clone(), ImageFormat::Png), &bytes),
            ("gray", encoded(gray, ImageFormat::Png), &bytes),
            ("RGBA of 16 bits", encoded(rgba16, ImageFormat::Png), &words),
            ("gray of 16 bits", encoded(gray16, ImageFormat::Png), &words),
            ("WebP", encoded(rgba, ImageFormat::WebP), &bytes),
        ] {
            let alpha = Square::new(masked()).uvs().image(&image).alpha().expect("alpha");
            let texture = AlphaTexture { size: [width, height], wrap: [Wrap::Repeat; 2], texels: texels.clone() };
            assert_eq!(alpha.texture.as_deref(), Some(&texture), "{name} of {width} × {height}");
            assert_eq!((alpha.uvs.as_slice(), alpha.factors.as_slice()), (&UVS[..], &[1.0; 4][..]));
        }
    }
    // Two bits per texel: numbers of a palette, whose last colors are opaque by default.
    let palette = "iVBORw0KGgoAAAANSUhEUgAAAAQAAAABAgMAAACEUudeAAAADFBMVEX/AAAA/wAAAP/////7AGD2AAAAAnRSTlMAgJsrThgAAAAKSURBVHicY5AGAAAdAByO9PUhAAAAAElFTkSuQmCC";
    let palette = base64::engine::general_purpose::STANDARD.decode(palette).expect("base64");
    assert_eq!(Square::new(masked()).uvs().image(&palette).texture().texels, [0, 128, 255, 255]);
}

#[test]
fn images_without_alpha_are_not_kept() {
    let rgb = encoded(ImageBuffer::from_pixel(2, 2, Rgb([1_u8, 2, 3])), ImageFormat::Png);
    let gray = encoded(ImageBuffer::from_pixel(2, 2, Luma([1_u16])), ImageFormat::Png);
    let webp = encoded(ImageBuffer::from_pixel(2, 2, Rgb([1_u8, 2, 3])), ImageFormat::WebP);
    let ones = encoded(ImageBuffer::from_pixel(2, 2, Rgba([1_u8, 2, 3, 255])), ImageFormat::Png);
    // JPEG has no alpha, so that it is not even decoded.
    for image in [rgb, gray, webp, ones, b"\xFF\xD8\xFF\xE0 and no more".to_vec()] {
        let mut material = masked();
        assert_eq!(Square::new(material.clone()).image(&image).alpha(), None, "without places in the texture");
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.75]);
        assert_eq!(Square::new(material).uvs().image(&image).alpha(), flat(AlphaMode::Cut(0.5), 0.75));
    }
}

#[test]
fn images_are_embedded_or_beside() {
    let (png, texels) = noisy(3, 2);
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("a leaf.png"), &png).expect("write the image");
    let beside = Square::new(masked()).uvs();
    let beside = beside.with(json!({"textures": [{"source": 0}], "images": [{"uri": "a%20leaf.png"}]}));
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, beside.text()).expect("write the mesh");
    let loaded = load(&path).expect("an image beside").meshes.remove(0).alpha.expect("alpha");
    assert_eq!(loaded.texture.expect("a texture").texels, texels);

    let mut viewed = Square::new(masked()).uvs();
    let view = viewed.view(&png);
    let images = json!([{"bufferView": view, "mimeType": "image/png"}]);
    let viewed = viewed.with(json!({"textures": [{"source": 0}], "images": images}));
    assert_eq!(viewed.texture().texels, texels);

    // EXT_texture_webp replaces the plain image; KTX2 is used only without a plain one.
    let webp = encoded(ImageBuffer::from_pixel(1, 1, Rgba([0_u8, 0, 0, 77])), ImageFormat::WebP);
    let images = json!([{"uri": uri(&png)}, {"uri": uri(&webp), "mimeType": "image/webp"}, {"uri": "absent.ktx2"}]);
    let of = |texture: Value| Square::new(masked()).uvs().with(json!({"textures": [texture], "images": images}));
    let webp = json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}});
    assert_eq!(of(webp).texture().texels, [77]);
    assert_eq!(of(json!({"extensions": {"EXT_texture_webp": {"source": 1}}})).texture().texels, [77]);
    let basis = json!({"source": 0, "extensions": {"KHR_texture_basisu": {"source": 2}}});
    assert_eq!(of(basis).texture().texels, texels);
}

#[test]
fn samplers_say_how_textures_continue() {
    for (sampler, wrap) in [
        (json!({}), [Wrap::Repeat; 2]),
        (json!({"wrapS": 10497, "wrapT": 33071}), [Wrap::Repeat, Wrap::Clamp]),
        (json!({"wrapS": 33648, "magFilter": 9728}), [Wrap::Mirror, Wrap::Repeat]),
    ] {
        let square = cut_out().with(json!({"samplers": [sampler], "textures": [{"source": 0, "sampler": 0}]}));
        assert_eq!(square.texture().wrap, wrap, "{sampler}");
    }
}

/// An image is decoded once per way to continue, whatever textures and primitives name it.
#[test]
fn textures_are_shared() {
    let mut square = cut_out();
    let part = square.root["meshes"][0]["primitives"][0].clone();
    let of = |material: u32| {
        let mut part = part.clone();
        part["material"] = json!(material);
        part
    };
    square.root["meshes"][0]["primitives"] = (0..4).map(of).collect();
    let of = |texture: u32| {
        let mut material = masked();
        material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(texture);
        material
    };
    let square = square.with(json!({
        "materials": [of(0), of(0), of(1), of(2)],
        "textures": [{"source": 0}, {"source": 0, "sampler": 0}, {"source": 0, "sampler": 1}],
        "samplers": [{"wrapS": 10497}, {"wrapS": 33071}],
    }));
    let meshes = square.load().expect("four squares");
    let textures: Vec<_> = meshes.into_iter().map(|mesh| mesh.alpha.expect("alpha").texture.expect("one")).collect();
    assert!(Arc::ptr_eq(&textures[0], &textures[1]) && Arc::ptr_eq(&textures[0], &textures[2]));
    assert_eq!(textures[3].wrap, [Wrap::Clamp, Wrap::Repeat]);
    assert_eq!(textures[3].texels, textures[0].texels);
}

#[test]
fn places_in_textures_are_read() {
    let image = noisy(3, 2).0;
    let uvs = |square: Square| square.image(&image).alpha().expect("alpha").uvs;
    let with = |texture: Value| {
        let mut material = masked();
        material["pbrMetallicRoughness"]["baseColorTexture"] = texture;
        Square::new(material)
    };
    let second = [[0.5, -2.0], [3.0, 0.25], [0.125, 0.0], [7.0, 8.0]];
    let two = |texture: Value| with(texture).uvs().floats("TEXCOORD_1", "VEC2", second.as_flattened());
    assert_eq!(uvs(two(json!({"index": 0}))), UVS);
    assert_eq!(uvs(two(json!({"index": 0, "texCoord": 1}))), second);
    let mut bytes = with(json!({"index": 0, "texCoord": 7}));
    bytes.put("TEXCOORD_7", "VEC2", 5121, true, &[0, 51, 255, 102, 0, 0, 255, 255]);
    assert_eq!(uvs(bytes), [[0.0, 0.2], [1.0, 0.4], [0.0, 0.0], [1.0, 1.0]]);
    let mut words = with(json!({"index": 0}));
    words.put(
        "TEXCOORD_0",
        "VEC2",
        5123,
        true,
        &[0, 13107, 65535, 0, 0, 0, 65535, 65535_u16].map(u16::to_le_bytes).concat(),
    );
    assert_eq!(uvs(words), [[0.0, 0.2], [1.0, 0.0], [0.0, 0.0], [1.0, 1.0]]);

    let moved = |transform: Value| json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    assert_eq!(uvs(two(moved(json!({"texCoord": 1})))), second);
    assert_eq!(uvs(two(moved(json!({"offset": [0.5, 2]})))), UVS.map(|[u, v]| [u + 0.5, v + 2.0]));
    let flipped = json!({"offset": [0, 1], "scale": [1, -1]});
    assert_eq!(uvs(two(moved(flipped))), UVS.map(|[u, v]| [u, 1.0 - v]));
    // The specification's example: the lower left quarter of the image, turned clockwise.
    let quarter = json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]});
    for ([u, v], [across, down]) in uvs(two(moved(quarter))).into_iter().zip(UVS) {
        assert!((u - 0.5 * down).abs() < 1e-6 && (v - (1.0 - 0.5 * across)).abs() < 1e-6, "{u} {v}");
    }
    // Scale, rotation and translation, in this order.
    let all = json!({"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3]});
    let (sin, cos) = 0.3_f64.sin_cos();
    for ([u, v], [x, y]) in
        uvs(two(moved(all))).into_iter().zip(UVS.map(|uv| [uv[0] * 2.0, uv[1] * 3.0].map(f64::from)))
    {
        let expected = [cos * x + sin * y + 0.1, cos * y - sin * x + 0.2];
        assert!((f64::from(u) - expected[0]).abs() < 1e-6 && (f64::from(v) - expected[1]).abs() < 1e-6);
    }
}

#[test]
fn transmission_lets_light_through() {
    let through = |mut material: Value, factor: f64| {
        material["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": factor}});
        material
    };
    let alpha = |material: Value| Square::new(material).floats("COLOR_0", "VEC4", &[0.5; 16]).alpha();
    assert_eq!(alpha(through(json!({}), 0.75)), flat(AlphaMode::SeeThrough, 0.25), "alpha of an opaque material is 1");
    assert_eq!(alpha(through(json!({}), 0.0)), None);
    assert_eq!(alpha(through(json!({}), 1.0)), flat(AlphaMode::SeeThrough, 0.0));
    // What passes is t + (1 − t)(1 − a).
    assert_eq!(alpha(through(blended(0.5), 0.75)), flat(AlphaMode::SeeThrough, 0.0625));
    let cut = json!({"alphaMode": "MASK", "alphaCutoff": 0});
    assert_eq!(alpha(through(cut, 0.75)), flat(AlphaMode::SeeThrough, 0.25), "a cutoff of 0 hides nothing");
    let mut textured = cut_out();
    textured.root["materials"][0] = through(masked(), 0.5);
    let textured = textured.alpha().expect("alpha");
    assert_eq!((textured.mode, textured.factors.as_slice()), (AlphaMode::SeeThrough, &[0.5; 4][..]));
    assert_eq!(textured.texture.expect("a texture").texels, [0, 255]);
}

/// Transmitted light takes the base color's factor: per color, 1 − (1 − t color) alpha passes.
#[test]
fn transmission_is_tinted() {
    let tinted = |color: [f64; 4], passed: f64, mode: &str| {
        Square::new(json!({"alphaMode": mode, "pbrMetallicRoughness": {"baseColorFactor": color},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": passed}}}))
    };
    let alpha = |color: [f64; 4], passed: f64, mode: &str| tinted(color, passed, mode).alpha().expect("alpha");
    let passes = |alpha: &Alpha| {
        let optical_depth = -(1.0 - f64::from(alpha.factors[0])).ln().max(-80.0);
        alpha.extinction_ratio.map(|ratio| (-optical_depth * f64::from(ratio)).exp())
    };
    for (color, passed) in [([0.5, 0.25, 1.0, 1.0], 1.0), ([0.9, 0.6, 0.3, 1.0], 0.7), ([0.0, 1.0, 1.0, 1.0], 0.2)] {
        let glass = alpha(color, passed, "OPAQUE");
        for (channel, (found, color)) in passes(&glass).into_iter().zip(color).enumerate() {
            assert!((found - passed * color).abs() < 1e-6, "{channel}: {found}, {color} times {passed}");
        }
    }
    let red = alpha([1.0, 0.0, 0.0, 1.0], 1.0, "OPAQUE");
    assert_eq!((red.factors, red.extinction_ratio), (vec![1.0; 4], [0.0, 1.0, 1.0]));
    let blended = alpha([0.5, 0.25, 1.0, 0.5], 1.0, "BLEND");
    assert_eq!(blended.factors, [0.375; 4], "half of what meets the surface");
    // Less than a step of 8 bits is no color.
    assert_eq!(alpha([0.5, 0.503, 0.501, 1.0], 1.0, "OPAQUE"), flat(AlphaMode::SeeThrough, 0.5).expect("alpha"));
    // The lights of such a file stand once per color, and so they do if a scene file names it.
    let square = tinted([0.5, 0.25, 1.0, 1.0], 1.0, "OPAQUE");
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("pane.gltf"), square.text()).expect("written");
    let alone = load(&folder.path().join("pane.gltf")).expect("a scene");
    let named = load_caster("meshes", "pane.gltf", &square.text(), "").expect("a scene");
    for scene in [alone, named] {
        assert_eq!((scene.colors(), scene.inks.len(), scene.inks[0].casters), (3, 1, 2));
    }
}

#[test]
fn specular_glossiness_has_its_own_color() {
    let mut square = cut_out();
    square.root["materials"][0] = json!({"alphaMode": "MASK", "extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [1, 1, 1, 0.75], "diffuseTexture": {"index": 0}}}});
    let alpha = square.alpha().expect("alpha");
    assert_eq!((alpha.factors, alpha.texture.expect("a texture").texels.clone()), (vec![0.75; 4], vec![0, 255]));
}

/// The data project's cases: a disc cut out of a card, and glass of alpha 0.1.
#[test]
fn leaf_cards_and_glass_are_not_walls() {
    let disc = "iVBORw0KGgoAAAANSUhEUgAAABAAAAAQCAYAAAAf8/9hAAAAMklEQVR4nGPQqNBgoARTpJmmBvzHgYkyAJdmrIaQqhnDkFEDaGAAxdFIlYQ0OPIC0RgAVAwfuOoNNBgAAAAASUVORK5CYII=";
    let file = |material: Value| {
        Square::new(material).uvs().with(json!({
            "images": [{"uri": format!("data:image/png;base64,{disc}")}],
            "samplers": [{"magFilter": 9728, "minFilter": 9728}], "textures": [{"source": 0, "sampler": 0}],
        }))
    };
    let leaf = file(json!({"alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let alpha = leaf.alpha().expect("alpha");
    assert_eq!((alpha.mode, alpha.uvs.as_slice()), (AlphaMode::Cut(0.5), &UVS[..]));
    let texture = alpha.texture.expect("a texture");
    assert_eq!((texture.size, texture.wrap), ([16, 16], [Wrap::Repeat; 2]));
    for (at, texel) in texture.texels.iter().enumerate() {
        let [x, y] = [at % 16, at / 16].map(|place| place as f64 - 7.5);
        let is_in = x * x + y * y < 28.0;
        assert_eq!(*texel, if is_in { 255 } else { 0 }, "{x} {y}");
    }
    let glass = file(json!({"alphaMode": "BLEND", "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.1]}}));
    assert_eq!(glass.alpha(), flat(AlphaMode::SeeThrough, 0.1));
}
