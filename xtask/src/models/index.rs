//! The index of a folder of models.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::{Deserialize, Serialize};
use tercio_mesh::Mesh;

const FILE: &str = "index.json";

/// One file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Model {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Triangles in it.
    pub triangles: u64,
    /// The centre of its bounding box, object space.
    pub center: [f64; 3],
    /// The longest edge of that box.
    pub extent: f64,
}

/// The files of a folder by name.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Index {
    models: BTreeMap<String, Model>,
}

impl Index {
    /// The file of this name; `None` if it was skipped.
    pub fn get(&self, name: &str) -> Option<&Model> {
        self.models.get(name)
    }

    pub(super) fn add(&mut self, name: &str, path: &Path, mesh: &Mesh) -> Result<()> {
        let bounds = mesh.bounds();
        let model = Model {
            path: path.into(),
            bytes: std::fs::metadata(path)?.len(),
            triangles: mesh.triangles.len() as u64,
            center: bounds.center().to_array(),
            extent: bounds.size().max_element(),
        };
        self.models.insert(name.into(), model);
        Ok(())
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        Ok(std::fs::write(folder.join(FILE), serde_json::to_string_pretty(self)?)?)
    }

    pub(super) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("reading {}", path.display()))
    }
}
