use std::io::Cursor;

use super::*;
use crate::image::Pixels;

/// A picture with smooth colours that differs from number to number.
fn picture(number: u32) -> Picture<'static> {
    let pixel = |i: u32| {
        let (x, y) = (i % 40, i / 40);
        [(x * 6) as u8, (y * 8) as u8, (number * 60 + x) as u8, 255]
    };
    Picture { width: 40, height: 30, pixels: Pixels::Eight((0..1200).map(pixel).collect::<Vec<_>>().into()) }
}

/// The pixels of a picture, which are translucent in a translucent film.
fn translucent(number: u32, is_translucent: bool) -> Vec<[u8; 4]> {
    let mut pixels = eight(&picture(number));
    if is_translucent {
        pixels.iter_mut().enumerate().for_each(|(i, p)| p[3] = (i * 7 + number as usize) as u8);
    }
    pixels
}

fn eight(picture: &Picture) -> Vec<[u8; 4]> {
    match &picture.pixels {
        Pixels::Eight(pixels) => pixels.to_vec(),
        Pixels::Sixteen(_) => unreachable!("8 bits"),
    }
}

fn film(format: FilmFormat) -> Film {
    let rate = FrameRate { pictures: 30, seconds: 1 };
    Film { format, width: 40, height: 30, pictures: 4, rate, plays: 0, is_translucent: false }
}

fn written(film: &Film) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = film.begin(&mut bytes).unwrap();
    for number in 0..film.pictures {
        let pixels = Pixels::Eight(translucent(number, film.is_translucent).into());
        let picture = Picture { pixels, ..picture(number) };
        writer.append(&film.encode(&picture, number).unwrap()).unwrap();
    }
    writer.finish().unwrap();
    bytes
}

#[test]
fn an_apng_holds_the_pictures_exactly_and_their_times() {
    for is_translucent in [false, true] {
        let film = Film { plays: 3, is_translucent, ..film(FilmFormat::Apng) };
        let mut reader = png::Decoder::new(Cursor::new(written(&film))).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (4, 3));
        let channels = reader.info().color_type.samples();
        assert_eq!(channels, if is_translucent { 4 } else { 3 });
        for number in 0..4 {
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            let frame = reader.info().frame_control().unwrap();
            assert_eq!((frame.delay_num, frame.delay_den), (1, 30));
            let expected: Vec<u8> =
                translucent(number, is_translucent).iter().flat_map(|p| p[..channels].to_vec()).collect();
            assert!(bytes == expected, "picture {number}");
        }
    }
}

#[test]
fn an_animated_webp_holds_the_pictures_exactly_and_their_times() {
    for is_translucent in [false, true] {
        let film = Film { plays: 3, is_translucent, ..film(FilmFormat::WebP) };
        let bytes = written(&film);
        assert_eq!(bytes.len() as u32, u32::from_le_bytes(bytes[4..8].try_into().unwrap()) + 8);
        let mut decoder = image_webp::WebPDecoder::new(Cursor::new(bytes)).unwrap();
        assert!(decoder.is_animated() && decoder.has_alpha() == is_translucent);
        assert_eq!((decoder.dimensions(), decoder.num_frames()), ((40, 30), 4));
        assert_eq!(decoder.loop_count(), image_webp::LoopCount::Times(3.try_into().unwrap()));
        let channels = if is_translucent { 4 } else { 3 };
        let mut times = Vec::new();
        for number in 0..4 {
            let mut shown = vec![0; decoder.output_buffer_size().unwrap()];
            times.push(decoder.read_frame(&mut shown).unwrap());
            let expected: Vec<u8> =
                translucent(number, is_translucent).iter().flat_map(|p| p[..channels].to_vec()).collect();
            assert!(shown == expected, "picture {number}");
        }
        // 33.3 milliseconds each, which do not add up to an error.
        assert_eq!(times, [33, 34, 33, 33]);
    }
}

#[test]
fn a_gif_is_close_to_the_pictures_and_its_times_add_up() {
    let mut options = ::gif::DecodeOptions::new();
    options.set_color_output(::gif::ColorOutput::RGBA);
    let bytes = written(&film(FilmFormat::Gif));
    let mut decoder = options.read_info(&bytes[..]).unwrap();
    let mut delays = 0;
    for number in 0..4 {
        let frame = decoder.read_next_frame().unwrap().unwrap();
        delays += u32::from(frame.delay);
        let pixels = eight(&picture(number));
        let shown = frame.buffer.as_chunks::<4>().0;
        let off = |k: usize| {
            let squares = shown.iter().zip(&pixels).map(|(a, b)| f64::from(a[k].abs_diff(b[k])).powi(2));
            (squares.sum::<f64>() / pixels.len() as f64).sqrt()
        };
        assert!((0..3).all(|k| off(k) < 8.0), "picture {number}: {:?}", [off(0), off(1), off(2)]);
        assert!(shown.iter().all(|p| p[3] == 255));
        // Dithering keeps the mean.
        let mean = |pixels: &[[u8; 4]]| pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / 1200.0;
        assert!((mean(shown) - mean(&pixels)).abs() < 1.5);
    }
    assert!(decoder.read_next_frame().unwrap().is_none());
    // 4 pictures at 30 a second are 13.3 hundredths.
    assert_eq!((delays, decoder.repeat()), (13, ::gif::Repeat::Infinite));
}

#[test]
fn y4m_is_bt_709() {
    let bytes = written(&film(FilmFormat::Y4m));
    let head = b"YUV4MPEG2 W40 H30 F30:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    assert!(bytes.starts_with(head));
    let frames: Vec<&[u8]> = bytes[head.len()..].chunks(6 + 3600).collect();
    assert_eq!(frames.len(), 4);
    for (number, frame) in frames.iter().enumerate() {
        assert!(frame.starts_with(b"FRAME\n"));
        let planes = &frame[6..];
        for (i, p) in eight(&picture(number as u32)).iter().enumerate() {
            let [r, g, b] = [p[0], p[1], p[2]].map(|v| f64::from(v) / 255.0);
            // The published formula, with its rounded coefficients.
            let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            let expected =
                [16.0 + 219.0 * y, 128.0 + 224.0 * (b - y) / 1.8556, 128.0 + 224.0 * (r - y) / 1.5748];
            for (k, expected) in expected.into_iter().enumerate() {
                let found = f64::from(planes[k * 1200 + i]);
                assert!((found - expected).abs() < 0.51, "{found} for {expected}");
            }
        }
    }
    let rgb = written(&film(FilmFormat::Rgb));
    let expected: Vec<u8> = (0..4).flat_map(|n| eight(&picture(n))).flat_map(|p| p[..3].to_vec()).collect();
    assert!(rgb == expected);
}

#[test]
fn rates_are_fractions() {
    let rate = |pictures, seconds| Ok(FrameRate { pictures, seconds });
    assert_eq!("25".parse::<FrameRate>(), rate(25, 1));
    assert_eq!("12.5".parse::<FrameRate>(), rate(25, 2));
    assert_eq!("30000/1001".parse::<FrameRate>(), rate(30000, 1001));
    assert_eq!("0.001".parse::<FrameRate>(), rate(1, 1000));
    for bad in ["", "0", "-1", "x", "1/0", "0/1", "1001", "nan", "1/9999", "4294967296"] {
        assert!(bad.parse::<FrameRate>().is_err(), "{bad}");
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused() {
    let fast = FrameRate { pictures: 60, seconds: 1 };
    assert!(Film { rate: fast, ..film(FilmFormat::Gif) }.check().unwrap_err().contains("--fps"));
    assert!(Film { is_translucent: true, ..film(FilmFormat::Y4m) }.check().is_err());
    assert!(Film { is_translucent: true, ..film(FilmFormat::Apng) }.check().is_ok());
    let other = Film { width: 41, ..film(FilmFormat::Apng) };
    assert!(matches!(other.encode(&picture(0), 0), Err(ImageError::SizesDiffer(..))));
}
