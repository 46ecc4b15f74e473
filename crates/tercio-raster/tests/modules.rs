//! The top-level modules of the crate use each other in one direction only.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The modules that each top-level module uses, by `use crate::` and paths in code.
fn uses() -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut uses = BTreeMap::<String, BTreeSet<String>>::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let inside = path.strip_prefix(&root).expect("inside the root");
            let first = inside.components().next().expect("a name").as_os_str().to_string_lossy();
            let module = first.trim_end_matches(".rs").to_owned();
            if module == "lib" {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("source text");
            let used = uses.entry(module).or_default();
            // Documentation may name what comes later.
            assert!(!text.contains("super::super"), "{}: write crate:: instead", path.display());
            let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            for name in code.flat_map(|line| line.split("crate::").skip(1)) {
                let end = name.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(name.len());
                let is_module = name.starts_with(|c: char| c.is_ascii_lowercase());
                assert!(is_module, "{}: the path crate::{name} does not say its module", path.display());
                used.insert(name[..end].to_owned());
            }
        }
    }
    let modules: BTreeSet<_> = uses.keys().cloned().collect();
    for (module, used) in &mut uses {
        used.retain(|name| name != module && modules.contains(name));
    }
    uses
}

#[test]
fn no_two_modules_use_each_other() {
    let mut uses = uses();
    assert!(uses.len() > 10 && uses["backend"].contains("projection"), "the modules were found: {uses:?}");
    // Modules that use no other are removed until none is left; those of a cycle never become free.
    while let Some(free) = uses.iter().find(|(_, used)| used.is_empty()).map(|(module, _)| module.clone()) {
        uses.remove(&free);
        uses.values_mut().for_each(|used| {
            used.remove(&free);
        });
    }
    assert!(uses.is_empty(), "these modules use each other in a cycle: {uses:?}");
}
