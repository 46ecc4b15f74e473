//! The value of a statement that names a texture: options, then the name of a file.

use crate::FileTexture;

/// The options that are understood, and the file name after them, which may hold blanks; `None` without a name.
pub fn parse(value: &str) -> Option<FileTexture> {
    let mut texture = FileTexture::new("");
    let mut rest = value.trim();
    while let Some((option, after)) = rest.split_once(char::is_whitespace).filter(|(o, _)| o.starts_with('-'))
    {
        let option = option.to_ascii_lowercase();
        // How many words follow, and whether fewer are allowed if they are not numbers.
        let (most, numeric) = match option.as_str() {
            "-o" | "-s" | "-t" => (3, true),
            "-mm" => (2, true),
            "-bm" | "-boost" | "-texres" => (1, true),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" | "-colorspace" => (1, false),
            // No option: a file name that begins with a minus sign.
            _ => break,
        };
        rest = after.trim_start();
        let mut words = Vec::new();
        for _ in 0..most {
            match rest.split_once(char::is_whitespace) {
                Some((word, after)) if !numeric || number(word).is_some() => {
                    words.push(word);
                    rest = after.trim_start();
                }
                _ => break,
            }
        }
        apply(&mut texture, &option, &words);
    }
    texture.file = rest.into();
    (!rest.is_empty()).then_some(texture)
}

/// Applies an option; numbers that are not finite change nothing.
fn apply(texture: &mut FileTexture, option: &str, words: &[&str]) {
    let number = |index: usize| words.get(index).and_then(|word| number(word)).filter(|x| x.is_finite());
    let pair = |default: f32| [number(0).unwrap_or(default), number(1).unwrap_or(default)];
    match option {
        "-clamp" => texture.clamp = words.first().is_some_and(|word| word.eq_ignore_ascii_case("on")),
        "-o" => texture.offset = pair(0.0),
        "-s" => texture.scale = pair(1.0),
        "-bm" => texture.bump_multiplier = number(0).unwrap_or(1.0),
        _ => {}
    }
}

fn number(word: &str) -> Option<f32> {
    fast_float2::parse(word).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        let all = parse("-s 2 3 1 -O 0.5 -clamp ON -bm -0.25 -mm 0 1 -type cube_top my tex.png");
        let expected = FileTexture {
            file: "my tex.png".into(),
            clamp: true,
            offset: [0.5, 0.0],
            scale: [2.0, 3.0],
            bump_multiplier: -0.25,
        };
        assert_eq!(all, Some(expected));
        assert_eq!(parse("-clamp off a.png"), Some(FileTexture::new("a.png")));
        assert_eq!(parse("-s inf nan 1 -bm inf a.png"), Some(FileTexture::new("a.png")));
    }

    #[test]
    fn names_may_look_like_options_and_numbers() {
        for name in ["-x a.png", "-o", "12 3.png", "-", "-s.png"] {
            assert_eq!(parse(name), Some(FileTexture::new(name)));
        }
        let after = FileTexture { offset: [1.0, 2.0], ..FileTexture::new("4.png") };
        assert_eq!(parse("-o 1 2 3 4.png"), Some(after));
        assert_eq!(parse("  "), None);
    }
}
