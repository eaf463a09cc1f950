//! What can be checked without the library, and with it.

use super::{look_up::first_fit, *};

#[test]
fn a_library_that_is_not_there_is_told_with_what_to_do() {
    let problem = first_fit(&["no-such-a.so".into(), "no-such-b.so".into()], None).err().unwrap();
    assert!(problem.contains("bench/fetch-rivals") && problem.contains("CONRAY_OIDN"), "{problem}");
    let file = "/no/such/library.so";
    let named = first_fit(&[file.into()], Some(file.as_ref())).err().unwrap();
    assert!(named.contains(file) && !named.contains("looked"), "{named}");
}

#[test]
fn a_file_that_is_no_library_is_refused_by_name() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let problem = first_fit(&[file.into(), "no-such.so".into()], None).err().unwrap();
    assert!(problem.starts_with(&format!("Open Image Denoise cannot be used: {file}: ")), "{problem}");
}

#[cfg(target_os = "linux")]
#[test]
fn another_library_is_refused_by_what_it_lacks() {
    let problem = first_fit(&["libm.so.6".into()], None).err().unwrap();
    assert_eq!(
        problem,
        "Open Image Denoise cannot be used: libm.so.6: lacks oidnNewDevice; version 2 is needed"
    );
}

const SIZE: (usize, usize) = (96, 64);

/// A step from 0.3 to 0.7 with uniform noise of +-0.25; and the step alone.
fn noisy_step() -> (Vec<f32>, Vec<f32>) {
    let points = conray_core::RandomPoints::new(3);
    let step: Vec<f32> = (0..SIZE.0 * SIZE.1).map(|i| if i % SIZE.0 < 48 { 0.3 } else { 0.7 }).collect();
    let noisy = (0..).zip(&step).map(|(i, v)| v + 0.5 * (points.point(i).x - 0.5)).collect();
    (noisy, step)
}

fn normals() -> Vec<f32> {
    (0..SIZE.0 * SIZE.1)
        .flat_map(|i| if i % SIZE.0 < 48 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] })
        .collect()
}

#[test]
#[ignore = "needs Open Image Denoise: bench/fetch-rivals"]
fn noise_goes_and_the_mean_stays() {
    let api = Api::get().unwrap();
    let (noisy, step) = noisy_step();
    let before = crate::quality::rmse(&noisy, &step);
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    for guides in [None, Some(normals())] {
        let denoiser = Denoiser::new(api, SIZE, 2, guides.as_deref()).unwrap();
        let out = denoiser.denoise(&noisy).unwrap();
        let after = crate::quality::rmse(&out, &step);
        assert!(after < 0.3 * before, "guides {}: {after} {before}", guides.is_some());
        // A displayed image would come back with its mean shifted by 0.1 and more.
        assert!((mean(&out) - mean(&noisy)).abs() < 0.02, "{} {}", mean(&out), mean(&noisy));
        // The filter can be used again, and says the same.
        assert_ne!(denoiser.denoise(&step).unwrap(), out);
        assert_eq!(denoiser.denoise(&noisy).unwrap(), out);
    }
}

#[test]
#[ignore = "needs Open Image Denoise: bench/fetch-rivals"]
fn threads_change_no_bit() {
    let (noisy, _) = noisy_step();
    let on =
        |threads| Denoiser::new(Api::get().unwrap(), SIZE, threads, None).unwrap().denoise(&noisy).unwrap();
    assert_eq!(on(1), on(2));
}

#[test]
#[ignore = "needs Open Image Denoise: bench/fetch-rivals"]
fn what_does_not_fit_is_refused() {
    let api = Api::get().unwrap();
    let denoiser = Denoiser::new(api, SIZE, 1, None).unwrap();
    assert!(denoiser.denoise(&[0.5; 3]).unwrap_err().contains("3 pixels"));
    assert!(Denoiser::new(api, SIZE, 1, Some(&[0.0])).err().unwrap().contains("normals"));
}
