//! Models beside the checkout, which are not part of the repository.

use std::env;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The folder of the workspace's `Cargo.toml` when this crate was built.
pub fn workspace_root() -> PathBuf {
    let crate_root = Path::new(env!("CARGO_MANIFEST_DIR"));
    crate_root.ancestors().nth(2).unwrap_or(crate_root).to_path_buf()
}

/// The folder `shared/data` in or beside the checkout or one of its parent folders; `None` if there is none.
pub fn shared_data() -> Option<PathBuf> {
    find_shared(&workspace_root())
}

fn find_shared(from: &Path) -> Option<PathBuf> {
    from.ancestors().map(|folder| folder.join("shared/data")).find(|data| data.is_dir())
}

/// [`shared_data`] for a test that needs it: where it is absent, the test prints that it is skipped and returns.
///
/// # Panics
/// If the data is absent and the environment has `CI=true`: on CI no test may be skipped.
pub fn require_shared(test_name: &str) -> Option<PathBuf> {
    let found = shared_data();
    if found.is_none() {
        assert!(!on_ci(), "{test_name}: ../shared is absent, and on CI it has to be there");
        // Not `eprintln!`: the test harness captures that if the test passes.
        let _ = writeln!(std::io::stderr(), "skipped: {test_name}: ../shared is absent");
    }
    found
}

/// True if the environment has `CI=true`.
pub fn on_ci() -> bool {
    env::var_os("CI").is_some_and(|value| value == "true")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workspace_root_holds_this_crate() {
        assert!(workspace_root().join("crates/tercio-testkit/Cargo.toml").is_file());
    }

    #[test]
    fn shared_is_found_in_beside_and_above() {
        let top = tempfile::tempdir().unwrap();
        let checkout = top.path().join("a/checkout");
        std::fs::create_dir_all(&checkout).unwrap();
        assert_eq!(find_shared(&checkout).filter(|found| found.starts_with(top.path())), None);
        for place in ["shared/data", "a/shared/data", "a/checkout/shared/data"] {
            let data = top.path().join(place);
            std::fs::create_dir_all(&data).unwrap();
            assert_eq!(find_shared(&checkout), Some(data), "the nearest one wins");
        }
    }
}
