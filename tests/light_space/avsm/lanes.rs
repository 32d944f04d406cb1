//! The order of casters within a tile's build changes no curve: `batch=lanes`, whose subgroups skip casters that cannot meet their texels,
//! and `batch=shared`, which tests all, give the same bytes.

use crate::avsm::nodes;
use crate::support::{all, built_avsm, gpu_test, runs, scenes};
use gobo::scene::{LightKind, Scene};

#[test]
fn lanes_leave_out_what_they_cannot_meet() {
    if crate::support::is_costly("lanes_leave_out_what_they_cannot_meet") {
        return;
    }
    const NAME: &str = "lanes_leave_out_what_they_cannot_meet";
    gpu_test(NAME, |context| {
        if !runs(NAME, context, "avsm:path=binned,resolve=streaming,batch=lanes") {
            return;
        }
        let around = |scene: Scene| scenes::point([0.9, 1.1, 1.4], scene);
        let mut asked = vec![scenes::strands(), around(scenes::locks()), around(scenes::crowd())];
        if all() {
            asked.extend([
                scenes::locks(),
                scenes::crowd(),
                scenes::random(),
                scenes::inside(),
                around(scenes::random()),
            ]);
        }
        for scene in asked {
            let maps =
                if scene.lights.iter().any(|light| matches!(light.kind, LightKind::Point { .. })) { 6 } else { 1 };
            for (size, texel) in [(24, "centre"), (11, "centre"), (24, "area")] {
                let [lanes, shared] = ["lanes", "shared"].map(|batch| {
                    let text =
                        format!("avsm:path=binned,resolve=streaming,skip=off,size={size},texel={texel},batch={batch}");
                    nodes(&built_avsm(context, &scene, &text), maps * size * size, 8)
                });
                assert!(lanes == shared, "{}, {size}, texel={texel}", scene.name);
            }
        }
    });
}
