//! Our files read by the `exr` crate, which did not write them, and by ourselves, whole and damaged.

use super::{read::decode, *};
use crate::{Layers, TargetError};
use ::exr::prelude::{AttributeValue, FlatSamples, read_first_flat_layer_from_file};
use conray_core::{ConeEstimate, Estimate, SurfacePoint, Vec3};
use proptest::prelude::*;
use std::{collections::BTreeMap, fs};

/// An image of odd size, more than one block high, with background, pending pixels and cones.
fn layers(width: u32, height: u32) -> Layers {
    let points: Vec<_> = (0..width * height)
        .filter(|i| i % 5 != 4)
        .map(|i| {
            SurfacePoint::new(Vec3::new(i as f32 * 0.1, 1.0 / 3.0, -7.0), Vec3::new(0.6, 0.0, 0.8)).with_id(i)
        })
        .collect();
    let estimate = |p: &SurfacePoint| {
        let v = (p.id as f32 * 0.37).fract();
        let cone = ConeEstimate { visibility: 1.0 - v, error: v * v, alpha: 0.5 };
        Estimate { visibility: v, error: 0.01 * v, rays: p.id, bent: Vec3::Y * v, cone: Some(cone) }
    };
    let estimates: Vec<_> =
        points.iter().map(|p| if p.id % 7 == 3 { Estimate::PENDING } else { estimate(p) }).collect();
    Layers::new(width, height, &points, &estimates)
}

fn settings() -> Vec<(String, String)> {
    [
        ("method", "paper"),
        ("distance", "1.5"),
        ("a key that is too long for a short name", "\u{e9}\nx"),
        ("empty", ""),
    ]
    .map(|(k, v)| (k.into(), v.into()))
    .into()
}

fn bytes_of(layers: &Layers, settings: &[(String, String)]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, layers, settings).unwrap();
    fs::read(&path).unwrap()
}

/// Bits of the channel of the layers that a channel of the file must equal.
fn truth(layers: &Layers, name: &str) -> Vec<u32> {
    let name = if ["R", "G", "B"].contains(&name) { "visibility" } else { name };
    layers.channel(name).unwrap().iter().map(|v| v.to_bits()).collect()
}

const NAMES: [&str; 18] = [
    "A",
    "B",
    "G",
    "R",
    "alpha",
    "bent.X",
    "bent.Y",
    "bent.Z",
    "cone.error",
    "cone.visibility",
    "error",
    "normal.X",
    "normal.Y",
    "normal.Z",
    "position.X",
    "position.Y",
    "position.Z",
    "rays",
];

#[test]
fn another_library_reads_every_bit() {
    for (width, height) in [(37, 53), (1, 1), (3, 16), (5, 17)] {
        let layers = layers(width, height);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_exr(&path, &layers, &settings()).unwrap();
        let image = read_first_flat_layer_from_file(&path).unwrap();
        let layer = &image.layer_data;
        assert_eq!((layer.size.x(), layer.size.y()), (width as usize, height as usize));
        let names: Vec<String> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, NAMES);
        for channel in &layer.channel_data.list {
            let FlatSamples::F32(values) = &channel.sample_data else {
                panic!("{} is not f32", channel.name)
            };
            let bits: Vec<u32> = values.iter().map(|v| v.to_bits()).collect();
            let name = channel.name.to_string();
            assert_eq!(bits, truth(&layers, &name), "{name}");
            // A negative control: other channels are not mistaken for this one.
            if name == "position.X" && width > 1 {
                assert_ne!(bits, truth(&layers, "rays"));
            }
        }
        let found: BTreeMap<String, Vec<u8>> = (image.attributes.other.iter().chain(&layer.attributes.other))
            .map(|(name, value)| match value {
                AttributeValue::Text(text) => (name.to_string(), text.as_slice().to_vec()),
                other => panic!("{name}: {other:?}"),
            })
            .collect();
        let expected: BTreeMap<String, Vec<u8>> =
            settings().into_iter().map(|(k, v)| (format!("conray.{k}"), v.into_bytes())).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn we_read_every_bit() {
    let layers = layers(37, 53);
    let image = decode(&bytes_of(&layers, &settings())).unwrap();
    assert_eq!((image.width, image.height), (37, 53));
    assert_eq!(image.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), NAMES);
    for (name, values) in &image.channels {
        assert_eq!(values.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), truth(&layers, name), "{name}");
    }
    let red = image.channel("R").unwrap();
    assert_eq!(red.iter().filter(|v| v.is_nan()).count(), layers.pending());
    assert!(layers.pending() > 0, "pending pixels must be among those compared");
    let expected: Vec<_> = settings().into_iter().map(|(k, v)| (format!("conray.{k}"), v)).collect();
    assert_eq!(image.attributes, expected, "in the order given");
}

#[test]
fn the_same_layers_give_the_same_bytes_whatever_the_thread_count() {
    let layers = layers(64, 50);
    let write = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bytes_of(&layers, &settings()))
    };
    assert_eq!(write(1), write(4));
    assert_ne!(write(1), bytes_of(&layers, &[]), "settings are part of the file");
}

#[test]
fn the_file_starts_as_the_format_says() {
    let short = bytes_of(&layers(2, 2), &[("seed".into(), "1".into())]);
    // Magic number, version 2, no flags; then the flag for long names where one is needed.
    assert_eq!(short[..8], [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]);
    assert_eq!(bytes_of(&layers(2, 2), &settings())[4..8], [2, 4, 0, 0]);
    let text = b"conray.seed\0string\0\x01\0\0\x001";
    assert!(short.windows(text.len()).any(|w| w == text));
}

#[test]
fn impossible_settings_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let long = "k".repeat(249);
    for (key, value) in
        [("", "x".to_string()), ("a\0b", "x".into()), (&long, "x".into()), ("k", "x".repeat(1 << 21))]
    {
        let error = write_exr(&path, &layers(2, 2), &[(key.into(), value)]).unwrap_err();
        assert!(matches!(error, TargetError::Settings { setting: "header", .. }), "{error}");
    }
    let twice = [("k".to_string(), "1".to_string()), ("k".into(), "2".into())];
    assert!(write_exr(&path, &layers(2, 2), &twice).is_err());
    assert!(!path.exists());
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_taken() {
    let bytes = bytes_of(&layers(4, 4), &[]);
    let window = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = bytes.windows(window.len()).position(|w| w == window).unwrap() + window.len();
    for (corner, reason) in [(0x3fffi32, "than the file can hold"), (i32::MAX, "too large"), (-1, "empty")] {
        let mut bytes = bytes.clone();
        bytes[at + 8..at + 16].copy_from_slice([corner; 2].map(i32::to_le_bytes).as_flattened());
        let problem = decode(&bytes).unwrap_err();
        assert!(problem.contains(reason), "{problem} / {reason}");
    }
}

#[test]
fn other_kinds_of_files_are_refused_by_reason() {
    let bytes = bytes_of(&layers(4, 4), &[]);
    let with = |from: &[u8], to: &[u8]| {
        let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
        [&bytes[..at], to, &bytes[at + from.len()..]].concat()
    };
    let cases = [
        (with(&MAGIC, b"RIFF"), "not an EXR file"),
        (with(&[2, 0, 0, 0, b'c'], &[2, 2, 0, 0, b'c']), "tiled"),
        (
            with(b"compression\0compression\0\x01\0\0\0\x03", b"compression\0compression\0\x01\0\0\0\x04"),
            "compression 4",
        ),
        (with(b"A\0\x02", b"A\0\x01"), "channel A does not hold 32-bit floats"),
        (with(b"dataWindow", b"dataWindot"), "no data window"),
    ];
    for (bytes, reason) in cases {
        let problem = decode(&bytes).unwrap_err();
        assert!(problem.contains(reason), "{problem} / {reason}");
    }
    let error = read_exr_channels("/absent/a.exr").unwrap_err();
    assert!(error.to_string().contains("/absent/a.exr"));
}

proptest! {
    #[test]
    fn truncated_files_are_refused(share in 0.0f64..1.0) {
        let whole = bytes_of(&layers(9, 20), &settings());
        let cut = (share * whole.len() as f64) as usize;
        prop_assert!(decode(&whole[..cut]).is_err());
    }

    #[test]
    fn damaged_files_never_panic(flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5)) {
        let mut bytes = bytes_of(&layers(9, 20), &settings());
        for (at, x) in flips {
            *at.get_mut(&mut bytes) ^= x;
        }
        if let Ok(image) = decode(&bytes) {
            let pixels = image.width as usize * image.height as usize;
            prop_assert!(image.channels.iter().all(|(_, values)| values.len() == pixels));
        }
    }

    #[test]
    fn bytes_of_any_kind_never_panic(tail in prop::collection::vec(any::<u8>(), 0..200)) {
        let bytes = [&MAGIC[..], &VERSION.to_le_bytes(), &tail].concat();
        prop_assert!(decode(&bytes).is_err());
    }
}
