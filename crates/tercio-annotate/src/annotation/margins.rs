//! The strips at the sides of a picture that annotation takes from the model.

use std::cmp::Ordering;

use crate::layout::{Layout, Place, Rect};

/// Strips at the left, upper, right and lower side, in pixels.
pub(super) type Margins = [f64; 4];

/// Strips take at most this share of the picture's width or height.
pub(super) const MOST_TAKEN: f64 = 0.6;

/// Another place is better than the nearest one if it leaves the model more than this, relative to what that leaves.
const WORTH: f64 = 1.05;

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
}

/// What is left of a picture between strips.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    pub margins: Margins,
    /// Whether there is enough room for the model.
    pub is_enough: bool,
    /// The shorter side: models are about as wide as high.
    short: f64,
    area: f64,
}

impl Room {
    fn new(margins: Margins, size: [f64; 2]) -> Self {
        let [left, top, right, bottom] = margins;
        let taken = [left + right, top + bottom];
        let [width, height] = [0, 1].map(|k| (size[k] - taken[k]).max(0.0));
        let is_enough = (0..2).all(|k| taken[k] <= size[k] * MOST_TAKEN);
        Self { margins, is_enough, short: width.min(height), area: width * height }
    }

    fn cmp(&self, other: &Self) -> Ordering {
        let by_short = || self.short.total_cmp(&other.short);
        self.is_enough
            .cmp(&other.is_enough)
            .then_with(by_short)
            .then_with(|| self.area.total_cmp(&other.area))
    }

    /// Whether this is more by so much that it is worth another place.
    fn is_worth_more_than(&self, other: &Self) -> bool {
        self.is_enough && !other.is_enough
            || self.is_enough == other.is_enough && self.short > other.short * WORTH
    }
}

/// The most room beside all claims. Each corner is in the strip at one of its two sides, whichever costs the model less, so
/// that it shares one that something else takes anyway.
pub(super) fn room(claims: &[Claim], size: [f64; 2]) -> Room {
    let reaches = |side: usize| {
        let at_side = claims.iter().filter(move |claim| claim.sides[0] == Some(side));
        std::iter::once(0.0).chain(at_side.map(move |claim| claim.reach(side, size)))
    };
    let mut best: Option<Room> = None;
    for left in reaches(0) {
        for right in reaches(2) {
            let Some(margins) = with_strips(claims, left, right, size) else { continue };
            let room = Room::new(margins, size);
            if best.is_none_or(|best| room.cmp(&best) == Ordering::Greater) {
                best = Some(room);
            }
        }
    }
    // The widest strips at both sides contain all that can be in them.
    best.unwrap_or_else(|| Room::new([0.0; 4], size))
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
