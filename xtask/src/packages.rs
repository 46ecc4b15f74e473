//! What the checks need besides a Rust toolchain, and how to install it on Debian.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Result, ensure};

use crate::process::{find_program, is_root, output, run};

/// A program or library that has to be installed.
pub struct Need {
    /// Debian's package.
    package: &'static str,
    /// What needs it.
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
    Need { package: "openmpi-bin", purpose: "ranks over MPI", is_there: || find_program("mpirun").is_some() },
    Need {
        package: "libopenmpi-dev",
        purpose: "ranks over MPI",
        is_there: || find_program("mpicc").is_some(),
    },
    Need { package: "libclang-dev", purpose: "the bindings of MPI", is_there: has_libclang },
    Need {
        package: "pkg-config",
        purpose: "linking C programs with the installed libraries",
        is_there: || find_program("pkg-config").is_some(),
    },
];

/// Whether ranks over MPI can be built and started.
///
/// # Errors
/// Names what is missing.
pub fn check_mpi() -> Result<()> {
    let missing: Vec<_> = TESTS.iter().filter(|n| n.purpose.contains("MPI") && !(n.is_there)()).collect();
    let names: Vec<_> = missing.iter().map(|n| n.package).collect();
    ensure!(missing.is_empty(), "MPI is missing (Debian's packages {})", names.join(", "));
    Ok(())
}

/// What `cargo xtask bench` needs to measure the other programs.
pub const RIVALS: &[Need] = &[
    Need { package: "gcc", purpose: "building the rivals", is_there: || find_program("cc").is_some() },
    Need { package: "libosmesa6-dev", purpose: "llvmpipe", is_there: || has_header("GL/osmesa.h") },
    Need { package: "libembree-dev", purpose: "Embree", is_there: || has_header("embree3/rtcore.h") },
];

/// What `cargo xtask beside` compares with.
pub const RAY_TRACER: &[Need] = &[Need {
    package: "povray",
    purpose: "comparing with a ray tracer",
    is_there: || find_program("povray").is_some(),
}];

/// What `cargo xtask aarch64` needs.
pub const AARCH64: &[Need] = &[
    Need {
        package: "gcc-aarch64-linux-gnu",
        purpose: "linking for AArch64",
        is_there: || find_program("aarch64-linux-gnu-gcc").is_some(),
    },
    Need {
        package: "libc6-dev-arm64-cross",
        purpose: "the C library of AArch64",
        is_there: || Path::new("/usr/aarch64-linux-gnu/lib").is_dir(),
    },
    Need {
        package: "qemu-user",
        purpose: "running programs of AArch64",
        is_there: || find_program("qemu-aarch64").is_some(),
    },
];

/// Installs what is missing if this is Debian and the user is root; otherwise prints what is missing. A missing package
/// is no error here: what needs it fails with a message.
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
    // If there is none, the compiler prints the bare name.
    path.is_ok_and(|path| Path::new(path.trim()).is_absolute())
}

/// The library that parses C headers, in the folders of its Debian package, of `llvm-config` or of the environment.
fn has_libclang() -> bool {
    let mut folders: Vec<PathBuf> = ["/usr/lib", "/usr/lib64", "/usr/local/lib"].map(PathBuf::from).to_vec();
    folders.extend(env::var_os("LIBCLANG_PATH").map(PathBuf::from));
    folders.extend(output(Command::new("llvm-config").arg("--libdir")).map(|f| PathBuf::from(f.trim())));
    // Debian has one folder per version and one per architecture.
    let inside = fs::read_dir("/usr/lib").into_iter().flatten().flatten().map(|e| e.path());
    folders.extend(inside.flat_map(|folder| [folder.join("lib"), folder]));
    folders.iter().any(|folder| holds_libclang(folder))
}

fn holds_libclang(folder: &Path) -> bool {
    let is_it = |name: &str| {
        let library = name.starts_with("libclang.so") || name.starts_with("libclang-");
        library && name.contains(".so") && !name.starts_with("libclang-cpp")
    };
    let mut entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.any(|e| e.file_name().to_str().is_some_and(is_it))
}

/// Whether the C compiler would find a header of a library.
fn has_header(header: &str) -> bool {
    Path::new("/usr/include").join(header).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libclang_is_recognised_by_its_file_name() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["libclang-cpp.so.14", "libclangAST.a", "libclang.a", "libLLVM.so"] {
            fs::write(folder.path().join(name), "").expect("a file");
        }
        assert!(!holds_libclang(folder.path()));
        for name in ["libclang.so", "libclang.so.1", "libclang-14.so.14.0.6"] {
            let file = folder.path().join(name);
            fs::write(&file, "").expect("a file");
            assert!(holds_libclang(folder.path()), "{name}");
            fs::remove_file(file).expect("the file");
        }
        assert!(!holds_libclang(&folder.path().join("missing")));
    }
}
