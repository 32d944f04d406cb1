//! The Vulkan layer by itself: the validation layer is awake, bytes come back as written, limits are errors, timestamps are plausible, and
//! Rust structs have the memory layout that the shaders read.

mod adopt;

mod record;

mod layout;

mod limits;

mod profile;

mod raster_worth;
mod stages;

use crate::support::{gpu_test, log, open, skipped};
use gobo::Error;
use gobo::gpu::{
    Bindings, Buffer, Constants, Format, Image, ImageUse, Kernel, Memory, Messages, ReadBack, Resource,
    is_gpu_assisted, push_struct,
};
use gobo::shaders;
use proptest::prelude::*;

/// Runs `wrong` on a device of its own, and returns the layer's messages.
fn said_to(name: &str, wrong: impl FnOnce(&gobo::gpu::Context)) -> Vec<String> {
    let messages = Messages::default();
    let context = open(&messages);
    log("exercised", name, &format!("{}, {}", context.features().name, context.features().driver));
    wrong(&context);
    drop(context);
    messages.all()
}

/// The canaries: if these errors are not reported, no test of this suite can detect any.
#[test]
fn the_layer_reports_core_errors() {
    let said = said_to("the_layer_reports_core_errors", |context| {
        let buffer = Buffer::new(context, "canary", 64, Memory::Device).expect("64 bytes");
        // Source and destination are the same bytes, which vkCmdCopyBuffer forbids.
        context.submit(|c| c.pass("overlap", |pass| pass.copy(&buffer, &buffer, 64))).expect("submitted");
    });
    assert!(said.iter().any(|m| m.contains("VUID-vkCmdCopyBuffer-pRegions-00117")), "{said:#?}");
}

#[test]
fn the_layer_reports_hazards() {
    let said = said_to("the_layer_reports_hazards", |context| {
        let buffer = Buffer::new(context, "canary", 64, Memory::Device).expect("64 bytes");
        // Two writes of the same bytes in one pass, without a barrier between them.
        let twice = |pass: &mut gobo::gpu::Pass| {
            pass.fill(&buffer, 1);
            pass.fill(&buffer, 2);
        };
        context.submit(|c| c.pass("hazard", twice)).expect("submitted");
    });
    assert!(said.iter().any(|m| m.contains("SYNC-HAZARD-WRITE-AFTER-WRITE")), "{said:#?}");
}

/// Copies into a buffer that is too short, if the layer checks inside shaders (GOBO_TEST_VALIDATION).
#[test]
fn the_layer_reports_what_shaders_write_beyond_a_buffer() {
    const TEST: &str = "the_layer_reports_what_shaders_write_beyond_a_buffer";
    gobo::cli::test_hooks();
    if !is_gpu_assisted() {
        return skipped(TEST, "GOBO_TEST_VALIDATION is not gpu-assisted");
    }
    let copy = |bytes: [u64; 2]| {
        said_to(TEST, |context| {
            let buffer = |bytes| Buffer::new(context, "canary", bytes, Memory::Device).expect("a few bytes");
            let resources = bytes.map(|bytes| Resource::Buffer(buffer(bytes)));
            let bindings = Bindings::new(context, "copy", &resources).expect("two buffers");
            let copy = &shaders::bench::COPY;
            let kernel: Kernel = Kernel::compute(context, copy, &[&bindings], &Constants::new()).expect("compiled");
            context.submit(|c| c.pass("copy", |pass| pass.dispatch(&kernel, &(), [1, 1, 1]))).expect("submitted");
        })
    };
    assert_eq!(copy([256, 256]), [""; 0]);
    let said = copy([256, 128]);
    assert!(said.iter().any(|m| m.contains("out of bounds")), "{said:#?}");
}

/// The same two writes in separate passes are ordered by the barrier between passes, and the layer reports nothing.
#[test]
fn passes_wait_for_each_other() {
    gpu_test("passes_wait_for_each_other", |context| {
        let buffer = Buffer::new(context, "twice", 64, Memory::Device).expect("64 bytes");
        let run = context.submit(|commands| {
            commands.pass("one", |pass| pass.fill(&buffer, 1));
            commands.pass("two", |pass| pass.fill(&buffer, 2));
        });
        run.expect("submitted");
        assert_eq!(buffer.read::<u32>(16).expect("read"), [2; 16]);
    });
}

#[test]
fn buffers_give_back_what_they_were_given() {
    gpu_test("buffers_give_back_what_they_were_given", |context| {
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(24));
        // Sizes around the staging copy's word size, and some thousands of bytes.
        let size = prop_oneof![0usize..9, 4090usize..4100];
        let bytes = size.prop_flat_map(|n| prop::collection::vec(any::<u8>(), n));
        let memory = prop::sample::select(vec![Memory::Device, Memory::Upload, Memory::Readback]);
        let result = runner.run(&(bytes, memory), |(bytes, memory)| {
            let buffer = Buffer::new(context, "bytes", bytes.len() as u64, memory).expect("a few bytes");
            buffer.write(&bytes).expect("it fits");
            prop_assert_eq!(buffer.read::<u8>(bytes.len()).expect("it is there"), bytes);
            Ok(())
        });
        result.unwrap_or_else(|e| panic!("{e}"));

        let data = [1.5f32, -0.0, f32::MIN_POSITIVE];
        let buffer = Buffer::with_data(context, "floats", &data).expect("12 bytes");
        let back = buffer.read::<f32>(3).expect("it is there");
        assert_eq!(back.map(f32::to_bits), data.map(f32::to_bits));
    });
}

#[test]
fn buffers_are_read_from_the_middle() {
    gpu_test("buffers_are_read_from_the_middle", |context| {
        let data: Vec<u32> = (100..116).collect();
        for memory in [Memory::Device, Memory::Upload, Memory::Readback] {
            let buffer = Buffer::new(context, "row", 64, memory).expect("64 bytes");
            buffer.write(&data).expect("it fits");
            assert_eq!(buffer.read_from::<u32>(5, 3).expect("it is there"), [105, 106, 107], "{memory:?}");
            // Offsets count elements, not bytes.
            assert_eq!(buffer.read_from::<[u32; 4]>(3, 1).expect("it is there"), [[112, 113, 114, 115]], "{memory:?}");
            assert_eq!(buffer.read_from::<u8>(63, 1).expect("it is there"), [0], "{memory:?}");
            assert!(buffer.read_from::<u32>(16, 0).expect("nothing is everywhere").is_empty(), "{memory:?}");
            names(buffer.read_from::<u32>(14, 3), "row", "12 bytes from byte 56 of 64");
            names(buffer.read_from::<u32>(17, 1), "row", "4 bytes from byte 68 of 64");
        }
    });
}

trait Bits {
    fn map(self, f: fn(f32) -> u32) -> Vec<u32>;
}

impl Bits for Vec<f32> {
    fn map(self, f: fn(f32) -> u32) -> Vec<u32> {
        self.into_iter().map(f).collect()
    }
}

/// Asserts that the result is an error on one line about the Vulkan object of this name.
#[track_caller]
fn names<T>(result: gobo::Result<T>, name: &str, words: &str) {
    let Err(error) = result else { panic!("{name} must be refused") };
    let text = error.to_string();
    assert!(matches!(error, Error::Gpu { .. }), "{text}");
    assert!(text.contains(name) && text.contains(words) && !text.contains('\n'), "{text}");
}

#[test]
fn limits_are_errors() {
    gpu_test("limits_are_errors", |context| {
        let features = context.features();
        let limit = u64::from(features.max_storage_buffer_range);
        names(Buffer::new(context, "too-large", limit + 1, Memory::Device), "too-large", "maxStorageBufferRange");
        // No device has this much: an actual allocation would fail with other words, or bring the machine down.
        names(Buffer::new(context, "absurd", u64::MAX / 2, Memory::Device), "absurd", "maxStorageBufferRange");

        let buffer = Buffer::new(context, "small", 8, Memory::Device).expect("8 bytes");
        names(buffer.write(&[0u8; 9]), "small", "9 bytes into 8");
        names(buffer.read::<u64>(2), "small", "16 bytes from byte 0 of 8");

        let side = features.max_image_dimension_2d;
        for size in [[0, 4], [4, 0], [side + 1, 1], [1, side + 1], [u32::MAX, 1]] {
            let image = Image::new(context, "misfit", Format::R32_UINT, size, ImageUse::Storage);
            names(image, "misfit", &format!("{} × {}", size[0], size[1]));
        }
        let image = Image::new(context, "four", Format::R32_UINT, [4, 4], ImageUse::Storage).expect("16 texels");
        names(image.read::<u64>(), "four", "not 8");
    });
}

#[test]
fn images_are_cleared_and_read_row_by_row() {
    gpu_test("images_are_cleared_and_read_row_by_row", |context| {
        let image = Image::new(context, "image", Format::R32_UINT, [5, 3], ImageUse::Storage).expect("15 texels");
        context.submit(|c| c.pass("clear", |pass| pass.clear_image(&image, 0xdead_beef))).expect("submitted");
        assert_eq!(image.read::<u32>().expect("read"), [0xdead_beef; 15]);
        assert_eq!((image.size(), image.bytes()), ([5, 3], 60));
    });
}

/// The first edition assumed four bytes per texel for every unknown format, and allocated a buffer of half the size.
#[test]
fn texels_of_two_floats_have_eight_bytes() {
    gpu_test("texels_of_two_floats_have_eight_bytes", |context| {
        let image = Image::new(context, "moments", Format::R32G32_SFLOAT, [5, 3], ImageUse::Color).expect("15 texels");
        context.submit(|c| c.pass("clear", |pass| pass.clear_volume(&image, 0.25))).expect("submitted");
        assert_eq!(image.bytes(), 15 * 8);
        assert_eq!(image.read::<[f32; 2]>().expect("read"), [[0.25; 2]; 15]);
        names(image.read::<f32>(), "moments", "8 bytes, not 4");
    });
}

/// A format with unknown texel size could not be read back, so it is refused. (Most devices do not support such images, and the layer would
/// report it.)
#[test]
fn images_of_other_formats_are_refused() {
    gpu_test("images_of_other_formats_are_refused", |context| {
        for usage in [ImageUse::Color, ImageUse::Storage] {
            let image = Image::new(context, "odd", Format::R8G8B8_UNORM, [4, 4], usage);
            names(image, "odd", "R8G8B8_UNORM");
        }
        // The format is checked before the size, and both before anything else.
        names(Image::volume(context, "odd", Format::R8G8B8_UNORM, [0, 4, 4], true), "odd", "R8G8B8_UNORM");
    });
}

push_struct! {
    /// Push constants of glsl/maps/order/keys.comp, with the same name as there.
    struct KeysPush { count: u32, capacity: u32 }
}

push_struct! {
    /// Push constants of the same size, but with another type.
    struct Misread { count: u32, capacity: f32 }
}

push_struct! {
    /// Push constants with more members than the shader reads.
    struct TooMuch { count: u32, capacity: u32, more: u32 }
}

/// A kernel is created only if the Rust push constants match the shader's; the error shows both.
#[test]
fn the_wrong_push_constants_are_refused() {
    gpu_test("the_wrong_push_constants_are_refused", |context| {
        fn make<P: gobo::gpu::Push>(context: &gobo::gpu::Context) -> gobo::Result<Kernel<P>> {
            Kernel::compute(context, &shaders::order::KEYS, &[], &Constants::new())
        }
        let reads = "`KeysPush { uint count; uint capacity; }`";
        let refused = [
            make::<Misread>(context).map(|_| ()),
            make::<TooMuch>(context).map(|_| ()),
            make::<()>(context).map(|_| ()),
        ];
        let has =
            ["`Misread { uint count; float capacity; }`", "`TooMuch { uint count; uint capacity; uint more; }`", "``"];
        for (result, has) in refused.into_iter().zip(has) {
            names(result, "maps/order/keys.comp", &format!("{reads}, and Rust has {has}"));
        }
        assert_eq!(<KeysPush as gobo::gpu::Push>::block(), shaders::order::KEYS.push);
    });
}

/// Workgroups of fixed size have at most the 128 threads that every device supports; the others are specialized to the device's limit.
#[test]
fn workgroups_fit_every_device() {
    const EXECUTION_MODE: u32 = 16;
    const LOCAL_SIZE: u32 = 17;
    let mut seen = 0;
    for shader in shaders::ALL {
        let mut rest = &shader.words()[5..];
        while let [first, ..] = rest {
            let (instruction, next) = rest.split_at((first >> 16) as usize);
            if let [_, _, LOCAL_SIZE, size @ ..] = instruction
                && first & 0xffff == EXECUTION_MODE
            {
                assert!(size.iter().product::<u32>() <= 128, "{}: {size:?} threads", shader.name);
                seen += 1;
            }
            rest = next;
        }
    }
    assert!(seen > 15, "{seen} compute shaders");
}

#[test]
fn passes_are_timed_in_order() {
    gpu_test("passes_are_timed_in_order", |context| {
        let buffer = Buffer::new(context, "filled", 1 << 22, Memory::Device).expect("4 MiB");
        let times = context
            .submit(|commands| {
                for i in 0..20 {
                    commands.pass(&format!("fill.{i}"), |pass| pass.fill(&buffer, i));
                }
            })
            .expect("submitted");
        if context.features().timestamp_valid_bits == 0 {
            assert!(times.is_empty());
            return;
        }
        let labels: Vec<_> = (0..20).map(|i| format!("fill.{i}")).collect();
        assert_eq!(times.iter().map(|t| t.name.clone()).collect::<Vec<_>>(), labels);
        assert_eq!(times[0].start_ns, 0.0, "the first pass starts the clock");
        assert!(times.iter().all(|t| t.start_ns <= t.end_ns), "{times:?}");
        assert!(times.windows(2).all(|t| t[0].end_ns <= t[1].start_ns), "{times:?}");
        // 80 MiB were written: a clock that stands still is no clock.
        assert!(times[19].end_ns > times[0].start_ns, "{times:?}");
        assert!(context.submit(|_| {}).expect("an empty submission").is_empty());
    });
}

#[test]
fn more_passes_than_can_be_timed_are_an_error() {
    gpu_test("more_passes_than_can_be_timed_are_an_error", |context| {
        let buffer = Buffer::new(context, "filled", 4, Memory::Device).expect("4 bytes");
        let run = |count: u32| {
            context.submit(|commands| {
                (0..count).for_each(|i| commands.pass("fill", |pass| pass.fill(&buffer, i)));
            })
        };
        assert!(run(512).is_ok());
        names(run(513), "a submission", "513 passes");
        assert!(run(1).is_ok(), "the context is still good");
    });
}

/// An unknown device is the user's mistake, and the message lists the available ones.
#[test]
fn unknown_devices_are_refused() {
    for wanted in ["no such device", "99"] {
        let options = gobo::gpu::Options { device: Some(wanted.into()), ..Default::default() };
        let Err(error) = gobo::gpu::Context::new(&options) else { panic!("{wanted} must be refused") };
        let text = error.to_string();
        assert!(matches!(error, Error::Input { .. }) && text.contains(wanted) && !text.contains('\n'), "{text}");
        let first = &gobo::gpu::devices().expect("devices")[0].name;
        assert!(text.contains(first.as_str()), "{text} does not list {first}");
    }
}

/// Code that records may create an image, write a buffer and read one; these run before the recorded commands. A set that is already bound
/// keeps its buffer; after a change, newly bound sets have the other one. Nothing deadlocks.
#[test]
fn images_are_made_while_recording() {
    gpu_test("images_are_made_while_recording", |context| {
        let buffer = |bytes| Buffer::new(context, "words", bytes, Memory::Device).expect("a few bytes");
        let (words, other) = (buffer(64), buffer(64));
        let (told, heard) = std::sync::mpsc::channel();
        let theirs = (context.clone(), words.clone(), other.clone());
        std::thread::spawn(move || {
            let (context, words, other) = theirs;
            let times = context.try_submit(|commands| {
                commands.pass("before", |pass| pass.fill(&words, 1));
                let image = Image::new(&context, "inner", Format::R32_SFLOAT, [4, 4], ImageUse::Storage)?;
                other.write(&[7_u32; 16])?;
                assert_eq!(other.read::<u32>(16)?, [7; 16]);
                commands.pass("after", |pass| pass.copy(&other, &words, 32));
                drop(image);
                Ok(())
            });
            // These three and their resources are dropped before the device closes.
            drop((context, words, other));
            told.send(times).expect("somebody listens");
        });
        let times = heard.recv_timeout(std::time::Duration::from_secs(60)).expect("it hangs").expect("submitted");
        let names: Vec<_> = times.iter().map(|time| time.name.as_str()).collect();
        assert!(names.is_empty() || names == ["before", "after"], "the others' are their own: {names:?}");
        let mut expected = vec![7_u32; 8];
        expected.extend([1; 8]);
        assert_eq!(words.read::<u32>(16).expect("read"), expected);
    });
}

/// Passes recorded before a set's buffer was replaced write the old one, later passes the new one, even through kernels created before. The
/// old buffer is kept until the passes have run.
#[test]
fn sets_are_changed_while_recording() {
    gpu_test("sets_are_changed_while_recording", |context| {
        let buffer = |value: u32| Buffer::with_data(context, "words", &[value; 64]).expect("a few bytes");
        let (from, [first, second]) = (buffer(7), [0, 0].map(buffer));
        let resources = [&from, &first].map(|buffer| Resource::Buffer(buffer.clone()));
        let set = Bindings::new(context, "copy", &resources).expect("two buffers");
        let kernel: Kernel =
            Kernel::compute(context, &shaders::bench::COPY, &[&set], &Constants::new()).expect("compiled");
        drop(resources);
        let copy = |commands: &mut gobo::gpu::Commands| {
            commands.pass("copy", |pass| pass.dispatch(&kernel, &(), [1, 1, 1]));
        };
        let run = context.try_submit(|commands| {
            copy(commands);
            set.replace(1, &second)?;
            commands.pass("clear", |pass| pass.fill(&from, 9));
            copy(commands);
            set.replace(0, &Buffer::with_data(context, "other", &[5u32; 64])?)?;
            Ok(())
        });
        run.expect("submitted");
        assert_eq!(first.read::<u32>(64).expect("read"), [7; 64]);
        assert_eq!(second.read::<u32>(64).expect("read"), [9; 64]);
        context.submit(copy).expect("submitted");
        assert_eq!(second.read::<u32>(64).expect("read"), [5; 64]);
    });
}

/// Writes reach the device with the next recorded commands, in order, even if the first attempt to record fails or the written buffer has
/// been dropped.
#[test]
fn writes_come_in_order() {
    gpu_test("writes_come_in_order", |context| {
        let buffer = Buffer::with_data(context, "words", &[1u32; 16]).expect("64 bytes");
        buffer.write(&[2u32; 8]).expect("it fits");
        buffer.write(&[3u32; 4]).expect("it fits");
        drop(Buffer::with_data(context, "dropped", &[4u32; 16]).expect("64 bytes"));
        let fails = |_: &mut gobo::gpu::Commands| Err(gobo::Error::Refused("nothing".into()));
        assert!(context.try_submit(fails).is_err());
        let expected = [3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1];
        assert_eq!(buffer.read::<u32>(16).expect("read"), expected);
        let zeroed = Buffer::zeroed(context, "zeroed", 64).expect("64 bytes");
        zeroed.write(&[6u32]).expect("it fits");
        assert_eq!(zeroed.read::<u32>(3).expect("read"), [6, 0, 0]);
    });
}

/// A read-back belongs to one frame: another frame's copy is not returned for it, and a forgotten one is not read.
#[test]
fn read_backs_are_of_a_frame() {
    gpu_test("read_backs_are_of_a_frame", |context| {
        let buffer = Buffer::new(context, "words", 64, Memory::Device).expect("64 bytes");
        let copy = ReadBack::new(context, "copy", 64).expect("64 bytes");
        assert_eq!(copy.bytes(), 64, "each submission is waited for");
        let fill = |value| {
            crate::support::ran(context, |commands| {
                commands.pass("fill", |pass| pass.fill(&buffer, value));
                commands.read_back(&buffer, &copy);
            })
        };
        let (first, nothing) = (fill(1), crate::support::ran(context, |_| ()));
        assert_eq!(copy.read::<u32>(first, 2).expect("read"), Some(vec![1, 1]));
        assert_eq!(copy.read::<u32>(nothing, 2).expect("read"), None);
        let second = fill(2);
        assert_eq!(copy.read::<u32>(first, 2).expect("read"), None);
        assert_eq!(copy.read::<u32>(second, 1).expect("read"), Some(vec![2]));
        assert!(copy.read::<u32>(second, 17).is_err());
        copy.forget();
        assert_eq!(copy.read::<u32>(second, 1).expect("read"), None);
    });
}
