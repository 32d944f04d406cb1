//! Settings of imperfect shadow maps.

use super::super::Path;
use super::super::keys::words;
use super::super::settings::{Setting, settings};
use crate::gpu::Limit;

words! {
    /// How the points are splatted.
    pub enum BuildPath {
        /// One workgroup per light, with its map in shared memory.
        Tiled = "tiled",
        /// One thread per point, with atomic operations on all maps in memory.
        Atomic = "atomic",
        /// Each point drawn as a square.
        Quads = "quads",
        /// Each point drawn as a triangle.
        Triangles = "triangles",
    }
}

words! {
    /// How to tell whether a point lies on the side of a closed mesh that faces the light.
    pub enum Facing {
        /// By the normal and the direction from the light.
        Exact = "exact",
        /// By the normals of point and light, as in Tokuyoshi 2014: an approximation.
        Slide = "slide",
    }
}

words! {
    /// Which sides of closed meshes are left out. Twin: CULL_NONE and so on.
    pub enum Culling {
        /// Sides that face the light, so the far sides cast shadows.
        Near = "on",
        /// Sides that face away from the light, so the near sides cast shadows.
        Far = "far",
        /// None.
        Off = "off",
    }
}

pub(super) const PATHS: &[Path] = &[
    Path { name: "tiled", requires: &[] },
    Path { name: "atomic", requires: &[] },
    Path { name: "quads", requires: &[] },
    Path { name: "triangles", requires: &[] },
];

settings! {
    /// Settings of imperfect shadow maps.
    #[derive(Copy)]
    pub struct Settings {
        /// How points are splatted. `None`: by one workgroup per light if a map fits into its shared memory, else by atomic operations.
        path: Option<BuildPath> = Setting::auto(
            "a workgroup per light, its map in shared memory; a thread per point; drawn; auto: the first that runs");
        /// Texels per side of a light's map: 32, 64 or 128.
        size: u32 = Setting::one_of("64", &["32", "64", "128"], "texels per side of a light's map");
        /// Number of points that each light uses, out of sixteen times as many on the meshes: 1024, 2048, 4096, 8192 or 16384. Ritschel et
        /// al. 2008 use 8000 per light.
        points: u32 = Setting::one_of(
            "8192",
            &["1024", "2048", "4096", "8192", "16384"],
            "points on the meshes that each light takes, of sixteen times as many");
        /// Whether each light uses more points where they cover more of its map or are nearer to the viewer.
        adaptive: bool =
            Setting::word("on", "each light takes its points where it and the viewer see more of them; off: evenly by area");
        /// Which points on closed meshes are left out: points on the sides that face the light, points on the sides that face away, or
        /// none. If points are drawn, a pass first lists the ones that remain (Tokuyoshi 2014).
        culling: Culling = Setting::word(
            "on", "leave out the near sides of closed things, or the far ones, or none; where points are drawn, the rest are listed");
        /// How to tell whether a point lies on the side of a closed mesh that faces the light; by the normals alone in
        /// Tokuyoshi 2014.
        facing: Facing = Setting::word(
            "exact",
            "which side of a closed thing is seen: by the direction to the point, or by the normals alone, which is not exact");
        /// Whether holes between points are filled by pull-push (Ritschel et al. 2008).
        fill: bool = Setting::word("on", "fill holes between points by pull-push");
    }
}

/// Texels per side of the smallest level.
const SMALLEST: u32 = 4;

impl Settings {
    /// Returns whether the side is decided by the normals alone.
    pub(super) fn slides(&self) -> bool {
        self.facing == Facing::Slide
    }

    /// Returns the shader's number for the culling. Twin: ISM_CULLING.
    pub(super) fn culls(&self) -> u32 {
        match self.culling {
            Culling::Off => 0,
            Culling::Near => 1,
            Culling::Far => 2,
        }
    }

    /// Returns the number of levels of a map. Twin: ISM_LEVELS.
    pub fn levels(&self) -> u32 {
        (self.size / SMALLEST).ilog2() + 1
    }

    /// Returns the number of texels in all levels of a map. Twin: ISM_TEXELS.
    pub fn texels(&self) -> u32 {
        (0..self.levels()).map(|level| (self.size >> level).pow(2)).sum()
    }

    /// Returns the limit on shared memory for a workgroup that holds a map.
    pub(super) fn room(&self) -> Limit {
        Limit::shared_memory((4 * self.texels()).into())
    }
}

/// Returns the limits of a path; devices that do not meet them are refused.
pub(super) fn limits(settings: &Settings, path: &Path) -> Vec<Limit> {
    if path.is(BuildPath::Tiled) {
        vec![settings.room()]
    } else if path.is(BuildPath::Quads) || path.is(BuildPath::Triangles) {
        vec![Limit::image_2d(settings.size.into())]
    } else {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::parse;

    #[test]
    fn a_spec_is_read() {
        let of = |text: &str| parse(text, &[]).expect(text)[0].settings::<Settings>();
        let plain = Settings::default();
        assert_eq!((of("ism"), plain.size, plain.points, plain.facing), (plain, 64, 8192, Facing::Exact));
        let path = Some(BuildPath::Atomic);
        let (adaptive, facing) = (false, Facing::Slide);
        let other = Settings { size: 32, points: 1024, adaptive, path, culling: Culling::Far, facing, fill: false };
        assert_eq!(of("ism:size=32,points=1024,adaptive=off,path=atomic,culling=far,facing=slide,fill=off"), other);
        assert_eq!(
            [32, 64, 128].map(|size| Settings { size, ..plain }).map(|s| (s.levels(), s.texels())),
            [(4, 1360), (5, 5456), (6, 21840)]
        );
    }
}
