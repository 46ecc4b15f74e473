//! Chapter 4: where to sort, compared by instructions (equations 4.1 to 4.12, and 5.1).
//!
//! A region holds f o p/n polygons of A/o pixels each, so the fullest region rasterizes f A p/n pixels. The document
//! prints A/o for that term in equations 4.2, 4.3, 4.8, 4.12, 5.1 and 6.1, yet its numbers 60,123 (4.12) and 75 % (5.1)
//! result only without the division. The functions here use f A R; the printed forms are kept beside them.

use super::sort_twice::grouped_sort_middle;
use super::{AREA, ASYMMETRY, DESCRIPTOR_PASS, GEOMETRY, OVERLAP, PROCESSORS, RASTER, SCREEN};
use crate::models;
use crate::models::registry::Model;
use crate::units::{Hertz, Instructions, Pixels, Polygons, Processors, Ratio, Seconds};

/// The cost of a polygon, in the document's symbols.
fn per_polygon(geometry: Instructions, area: Pixels, raster: Instructions) -> Instructions {
    geometry + raster * area.get()
}

/// Equation 4.1: time without communication, overlap and imbalance. Instructions of the slowest processor, like all
/// times of this chapter.
pub fn optimal(
    p: Polygons,
    n: Processors,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
) -> Instructions {
    per_polygon(geometry, area, raster) * (p.get() / n.get())
}

/// Equation 4.2 with the raster term f A R: sort-first, whose communication is assumed to be free.
pub fn sort_first(
    p: Polygons,
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
) -> Instructions {
    (geometry * o.get() + raster * area.get()) * (f.get() * p.get() / n.get())
}

/// Equation 4.2 as it is printed, with the raster term f A R / o.
pub fn sort_first_as_printed(
    p: Polygons,
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
) -> Instructions {
    sort_first(p, n, f, o, geometry, area / o.get(), raster)
}

/// Equation 4.3 with the raster term f A R: sort-middle; every descriptor visits all processors. It is equation 6.1
/// with one group.
pub fn sort_middle(
    p: Polygons,
    n: Processors,
    f: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Instructions {
    grouped_sort_middle(p, n, n, f, geometry, area, raster, pass)
}

/// Equation 4.3 as it was printed, with the raster term f A R / o; the scan has lost G and A, equation 4.8 has them.
#[expect(clippy::too_many_arguments, reason = "the symbols of the equation")]
pub fn sort_middle_as_printed(
    p: Polygons,
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Instructions {
    sort_middle(p, n, f, geometry, area / o.get(), raster, pass)
}

/// Equation 4.4: dense sort-last; every pixel of the screen visits its neighbour, `pass` each.
pub fn sort_last_dense(
    p: Polygons,
    n: Processors,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    screen: Pixels,
    pass: Instructions,
) -> Instructions {
    optimal(p, n, geometry, area, raster) + dense_composite(screen, pass)
}

/// Equation 4.5: sparse sort-last; every rasterized pixel visits all processors, `pass` to each neighbour.
pub fn sort_last_sparse(
    p: Polygons,
    n: Processors,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Instructions {
    optimal(p, n, geometry, area, raster) + pass * (area.get() * p.get())
}

/// Instructions of the composition of dense sort-last (4.4.3).
pub fn dense_composite(screen: Pixels, pass: Instructions) -> Instructions {
    pass * screen.get()
}

/// Its time.
pub fn dense_composite_time(screen: Pixels, pass: Instructions, clock: Hertz) -> Seconds {
    dense_composite(screen, pass) / clock
}

/// Equation 4.10: sort-middle beats sort-first where f o is above this.
pub fn sort_first_threshold(n: Processors, pass: Instructions, geometry: Instructions) -> Ratio {
    Ratio::new(1.0 + pass * n.get() / geometry)
}

/// f o: the factor of redundant geometry work in sort-first (4.4.1).
pub fn sort_first_penalty(f: Ratio, o: Ratio) -> Ratio {
    f * o.get()
}

/// Equation 4.7: time of sort-middle over that of sort-first (4.4.1); below 1 sort-middle wins. The number of polygons
/// does not matter.
pub fn sort_middle_to_first(
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Ratio {
    let p = Polygons::new(n.get());
    let middle = sort_middle(p, n, f, geometry, area, raster, pass);
    Ratio::new(middle / sort_first(p, n, f, o, geometry, area, raster))
}

/// Equation 4.8: [`sort_middle_to_first`] with both raster terms as printed, f A R / o.
pub fn sort_middle_to_first_as_printed(
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    area: Pixels,
    raster: Instructions,
    pass: Instructions,
) -> Ratio {
    sort_middle_to_first(n, f, o, geometry, area / o.get(), raster, pass)
}

/// Equation 4.9: geometry and communication of sort-middle over the geometry of sort-first: equation 4.8 after the
/// raster terms cancel; below 1 sort-middle wins.
pub fn geometry_to_first(
    n: Processors,
    f: Ratio,
    o: Ratio,
    geometry: Instructions,
    pass: Instructions,
) -> Ratio {
    Ratio::new((geometry + pass * n.get()) / (geometry * sort_first_penalty(f, o).get()))
}

/// Equation 4.11: dense sort-last beats sparse above this many polygons.
pub fn dense_crossover(screen: Pixels, dense: Instructions, area: Pixels, sparse: Instructions) -> Polygons {
    Polygons::new((dense * screen.get()) / (sparse * area.get()))
}

/// Equation 4.12 with the raster term f A R: dense sort-last beats sort-middle above this many polygons.
pub fn sort_last_crossover(
    screen: Pixels,
    dense: Instructions,
    middle: Instructions,
    f: Ratio,
    area: Pixels,
    raster: Instructions,
    n: Processors,
) -> Polygons {
    let imbalance = raster * ((f.get() - 1.0) * area.get() / n.get());
    Polygons::new(dense * screen.get() / (middle + imbalance))
}

/// Equation 4.12 as it is printed, with f/o in place of f.
#[expect(clippy::too_many_arguments, reason = "the symbols of the equation")]
pub fn sort_last_crossover_as_printed(
    screen: Pixels,
    dense: Instructions,
    middle: Instructions,
    f: Ratio,
    o: Ratio,
    area: Pixels,
    raster: Instructions,
    n: Processors,
) -> Polygons {
    sort_last_crossover(screen, dense, middle, f / o.get(), area, raster, n)
}

/// Equation 5.1 with the raster term f A R: the share of communication in sort-middle.
pub fn communication_share(
    n: Processors,
    pass: Instructions,
    geometry: Instructions,
    f: Ratio,
    area: Pixels,
    raster: Instructions,
) -> Ratio {
    let communication = pass * n.get();
    Ratio::new(communication / (communication + per_polygon(geometry, area * f.get(), raster)))
}

/// Equation 5.1 as it is printed, with the raster term f A R / o.
pub fn communication_share_as_printed(
    n: Processors,
    pass: Instructions,
    geometry: Instructions,
    f: Ratio,
    o: Ratio,
    area: Pixels,
    raster: Instructions,
) -> Ratio {
    communication_share(n, pass, geometry, f, area / o.get(), raster)
}

/// The asymmetry factor f by its definition in table 4.1: polygons in the fullest region over the mean. Figure 4-1
/// gives 394 / 23.3 = 16.9; the 4.4 of table 4.3 is that divided by o once more.
pub fn asymmetry(max: Polygons, mean: Polygons) -> Ratio {
    Ratio::new(max / mean)
}

/// Mean polygons per region, overlap included (figure 4-1).
pub fn mean_per_region(visible: Polygons, o: Ratio, n: Processors) -> Polygons {
    visible * (o.get() / n.get())
}

pub(crate) const MODELS: &[Model] = models! {
    "eldridge.4.1", "eq 4.1", "instructions of the work alone":
        optimal["p": Polygons, "n": Processors = PROCESSORS, "G": Instructions = GEOMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER] -> Instructions;
    "eldridge.4.2", "eq 4.2", "instructions of sort-first, raster term f A R":
        sort_first["p": Polygons, "n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP,
            "G": Instructions = GEOMETRY, "A": Pixels = AREA, "R": Instructions = RASTER] -> Instructions;
    "eldridge.4.2-as-printed", "eq 4.2", "the same as printed, raster term f A R / o":
        sort_first_as_printed["p": Polygons, "n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY,
            "o": Ratio where 1.0 = OVERLAP, "G": Instructions = GEOMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER] -> Instructions;
    "eldridge.4.3", "eq 4.3", "instructions of sort-middle, raster term f A R":
        sort_middle["p": Polygons, "n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY, "G": Instructions = GEOMETRY,
            "A": Pixels = AREA, "R": Instructions = RASTER, "C": Instructions = DESCRIPTOR_PASS] -> Instructions;
    "eldridge.4.3-as-printed", "eq 4.3", "the same as printed, raster term f A R / o":
        sort_middle_as_printed["p": Polygons, "n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY,
            "o": Ratio where 1.0 = OVERLAP, "G": Instructions = GEOMETRY, "A": Pixels = AREA, "R": Instructions = RASTER,
            "C": Instructions = DESCRIPTOR_PASS] -> Instructions;
    "eldridge.4.4", "eq 4.4", "instructions of dense sort-last":
        sort_last_dense["p": Polygons, "n": Processors = PROCESSORS, "G": Instructions = GEOMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER, "Q": Pixels = SCREEN, "C": Instructions = 24.0] -> Instructions;
    "eldridge.4.5", "eq 4.5", "instructions of sparse sort-last":
        sort_last_sparse["p": Polygons, "n": Processors = PROCESSORS, "G": Instructions = GEOMETRY,
            "A": Pixels = AREA, "R": Instructions = RASTER, "C": Instructions = 45.0] -> Instructions;
    "eldridge.dense-composite", "4.4.3", "instructions of dense sort-last's composition":
        dense_composite["Q": Pixels = SCREEN, "C": Instructions = 24.0] -> Instructions;
    "eldridge.dense-composite-time", "4.4.3", "time of dense sort-last's composition":
        dense_composite_time["Q": Pixels = SCREEN, "C": Instructions = 24.0, "clock": Hertz = super::CLOCK] -> Seconds;
    "eldridge.4.10", "eq 4.10", "f o above which sort-middle beats sort-first":
        sort_first_threshold["n": Processors = PROCESSORS, "C": Instructions = DESCRIPTOR_PASS,
            "G": Instructions = GEOMETRY] -> Ratio;
    "eldridge.fo", "4.4.1", "f o of a scene":
        sort_first_penalty["f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP] -> Ratio;
    "eldridge.4.7", "eq 4.7", "time of sort-middle over that of sort-first, raster terms f A R":
        sort_middle_to_first["n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP,
            "G": Instructions = GEOMETRY, "A": Pixels = AREA, "R": Instructions = RASTER,
            "C": Instructions = DESCRIPTOR_PASS] -> Ratio;
    "eldridge.4.8-as-printed", "eq 4.8", "time of sort-middle over that of sort-first, raster terms f A R / o":
        sort_middle_to_first_as_printed["n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP,
            "G": Instructions = GEOMETRY, "A": Pixels = AREA, "R": Instructions = RASTER,
            "C": Instructions = DESCRIPTOR_PASS] -> Ratio;
    "eldridge.4.9", "eq 4.9", "4.8 without its equal raster terms":
        geometry_to_first["n": Processors = PROCESSORS, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP,
            "G": Instructions = GEOMETRY, "C": Instructions = DESCRIPTOR_PASS] -> Ratio;
    "eldridge.4.11", "eq 4.11", "polygons above which dense sort-last beats sparse":
        dense_crossover["Q": Pixels = SCREEN, "C_dense": Instructions = 24.0, "A": Pixels = AREA,
            "C_sparse": Instructions = 45.0] -> Polygons;
    "eldridge.4.12", "eq 4.12", "polygons above which dense sort-last beats sort-middle, raster term f A R":
        sort_last_crossover["Q": Pixels = SCREEN, "C_dense": Instructions = 24.0,
            "C_sm": Instructions = DESCRIPTOR_PASS, "f": Ratio where 1.0 = ASYMMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER, "n": Processors = PROCESSORS] -> Polygons;
    "eldridge.4.12-as-printed", "eq 4.12", "the same as printed, f / o in place of f":
        sort_last_crossover_as_printed["Q": Pixels = SCREEN, "C_dense": Instructions = 29.0,
            "C_sm": Instructions = DESCRIPTOR_PASS, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP, "A": Pixels = AREA,
            "R": Instructions = RASTER, "n": Processors = PROCESSORS] -> Polygons;
    "eldridge.5.1", "eq 5.1", "share of communication in sort-middle, raster term f A R":
        communication_share["n": Processors = PROCESSORS, "C": Instructions = DESCRIPTOR_PASS,
            "G": Instructions = GEOMETRY, "f": Ratio where 1.0 = ASYMMETRY, "A": Pixels = AREA,
            "R": Instructions = RASTER] -> Ratio;
    "eldridge.5.1-as-printed", "eq 5.1", "the same as printed, raster term f A R / o":
        communication_share_as_printed["n": Processors = PROCESSORS, "C": Instructions = DESCRIPTOR_PASS,
            "G": Instructions = GEOMETRY, "f": Ratio where 1.0 = ASYMMETRY, "o": Ratio where 1.0 = OVERLAP, "A": Pixels = AREA,
            "R": Instructions = RASTER] -> Ratio;
    "eldridge.asymmetry", "table 4.1", "f: polygons of the fullest region over the mean":
        asymmetry["max": Polygons, "mean": Polygons] -> Ratio;
    "eldridge.mean-per-region", "fig 4-1", "mean polygons per region, overlap included":
        mean_per_region["visible": Polygons, "o": Ratio where 1.0 = OVERLAP, "n": Processors = PROCESSORS] -> Polygons;
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossovers_are_where_the_curves_meet() {
        let (n, q) = (Processors::new(1024.0), Pixels::new(393_216.0));
        let (g, a, r) = (Instructions::new(5000.0), Pixels::new(100.0), Instructions::new(100.0));
        let (dense, sparse, middle) =
            (Instructions::new(24.0), Instructions::new(45.0), Instructions::new(156.0));
        let f = Ratio::new(4.4);
        let p = dense_crossover(q, dense, a, sparse);
        let difference = sort_last_dense(p, n, g, a, r, q, dense) / sort_last_sparse(p, n, g, a, r, sparse);
        assert!((difference - 1.0).abs() < 1e-12);
        let p = sort_last_crossover(q, dense, middle, f, a, r, n);
        let difference = sort_last_dense(p, n, g, a, r, q, dense) / sort_middle(p, n, f, g, a, r, middle);
        assert!((difference - 1.0).abs() < 1e-12);
    }

    #[test]
    fn at_the_threshold_sort_first_and_sort_middle_take_the_same_time() {
        let (n, p) = (Processors::new(1024.0), Polygons::new(5000.0));
        let (g, a, r) = (Instructions::new(5000.0), Pixels::new(100.0), Instructions::new(100.0));
        let c = Instructions::new(156.0);
        let o = Ratio::new(3.8);
        let f = Ratio::new(sort_first_threshold(n, c, g).get() / o.get());
        let ratio = sort_middle(p, n, f, g, a, r, c) / sort_first(p, n, f, o, g, a, r);
        assert!((ratio - 1.0).abs() < 1e-12);
        // The raster terms are the same on both sides, so neither they nor p move the threshold.
        assert!((sort_middle_to_first(n, f, o, g, a, r, c).get() - 1.0).abs() < 1e-12);
        assert!((geometry_to_first(n, f, o, g, c).get() - 1.0).abs() < 1e-12);
        assert!((sort_middle_to_first_as_printed(n, f, o, g, a, r, c).get() - 1.0).abs() < 1e-12);
    }
}
