//! Promises of AVSM, and the specs that run if a command names none.

use super::settings::{BuildPath, Settings};
use crate::technique::keys::Name;
use crate::technique::promises::EIGHT_BITS;
use crate::technique::{Path, Promises, Runs};

/// Returns the promises of the settings on a path.
pub fn promises(settings: &Settings, path: &Path) -> Promises {
    let (is_linear, is_captured) = (!settings.is_exponential(), !settings.is_sorted());
    let (is_tight, is_adaptive) = (settings.is_tight(), settings.is_adaptive());
    // A full list loses the last segments.
    let loses = settings.capacity.is_some();
    // Single-pass paths insert casters by the depth of their nearest points, so segments may be out of order.
    let is_sorted = (path.is(BuildPath::TwoPass) || path.is(BuildPath::Binned)) && !is_captured;
    // `gobo stress` queries along the rays of an even map's texels. Adaptive maps and area texels represent other rays; tests against the
    // CPU twins check their tails instead.
    let has_other_rays = is_adaptive || settings.is_of_areas();
    let mean = if is_sorted { 1e-2 } else { 2e-2 };
    Promises {
        // Straight lines between nodes miss the exponential falloff in smoke. Nodes of two bytes are coarse.
        mean: Some(mean).filter(|_| !(is_linear || is_tight || has_other_rays || loses)),
        // A tight node stores its value in one byte, quantized once.
        tail: Some(if is_tight { EIGHT_BITS } else { 1e-3 }).filter(|_| !(has_other_rays || loses)),
        order: Some(0.0).filter(|_| is_sorted && !is_linear && !loses),
        repeats: !is_captured && !loses,
        // With skip=off, tiles without casters are built too and use some of the bytes that the tiles of adaptive maps share.
        skips_alike: !is_adaptive,
        finer: if is_adaptive { 8.0 } else { 1.0 },
        ..Promises::OF_DEPTH
    }
}

/// Specs that commands run.
pub const RUNS: Runs = Runs {
    usual: &["path=two-pass|interlock|raster-order|binned"],
    usual_on_cpu: &["size=128,path=two-pass|interlock|raster-order|binned"],
    compare: &["nodes=4|8|16,curve=linear|exponential,path=two-pass|interlock", "nodes=8,path=raster-order|binned"],
    on_cpu: &[(Name::SIZE, "64")],
    stress_smoke: &[
        "size=32,path=two-pass|interlock|raster-order",
        "size=32,path=two-pass,resolve=whole",
        "size=32,path=binned,resolve=streaming|whole|cells",
        "size=32,path=two-pass,curve=linear",
        "size=32,path=binned,levels=3",
        "size=32,path=binned,nodes=4,storage=packed,batch=shared",
        "size=32,path=binned,nodes=16,storage=tight,batch=lanes",
        "size=32,path=binned,detail=adaptive",
        "size=32,path=binned,texel=area",
        "size=32,path=binned,resolve=cells,fit=plain,storage=full",
        "size=32,path=two-pass,resolve=whole,fit=refined",
        "size=32,path=two-pass,order=captured,nudge=off",
    ],
    ..Runs::NONE
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::avsm::ENTRY;
    use crate::technique::parse;

    /// Asserts the promised mean, tail and order for several settings and paths: a setting that breaks a promise must withdraw it.
    #[test]
    fn keys_take_promises_back() {
        let of = |settings: &str, path: &str| {
            let path = ENTRY.path(path).expect(path);
            let promises = promises(&parse(&format!("avsm:{settings}"), &[]).expect(settings)[0].settings(), path);
            (promises.mean, promises.tail, promises.order)
        };
        let exact = Some(0.0);
        for (settings, path, expected) in [
            ("", "binned", (Some(1e-2), Some(1e-3), exact)),
            ("", "two-pass", (Some(1e-2), Some(1e-3), exact)),
            ("", "interlock", (Some(2e-2), Some(1e-3), None)),
            ("order=captured", "two-pass", (Some(2e-2), Some(1e-3), None)),
            ("curve=linear", "binned", (None, Some(1e-3), None)),
            ("storage=tight", "binned", (None, Some(1e-2), exact)),
            ("detail=adaptive", "binned", (None, None, exact)),
            ("texel=area", "binned", (None, None, exact)),
            ("capacity=100", "two-pass", (None, None, None)),
        ] {
            assert_eq!(of(settings, path), expected, "{settings} {path}");
        }
    }
}
