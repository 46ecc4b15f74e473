//! The statements of a material library.

use std::collections::HashSet;

use super::ignored::Ignored;
use super::texture;
use crate::io::companions;
use crate::io::obj::lines::{Lines, join};
use crate::{FileMaterial, TextureRole};

/// Statements that name a texture, in lower case, with what it means; `None` for those that are not drawn. They are those
/// of the manual, and those that programs have added.
///
/// `map_Tr` is not drawn because programs do not agree whether its white is opaque.
const TEXTURES: [(&[u8], Option<TextureRole>); 17] = [
    (b"map_kd", Some(TextureRole::Diffuse)),
    (b"map_d", Some(TextureRole::Opacity)),
    (b"map_ks", Some(TextureRole::Specular)),
    (b"map_ke", Some(TextureRole::Emissive)),
    (b"map_bump", Some(TextureRole::Bump)),
    (b"bump", Some(TextureRole::Bump)),
    (b"norm", Some(TextureRole::Normal)),
    (b"map_pr", Some(TextureRole::Roughness)),
    (b"map_pm", Some(TextureRole::Metallic)),
    (b"map_ka", None),
    (b"map_ns", None),
    (b"map_tr", None),
    (b"disp", None),
    (b"decal", None),
    (b"refl", None),
    (b"map_ps", None),
    (b"map_rma", None),
];

/// Statements without effect here, in lower case, that are not reported: files state them for every material, and nothing
/// that is drawn depends on them. Ambient light has the diffuse colour; `Ni` and `sharpness` belong to rays that are refracted
/// and mirrored, `Pcr` and `anisor` to `Pc` and `aniso`; textures are always anti-aliased.
const WITHOUT_EFFECT: [&[u8]; 6] = [b"ka", b"ni", b"sharpness", b"pcr", b"anisor", b"map_aat"];

/// A material that is being read.
#[derive(Default)]
struct Draft {
    material: FileMaterial,
    /// Whether `d` was found in the file: it takes precedence over `Tr`, whose meaning exporters do not agree on.
    has_d: bool,
}

/// Parses a library and appends its materials; if a name exists already, its first definition is kept. Keywords may be in
/// upper or lower case.
pub fn parse(library: &str, text: &[u8], materials: &mut Vec<FileMaterial>, warnings: &mut Vec<String>) {
    let (mut broken, mut ignored) = (Vec::new(), Ignored::default());
    let mut draft: Option<Draft> = None;
    let mut scratch = Vec::new();
    for line in Lines::new(text, 1) {
        let text = if line.continued { join(line.text, &mut scratch) } else { line.text }.trim_ascii();
        let keyword = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let value = text.get(keyword.len()..).unwrap_or_default().trim_ascii();
        let keyword = keyword.to_ascii_lowercase();
        if keyword == b"newmtl" {
            materials.extend(draft.take().map(finished));
            let name = String::from_utf8_lossy(value).into_owned();
            draft = Some(Draft { material: FileMaterial { name, ..FileMaterial::default() }, has_d: false });
        } else if !statement(&mut draft, &keyword, value, &mut ignored) {
            broken.push(line.number);
        }
    }
    materials.extend(draft.map(finished));
    if let Some(first) = broken.first() {
        let more = match broken.len() - 1 {
            0 => String::new(),
            n => format!(" and in {n} more"),
        };
        warnings.push(format!(
            "did not understand the value in line {first} of the material library \"{library}\"{more}"
        ));
    }
    warnings.extend(ignored.warning(library));
}

/// The material, with every other texture once.
fn finished(draft: Draft) -> FileMaterial {
    let mut material = draft.material;
    let mut known = HashSet::new();
    material.other_textures.retain(|name| known.insert(name.clone()));
    material
}

/// Applies one statement; false if its value is invalid, or if it belongs to no material.
fn statement(draft: &mut Option<Draft>, keyword: &[u8], value: &[u8], ignored: &mut Ignored) -> bool {
    let texture = TEXTURES.iter().find(|(name, _)| *name == keyword);
    let Some(draft) = draft else {
        let is_known =
            matches!(keyword, b"kd" | b"d" | b"tr" | b"ks" | b"ns" | b"ke" | b"pr" | b"pm" | b"illum");
        return !is_known && texture.is_none();
    };
    if let Some((_, role)) = texture {
        return texture_statement(&mut draft.material, *role, value, ignored);
    }
    let material = &mut draft.material;
    let unit = |x: f32| x.clamp(0.0, 1.0);
    match keyword {
        b"kd" => match color(value) {
            Some(rgb) => (material.diffuse, material.states_diffuse) = (rgb.map(unit), true),
            None => return false,
        },
        b"ks" => match color(value) {
            Some(rgb) => material.specular = Some(rgb.map(unit)),
            None => return false,
        },
        b"ke" => match color(value) {
            Some(rgb) => material.emissive = rgb.map(|c| c.max(0.0)),
            None => return false,
        },
        b"ns" => match number(value) {
            Some(x) if x >= 0.0 => material.shininess = Some(x),
            _ => return false,
        },
        b"pr" => match number(value) {
            Some(x) => material.roughness = Some(unit(x)),
            None => return false,
        },
        b"pm" => match number(value) {
            Some(x) => material.metallic = Some(unit(x)),
            None => return false,
        },
        b"d" => match number(value.strip_prefix(b"-halo").unwrap_or(value)) {
            Some(x) => {
                (material.opacity, draft.has_d) = (unit(x), true);
                // An opacity that depends on the angle of view.
                if value.starts_with(b"-halo") {
                    ignored.add(b"-halo");
                }
            }
            None => return false,
        },
        b"illum" => match number(value) {
            Some(x) if (0.0..=10.0).contains(&x) && x.fract() == 0.0 => {
                material.illumination = Some(x as u8);
                // Above 2 are hints which rays to trace; 10 draws nothing but shadows.
                if x == 10.0 {
                    ignored.add(b"illum 10");
                }
            }
            _ => return false,
        },
        // The light that a transparent material lets through; exporters write white and black for "not stated".
        b"tf" => match color(value) {
            Some(rgb) if rgb == [0.0; 3] || rgb == [1.0; 3] => {}
            Some(_) => ignored.add(keyword),
            None => return false,
        },
        // Sheen, clear coat and anisotropic highlights.
        b"ps" | b"pc" | b"aniso" => match number(value) {
            Some(0.0) => {}
            Some(_) => ignored.add(keyword),
            None => return false,
        },
        b"tr" => match number(value) {
            // An invisible material makes no sense: programs that write 1, such as MeshLab, mean opaque.
            Some(x) if !draft.has_d => material.opacity = if x >= 1.0 { 1.0 } else { unit(1.0 - x) },
            Some(_) => {}
            None => return false,
        },
        _ if keyword.is_empty() || keyword.starts_with(b"#") || WITHOUT_EFFECT.contains(&keyword) => {}
        _ => ignored.add(keyword),
    }
    true
}

/// Applies a statement that names a texture; false if it names none. Programs write empty statements for textures that a
/// material does not have; only that of the diffuse texture is reported, as that of a broken line.
fn texture_statement(
    material: &mut FileMaterial,
    role: Option<TextureRole>,
    value: &[u8],
    ignored: &mut Ignored,
) -> bool {
    let Some(texture) = texture::parse(&String::from_utf8_lossy(value), role, ignored) else {
        return role != Some(TextureRole::Diffuse);
    };
    // The last one counts, and the others are said to be not drawn.
    let other = match role {
        Some(role) => {
            let last = texture.file.clone();
            material.textures.get_mut(role).replace(texture).map(|t| t.file).filter(|file| *file != last)
        }
        None => Some(texture.file),
    };
    if material.other_textures.len() < companions::MOST {
        material.other_textures.extend(other);
    }
    true
}

/// The first number of a statement; `None` if any is invalid.
fn number(value: &[u8]) -> Option<f32> {
    numbers(value)?.first().copied()
}

/// Three numbers, or one for all components.
fn color(value: &[u8]) -> Option<[f32; 3]> {
    match numbers(value)?[..] {
        [r, g, b, ..] => Some([r, g, b]),
        [grey] => Some([grey; 3]),
        _ => None,
    }
}

/// All words as finite numbers, or none.
fn numbers(value: &[u8]) -> Option<Vec<f32>> {
    value
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
        .take_while(|w| !w.starts_with(b"#"))
        .map(|w| fast_float2::parse::<f32, _>(w).ok().filter(|x| x.is_finite()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (Vec<FileMaterial>, Vec<String>) {
        let (mut materials, mut warnings) = (Vec::new(), Vec::new());
        parse("a.mtl", text.as_bytes(), &mut materials, &mut warnings);
        (materials, warnings)
    }

    /// The roles and files of the textures that are drawn.
    fn textures(material: &FileMaterial) -> Vec<(&str, &str)> {
        material.textures.iter().map(|(role, texture)| (role.name(), texture.file.as_str())).collect()
    }

    #[test]
    fn colours_opacities_and_textures_are_read() {
        let (m, w) = parsed(
            "# c\nnewmtl red paint\nKd 1 0.5 0\nd 0.25\nTr 0.9\nmap_Kd -s 1 1 1 -o 0.5 -clamp on my tex.png\n\
             newmtl b\r\nTr 0.25\r\nKd 0.5\r\nNs 3\nmap_Kd -cc off a.jpg",
        );
        assert_eq!(w, [""; 0]);
        assert_eq!(m[0].name, "red paint");
        assert_eq!(m[0].diffuse, [1.0, 0.5, 0.0]);
        assert_eq!(m[0].opacity, 0.25);
        assert_eq!(textures(&m[0]), [("diffuse", "my tex.png")]);
        assert_eq!((m[1].opacity, m[1].diffuse), (0.75, [0.5; 3]));
        assert_eq!(textures(&m[1]), [("diffuse", "a.jpg")]);
    }

    #[test]
    fn highlights_emission_roughness_and_metals_are_read() {
        let (m, w) = parsed(
            "newmtl a\nKs 0.5 2 0\nNs 96.5\nKe 3 0 -1\nPr 0.25\nPm 7\nnewmtl b\nKs 0.5\nnewmtl c\nd 1\n",
        );
        assert_eq!(w, [""; 0]);
        assert_eq!((m[0].specular, m[0].shininess), (Some([0.5, 1.0, 0.0]), Some(96.5)));
        assert_eq!((m[0].emissive, m[0].roughness, m[0].metallic), ([3.0, 0.0, 0.0], Some(0.25), Some(1.0)));
        assert_eq!(m[1].specular, Some([0.5; 3]));
        assert_eq!(m[2], FileMaterial { name: "c".into(), ..FileMaterial::default() });
    }

    #[test]
    fn keywords_may_have_any_case() {
        let (m, w) = parsed("NEWMTL a\nKD 0 0 1\nks 1\nNS 2\nMAP_KD a.png\nmap_bump b.png\nmap_D c.png\n");
        assert_eq!(w, [""; 0]);
        assert_eq!(
            (m[0].diffuse, m[0].specular, m[0].shininess),
            ([0.0, 0.0, 1.0], Some([1.0; 3]), Some(2.0))
        );
        assert!(m[0].states_diffuse);
        assert_eq!(textures(&m[0]), [("diffuse", "a.png"), ("opacity", "c.png"), ("bump", "b.png")]);
    }

    #[test]
    fn a_transparency_of_one_means_opaque() {
        let (m, _) =
            parsed("newmtl a\nTr 1.000000\nnewmtl b\nTr 0\nnewmtl c\nTr 0.75\nnewmtl d\nd 0\nTr 1\n");
        assert_eq!(m.iter().map(|m| m.opacity).collect::<Vec<_>>(), [1.0, 1.0, 0.25, 0.0]);
    }

    #[test]
    fn all_textures_are_recorded() {
        let (m, w) = parsed(
            "newmtl a\nmap_Kd a.png\nmap_Bump -bm 0.5 b b.png\nrefl -type sphere c.png\nmap_d\nnorm d.png\n\
             map_Ks e.png\nmap_Ke f.png\nmap_Pr g.png\nmap_Pm h.png\nmap_Ka c.png\nmap_Tr i.png\ndisp j.png\n",
        );
        let drawn = [
            ("diffuse", "a.png"),
            ("specular", "e.png"),
            ("emissive", "f.png"),
            ("bump", "b b.png"),
            ("normal", "d.png"),
            ("roughness", "g.png"),
            ("metallic", "h.png"),
        ];
        assert_eq!((textures(&m[0]).as_slice(), w.len()), (drawn.as_slice(), 0));
        assert_eq!(m[0].other_textures, ["c.png", "i.png", "j.png"]);
        assert_eq!(m[0].texture_files().count(), 10);
    }

    #[test]
    fn of_several_textures_of_a_role_the_last_is_drawn() {
        let (m, _) = parsed("newmtl a\nmap_bump a.png\nbump a.png\nbump -bm 2 b.png\n");
        assert_eq!(
            m[0].textures.bump.as_ref().map(|t| (t.file.as_str(), t.bump_multiplier)),
            Some(("b.png", 2.0))
        );
        assert_eq!(m[0].other_textures, ["a.png"]);
    }

    #[test]
    fn broken_values_are_reported_once_and_change_nothing() {
        let (m, w) = parsed("Kd 1 1 1\nnewmtl a\nKd x 0 0\nKd nan 0 0\nd\nmap_Kd\n");
        assert_eq!(m[0], FileMaterial { name: "a".into(), ..FileMaterial::default() });
        assert_eq!(w.len(), 1);
        assert!(w[0].contains("line 1 of") && w[0].contains("4 more"), "{w:?}");
        let (m, w) = parsed("newmtl a\nNs -3\nKs 1 x\nNs inf\nKe\nPr nan\nPm rough\n");
        assert_eq!(m[0], FileMaterial { name: "a".into(), ..FileMaterial::default() });
        assert!(w[0].contains("line 2 of") && w[0].contains("5 more"), "{w:?}");
    }

    #[test]
    fn illumination_models_are_read() {
        let (m, w) = parsed("newmtl a\nillum 0\nnewmtl b\nillum 2\nillum 1\nnewmtl c\nIllum 9\nnewmtl d\n");
        assert_eq!(m.iter().map(|m| m.illumination).collect::<Vec<_>>(), [Some(0), Some(1), Some(9), None]);
        assert_eq!(w, [""; 0]);
        let (m, w) = parsed("illum 1\nnewmtl a\nillum 11\nillum -1\nillum 1.5\nillum\nillum phong\n");
        assert_eq!((m[0].illumination, w.len()), (None, 1));
        assert!(w[0].contains("line 1 of") && w[0].ends_with("and in 5 more"), "{w:?}");
    }

    #[test]
    fn what_is_not_applied_is_one_warning() {
        let (_, w) = parsed(
            "newmtl a\nKa 1 1 1\nNi 1.5\nTf 1 1 1\nPc 0\nmap_Kd -blendu on -boost 0 -type plane a.png\n# Tf\n\nPcr 0.03\n",
        );
        assert_eq!(w, [""; 0]);
        let (_, w) = parsed(
            "newmtl a\nTf 0.5 1 1\nTF 0.2\nd -halo 0.5\nnewmtl b\nPc 1\nillum 10\nmap_Kd -boost 2 -imfchan r a.png\n\
             map_Ks -boost 3 b.png\nglow \x1b[2J\n",
        );
        let names = "\"tf\", \"-halo\", \"pc\", \"illum 10\", \"-boost\", \"-imfchan\", \"glow\"";
        assert_eq!(w, [format!("did not apply of the material library \"a.mtl\": {names}")]);
        let many: String = ('a'..='z').map(|c| format!("{c}{c} 1\n")).collect();
        let (_, w) = parsed(&format!("newmtl a\n{many}"));
        assert!(w.len() == 1 && w[0].ends_with("\"gg\", \"hh\", …"), "{w:?}");
    }
}
