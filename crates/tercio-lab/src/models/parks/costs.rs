//! Cycle costs of the Z-buffer algorithm and of scenes (sections 2.2, 4.1, 4.3, 4.5, appendices B and C).

use super::distributions::Distribution;
use crate::models;
use crate::models::common::total;
use crate::models::registry::Model;
use crate::units::{Count, Cycles, Length, Pixels, Polygons, Ratio, Seconds, Segments, Vertices};

/// Cycles per polygon: 42 to find it, 97 to begin and end it (2.2). The summary's cell is blank in the scan; appendix
/// C prints 139.0.
pub const POLYGON: Cycles = Cycles::new(42.0 + 97.0);
/// Cycles per vertex: 24.6 to find the top one, 25 to step, 257.2 for the deltas of a side, 12.5 to end it (2.2).
pub const VERTEX: Cycles = Cycles::new(24.6 + 25.0 + 257.2 + 12.5);
/// Cycles per segment: 85 to begin it, 15 for the body, 58 to end it (2.2).
pub const SEGMENT: Cycles = Cycles::new(85.0 + 15.0 + 58.0);
/// Cycles per pixel (2.2).
pub const PIXEL: Cycles = Cycles::new(21.0);

/// Cycles of a scene on one processor. `segments` are the charged ones, see [`super::distributions::charged_segments`].
pub fn scene(polygons: Polygons, vertices: Vertices, segments: Segments, pixels: Pixels) -> Cycles {
    POLYGON * polygons.get() + VERTEX * vertices.get() + SEGMENT * segments.get() + PIXEL * pixels.get()
}

/// Cycles of a scene whose polygons have the heights `heights` on this processor.
pub fn scene_of_heights(
    polygons: Polygons,
    vertices: Vertices,
    heights: Distribution,
    pixels: Pixels,
) -> Cycles {
    scene(polygons, vertices, super::distributions::charged_segments(heights), pixels)
}

/// Cycles of one polygon with `vertices`, of `height` and `area`.
pub fn polygon(vertices: Vertices, height: Segments, area: Pixels) -> Cycles {
    scene(Polygons::new(1.0), vertices, height, area)
}

/// Point polygons in the time of one square of `side`, rounded down (4.3).
pub fn points_per_square(side: Length) -> Count {
    Count::new((square(side) / point()).floor())
}

/// Polygons of one vertex in the time of `squares` squares of `side` (4.3).
pub fn points_per_squares(side: Length, squares: Count) -> Ratio {
    Ratio::new(square(side) * squares.get() / point())
}

/// Triangles with `height` and its square as area in the time of one square of `side`, rounded down (4.3).
pub fn triangles_per_square(side: Length, height: Length) -> Count {
    let h = height.get();
    let triangle = polygon(Vertices::new(3.0), Segments::new(h), Pixels::new(h * h));
    Count::new((square(side) / triangle).floor())
}

fn square(side: Length) -> Cycles {
    polygon(Vertices::new(4.0), Segments::new(side.get()), Pixels::new(side.get() * side.get()))
}

/// Cycles of a polygon that is a point; times the depth complexity, the lower bound of a splitter with one processor
/// per pixel (4.1).
pub fn point() -> Cycles {
    polygon(Vertices::new(1.0), Segments::new(1.0), Pixels::new(1.0))
}

/// The lower bound of a splitter's time, however many processors it has: a point for every layer of the deepest pixel
/// (4.1).
pub fn splitter_floor(depth: Ratio) -> Cycles {
    point() * depth.get()
}

/// Cycles of one of the k by k processors of an interlace machine by the rule of section 4.5: all polygons and
/// vertices, 1/k of the segments, 1/k^2 of the pixels.
pub fn interlace(
    polygons: Polygons,
    vertices: Vertices,
    segments: Segments,
    pixels: Pixels,
    k: Count,
) -> Cycles {
    scene(polygons, vertices, segments / k.get(), pixels / (k.get() * k.get()))
}

/// The share of polygons and vertices in [`interlace`], which more processors do not reduce (4.5).
pub fn interlace_fixed_share(
    polygons: Polygons,
    vertices: Vertices,
    segments: Segments,
    pixels: Pixels,
    k: Count,
) -> Ratio {
    Ratio::new(fixed(polygons, vertices) / interlace(polygons, vertices, segments, pixels, k))
}

fn fixed(polygons: Polygons, vertices: Vertices) -> Cycles {
    POLYGON * polygons.get() + VERTEX * vertices.get()
}

/// Shares of a scene's time: polygons, vertices, segments, pixels (appendix C).
pub fn shares(polygons: Polygons, vertices: Vertices, segments: Segments, pixels: Pixels) -> [Ratio; 4] {
    let total = scene(polygons, vertices, segments, pixels);
    let parts =
        [POLYGON * polygons.get(), VERTEX * vertices.get(), SEGMENT * segments.get(), PIXEL * pixels.get()];
    parts.map(|part| Ratio::new(part / total))
}

/// The share of polygons (appendix C).
pub fn polygon_share(n: Polygons, v: Vertices, s: Segments, p: Pixels) -> Ratio {
    shares(n, v, s, p)[0]
}

/// The share of vertices (appendix C).
pub fn vertex_share(n: Polygons, v: Vertices, s: Segments, p: Pixels) -> Ratio {
    shares(n, v, s, p)[1]
}

/// The share of segments (appendix C).
pub fn segment_share(n: Polygons, v: Vertices, s: Segments, p: Pixels) -> Ratio {
    shares(n, v, s, p)[2]
}

/// The share of pixels (appendix C).
pub fn pixel_share(n: Polygons, v: Vertices, s: Segments, p: Pixels) -> Ratio {
    shares(n, v, s, p)[3]
}

/// The share of polygons and vertices together (4.5).
pub fn fixed_share(n: Polygons, v: Vertices, s: Segments, p: Pixels) -> Ratio {
    Ratio::new(fixed(n, v) / scene(n, v, s, p))
}

/// Depth complexity: pixels drawn over pixels of the processor's part of the screen (appendix C).
pub fn depth_complexity(pixels: Pixels, screen: Pixels) -> Ratio {
    Ratio::new(pixels / screen)
}

/// The same from the mean area of polygons (footnote 5, whose formula the scan has lost).
pub fn depth_complexity_by_area(polygons: Polygons, area: Pixels, screen: Pixels) -> Ratio {
    depth_complexity(area * polygons.get(), screen)
}

/// Time of a number of memory cycles (4.4).
pub fn time(cycles: Cycles, cycle: Seconds) -> Seconds {
    cycle * cycles.get()
}

pub(crate) const MODELS: &[Model] = models! {
    "parks.listing", "app. B", "cycles of a listing with a number of instructions of each cost":
        total["times": Vec<Count>, "each": Vec<Cycles>] -> Result<Cycles, String>;
    "parks.scene", "2.2", "cycles of a scene by charged segments":
        scene["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Cycles;
    "parks.scene-of-heights", "app. C", "cycles of a scene by the heights of its polygons, [[height, polygons], ...]":
        scene_of_heights["N": Polygons, "V": Vertices, "heights": Distribution, "P": Pixels] -> Cycles;
    "parks.polygon", "2.2", "cycles of a polygon":
        polygon["V": Vertices, "height": Segments, "area": Pixels] -> Cycles;
    "parks.point", "4.1", "cycles of a point; the splitter's floor per unit of depth complexity":
        point[] -> Cycles;
    "parks.splitter-floor", "4.1", "lower bound of the cycles of a splitter":
        splitter_floor["Dc": Ratio] -> Cycles;
    "parks.points-per-square", "4.3", "whole points in the time of a square":
        points_per_square["side": Length = 128.0] -> Count;
    "parks.points-per-squares", "4.3", "points in the time of squares":
        points_per_squares["side": Length = 128.0, "squares": Count = 2.0] -> Ratio;
    "parks.triangles-per-square", "4.3", "whole triangles in the time of a square":
        triangles_per_square["side": Length = 128.0, "height": Length = 12.8] -> Count;
    "parks.interlace", "4.5", "cycles of one of k by k interlaced processors":
        interlace["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels, "k": Count where 1.0] -> Cycles;
    "parks.interlace-fixed-share", "4.5", "share of polygons and vertices in them":
        interlace_fixed_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels, "k": Count where 1.0] -> Ratio;
    "parks.shares", "app. C", "shares of polygons, vertices, segments, pixels":
        shares["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> [Ratio; 4];
    "parks.polygon-share", "app. C", "share of polygons":
        polygon_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Ratio;
    "parks.vertex-share", "app. C", "share of vertices":
        vertex_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Ratio;
    "parks.segment-share", "app. C", "share of segments":
        segment_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Ratio;
    "parks.pixel-share", "app. C", "share of pixels":
        pixel_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Ratio;
    "parks.fixed-share", "4.5", "share of polygons and vertices":
        fixed_share["N": Polygons, "V": Vertices, "S": Segments, "P": Pixels] -> Ratio;
    "parks.depth-complexity", "app. C", "pixels drawn over pixels of the part of the screen":
        depth_complexity["P": Pixels, "screen": Pixels = 512.0 * 512.0] -> Ratio;
    "parks.depth-complexity-by-area", "4.3, footnote 5", "the same from the mean area of polygons":
        depth_complexity_by_area["N": Polygons, "area": Pixels, "screen": Pixels = 512.0 * 512.0] -> Ratio;
    "parks.time", "4.4", "time of a number of memory cycles":
        time["cycles": Cycles, "cycle": Seconds = 300e-9] -> Seconds;
};
