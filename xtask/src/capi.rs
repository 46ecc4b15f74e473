//! `cargo xtask capi`: libraries for C, with their header and a file for pkg-config.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use crate::process::{cargo, run as run_command, target_folder};
use crate::{header, packages};

/// Arguments of `cargo xtask capi`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder to install to: include, lib and lib/pkgconfig are made in it
    #[arg(long, value_name = "FOLDER")]
    prefix: PathBuf,
    /// Sessions of several processes: needs an MPI installation (mpicc) and libclang
    #[arg(long)]
    mpi: bool,
    /// Install the libraries that are in this folder, instead of building them
    #[arg(long, value_name = "FOLDER")]
    built: Option<PathBuf>,
}

/// The name by which programs find the shared library when they start: its number changes with what programs have to be compiled for
/// again.
const SONAME: &str = "libtercio.so.0";

/// Builds the libraries, and installs them.
///
/// # Errors
/// They do not build, or a file cannot be written.
pub fn run(arguments: &Arguments) -> Result<()> {
    ensure!(cfg!(target_os = "linux"), "the libraries for C are made on Linux only");
    if arguments.mpi {
        packages::check_mpi()?;
    }
    let built = match &arguments.built {
        Some(folder) => folder.clone(),
        None => build(arguments.mpi)?,
    };
    let prefix = std::path::absolute(&arguments.prefix)?;
    for path in install(&prefix, &built, arguments.mpi)? {
        println!("{}", path.display());
    }
    Ok(())
}

/// Builds the libraries; returns the folder that they are in.
fn build(mpi: bool) -> Result<PathBuf> {
    let features = if mpi { "library,mpi" } else { "library" };
    let package = ["rustc", "--release", "--package", "tercio-capi", "--example", "tercio", "--features"];
    let soname = format!("link-arg=-Wl,-soname,{SONAME}");
    run_command(cargo().args(package).args([features, "--", "-C", &soname]))?;
    Ok(target_folder()?.join("release/examples"))
}

/// Copies what was built; returns what is there then.
fn install(prefix: &Path, built: &Path, mpi: bool) -> Result<Vec<PathBuf>> {
    let [include, lib] = ["include", "lib"].map(|folder| prefix.join(folder));
    let pkgconfig = lib.join("pkgconfig");
    for folder in [&include, &pkgconfig] {
        fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    }
    let [shared, archive] = ["libtercio.so", "libtercio.a"].map(|name| built.join(name));
    let copies = [
        (header::path(), include.join("tercio.h")),
        (shared, lib.join(SONAME)),
        (archive, lib.join("libtercio.a")),
    ];
    let mut installed = Vec::new();
    for (from, to) in copies {
        // Programs that run keep the library that they have.
        let unfinished = to.with_extension("unfinished");
        fs::copy(&from, &unfinished).with_context(|| format!("copying {}", from.display()))?;
        fs::rename(&unfinished, &to).with_context(|| format!("writing {}", to.display()))?;
        installed.push(to);
    }
    let link = lib.join("libtercio.so");
    if fs::symlink_metadata(&link).is_ok() {
        fs::remove_file(&link).with_context(|| format!("replacing {}", link.display()))?;
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(SONAME, &link).with_context(|| format!("writing {}", link.display()))?;
    installed.push(link);
    let description = pkgconfig.join("tercio.pc");
    fs::write(&description, pc(prefix, mpi)).with_context(|| format!("writing {}", description.display()))?;
    installed.push(description);
    Ok(installed)
}

/// The file for pkg-config. MPI itself is left to mpicc.
fn pc(prefix: &Path, mpi: bool) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let kind = if mpi { "with MPI: use mpicc" } else { "without MPI" };
    format!(
        "prefix={}\n\
         includedir=${{prefix}}/include\n\
         libdir=${{prefix}}/lib\n\
         \n\
         Name: tercio\n\
         Description: In-situ drawing of polygon models, {kind}\n\
         Version: {version}\n\
         Cflags: -I${{includedir}}\n\
         Libs: -L${{libdir}} -ltercio\n\
         Libs.private: -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc\n",
        prefix.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_are_installed_again_and_again() {
        let top = tempfile::tempdir().expect("a folder");
        let [built, prefix] = ["built", "prefix"].map(|name| top.path().join(name));
        fs::create_dir(&built).expect("a folder");
        for version in ["first", "second"] {
            for name in ["libtercio.so", "libtercio.a"] {
                fs::write(built.join(name), version).expect("a file");
            }
            let installed = install(&prefix, &built, false).expect("installed");
            let names: Vec<_> =
                installed.iter().map(|path| path.strip_prefix(&prefix).expect("inside")).collect();
            let expected = [
                "include/tercio.h",
                "lib/libtercio.so.0",
                "lib/libtercio.a",
                "lib/libtercio.so",
                "lib/pkgconfig/tercio.pc",
            ];
            assert_eq!(names, expected.map(Path::new));
            for name in ["lib/libtercio.so", "lib/libtercio.a"] {
                assert_eq!(fs::read_to_string(prefix.join(name)).expect("a file"), version);
            }
        }
        fs::remove_file(built.join("libtercio.a")).expect("the file");
        let error = install(&prefix, &built, false).expect_err("a library is missing").to_string();
        assert!(error.ends_with("built/libtercio.a"), "{error}");
    }
}
