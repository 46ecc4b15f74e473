//! Options of `tercio bench` for scenes other than one model that turns.

use std::sync::Arc;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio::glam::{DAffine3, DVec3};
use tercio::mesh::{Aabb, ClusteredMesh};
use tercio::raster::LastStage;
use tercio::scene::{Camera, Framing, Light, Scene};

use super::values;

/// A fixed camera: every frame shows the same view.
#[derive(Clone, Debug, Args)]
pub struct StillArgs {
    /// Position of the camera in every frame, instead of moving round the model.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    eye: Option<DVec3>,
    /// What the camera at --eye looks at [default: the middle of the model].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector)]
    #[arg(requires = "eye")]
    target: Option<DVec3>,
    /// Vertical angle of view of the camera at --eye, degrees [default: 30].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = values::field_of_view)]
    #[arg(requires = "eye")]
    fov: Option<f64>,
}

impl StillArgs {
    /// The camera for something with these bounds; `None` if it moves round the model.
    pub fn camera(&self, bounds: &Aabb, (width, height): (u32, u32)) -> Option<Camera> {
        let mut framing = Framing::new(width, height);
        framing.fov_y = Some(self.fov.unwrap_or(Framing::FOV_Y));
        Some(framing.camera_at(self.eye?, self.target.unwrap_or_else(|| bounds.center()), None))
    }
}

/// How the model looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LookName {
    /// As `tercio render` draws it: three lights that go with the camera, highlights.
    Default,
    /// One light, no highlights: the little shading that other renderers do in comparisons.
    Plain,
}

impl LookName {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Plain => "plain",
        }
    }

    /// Strength of all highlights, if they are not those of the model.
    pub fn specular(self) -> Option<f32> {
        (self == Self::Plain).then_some(0.0)
    }

    /// A model with this look.
    pub fn scene(self, mesh: Arc<ClusteredMesh>) -> Scene {
        let mut scene = Scene::from_mesh(mesh);
        if self == Self::Plain {
            scene.lights = vec![Light::Ambient { color: [0.1; 3] }, Light::headlight([0.9; 3])];
            scene.instances[0].surface.specular = self.specular().unwrap_or_default();
        }
        scene
    }
}

/// Positions of the copies of a model: a cubic grid, row by row, centred on the model's own position.
pub struct Copies {
    offsets: Vec<DVec3>,
}

impl Copies {
    /// Distance between centres, in longest edges of the model's box.
    const SPACING: f64 = 1.5;

    /// Positions for `count` copies of a model with these bounds.
    pub fn new(count: u32, bounds: &Aabb) -> Self {
        let edge = (1u32..).find(|&e| u64::from(e).pow(3) >= u64::from(count)).unwrap_or(1);
        let step = bounds.size().max_element() * Self::SPACING;
        let at = |i: u32| (f64::from(i) - f64::from(edge - 1) * 0.5) * step;
        let offset = |i: u32| DVec3::new(at(i % edge), at(i / edge % edge), at(i / (edge * edge)));
        Self { offsets: if count == 1 { vec![DVec3::ZERO] } else { (0..count).map(offset).collect() } }
    }

    /// Adds instances so that the scene's one instance is at all the positions.
    pub fn place(&self, scene: &mut Scene) {
        let first = scene.instances[0].clone();
        scene.instances.clear();
        scene.instances.extend(self.offsets.iter().map(|&offset| {
            let mut copy = first.clone();
            copy.world_from_object = DAffine3::from_translation(offset);
            copy
        }));
    }

    /// Offset of each copy, x, y, z.
    pub fn json(&self) -> Value {
        json!(self.offsets.iter().map(|o| o.to_array()).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_fill_a_cube_round_the_model() {
        let bounds = Aabb { min: DVec3::new(3.0, 0.0, 0.0), max: DVec3::new(5.0, 1.0, 1.0) };
        assert_eq!(Copies::new(1, &bounds).offsets, [DVec3::ZERO]);
        let eight = Copies::new(8, &bounds).offsets;
        assert_eq!((eight[0], eight[7]), (DVec3::splat(-1.5), DVec3::splat(1.5)));
        assert_eq!(Copies::new(1000, &bounds).offsets.len(), 1000);
        assert_eq!(eight.iter().sum::<DVec3>(), DVec3::ZERO);
    }
}

/// A stage of the pipeline after which the work may stop.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StageName {
    /// Clusters are tested.
    Cull,
    /// Clusters and triangles are sorted into tiles.
    Bin,
    /// Triangles that reach a sample are found in each tile.
    Sieve,
    /// The visible triangle of each sample is known.
    Visibility,
}

impl StageName {
    /// The renderer's value.
    pub fn stage(self) -> LastStage {
        match self {
            Self::Cull => LastStage::Cull,
            Self::Bin => LastStage::Bin,
            Self::Sieve => LastStage::Sieve,
            Self::Visibility => LastStage::Visibility,
        }
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cull => "cull",
            Self::Bin => "bin",
            Self::Sieve => "sieve",
            Self::Visibility => "visibility",
        }
    }
}
