//! The closed formulas of the documents: plain functions of quantities, and the [`registry`] that evaluates any of
//! them by name.
//!
//! | module | document |
//! |---|---|
//! | [`eldridge`] | 000, polygon rendering on the Princeton Engine: where to sort on a ring |
//! | [`hybris`] | 001, the Hybris renderer: sizes, rates, fixed point, plane equations |
//! | [`overlap`] | how many tiles a triangle meets, by documents 001 (Molnar and Eyles) and 003 |
//! | [`amdahl`] | speed-up with a serial part, as document 001 uses it |
//! | [`parks`] | 002, cycle costs of the splitter, interlace and hybrid machines |
//! | [`mcmanus`] | 003, area and performance of arrays of pixel processors |
//! | [`ortega`] | 004, rates and speed-ups of data-parallel rendering |
//! | [`common`] | arithmetic that several documents share: bandwidths, shares, record layouts |
//!
//! Where a document's formula is damaged or wrong, the function is the corrected one, its documentation says what was
//! corrected and why, and the printed form is kept beside it with `as_printed` in its name where both matter.

pub mod amdahl;
pub mod common;
pub mod eldridge;
pub mod hybris;
pub mod mcmanus;
pub mod ortega;
pub mod overlap;
pub mod parks;
pub mod registry;

use registry::{Glossary, Model};

/// The modules of the registry, in the order of the documents; simulators follow formulas.
const MODULES: &[&[Model]] = &[
    eldridge::geometry::MODELS,
    eldridge::planes::MODELS,
    eldridge::comparison::MODELS,
    eldridge::ring::MODELS,
    eldridge::distribution::MODELS,
    eldridge::sort_twice::MODELS,
    eldridge::placement::MODELS,
    eldridge::throughput::MODELS,
    overlap::MODELS,
    overlap::integral::MODELS,
    hybris::rates::MODELS,
    hybris::records::MODELS,
    hybris::rasterization::MODELS,
    amdahl::MODELS,
    parks::costs::MODELS,
    parks::distributions::MODELS,
    parks::scenes::MODELS,
    mcmanus::MODELS,
    mcmanus::optimum::MODELS,
    ortega::MODELS,
    common::MODELS,
];

/// The meanings of the symbols, one glossary per group of names.
const GLOSSARIES: &[&Glossary] = &[
    &eldridge::glossary::GLOSSARY,
    &overlap::GLOSSARY,
    &hybris::glossary::GLOSSARY,
    &amdahl::GLOSSARY,
    &parks::glossary::GLOSSARY,
    &mcmanus::glossary::GLOSSARY,
    &ortega::GLOSSARY,
    &common::GLOSSARY,
];
