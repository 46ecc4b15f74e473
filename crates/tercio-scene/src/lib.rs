//! What is drawn and from where: [`Scene`], [`Camera`], [`Stereo`], [`Light`], [`Surface`].
//!
//! World space is right-handed, any unit; colours are linear light unless a name says sRGB.
//!
//! # Example
//!
//! ```
//! use tercio_mesh::builtin::{self, BuiltinError};
//! use tercio_mesh::cluster::{PartitionOptions, partition};
//! use tercio_scene::{Background, Framing, Light, Scene, View};
//!
//! let mesh = partition(builtin::make("builtin:teapot@1k")?, &PartitionOptions::default());
//! let mut scene = Scene::from_mesh(mesh);
//! scene.background = Background::Solid([1.0; 4]);
//! scene.lights.push(Light::headlight([0.2; 3]));
//!
//! let camera = Framing::new(640, 480).with_view(View::Top).camera_for_scene(&scene);
//! assert!(camera.eye.y > scene.bounds().max.y);
//! assert!(camera.basis().is_ok_and(|basis| basis.forward.y == -1.0));
//! # Ok::<(), BuiltinError>(())
//! ```

#![forbid(unsafe_code)]

pub mod camera;
pub mod color_map;
pub mod data;
pub mod edges;
pub mod environment;
pub mod framing;
pub mod light;
pub mod material;
pub mod motion;
pub mod scene;
pub mod stereo;
pub mod texture;

pub use camera::{Camera, Projection};
pub use color_map::{ColorMap, DataColors};
pub use data::{DataReader, DataSource, SurfaceData, Vertex};
pub use edges::SurfaceEdges;
pub use environment::{Environment, Panorama, PanoramaError};
pub use framing::{Framing, UpAxis, View};
pub use light::{Light, LightSpace};
pub use material::{AlphaMode, InstanceMaterials, Material, TextureMap, Wrap};
pub use motion::{CameraPath, Keyframe};
pub use scene::{Background, Instance, Scene, Share, Surface};
pub use stereo::Stereo;
pub use tercio_mesh::color::{self, srgb_to_linear};
pub use texture::Texture;
