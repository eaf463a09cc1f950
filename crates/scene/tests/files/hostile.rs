//! Files that chance has damaged: every seed of the fuzz targets, cut and changed in many ways.
//!
//! What a loader may answer is told in `fuzz/shared.rs`, which the fuzz targets use too.

#[path = "../../../../fuzz/shared.rs"]
mod shared;

use conray_core::hash_u32;
use conray_scene::Format;
use proptest::prelude::*;
use shared::check;
use std::fs;
use std::path::PathBuf;

/// The seeds of a target, by name, so that the order is the same everywhere.
fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let mut paths: Vec<PathBuf> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let seeds: Vec<_> = paths
        .iter()
        .map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), fs::read(p).unwrap()))
        .collect();
    assert!(seeds.len() >= 3, "{target} has too few seeds");
    seeds
}

/// Changes a seed in one to four places: bytes turned and, for odd numbers, also removed, doubled, replaced by others
/// of the seed.
fn mutated(seed: &[u8], number: u32) -> Vec<u8> {
    let mut out = seed.to_vec();
    let mut state = hash_u32(number ^ 0x5eed);
    let mut next = |below: usize| {
        state = hash_u32(state.wrapping_add(0x9e37_79b9));
        state as usize % below.max(1)
    };
    for _ in 0..=next(3) {
        let (at, length) = (next(out.len()), next(8) + 1);
        let end = (at + length).min(out.len());
        match next(if number.is_multiple_of(2) { 2 } else { 6 }) {
            0 if at < out.len() => out[at] ^= 1 << next(8),
            1 if at < out.len() => {
                out[at] = [0, 1, 0x7f, 0x80, 0xff, b'9', b'-', b' ', b'\n', b'/'][next(10)]
            }
            2 => drop(out.drain(at..end)),
            3 => {
                let piece = out[at..end].to_vec();
                out.splice(at..at, piece);
            }
            4 => {
                let from = next(seed.len());
                out.splice(at..end, seed[from..(from + length).min(seed.len())].iter().copied());
            }
            _ => out.truncate(at),
        }
    }
    out
}

fn every_seed(target: &str, format: Format) {
    let mut loaded = 0;
    for (name, seed) in seeds(target) {
        let good = check(format, &seed);
        assert_eq!(good.is_ok(), !name.starts_with("bad"), "{target}/{name}: {good:?}");
        for number in 0..400 {
            loaded += u32::from(check(format, &mutated(&seed, number)).is_ok());
        }
    }
    // Mutations that only ever fail at the first byte would try nothing.
    assert!(loaded > 50, "{target}: only {loaded} mutations could still be loaded");
}

#[test]
fn obj_seeds_and_their_mutations() {
    every_seed("obj", Format::Obj);
}

#[test]
fn gltf_seeds_and_their_mutations() {
    every_seed("gltf", Format::Gltf);
}

#[test]
fn ply_seeds_and_their_mutations() {
    every_seed("ply", Format::Ply);
}

#[test]
fn stl_seeds_and_their_mutations() {
    every_seed("stl", Format::Stl);
}

#[test]
fn every_truncation_of_every_seed() {
    let targets = [("obj", Format::Obj), ("gltf", Format::Gltf), ("ply", Format::Ply), ("stl", Format::Stl)];
    for (target, format) in targets {
        for (_, seed) in seeds(target) {
            for length in 0..seed.len().min(1500) {
                let _ = check(format, &seed[..length]);
            }
        }
    }
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), format in 0..4usize) {
        let formats = [(Format::Obj, &b""[..]), (Format::Gltf, b"glTF\x02\0\0\0"), (Format::Ply, b"ply\n"), (Format::Stl, b"solid")];
        let (format, start) = formats[format];
        let _ = check(format, &bytes);
        let _ = check(format, &[start, &bytes].concat());
    }

    #[test]
    fn random_obj_words_never_panic(words in prop::collection::vec(
        prop::sample::select(vec!["v", "vt", "vn", "f", "o", "g", "usemtl", "mtllib", "\n", "\n", "\\\n", "1", "-1", "2/1",
            "3//2", "0.5", "1e30", "nan", "-inf", "l", "#", "a.mtl"]), 0..200))
    {
        let _ = check(Format::Obj, format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", words.join(" ")).as_bytes());
    }
}
