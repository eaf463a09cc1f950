//! Any bytes as a glTF file.
#![no_main]

#[path = "../shared.rs"]
mod shared;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let _ = shared::check(conray_scene::Format::Gltf, input);
});
