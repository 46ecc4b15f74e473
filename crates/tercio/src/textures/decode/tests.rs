//! Pictures are made by encoders, and broken by hand.

use std::io::Cursor;

use image::{GrayImage, Rgb, RgbaImage};

use super::*;

/// Eight by six texels of two colours, left and right.
fn rgba() -> RgbaImage {
    RgbaImage::from_fn(8, 6, |x, _| image::Rgba(if x < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 255] }))
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).expect("an encoder");
    bytes.into_inner()
}

/// A file, decoded as those that models name are.
fn from_file(name: &str, bytes: &[u8]) -> Result<Picture, TextureError> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join(name);
    std::fs::write(&path, bytes)?;
    let needs = needs_of_file(&path)?;
    needs.check(0, Some(1 << 28))?;
    decode_file(&path, &needs)
}

fn message(result: Result<Picture, TextureError>) -> String {
    result.map_or_else(|error| error.to_string(), |_| "no error".into())
}

#[test]
fn every_format_is_decoded_whatever_its_name() {
    let expected = from_file("a.png", &encoded(rgba(), ImageFormat::Png)).expect("a picture");
    let expected = expected.texture(Encoding::Linear);
    for format in [ImageFormat::Png, ImageFormat::Gif, ImageFormat::Bmp, ImageFormat::WebP, ImageFormat::Tiff]
    {
        let picture = from_file("a.jpg", &encoded(rgba(), format)).expect("a picture");
        assert_eq!(picture.texture(Encoding::Linear).levels(), expected.levels(), "{format:?}");
    }
    let tga = encoded(rgba(), ImageFormat::Tga);
    let picture = from_file("a.TGA", &tga).expect("a picture");
    assert_eq!(picture.texture(Encoding::Linear).levels(), expected.levels());
    assert!(message(from_file("a.png", &tga)).contains("expected a PNG, JPEG"));

    let rgb = DynamicImage::from(rgba()).into_rgb8();
    let jpeg =
        from_file("a.png", &encoded(rgb, ImageFormat::Jpeg)).expect("a picture").texture(Encoding::Linear);
    assert_eq!((jpeg.levels()[0].width, jpeg.levels()[0].height), (8, 6));
    let [r, g, b, a] = jpeg.levels()[0].texels[0].map(|c| c >> 8);
    assert!(r > 240 && g < 16 && b < 16 && a == 255, "{r} {g} {b}");
}

#[test]
fn sixteen_bits_are_kept_and_grey_is_spread() {
    let wide = image::ImageBuffer::from_pixel(1, 1, Rgb([1u16, 256, 65535]));
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let picture = from_file("a", &encoded(wide.clone(), format)).expect("a picture");
        assert_eq!(picture.texture(Encoding::Linear).levels()[0].texels, [[1, 256, 65535, 65535]]);
    }
    let grey = GrayImage::from_pixel(1, 1, image::Luma([9]));
    let picture = from_file("a", &encoded(grey, ImageFormat::Png)).expect("a picture");
    assert_eq!(picture.texture(Encoding::Linear).levels()[0].texels, [[9 * 257, 9 * 257, 9 * 257, 65535]]);
}

#[test]
fn the_upper_row_comes_first_in_every_format() {
    let image = RgbaImage::from_fn(2, 2, |_, y| image::Rgba(if y == 0 { [255; 4] } else { [0, 0, 0, 255] }));
    for format in FORMATS {
        let image = DynamicImage::from(image.clone());
        let image = if format == ImageFormat::Jpeg { image.to_rgb8().into() } else { image };
        let picture = from_file("a.tga", &encoded(image, format)).expect("a picture");
        let texels: Vec<bool> =
            picture.texture(Encoding::Linear).levels()[0].texels.iter().map(|t| t[0] > 32768).collect();
        assert_eq!(texels, [true, true, false, false], "{format:?}");
    }
}

/// The head of a PNG of this size, without the picture.
fn png_head(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = encoded(rgba(), ImageFormat::Png);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = flate2::Crc::new();
    crc.update(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.sum().to_be_bytes());
    bytes
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    let large = message(from_file("a.png", &png_head(30_000, 30_000)));
    assert!(large.starts_with("needs ") && large.ends_with("the limit leaves 268435456"), "{large}");
    let long = message(from_file("a.png", &png_head(40_000, 3)));
    assert!(long.starts_with("has 40000x3 texels, expected 1 to 32768"), "{long}");
    let missing = message(from_file("a.png", &png_head(1000, 1000)));
    assert!(missing.starts_with("broken"), "{missing}");
    let empty = message(from_file("a.png", &png_head(0, 6)));
    assert!(empty.starts_with("broken") || empty.starts_with("has 0x6"), "{empty}");
}

#[test]
fn what_is_no_picture_is_described() {
    assert!(message(from_file("a.png", b"")).ends_with("found an empty file"));
    assert!(message(from_file("a.png", b"v 0 0 0\n")).ends_with("found none of these"));
    assert!(message(from_file("a.png", b"DDS \x7c\0\0\0\0\0\0\0")).ends_with("found Dds"));
    assert!(message(from_file("a.tga", b"")).ends_with("found an empty file"));
    assert!(
        message(from_file("a.tga", &[0; 18])).starts_with("broken")
            || message(from_file("a.tga", &[0; 18])).starts_with("has 0x0")
    );
}

#[test]
fn shortened_and_altered_files_are_errors_or_pictures() {
    for format in FORMATS {
        let image = DynamicImage::from(rgba());
        let image = if format == ImageFormat::Jpeg { image.to_rgb8().into() } else { image };
        let bytes = encoded(image, format);
        for length in 0..bytes.len().min(200) {
            let _ = from_bytes(format, &bytes[..length]);
        }
        let mut random = 1u32;
        for _ in 0..3000 {
            let mut altered = bytes.clone();
            for _ in 0..1 + random % 3 {
                random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let place = (random >> 8) as usize % altered.len();
                altered[place] = (random >> 3) as u8;
            }
            let _ = from_bytes(format, &altered);
        }
    }
}

#[test]
fn a_shortened_picture_is_an_error_or_said_to_be_one() {
    let noise = RgbaImage::from_fn(64, 48, |x, y| {
        let level = (x * 97 + y * y * 31) as u8;
        image::Rgba([level, level.wrapping_mul(7), level ^ 91, 255])
    });
    for format in FORMATS {
        let image = DynamicImage::from(noise.clone());
        let image = if format == ImageFormat::Jpeg { image.to_rgb8().into() } else { image };
        let bytes = encoded(image, format);
        let ends_early = |bytes: &[u8]| from_bytes(format, bytes).map_or(true, |picture| picture.ends_early);
        assert!(!ends_early(&bytes), "{format:?}");
        for share in [10, 50, 90, 97] {
            assert!(ends_early(&bytes[..bytes.len() * share / 100]), "{share} % of a {format:?}");
        }
    }
    // A thumbnail within a segment has an end of its own.
    let jpeg = encoded(DynamicImage::from(noise).to_rgb8(), ImageFormat::Jpeg);
    let thumbnail = [&[0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, 0xd9], &jpeg[2..]].concat();
    let whole = [&jpeg[..2], &thumbnail].concat();
    let ends_early = |bytes: &[u8]| from_bytes(ImageFormat::Jpeg, bytes).expect("a picture").ends_early;
    assert!(!ends_early(&whole) && ends_early(&whole[..whole.len() / 2]));
    // Without the mark of the end, but whole.
    assert!(ends_early(&whole[..whole.len() - 2]));
    // What follows the end does not matter.
    assert!(!ends_early(&[&jpeg[..], b"more"].concat()));
    let refused = texture_from_bytes(&whole[..whole.len() / 2], Encoding::Srgb, None);
    assert!(matches!(refused, Err(TextureError::Broken { .. })), "{refused:?}");
}

fn from_bytes(format: ImageFormat, bytes: &[u8]) -> Result<Picture, TextureError> {
    let needs = needs(in_memory(bytes), format, bytes.len() as u64)?;
    needs.check(0, Some(1 << 26))?;
    decode(bytes, &needs)
}

#[test]
fn textures_are_made_from_bytes() {
    let bytes = encoded(rgba(), ImageFormat::Png);
    let texture = texture_from_bytes(&bytes, Encoding::Srgb, None).expect("a picture");
    assert_eq!(
        (texture.levels()[0].width, texture.encoding(), texture.is_opaque()),
        (8, Encoding::Srgb, true)
    );
    let refused = texture_from_bytes(&bytes, Encoding::Srgb, Some(1000));
    assert!(matches!(refused, Err(TextureError::Memory { left: 1000, .. })), "{refused:?}");
}
