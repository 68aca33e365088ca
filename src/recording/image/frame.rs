//! A picture file as a camera frame: whatever is wrong with it is an error, and its size is bounded before it is decoded.

use super::Image;
use crate::storage;
use ::image::{ImageDecoder, ImageError, ImageReader, Limits};
use std::{fs, io::Cursor, path::Path};

/// Largest picture file; photographs are a tenth of it.
const LARGEST_FILE: u64 = 256 << 20;
const EXPECTED: &str = "expected a PNG or JPEG picture";

/// The picture in a file, or in a few words what is wrong with it.
pub(in crate::recording) fn read(path: &Path) -> Result<Image, String> {
    // Looked at before it is opened: a pipe or a device would be read for ever.
    let about =
        fs::metadata(path).map_err(|fault| format!("cannot be read: {fault}; {EXPECTED}"))?;
    if !about.is_file() {
        return Err(format!("is no ordinary file; {EXPECTED}"));
    }
    if about.len() > LARGEST_FILE {
        let megabytes = about.len() >> 20;
        return Err(format!(
            "has {megabytes} MB; expected a picture of up to {} MB",
            LARGEST_FILE >> 20
        ));
    }
    let file = fs::read(path).map_err(|fault| format!("cannot be read: {fault}; {EXPECTED}"))?;
    decoded(&file)
}

/// The picture that a file's content shows.
pub(in crate::recording) fn decoded(file: &[u8]) -> Result<Image, String> {
    if file.is_empty() {
        return Err(format!("is empty; {EXPECTED}"));
    }
    let broken = |fault: ImageError| {
        let fault = fault.to_string().replace('\n', " ");
        format!("is a broken picture: {fault}; {EXPECTED}")
    };
    let mut reader = ImageReader::new(Cursor::new(file))
        .with_guessed_format()
        .map_err(|fault| format!("cannot be read: {fault}; {EXPECTED}"))?;
    if reader.format().is_none() {
        return Err(format!("is not a picture; {EXPECTED}"));
    }
    let most = storage::largest_content(file.len());
    let mut limits = Limits::default();
    limits.max_alloc = Some(most);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(broken)?;
    let (columns, rows) = decoder.dimensions();
    // Checked here too, since not every decoder keeps to the limit: three bytes a pixel is what we keep of it.
    let wanted = decoder
        .total_bytes()
        .max(3 * u64::from(columns) * u64::from(rows));
    if columns == 0 || rows == 0 || wanted > most {
        return Err(format!(
            "declares {columns} × {rows} pixels in {} bytes; expected at least one, and no more than such a file can hold",
            file.len()
        ));
    }
    let picture = ::image::DynamicImage::from_decoder(decoder).map_err(broken)?;
    let rgb = picture.into_rgb8().into_raw();
    Image::new(rows as usize, columns as usize, rgb).map_err(|fault| fault.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png() -> Vec<u8> {
        Image::new(12, 16, (0..12 * 16 * 3).map(|v| v as u8).collect())
            .and_then(|image| image.to_png())
            .unwrap()
    }

    /// The same file with another width and height in its header; the checksum is made to fit.
    fn declaring(columns: u32, rows: u32) -> Vec<u8> {
        let mut file = png();
        file[16..20].copy_from_slice(&columns.to_be_bytes());
        file[20..24].copy_from_slice(&rows.to_be_bytes());
        let mut sum = flate2::Crc::new();
        sum.update(&file[12..29]);
        file[29..33].copy_from_slice(&sum.sum().to_be_bytes());
        file
    }

    #[test]
    fn what_is_no_picture_is_told_in_one_line() {
        let file = png();
        for (file, part) in [
            (Vec::new(), "is empty"),
            (b"1,2,3\n4,5,6\n".to_vec(), "is not a picture"),
            (file[..file.len() / 2].to_vec(), "broken picture"),
            (file[..20].to_vec(), "broken picture"),
            (b"\xff\xd8\xff\xe0 and no more".to_vec(), "broken picture"),
            (declaring(0, 12), "expected"),
            (declaring(60_000, 60_000), "declares 60000 × 60000"),
            (declaring(u32::MAX, u32::MAX), "expected"),
        ] {
            let message = decoded(&file).unwrap_err();
            assert!(
                message.contains(part) && !message.contains('\n'),
                "{part}: {message}"
            );
            assert!(message.contains("expected"), "{message}");
        }
    }

    #[test]
    fn grey_and_transparent_and_jpeg_pictures_are_read() {
        let grey = ::image::GrayImage::from_pixel(30, 20, ::image::Luma([99]));
        let clear = ::image::RgbaImage::from_pixel(30, 20, ::image::Rgba([99, 99, 99, 7]));
        for (picture, format) in [
            (
                ::image::DynamicImage::from(grey.clone()),
                ::image::ImageFormat::Png,
            ),
            (
                ::image::DynamicImage::from(clear),
                ::image::ImageFormat::Png,
            ),
            (
                ::image::DynamicImage::from(grey),
                ::image::ImageFormat::Jpeg,
            ),
        ] {
            let mut file = Cursor::new(Vec::new());
            picture.write_to(&mut file, format).unwrap();
            let image = decoded(file.get_ref()).unwrap();
            assert_eq!((image.rows(), image.columns()), (20, 30));
            assert!(image.values().iter().all(|v| v.abs_diff(99) <= 2));
        }
    }
}
