//! The shaders, as build.rs beside this folder compiled them.

macro_rules! spirv {
    ($($file:literal),+) => {
        include_bytes!(concat!(env!("OUT_DIR"), "/embed/", $($file,)+ ".spv"))
    };
}

pub const MOVE: &[u8] = spirv!("move.comp");
pub const SORT: &[u8] = spirv!("sort.comp");
pub const GROUND_VERT: &[u8] = spirv!("ground.vert");
pub const SMOKE_VERT: &[u8] = spirv!("smoke.vert");

/// Shaders that ask how much of the sun gets through, of one technique.
pub struct Asking {
    pub ground: &'static [u8],
    pub smoke: &'static [u8],
    /// At a list of points.
    pub points: &'static [u8],
}

macro_rules! asking {
    ($technique:literal) => {
        Asking {
            ground: spirv!($technique, "/ground.frag"),
            smoke: spirv!($technique, "/smoke.frag"),
            points: spirv!($technique, "/ask.comp"),
        }
    };
}

pub const AVSM: Asking = asking!("avsm");
pub const PSM: Asking = asking!("psm");
pub const BEER_SHADOW_MAP: Asking = asking!("beer_shadow_map");
