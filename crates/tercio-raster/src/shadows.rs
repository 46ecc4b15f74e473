//! Shadows: pictures of the scene's depth as seen from its lights.
//!
//! A point is lit if nothing is nearer to the light than the plane of its triangle, at each of 4 x 4 texels around it. The
//! plane, not the point, is compared, so that surfaces at an angle to the light do not shadow themselves, and the tolerance
//! can be as small as one texel: shadows begin where surfaces touch. The mean of the comparisons, weighted by their share of a
//! square of 3 x 3 texels around the point, makes the edge of the shadow smooth.
//!
//! Source of the plane: Isidoro, "Shadow mapping: GPU-based tips and techniques" (GDC 2006).

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use tercio_mesh::Aabb;
use tercio_scene::{Camera, Instance, Light, LightSpace, Projection, Scene};

use crate::error::RenderError;
use crate::frame::{Frame, Outputs};
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::shadow_map::{MadeFor, NearMaps, ShadowArea, ShadowMap, ShadowMaps, is_wide};
use crate::shadow_window::Window;
use crate::view::View;

/// Angle of view of a face of a point light's cube in degrees: more than 90, so that the texels around every point are in one
/// picture: a margin of two texels, as a face has at least 128.
const FACE_DEGREES: f64 = 92.0;

impl ShadowMaps {
    /// Default texels along the edge of a shadow map.
    pub const SIZE: u32 = 2048;

    /// Draws the shadow maps, each with `size` x `size` texels; those of a point light have half as many along an edge. `area` is what
    /// those of directional lights have.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn draw(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        (size, area): (u32, ShadowArea),
    ) -> Result<Self, RenderError> {
        let basis = camera.basis()?;
        let from_camera = |v: DVec3| basis.right * v.x + basis.up * v.y - basis.forward * v.z;
        let direction = |v: DVec3, space| match space {
            LightSpace::World => v.normalize_or_zero(),
            LightSpace::Camera => from_camera(v).normalize_or_zero(),
        };
        let place = |p: DVec3, space| match space {
            LightSpace::World => p,
            LightSpace::Camera => camera.eye + from_camera(p),
        };
        let casts = |instance: &&Instance| instance.surface.opacity >= 1.0;
        let casting = Scene {
            instances: scene.instances.iter().filter(casts).cloned().collect(),
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            ..Scene::default()
        };
        let outputs = Outputs { depth: true, ..Outputs::NONE };
        let picture = (settings.width, settings.height);
        let view = match area {
            ShadowArea::Scene => None,
            ShadowArea::Picture => Some(View::new(camera, &scene.bounds(), picture.0, picture.1)?),
        };
        let settings = Settings {
            outputs,
            cull: settings.cull,
            texture_filter: settings.texture_filter,
            layer_memory: settings.layer_memory,
            simd: settings.simd,
            ..Settings::one_sample(size, size)
        };
        let mut artist =
            Artist { scene: &casting, settings, renderer: Renderer::new(), frame: Frame::default() };
        let moves = |light: &Light| {
            matches!(
                light,
                Light::Directional { space: LightSpace::Camera, .. }
                    | Light::Point { space: LightSpace::Camera, .. }
                    | Light::Spot { space: LightSpace::Camera, .. }
            )
        };
        let (needs_camera, mut needs_picture) = (scene.lights.iter().any(moves), false);
        let mut maps = Self { distant: Vec::new(), near: Vec::new(), made_for: MadeFor::default() };
        for light in &scene.lights {
            match *light {
                Light::Ambient { .. } | Light::Wide { .. } => {}
                Light::Directional { to_light, space, .. } => {
                    let to_light = direction(to_light, space);
                    let (map, is_window) = artist.distant(&scene.bounds(), to_light, view.as_ref())?;
                    needs_picture |= is_window;
                    maps.distant.push(map);
                }
                Light::Point { position, space, .. } => {
                    maps.near.push(artist.cube(place(position, space))?);
                }
                Light::Spot { position, direction: towards, space, angle, .. } => {
                    let eye = place(position, space);
                    if is_wide(angle) {
                        maps.near.push(artist.cube(eye)?);
                        continue;
                    }
                    // With a margin of three texels for those around points at the edge.
                    let (sine, cosine) = tercio_mesh::trig::sin_cos(angle);
                    let margin = 6.0 * sine / (cosine * f64::from(size));
                    let face = artist.near(eye, direction(towards, space), 2.0 * (angle + margin))?;
                    maps.near.push(NearMaps { faces: vec![face] });
                }
            }
        }
        maps.made_for = MadeFor {
            lights: scene.lights.clone(),
            camera: (needs_camera || needs_picture).then_some(*camera),
            picture: needs_picture.then_some(picture),
        };
        Ok(maps)
    }
}

/// What draws shadow maps.
struct Artist<'a> {
    scene: &'a Scene,
    settings: Settings,
    renderer: Renderer,
    frame: Frame,
}

impl Artist<'_> {
    fn resize(&mut self, size: u32) {
        (self.settings.width, self.settings.height) = (size, size);
    }

    /// The map of a scene with these bounds, and whether it has no more than what `view` sees.
    fn distant(
        &mut self,
        bounds: &Aabb,
        to_light: DVec3,
        view: Option<&View>,
    ) -> Result<(ShadowMap, bool), RenderError> {
        let (target, radius) =
            if bounds.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), bounds.radius()) };
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let size = self.settings.width;
        let eye = target + to_light * (2.0 * radius);
        let basis = towards(eye, -to_light, Projection::Orthographic { height: 1.0 }).basis()?;
        let window = view.and_then(|view| Window::of(view, bounds, [basis.right, basis.up], size));
        let (center, half) = window.map_or((DVec2::ZERO, radius), |window| (window.center, window.half));
        // With a margin of a few texels around everything.
        let height = 2.0 * half * (1.0 + 8.0 / f64::from(size.max(16)));
        let projection = Projection::Orthographic { height };
        let eye = eye + basis.right * center.x + basis.up * center.y;
        Ok((self.draw(eye, -to_light, projection)?, window.is_some()))
    }

    /// The maps of a light that shines in all directions.
    fn cube(&mut self, eye: DVec3) -> Result<NearMaps, RenderError> {
        let size = self.settings.width;
        self.resize(ShadowMaps::size_of_face(size));
        let faces = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        let faces = faces.into_iter().map(|face| self.near(eye, face, FACE_DEGREES.to_radians()));
        let faces = faces.collect::<Result<_, _>>()?;
        self.resize(size);
        Ok(NearMaps { faces })
    }

    fn near(&mut self, eye: DVec3, towards: DVec3, fov_y: f64) -> Result<ShadowMap, RenderError> {
        self.draw(eye, towards, Projection::Perspective { fov_y })
    }

    fn draw(&mut self, eye: DVec3, towards: DVec3, projection: Projection) -> Result<ShadowMap, RenderError> {
        let camera = self::towards(eye, towards, projection);
        let size = self.settings.width;
        let basis = camera.basis()?;
        let bounds = self.scene.bounds();
        let view = View::new(&camera, &bounds, size, size)?;
        self.renderer.render_into(self.scene, &camera, &self.settings, &mut self.frame)?;
        let perspective = view.perspective;
        let nearness = |&distance: &f32| if perspective { 1.0 / distance } else { -distance };
        Ok(ShadowMap {
            eye,
            axes: [basis.right, -basis.up, basis.forward],
            perspective,
            scale: view.scale / f64::from(crate::conventions::SUBPIXELS),
            size,
            nearness: self.frame.planes.depth.par_iter().with_min_len(1 << 14).map(nearness).collect(),
        })
    }
}

/// The camera of a light that looks along a direction.
fn towards(eye: DVec3, direction: DVec3, projection: Projection) -> Camera {
    const FAR: f64 = (1u64 << 20) as f64;
    let up = if direction.y.abs() < 0.9 { DVec3::Y } else { DVec3::Z };
    // So far out, the direction to a point at a distance of 1 is rounded by more than a texel, or the point is the same one.
    let place = eye.abs().max_element();
    let distance = if place < FAR { 1.0 } else { place * 1e-4 };
    Camera { eye, target: eye + direction * distance, up, projection, near: None, shift: [0.0; 2] }
}
