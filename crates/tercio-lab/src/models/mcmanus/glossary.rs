//! The symbols of document 003, and what its formulas assume.

use crate::models::registry::Glossary;

pub(crate) const GLOSSARY: Glossary = Glossary {
    group: "mcmanus",
    document: Some("003"),
    symbols: &[
        ("A", "side of the array of pixel processors, which is that of a screen region"),
        ("mcmanus.largest-deviation/A", "sides of the arrays"),
        ("N", "mean area of the polygons' bounding boxes"),
        ("P", "polygons a second of the renderer"),
        ("R", "area of the renderer's silicon"),
        ("R_A", "raster cycles of the picture with this array"),
        ("mcmanus.largest-deviation/R_A", "raster cycles of the picture with each array"),
        ("mcmanus.optimal-measured/R_A", "raster cycles of the picture with the sides 1, 2, 4, ... 512"),
        ("T", "raster cycles a second"),
        ("X", "pixel processors of the machine"),
        ("cycle", "time of a raster cycle"),
        ("points", "[polygons a second, area of the die, microprocessors] of each geometry engine"),
        ("polygons", "polygons of the picture"),
        ("renderers", "arrays that share the picture"),
        ("w", "side of a square bounding box"),
    ],
    assumptions: &[
        (
            &[
                "mcmanus.6*",
                "mcmanus.7",
                "mcmanus.8",
                "mcmanus.9",
                "mcmanus.10",
                "mcmanus.12",
                "mcmanus.13",
                "mcmanus.13-by-search",
                "mcmanus.14*",
                "mcmanus.rate-slope",
                "mcmanus.optimal-power-of-two",
                "mcmanus.largest-deviation",
            ],
            "square boxes of one size, whole pixels wide, equally likely at every position",
        ),
        (
            &["mcmanus.7", "mcmanus.measured-rate", "mcmanus.9", "mcmanus.14*"],
            "a raster cycle for each polygon in each region, whatever its size; perfect balance",
        ),
        (
            &[
                "mcmanus.1",
                "mcmanus.geometry-area",
                "mcmanus.array-area",
                "mcmanus.8",
                "mcmanus.9",
                "mcmanus.10",
                "mcmanus.12",
                "mcmanus.13*",
                "mcmanus.optimal*",
            ],
            "0.000871 in2 a pixel processor; 7.4645e-7 in2 for each polygon a second and 1.3673 in2 of geometry engine",
        ),
        (
            &["mcmanus.11*", "mcmanus.13-of-11"],
            "i = sqrt N / A + 0.5, and i^2 + 1 regions where equation 6 has i^2 + i",
        ),
        (&["mcmanus.14"], "A^2 <= X"),
        (&["mcmanus.frame-time"], "perfect balance between the arrays"),
    ],
};
