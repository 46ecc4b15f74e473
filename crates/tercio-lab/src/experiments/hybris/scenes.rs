//! Replacements for the scenes of document 001: the bunny and the Buddha are not part of this program.

use tercio_mesh::builtin;

use crate::experiments::ExperimentError;
use crate::predict::views;
use crate::simulators::hybris::Scene;
use crate::simulators::hybris::scene::project;

/// The largest screen with a table of 40x32 tiles (4.4); the size used in the measurements is not given.
pub const SCREEN: (u32, u32) = (1280, 1024);
/// Replaces the bunny: as many triangles, 69,451.
pub const SMALL: &str = "builtin:teapot@69451";
/// Replaces the Buddha: as many triangles, 1,087,716.
pub const LARGE: &str = "builtin:teapot@1087716";
/// The remark of every experiment with these scenes.
pub const REMARK: &str = "The document's models are not part of this program: a teapot of as many triangles, seen so \
                          that it fills 80 % of a picture of 1280x1024, takes their place. The document does not \
                          state the size of its pictures.";

/// A built-in model in partitions of 500 triangles, projected.
pub fn scene(model: &str) -> Result<Scene, ExperimentError> {
    scene_of_size(model, SCREEN)
}

/// The same in a picture of another size.
pub fn scene_of_size(model: &str, size: (u32, u32)) -> Result<Scene, ExperimentError> {
    let mesh = builtin::make(model)?;
    let camera = views::camera(&mesh.bounds(), size, 0, 1);
    Ok(project(&mesh, &camera, size)?)
}
