//! Pictures are the same after writing and reading; damage gives errors.

use proptest::prelude::*;

use super::*;

fn picture(width: u32, height: u32, sixteen: bool, opaque: bool, seed: u32) -> Picture<'static> {
    let mut state = seed | 1;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as u16
    };
    let n = (width * height) as usize;
    let alpha = |v: u16| if opaque { u16::MAX } else { v };
    let wide: Vec<[u16; 4]> = (0..n).map(|_| [next(), next(), next(), alpha(next())]).collect();
    let pixels = if sixteen {
        Pixels::Sixteen(wide.into())
    } else {
        Pixels::Eight(wide.iter().map(|p| p.map(|v| (v >> 8) as u8)).collect::<Vec<_>>().into())
    };
    Picture { width, height, pixels }
}

fn written(picture: &Picture, format: PictureFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    picture.write(format, &mut bytes).unwrap();
    bytes
}

proptest! {
    #[test]
    fn what_was_written_can_be_read(
        width in 1u32..70, height in 1u32..40, sixteen: bool, opaque: bool, seed: u32,
    ) {
        let original = picture(width, height, sixteen, opaque, seed);
        for format in PictureFormat::ALL {
            let can = match format {
                PictureFormat::Png => true,
                PictureFormat::Ppm => original.is_opaque(),
                PictureFormat::WebP => !sixteen,
                PictureFormat::Jpeg { .. } => !sixteen && original.is_opaque(),
            };
            if can && matches!(format, PictureFormat::Jpeg { .. }) {
                let read = Picture::from_bytes(&written(&original, format)).unwrap();
                prop_assert_eq!((read.width, read.height), (width, height));
            } else if can {
                prop_assert_eq!(&Picture::from_bytes(&written(&original, format)).unwrap(), &original, "{}", format);
            } else {
                prop_assert!(original.write(format, &mut Vec::new()).is_err());
            }
        }
    }

    #[test]
    fn one_translucent_pixel_keeps_alpha(
        width in 1u32..20, height in 1u32..10, sixteen: bool, at in 0.0..1.0, alpha in 0u16..255,
    ) {
        let mut original = picture(width, height, sixteen, true, 3);
        let at = (f64::from(width * height) * at) as usize;
        match &mut original.pixels {
            Pixels::Eight(p) => p.to_mut()[at][3] = alpha as u8,
            Pixels::Sixteen(p) => p.to_mut()[at][3] = alpha,
        }
        let read = Picture::from_bytes(&written(&original, PictureFormat::Png)).unwrap();
        prop_assert_eq!(&read, &original);
        prop_assert!(original.write(PictureFormat::Ppm, &mut Vec::new()).is_err());
    }

    #[test]
    fn damaged_pictures_give_errors_not_panics(
        format in prop::sample::select(&PictureFormat::ALL[..]), cut in 0.0..1.0, at in 0.0..1.0, value: u8,
    ) {
        let mut bytes = written(&picture(20, 10, false, true, 5), format);
        bytes.truncate((bytes.len() as f64 * cut) as usize);
        prop_assert!(Picture::from_bytes(&bytes).is_err());
        let mut bytes = written(&picture(20, 10, false, true, 5), format);
        let place = (bytes.len() as f64 * at) as usize;
        bytes[place] = value;
        let _ = Picture::from_bytes(&bytes);
    }
}

#[test]
fn jpeg_pictures_are_close_and_have_all_chroma() {
    // Smooth colours, with a thin coloured line that subsampled chroma would lose.
    let (width, height) = (61, 37);
    let pixel = |i: u32| match (i % width, i / width) {
        (20, _) => [230, 20, 40, 255],
        (x, y) => [(x * 4) as u8, (y * 6) as u8, 128, 255],
    };
    let pixels: Vec<[u8; 4]> = (0..width * height).map(pixel).collect();
    let original = Picture { width, height, pixels: Pixels::Eight(pixels.clone().into()) };
    let mut lengths = Vec::new();
    for (quality, most) in [(30, 14.0), (90, 4.0), (100, 1.0)] {
        let bytes = written(&original, PictureFormat::Jpeg { quality });
        // Baseline; three components, each sampled at every pixel.
        let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        let samplings: Vec<u8> = (0..3).map(|k| bytes[frame + 11 + 3 * k]).collect();
        assert_eq!((bytes[frame + 9], samplings), (3, vec![0x11; 3]));
        // The decoder shares no code with the encoder.
        let Pixels::Eight(read) = Picture::from_bytes(&bytes).unwrap().pixels else { panic!("8 bits") };
        let squares = pixels.iter().zip(&*read).flat_map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])));
        let off = (squares.map(|d| f64::from(d).powi(2)).sum::<f64>() / (pixels.len() * 3) as f64).sqrt();
        assert!(off < most, "quality {quality} is off by {off}");
        lengths.push(bytes.len());
    }
    assert!(lengths.is_sorted(), "{lengths:?}");
    let clear = picture(4, 4, false, false, 1);
    let error = clear.write(PictureFormat::Jpeg { quality: 90 }, &mut Vec::new()).unwrap_err();
    assert!(error.to_string().contains("transparency"), "{error}");
    assert_eq!(PictureFormat::from_path("a.JPG"), PictureFormat::from_path("a.jpeg"));
}

#[test]
fn opaque_png_pictures_have_no_alpha_channel_and_say_srgb() {
    let has = |bytes: &[u8], chunk: &[u8]| bytes.windows(4).any(|w| w == chunk);
    let opaque = written(&picture(4, 4, false, true, 1), PictureFormat::Png);
    let clear = written(&picture(4, 4, true, false, 1), PictureFormat::Png);
    // Depth and colour type follow the size.
    assert_eq!((&opaque[24..26], &clear[24..26]), (&[8, 2][..], &[16, 6][..]));
    assert!(has(&opaque, b"sRGB") && has(&clear, b"sRGB"));
}

#[test]
fn comparison_counts_and_shows_differences() {
    let a = Picture { width: 2, height: 1, pixels: Pixels::Eight(vec![[10, 20, 30, 255]; 2].into()) };
    let same = compare(&a, &a).unwrap().0;
    assert_eq!((same.differing, same.largest_of_all(), same.mean_of_all()), (0, 0.0, 0.0));

    let b = Picture { pixels: Pixels::Eight(vec![[10, 20, 30, 255], [14, 20, 22, 255]].into()), ..a.clone() };
    let (d, shown) = compare(&a, &b).unwrap();
    assert_eq!((d.pixels, d.differing), (2, 1));
    assert_eq!((d.largest, d.mean), ([4.0, 0.0, 8.0, 0.0], [2.0, 0.0, 4.0, 0.0]));
    assert_eq!(shown.pixels, Pixels::Eight(vec![[0, 0, 0, 255], [128, 0, 255, 255]].into()));

    let deep = Picture { pixels: Pixels::Sixteen(vec![[2570, 5140, 7710, 65535]; 2].into()), ..a.clone() };
    assert_eq!(compare(&a, &deep).unwrap().0.differing, 0);
    let other = Picture { width: 1, height: 2, ..a.clone() };
    assert!(matches!(compare(&a, &other), Err(ImageError::SizesDiffer([2, 1], [1, 2]))));
}

#[test]
fn an_old_file_is_kept_until_the_new_one_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let destination = Destination::from_path(&path);
    let write = |text: &[u8]| {
        let mut file = OutputFile::create(&destination).unwrap();
        file.write_all(text).unwrap();
        file
    };
    write(b"old").commit().unwrap();
    drop(write(b"half"));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary file is gone");
    write(b"new").commit().unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

#[cfg(unix)]
#[test]
fn permissions_links_and_devices_are_respected() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let [path, link] = ["a.png", "link.png"].map(|n| folder.path().join(n));
    let p = picture(2, 2, false, true, 1);
    p.save(&path).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    fs::write(folder.path().join("plain"), "").unwrap();
    assert_eq!(mode(&path), mode(&folder.path().join("plain")), "as any new file");

    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink(&path, &link).unwrap();
    p.save(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(mode(&path), 0o640);

    let null = Destination::File("/dev/null".into());
    let mut out = OutputFile::create(&null).unwrap();
    out.write_all(b"x").unwrap();
    out.commit().unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn outputs_that_cannot_be_written_are_found_early() {
    let folder = tempfile::tempdir().unwrap();
    assert!(Destination::File(folder.path().into()).check().is_err());
    assert!(Destination::File(folder.path().join("no/a.png")).check().is_err());
    assert!(Destination::File("a.png".into()).check().is_ok());
    assert_eq!(PictureFormat::from_path("a.PNG"), Some(PictureFormat::Png));
    assert_eq!(PictureFormat::from_path("a.bmp"), None);
}

#[test]
fn files_are_named_in_errors_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let original = picture(3, 2, false, true, 7);
    let path = folder.path().join("a.webp");
    original.save(&path).unwrap();
    assert_eq!(Picture::from_file(&path).unwrap(), original);

    for (name, is_right) in [
        ("a.bmp", (|e| matches!(e, ImageError::UnknownExtension)) as fn(&ImageError) -> bool),
        ("no/a.png", |e| matches!(e, ImageError::Io(_))),
    ] {
        let path = folder.path().join(name);
        let error = original.save(&path).unwrap_err();
        assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
        assert!(matches!(&error, ImageError::File { source, .. } if is_right(source)), "{error:?}");
    }
    let missing = Picture::from_file(folder.path().join("missing.png")).unwrap_err();
    let source = std::error::Error::source(&missing).expect("a reason");
    assert!(source.to_string().contains("os error 2") || cfg!(not(unix)), "{source}");
}
