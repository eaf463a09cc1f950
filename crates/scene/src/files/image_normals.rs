//! Normal maps out of image files.

use super::error::Fault;
use super::image_file::ImageFile;
use super::intake::Intake;
use conray_core::NormalTexture;
use image::DynamicImage;

/// Reads an image of normals; the inner error names a kind of image that is not read.
pub(super) fn read_normals(
    name: &str,
    bytes: &[u8],
    intake: &mut Intake,
) -> Result<Result<NormalTexture, &'static str>, Fault> {
    let file = match ImageFile::open(name, bytes, intake.pixels_left, intake.limits)? {
        Ok(file) => file,
        Err(unknown) => return Ok(Err(unknown)),
    };
    let (pixels, image) = (file.pixels(), file.decode()?);
    let Some(texture) = texture(&image) else {
        return Err(Fault::element(format!("image `{name}`"), "it has no pixels"));
    };
    intake.pixels_left -= pixels;
    Ok(Ok(texture))
}

fn texture(image: &DynamicImage) -> Option<NormalTexture> {
    let texels = image.to_rgb8().pixels().map(|pixel| pixel.0).collect();
    NormalTexture::new(image.width(), image.height(), texels)
}

/// True where an image can be one of heights: it has no colours.
pub(super) fn is_grey(texture: &NormalTexture) -> bool {
    texture.texels().iter().all(|[r, g, b]| r == g && g == b)
}
