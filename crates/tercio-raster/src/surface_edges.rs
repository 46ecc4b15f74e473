//! What reference and kernels share of lines along the sides of triangles.

use glam::DVec3;
use tercio_mesh::edges::{Beyond, place};
use tercio_scene::{Scene, SurfaceEdges};

use crate::conventions::SUBPIXELS;
use crate::error::RenderError;
use crate::sampling::SampleShading;
use crate::settings::Settings;

/// Pixels per sub-pixel.
pub const PIXELS: f32 = 1.0 / SUBPIXELS as f32;

/// The part of the picture whose colour a shaded point has, as an extent in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// Of a point in the middle of a pixel, or of a sample.
    pub size: f32,
    /// By how much it is smaller for each sub-pixel between the point and the middle of the pixel: on both sides.
    pub shrinking: f32,
    /// The least extent.
    pub least: f32,
}

impl Footprint {
    /// For these settings; `distance` of the points at which a surface is shaded, in sub-pixels.
    pub fn new(settings: &Settings, distance: f32) -> Self {
        let shrinking = match settings.sampling.shading {
            SampleShading::Pixel => 2.0 * PIXELS,
            SampleShading::Sample => 0.0,
        };
        Self { size: distance * PIXELS, shrinking, least: 0.125 }
    }
}

/// Fails if lines along the sides of triangles have no width, no finite colour, or are not those of their mesh.
///
/// # Errors
/// [`RenderError::Setting`].
pub fn check_edges(scene: &Scene) -> Result<(), RenderError> {
    for instance in &scene.instances {
        let Some(edges) = instance.edges.as_deref() else { continue };
        let fail =
            |what, range: &str, value: String| Err(RenderError::Setting { what, range: range.into(), value });
        if !(edges.width > 0.0 && edges.width.is_finite()) {
            return fail("width of edges", "above 0 and finite", edges.width.to_string());
        }
        if let Some(c) = edges.color.iter().find(|c| !(0.0..=1.0).contains(*c)) {
            return fail("colour of edges", "0 to 1", c.to_string());
        }
        if !(0.0..=1.0).contains(&edges.opacity) {
            return fail("opacity of edges", "0 to 1", edges.opacity.to_string());
        }
        let triangles = instance.mesh.triangle_count();
        let lengths = [edges.sides.as_ref().map(Vec::len), edges.beyond.triangles()];
        for length in lengths.into_iter().flatten() {
            if length != triangles || instance.share.is_some() {
                let range = format!("{triangles}, the triangles of a whole mesh");
                return fail("number of triangles with edges", &range, length.to_string());
            }
        }
        let places = edges.beyond.numbers();
        // Bits of numbers are in the order of the numbers, those with a sign above all others. This is quick, and nearly always all.
        let greatest = places.iter().map(|place| place.to_bits()).fold(0, u32::max);
        let most = Beyond::MOST as f32;
        let is_wrong = |place: &&f32| !(**place >= 0.0 && **place <= most);
        if greatest > most.to_bits()
            && let Some(place) = places.iter().find(is_wrong)
        {
            return fail("place of an edge beyond a side", &format!("0 to {most}"), place.to_string());
        }
    }
    Ok(())
}

/// By how many sub-pixels the far end of an edge may be on the wrong side of the side that it is beyond: corners in the middle of a side are
/// snapped to either.
pub const SNAPPED: f32 = 2.0;

/// The line that is nearest to a point. The kernels do the same lane by lane.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Its distance in sub-pixels.
    pub distance: f32,
    /// How far the point is from the middle of the pixel across it.
    pub across: f32,
}

impl Nearest {
    /// No line.
    pub const NONE: Self = Self { distance: f32::INFINITY, across: 0.0 };

    /// Adds a line, given by the value of its edge function and the changes of this to the right and downwards; the point is so far from
    /// the middle of the pixel.
    pub fn add(&mut self, [value, right, down]: [f32; 3], [x, y]: [f32; 2]) {
        let inverse = 1.0 / (right * right + down * down).sqrt();
        let across = (x * right + y * down).abs() * inverse;
        self.take(Self { distance: value.abs() * inverse, across });
    }

    /// The nearer one of both; this one if they are as near.
    pub fn take(&mut self, other: Self) {
        if other.distance < self.distance {
            *self = other;
        }
    }
}

/// Of the lines to far ends ([`Beyond::Quadrilaterals`], [`Beyond::Ends`]) of a triangle that is clipped, the nearest one to a point. `sides` are those with lines of their own, `positions` its
/// corners; `area` are barycentric coordinates, followed by their slopes.
pub fn nearest_of_clipped(
    edges: &SurfaceEdges,
    (triangle, sides): (usize, u8),
    positions: [[f32; 3]; 3],
    [area, right, down]: [[f32; 3]; 3],
    from_middle: [f32; 2],
) -> Nearest {
    let mut nearest = Nearest::NONE;
    let at = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let mut to_far_end = |side: usize, end: usize, far: [f32; 3]| {
        let [pivot, beside] = [end, 1 - end].map(|end| (side + 1 + end) % 3);
        let [from, other, apex] = [pivot, beside, side].map(|corner| at(positions[corner]));
        let Some(place) = place(from, other, apex, at(far)).filter(|place| *place > 0.0) else { return };
        let of = |v: [f32; 3]| v[side] * place + v[beside];
        nearest.add([of(area), of(right), of(down)], from_middle);
    };
    match &edges.beyond {
        Beyond::Nothing | Beyond::Polygons(_) => {}
        Beyond::Quadrilaterals(fourth) => {
            if let Some(position) = fourth.of(triangle) {
                (0..2).for_each(|end| to_far_end(apex_of(sides), end, position));
            }
        }
        Beyond::Ends(ends) => {
            ends.of(triangle).for_each(|far| to_far_end(far.side.into(), far.end.into(), far.position));
        }
    }
    nearest
}

/// Of half a quadrilateral, the number of the corner that is opposite to its diagonal: the only side without a line.
#[inline(always)]
pub fn apex_of(sides: u8) -> usize {
    (!sides & SurfaceEdges::ALL).trailing_zeros().min(2) as usize
}
