//! The caller's buffers on the device, and their layouts.

use crate::gpu::Buffer;
use crate::scene::{AlphaMode, AlphaTexture, Light, LightKind, Wrap};
use crate::{Error, Result};
use glam::DVec3;

/// Elements of one layout at a constant stride in one of the caller's buffers ([`Buffer::adopt`]).
#[derive(Clone)]
pub struct Source {
    /// The caller's buffer. It may contain other data before, between and after the elements.
    pub buffer: Buffer,
    /// Byte offset of the first element, a multiple of 4.
    pub offset: u64,
    /// Distance between elements in bytes, a multiple of 4.
    pub stride: u32,
    /// Number of elements.
    pub count: Count,
}

/// The number of elements, known to the host or only to the device.
#[derive(Clone)]
pub enum Count {
    /// Known to the host.
    Host(u32),
    /// Known only to the device: a 32-bit number in a buffer, at a byte offset that is a multiple of 4. Elements past the capacity are
    /// dropped ([`super::Gathered`]).
    Device {
        /// The buffer that contains the number.
        buffer: Buffer,
        /// Byte offset of the number.
        offset: u64,
    },
}

/// A float, stored per element or shared by all elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// Stored at this byte offset in each element, a multiple of 4.
    At(u32),
    /// The same value for all elements.
    Is(f32),
}

/// Offsets of a sphere's fields, in bytes from its start; multiples of 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereAt {
    /// Position: three floats, in world units.
    pub position: u32,
    /// Radius in world units, > 0.
    pub radius: Number,
    /// Extinction in 1 / world unit, ≥ 0.
    pub extinction: Number,
}

impl SphereAt {
    /// The layout of [`crate::scene::Particle`], 20 bytes.
    pub const PARTICLE: Self = Self { position: 0, radius: Number::At(12), extinction: Number::At(16) };

    /// The layout of [`crate::scene::Caster`], 32 bytes.
    pub const CASTER: Self = Self { position: 0, radius: Number::At(12), extinction: Number::At(28) };
}

/// Offsets of a hair segment's fields, in bytes from its start; multiples of 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrandAt {
    /// Start point: three floats, in world units.
    pub start: u32,
    /// End point: three floats, in world units; must differ from the start.
    pub end: u32,
    /// Half the ribbon's width in world units, > 0.
    pub radius: Number,
    /// Optical depth, ≥ 0, clamped to 80: for an opacity o it is −ln(1 − o).
    pub depth: Number,
}

/// Offsets of a splat's fields, in bytes from its start; multiples of 4. A splat is an anisotropic Gaussian of extinction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatAt {
    /// Centre: three floats, in world units.
    pub position: u32,
    /// Standard deviations along the splat's own axes: three floats, in world units, > 0.
    pub deviations: u32,
    /// Axes: four floats, a quaternion x, y, z, w of any nonzero length.
    pub rotation: u32,
    /// Fraction of light that the splat removes from a ray through its centre along its shortest axis, in [0, 1].
    pub opacity: Number,
}

/// Offsets of a light's fields, in bytes from its start; multiples of 4. All fields must be inside the buffer, including those that the
/// light's type does not use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightAt {
    /// Position: three floats, in world units; unused for a directional light.
    pub position: u32,
    /// Direction: three floats, of unit length to within a thousandth. Direction in which a directional light shines, axis of a spot light,
    /// or normal of a virtual light; unused for a point light.
    pub direction: u32,
    /// Radiance: three floats, linear RGB, ≥ 0; see [`Light::radiance`].
    pub radiance: u32,
    /// Radius in world units, at least 1e-18. For a spot or a point light, the distance at which it ends, which may be infinite; for a
    /// virtual light, the distance below which it gets no brighter; unused for a directional light.
    pub radius: Number,
    /// Cosine of half the full opening angle of a spot light: less than 1, and at least the cosine of half of 170°.
    pub cos_cone: Number,
}

/// A light's type, which determines the light's number of maps: six for a point or a virtual light, one for any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightType {
    /// See [`LightKind::Directional`].
    Directional,
    /// See [`LightKind::Spot`].
    Spot,
    /// See [`LightKind::Point`].
    Point,
    /// See [`LightKind::Virtual`].
    Virtual,
}

impl LightType {
    /// Returns a dark light of this type. On the host it replaces a light whose values only the device knows.
    pub(super) fn stand_in(self) -> Light {
        let (position, direction) = (DVec3::ZERO, DVec3::NEG_Z);
        let kind = match self {
            Self::Directional => LightKind::Directional { direction },
            Self::Spot => LightKind::Spot { position, direction, cone_degrees: 90.0 },
            Self::Point => LightKind::Point { position },
            Self::Virtual => LightKind::Virtual { position, normal: direction, nearest: 1.0 },
        };
        Light { kind, radiance: [0.0; 3], radius: f64::INFINITY }
    }
}

/// Triangles in the caller's buffers.
#[derive(Clone)]
pub struct Corners {
    /// Vertices, each starting with three floats, in world units.
    pub vertices: Buffer,
    /// Byte offset of the first vertex, a multiple of 4.
    pub offset: u64,
    /// Distance between vertices in bytes, a multiple of 4.
    pub stride: u32,
    /// 32-bit vertex indices, three per triangle: the buffer, and their byte offset, a multiple of 4. None if the vertices are not indexed,
    /// so that three consecutive ones make up each triangle.
    pub indices: Option<(Buffer, u64)>,
    /// Number of triangles.
    pub count: Count,
    /// Diffuse reflectance of all triangles.
    pub albedo: [f32; 3],
    /// Alpha of all triangles ([`crate::scene::Alpha`]), in a world with [`Capacity::alpha_texels`](super::Capacity::alpha_texels). None:
    /// the triangles block all light.
    pub alpha: Option<AlphaAt>,
}

/// Where the alpha of the caller's triangles is: at each point the texture's times the factor.
#[derive(Clone)]
pub struct AlphaAt {
    /// Holes, or glass. [`AlphaMode::SeeThrough`] needs a world with [`Capacity::see_through`](super::Capacity::see_through).
    pub mode: AlphaMode,
    /// Factor per vertex, in [0, 1], at a byte offset from the vertex's start.
    pub factor: Number,
    /// The texture; without one, its alpha counts as 1.
    pub texture: Option<TextureAt>,
}

/// A texture's alpha in the caller's buffer.
#[derive(Clone)]
pub struct TextureAt {
    /// Byte offset of a vertex's place in the texture, from the vertex's start, a multiple of 4: two floats, as in
    /// [`crate::scene::Alpha::uvs`]. A triangle with a place that is not finite casts nothing.
    pub uv: u32,
    /// The texels' alpha: a byte each, row by row from the top, and up to three bytes more, to whole words.
    pub texels: Buffer,
    /// Byte offset of the first texel, a multiple of 4.
    pub offset: u64,
    /// Width and height in texels, each from 1 to [`crate::scene::AlphaTexture::MOST_SIDE`].
    pub size: [u32; 2],
    /// How the texture continues beyond its borders, across and down.
    pub wrap: [Wrap; 2],
}

impl TextureAt {
    /// Returns the number of 32-bit words of texels, if they fit into room for `room` texels.
    pub(super) fn words(&self, room: u32) -> std::result::Result<u32, String> {
        let [width, height] = self.size;
        if !self.size.iter().all(|side| (1..=AlphaTexture::MOST_SIDE).contains(side)) {
            return Err(format!("a texture of {width} × {height} texels"));
        }
        let words = (u64::from(width) * u64::from(height)).div_ceil(4);
        if 4 * words > u64::from(room.next_multiple_of(4)) {
            return Err(format!("a texture of {width} × {height} texels, and the world has room for {room}"));
        }
        if self.offset.saturating_add(4 * words) > self.texels.bytes() {
            return Err(format!("a texture of {width} × {height} texels in a buffer of {} bytes", self.texels.bytes()));
        }
        Ok(words as u32)
    }
}

/// Marks a missing word offset in a buffer. Twin: NOWHERE in glsl/world/gather.glsl.
pub(super) const NOWHERE: u32 = u32::MAX;

fn error(what: &str, cause: String) -> Error {
    Error::input(what, cause, "give what the buffer holds, or make the world with a larger capacity")
}

/// Returns the number of 32-bit words in `bytes`.
///
/// # Errors
/// [`Error::Input`] if `bytes` is not a multiple of 4.
pub(super) fn words(what: &str, bytes: u64) -> Result<u32> {
    let whole = u32::try_from(bytes / 4).ok().filter(|_| bytes.is_multiple_of(4));
    whole.ok_or_else(|| error(what, format!("an offset or a stride of {bytes} bytes, and there are words of 4")))
}

impl Number {
    /// Returns the number's word offset and value, as push constants.
    pub(super) fn pushed(self, what: &str) -> Result<(u32, f32)> {
        match self {
            Self::At(bytes) => Ok((words(what, bytes.into())?, 0.0)),
            Self::Is(value) => Ok((NOWHERE, value)),
        }
    }

    /// Returns the end of the number in an element, as a byte offset.
    pub(super) fn end(self) -> u32 {
        match self {
            Self::At(bytes) => bytes.saturating_add(4),
            Self::Is(_) => 0,
        }
    }
}

/// Returns how many elements of `bytes` bytes, `stride` bytes apart, a buffer holds from `offset` on.
pub(super) fn held(buffer: &Buffer, offset: u64, stride: u32, bytes: u32) -> u32 {
    match buffer.bytes().checked_sub(offset.saturating_add(bytes.into())) {
        None => 0,
        Some(_) if stride == 0 => u32::MAX,
        Some(more) => u32::try_from(more / u64::from(stride) + 1).unwrap_or(u32::MAX),
    }
}

/// The element count for a gather pass.
pub(super) struct CountSource {
    /// The largest number of elements to gather.
    pub most: u32,
    /// The word that contains the count; [`NOWHERE`] if the host knows the count.
    pub at: u32,
}

impl Count {
    /// Returns the count, limited by `capacity` and by what the buffer holds.
    ///
    /// # Errors
    /// [`Error::Input`] if the host's count exceeds `capacity`, or the device's count is outside its buffer.
    pub(super) fn counted(&self, what: &str, capacity: u32, held: u32) -> Result<CountSource> {
        match self {
            Self::Host(count) if *count > capacity => {
                Err(error(what, format!("{count}, and the world has room for {capacity}")))
            }
            Self::Host(count) if *count > held => Err(error(what, format!("{count}, and the buffer holds {held}"))),
            Self::Host(count) => Ok(CountSource { most: *count, at: NOWHERE }),
            Self::Device { buffer, offset } if offset.saturating_add(4) > buffer.bytes() => {
                Err(error(what, format!("a count at byte {offset} of a buffer of {}", buffer.bytes())))
            }
            Self::Device { offset, .. } => Ok(CountSource { most: capacity.min(held), at: words(what, *offset)? }),
        }
    }

    /// Returns the buffer that contains the count; `other` if the host knows the count.
    pub(super) fn buffer<'a>(&'a self, other: &'a Buffer) -> &'a Buffer {
        match self {
            Self::Host(_) => other,
            Self::Device { buffer, .. } => buffer,
        }
    }
}
