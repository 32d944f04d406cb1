#![no_main]
#[path = "../../tests/host/fuzz/bodies/mod.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    bodies::sog(bytes);
});
