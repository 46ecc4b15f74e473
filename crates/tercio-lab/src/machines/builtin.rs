//! The built-in machines.

use super::description::{Machine, parse};
use super::error::MachineError;

/// Declares the table of names and texts; names are those of the files.
macro_rules! machines {
    ($($name:literal),+ $(,)?) => {
        /// Names of the built-in machines, the documents' machines first.
        pub const NAMES: &[&str] = &[$($name),+];
        const TEXTS: &[&str] = &[$(include_str!(concat!("descriptions/", $name, ".toml"))),+];
    };
}

machines! {
    "princeton-engine", "magic-1", "parks-uniprocessor", "parks-splitter", "parks-interlace", "parks-hybrid",
    "mcmanus-array", "cm-200", "cm-5", "pixelflow", "hybris-single-cpu", "hybris-dual-cpu", "hybris-asic",
    "hybris-asic-2x2", "hybris-asic-two-engines", "hybris-fpga", "sgi-gtx", "sgi-reality-engine",
    "pixel-planes-5", "voodoo-sli", "rage-fury-maxx", "metabyte-pgc", "wildcat-parascale", "powervr-naomi-2",
    "vc-1", "pomegranate", "intrepid", "stampede2-skx", "stampede2-knl", "theta", "slic-cluster",
    "two-core-2026", "server-128", "cluster-64",
}

/// A built-in machine; `None` if there is none of this name.
pub fn builtin(name: &str) -> Option<Result<Machine, MachineError>> {
    let k = NAMES.iter().position(|n| *n == name)?;
    Some(parse(&format!("{name}.toml"), TEXTS[k]))
}
