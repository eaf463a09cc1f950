//! What cannot be used is refused in words that name the file, the place and the reason.

use crate::support::{load, load_with, png};
use conray_scene::{Fault, Limits, load_bytes};
use std::path::Path;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The message of a file that must be refused.
pub(crate) fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    load(name, bytes).expect_err("it must be refused").to_string()
}

fn assert_all(name: &str, cases: &[(String, &str)]) {
    for (text, expected) in cases {
        assert_eq!(refusal(name, text), format!("{name}: {expected}"), "{text}");
    }
}

#[test]
fn files_that_are_not_there_or_not_files() {
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &Path| conray_scene::load(path, &Limits::default()).unwrap_err();
    let missing = folder.path().join("gone.obj");
    let error = message(&missing);
    assert_eq!(error.to_string(), format!("{}: there is no such file", missing.display()));
    assert!(matches!(error.fault, Fault::NotFound) && error.path == missing);
    let error = message(folder.path());
    assert!(matches!(error.fault, Fault::CannotRead(_)));
    assert!(error.to_string().ends_with("it cannot be read: it is a folder"), "{error}");
    #[cfg(unix)]
    assert!(message(Path::new("/dev/zero")).to_string().ends_with("it is not a regular file"));
}

#[test]
fn formats_that_nobody_knows() {
    assert_eq!(refusal("a.fbx", "Kaydara"), "a.fbx: unknown format; OBJ, glTF, GLB, PLY and STL are known");
}

#[test]
fn obj_faults_name_their_line() {
    let cases = [
        (
            format!("{SQUARE}f 1 2 3\n\nf 1 2 99"),
            "line 7: vertex index 99 is out of range (there are 4 vertices)",
        ),
        (format!("{SQUARE}f 1 2 -5"), "line 5: vertex index -5 is out of range (4 vertices come before it)"),
        (format!("{SQUARE}f 0 1 2"), "line 5: vertex index 0: they count from 1"),
        (
            format!("{SQUARE}f 1/1 2/1 3/1"),
            "line 5: texture coordinate index 1 is out of range (there are 0 texture coordinates)",
        ),
        (
            format!("{SQUARE}vn 0 0 1\nf 1//1 2//2 3//1"),
            "line 6: normal index 2 is out of range (there is 1 normal)",
        ),
        (
            format!("{SQUARE}f 1 2 5000000000"),
            "line 5: vertex index 5000000000 is out of range (there are 4 vertices)",
        ),
        (format!("{SQUARE}f 1 2 x"), "line 5: `x` is not a face corner"),
        (format!("{SQUARE}f 1 2 3/1/1/1"), "line 5: `3/1/1/1` is not a face corner"),
        ("v 0 0 0\nv 1 nan 0\n".into(), "line 2: the vertex is not finite"),
        ("v 0 0 1e39\n".into(), "line 1: the vertex is not finite"),
        ("v 0 -inf 0\n".into(), "line 1: the vertex is not finite"),
        ("v 0 0\n".into(), "line 1: `v` needs 3 numbers"),
        ("v 0 0 1.#IND\n".into(), "line 1: `1.#IND` is not a number"),
        ("v 0 \\\n 0 \\\n x\nf".into(), "line 1: `x` is not a number"),
        (SQUARE.into(), "there are no triangles"),
        (format!("{SQUARE}f 1 2\nl 1 2"), "there are no triangles"),
        (String::new(), "there are no triangles"),
    ];
    assert_all("a.obj", &cases);
}

fn ply(count: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{body}"
    )
}

#[test]
fn ply_faults_name_their_line_or_element() {
    let cases = [
        ("plx\n".into(), "line 1: the file does not start with `ply`"),
        ("ply\nformat ascii 1.0\n".into(), "line 2: the file ends within the header"),
        ("ply\nformat odd 1.0\nend_header\n".into(), "line 2: unknown PLY format `odd`"),
        ("ply\nelement vertex 0\nend_header\n".into(), "line 3: the header has no `format`"),
        ("ply\nformat ascii 1.0\nelement vertex -3\n".into(), "line 3: `-3` is not a count"),
        ("ply\nformat ascii 1.0\nproperty float x\n".into(), "line 3: a property before any element"),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n".into(),
            "line 4: unknown PLY type `real`",
        ),
        (
            ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "line 13: vertex index 3 is out of range (there are 3 vertices)",
        ),
        (
            ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "line 13: vertex index -1 is out of range (there are 3 vertices)",
        ),
        (ply("3", "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), "line 11: the vertex is not finite"),
        (ply("3", "0 0 0\n1 a 0\n0 1 0\n3 0 1 2\n"), "line 11: `a` is not a number"),
        (
            ply("99999999999", "0 0 0"),
            "element `vertex`: 99999999999 are declared, which the rest of the file is too short for",
        ),
        (ply("3", "0 0 0\n1 0 0\n0 1 0\n0\n"), "there are no triangles"),
    ];
    assert_all("a.ply", &cases);
    let truncated = ply("3", "0 0 0\n1 0 0\n0 1 0\n3 0 1 ");
    let expected = format!("a.ply: byte {}: the file ends within face 0", truncated.len());
    assert_eq!(refusal("a.ply", &truncated), expected);
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nend_header\n";
    let nan = [header.as_bytes(), &[0, 0, 192, 127, 0, 0, 0, 0, 0, 0, 0, 0]].concat();
    assert_eq!(refusal("a.ply", nan), "a.ply: vertex 0: the vertex is not finite");
    let no_x = header.replace("float x", "float w") + "123456789012";
    assert_eq!(refusal("a.ply", no_x), "a.ply: element `vertex`: it has no x, y and z");
}

#[test]
fn stl_faults_name_their_line_or_byte() {
    let cases = [
        (
            "solid a\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\n".into(),
            "line 5: a facet needs 3 vertices, this one has 2",
        ),
        ("solid a\nfacet\nvertex 0 0 zero\n".into(), "line 3: `zero` is not a number"),
        ("solid a\nfacet\nvertex 0 0 inf\n".into(), "line 3: the vertex is not finite"),
        ("solid a\nfacet\nvertex 0 0 0\n".into(), "line 3: the file ends within a facet"),
        ("solid a\nvertex 0 0 0\n".into(), "line 2: `vertex` outside a facet"),
        ("solid a\nfacet\nfacet\n".into(), "line 3: `facet` within a facet"),
        ("solid a\nfascet\n".into(), "line 2: `fascet` is not a word of STL"),
        ("solid a\nendsolid a\n".into(), "there are no triangles"),
        ("short".into(), "byte 5: the file ends within the header of 84 bytes"),
    ];
    assert_all("a.stl", &cases);
    let mut bytes = crate::stl::binary(b"");
    bytes.truncate(84 + 50 + 49);
    assert_eq!(refusal("a.stl", &bytes), "a.stl: byte 183: the file ends within triangle 2 of 4");
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let message = refusal("a.stl", &bytes);
    assert!(
        message.starts_with("a.stl: too many triangles: 4294967295 are more than the limit of"),
        "{message}"
    );
    let mut bytes = crate::stl::binary(b"");
    bytes[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(refusal("a.stl", &bytes), "a.stl: triangle 1: a corner is not finite");
}

fn masked_obj(
    image_name: &str,
    image: &[u8],
    limits: &Limits,
) -> Result<conray_scene::Scene, conray_scene::SceneError> {
    let mtl = format!("newmtl a\nmap_d {image_name}");
    let resolve = |name: &str| Ok(if name == "a.mtl" { mtl.clone().into_bytes() } else { image.to_vec() });
    let text = format!("mtllib a.mtl\nusemtl a\n{SQUARE}f 1 2 3\n");
    load_bytes("a.obj", text.as_bytes(), None, &resolve, limits)
}

#[test]
fn images_that_cannot_be_decoded_or_are_too_big() {
    let good = png(64, 64, image::ExtendedColorType::L8, &[7; 64 * 64]);
    assert!(masked_obj("m.png", &good, &Limits::default()).is_ok());
    let error = masked_obj("m.png", &good[..good.len() / 2], &Limits::default()).unwrap_err().to_string();
    assert!(error.starts_with("a.obj: image `m.png`: cannot be decoded: "), "{error}");
    let error = masked_obj("m.png", b"no image", &Limits::default()).unwrap_err().to_string();
    assert!(error.starts_with("a.obj: image `m.png`: cannot be decoded: "), "{error}");
    let small = Limits { max_texture_pixels: 64 * 64 - 1, ..Limits::default() };
    let error = masked_obj("m.png", &good, &small).unwrap_err();
    assert_eq!(error.to_string(), "a.obj: too many texture pixels: 4096 are more than the limit of 4095");
    // A bomb: the same image that declares 60 000 x 60 000 pixels.
    let mut bomb = good.clone();
    bomb[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    bomb[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let error = masked_obj("m.png", &bomb, &Limits::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.obj: too many texture pixels: 3600000000 are more than the limit of 268435456"
    );
    let wide = Limits { max_texture_pixels: u64::MAX, ..Limits::default() };
    let error = masked_obj("m.png", &bomb, &wide).unwrap_err().to_string();
    assert_eq!(error, "a.obj: image `m.png`: it has too little data for its 60000 x 60000 pixels");
}

/// The checksum of PNG chunks (ISO 3309), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn limits_are_named_with_what_was_found() {
    let text = format!("{SQUARE}f 1 2 3 4\n");
    let with = |limits: Limits| {
        load_bytes("a.obj", text.as_bytes(), None, &|_| unreachable!(), &limits)
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    let limits = Limits::default();
    assert_eq!(with(limits.clone()), Ok(()));
    let cases = [
        (
            Limits { max_triangles: 1, ..limits.clone() },
            "a.obj: too many triangles: 2 are more than the limit of 1",
        ),
        (
            Limits { max_vertices: 3, ..limits.clone() },
            "a.obj: too many vertices: 4 are more than the limit of 3",
        ),
        (
            Limits { max_file_bytes: 41, ..limits.clone() },
            "a.obj: too many bytes in the file: 42 are more than the limit of 41",
        ),
    ];
    for (limits, expected) in cases {
        assert_eq!(with(limits), Err(expected.into()));
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.obj");
    std::fs::write(&file, &text).unwrap();
    let error = conray_scene::load(&file, &Limits { max_file_bytes: 41, ..limits }).unwrap_err();
    assert!(matches!(error.fault, Fault::LimitExceeded { found: 42, limit: 41, .. }));
}

#[test]
fn messages_show_no_more_of_a_file_than_they_must() {
    let long = format!("v 0 0 {}\n", "x\u{1b}".repeat(5000));
    let message = refusal("a.obj", long);
    assert!(message.len() < 250 && !message.contains('\u{1b}'), "{message}");
    let none = load_with("a.obj", format!("mtllib {}\n{SQUARE}f 1 2 3", "y".repeat(9999)), &[]).unwrap();
    assert!(none.warnings[0].example.len() < 100);
}
