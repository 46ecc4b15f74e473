//! The reference formulas for materials: what their textures make of them at a point, and the light that they reflect.

use tercio_mesh::Mesh;
use tercio_scene::{AlphaMode, Instance, Material, Scene, TextureMap};

use super::shading::{Vec3, dot, each, normalize, polynomial, wide};
use super::texture::{TexturePoint, sample};
use crate::conventions::{DIELECTRIC, LEAST_ROUGHNESS};
use crate::lighting::LightRig;
use crate::settings::TextureFilter;
use crate::shadow_map::LightNumber;

/// A material at a point.
pub struct Evaluated {
    pub albedo: Vec3,
    pub alpha: f32,
    pub specular: Vec3,
    pub shininess_log2: u32,
    pub roughness: f32,
    pub metallic: f32,
    pub emissive: Vec3,
    pub occlusion: f32,
    /// The normal in tangent space, if there is a texture of it.
    pub normal: Option<Vec3>,
}

/// The material of a triangle.
pub fn material_of(scene: &Scene, instance: &Instance, mesh: &Mesh, triangle: usize) -> Material {
    let of_triangle = mesh.triangle_materials.as_ref().map_or(Mesh::NO_MATERIAL, |m| m[triangle]);
    let uses_own = instance.uses_mesh_colors();
    let number = instance.materials.as_ref().filter(|_| uses_own).and_then(|m| m.of_triangle(of_triangle));
    match number {
        Some(number) => scene.materials[number as usize].clone(),
        None => Material::of_surface(&instance.surface),
    }
}

/// Evaluates a material at a point. `point` is `None` if the mesh has no texture coordinates: then there are no textures.
/// `own` is the colour and alpha of the mesh, if it has colours, which override the material's. A texture overrides the colour, not its
/// alpha.
pub fn evaluate(
    scene: &Scene,
    material: &Material,
    filter: TextureFilter,
    point: Option<&TexturePoint>,
    own: Option<(Vec3, f32)>,
) -> Evaluated {
    let map = |map: &Option<TextureMap>| -> Option<([f32; 4], bool)> {
        let (map, point) = (map.as_ref()?, point?);
        let texture = &scene.textures[map.texture as usize];
        Some((sample(texture, map, filter, point), texture.is_opaque()))
    };
    let times = |color: Vec3, map: Option<([f32; 4], bool)>| match map {
        Some(([r, g, b, _], _)) => [color[0] * r, color[1] * g, color[2] * b],
        None => color,
    };
    let opacity = if material.opacity < 1.0 { material.opacity.max(0.0) } else { 1.0 };
    let (mut albedo, mut alpha) = (material.base_color, opacity);
    if let Some((_, own_alpha)) = own {
        alpha *= own_alpha;
    }
    match (map(&material.base_color_map), own) {
        (Some(([r, g, b, a], is_opaque)), _) => {
            let straight = |c: f32| match a {
                _ if is_opaque => c,
                0.0 => 0.0,
                a => c / a,
            };
            albedo = [albedo[0] * straight(r), albedo[1] * straight(g), albedo[2] * straight(b)];
            alpha = if is_opaque { alpha } else { alpha * a };
        }
        (None, Some((color, _))) => albedo = color,
        (None, None) => {}
    }
    if let Some(([share, ..], _)) = map(&material.opacity_map) {
        alpha *= share;
    }
    alpha = match material.alpha_mode {
        AlphaMode::Blend => alpha.min(1.0),
        AlphaMode::Cutout(least) => f32::from(u8::from(alpha >= least)),
        AlphaMode::Opaque => 1.0,
    };
    Evaluated {
        albedo,
        alpha,
        specular: times(material.specular, map(&material.specular_map)),
        shininess_log2: material.shininess_log2,
        roughness: map(&material.roughness_map).map_or(1.0, |(c, _)| c[1]) * material.roughness,
        metallic: map(&material.metallic_map).map_or(1.0, |(c, _)| c[2]) * material.metallic,
        emissive: times(material.emissive, map(&material.emissive_map)),
        occlusion: map(&material.occlusion_map).map_or(1.0, |(c, _)| c[0]),
        normal: map(&material.normal_map).map(|([x, y, z, _], _)| {
            let signed = |c: f32| c * 2.0 - 1.0;
            [signed(x) * material.normal_scale, signed(y) * material.normal_scale, signed(z)]
        }),
    }
}

/// The normal that a normal in tangent space stands for. `edges` are those from the first corner to the others in world
/// space, `uv` their texture coordinates; neither needs a unit.
pub fn bumped(normal: Vec3, edges: [Vec3; 2], uv: [[f32; 2]; 2], tangent: Vec3) -> Vec3 {
    let [[u1, v1], [u2, v2]] = uv;
    let sign = if u1 * v2 - u2 * v1 < 0.0 { -1.0 } else { 1.0 };
    let along_u = each(|k| (edges[0][k] * v2 - edges[1][k] * v1) * sign);
    let along_v = each(|k| (edges[1][k] * u1 - edges[0][k] * u2) * sign);
    let axis = |v: Vec3| {
        let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
        let v = if largest > 0.0 { v.map(|c| c / largest) } else { [0.0; 3] };
        let out = dot(normal, v);
        normalize(each(|k| v[k] - normal[k] * out), [0.0; 3])
    };
    let (along_u, along_v) = (axis(along_u), axis(along_v));
    let bumped = each(|k| (along_u[k] * tangent[0] + along_v[k] * tangent[1]) + normal[k] * tangent[2]);
    normalize(bumped, normal)
}

/// A light as seen from a point.
pub struct Seen {
    to_light: Vec3,
    color: Vec3,
    /// Its highlight fades with the cosine.
    is_wide: bool,
    /// The share that reaches the point.
    share: f32,
}

/// All lights as seen from a point, relative to the eye; `lit` is the share of a light that is not in shadow.
pub fn lights(rig: &LightRig, position: Vec3, lit: impl Fn(LightNumber) -> f32) -> Vec<Seen> {
    let mut seen = Vec::new();
    for (number, l) in rig.distant.iter().enumerate() {
        let share = lit(LightNumber::Distant(number));
        seen.push(Seen { to_light: l.to_light, color: l.color, is_wide: false, share });
    }
    for (number, l) in rig.near.iter().enumerate() {
        let to_light = normalize(each(|k| l.position[k] - position[k]), rig.sight.base);
        let in_cone = l.cone.map_or(1.0, |cone| {
            let inside = ((dot(to_light, cone.to_light) - cone.edge) / cone.fade).clamp(0.0, 1.0);
            (inside * inside) * (3.0 - 2.0 * inside)
        });
        let share = lit(LightNumber::Near(number)) * in_cone;
        seen.push(Seen { to_light, color: l.color, is_wide: false, share });
    }
    for l in &rig.highlights {
        seen.push(Seen {
            to_light: l.to_light,
            color: l.color,
            is_wide: true,
            share: lit(LightNumber::Wide),
        });
    }
    seen
}

/// The light of Phong shading.
pub fn phong(rig: &LightRig, lights: &[Seen], m: &Evaluated, normal: Vec3, to_viewer: Vec3) -> Vec3 {
    let mut diffuse = wide(rig, normal).map(|c| c * m.occlusion);
    let mut specular = [0.0; 3];
    for &Seen { to_light, color, is_wide, share } in lights {
        let cosine = dot(normal, to_light);
        if !(cosine > 0.0) {
            continue;
        }
        if !is_wide {
            diffuse = each(|k| diffuse[k] + (cosine * share) * color[k]);
        }
        let half = normalize(each(|k| to_light[k] + to_viewer[k]), rig.sight.base);
        let mut power = dot(normal, half);
        power = if power > 0.0 { power } else { 0.0 };
        (0..m.shininess_log2).for_each(|_| power *= power);
        let strength = if is_wide { power * cosine } else { power * share };
        specular = each(|k| specular[k] + (strength * m.specular[k]) * color[k]);
    }
    each(|k| (m.albedo[k] * diffuse[k] + specular[k]) + m.emissive[k])
}

/// The light of physically based shading: Lambert's diffuse reflection below a specular one of microfacets with the
/// distribution of Trowbridge and Reitz (GGX).
///
/// Sources: Walter et al., "Microfacet models for refraction through rough surfaces" (2007); Schlick's Fresnel term (1994);
/// the masking of Hammon, "PBR diffuse lighting for GGX+Smith microsurfaces" (2017); Lagarde's Fresnel term for ambient
/// light (2011).
pub fn physical(rig: &LightRig, lights: &[Seen], m: &Evaluated, normal: Vec3, to_viewer: Vec3) -> Vec3 {
    let base = each(|k| (m.albedo[k] - DIELECTRIC) * m.metallic + DIELECTRIC);
    let diffuse_color = m.albedo.map(|c| c * (1.0 - m.metallic));
    let roughness = m.roughness.clamp(LEAST_ROUGHNESS, 1.0);
    let a = roughness * roughness;
    let facing = unit_share(dot(normal, to_viewer));
    let grazing = fifth(1.0 - facing);
    // Ambient light: what comes from the direction of the mirror image, as blurred as the wide lights are.
    let mirrored = each(|k| normal[k] * (2.0 * facing) - to_viewer[k]);
    let mut reflected = polynomial(&rig.mirrored, mirrored);
    if let Some(environment) = &rig.environment {
        let more = environment.mirrored(mirrored, roughness);
        reflected = each(|k| reflected[k] + more[k]);
    }
    let irradiance = wide(rig, normal);
    let mut sum = each(|k| {
        let limit = (1.0 - roughness).max(base[k]);
        let fresnel = base[k] + (limit - base[k]) * grazing;
        ((diffuse_color[k] * (1.0 - fresnel)) * irradiance[k] + fresnel * reflected[k]) * m.occlusion
    });
    for &Seen { to_light, color, is_wide, share } in lights {
        let cosine = dot(normal, to_light).min(1.0);
        if !(cosine > 0.0) {
            continue;
        }
        let half = normalize(each(|k| to_light[k] + to_viewer[k]), rig.sight.base);
        let (nh, vh) = (unit_share(dot(normal, half)), unit_share(dot(to_viewer, half)));
        let grazing = fifth(1.0 - vh);
        let spread = (nh * nh) * (a * a - 1.0) + 1.0;
        let together = (cosine * facing) * 2.0;
        let apart = cosine + facing;
        let masking = 0.5 / (together + (apart - together) * a);
        let lobe = ((a * a) / (spread * spread)) * masking;
        // The highlight of a wide light fades with the cosine once more; its diffuse light is part of the ambient light.
        let strength = if is_wide { cosine * cosine } else { cosine * share };
        sum = each(|k| {
            let fresnel = base[k] + (1.0 - base[k]) * grazing;
            let below = if is_wide { 0.0 } else { diffuse_color[k] * (1.0 - fresnel) };
            sum[k] + ((below + fresnel * lobe) * strength) * color[k]
        });
    }
    each(|k| sum[k] + m.emissive[k])
}

/// A number that is 0 where it is not above 0, and at most 1.
fn unit_share(c: f32) -> f32 {
    if c > 0.0 { c.min(1.0) } else { 0.0 }
}

fn fifth(x: f32) -> f32 {
    let square = x * x;
    (square * square) * x
}
