//! The value of a statement that names a texture: options, then the name of a file.

use super::ignored::Ignored;
use crate::{FileTexture, TextureChannel, TextureRole};

/// The options that are understood, and the file name after them, which may hold blanks; `None` without a name.
///
/// Options that would change what is drawn but are not applied are added to `ignored`; not those of a texture that is not
/// drawn (`role` is `None`).
pub fn parse(value: &str, role: Option<TextureRole>, ignored: &mut Ignored) -> Option<FileTexture> {
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
        if let Some(role) = role
            && !apply(&mut texture, &option, &words, role)
        {
            ignored.add(option.as_bytes());
        }
    }
    texture.file = rest.into();
    (!rest.is_empty()).then_some(texture)
}

/// Applies an option; false if the picture would be another one if it were applied. Numbers that are not finite change
/// nothing.
fn apply(texture: &mut FileTexture, option: &str, words: &[&str], role: TextureRole) -> bool {
    let number = |index: usize| words.get(index).and_then(|word| number(word)).filter(|x| x.is_finite());
    let pair = |default: f32| [number(0).unwrap_or(default), number(1).unwrap_or(default)];
    let is = |name: &str| words.first().is_some_and(|word| word.eq_ignore_ascii_case(name));
    match option {
        "-clamp" => texture.clamp = is("on"),
        "-o" => texture.offset = pair(0.0),
        "-s" => texture.scale = pair(1.0),
        "-bm" => texture.bump_multiplier = number(0).unwrap_or(1.0),
        "-mm" => (texture.base, texture.gain) = (number(0).unwrap_or(0.0), number(1).unwrap_or(1.0)),
        "-imfchan" => {
            texture.channel = channel(words.first().unwrap_or(&"")).filter(|_| role.is_number());
            return texture.channel.is_some();
        }
        // The pictures are always filtered, and never wrapped around a sphere or a cube.
        "-blendu" | "-blendv" => return is("on"),
        "-cc" => return is("off"),
        "-type" => return is("plane"),
        "-t" => return (0..3).all(|axis| number(axis).unwrap_or(0.0) == 0.0),
        "-boost" => return number(0).unwrap_or(0.0) == 0.0,
        "-colorspace" => return is(if is_color(role) { "sRGB" } else { "linear" }),
        _ => return false,
    }
    true
}

fn is_color(role: TextureRole) -> bool {
    matches!(role, TextureRole::Diffuse | TextureRole::Specular | TextureRole::Emissive)
}

/// `z` is a depth, which the formats of textures do not have.
fn channel(word: &str) -> Option<TextureChannel> {
    match word.to_ascii_lowercase().as_str() {
        "r" => Some(TextureChannel::Red),
        "g" => Some(TextureChannel::Green),
        "b" => Some(TextureChannel::Blue),
        "m" => Some(TextureChannel::Alpha),
        "l" => Some(TextureChannel::Luminance),
        _ => None,
    }
}

fn number(word: &str) -> Option<f32> {
    fast_float2::parse(word).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texture of a role, and whether all its options were applied.
    fn parsed(value: &str, role: TextureRole) -> (Option<FileTexture>, bool) {
        let mut ignored = Ignored::default();
        let texture = parse(value, Some(role), &mut ignored);
        (texture, ignored.warning("").is_none())
    }

    fn bump(value: &str) -> Option<FileTexture> {
        parsed(value, TextureRole::Bump).0
    }

    #[test]
    fn options_are_read() {
        let all = bump("-s 2 3 1 -O 0.5 -clamp ON -bm -0.25 -mm 0.5 2 -imfchan M -type cube_top my tex.png");
        let expected = FileTexture {
            file: "my tex.png".into(),
            clamp: true,
            offset: [0.5, 0.0],
            scale: [2.0, 3.0],
            bump_multiplier: -0.25,
            base: 0.5,
            gain: 2.0,
            channel: Some(TextureChannel::Alpha),
        };
        assert_eq!(all, Some(expected));
        assert_eq!(bump("-clamp off a.png"), Some(FileTexture::new("a.png")));
        assert_eq!(bump("-s inf nan 1 -bm inf -mm nan inf a.png"), Some(FileTexture::new("a.png")));
        assert_eq!(bump("-mm 0.5 a.png"), Some(FileTexture { base: 0.5, ..FileTexture::new("a.png") }));
    }

    #[test]
    fn options_that_are_not_applied_are_reported() {
        let applied = |options: &str, role| parsed(&format!("{options} a.png"), role).1;
        let always =
            ["-blendu on -BLENDV On", "-cc off", "-type plane", "-t 0 0 0", "-t 0", "-boost 0", "-clamp on"];
        for options in always {
            assert!(applied(options, TextureRole::Diffuse), "{options}");
        }
        for options in ["-blendu off", "-cc on", "-type sphere", "-t 0 0.1", "-boost 2", "-texres 512"] {
            assert!(!applied(options, TextureRole::Diffuse), "{options}");
        }
        for channel in ["r", "g", "b", "m", "l"] {
            let options = format!("-imfchan {channel}");
            assert!(applied(&options, TextureRole::Opacity) && !applied(&options, TextureRole::Diffuse));
        }
        assert!(!applied("-imfchan z", TextureRole::Bump));
        assert!(
            applied("-colorspace sRGB", TextureRole::Diffuse)
                && applied("-colorspace linear", TextureRole::Normal)
        );
        assert!(!applied("-colorspace linear", TextureRole::Diffuse));
        // Nothing of a texture that is not drawn.
        let mut ignored = Ignored::default();
        assert!(parse("-boost 2 a.png", None, &mut ignored).is_some() && ignored.warning("").is_none());
    }

    #[test]
    fn names_may_look_like_options_and_numbers() {
        for name in ["-x a.png", "-o", "12 3.png", "-", "-s.png"] {
            assert_eq!(bump(name), Some(FileTexture::new(name)));
        }
        let after = FileTexture { offset: [1.0, 2.0], ..FileTexture::new("4.png") };
        assert_eq!(bump("-o 1 2 3 4.png"), Some(after));
        assert_eq!(bump("  "), None);
    }
}
