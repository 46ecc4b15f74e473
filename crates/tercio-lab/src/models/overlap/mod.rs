//! How many tiles a triangle or a box meets on average, at a random position.
//!
//! Two ways of counting: documents 001 and 000 treat a box as a region of the plane, document 003 as a number of whole
//! pixels, of which a box w pixels wide extends w - 1 beyond its first.

pub mod integral;

use crate::models;
use crate::models::registry::{Glossary, Model};
use crate::units::{Count, Length, Pixels, Ratio};

/// Area of the bounding box over that of the triangle: the mean that document 001 assumes (2.3.2).
const BOX_TO_TRIANGLE: f64 = 3.0;

/// Side of the largest region that is counted exhaustively, in pixels.
const MOST_COUNTED: u64 = 4096;

/// Document 001, equation 2.1 (Molnar and Eyles): tiles of `width` by `height` that a box of `w` by `h` meets. Exact
/// for boxes of any size.
pub fn boxes(width: Length, height: Length, w: Length, h: Length) -> Ratio {
    Ratio::new((1.0 + w / width) * (1.0 + h / height))
}

/// Document 001, equation 2.3: the same for square tiles of side `tile`.
pub fn boxes_in_squares(tile: Length, w: Length, h: Length) -> Ratio {
    boxes(tile, tile, w, h)
}

/// Document 001, equation 2.2: tiles of `area` and aspect ratio `aspect` (width over height) that a square box of
/// side `s` meets. Least for square tiles.
pub fn boxes_by_aspect(area: Pixels, aspect: Ratio, s: Length) -> Ratio {
    let [width, height] = tile_sides(area, aspect);
    boxes(width, height, s, s)
}

/// Width and height of a tile of `area` and `aspect` = width over height. The text beside equation 2.2 prints W = R
/// sqrt(A), H = R^-1 sqrt(A) with the -1 lost; even with it W/H would be R squared. Consistent is W = sqrt(R A), H =
/// sqrt(A / R).
pub fn tile_sides(area: Pixels, aspect: Ratio) -> [Length; 2] {
    [Length::new((aspect.get() * area.get()).sqrt()), Length::new((area.get() / aspect.get()).sqrt())]
}

/// The sides as the text prints them with the lost -1 restored, W = R sqrt(A) and H = sqrt(A) / R, as used in equation
/// 2.2. Their aspect ratio is R squared.
pub fn tile_sides_as_printed(area: Pixels, aspect: Ratio) -> [Length; 2] {
    tile_sides(area, aspect * aspect.get())
}

/// Equation 2.2 with the sides as printed. Here, too, the overlap is least at R = 1.
pub fn boxes_by_aspect_as_printed(area: Pixels, aspect: Ratio, s: Length) -> Ratio {
    boxes_by_aspect(area, aspect * aspect.get(), s)
}

/// The aspect ratio of the result of [`tile_sides`].
pub fn tile_aspect(area: Pixels, aspect: Ratio) -> Ratio {
    let [width, height] = tile_sides(area, aspect);
    Ratio::new(width / height)
}

/// Document 001, equation 2.4: tiles of side `tile` that the bounding box of a triangle of `area` meets, where boxes
/// are square and `rho` times as large as their triangles.
pub fn bounding_boxes(tile: Length, area: Pixels, rho: Ratio) -> Ratio {
    let s = Length::new((rho.get() * area.get()).sqrt());
    boxes_in_squares(tile, s, s)
}

/// Document 001, equation 2.7: tiles that a triangle meets whose box contains a corner of four tiles.
pub fn corner(rho: Ratio) -> Ratio {
    Ratio::new(3.0 + 1.0 / rho.get())
}

/// Document 001, equation 2.8: tiles that the triangle itself meets, by the side `s` of its square box.
pub fn exact_by_side(tile: Length, s: Length, rho: Ratio) -> Ratio {
    exact_of(tile, s, s, Pixels::new(s.get() * s.get() / rho.get()))
}

/// The factor of s^2/S^2 in equation 2.8: the excess of [`corner`] over 3.
pub fn corner_excess(rho: Ratio) -> Ratio {
    corner(rho) - Ratio::new(3.0)
}

/// Document 001, equation 2.9: tiles that a triangle of `area` meets, `rho` as in [`bounding_boxes`].
pub fn exact(tile: Length, area: Pixels, rho: Ratio) -> Ratio {
    let s = Length::new((rho.get() * area.get()).sqrt());
    exact_of(tile, s, s, area)
}

/// Document 001, equation 2.10, in general: tiles that a convex shape with box `w` by `h` and `area` meets. Exact for
/// any convex shape of any size, since it is the area of the shape's Minkowski sum with a tile over the tile's; the
/// document derives it for boxes within a tile only.
///
/// # Errors
/// An area larger than the box.
pub fn exact_by_box(tile: Length, w: Length, h: Length, area: Pixels) -> Result<Ratio, String> {
    let of_box = w.get() * h.get();
    // Rounding in binary must not decide about a shape that fills its box.
    if area.get() > of_box * (1.0 + 4.0 * f64::EPSILON) {
        return Err(format!("a: expected at most the area of the box, w h = {of_box}, found {}", area.get()));
    }
    Ok(exact_of(tile, w, h, area))
}

fn exact_of(tile: Length, w: Length, h: Length, area: Pixels) -> Ratio {
    let s = tile.get();
    Ratio::new(1.0 + (w.get() + h.get()) / s + area.get() / (s * s))
}

/// Document 001, equation 2.11: bounding boxes minus exact, 2.4 - 2.9.
pub fn difference(tile: Length, area: Pixels, rho: Ratio) -> Ratio {
    Ratio::new(area.get() * (rho.get() - 1.0) / (tile.get() * tile.get()))
}

/// Document 003, equations 2 to 6: regions of side `region` that a square box of `side` whole pixels meets. The
/// equations with 4 corrected collapse to this square, whether `side` is a multiple of `region` or not.
pub fn pixel_boxes(region: Length, side: Length) -> Ratio {
    let regions = (side.get() + region.get() - 1.0) / region.get();
    Ratio::new(regions * regions)
}

/// Document 000: columns of a column-parallel machine that polygons `width` pixels wide meet; [`pixel_boxes`] in one
/// dimension.
pub fn columns(column: Length, width: Length) -> Ratio {
    Ratio::new((width.get() + column.get() - 1.0) / column.get())
}

/// The mean of [`pixel_boxes`] by enumeration: a box of `side` pixels at each of the `region` squared positions.
///
/// # Errors
/// A region or a box without a pixel, a region of more than 4096 on a side.
pub fn pixel_boxes_counted(region: Count, side: Count) -> Result<Ratio, String> {
    let (a, w) = (region.get() as u64, side.get() as u64);
    if a == 0 || w == 0 {
        return Err("A, w: expected at least one pixel, found 0".into());
    }
    if a > MOST_COUNTED {
        return Err(format!("A: expected at most {MOST_COUNTED} pixels to count at, found {region}"));
    }
    let met = |offset: u64| (offset + w - 1) / a + 1;
    let sum: u64 = (0..a).flat_map(|y| (0..a).map(move |x| met(x) * met(y))).sum();
    Ok(Ratio::new(sum as f64 / (a * a) as f64))
}

pub(crate) const MODELS: &[Model] = models! {
    "overlap.2.1", "001 eq 2.1", "tiles W by H that a box w by h meets":
        boxes["W": Length, "H": Length, "w": Length, "h": Length] -> Ratio;
    "overlap.2.2", "001 eq 2.2", "tiles of area A_r and aspect R that a square box of side s meets":
        boxes_by_aspect["A_r": Pixels, "R": Ratio = 1.0, "s": Length] -> Ratio;
    "overlap.2.2-as-printed", "001 eq 2.2", "the same with the sides as printed, whose aspect is R squared":
        boxes_by_aspect_as_printed["A_r": Pixels, "R": Ratio = 1.0, "s": Length] -> Ratio;
    "overlap.tile-sides-as-printed", "001 eq 2.2", "width and height of a tile as printed":
        tile_sides_as_printed["A_r": Pixels, "R": Ratio] -> [Length; 2];
    "overlap.tile-sides", "001 eq 2.2", "width and height of a tile of area A_r and aspect R":
        tile_sides["A_r": Pixels, "R": Ratio] -> [Length; 2];
    "overlap.tile-aspect", "001 eq 2.2", "aspect ratio of these sides":
        tile_aspect["A_r": Pixels, "R": Ratio] -> Ratio;
    "overlap.2.3", "001 eq 2.3", "square tiles of side S that a box w by h meets":
        boxes_in_squares["S": Length, "w": Length, "h": Length] -> Ratio;
    "overlap.2.4", "001 eq 2.4", "square tiles that the bounding box of a triangle of area a meets":
        bounding_boxes["S": Length, "a": Pixels, "rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.2.7", "001 eq 2.7", "tiles that a triangle meets whose box contains a corner":
        corner["rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.2.7-excess", "001 eq 2.7, 2.8", "the same, less 3":
        corner_excess["rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.2.8", "001 eq 2.8", "square tiles that a triangle with a square box of side s meets":
        exact_by_side["S": Length, "s": Length, "rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.2.9", "001 eq 2.9", "square tiles that a triangle of area a meets":
        exact["S": Length, "a": Pixels, "rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.2.10", "001 eq 2.10", "square tiles that a convex shape with box w by h and area a meets":
        exact_by_box["S": Length, "w": Length, "h": Length, "a": Pixels] -> Result<Ratio, String>;
    "overlap.2.11", "001 eq 2.11", "2.4 minus 2.9":
        difference["S": Length, "a": Pixels, "rho": Ratio where 1.0 = BOX_TO_TRIANGLE] -> Ratio;
    "overlap.pixel-boxes", "003 eq 2 to 6", "regions of side A that a square box of w whole pixels meets":
        pixel_boxes["A": Length where 1.0, "w": Length where 1.0] -> Ratio;
    "overlap.pixel-boxes-counted", "003 eq 6", "the same, counted at every place":
        pixel_boxes_counted["A": Count where 1.0, "w": Count where 1.0] -> Result<Ratio, String>;
    "overlap.columns", "000 4.3.1", "columns of width A that a polygon w pixels wide meets":
        columns["A": Length where 1.0 = 1.0, "w": Length where 1.0] -> Ratio;
};

pub(crate) const GLOSSARY: Glossary = Glossary {
    group: "overlap",
    document: None,
    symbols: &[
        ("A", "side of a region in whole pixels"),
        ("overlap.columns/A", "width of a column of the screen"),
        ("A_r", "area of a tile"),
        ("H", "height of a tile"),
        ("R", "aspect ratio of a tile, width over height"),
        ("S", "side of a square tile"),
        ("W", "width of a tile"),
        ("a", "area of the triangle or shape"),
        ("h", "height of the bounding box"),
        ("p", "weights of the positions of the box's centre: rows of equal cells of a tile"),
        ("rho", "area of the bounding box over that of the triangle"),
        ("s", "side of a square bounding box"),
        ("shape", "corners [x, y] of a convex polygon"),
        ("steps", "positions tried across a tile and down"),
        ("w", "width of the bounding box"),
    ],
    assumptions: &[
        (
            &[
                "overlap.2.1",
                "overlap.2.2*",
                "overlap.2.3",
                "overlap.2.4",
                "overlap.2.6",
                "overlap.2.7*",
                "overlap.2.8",
                "overlap.2.9",
                "overlap.2.10",
                "overlap.2.11",
                "overlap.pixel-boxes*",
                "overlap.columns",
            ],
            "every position of the box relative to the tiles is equally likely",
        ),
        (&["overlap.2.4", "overlap.2.8", "overlap.2.9", "overlap.2.11"], "square bounding boxes"),
        (&["overlap.2.7*"], "a box smaller than a tile"),
        (
            &["overlap.pixel-boxes*", "overlap.columns"],
            "boxes of whole pixels: one w pixels wide extends w - 1 beyond its first",
        ),
    ],
};

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The closed form is the exact mean over all positions, for any sizes.
        #[test]
        fn pixel_boxes_are_exact(a in 1u32..24, w in 1u32..80) {
            let counted = pixel_boxes_counted(Count::new(a.into()), Count::new(w.into())).unwrap().get();
            let closed = pixel_boxes(Length::new(a.into()), Length::new(w.into())).get();
            prop_assert!((counted - closed).abs() < 1e-9 * closed);
        }

        /// A rectangle fills its box, so the general form is equation 2.3.
        #[test]
        fn a_rectangle_is_its_own_box(s in 1.0f64..300.0, w in 0.0f64..500.0, h in 0.0f64..500.0) {
            let (s, wl, hl) = (Length::new(s), Length::new(w), Length::new(h));
            let general = exact_by_box(s, wl, hl, Pixels::new(w * h)).unwrap().get();
            prop_assert!((general / boxes_in_squares(s, wl, hl).get() - 1.0).abs() < 1e-12);
        }

        /// Pixel counting is the continuous formula for a box one pixel smaller.
        #[test]
        fn the_documents_agree(a in 1.0f64..300.0, w in 1.0f64..500.0) {
            let pixels = pixel_boxes(Length::new(a), Length::new(w)).get();
            let plane = boxes_in_squares(Length::new(a), Length::new(w - 1.0), Length::new(w - 1.0)).get();
            prop_assert!((pixels / plane - 1.0).abs() < 1e-12);
        }

        #[test]
        fn square_tiles_meet_least(area in 1.0f64..1e5, aspect in 0.01f64..100.0, s in 0.0f64..500.0) {
            let at = |r: f64| boxes_by_aspect(Pixels::new(area), Ratio::new(r), Length::new(s)).get();
            prop_assert!(at(aspect) >= at(1.0) * (1.0 - 1e-12));
        }
    }

    #[test]
    fn a_shape_is_not_larger_than_its_box() {
        let met =
            |area| exact_by_box(Length::new(8.0), Length::new(4.0), Length::new(5.0), Pixels::new(area));
        // 1 + 9/8 + 20/64.
        assert_eq!(met(20.0).unwrap().get(), 2.4375);
        assert!(met(21.0).unwrap_err().contains("w h = 20, found 21"));
    }

    #[test]
    fn printed_sides_have_another_aspect() {
        let (area, aspect) = (Pixels::new(1024.0), Ratio::new(2.0));
        assert_eq!(tile_aspect(area, aspect).get(), 2.0);
        assert_eq!(tile_sides_as_printed(area, aspect), [Length::new(64.0), Length::new(16.0)]);
        let box_side = Length::new(16.0);
        // (64 + 16) / 64 * (16 + 16) / 16
        assert_eq!(boxes_by_aspect_as_printed(area, aspect, box_side).get(), 2.5);
    }
}
