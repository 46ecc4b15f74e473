//! The strips at the sides of a picture that annotation takes from the model.

use std::cmp::Ordering;

use crate::layout::{Layout, Place, Rect, overlap};

/// Strips at the left, upper, right and lower side, in pixels.
pub(super) type Margins = [f64; 4];

/// Strips take at most this share of the picture's width or height.
pub(crate) const MOST_TAKEN: f64 = 0.6;

/// Another place is better than the nearest one if it leaves the model more than this, relative to what that leaves.
const WORTH: f64 = 1.05;

/// Half of the width and of the height of what is framed, in any unit.
pub type Shape = [f64; 2];

/// What is framed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Framed<'a> {
    /// In pictures of their own.
    pub shapes: &'a [Shape],
    /// What is drawn beside it, as numbers of its box, in pixels.
    pub beside: Margins,
    /// How far it stays from what is in corners.
    pub gap: f64,
}

/// Something as wide as high, alone.
const ROUND: Framed = Framed { shapes: &[[1.0; 2]], beside: [0.0; 4], gap: 0.0 };

/// A box that the model has to be beside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    pub rect: Rect,
    /// The sides at which a strip can contain it, as indices of [`Margins`]: the left or right one, and the upper or lower one.
    /// What is in a corner has both, what is in the middle of the picture none.
    pub sides: [Option<usize>; 2],
}

/// The sides at which a place is.
pub(crate) fn sides_of(place: Place) -> [Option<usize>; 2] {
    let side = |share: f64, sides: [usize; 2]| match share {
        0.0 => Some(sides[0]),
        1.0 => Some(sides[1]),
        _ => None,
    };
    [side(place.x, [0, 2]), side(place.y, [1, 3])]
}

impl Claim {
    /// The width of the strip at a side that contains the box.
    fn reach(&self, side: usize, size: [f64; 2]) -> f64 {
        let [left, top, right, bottom] = self.rect;
        [right, bottom, size[0] - left, size[1] - top][side]
    }

    /// Whether the model in a room is beside the box: a strip contains it, or, in a corner, the model does not reach it.
    fn is_beside(&self, room: &Room, framed: &Framed, size: [f64; 2]) -> bool {
        let is_in = |side: usize| self.reach(side, size) <= room.margins[side];
        match self.sides {
            [None, None] => true,
            [Some(side), None] | [None, Some(side)] => is_in(side),
            [Some(a), Some(b)] => {
                let is_clear = |&shape: &Shape| !overlap(&self.rect, &room.model(shape, framed), framed.gap);
                is_in(a) || is_in(b) || framed.shapes.iter().all(is_clear)
            }
        }
    }
}

/// How large something is that fills a room.
fn fit(room: [f64; 2], [x, y]: Shape) -> f64 {
    (room[0] / x).min(room[1] / y) * 0.5
}

/// What is left of a picture between strips.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    pub margins: Margins,
    /// Whether there is enough room for the model.
    pub is_enough: bool,
    /// How large the model is, relative to the whole picture.
    scale: f64,
    /// Width and height without what is beside the model.
    inner: [f64; 2],
}

impl Room {
    fn new(margins: Margins, size: [f64; 2], framed: &Framed) -> Self {
        let beside = framed.beside;
        let taken = [0, 1].map(|k| margins[k] + margins[k + 2]);
        let is_enough = (0..2).all(|k| taken[k] <= size[k] * MOST_TAKEN);
        let inner = [0, 1].map(|k| (size[k] - taken[k] - beside[k] - beside[k + 2]).max(0.0));
        let scales = framed.shapes.iter().map(|&shape| fit(inner, shape) / fit(size, shape));
        Self { margins, is_enough, scale: scales.fold(1.0, f64::min), inner }
    }

    /// The box of a model in it, and of what is beside it.
    fn model(&self, shape: Shape, framed: &Framed) -> Rect {
        let scale = fit(self.inner, shape);
        [0, 1, 2, 3].map(|side| {
            let (k, sign) = (side % 2, if side < 2 { -1.0 } else { 1.0 });
            let middle = self.margins[k] + framed.beside[k] + self.inner[k] * 0.5;
            middle + sign * (shape[k] * scale + framed.beside[side])
        })
    }

    fn area(&self) -> f64 {
        self.inner[0] * self.inner[1]
    }

    fn cmp(&self, other: &Self) -> Ordering {
        let by_scale = || self.scale.total_cmp(&other.scale);
        self.is_enough
            .cmp(&other.is_enough)
            .then_with(by_scale)
            .then_with(|| self.area().total_cmp(&other.area()))
    }

    /// Whether this is more by so much that it is worth another place.
    fn is_worth_more_than(&self, other: &Self) -> bool {
        self.is_enough && !other.is_enough
            || self.is_enough == other.is_enough && self.scale > other.scale * WORTH
    }
}

/// The widths that a strip at a side may have.
fn reaches(claims: &[Claim], side: usize, size: [f64; 2]) -> Vec<f64> {
    let at_side = claims.iter().filter(move |claim| claim.sides.contains(&Some(side)));
    std::iter::once(0.0).chain(at_side.map(move |claim| claim.reach(side, size))).collect()
}

/// The most room for what is framed beside all claims. Where it does not reach a corner, what is there costs it nothing; otherwise the
/// corner is in a strip, as in [`room`].
pub(super) fn room_for(claims: &[Claim], size: [f64; 2], framed: &Framed) -> Room {
    let [left, top, right, bottom] = [0, 1, 2, 3].map(|side| reaches(claims, side, size));
    let mut best: Option<Room> = None;
    for &left in &left {
        for &right in &right {
            for &top in &top {
                for &bottom in &bottom {
                    let room = Room::new([left, top, right, bottom], size, framed);
                    let is_better = best.is_none_or(|best| room.cmp(&best) == Ordering::Greater);
                    if is_better && claims.iter().all(|claim| claim.is_beside(&room, framed, size)) {
                        best = Some(room);
                    }
                }
            }
        }
    }
    best.unwrap_or_else(|| Room::new([0.0; 4], size, framed))
}

/// The most room beside all claims for a model that is about as wide as high. Each corner is in the strip at one of its two sides, whichever costs the model less, so
/// that it shares one that something else takes anyway.
pub(super) fn room(claims: &[Claim], size: [f64; 2]) -> Room {
    let mut best: Option<Room> = None;
    for left in reaches(claims, 0, size) {
        for right in reaches(claims, 2, size) {
            let Some(margins) = with_strips(claims, left, right, size) else { continue };
            let room = Room::new(margins, size, &ROUND);
            if best.is_none_or(|best| room.cmp(&best) == Ordering::Greater) {
                best = Some(room);
            }
        }
    }
    // The widest strips at both sides contain all that can be in them.
    best.unwrap_or_else(|| Room::new([0.0; 4], size, &ROUND))
}

/// The strips above and below that contain what those at the sides do not; `None` if one has to be in a strip at a side and is not.
fn with_strips(claims: &[Claim], left: f64, right: f64, size: [f64; 2]) -> Option<Margins> {
    let mut margins = [left, 0.0, right, 0.0];
    for claim in claims {
        let is_in = |side: &usize| claim.reach(*side, size) <= margins[*side];
        match claim.sides {
            [Some(side), _] if is_in(&side) => {}
            [_, Some(side)] => margins[side] = margins[side].max(claim.reach(side, size)),
            [Some(_), None] => return None,
            [None, None] => {}
        }
    }
    Some(margins)
}

/// Finds room for a box of one of these sizes, the first if possible: at its place, above, below or beside what is there, where it
/// leaves the model the most room.
pub(super) fn find(layout: &Layout, claims: &[Claim], sizes: &[[f64; 2]], place: Place) -> Option<Rect> {
    let sides = sides_of(place);
    let found = sizes.iter().flat_map(|&size| [layout.find(size, place), layout.find_beside(size, place)]);
    let mut best: Option<(Rect, Room)> = None;
    for rect in found.flatten() {
        let all: Vec<Claim> = claims.iter().copied().chain([Claim { rect, sides }]).collect();
        let room = room(&all, layout.size);
        if best.as_ref().is_none_or(|(_, best)| room.is_worth_more_than(best)) {
            best = Some((rect, room));
        }
    }
    best.map(|(rect, _)| rect)
}
