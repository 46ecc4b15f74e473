//! The laboratory: published graphics architectures rebuilt as formulas, machine descriptions and exact simulators.
//!
//! | module | what |
//! |---|---|
//! | [`units`] | quantities as types: cycles, seconds, pixels, bytes, polygons |
//! | [`mod@models`] | the closed formulas of the documents, and the registry that evaluates any of them by name |
//! | [`machines`] | descriptions of machines, each number with its source |
//! | [`workloads`] | input of the machines: boxes, screen polygons, synthetic scenes |
//! | [`simulators`] | exact simulators: the ring, raster processors, data-parallel passes, Hybris, networks |
//! | [`predict`] | the real renderer: predicted, measured, compared; the best organisation for a machine |
//! | [`experiments`] | one per published figure or table: data, plot, verdict; the report |
//! | [`published`] | every machine-checkable published number, recomputed from the model it belongs to |
//! | [`words`] | words of texts |
//!
//! # Example
//!
//! ```
//! use tercio_lab::models::registry::{self, Arguments, ModelError, Value};
//!
//! // Work of 1024 polygons on 1024 processors: geometry, and 100 pixels each. Other values are the document's.
//! let arguments = Arguments::from([("p".into(), Value::Number(1024.0)), ("R".into(), Value::Number(60.0))]);
//! let instructions = registry::evaluate("eldridge.4.1", &arguments)?;
//! assert_eq!(instructions.as_number(), Some(5000.0 + 100.0 * 60.0));
//!
//! let error = registry::evaluate("eldridge.4.1", &Arguments::new()).unwrap_err();
//! assert!(matches!(error, ModelError::Missing { name: "p", .. }));
//! # Ok::<(), ModelError>(())
//! ```

#![forbid(unsafe_code)]

pub mod experiments;
pub mod machines;
pub mod models;
pub mod predict;
pub mod published;
pub mod simulators;
pub mod units;
pub mod words;
pub mod workloads;
