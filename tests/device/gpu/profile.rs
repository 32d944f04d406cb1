//! Work counted in passes, and their times by the host's clock, against what was requested.

use crate::support::{gpu_test, skipped};
use gobo::gpu::{
    Bindings, Blend, Buffer, Constants, Format, Graphics, Image, ImageUse, Kernel, Memory, PassCounts, Resource,
    Target, push_struct,
};
use gobo::shaders;
use std::time::{Duration, Instant};

push_struct! {
    struct DensityPush { many: f32 }
}

/// Counts workgroups times their threads; three vertices, one triangle and one fragment per pixel; and nothing for a pass without such
/// work.
#[test]
fn passes_count_what_they_were_asked_for() {
    const TEST: &str = "passes_count_what_they_were_asked_for";
    gpu_test(TEST, |context| {
        let buffer = |name| Buffer::new(context, name, 1 << 12, Memory::Device).expect("4 KiB");
        let two = [Resource::Buffer(buffer("from")), Resource::Buffer(buffer("to"))];
        let bindings = Bindings::new(context, "copy", &two).expect("two buffers");
        let copy: Kernel =
            Kernel::compute(context, &shaders::bench::COPY, &[&bindings], &Constants::new()).expect("compiled");
        const SIZE: [u32; 2] = [48, 32];
        let image = |name, format| Image::new(context, name, format, SIZE, ImageUse::Color).expect("a few texels");
        let (from, to) = (image("from", Format::R32G32B32A32_SFLOAT), image("to", Format::R8G8B8A8_UNORM));
        let bindings = Bindings::new(context, "counted", &[Resource::Texture(from)]).expect("an image");
        let colors = [(Format::R8G8B8A8_UNORM, Blend::None)];
        let (vertex, fragment) = (&shaders::shading::FULLSCREEN_VERT, &shaders::shading::DENSITY_FRAG);
        let state = Graphics { vertex, fragment, colors: &colors, depth: None };
        let over: Kernel<DensityPush> =
            Kernel::graphics(context, &state, &[&bindings], &Constants::new()).expect("compiled");
        let filled = buffer("filled");
        let run = || {
            let passes = context.submit(|commands| {
                commands.pass("copy", |pass| pass.dispatch(&copy, &(), [3, 2, 1]));
                commands.pass("nothing", |pass| pass.fill(&filled, 1));
                commands.pass("draw", |pass| {
                    let colors = [Target { image: &to, clear: None }];
                    pass.render(SIZE, &colors, None, |draw| draw.draw(&over, &DensityPush { many: 1.0 }, 3, 1));
                });
                commands.pass("twice", |pass| {
                    (0..2).for_each(|_| pass.dispatch(&copy, &(), [1, 1, 1]));
                });
            });
            passes.expect("submitted").into_iter().map(|pass| pass.counts).collect::<Vec<_>>()
        };
        let features = context.features();
        let none = vec![None; if features.timestamp_valid_bits > 0 { 4 } else { 0 }];
        assert_eq!(run(), none, "nobody has asked");
        context.count_passes(true);
        let counted = run();
        context.count_passes(false);
        assert_eq!(run(), none, "nobody asks any more");
        if !features.pipeline_statistics_query || none.is_empty() {
            assert_eq!(counted, none);
            return skipped(TEST, "no pipelineStatisticsQuery");
        }
        let counts = |threads| Some(PassCounts { threads, ..PassCounts::default() });
        assert_eq!([&counted[0], &counted[1], &counted[3]], [&counts(6 * 128), &counts(0), &counts(2 * 128)]);
        let draw = counted[2].expect("asked");
        let pixels = u64::from(SIZE[0] * SIZE[1]);
        assert_eq!([draw.vertices, draw.primitives, draw.threads], [3, 1, 0]);
        // The triangle's edges lie outside the picture or touch its corner, so no helper lane runs that could be counted.
        assert_eq!(draw.fragments, pixels, "a fragment a pixel");
    });
}

/// Device timestamps, converted to the host's clock, lie between the host times taken before and after the work, and increase from one
/// submission to the next.
#[test]
fn the_device_is_on_the_hosts_clock() {
    const TEST: &str = "the_device_is_on_the_hosts_clock";
    gpu_test(TEST, |context| {
        let start = Instant::now();
        let Some(first) = context.calibrate() else { return skipped(TEST, "no VK_EXT_calibrated_timestamps") };
        let buffer = Buffer::new(context, "filled", 1 << 16, Memory::Device).expect("64 KiB");
        let mut last = f64::NEG_INFINITY;
        for _ in 0..3 {
            let before = start.elapsed().as_nanos() as f64;
            let passes =
                context.submit(|commands| commands.pass("fill", |pass| pass.fill(&buffer, 1))).expect("submitted");
            let after = start.elapsed().as_nanos() as f64;
            let clock = context.calibrate().expect("as before");
            let begin = clock.ns_since(start, passes[0].began);
            let end = begin + passes[0].end_ns - passes[0].start_ns;
            let off = clock.deviation_ns + f64::from(context.features().timestamp_period_ns);
            assert!(before - off <= begin && end <= after + off, "{begin}..{end} in {before}..{after} ± {off}");
            assert!(begin > last, "{begin} after {last}");
            last = end;
            // The clocks drift apart by less than a thousandth.
            let by_first = first.ns_since(start, passes[0].began);
            assert!((by_first - begin).abs() <= off + first.deviation_ns + 1e-3 * after, "{by_first} and {begin}");
            std::thread::sleep(Duration::from_millis(2));
        }
    });
}
