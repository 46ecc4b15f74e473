//! What the camera frames: the instances of all models, whole models of which a part is drawn, and lines and points.

use std::borrow::Cow;

use tercio::glam::{DAffine3, DMat3, DVec3};
use tercio::mesh::Aabb;
use tercio::parallel::Communicator;
use tercio::parallel::comm::CommError;
use tercio::parallel::comm::collective::all_max;
use tercio::scene::Instance;
use tercio::scene::framing::{Extent, Outline};

/// Everything that is framed.
#[derive(Default)]
pub(super) struct Subject<'a> {
    pieces: Vec<Piece<'a>>,
}

/// What is around a piece, in world units: the radius of its points, half the width of its lines.
type Margin = f64;

enum Piece<'a> {
    Instance(&'a Instance, Margin),
    /// At a place in the world.
    Extent(Cow<'a, Extent>, DAffine3, Margin),
    /// Models of other pictures.
    Outline(&'a Outline),
}

impl<'a> Subject<'a> {
    /// Adds an instance.
    pub fn add_instance(&mut self, instance: &'a Instance, margin: Margin) {
        self.pieces.push(Piece::Instance(instance, margin));
    }

    /// Adds an extent at a place.
    pub fn add_extent(&mut self, extent: Cow<'a, Extent>, world_from_object: DAffine3, margin: Margin) {
        self.pieces.push(Piece::Extent(extent, world_from_object, margin));
    }

    /// Adds the models of other pictures.
    pub fn add_outline(&mut self, outline: &'a Outline) {
        self.pieces.push(Piece::Outline(outline));
    }

    /// Its outline, for other pictures.
    pub fn outline(&self) -> Outline {
        let mut outline = Outline::default();
        self.pieces.iter().for_each(|piece| piece.add_to(&mut outline));
        outline
    }

    /// World-space bounds.
    pub fn bounds(&self) -> Aabb {
        self.pieces.iter().fold(Aabb::EMPTY, |bounds, piece| bounds.union(piece.bounds()))
    }

    /// The smallest box around it, however it is turned. Looks at the vertices of what is turned; of models in parts, together with
    /// the ranks that have the others.
    ///
    /// # Errors
    /// Another rank is gone.
    pub fn smallest_box(&self, parts: &mut Option<&mut impl Communicator>) -> Result<Aabb, CommError> {
        self.pieces.iter().try_fold(Aabb::EMPTY, |bounds, piece| Ok(bounds.union(piece.smallest_box(parts)?)))
    }

    /// See [`Instance::reach`].
    pub fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        // Without vertices that is not a number.
        self.pieces.iter().fold(f64::NEG_INFINITY, |far, piece| far.max(piece.reach(direction, from)))
    }
}

impl Piece<'_> {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Instance(instance, margin) => grown(instance.bounds(), *margin),
            Self::Extent(extent, place, margin) => grown(placed(&extent.bounds(), place), *margin),
            Self::Outline(outline) => outline.bounds(),
        }
    }

    fn smallest_box(&self, parts: &mut Option<&mut impl Communicator>) -> Result<Aabb, CommError> {
        let (bounds, is_turned) = (self.bounds(), self.is_turned());
        if bounds.is_empty() || !is_turned {
            return Ok(bounds);
        }
        let middle = bounds.center();
        let [x, y, z] = DVec3::AXES;
        let mut far = [x, y, z, -x, -y, -z].map(|direction| self.reach(direction, middle));
        if let (Some(comm), Self::Instance(instance, _)) = (parts, self)
            && instance.share.is_some()
        {
            far = all_max(*comm, far)?;
        }
        let [x, y, z, left, below, behind] = far;
        // Rounded: nothing is outside of the box of the box.
        let (min, max) = (middle - DVec3::new(left, below, behind), middle + DVec3::new(x, y, z));
        Ok(Aabb { min: min.max(bounds.min), max: max.min(bounds.max) })
    }

    /// Whether its box may be smaller than that of its own box.
    fn is_turned(&self) -> bool {
        match self {
            Self::Instance(instance, _) => turns(&instance.world_from_object.matrix3),
            Self::Extent(_, place, _) => turns(&place.matrix3),
            Self::Outline(_) => false,
        }
    }

    fn reach(&self, direction: DVec3, from: DVec3) -> f64 {
        let (reach, margin) = match self {
            Self::Instance(instance, margin) => (instance.reach(direction, from), margin),
            Self::Outline(outline) => return outline.reach(direction, from),
            Self::Extent(extent, place, margin) if *place == DAffine3::IDENTITY => {
                (extent.reach(direction, from), margin)
            }
            Self::Extent(extent, place, margin) => {
                // Relative to a point of the extent, so that nothing is lost far from the origin.
                let middle = extent.bounds().center();
                let own = extent.reach(place.matrix3.transpose() * direction, middle);
                (own + direction.dot(place.transform_point3(middle) - from), margin)
            }
        };
        reach + margin * direction.length()
    }

    fn add_to(&self, outline: &mut Outline) {
        match self {
            Self::Instance(instance, margin) => {
                outline.add(&self.bounds(), |d| Some(instance.farthest(d)? + d * *margin));
            }
            Self::Extent(extent, place, margin) => {
                let cells = extent.cells();
                outline.add(&self.bounds(), |d| {
                    let farthest = cells.farthest(place.matrix3.transpose() * d)?;
                    Some(place.transform_point3(farthest) + d * *margin)
                });
            }
            Self::Outline(_) => {}
        }
    }
}

/// Whether a box does not remain a box along the axes: a coordinate depends on more than one of the original ones.
fn turns(matrix: &DMat3) -> bool {
    (0..3).any(|row| matrix.row(row).to_array().iter().filter(|&&v| v != 0.0).count() > 1)
}

/// A box with a margin on all sides.
pub(super) fn grown(bounds: Aabb, margin: f64) -> Aabb {
    match bounds.is_empty() || margin <= 0.0 {
        true => bounds,
        false => Aabb { min: bounds.min - margin, max: bounds.max + margin },
    }
}

/// The box of a box at a place.
pub(super) fn placed(bounds: &Aabb, place: &DAffine3) -> Aabb {
    if bounds.is_empty() || *place == DAffine3::IDENTITY {
        return *bounds;
    }
    let mut all = Aabb::EMPTY;
    bounds.corners().into_iter().for_each(|corner| all.add(place.transform_point3(corner)));
    all
}
