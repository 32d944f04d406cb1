//! The alpha of glTF textures: PNG and WebP images, embedded or in files beside.

use crate::scene::files::gltf_accessor::view_bytes;
use crate::scene::files::gltf_document::{self, GltfDocument};
use crate::scene::{AlphaTexture, Wrap};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, LumaA, Rgba};
use serde_json::Value;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// The largest number of texels of all textures of a file. A small file can name one image many times.
const MOST_TEXELS: usize = 1 << 30;

/// The most memory, in bytes, that decoding one image may take: texels of 8 bytes, and what the decoder needs itself.
const MOST_BYTES: u64 = (AlphaTexture::MOST_SIDE as u64).pow(2) * 8 + (1 << 28);

/// The first bytes of a KTX2 file.
const KTX2: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

const EXPORT_AGAIN: &str = "export the file again with its textures";

/// What is wrong with a material or a texture, and what may help.
pub(in crate::scene) struct Fault {
    pub cause: String,
    pub way_out: &'static str,
}

pub(in crate::scene) type Checked<T> = Result<T, Fault>;

impl Fault {
    pub(in crate::scene) fn new(cause: impl Into<String>, way_out: &'static str) -> Self {
        Self { cause: cause.into(), way_out }
    }

    /// Adds the place of the fault to its cause.
    pub(in crate::scene) fn within(self, place: &str) -> Self {
        Self { cause: format!("{place}: {}", self.cause), ..self }
    }
}

/// Returns a name for messages of an item of the file: its kind, its index and, if it has one, its own name.
pub(in crate::scene) fn label(kind: &str, index: usize, item: &Value) -> String {
    item["name"].as_str().map_or_else(|| format!("{kind} {index}"), |name| format!("{kind} {index} ({name})"))
}

/// Returns an index of the JSON, if it is one.
pub(in crate::scene) fn index(value: &Value) -> Option<usize> {
    usize::try_from(value.as_u64()?).ok()
}

/// The textures of one file, each read at its first use.
pub(in crate::scene) struct Textures<'a> {
    path: &'a Path,
    file: &'a GltfDocument,
    /// Textures by the index of their image and the way they continue. `None`: alpha is 1 everywhere.
    known: HashMap<(usize, [u8; 2]), Option<Arc<AlphaTexture>>>,
    /// The number of texels of all of them.
    texels: usize,
}

impl<'a> Textures<'a> {
    pub(in crate::scene) fn new(path: &'a Path, file: &'a GltfDocument) -> Self {
        Self { path, file, known: HashMap::new(), texels: 0 }
    }

    /// Returns the alpha of a texture; `None` if it is 1 everywhere.
    pub(in crate::scene) fn read(&mut self, texture: usize) -> Checked<Option<Arc<AlphaTexture>>> {
        let missing = || Fault::new(format!("there is no texture {texture}"), EXPORT_AGAIN);
        let json = self.file.appearance["textures"].get(texture).ok_or_else(missing)?;
        self.read_json(json).map_err(|fault| fault.within(&label("texture", texture, json)))
    }

    fn read_json(&mut self, texture: &Value) -> Checked<Option<Arc<AlphaTexture>>> {
        let image = source(texture).ok_or_else(|| Fault::new("has no image", EXPORT_AGAIN))?;
        let wrap = self.wrap(texture)?;
        let key = (image, wrap.map(|wrap| wrap as u8));
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let missing = || Fault::new(format!("there is no image {image}"), EXPORT_AGAIN);
        let json = self.file.appearance["images"].get(image).ok_or_else(missing)?;
        let read = self.bytes(json).and_then(|bytes| decode(&bytes, wrap));
        let read = read.and_then(|read| self.counted(read)).map_err(|fault| fault.within(&name(image, json)))?;
        let is_opaque = |read: &AlphaTexture| read.texels.iter().all(|alpha| *alpha == u8::MAX);
        let read = read.filter(|read| !is_opaque(read)).map(Arc::new);
        self.known.insert(key, read.clone());
        Ok(read)
    }

    /// Returns how a texture continues beyond its borders, by its sampler.
    fn wrap(&self, texture: &Value) -> Checked<[Wrap; 2]> {
        let sampler = &texture["sampler"];
        if sampler.is_null() {
            return Ok([Wrap::Repeat; 2]);
        }
        let found = index(sampler).and_then(|index| self.file.appearance["samplers"].get(index));
        let found = found.ok_or_else(|| Fault::new(format!("there is no sampler {sampler}"), EXPORT_AGAIN))?;
        Ok([wrap(found, "wrapS")?, wrap(found, "wrapT")?])
    }

    /// Returns the bytes of an image, still encoded.
    fn bytes(&self, image: &Value) -> Checked<Cow<'a, [u8]>> {
        if let Some(uri) = image["uri"].as_str() {
            let bytes = gltf_document::read_uri(self.path, uri);
            let beside = |cause| Fault::new(cause, "embed the image or put its file beside");
            return bytes.map(Cow::Owned).map_err(beside);
        }
        let view = index(&image["bufferView"]).and_then(|index| self.file.document.views().nth(index));
        let view = view.ok_or_else(|| Fault::new("has neither a file nor a buffer view", EXPORT_AGAIN))?;
        let bytes = view_bytes(&self.file.buffers, &view);
        bytes.map(Cow::Borrowed).ok_or_else(|| Fault::new("reaches beyond its buffer", EXPORT_AGAIN))
    }

    /// Adds a texture to the number of texels, which is limited.
    fn counted(&mut self, read: Option<AlphaTexture>) -> Checked<Option<AlphaTexture>> {
        self.texels += read.as_ref().map_or(0, |read| read.texels.len());
        if self.texels > MOST_TEXELS {
            return Err(Fault::new(format!("the textures have more than {MOST_TEXELS} texels"), "give smaller ones"));
        }
        Ok(read)
    }
}

/// Returns the index of a texture's image: WebP, if there is one, or else the plain one, or else that of any other extension.
fn source(texture: &Value) -> Option<usize> {
    let extensions = &texture["extensions"];
    let others = extensions.as_object().into_iter().flatten().map(|(_, extension)| &extension["source"]);
    [&extensions["EXT_texture_webp"]["source"], &texture["source"]].into_iter().chain(others).find_map(index)
}

/// Returns how a texture continues in one direction.
fn wrap(sampler: &Value, key: &str) -> Checked<Wrap> {
    match (&sampler[key], sampler[key].as_u64()) {
        (Value::Null, _) | (_, Some(10497)) => Ok(Wrap::Repeat),
        (_, Some(33071)) => Ok(Wrap::Clamp),
        (_, Some(33648)) => Ok(Wrap::Mirror),
        (other, _) => Err(Fault::new(format!("{key} is {other}, not 10497, 33071 or 33648"), "correct the sampler")),
    }
}

/// Returns a name for messages of an image: that of its file, if it has one.
fn name(image: usize, json: &Value) -> String {
    let file = json["uri"].as_str().filter(|uri| !uri.starts_with("data:"));
    file.map_or_else(|| label("image", image, json), |uri| format!("image {image} ({uri})"))
}

/// Decodes the alpha of an image; `None` if it has none. The kind of image is read from its bytes: files may declare another.
fn decode(bytes: &[u8], wrap: [Wrap; 2]) -> Checked<Option<AlphaTexture>> {
    let Some(format) = format(bytes)? else { return Ok(None) };
    let undecodable = |cause: image::ImageError| Fault::new(cause.to_string(), "export the image again as PNG");
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(undecodable)?;
    if !decoder.color_type().has_alpha() {
        return Ok(None);
    }
    let (width, height) = decoder.dimensions();
    if [width, height].iter().any(|side| !(1..=AlphaTexture::MOST_SIDE).contains(side)) {
        let cause = format!("is {width} × {height} texels, not 1 to {} per side", AlphaTexture::MOST_SIDE);
        return Err(Fault::new(cause, "give another size"));
    }
    let texels = alphas(&DynamicImage::from_decoder(decoder).map_err(undecodable)?);
    Ok(Some(AlphaTexture { size: [width, height], wrap, texels }))
}

/// Returns the format of an image that may have alpha; `None` for JPEG, which has none.
fn format(bytes: &[u8]) -> Checked<Option<ImageFormat>> {
    if bytes.starts_with(KTX2) {
        let way_out = "run gltf-transform ktxdecompress IN.glb OUT.glb, which makes it PNG";
        return Err(Fault::new("is KTX2, which is not decoded", way_out));
    }
    match image::guess_format(bytes) {
        Ok(ImageFormat::Jpeg) => Ok(None),
        Ok(format @ (ImageFormat::Png | ImageFormat::WebP)) => Ok(Some(format)),
        _ => Err(Fault::new("is not PNG, JPEG or WebP", "export the image again as PNG")),
    }
}

/// Returns the alpha of each texel; 16 bits are rounded to 8.
fn alphas(image: &DynamicImage) -> Vec<u8> {
    let rounded = |alpha: u16| ((u32::from(alpha) + 128) / 257) as u8;
    match image {
        DynamicImage::ImageLumaA8(image) => image.pixels().map(|LumaA([_, alpha])| *alpha).collect(),
        DynamicImage::ImageRgba8(image) => image.pixels().map(|Rgba([.., alpha])| *alpha).collect(),
        DynamicImage::ImageLumaA16(image) => image.pixels().map(|LumaA([_, alpha])| rounded(*alpha)).collect(),
        DynamicImage::ImageRgba16(image) => image.pixels().map(|Rgba([.., alpha])| rounded(*alpha)).collect(),
        other => other.to_rgba8().pixels().map(|Rgba([.., alpha])| *alpha).collect(),
    }
}
