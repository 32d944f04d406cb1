//! Bad materials and textures are refused by name, and what is left out is told.

use super::*;

/// What no mesh needs for its alpha may be missing, broken or of any form.
#[test]
fn appearance_that_is_not_needed_may_have_any_form() {
    let exotic = json!({
        "textures": [{"source": 9}, {"extensions": {"KHR_texture_basisu": {"source": 0}}}, 7],
        "images": [{"uri": "absent.ktx2", "mimeType": "image/ktx2"}, {"bufferView": 99, "mimeType": "image/avif"}, null],
        "samplers": [{"wrapS": "loose", "magFilter": 1}],
    });
    let mut square = Square::new(json!({"alphaMode": "OPAQUE", "alphaCutoff": "high", "normalTexture": {"index": 77},
        "emissiveTexture": 5, "pbrMetallicRoughness": {"baseColorTexture": {"index": 1, "texCoord": -1}}}));
    for name in ["TEXCOORD_0", "TEXCOORD_x", "COLOR_0", "COLOR_1", "NORMAL"] {
        square.root["meshes"][0]["primitives"][0]["attributes"][name] = json!(99);
    }
    let square = square.with(exotic);
    assert_eq!(square.alpha(), None);
    let mut blend = square.clone();
    blend.root["materials"][0] = blended(0.5);
    blend.root["materials"][0]["normalTexture"] = json!({"index": 0});
    assert_eq!(blend.alpha(), flat(AlphaMode::SeeThrough, 0.5));
}

#[test]
fn bad_textures_are_refused_by_name() {
    let textured = |texture: Value, image: Value| {
        let mut square = Square::new(masked()).uvs();
        square.root["materials"][0]["name"] = json!("bark");
        square.with(json!({"textures": [texture], "images": [image], "samplers": [{"wrapT": 1}]}))
    };
    let plain = json!({"source": 0});
    let (png, _) = noisy(9, 9);
    let webp = encoded(ImageBuffer::from_fn(9, 9, |x, y| Rgba([1, 2, 3, noise(x, y) as u8])), ImageFormat::WebP);
    let of = |bytes: &[u8]| textured(plain.clone(), json!({"uri": uri(bytes)}));
    let mut empty = png.clone();
    empty[16..20].fill(0);
    let mut wide =
        encoded(ImageBuffer::from_fn(AlphaTexture::MOST_SIDE + 1, 1, |_, _| LumaA([0_u8, 1])), ImageFormat::Png);
    for (words, square) in [
        ("texture 0: image 0 (absent.png): ", textured(plain.clone(), json!({"uri": "absent.png"}))),
        ("embed the image or put its file beside", textured(plain.clone(), json!({"uri": "absent.png"}))),
        ("unsupported URI", textured(plain.clone(), json!({"uri": "https://example.com/a.png"}))),
        ("image 0 (disc): data URI without base64", textured(plain.clone(), json!({"name": "disc", "uri": "data:,a"}))),
        ("has neither a file nor a buffer view", textured(plain.clone(), json!({"bufferView": 99}))),
        ("there is no image 5", textured(json!({"source": 5}), json!({}))),
        ("texture 0 (skin): has no image", textured(json!({"name": "skin"}), json!({}))),
        ("there is no sampler 3", textured(json!({"source": 0, "sampler": 3}), json!({}))),
        ("wrapT is 1, not 10497", textured(json!({"source": 0, "sampler": 0}), json!({}))),
        ("image 0: ", of(&png[..png.len() / 2])),
        ("image 0: ", of(&png[..20])),
        ("image 0: ", of(&webp[..webp.len() / 2])),
        ("image 0: ", of(&empty)),
        ("image 0: is not PNG, JPEG or WebP", of(b"")),
        ("image 0: is not PNG, JPEG or WebP", of(b"GIF89a and more")),
        ("KTX2, which is not decoded; run gltf-transform ktxdecompress", of(b"\xABKTX 20\xBB\r\n\x1A\n and more")),
        ("is 16385 × 1 texels, not 1 to 16384 per side", of(&wide)),
    ] {
        let told = message(square.load(), "leaf.gltf", words);
        assert!(told.contains("mesh leaf primitive 0: material 0 (bark): texture 0"), "{told}");
    }
    wide.truncate(200);
    message(of(&wide).load(), "leaf.gltf", "is 16385 × 1 texels");
    message(Square::new(masked()).load(), "leaf.gltf", "there is no texture 0");
}

#[test]
fn bad_alpha_is_refused_by_name() {
    let uvs = |numbers: &[f32]| {
        let mut square = cut_out();
        square.put(
            "TEXCOORD_0",
            "VEC2",
            5126,
            false,
            &numbers.iter().flat_map(|uv| uv.to_le_bytes()).collect::<Vec<_>>(),
        );
        square
    };
    let material = |material: Value| {
        let mut square = cut_out();
        square.root["materials"][0] = material;
        square
    };
    let texture = |texture: Value| {
        let mut of = masked();
        of["pbrMetallicRoughness"]["baseColorTexture"] = texture;
        material(of)
    };
    let moved = |transform: Value| texture(json!({"index": 0, "extensions": {"KHR_texture_transform": transform}}));
    let cutoff = |cutoff: Value| material(json!({"alphaMode": "MASK", "alphaCutoff": cutoff}));
    let transmission = json!({"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.5}}});
    let colors = |numbers: [f32; 16]| cut_out().floats("COLOR_0", "VEC4", &numbers);
    let mut odd = [0.5; 16];
    (odd[3], odd[7]) = (0.0, -0.5);
    let mut none = [0.5; 16];
    none[11] = f32::NAN;
    let mut far = cut_out();
    far.root["bufferViews"][2]["byteLength"] = json!(31);
    let mut pale = cut_out();
    pale.put("TEXCOORD_0", "VEC3", 5126, false, &[0; 48]);
    for (words, square) in [
        ("TEXCOORD_0 of vertex 2 (the first is 0) is not finite", uvs(&[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0])),
        ("TEXCOORD_0 of vertex 3", uvs(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::INFINITY])),
        ("TEXCOORD_0 of vertex 1 (the first is 0) is not finite", moved(json!({"scale": [1e300, 1]}))),
        ("TEXCOORD_0 has 3 elements for 4 vertices", uvs(&[0.0; 6])),
        ("TEXCOORD_0 is Vec3 of F32", pale),
        ("TEXCOORD_0 reaches beyond its buffer", far),
        ("its mesh has no TEXCOORD_2", texture(json!({"index": 0, "texCoord": 2}))),
        ("its mesh has no TEXCOORD_5000000000", texture(json!({"index": 0, "texCoord": 5_000_000_000_u64}))),
        ("there is no texture 8", texture(json!({"index": 8}))),
        ("its texture has no index", texture(json!({"texCoord": 0}))),
        ("KHR_texture_transform rotation \"left\" is not a number", moved(json!({"rotation": "left"}))),
        ("KHR_texture_transform scale", moved(json!({"scale": [1, []]}))),
        ("alphaCutoff -0.5 is negative; correct the material", cutoff(json!(-0.5))),
        ("alphaCutoff \"NaN\" is not a number", cutoff(json!("NaN"))),
        ("alphaMode is \"HASHED\", not", material(json!({"alphaMode": "HASHED"}))),
        ("the alpha of its color, 1.5, is not in [0, 1]", material(blended(1.5))),
        ("the alpha of its color, -0.1, is not in [0, 1]", material(blended(-0.1))),
        ("transmissionFactor, 1.5, is not in [0, 1]", material(transmission)),
        ("COLOR_0 of vertex 1 (the first is 0) has an alpha of -0.5, not in [0, 1]", colors(odd)),
        ("COLOR_0 of vertex 2 (the first is 0) has an alpha of NaN, not in [0, 1]", colors(none)),
        ("COLOR_0 has 3 elements for 4 vertices", cut_out().floats("COLOR_0", "VEC4", &[0.5; 12])),
    ] {
        let told = message(square.load(), "leaf.gltf", words);
        assert!(told.contains("mesh leaf primitive 0: material 0: "), "{told}");
    }
}

/// Returns the scene of a file that is loaded by itself, with its notes; the file's name stands for its path.
fn noted(name: &str, files: &[(&str, Vec<u8>)]) -> (Vec<Mesh>, Vec<String>) {
    let folder = TempDir::new().expect("a temporary folder");
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).expect("written"));
    let path = folder.path().join(name);
    let loaded = AnimatedScene::load(path.to_str().expect("UTF-8"), 0.0).expect("a scene");
    let within = format!("{}/", folder.path().display());
    (loaded.scene.meshes, loaded.notes.iter().map(|note| note.replace(&within, "")).collect())
}

#[test]
fn what_is_left_out_is_told() {
    let mut square = Square::new(json!({"alphaMode": "MASK", "alphaCutoff": 1.5}));
    let part = square.root["meshes"][0]["primitives"][0].clone();
    let mut shown = part.clone();
    shown["material"] = json!(1);
    square.root["meshes"][0]["primitives"] = json!([part, shown]);
    square.root["materials"] = json!([square.root["materials"][0], {"extensions": {"KHR_materials_transmission":
        {"transmissionFactor": 0.5, "transmissionTexture": {"index": 0}}}}]);
    let one = "leaf.gltf: 1 mesh has a cutoff above 1 and is left out";
    let texture = "leaf.gltf: 1 mesh has a transmission texture, which is not read";
    let (meshes, notes) = noted("leaf.gltf", &[("leaf.gltf", square.text())]);
    assert_eq!((meshes.len(), meshes[0].alpha.clone()), (1, flat(AlphaMode::SeeThrough, 0.5)));
    assert_eq!(notes, [one, texture]);
    // A scene file tells the notes of each of its files once.
    let scene = format!("[[meshes]]\nfile = \"leaf.gltf\"\n{LIGHT}{CAMERA}[[meshes]]\nfile = \"leaf.gltf\"\n");
    let files = [("leaf.gltf", square.text()), ("scene.toml", scene.into_bytes())];
    let (meshes, notes) = noted("scene.toml", &files);
    assert_eq!((meshes.len(), notes), (2, vec![one.to_owned(), texture.to_owned()]));
    let parts = square.root["meshes"][0]["primitives"].as_array_mut().expect("primitives");
    parts.push(part);
    let (_, notes) = noted("leaf.gltf", &[("leaf.gltf", square.text())]);
    assert_eq!(notes[0], "leaf.gltf: 2 meshes have a cutoff above 1 and are left out");
    assert!(noted("leaf.gltf", &[("leaf.gltf", cut_out().text())]).1.is_empty());
    let mut both = masked();
    both["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}});
    let mut square = cut_out();
    square.root["materials"][0] = both;
    let (_, notes) = noted("leaf.gltf", &[("leaf.gltf", square.text())]);
    let color = "leaf.gltf: 1 mesh has a color by texture or by vertex on its transmission, which is not read";
    assert_eq!(notes, [color, "leaf.gltf: 1 mesh has a cutoff beside its transmission, which is not read"]);
    // A file of nothing else says why there is nothing.
    let hidden = Square::new(json!({"alphaMode": "MASK", "alphaCutoff": 1.5}));
    let folder = TempDir::new().expect("a temporary folder");
    std::fs::write(folder.path().join("leaf.gltf"), hidden.text()).expect("written");
    message(load(&folder.path().join("leaf.gltf")), "leaf.gltf", "1 mesh has a cutoff above 1 and is left out; give");
}

#[test]
fn scene_files_cut_holes() {
    let cut = |square: &Square, keys: &str| load_caster("meshes", "leaf.gltf", &square.text(), keys);
    let mut leaf = cut_out();
    leaf.root["materials"][0]["alphaMode"] = json!("BLEND");
    let before = leaf.alpha().expect("alpha");
    let after = cut(&leaf, "cutout = 0.25").expect("cut").meshes.remove(0).alpha.expect("alpha");
    assert_eq!(after, Alpha { mode: AlphaMode::Cut(0.25), ..before });
    assert_eq!(
        cut(&leaf, "cutout = 1").expect("cut").meshes[0].alpha.as_ref().expect("alpha").mode,
        AlphaMode::Cut(1.0)
    );
    for wrong in ["0", "-0.5", "1.5", "nan", "inf", "1e-60"] {
        message(cut(&leaf, &format!("cutout = {wrong}")), "meshes leaf.gltf: cutout ", "is not above 0 and at most 1");
    }
    let words = "there is a cutout, but no mesh of the file is see-through";
    message(cut(&Square::new(json!({})), "cutout = 0.5"), "meshes leaf.gltf", words);
    message(cut(&cut_out(), "cutout = 0.5"), "meshes leaf.gltf", words);
}
