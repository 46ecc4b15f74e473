//! What the checks need beside a Rust toolchain, and how a Debian machine gets it.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};

use crate::process::{find_program, is_root, output, run};

/// Something that has to be on the machine.
pub struct Need {
    /// Debian's package.
    package: &'static str,
    /// What misses it.
    purpose: &'static str,
    is_there: fn() -> bool,
}

/// What `cargo xtask test` needs.
pub const TESTS: &[Need] = &[
    Need { package: "g++", purpose: "libFuzzer", is_there: || find_program("c++").is_some() },
    Need { package: "libc6-dev", purpose: "the static binary", is_there: has_static_libc },
    Need { package: "coreutils", purpose: "chroot", is_there: || find_program("chroot").is_some() },
    Need {
        package: "valgrind",
        purpose: "counting instructions",
        is_there: || find_program("valgrind").is_some(),
    },
];

/// What `cargo xtask bench` needs to measure others.
pub const RIVALS: &[Need] = &[
    Need { package: "gcc", purpose: "building the rivals", is_there: || find_program("cc").is_some() },
    Need { package: "libosmesa6-dev", purpose: "llvmpipe", is_there: || has_header("GL/osmesa.h") },
    Need { package: "libembree-dev", purpose: "Embree", is_there: || has_header("embree3/rtcore.h") },
];

/// Installs what is missing if this is Debian and the user is root; says what is missing otherwise. A
/// missing package is no error here: what needs it fails and tells why.
pub fn provide(needs: &[Need]) {
    let missing: Vec<_> = needs.iter().filter(|need| !(need.is_there)()).collect();
    if missing.is_empty() {
        return;
    }
    for need in &missing {
        eprintln!("missing for {}: Debian's package {}", need.purpose, need.package);
    }
    if find_program("apt-get").is_none() || !is_root() {
        return;
    }
    if let Err(error) = install(&missing) {
        eprintln!("warning: {error:#}");
    }
}

fn install(missing: &[&Need]) -> Result<()> {
    let apt = || {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive").arg("--quiet");
        command
    };
    run(apt().arg("update"))?;
    run(apt().args(["install", "--yes", "--no-install-recommends"]).args(missing.iter().map(|n| n.package)))?;
    for need in missing {
        ensure!((need.is_there)(), "{} is installed, but not what {} needs", need.package, need.purpose);
    }
    Ok(())
}

/// Distributions other than Debian have the static C library in a package of its own.
pub fn has_static_libc() -> bool {
    let path = output(Command::new("cc").arg("-print-file-name=libc.a"));
    // Without one, the compiler gives back the bare name.
    path.is_ok_and(|path| Path::new(path.trim()).is_absolute())
}

/// Whether the C compiler would find a header of a library.
fn has_header(header: &str) -> bool {
    Path::new("/usr/include").join(header).is_file()
}
