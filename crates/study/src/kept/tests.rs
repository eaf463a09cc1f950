//! What goes in comes out, and nothing else does.

use super::*;
use proptest::prelude::*;
use serde_json::json;

fn print_of(value: u32) -> Fingerprint {
    Fingerprint::of(|feed| feed.u32(value))
}

fn sample() -> Kept {
    let arrays = [("a".to_string(), vec![1.0, -0.0, f32::MIN_POSITIVE]), ("empty".to_string(), vec![])];
    Kept { header: json!({ "rays": [16, 32], "name": "cornell" }), arrays: arrays.into() }
}

fn bits(kept: &Kept) -> Vec<(&str, Vec<u32>)> {
    kept.arrays.iter().map(|(name, values)| (&**name, values.iter().map(|v| v.to_bits()).collect())).collect()
}

/// What the message says, after the name of the file.
fn problem(result: Result<Option<Kept>, StudyError>) -> String {
    match result.unwrap_err() {
        StudyError::Kept { path, problem } => {
            assert!(path.ends_with("x.kept"));
            assert!(problem.ends_with("delete it to have it computed anew"), "{problem}");
            problem
        }
        other => panic!("{other}"),
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_back_bit_by_bit(
        number in any::<u64>(),
        text in any::<String>(),
        kind in "[a-z ]{0,12}",
        arrays in prop::collection::btree_map(any::<String>(), prop::collection::vec(any::<u32>(), 0..40), 0..5),
    ) {
        let arrays = arrays.into_iter().map(|(name, v)| (name, v.into_iter().map(f32::from_bits).collect()));
        let kept = Kept { header: json!({ "number": number, "text": text }), arrays: arrays.collect() };
        let read = decode(&encode(&kept, &kind, print_of(1)), &kind, print_of(1)).unwrap();
        prop_assert_eq!(&read.header, &kept.header);
        prop_assert_eq!(bits(&read), bits(&kept));
    }

    #[test]
    fn any_bytes_are_refused_without_harm(bytes in prop::collection::vec(any::<u8>(), 0..200), sealed in any::<bool>()) {
        let mut bytes = bytes;
        if sealed {
            // A right frame around nonsense: lengths far beyond the file, text that is none.
            bytes.splice(0..0, MAGIC.iter().copied().chain(VERSION.to_le_bytes()).chain(print_of(1).to_le_bytes()));
            bytes.extend(XxHash3_128::oneshot(&bytes).to_le_bytes());
        }
        prop_assert!(decode(&bytes, "truth", print_of(1)).is_err());
    }
}

#[test]
fn every_truncation_is_caught() {
    let bytes = encode(&sample(), "truth", print_of(1));
    assert!(decode(&bytes, "truth", print_of(1)).is_ok());
    for length in 0..bytes.len() {
        assert!(decode(&bytes[..length], "truth", print_of(1)).is_err(), "{length} bytes");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(decode(&longer, "truth", print_of(1)).is_err());
}

#[test]
fn every_flipped_bit_is_caught() {
    let mut bytes = encode(&sample(), "truth", print_of(1));
    for bit in 0..8 * bytes.len() {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(decode(&bytes, "truth", print_of(1)).is_err(), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn lengths_beyond_the_file_take_no_memory() {
    // The last length of the sample is that of the empty array; the checksum is made to fit.
    for length in [1, u64::MAX / 4, u64::MAX / 4 + 1, u64::MAX] {
        let mut bytes = encode(&sample(), "truth", print_of(1));
        bytes.truncate(bytes.len() - CHECKSUM_BYTES - 8);
        bytes.extend(length.to_le_bytes());
        bytes.extend(XxHash3_128::oneshot(&bytes).to_le_bytes());
        let error = decode(&bytes, "truth", print_of(1)).unwrap_err();
        assert!(error.contains("cut short"), "{length}: {error}");
    }
}

#[test]
fn files_of_another_kind_origin_or_version_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.kept");
    assert_eq!(Kept::read(&path, "truth", print_of(1)).unwrap(), None);
    sample().write(&path, "truth", print_of(1)).unwrap();
    assert_eq!(Kept::read(&path, "truth", print_of(1)).unwrap(), Some(sample()));

    assert!(problem(Kept::read(&path, "trial", print_of(1))).contains("truth where trial"));
    let other = problem(Kept::read(&path, "truth", print_of(2)));
    assert!(other.contains(&print_of(1).to_string()) && other.contains(&print_of(2).to_string()), "{other}");

    let mut bytes = std::fs::read(&path).unwrap();
    bytes[MAGIC.len()] += 1;
    std::fs::write(&path, &bytes).unwrap();
    assert!(problem(Kept::read(&path, "truth", print_of(1))).contains("version 2"));
    std::fs::write(&path, "PNG and so on").unwrap();
    assert!(problem(Kept::read(&path, "truth", print_of(1))).contains("no file of this program"));
}

#[test]
fn what_cannot_be_read_or_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.kept");
    std::fs::create_dir(&path).unwrap();
    assert!(problem(Kept::read(&path, "truth", print_of(1))).contains("cannot be read"));
    let error = sample().write(&path, "truth", print_of(1)).unwrap_err();
    assert!(matches!(&error, StudyError::Output { path, .. } if path.ends_with("x.kept")), "{error}");
}
