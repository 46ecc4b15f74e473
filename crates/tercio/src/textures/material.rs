//! From a material as its file states it to what a renderer draws.

use tercio_mesh::{FileMaterial, FileTexture, TextureRole};
use tercio_scene::{AlphaMode, Material, Surface, TextureMap, Wrap, srgb_to_linear};

use super::TextureOptions;

/// Exponent of highlights if a file states only their colour: that of [`Surface`].
const SHININESS: f32 = 32.0;

/// Most by which slopes are multiplied: the renderer's limit.
const STEEPEST: f32 = 1e6;

/// The textures of a material, by their numbers in the scene.
#[derive(Debug, Default)]
pub struct Maps {
    numbers: [Option<u32>; TextureRole::ALL.len()],
    /// Whether the opacity is not the same everywhere.
    pub has_alpha: bool,
    /// Whether the material emits its diffuse colour and reflects nothing.
    pub is_unlit: bool,
}

impl Maps {
    pub fn get(&self, role: TextureRole) -> Option<u32> {
        self.numbers[role as usize]
    }

    pub fn set(&mut self, role: TextureRole, number: u32) {
        self.numbers[role as usize] = Some(number);
    }
}

/// Does a material state anything besides a plain colour, its opacity and textures?
pub fn states_more_than_a_colour(file: &FileMaterial) -> bool {
    file.specular.is_some()
        || file.shininess.is_some()
        || file.roughness.is_some()
        || file.metallic.is_some()
        || file.emissive != [0.0; 3]
        || matches!(file.illumination, Some(0 | 1))
}

/// The colour and opacity of a material alone.
pub fn plain(file: &FileMaterial) -> FileMaterial {
    let FileMaterial { ref name, diffuse, states_diffuse, opacity, .. } = *file;
    FileMaterial { name: name.clone(), diffuse, states_diffuse, opacity, ..FileMaterial::default() }
}

/// Is a material a colour without light?
pub fn is_unlit(file: &FileMaterial, options: &TextureOptions) -> bool {
    file.illumination == Some(0) && !options.is_unlit
}

/// The texture of a material in a role. One without light emits its diffuse texture, whose alpha still is that of the
/// diffuse colour; its other textures have no effect.
pub fn texture<'m>(
    file: &'m FileMaterial,
    role: TextureRole,
    options: &TextureOptions,
) -> Option<&'m FileTexture> {
    match role {
        TextureRole::Specular if file.illumination == Some(1) => None,
        _ if !is_unlit(file, options) => file.textures.get(role),
        TextureRole::Diffuse | TextureRole::Emissive => file.textures.diffuse.as_ref(),
        TextureRole::Opacity => file.textures.opacity.as_ref(),
        _ => None,
    }
}

/// Converts a material.
///
/// Colours are taken as sRGB. A texture multiplies what the file states beside it, as the manual of MTL says of `Kd` and
/// `Ks`. For the statements that programs have added it says nothing; there, a zero beside a texture, which exporters write
/// for "not stated", counts as one.
pub fn convert(file: &FileMaterial, maps: &Maps, surface: &Surface, options: &TextureOptions) -> Material {
    let map = |role| Some(texture_map(texture(file, role, options)?, maps.get(role)?));
    let [
        base_color_map,
        opacity_map,
        specular_map,
        emissive_map,
        bump_map,
        normal_map,
        roughness_map,
        metallic_map,
    ] = TextureRole::ALL.map(map);
    let is_textured = base_color_map.is_some() && !file.states_diffuse;
    let base_color = if is_textured { [1.0; 3] } else { file.diffuse.map(linear_level) };
    let roughness = file.roughness.unwrap_or_else(|| match file.shininess {
        // Walter and others, Microfacet Models for Refraction, 2007: the exponent of the lobe that is as wide, for the
        // square of the roughness.
        Some(exponent) => (2.0 / (exponent + 2.0)).sqrt().sqrt(),
        // Without highlights.
        None if file.illumination == Some(1) => 1.0,
        None => surface.roughness,
    });
    let unless_zero =
        |factor: f32, is_textured: bool| if is_textured && factor == 0.0 { 1.0 } else { factor };
    let has_emission = file.emissive != [0.0; 3];
    let bumps = normal_map.is_none().then_some(file.textures.bump.as_ref()).flatten();
    let scaled = file.textures.normal.as_ref().filter(|_| normal_map.is_some()).or(bumps);
    let material = Material {
        base_color,
        base_color_map,
        // A NaN draws nothing less opaque.
        opacity: if file.opacity < 1.0 { file.opacity.max(0.0) } else { 1.0 },
        opacity_map,
        alpha_mode: match options.alpha_mode {
            AlphaMode::Cutout(least) if maps.has_alpha => AlphaMode::Cutout(least),
            _ => AlphaMode::Blend,
        },
        specular: specular(file, specular_map.is_some(), surface, options),
        specular_map,
        shininess_log2: file.shininess.map_or(surface.shininess_log2, rounded_log2),
        roughness: match file.roughness {
            None if roughness_map.is_some() => 1.0,
            _ => unless_zero(roughness, roughness_map.is_some()),
        },
        roughness_map,
        metallic: unless_zero(file.metallic.unwrap_or(surface.metallic), metallic_map.is_some()),
        metallic_map,
        emissive: if emissive_map.is_some() && !has_emission { [1.0; 3] } else { emissive(file.emissive) },
        emissive_map,
        normal_map: normal_map.or(bump_map),
        normal_scale: scaled.map_or(1.0, |t| (t.bump_multiplier * t.gain).clamp(-STEEPEST, STEEPEST)),
        occlusion_map: None,
    };
    if maps.is_unlit { unlit(material) } else { material }
}

/// The material that emits the diffuse colour of another and reflects nothing: in physically based shading, that is a black
/// metal.
fn unlit(material: Material) -> Material {
    Material {
        base_color: [0.0; 3],
        specular: [0.0; 3],
        roughness: 1.0,
        metallic: 1.0,
        emissive: material.base_color,
        ..material
    }
}

/// Options of MTL in terms of the scene: coordinates are multiplied by the scale, then the offset is added.
fn texture_map(file: &FileTexture, texture: u32) -> TextureMap {
    let wrap = if file.clamp { Wrap::Clamp } else { Wrap::Repeat };
    TextureMap { texture, wrap: [wrap; 2], scale: file.scale, offset: file.offset }
}

/// Linear light of a component of the diffuse colour, rounded to 8 bits first: as the renderer does with materials that are
/// plain colours, so that a material has the same colour with and without textures elsewhere in the model.
fn linear_level(component: f32) -> f32 {
    let level = (component.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    srgb_to_linear(f64::from(level) / 255.0) as f32
}

fn linear(component: f32) -> f32 {
    srgb_to_linear(f64::from(component)) as f32
}

/// Colour of the highlight.
///
/// `Ks` is a share of the light, spread over a lobe that is narrower with a larger exponent n. A lobe that reflects the same
/// light is brighter in proportion to n + 8, as in the normalised lobe of Blinn and Phong. White, which exporters write for
/// everything that is glossy, is 0.4 from the exponent 32 on, twice the default of [`Surface`]: more would be cut off in
/// the picture. Wide lobes are weaker, by a factor of five at most, so that they do not cover the whole surface with haze.
fn specular(file: &FileMaterial, has_map: bool, surface: &Surface, options: &TextureOptions) -> [f32; 3] {
    if let Some(strength) = options.specular {
        return [strength; 3];
    }
    if file.illumination == Some(1) {
        return [0.0; 3];
    }
    let stated = file.specular.or(has_map.then_some([1.0; 3]));
    let lobe = ((file.shininess.unwrap_or(SHININESS) + 8.0) / 40.0).clamp(0.2, 1.0);
    stated.map_or([surface.specular; 3], |color| color.map(|c| 0.4 * linear(c) * lobe))
}

/// log2 of the exponent, rounded, 0 to 10; by comparisons, which are the same on every machine.
fn rounded_log2(exponent: f32) -> u32 {
    let half_way = |power: u32| (1 << power) as f32 * std::f32::consts::SQRT_2;
    (0..10).filter(|&power| exponent >= half_way(power)).count() as u32
}

/// Linear light of an emitted colour, which is proportional to the brightness above 1.
fn emissive(color: [f32; 3]) -> [f32; 3] {
    let brightness = color.into_iter().fold(1.0, f32::max);
    color.map(|c| brightness * linear(c / brightness))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(file: &FileMaterial, roles: &[TextureRole]) -> Material {
        let mut maps = Maps::default();
        let mut file = file.clone();
        maps.is_unlit = file.illumination == Some(0);
        for (number, &role) in roles.iter().enumerate() {
            file.textures.get_mut(role).get_or_insert_with(|| FileTexture::new("a.png"));
            maps.set(role, number as u32);
        }
        convert(&file, &maps, &Surface::default(), &TextureOptions::default())
    }

    #[test]
    fn a_plain_colour_is_the_default_material_in_that_colour() {
        let file = FileMaterial { diffuse: [0.5, 1.0, 0.0], opacity: 0.25, ..FileMaterial::default() };
        let base_color = [srgb_to_linear(128.0 / 255.0) as f32, 1.0, 0.0];
        assert_eq!(converted(&file, &[]), Material { base_color, opacity: 0.25, ..Material::default() });
        assert!(!states_more_than_a_colour(&file));
    }

    #[test]
    fn textures_multiply_what_is_stated() {
        let stated =
            FileMaterial { states_diffuse: true, diffuse: [0.0, 0.5, 1.0], ..FileMaterial::default() };
        let [black, grey, white] = converted(&stated, &[TextureRole::Diffuse]).base_color;
        assert!(black == 0.0 && (0.2..0.22).contains(&grey) && white == 1.0);
        assert_eq!(converted(&FileMaterial::default(), &[TextureRole::Diffuse]).base_color, [1.0; 3]);
        let all = converted(
            &FileMaterial { metallic: Some(0.0), ..FileMaterial::default() },
            &[TextureRole::Emissive, TextureRole::Roughness, TextureRole::Metallic],
        );
        assert_eq!((all.emissive, all.roughness, all.metallic), ([1.0; 3], 1.0, 1.0));
        assert_eq!(all.metallic_map.map(|map| map.texture), Some(2));
        let half = FileMaterial { roughness: Some(0.5), ..FileMaterial::default() };
        assert_eq!(converted(&half, &[TextureRole::Roughness]).roughness, 0.5);
    }

    #[test]
    fn options_of_textures_are_kept() {
        let mut file = FileMaterial::default();
        let texture = FileTexture {
            clamp: true,
            offset: [0.5, 0.25],
            scale: [2.0, -1.0],
            bump_multiplier: 0.2,
            gain: 1.5,
            ..FileTexture::new("a.png")
        };
        (file.textures.diffuse, file.textures.bump) = (Some(texture.clone()), Some(texture));
        let material = converted(&file, &[TextureRole::Diffuse, TextureRole::Bump]);
        let map = TextureMap { texture: 0, wrap: [Wrap::Clamp; 2], scale: [2.0, -1.0], offset: [0.5, 0.25] };
        assert_eq!(material.base_color_map, Some(map));
        assert_eq!((material.normal_map.map(|map| map.texture), material.normal_scale), (Some(1), 0.2 * 1.5));
        let both = converted(&file, &[TextureRole::Bump, TextureRole::Normal]);
        assert_eq!((both.normal_map.map(|map| map.texture), both.normal_scale), (Some(1), 1.0));
    }

    #[test]
    fn highlights_are_as_strong_as_their_lobe_is_narrow() {
        let with = |specular, shininess| {
            let material = converted(&FileMaterial { specular, shininess, ..FileMaterial::default() }, &[]);
            (material.specular[0], material.shininess_log2)
        };
        let white = Some([1.0; 3]);
        assert_eq!(with(None, None), (Surface::default().specular, 5));
        assert_eq!(with(white, None), (0.4, 5));
        assert_eq!(with(white, Some(1000.0)), (0.4, 10));
        assert_eq!(with(white, Some(12.0)), (0.2, 4));
        assert_eq!(with(white, Some(0.0)), (0.4 * 0.2, 0));
        assert_eq!(with(Some([0.0; 3]), Some(32.0)), (0.0, 5));
        assert_eq!(with(None, Some(4.0)), (Surface::default().specular, 2));
        let overridden = TextureOptions { specular: Some(0.0), ..TextureOptions::default() };
        let file = FileMaterial { specular: white, ..FileMaterial::default() };
        assert_eq!(convert(&file, &Maps::default(), &Surface::default(), &overridden).specular, [0.0; 3]);
    }

    #[test]
    fn illumination_models_say_what_is_reflected() {
        let file = |illumination| FileMaterial {
            illumination: Some(illumination),
            diffuse: [1.0, 0.0, 1.0],
            specular: Some([1.0; 3]),
            emissive: [0.5; 3],
            ..FileMaterial::default()
        };
        let unlit = converted(&file(0), &[TextureRole::Diffuse, TextureRole::Bump]);
        assert_eq!((unlit.base_color, unlit.specular, unlit.emissive), ([0.0; 3], [0.0; 3], [1.0; 3]));
        assert!(unlit.base_color_map.is_some() && unlit.normal_map.is_none());
        assert_eq!((unlit.metallic, unlit.roughness), (1.0, 1.0));
        assert_eq!(converted(&file(0), &[]).emissive, [1.0, 0.0, 1.0]);
        let dull = converted(&file(1), &[]);
        assert_eq!((dull.specular, dull.roughness, dull.base_color), ([0.0; 3], 1.0, [1.0, 0.0, 1.0]));
        let usual = FileMaterial { illumination: None, ..file(2) };
        for illumination in 2..=10 {
            assert_eq!(converted(&file(illumination), &[]), converted(&usual, &[]));
        }
        assert!(states_more_than_a_colour(&FileMaterial {
            illumination: Some(1),
            ..FileMaterial::default()
        }));
        assert!(!states_more_than_a_colour(&FileMaterial {
            illumination: Some(2),
            ..FileMaterial::default()
        }));
        // Where everything is unlit, it is a material like the others.
        let options = TextureOptions { is_unlit: true, ..TextureOptions::default() };
        assert_eq!(texture(&file(0), TextureRole::Emissive, &options), None);
        assert!(!is_unlit(&file(0), &options));
    }

    #[test]
    fn exponents_are_rounded_in_their_logarithm() {
        let expected = [(0.0, 0), (1.0, 0), (1.42, 1), (2.82, 1), (2.83, 2), (96.0, 7), (90.0, 6), (1e9, 10)];
        expected.iter().for_each(|&(exponent, log2)| assert_eq!(rounded_log2(exponent), log2, "{exponent}"));
    }

    #[test]
    fn roughness_follows_the_exponent_unless_it_is_stated() {
        let with = |shininess, roughness| {
            converted(&FileMaterial { shininess, roughness, ..FileMaterial::default() }, &[]).roughness
        };
        assert_eq!(
            [with(None, None), with(Some(6.0), None), with(Some(0.0), None)],
            [0.5, 0.5f32.sqrt(), 1.0]
        );
        assert_eq!(with(Some(6.0), Some(0.0)), 0.0);
    }

    #[test]
    fn light_sources_may_be_brighter_than_white() {
        assert_eq!(emissive([4.0, 0.0, 4.0]), [4.0, 0.0, 4.0]);
        assert_eq!(emissive([0.5, 0.0, 1.0]), [linear(0.5), 0.0, 1.0]);
    }
}
