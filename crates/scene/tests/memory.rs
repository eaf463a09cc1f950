//! Small files, whatever they claim, take little memory: counted by an allocator that watches every request.

#![allow(unsafe_code, reason = "an allocator can only be written with it")]

use conray_scene::{Format, Limits, load_bytes};
use std::alloc::{GlobalAlloc, Layout, System};
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator with a tally.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged; the tally only counts.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let now = NOW.fetch_add(layout.size(), Relaxed) + layout.size();
        PEAK.fetch_max(now, Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Most bytes in use at a time while a file is loaded under the default limits.
fn peak_of(format: Format, bytes: &[u8]) -> usize {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let scene =
        load_bytes("a", bytes, Some(format), &|_| Err(io::ErrorKind::NotFound.into()), &Limits::default());
    let peak = PEAK.load(Relaxed) - before;
    drop(scene);
    peak
}

/// Replaces the first run of `from`.
fn with(text: &str, from: &str, to: &str) -> Vec<u8> {
    assert!(text.contains(from));
    text.replacen(from, to, 1).into_bytes()
}

/// One test, because the tally is the process's.
#[test]
fn claims_take_no_memory_that_the_file_does_not_back() {
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
    let gltf = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"componentType": 5126, "type": "VEC3", "count": 3}, {"componentType": 5125, "type": "SCALAR", "count": 3}],
        "buffers": [{"byteLength": 0, "uri": "data:,"}]}"#;
    let mut stl = vec![0u8; 84 + 50];
    stl[80..84].copy_from_slice(&300_000_000u32.to_le_bytes());
    let list = [&with(ply, "vertex 3", "vertex 0")[..], &u32::MAX.to_le_bytes()].concat();
    let claims: [(Format, Vec<u8>); 8] = [
        (Format::Ply, with(ply, "vertex 3", "vertex 100000000")),
        (Format::Ply, with(ply, "vertex 3", "vertex 18446744073709551615")),
        (Format::Ply, with(ply, "face 1", "face 4000000000")),
        (Format::Ply, list),
        (Format::Stl, stl),
        (Format::Gltf, with(gltf, "\"count\": 3", "\"count\": 100000000")),
        (
            Format::Gltf,
            with(
                gltf,
                "5125, \"type\": \"SCALAR\", \"count\": 3",
                "5125, \"type\": \"SCALAR\", \"count\": 300000000",
            ),
        ),
        (Format::Gltf, with(gltf, "\"byteLength\": 0", "\"byteLength\": 4000000000")),
    ];
    for (format, bytes) in claims {
        let peak = peak_of(format, &bytes);
        assert!(peak < 256 << 10, "{}: {peak} bytes", String::from_utf8_lossy(&bytes));
    }
    // An honest file shows that the tally counts at all, and what a byte of OBJ may cost.
    let vertices: String = (0..3000).map(|i| format!("v {i} 0 {}\n", i % 7)).collect();
    let polygon: String = (1..=3000).map(|i| format!(" {i}")).collect();
    let honest = format!("{vertices}f{polygon}\n");
    let peak = peak_of(Format::Obj, honest.as_bytes());
    assert!(peak > 3000 * 36 && peak < 64 * honest.len(), "{peak} bytes for {}", honest.len());
}
