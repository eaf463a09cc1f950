use super::*;
use proptest::prelude::*;

fn decode(bytes: &[u8]) -> Picture {
    let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    Picture { width: info.width, height: info.height, rgb }
}

fn at(picture: &Picture, index: usize) -> [u8; 3] {
    [0, 1, 2].map(|c| picture.rgb[3 * index + c])
}

/// Every pixel different from its neighbours and told apart by its place.
fn places(width: u32, height: u32) -> Picture {
    let rgb = (0..height).flat_map(|y| (0..width).flat_map(move |x| [x as u8, y as u8, 7])).collect();
    Picture { width, height, rgb }
}

#[test]
fn grey_has_no_transfer_curve_and_shows_what_is_no_number() {
    let picture = Picture::grey(3, 2, &[0.0, 0.5, 1.0, f32::NAN, -3.0, 9.0]);
    let all: Vec<[u8; 3]> = (0..6).map(|i| at(&picture, i)).collect();
    assert_eq!(all, [[0; 3], [128; 3], [255; 3], [255, 0, 255], [0; 3], [255; 3]]);
}

#[test]
fn a_difference_has_a_sign_and_a_full_scale() {
    let picture = Picture::difference(5, 1, &[0.5, 0.7, 0.3, 0.9, f32::NAN], &[0.5; 5], 0.2);
    assert_eq!(at(&picture, 0), [255; 3]);
    assert!(at(&picture, 1)[0] > at(&picture, 1)[2], "too open is red");
    assert!(at(&picture, 2)[2] > at(&picture, 2)[0], "too closed is blue");
    assert_eq!(at(&picture, 1), at(&picture, 3), "beyond full scale nothing gets stronger");
    assert_eq!(at(&picture, 4), NOT_A_NUMBER);
    assert_ne!(at(&picture, 1), at(&Picture::difference(1, 1, &[0.6], &[0.5], 0.2), 0));
}

#[test]
fn a_full_scale_of_zero_still_has_a_sign() {
    let picture = Picture::difference(3, 1, &[0.4, 0.5, 0.6], &[0.5; 3], 0.0);
    let strong = Picture::difference(3, 1, &[0.0, 0.5, 1.0], &[0.5; 3], 0.5);
    assert_eq!(picture, strong);
    assert_eq!(at(&Picture::heat(1, 1, &[0.0], 0.0), 0), at(&Picture::heat(1, 1, &[0.0], 1.0), 0));
}

#[test]
fn a_crop_moves_inside_and_repeats_pixels() {
    let picture = places(10, 8);
    let middle = picture.crop_enlarged([5, 4], 4, 2);
    assert_eq!((middle.width, middle.height), (8, 8));
    assert_eq!((at(&middle, 0), at(&middle, 9), at(&middle, 63)), ([3, 2, 7], [3, 2, 7], [6, 5, 7]));
    let corner = picture.crop_enlarged([9, 0], 4, 1);
    assert_eq!((at(&corner, 0), at(&corner, 15)), ([6, 0, 7], [9, 3, 7]));
    let all = picture.crop_enlarged([1, 1], 100, 1);
    assert_eq!(all, picture);
}

#[test]
fn pictures_stand_side_by_side() {
    let both = Picture::beside(&[places(2, 1), places(1, 2)], 1);
    assert_eq!((both.width, both.height), (4, 2));
    let row = |y: usize| [0, 1, 2, 3].map(|x| at(&both, 4 * y + x));
    assert_eq!(row(0), [[0, 0, 7], [1, 0, 7], [255; 3], [0, 0, 7]]);
    assert_eq!(row(1), [[255; 3], [255; 3], [255; 3], [0, 1, 7]]);
    assert_eq!(Picture::beside(&[], 3).rgb.len(), 0);
}

#[test]
fn a_picture_with_missing_pixels_or_none_is_still_a_file() {
    let torn = Picture { width: 2, height: 1, rgb: vec![1, 2, 3] };
    assert_eq!(decode(&torn.to_png()).rgb, [1, 2, 3, 255, 255, 255]);
    assert_eq!(decode(&Picture::plain(0, 5, [0; 3]).to_png()).rgb, [255; 15]);
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(
        (width, height, rgb) in (1u32..20, 1u32..20).prop_flat_map(|(w, h)| {
            (Just(w), Just(h), prop::collection::vec(any::<u8>(), (3 * w * h) as usize))
        }),
    ) {
        let picture = Picture { width, height, rgb };
        prop_assert_eq!(decode(&picture.to_png()), picture);
    }

    #[test]
    fn crops_hold_their_centre(
        width in 1u32..30, height in 1u32..30, x in 0u32..30, y in 0u32..30, side in 1u32..40, factor in 1u32..4,
    ) {
        let (x, y) = (x.min(width - 1), y.min(height - 1));
        let picture = places(width, height);
        let crop = picture.crop_enlarged([x, y], side, factor);
        prop_assert_eq!(crop.width, side.min(width) * factor);
        let pixels: Vec<[u8; 3]> = (0..(crop.width * crop.height) as usize).map(|i| at(&crop, i)).collect();
        let wanted = [x as u8, y as u8, 7];
        prop_assert_eq!(pixels.iter().filter(|p| **p == wanted).count(), (factor * factor) as usize);
    }
}
