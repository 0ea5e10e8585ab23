//! Images as inputs: depths, colours, transparency, sizes.

use image::{DynamicImage, ImageFormat};
use lab::input;
use ndarray::ArrayD;
use std::{fs, io::Cursor};
use tempfile::TempDir;

fn load(bytes: &[u8], limit: u64) -> Result<ArrayD<f64>, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("picture.png");
    fs::write(&path, bytes).unwrap();
    input::load_within(&path, limit).map_err(|error| format!("{error:#}"))
}

fn png(image: DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A grey PNG of `depth` bits, `data` packed.
fn packed(depth: png::BitDepth, color: png::ColorType, size: [u32; 2], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 255, 255, 255, 255, 0, 0]);
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn every_depth_becomes_grey_in_0_to_1() {
    use png::{BitDepth, ColorType};
    let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
    let grey = |depth, data: &[u8]| {
        let values = load(&packed(depth, ColorType::Grayscale, [4, 1], data), 1 << 20).unwrap();
        values.into_raw_vec_and_offset().0
    };
    assert_eq!(grey(BitDepth::One, &[0b0110_0000]), [0.0, 1.0, 1.0, 0.0]);
    assert_eq!(grey(BitDepth::Two, &[0b0001_1011]), thirds);
    assert_eq!(grey(BitDepth::Four, &[0x05, 0xaf]), thirds);
    assert_eq!(grey(BitDepth::Eight, &[0, 85, 170, 255]), thirds);
    let sixteen = grey(BitDepth::Sixteen, &[0, 0, 0, 1, 0x80, 0, 0xff, 0xff]);
    assert_eq!(sixteen, [0.0, 1.0 / 65535.0, 32768.0 / 65535.0, 1.0]);
    let palette = packed(BitDepth::Two, ColorType::Indexed, [3, 1], &[0b0001_1000]);
    assert_eq!(load(&palette, 1 << 20).unwrap().as_slice().unwrap(), [0.0, 1.0, 0.2126]);
}

#[test]
fn colours_weigh_as_in_rec_709_and_transparency_is_white() {
    let pixel = |r, g, b, a| {
        let image = image::RgbaImage::from_pixel(1, 1, image::Rgba([r, g, b, a]));
        load(&png(DynamicImage::ImageRgba8(image)), 1 << 20).unwrap()[[0, 0]]
    };
    assert_eq!(pixel(255, 0, 0, 255), 0.2126);
    assert_eq!(pixel(0, 255, 0, 255), 0.7152);
    assert_eq!(pixel(0, 0, 255, 255), 0.0722);
    assert_eq!(pixel(100, 100, 100, 255), 100.0 / 255.0);
    assert_eq!(pixel(9, 99, 199, 0), 1.0);
    assert!((pixel(0, 0, 0, 51) - 0.8).abs() < 1e-15);
}

#[test]
fn row_0_is_the_top() {
    let image = image::GrayImage::from_fn(3, 2, |x, y| image::Luma([(10 * y + x) as u8]));
    let values = load(&png(DynamicImage::ImageLuma8(image)), 1 << 20).unwrap();
    assert_eq!(values.shape(), [2, 3]);
    assert_eq!(values[[1, 2]], 12.0 / 255.0);
}

#[test]
fn a_huge_claim_is_refused_before_any_memory_is_taken() {
    // The header of a 20000 x 20000 PNG, and of one of 2^31 x 2^31, with next to no data.
    let small = packed(png::BitDepth::Eight, png::ColorType::Grayscale, [1, 1], &[7]);
    for (size, want) in [
        (
            20_000_u32,
            "an image of 20000 x 20000 pixels needs 3200000000 bytes, more than the limit of 2147483648",
        ),
        (
            i32::MAX as u32,
            "an image of 2147483647 x 2147483647 pixels needs 18446744073709551615 bytes",
        ),
    ] {
        let mut bytes = small.clone();
        bytes[16..20].copy_from_slice(&size.to_be_bytes());
        bytes[20..24].copy_from_slice(&size.to_be_bytes());
        let check = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&check.to_be_bytes());
        let message = load(&bytes, input::LIMIT).unwrap_err();
        assert!(message.contains(want) && message.contains("picture.png"), "{message}");
    }
}

/// The check sum of PNG chunks (PNG specification, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 },
        )
    })
}
