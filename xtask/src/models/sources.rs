//! The scanned models, read by tercio's own readers.

use std::path::{Path, PathBuf};

use anyhow::Result;
use tercio_mesh::clean::clean;
use tercio_mesh::io::{ReadOptions, read};
use tercio_mesh::normals::make_normals;
use tercio_mesh::{Mesh, subdivide::subdivide};

/// The folder of the scanned models. Each method returns `None` where they are absent.
pub struct Sources {
    shared: Option<PathBuf>,
}

impl Sources {
    pub fn find() -> Self {
        Self { shared: tercio_testkit::shared_data() }
    }

    /// 69,451 triangles.
    pub fn bunny(&self) -> Result<Option<Mesh>> {
        Ok(self.scanned("meshes/obj/stanford-bunny.obj")?.map(ready_to_draw))
    }

    /// 871,414 triangles, a few of which have no area and are dropped.
    pub fn dragon(&self) -> Result<Option<Mesh>> {
        Ok(self.scanned_dragon()?.map(ready_to_draw))
    }

    /// 16 triangles for each triangle of the dragon.
    pub fn dragon_split_twice(&self) -> Result<Option<Mesh>> {
        Ok(self.dragon()?.map(split_twice))
    }

    /// As in the file: without normals, nothing dropped.
    pub fn scanned_dragon(&self) -> Result<Option<Mesh>> {
        self.scanned("meshes/ply/dragon_vrip.ply.gz")
    }

    /// The same with 16 triangles for each.
    pub fn scanned_dragon_split_twice(&self) -> Result<Option<Mesh>> {
        Ok(self.scanned_dragon()?.map(split_twice))
    }

    fn scanned(&self, file: &str) -> Result<Option<Mesh>> {
        let Some(shared) = &self.shared else { return Ok(None) };
        Ok(Some(read(Path::new(shared).join(file), &ReadOptions::default())?.mesh))
    }
}

/// The preparation of `tercio bench`: triangles without area are dropped, and each vertex has one smooth normal.
fn ready_to_draw(mut mesh: Mesh) -> Mesh {
    clean(&mut mesh);
    if mesh.normals.is_none() {
        make_normals(&mut mesh, None);
    }
    mesh
}

fn split_twice(mesh: Mesh) -> Mesh {
    subdivide(&subdivide(&mesh))
}
