//! From world space to the picture in `f64`, in the same projection as the renderer's.

use glam::{DVec2, DVec3};
use tercio_raster::conventions::SUBPIXELS;
use tercio_raster::view::View;

/// A camera's projection. *Eye space* has x to the right, y downwards and z into the picture, relative to the eye, in world
/// units; the screen has pixels from the upper left corner of the picture. *Nearness* is a number that grows towards the eye
/// and is linear on the screen over any plane: 1 / z for a perspective camera, -z for an orthographic one.
#[derive(Clone, Debug)]
pub struct Eye {
    view: View,
    /// Where the line of sight meets the picture.
    middle: DVec2,
    /// Pixels per world unit, at distance 1 for a perspective camera.
    scale: f64,
    /// Where in eye space the meshes have their origin: at the eye, because errors are then relative to the distance from it;
    /// for an orthographic camera in the middle of the scene.
    origin: f64,
}

impl Eye {
    /// The projection of a view.
    pub fn new(view: View) -> Self {
        let subpixels = f64::from(SUBPIXELS);
        let middle = DVec2::new(f64::from(view.middle[0]), f64::from(view.middle[1])) / subpixels;
        let origin = if view.perspective { 0.0 } else { 0.5 * (view.near + view.far) };
        Self { middle, scale: view.scale / subpixels, origin, view }
    }

    /// The origin of meshes, in world space.
    pub fn origin(&self) -> DVec3 {
        self.view.eye + self.view.basis.forward * self.origin
    }

    /// A point of the world in eye space.
    pub fn eye_space(&self, world: DVec3) -> DVec3 {
        let (p, b) = (world - self.view.eye, &self.view.basis);
        DVec3::new(p.dot(b.right), -p.dot(b.up), p.dot(b.forward))
    }

    /// A point or direction in world axes, relative to [`Eye::origin`], from a point or direction in eye space relative to the same.
    pub fn world_axes(&self, p: DVec3) -> DVec3 {
        let b = &self.view.basis;
        b.right * p.x - b.up * p.y + b.forward * p.z
    }

    /// A point in front of the near plane on the screen.
    pub fn screen(&self, p: DVec3) -> DVec2 {
        let w = if self.view.perspective { p.z } else { 1.0 };
        self.middle + DVec2::new(p.x, p.y) * (self.scale / w)
    }

    /// The point of a place on the screen at a distance, in world axes relative to [`Eye::origin`].
    pub fn place(&self, screen: DVec2, z: f64) -> DVec3 {
        let at = (screen - self.middle) * self.pixel(z);
        self.world_axes(DVec3::new(at.x, at.y, z - self.origin))
    }

    /// World units per pixel at a distance.
    pub fn pixel(&self, z: f64) -> f64 {
        if self.view.perspective { z / self.scale } else { 1.0 / self.scale }
    }

    /// The nearness of a distance.
    pub fn nearness(&self, z: f64) -> f64 {
        if self.view.perspective { 1.0 / z } else { -z }
    }

    /// The distance of a nearness.
    pub fn distance(&self, nearness: f64) -> f64 {
        if self.view.perspective { 1.0 / nearness } else { -nearness }
    }

    /// Change of distance per change of nearness.
    pub fn distance_per_nearness(&self, z: f64) -> f64 {
        if self.view.perspective { -z * z } else { -1.0 }
    }

    /// The gradient on the screen of the nearness of a plane through a point; not finite if the plane is seen edge-on.
    pub fn slope(&self, normal: DVec3, point: DVec3) -> DVec2 {
        let across = DVec2::new(normal.x, normal.y) / self.scale;
        if self.view.perspective { across / normal.dot(point) } else { across / normal.z }
    }

    /// Positive if a point in eye space is on the side of `direction` of a line on the screen through a place.
    pub fn side(&self, direction: DVec2, through: DVec2, p: DVec3) -> f64 {
        let w = if self.view.perspective { p.z } else { 1.0 };
        self.scale * direction.dot(DVec2::new(p.x, p.y)) - w * direction.dot(through - self.middle)
    }

    /// The eye in world space.
    pub fn position(&self) -> DVec3 {
        self.view.eye
    }

    /// The size of the picture in pixels.
    pub fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.view.width), f64::from(self.view.height))
    }

    /// A point in eye space, in world axes relative to [`Eye::origin`].
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.world_axes(DVec3::new(p.x, p.y, p.z - self.origin))
    }

    /// The direction from a point in eye space to the viewer.
    pub fn to_viewer(&self, p: DVec3) -> DVec3 {
        if self.view.perspective { -p } else { DVec3::NEG_Z }
    }

    /// Is it a perspective camera?
    pub fn is_perspective(&self) -> bool {
        self.view.perspective
    }

    /// The distance at which the picture begins.
    pub fn near(&self) -> f64 {
        self.view.near * (1.0 + 1e-6)
    }

    /// How far a point in eye space is inside of the near plane, in world units, and of each border of the picture with so many
    /// pixels beside it, in pixels, times z for a perspective camera.
    pub(crate) fn inside(&self, p: DVec3, margin: f64) -> [f64; 5] {
        let (width, height) = (f64::from(self.view.width), f64::from(self.view.height));
        let w = if self.view.perspective { p.z } else { 1.0 };
        let (x, y) = (p.x * self.scale + self.middle.x * w, p.y * self.scale + self.middle.y * w);
        let beyond = margin * w;
        [p.z - self.near(), x + beyond, width * w - x + beyond, y + beyond, height * w - y + beyond]
    }

    /// The part of a segment in eye space that is in front of the near plane and less than `margin` pixels beside the picture.
    pub fn clip(&self, ends: [DVec3; 2], margin: f64) -> Option<[DVec3; 2]> {
        self.clip_shares(ends, margin).map(|shares| part(ends, shares))
    }

    /// The same as shares of the way from the first end to the second.
    pub fn clip_shares(&self, [p, q]: [DVec3; 2], margin: f64) -> Option<[f64; 2]> {
        let (a, b) = (self.inside(p, margin), self.inside(q, margin));
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for (a, b) in a.into_iter().zip(b) {
            match (a >= 0.0, b >= 0.0) {
                (true, true) => {}
                (false, true) => from = from.max(a / (a - b)),
                (true, false) => to = to.min(a / (a - b)),
                // Also where a coordinate is not finite.
                (false, false) => return None,
            }
        }
        (from <= to).then_some([from, to])
    }

    /// The error of depths by rounding, as a distance, at most.
    pub fn rounding(&self, z: f64) -> f64 {
        if self.view.perspective {
            z / f64::from(1 << 20)
        } else {
            (self.view.far - self.view.near) / f64::from(1 << 21)
        }
    }
}

/// The part of a segment between two shares of the way from its first end to the second.
pub fn part([p, q]: [DVec3; 2], shares: [f64; 2]) -> [DVec3; 2] {
    shares.map(|share| match share {
        share if share <= 0.0 => p,
        share if share >= 1.0 => q,
        share => p.lerp(q, share),
    })
}
