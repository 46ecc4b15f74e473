//! How many tiles triangles meet on average: the renderer's binning against the formulas of documents 001 and 003. The formulas
//! speak of shapes at random places on an unlimited screen; the renderer bins triangles of random places, sizes and shapes that
//! are inside the picture.

use std::sync::Arc;

use glam::DVec3;
use tercio_lab::models::{mcmanus, overlap};
use tercio_lab::units::{Length, Pixels, Ratio};
use tercio_mesh::Mesh;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::tally;
use tercio_raster::{Binning, LastStage, Settings, Sorting};

use tercio_scene::{Camera, Projection, Scene};

/// Pixels along the edge of the picture.
const EDGE: u32 = 2048;
const TRIANGLES: usize = 60_000;

/// Random numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.next()
    }
}

/// Corners of a triangle in pixels, from the upper left corner of its box.
type Corners = [[f64; 2]; 3];

/// Mean sizes of triangles on the screen, and the tiles that each met, as the renderer counted.
struct Met {
    width: f64,
    height: f64,
    area: f64,
    tiles: f64,
}

/// Bins triangles at random places, one by one.
fn met(tile: u32, binning: Binning, mut shape: impl FnMut(&mut Random) -> Corners) -> Met {
    let mut random = Random(7);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let (mut width, mut height, mut area) = (0.0, 0.0, 0.0);
    for _ in 0..TRIANGLES {
        let corners = shape(&mut random);
        let most = |k: usize| corners.iter().map(|c| c[k]).fold(0.0, f64::max);
        let (w, h) = (most(0), most(1));
        let [a, b, c] = corners;
        width += w;
        height += h;
        area += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0;
        let edge = f64::from(EDGE);
        // Anywhere in a tile with the same probability.
        let place = [w, h].map(|size| {
            let tile = f64::from(tile);
            random.between(0.0, ((edge - size) / tile).floor() * tile)
        });
        let first = positions.len() as u32;
        triangles.push([first, first + 1, first + 2]);
        // One unit is one pixel, and the picture's centre is the origin.
        let at =
            |c: [f64; 2]| [c[0] + place[0] - edge / 2.0, edge / 2.0 - c[1] - place[1], 0.0].map(|x| x as f32);
        positions.extend(corners.map(at));
    }
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let camera = Camera {
        eye: DVec3::Z * 10.0,
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: EDGE.into() },
        near: None,
        shift: [0.0; 2],
    };
    let settings = Settings {
        binning,
        sorting: Sorting::Triangles,
        last_stage: LastStage::Bin,
        tile_size: Some(tile),
        ..Settings::one_sample(EDGE, EDGE)
    };
    let counted = tally::count(&scene, &camera, &settings, 1).expect("counts").stats.binning;
    let all = TRIANGLES as f64;
    assert!(counted.triangles as f64 > 0.999 * all, "{counted:?}");
    Met { width: width / all, height: height / all, area: area / all, tiles: counted.overlap }
}

/// A triangle whose box has this size: one corner in a corner of the box, and others on the sides beyond, so that the area is this
/// part of the box.
fn in_box(random: &mut Random, [w, h]: [f64; 2], part: f64) -> Corners {
    // The triangle (0, 0), (w, y), (x, h) has the area (w h - x y) / 2.
    let product = 1.0 - 2.0 * part;
    let x = random.between(product, 1.0);
    let y = product / x;
    let mirror = [random.next() < 0.5, random.next() < 0.5];
    [[0.0, 0.0], [w, y * h], [x * w, h]]
        .map(|[x, y]| [if mirror[0] { w - x } else { x }, if mirror[1] { h - y } else { y }])
}

#[track_caller]
fn assert_near(found: f64, formula: f64, tolerance: f64, what: &str) {
    assert!((found / formula - 1.0).abs() < tolerance, "{what}: {found} counted, {formula} by the formula");
}

/// Document 003, equations 2 to 6: square boxes of whole pixels. A triangle whose box is w wide has w columns of samples on
/// average in it, whatever its place is.
#[test]
fn square_boxes_meet_as_many_regions_as_document_003_says() {
    for (tile, side) in [(8, 5.0), (16, 16.0), (32, 24.0), (64, 23.5)] {
        let found = met(tile, Binning::BoundingBox, |random| in_box(random, [side; 2], 1.0 / 3.0));
        let [region, side] = [Length::new(tile.into()), Length::new(side)];
        let what = format!("boxes of {side} in tiles of {tile}");
        assert_near(found.tiles, overlap::pixel_boxes(region, side).get(), 0.01, &what);
        let square = Pixels::new(side.get() * side.get());
        assert_near(found.tiles, mcmanus::overlap_of_area(region, square).get(), 0.01, &what);
        let places = mcmanus::overlap_of_places(region, side);
        assert_near(found.tiles, places.get(), 0.01, &what);
    }
}

/// Document 001, equations 2.1 and 2.3: boxes of the plane, which are a pixel larger than their samples.
#[test]
fn boxes_meet_as_many_tiles_as_document_001_says() {
    for (tile, w, h) in [(8, 20.0, 3.0), (32, 9.0, 40.0), (64, 50.0, 50.0), (128, 30.0, 200.0)] {
        let found = met(tile, Binning::BoundingBox, |random| in_box(random, [w, h], 0.4));
        let [side, less_w, less_h] = [f64::from(tile), w - 1.0, h - 1.0].map(Length::new);
        let what = format!("boxes of {w} by {h} in tiles of {tile}");
        assert_near(found.tiles, overlap::boxes_in_squares(side, less_w, less_h).get(), 0.01, &what);
        // What a pixel is to a tile is what the formula is off with the boxes themselves.
        let plane = overlap::boxes_in_squares(side, Length::new(w), Length::new(h)).get();
        let pixel = 2.0 / f64::from(tile);
        assert!(
            found.tiles < plane && plane < found.tiles * (1.0 + pixel),
            "{what}: {plane}, {}",
            found.tiles
        );
    }
}

/// Document 001, equations 2.4, 2.9 and 2.11: triangles whose boxes are square and rho times as large, many times as large as a pixel.
#[test]
fn triangles_meet_as_many_tiles_as_document_001_says() {
    for (rho, tile, side) in [(3.0, 128, 60.0), (3.0, 128, 150.0), (2.0, 128, 128.0), (5.0, 128, 300.0)] {
        let part = 1.0 / rho;
        let shape = |random: &mut Random| in_box(random, [side; 2], part);
        let [exact, boxes] = [Binning::Exact, Binning::BoundingBox].map(|binning| met(tile, binning, shape));
        let (edge, area, rho) = (Length::new(tile.into()), Pixels::new(exact.area), Ratio::new(rho));
        let what = format!("boxes of {side}, rho {rho}, in tiles of {tile}");
        assert_near(exact.tiles, overlap::exact(edge, area, rho).get(), 0.015, &what);
        assert_near(boxes.tiles, overlap::bounding_boxes(edge, area, rho).get(), 0.015, &what);
        let difference = overlap::difference(edge, area, rho).get();
        assert_near(boxes.tiles - exact.tiles, difference, 0.05, &format!("{what}: difference"));
    }
}

/// Document 001, equation 2.10: triangles of any shape, by the means of their boxes and areas. Tiles have samples only in a square
/// that is a pixel smaller, and triangles count where they meet that.
#[test]
fn triangles_of_any_shape_meet_as_many_tiles_as_document_001_says() {
    let any = |most: f64| {
        move |random: &mut Random| {
            let corners: Corners =
                std::array::from_fn(|_| [random.between(0.0, most), random.between(0.0, most)]);
            let least = |k: usize| corners.iter().map(|c| c[k]).fold(f64::MAX, f64::min);
            let (x, y) = (least(0), least(1));
            corners.map(|c| [c[0] - x, c[1] - y])
        }
    };
    for (tile, most) in [(16, 60.0), (32, 90.0), (64, 300.0)] {
        let found = met(tile, Binning::Exact, any(most));
        let (w, h, area) = (Length::new(found.width), Length::new(found.height), Pixels::new(found.area));
        let smaller = f64::from(tile - 1);
        let formula = overlap::exact_by_box(Length::new(smaller), w, h, area).expect("a shape").get();
        let denser = (smaller / f64::from(tile)).powi(2);
        assert_near(found.tiles, formula * denser, 0.015, &format!("shapes up to {most} in tiles of {tile}"));
    }
}
