//! MTL files and the opacity that comes out of them.

use crate::support::{count, load_with, png, png_with_alpha};
use conray_core::{Opacity, Vec2, Wrap};
use conray_scene::{Limits, Scene, WarningKind, load};
use image::ExtendedColorType::{L8, Rgb8, Rgba8};
use std::fs;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

/// A triangle with one material of these statements, beside these files.
fn with_material(statements: &str, others: &[(&str, &[u8])]) -> Scene {
    let mtl = format!("newmtl leaf\n{statements}\n");
    let mut files: Vec<(&str, &[u8])> = vec![("a.mtl", mtl.as_bytes())];
    files.extend_from_slice(others);
    load_with("a.obj", format!("mtllib a.mtl\nusemtl leaf\n{TRIANGLE}"), &files).unwrap()
}

fn opacity(scene: &Scene) -> &Opacity {
    assert_eq!(scene.geometry.materials().len(), 1);
    &scene.geometry.materials()[0].opacity
}

fn at(scene: &Scene, u: f32, v: f32) -> f32 {
    match opacity(scene) {
        Opacity::Constant(_) => panic!("a texture was expected"),
        Opacity::Texture(texture) => texture.at(Vec2::new(u, v)),
    }
}

fn constant(scene: &Scene) -> f32 {
    match opacity(scene) {
        Opacity::Constant(opacity) => *opacity,
        Opacity::Texture(_) => panic!("a constant was expected"),
    }
}

#[test]
fn v_points_up_so_the_top_of_the_picture_is_at_one() {
    let scene = with_material("map_d m.png", &[("m.png", &png(1, 2, L8, &[255, 51]))]);
    assert_eq!((at(&scene, 0.5, 0.75), at(&scene, 0.5, 0.25)), (1.0, 0.2));
    assert_eq!(at(&scene, 0.5, -3.25), 1.0, "it repeats");
}

#[test]
fn a_mask_is_its_alpha_where_that_says_anything_and_else_its_red() {
    let alpha = with_material("map_d m.png", &[("m.png", &png(1, 1, Rgba8, &[255, 255, 255, 51]))]);
    assert_eq!(constant(&alpha), 0.2);
    let opaque_alpha = with_material("map_d m.png", &[("m.png", &png(1, 1, Rgba8, &[102, 0, 0, 255]))]);
    assert_eq!(constant(&opaque_alpha), 0.4);
    let red = with_material("map_d m.png", &[("m.png", &png(1, 1, Rgb8, &[102, 255, 0]))]);
    assert_eq!(constant(&red), 0.4);
    let green = with_material("map_d -imfchan g m.png", &[("m.png", &png(1, 1, Rgb8, &[102, 153, 0]))]);
    assert_eq!(constant(&green), 0.6);
}

#[test]
fn sixteen_bit_and_tga_masks_are_read() {
    let image = image::DynamicImage::ImageLuma16(image::ImageBuffer::from_raw(1, 1, vec![13107u16]).unwrap());
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    assert_eq!(constant(&with_material("map_d m.png", &[("m.png", bytes.get_ref())])), 0.2);
    // TGA: uncompressed, 1 x 1, 32 bits, 8 of them alpha, top left origin.
    let tga = [0u8, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 32, 0x28, 255, 255, 255, 51];
    assert_eq!(constant(&with_material("map_d m.tga", &[("m.tga", &tga)])), 0.2);
}

#[test]
fn the_colour_map_counts_only_by_alpha_and_without_a_mask() {
    let colour = png_with_alpha();
    let scene = with_material("map_Kd c.png", &[("c.png", &colour)]);
    assert_eq!((at(&scene, 0.5, 0.75), at(&scene, 0.5, 0.25)), (1.0, 0.2));
    let masked =
        with_material("map_Kd c.png\nmap_d m.png", &[("c.png", &colour), ("m.png", &png(1, 1, L8, &[102]))]);
    assert_eq!(constant(&masked), 0.4);
    let plain = with_material("map_Kd c.png", &[("c.png", &png(1, 1, Rgb8, &[0, 0, 0]))]);
    assert_eq!(constant(&plain), 1.0);
    let white = with_material("map_Kd c.png", &[("c.png", &png(1, 1, Rgba8, &[0, 0, 0, 255]))]);
    assert_eq!(constant(&white), 1.0);
}

#[test]
fn an_alpha_channel_that_nobody_filled_is_not_believed() {
    let scene = with_material("map_Kd c.png", &[("c.png", &png(1, 1, Rgba8, &[9, 9, 9, 0]))]);
    assert_eq!(constant(&scene), 1.0);
    assert_eq!(count(&scene, WarningKind::IgnoredFeature), 1);
    let mask = with_material("map_d c.png", &[("c.png", &png(1, 1, L8, &[0]))]);
    assert_eq!(constant(&mask), 0.0, "a mask is believed");
}

#[test]
fn opacity_is_the_product_of_d_and_mask() {
    let scene = with_material("d 0.5\nmap_d m.png", &[("m.png", &png(1, 2, L8, &[255, 51]))]);
    assert_eq!((at(&scene, 0.5, 0.75), at(&scene, 0.5, 0.25)), (0.5, 0.1));
    assert_eq!(constant(&with_material("Tr 0.75", &[])), 0.25);
}

#[test]
fn options_scale_shift_and_clamp() {
    let mask = png(2, 2, L8, &[255, 51, 102, 153]);
    let scene = with_material("map_d -clamp on -s 2 2 1 -o 0 -1 my mask.png", &[("my mask.png", &mask)]);
    // u scales by two; v = 2 v - 1: the square's lower half is clamped to the picture's lowest row.
    assert_eq!(at(&scene, 0.125, 0.875), 1.0);
    assert_eq!((at(&scene, 0.125, 0.1), at(&scene, 0.9, 0.1)), (0.4, 0.6));
    let Opacity::Texture(texture) = opacity(&scene) else { panic!() };
    assert_eq!(texture.wrap, [Wrap::Clamp; 2]);
    let gained = with_material("map_d -mm 0.2 0.5 m.png", &[("m.png", &png(1, 1, L8, &[102]))]);
    assert_eq!(constant(&gained), 0.4);
}

#[test]
fn what_is_missing_is_opaque_and_warned_about() {
    let no_file =
        load_with("a.obj", format!("mtllib gone.mtl\nusemtl x\n{TRIANGLE}usemtl y\n{TRIANGLE}"), &[])
            .unwrap();
    assert_eq!(count(&no_file, WarningKind::MissingMaterialFile), 1);
    assert_eq!(count(&no_file, WarningKind::MissingMaterial), 2);
    assert!(no_file.geometry.materials().iter().all(|m| m.opacity.is_opaque()));
    let no_texture = with_material("map_d gone.png", &[]);
    assert_eq!((constant(&no_texture), count(&no_texture, WarningKind::MissingTexture)), (1.0, 1));
    let unknown_kind = with_material("map_d m.dds", &[("m.dds", b"DDS |\0\0\0")]);
    assert_eq!((constant(&unknown_kind), count(&unknown_kind, WarningKind::MissingTexture)), (1.0, 1));
    assert!(unknown_kind.warnings[0].example.contains("DDS"));
    assert!(with_material("Kd 1 1 1", &[]).warnings.is_empty());
}

#[test]
fn one_statement_may_name_several_material_files_or_one_with_spaces() {
    let text = format!("mtllib a.mtl b c.mtl\nusemtl y\n{TRIANGLE}");
    let apart: [(&str, &[u8]); 2] = [("a.mtl", b"newmtl x"), ("c.mtl", b"newmtl y\nd 0.5")];
    let scene = load_with("a.obj", &text, &apart).unwrap();
    assert_eq!((constant(&scene), count(&scene, WarningKind::MissingMaterialFile)), (0.5, 1));
    let whole: [(&str, &[u8]); 1] = [("a.mtl b c.mtl", b"newmtl y\nd 0.25")];
    assert_eq!(constant(&load_with("a.obj", &text, &whole).unwrap()), 0.25);
    let quoted = format!("mtllib \"my file.mtl\"\nusemtl y\n{TRIANGLE}");
    let one: [(&str, &[u8]); 1] = [("my file.mtl", b"newmtl y\nd 0.75")];
    assert_eq!(constant(&load_with("a.obj", quoted, &one).unwrap()), 0.75);
}

#[test]
fn names_from_another_computer_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let scene_folder = folder.path().join("models");
    fs::create_dir_all(scene_folder.join("Textures")).unwrap();
    fs::write(scene_folder.join("Textures/Leaf Mask.PNG"), png(1, 1, L8, &[51])).unwrap();
    fs::write(scene_folder.join("beside.png"), png(1, 1, L8, &[102])).unwrap();
    fs::write(folder.path().join("above.png"), png(1, 1, L8, &[153])).unwrap();
    let written = [
        ("Textures/Leaf Mask.PNG", 0.2),
        ("textures\\leaf mask.png", 0.2),
        ("./TEXTURES//LEAF MASK.png", 0.2),
        ("C:\\work\\maps\\Beside.png", 0.4),
        ("/home/somebody/beside.png", 0.4),
        ("maps/beside.png", 0.4),
        ("../above.png", 0.6),
    ];
    for (name, expected) in written {
        fs::write(scene_folder.join("a.mtl"), format!("newmtl leaf\nmap_d {name}")).unwrap();
        let obj = scene_folder.join("a.obj");
        fs::write(&obj, format!("mtllib A.MTL\nusemtl leaf\n{TRIANGLE}")).unwrap();
        let scene = load(&obj, &Limits::default()).unwrap();
        assert_eq!(constant(&scene), expected, "{name}: {:?}", scene.warnings);
    }
    fs::write(scene_folder.join("a.mtl"), "newmtl leaf\nmap_d /above.png").unwrap();
    let outside = load(&scene_folder.join("a.obj"), &Limits::default()).unwrap();
    assert_eq!(
        count(&outside, WarningKind::MissingTexture),
        1,
        "an absolute name is looked for beside the scene only"
    );
}
