//! The caller's buffers on the device, and their layouts.

use crate::gpu::Buffer;
use crate::scene::{Light, LightKind};
use crate::{Error, Result};
use glam::DVec3;

/// Elements of one layout in a buffer of the caller's ([`Buffer::adopt`]), at equal distances.
#[derive(Clone)]
pub struct Source {
    /// The caller's buffer. It may hold anything before, between and behind the elements.
    pub buffer: Buffer,
    /// The byte at which the first element begins, a multiple of 4.
    pub offset: u64,
    /// Bytes from one element to the next, a multiple of 4.
    pub stride: u32,
    /// How many elements there are.
    pub count: Count,
}

/// How many elements there are, and whether the host or the device knows the number.
#[derive(Clone)]
pub enum Count {
    /// The host knows.
    Host(u32),
    /// The device knows: a 32-bit number in a buffer, at a byte that is a multiple of 4. Elements past the capacity are
    /// left out ([`super::Gathered`]).
    Device {
        /// The buffer with the number.
        buffer: Buffer,
        /// The byte at which the number is.
        offset: u64,
    },
}

/// A float that each element has, or that is the same for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// At this byte of each element, a multiple of 4.
    At(u32),
    /// This value for all elements.
    Is(f32),
}

/// Offsets of a sphere's fields, bytes from its start, multiples of 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereAt {
    /// Three floats, world units.
    pub position: u32,
    /// World units, > 0.
    pub radius: Number,
    /// 1 / world unit, ≥ 0.
    pub extinction: Number,
}

impl SphereAt {
    /// The layout of [`crate::scene::Particle`], 20 bytes.
    pub const PARTICLE: Self = Self { position: 0, radius: Number::At(12), extinction: Number::At(16) };

    /// The layout of [`crate::scene::Caster`], 32 bytes.
    pub const CASTER: Self = Self { position: 0, radius: Number::At(12), extinction: Number::At(28) };
}

/// Offsets of a hair segment's fields, bytes from its start, multiples of 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrandAt {
    /// Three floats, world units.
    pub start: u32,
    /// Three floats, world units; must differ from the start.
    pub end: u32,
    /// Half the ribbon's width, world units, > 0.
    pub radius: Number,
    /// Its optical depth, ≥ 0, taken as 80 where it is more: for an opacity o it is −ln(1 − o).
    pub depth: Number,
}

/// Offsets of the fields of a splat, an anisotropic Gaussian of extinction, bytes from its start, multiples of 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatAt {
    /// Three floats: its middle, world units.
    pub position: u32,
    /// Three floats: standard deviations along its own axes, world units, > 0.
    pub deviations: u32,
    /// Four floats: its axes, a quaternion x, y, z, w of any length but 0.
    pub rotation: u32,
    /// The share of light that it takes from a ray through its middle along its shortest axis, in [0, 1].
    pub opacity: Number,
}

/// Offsets of a light's fields, bytes from its start, multiples of 4. All fields must lie in the buffer, also those
/// that the light's type does not use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightAt {
    /// Three floats, world units: the light's position; unused for a directional light.
    pub position: u32,
    /// Three floats, unit length up to a thousandth: the direction in which a directional light travels, the axis of a
    /// spot light, the normal of a virtual light; unused for a point light.
    pub direction: u32,
    /// Three floats, linear RGB, ≥ 0: see [`Light::radiance`].
    pub radiance: u32,
    /// World units, at least 1e-18. For a spot or a point light: the distance at which it ends, which may be infinite.
    /// For a virtual light: the distance below which it gets no brighter. Unused for a directional light.
    pub radius: Number,
    /// Cosine of half the full opening angle of a spot light: less than 1, and at least the cosine of half of 170°.
    pub cos_cone: Number,
}

/// A light's type, which decides how many maps the light has: six for a point or a virtual light, one for any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightType {
    /// As [`LightKind::Directional`].
    Directional,
    /// As [`LightKind::Spot`].
    Spot,
    /// As [`LightKind::Point`].
    Point,
    /// As [`LightKind::Virtual`].
    Virtual,
}

impl LightType {
    /// A dark light of that type. On the host it stands for a light whose values only the device knows.
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

/// Triangles in buffers of the caller's.
#[derive(Clone)]
pub struct Corners {
    /// Vertices, each of which begins with three floats, world units.
    pub vertices: Buffer,
    /// The byte at which the first vertex begins, a multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex to the next, a multiple of 4.
    pub stride: u32,
    /// 32-bit indices of vertices, three per triangle: the buffer, and the byte at which they begin, a multiple of 4.
    /// None where the vertices themselves stand in threes, one three for each triangle.
    pub indices: Option<(Buffer, u64)>,
    /// How many triangles.
    pub count: Count,
    /// Diffuse reflectance of all triangles.
    pub albedo: [f32; 3],
}

/// The number of no word in a buffer. Twin: NOWHERE in glsl/world/gather.glsl.
pub(super) const NOWHERE: u32 = u32::MAX;

fn error(what: &str, cause: String) -> Error {
    Error::input(what, cause, "give what the buffer holds, or make the world with a larger capacity")
}

/// The number of 32-bit words in `bytes`.
///
/// # Errors
/// [`Error::Input`] where `bytes` is no multiple of 4.
pub(super) fn words(what: &str, bytes: u64) -> Result<u32> {
    let whole = u32::try_from(bytes / 4).ok().filter(|_| bytes.is_multiple_of(4));
    whole.ok_or_else(|| error(what, format!("an offset or a stride of {bytes} bytes, and there are words of 4")))
}

impl Number {
    /// The number's word and value, as push constants.
    pub(super) fn pushed(self, what: &str) -> Result<(u32, f32)> {
        match self {
            Self::At(bytes) => Ok((words(what, bytes.into())?, 0.0)),
            Self::Is(value) => Ok((NOWHERE, value)),
        }
    }

    /// The byte behind the number in an element.
    pub(super) fn end(self) -> u32 {
        match self {
            Self::At(bytes) => bytes.saturating_add(4),
            Self::Is(_) => 0,
        }
    }
}

/// How many elements of `bytes`, `stride` apart, a buffer holds from `offset` on.
pub(super) fn held(buffer: &Buffer, offset: u64, stride: u32, bytes: u32) -> u32 {
    match buffer.bytes().checked_sub(offset.saturating_add(bytes.into())) {
        None => 0,
        Some(_) if stride == 0 => u32::MAX,
        Some(more) => u32::try_from(more / u64::from(stride) + 1).unwrap_or(u32::MAX),
    }
}

/// The count by which a gathering pass goes.
pub(super) struct CountSource {
    /// The most elements to take.
    pub most: u32,
    /// The word that holds the count; [`NOWHERE`] where the host knows the count.
    pub at: u32,
}

impl Count {
    /// The count, cut to `capacity` and to what the buffer holds.
    ///
    /// # Errors
    /// [`Error::Input`] where the host's count exceeds `capacity`, or the device's count lies outside its buffer.
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

    /// The buffer that holds the count; `other` where the host knows the count.
    pub(super) fn buffer<'a>(&'a self, other: &'a Buffer) -> &'a Buffer {
        match self {
            Self::Host(_) => other,
            Self::Device { buffer, .. } => buffer,
        }
    }
}
