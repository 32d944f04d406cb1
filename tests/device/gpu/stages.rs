//! The probe of stages: compute threads and fragments compute the same values as their twin, passes report whether they draw, and on
//! software drivers both stages run on all processors.

use crate::support::{gpu_test, skipped};
use gobo::bench::{StageArithmetic, stage_rates};
use gobo::gpu::{Buffer, Context, Format, Image, ImageUse, Memory, Target};
use gobo::reference::twin::arithmetic::arithmetic;
use proptest::prelude::*;

/// Compares both stages with the twin, for random seeds and rounds.
fn equals_its_twin(context: &Context, processors: bool) {
    const SIDE: u32 = 48;
    let stages = StageArithmetic::new(context, SIDE, processors).expect("room for a few values");
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(16));
    let result = runner.run(&(any::<u32>(), 0u32..40), |(seed, rounds)| {
        stages.run(seed, rounds).expect("it runs");
        let wanted: Vec<u32> = (0..SIDE * SIDE).map(|thread| arithmetic(seed, thread, rounds)).collect();
        for values in stages.read().expect("read") {
            prop_assert!(values.iter().map(|value| value[0]).eq(wanted.iter().copied()), "{seed} {rounds}");
            prop_assert!(processors || values.iter().all(|value| value[1] == 0), "no processor was asked for");
        }
        Ok(())
    });
    result.unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn the_arithmetic_of_both_stages_equals_its_twin() {
    gpu_test("the_arithmetic_of_both_stages_equals_its_twin", |context| equals_its_twin(context, false));
}

#[test]
fn so_it_does_where_it_tells_processors() {
    const TEST: &str = "so_it_does_where_it_tells_processors";
    gpu_test(TEST, |context| match context.features().shader_sm_builtins {
        true => equals_its_twin(context, true),
        false => skipped(TEST, "needs VK_NV_shader_sm_builtins"),
    });
}

/// A software driver's threads run on the host's processors in either stage.
#[test]
fn a_software_driver_is_not_lopsided() {
    gpu_test("a_software_driver_is_not_lopsided", |context| {
        let stages = stage_rates(context).expect("measured");
        println!("{stages:?}");
        assert_eq!(stages.is_some(), context.features().timestamp_valid_bits > 0);
        let Some(stages) = stages else { return };
        assert!(stages.fragment_slowdown > 0.0 && stages.fragment_slowdown.is_finite(), "{stages:?}");
        assert_eq!(stages.processors.is_some(), context.features().shader_sm_builtins);
        assert!(stages.fragment_processors <= stages.processors, "{stages:?}");
        if context.features().is_software() {
            assert!(!stages.is_lopsided(), "{stages:?}");
        }
    });
}

/// A pass that begins rendering counts as raster work; if all passes are timed as one, all do if any does.
#[test]
fn passes_say_whether_they_draw() {
    gpu_test("passes_say_whether_they_draw", |context| {
        let image = Image::new(context, "drawn", Format::R8G8B8A8_UNORM, [4, 4], ImageUse::Color).expect("16 texels");
        let buffer = Buffer::new(context, "filled", 64, Memory::Device).expect("64 bytes");
        // More passes than a flag word has bits; the last pass and the passes on either side of a word boundary draw.
        let draws = |pass: u32| [1, 63, 64, 129].contains(&pass);
        let passes = |all: bool| {
            let submitted = context.submit(|commands| {
                for i in 0..130 {
                    commands.pass("pass", |pass| match all && draws(i) {
                        true => {
                            let colors = [Target { image: &image, clear: Some([0.0; 4]) }];
                            pass.render([4, 4], &colors, None, |_| {});
                        }
                        false => pass.fill(&buffer, i),
                    });
                }
            });
            submitted.expect("submitted").into_iter().map(|pass| pass.raster).collect::<Vec<_>>()
        };
        if context.features().timestamp_valid_bits == 0 {
            assert!(passes(true).is_empty());
            return;
        }
        assert_eq!(passes(true), (0..130).map(draws).collect::<Vec<_>>());
        assert_eq!(passes(false), [false; 130]);
        context.time_passes(false);
        let together = [passes(true), passes(false)];
        context.time_passes(true);
        assert_eq!(together, [[true], [false]]);
    });
}
