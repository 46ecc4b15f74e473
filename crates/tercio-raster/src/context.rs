//! The immutable state of one frame, which all stages share.

use std::ops::Range;

use tercio_mesh::ClusteredMesh;
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES};
use tercio_scene::{AlphaMode, Camera, Instance, Light, Scene, Share};

use crate::cluster_set::ClusterSet;
use crate::conventions::{MAX_CLUSTERS, MAX_NUMBERS, SUBPIXELS};
use crate::data::{DataTable, check_data};
use crate::depth_bounds::{DepthBounds, blocks_across};
use crate::error::RenderError;
use crate::frame::{FragmentLayout, FragmentMerger, NO_PRIMITIVE, Outputs};
use crate::lighting::LightRig;
use crate::sampling::{FilterWeights, SampleCells, SampleCenters, SampleShading};
use crate::screen::{PixelRect, TileGrid};
use crate::settings::{Settings, Shading};
use crate::shadow_map::ObjectShadows;
use crate::surface_edges::{Footprint, check_edges};
use crate::view::{ObjectView, View};

/// The slot of a sample where nothing was drawn.
pub const NO_SLOT: u32 = u32::MAX;

/// The immutable state of a frame.
pub struct FrameContext<'a> {
    /// The scene to draw.
    pub scene: &'a Scene,
    /// The settings to draw it with.
    pub settings: &'a Settings,
    /// The camera.
    pub view: View,
    /// The view of each instance.
    pub objects: Vec<ObjectView>,
    /// The lights, in the form that the kernels use.
    pub lights: LightRig,
    /// The shadow maps as seen from each instance, if there are shadows.
    pub(crate) shadows: Vec<ObjectShadows>,
    /// Does shading need more than the common kernels do, whatever the instance: physically based shading, shadows, or spot
    /// lights?
    pub is_elaborate: bool,
    /// Of each instance that shows data, how values become colours.
    pub data: Vec<Option<DataTable>>,
    /// The tiles.
    pub grid: TileGrid,
    /// The samples of a pixel.
    pub cells: SampleCells,
    /// The centres of sets of samples.
    pub centers: SampleCenters,
    /// The filter that makes a pixel from them.
    pub filter: FilterWeights,
    /// Number of workers that the work is divided among, whatever the number of threads in the pool. It determines the
    /// tile size and which tiles are shared and how, but does not change the picture.
    pub workers: usize,
    /// Distance of the points at which a surface is shaded, in sub-pixels.
    pub shading_distance: f32,
    /// The part of the picture whose colour a shaded point has.
    pub(crate) footprint: Footprint,
    /// How near other ranks draw, in each block of pixels of the tiles that this is known of. A frame that keeps fragments then has
    /// planes, too, for the blocks that are finished without other ranks; otherwise, and where [`Self::has_blocks`] is not so, it has
    /// no effect.
    pub nearest_of_others: Option<DepthBounds>,
    /// Behind which depth nothing is drawn in each block of pixels of the tiles that this is known of, because other ranks have drawn
    /// nearer pixels in all of the block; 0 where it is not known, infinity where another rank has finished the block. Of frames
    /// that keep fragments, and where [`Self::has_blocks`] is so.
    pub hidden_by_others: Option<DepthBounds>,
    /// The clusters that the front end sorts: those that the settings select, until ranks divide them.
    pub drawn_clusters: ClusterSet,
    is_translucent: bool,
    /// Number of each instance's first cluster; one more than there are instances.
    first_cluster: Vec<u32>,
    /// Number of each instance's first primitive.
    first_primitive: Vec<u64>,
    /// Number of each instance's first input face.
    first_face: Vec<u64>,
    is_wide: bool,
}

impl<'a> FrameContext<'a> {
    /// Numbers the clusters and primitives of a scene, and divides the picture into tiles that are small enough to keep
    /// this many workers (at least one) busy.
    ///
    /// # Errors
    /// An invalid camera or setting, a scene with more clusters or triangles than can be numbered, ids of faces that do not fit
    /// into them, and the errors of [`check_range`].
    pub fn new(
        scene: &'a Scene,
        camera: &Camera,
        settings: &'a Settings,
        workers: usize,
    ) -> Result<Self, RenderError> {
        settings.check()?;
        let (width, height) = (settings.width, settings.height);
        let view = View::new(camera, &scene.bounds(), width, height)?;
        let is_translucent = scene.instances.iter().any(Instance::is_translucent);
        let mut edge = settings.tile_edge_for(workers);
        if is_translucent && settings.tile_size.is_none() {
            // The layers of a tile are many times as large as its samples.
            edge = edge.min(32);
        }
        let mut grid = TileGrid::new(width, height, edge, settings.tiles.clone());
        grid = grid.of_rows(&settings.rows());
        // The filter needs no other pixels where samples are kept.
        grid.halo = if settings.unresolved { 0 } else { settings.sampling.halo() };
        let mut first_cluster = vec![0];
        let (mut first_primitive, mut first_face) = (Vec::new(), Vec::new());
        // The numbers that come next, and how many there are.
        let (mut clusters, mut next, [mut triangles, mut faces]) = (0u64, [0u64; 2], [0u64; 2]);
        for instance in &scene.instances {
            let own = share_of(instance)?;
            let base = own.base.unwrap_or(next);
            first_primitive.push(base[0].saturating_add(own.first_triangle));
            first_face.push(base[1].saturating_add(own.first_face));
            clusters += instance.mesh.clusters().len() as u64;
            next = [base[0].saturating_add(own.triangles), base[1].saturating_add(own.faces)];
            (triangles, faces) = (triangles.max(next[0]), faces.max(next[1]));
            first_cluster.push(clusters.min(u64::from(u32::MAX)) as u32);
        }
        check_numbers(clusters, triangles, faces, settings)?;
        check_range(scene, settings, &view)?;
        check_light(scene)?;
        check_data(scene)?;
        check_edges(scene)?;
        let objects: Vec<ObjectView> = scene.instances.iter().map(|i| view.object(i)).collect();
        let lights = LightRig::new(&scene.lights, scene.environment.as_ref(), &view);
        let shadows = shadows_on(scene, &objects, camera, settings)?;
        let is_elaborate = is_elaborate(settings, &lights);
        let workers = workers.max(1);
        let shading_distance = match settings.sampling.shading {
            SampleShading::Pixel => SUBPIXELS as f32,
            SampleShading::Sample => SUBPIXELS as f32 / (settings.sampling.pattern.count() as f32).sqrt(),
        };
        Ok(Self {
            scene,
            settings,
            view,
            objects,
            lights,
            shadows,
            is_elaborate,
            data: scene.instances.iter().map(DataTable::of).collect(),
            grid,
            cells: settings.sampling.pattern.cells(),
            centers: SampleCenters::new(&settings.sampling.pattern.cells()),
            filter: FilterWeights::new(&settings.sampling),
            workers,
            shading_distance,
            footprint: Footprint::new(settings, shading_distance),
            nearest_of_others: None,
            hidden_by_others: None,
            is_translucent,
            first_cluster,
            drawn_clusters: settings.clusters.clone(),
            first_primitive,
            first_face,
            is_wide: triangles >= u64::from(NO_PRIMITIVE),
        })
    }

    /// Where lighting of an instance is computed.
    #[inline(always)]
    pub fn shading_of(&self, instance: usize) -> Shading {
        self.settings.shading.of(&self.scene.instances[instance].surface)
    }

    /// May any triangle of the scene not be opaque?
    #[inline(always)]
    pub fn is_translucent(&self) -> bool {
        self.is_translucent
    }

    /// May a triangle of this cluster not be opaque?
    #[inline(always)]
    pub fn has_translucency(&self, cluster: u32) -> bool {
        let (instance, number) = self.locate(cluster);
        let instance = &self.scene.instances[instance];
        let of_materials = || instance.materials.as_ref().is_some_and(|m| m.is_cluster_translucent(number));
        instance.surface.opacity < 1.0
            || instance
                .colors_are_translucent(instance.mesh.clusters()[number].is_translucent() || of_materials())
    }

    /// Do pixels depend on nothing but the opaque fragments in them? Not where a filter is wider than a pixel, nor where there may be layers.
    pub fn has_blocks(&self) -> bool {
        self.filter.taps.is_empty() && !self.is_translucent
    }

    /// How near other ranks draw in each block of a tile, if that is known and has an effect.
    #[inline(always)]
    pub(crate) fn others_in(&self, tile: u32) -> Option<&[f32]> {
        self.nearest_of_others.as_ref().filter(|_| self.knows_others())?.of(tile)
    }

    /// Behind which depth nothing is seen in each block of a tile, if that is known and has an effect.
    #[inline(always)]
    pub(crate) fn hidden_in(&self, tile: u32) -> Option<&[f32]> {
        self.hidden_by_others.as_ref().filter(|_| self.knows_others())?.of(tile)
    }

    /// Does what is known of other ranks have an effect?
    #[inline(always)]
    fn knows_others(&self) -> bool {
        self.settings.keep_fragments && self.has_blocks()
    }

    /// Are pixels made from fragments? Otherwise there is one sample per pixel, at which one opaque triangle is visible.
    #[inline(always)]
    pub fn has_fragments(&self) -> bool {
        self.cells.count > 1 || self.is_translucent || self.settings.keep_fragments
    }

    /// Width and height of the picture in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.view.width, self.view.height]
    }

    /// All pixels of the picture.
    #[inline(always)]
    pub fn picture(&self) -> PixelRect {
        PixelRect { x0: 0, x1: self.view.width as i32 - 1, y0: 0, y1: self.view.height as i32 - 1 }
    }

    /// Splits a range of clusters by instance. Yields the instance, the number of the first cluster in the frame, and
    /// the range of cluster numbers in the instance's mesh.
    pub fn by_instance(&self, clusters: Range<u32>) -> impl Iterator<Item = (usize, u32, Range<usize>)> {
        let first = self.first_cluster.partition_point(|&first| first <= clusters.start).max(1) - 1;
        (first..self.objects.len())
            .map(move |instance| {
                let (begin, end) = (self.first_cluster[instance], self.first_cluster[instance + 1]);
                let (from, to) = (begin.max(clusters.start), end.min(clusters.end));
                (instance, from, (from - begin) as usize..(to.max(from) - begin) as usize)
            })
            .take_while(move |&(_, from, _)| from < clusters.end)
            .filter(|(_, _, range)| !range.is_empty())
    }

    /// Number of clusters of all instances.
    pub fn clusters(&self) -> u32 {
        *self.first_cluster.last().unwrap_or(&0)
    }

    /// The instance that a cluster belongs to, and the cluster's number in the instance's mesh.
    #[inline]
    pub fn locate(&self, cluster: u32) -> (usize, usize) {
        let instance = if self.first_cluster.len() == 2 {
            0
        } else {
            self.first_cluster.partition_point(|&first| first <= cluster) - 1
        };
        (instance, (cluster - self.first_cluster[instance]) as usize)
    }

    /// Does a triangle have this slot?
    pub fn has_slot(&self, slot: u32) -> bool {
        let number = slot / MAX_TRIANGLES as u32;
        number < self.clusters() && (slot as usize % MAX_TRIANGLES) < self.cluster(number).1.triangles()
    }

    /// The instance that a cluster belongs to, and the cluster.
    #[inline(always)]
    pub fn cluster(&self, number: u32) -> (usize, ClusterView<'a>) {
        let (instance, index) = self.locate(number);
        (instance, self.scene.instances[instance].mesh.cluster(index))
    }

    /// Instance, cluster and number in the cluster of the triangle in a slot.
    #[inline]
    pub fn locate_slot(&self, slot: u32) -> (usize, ClusterView<'a>, usize) {
        let (instance, cluster) = self.cluster(slot / MAX_TRIANGLES as u32);
        (instance, cluster, slot as usize % MAX_TRIANGLES)
    }

    /// Do numbers of primitives need more than 32 bits?
    #[inline(always)]
    pub fn is_wide(&self) -> bool {
        self.is_wide
    }

    /// The numbers in the picture of the first triangle and the first input face of the whole model that an instance is, or is a
    /// part of.
    pub fn base(&self, instance: usize) -> [u64; 2] {
        let [triangle, face] =
            self.scene.instances[instance].share.map_or([0; 2], |s| [s.first_triangle, s.first_face]);
        [self.first_primitive[instance] - triangle, self.first_face[instance] - face]
    }

    /// What the fragments of a frame with these planes have.
    pub fn fragment_layout(&self, outputs: &Outputs) -> FragmentLayout {
        FragmentLayout::new(outputs, self.is_wide)
    }

    /// What merges the fragments of a frame with these planes.
    pub fn fragment_merger(&self, outputs: &Outputs) -> FragmentMerger {
        FragmentMerger {
            layout: self.fragment_layout(outputs),
            stride_bits: self.grid.needed_bits(),
            blocks_across: blocks_across(&self.grid),
        }
    }

    /// The number of the first primitive of a cluster's instance, and the cluster, which has the numbers of its triangles
    /// in the instance.
    pub fn primitives_of(&self, cluster: u32) -> (u64, ClusterView<'a>) {
        let (instance, cluster) = self.cluster(cluster);
        (self.first_primitive[instance], cluster)
    }

    /// The primitive number of the triangle in a slot, which breaks ties of depth.
    #[cold]
    pub fn primitive(&self, slot: u32) -> u64 {
        let (instance, cluster, triangle) = self.locate_slot(slot);
        self.first_primitive[instance] + u64::from(cluster.primitive(triangle))
    }

    /// The number of the input face of the triangle in a slot, as stored in the ids of a frame; of no meaning in a scene whose faces
    /// need more than 32 bits, which has no ids.
    pub fn face(&self, slot: u32) -> u32 {
        let (instance, cluster) = self.locate(slot / MAX_TRIANGLES as u32);
        let face = self.scene.instances[instance].mesh.face(cluster, slot as usize % MAX_TRIANGLES);
        (self.first_face[instance] + u64::from(face)) as u32
    }
}

/// Does shading need more than the common kernels do, whatever the instance?
pub fn is_elaborate(settings: &Settings, lights: &LightRig) -> bool {
    let has_cones = lights.near.iter().any(|light| light.cone.is_some());
    settings.shading == Shading::Physical || settings.shadows.is_some() || has_cones
}

/// The shadow maps as seen from each instance; none without shadows.
///
/// # Errors
/// [`RenderError::Setting`] if the shadows are not those of these lights and this camera.
pub(crate) fn shadows_on(
    scene: &Scene,
    objects: &[ObjectView],
    camera: &Camera,
    settings: &Settings,
) -> Result<Vec<ObjectShadows>, RenderError> {
    let Some(maps) = &settings.shadows else { return Ok(Vec::new()) };
    let made_for = &maps.made_for;
    let picture = (settings.width, settings.height);
    if made_for.lights != scene.lights
        || made_for.camera.is_some_and(|of| of != *camera)
        || made_for.picture.is_some_and(|of| of != picture)
    {
        let (range, value) =
            ("those of the scene's lights, its camera and the picture's size", "those of others");
        return Err(RenderError::Setting { what: "shadows", range: range.into(), value: value.into() });
    }
    let instances = scene.instances.iter().zip(objects);
    Ok(instances.map(|(instance, object)| ObjectShadows::new(maps, instance, object)).collect())
}

/// Fails if the coordinates of a mesh, or the requested distances, are outside the range of `f32`.
///
/// # Errors
/// [`RenderError::OutOfRange`], [`RenderError::Distances`].
pub fn check_range(scene: &Scene, settings: &Settings, view: &View) -> Result<(), RenderError> {
    const RANGE: Range<f64> = 1.0 / (1u64 << 60) as f64..(1u64 << 60) as f64;
    for (instance, Instance { mesh, .. }) in scene.instances.iter().enumerate() {
        if mesh.bounds.is_empty() {
            continue;
        }
        let bounds = mesh.local_bounds();
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        if largest > 0.0 && !RANGE.contains(&largest) {
            return Err(RenderError::OutOfRange { instance, largest });
        }
    }
    let fits = (f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&view.far);
    if settings.outputs.depth && !fits {
        return Err(RenderError::Distances { farthest: view.far });
    }
    Ok(())
}

/// Fails if clusters, triangles or faces cannot be numbered, or faces not in the ids that are requested.
fn check_numbers(clusters: u64, triangles: u64, faces: u64, settings: &Settings) -> Result<(), RenderError> {
    if clusters > MAX_CLUSTERS {
        return Err(RenderError::TooLarge { clusters });
    }
    for (what, count) in [("triangles", triangles), ("faces", faces)] {
        if count > MAX_NUMBERS {
            return Err(RenderError::TooMany { what, count });
        }
    }
    if settings.outputs.ids && faces > u64::from(NO_PRIMITIVE) {
        return Err(RenderError::Ids { faces });
    }
    Ok(())
}

/// The share of its model that an instance has; a mesh that is not a part of one is its own model.
///
/// # Errors
/// [`RenderError::Setting`] if the triangles of the mesh cannot be those of the share.
fn share_of(instance: &Instance) -> Result<Share, RenderError> {
    let (mesh, own) = (&instance.mesh, instance.mesh.triangle_count() as u64);
    let Some(share) = instance.share else {
        let (triangles, faces) = (own, faces_of(mesh));
        return Ok(Share {
            first_triangle: 0,
            triangles,
            first_face: 0,
            faces,
            base: None,
            has_whole_numbers: true,
        });
    };
    if share.first_triangle.saturating_add(own) > share.triangles || share.first_face > share.faces {
        return Err(RenderError::Setting {
            what: "share of an instance",
            range: "a range of the model's triangles".into(),
            value: format!("{own} triangles as {share:?}"),
        });
    }
    Ok(share)
}

/// Number of input faces that a mesh's triangles come from.
pub fn faces_of(mesh: &ClusteredMesh) -> u64 {
    match &mesh.face_of_triangle {
        Some(faces) => faces.last().map_or(0, |&last| u64::from(last) + 1),
        None => mesh.triangle_count() as u64,
    }
}

/// Fails if a number of the lights or surfaces is infinite or NaN: kernels skip what they multiply by zero.
///
/// # Errors
/// [`RenderError::Setting`].
pub fn check_light(scene: &Scene) -> Result<(), RenderError> {
    let finite = |what, values: &[f32]| match values.iter().find(|v| !v.is_finite()) {
        Some(v) => {
            Err(RenderError::Setting { what, range: "finite in 32 bits".into(), value: v.to_string() })
        }
        None => Ok(()),
    };
    for light in &scene.lights {
        let (Light::Ambient { color }
        | Light::Directional { color, .. }
        | Light::Wide { color, .. }
        | Light::Spot { color, .. }
        | Light::Point { color, .. }) = light;
        finite("colour of a light", color)?;
        if let Light::Spot { angle, .. } = light
            && !(*angle > 0.0 && *angle < std::f64::consts::FRAC_PI_2)
        {
            let (what, value) = ("angle of a spot light", angle.to_degrees().to_string());
            let range = "above 0 and below 90 degrees".into();
            return Err(RenderError::Setting { what, range, value });
        }
    }
    for Instance { mesh, surface, materials, .. } in &scene.instances {
        finite("colour of a surface", &surface.base_color)?;
        finite("specular of a surface", &[surface.specular])?;
        finite("roughness of a surface", &[surface.roughness])?;
        finite("metallicity of a surface", &[surface.metallic])?;
        if materials.as_ref().is_some_and(|m| !m.fit(mesh, scene)) {
            let (range, value) =
                ("made for the instance's mesh and the scene's materials", "made for others");
            return Err(RenderError::Setting {
                what: "materials of an instance",
                range: range.into(),
                value: value.into(),
            });
        }
        if !(0.0..=1.0).contains(&surface.opacity) {
            let (what, value) = ("opacity of a surface", surface.opacity.to_string());
            return Err(RenderError::Setting { what, range: "0 to 1".into(), value });
        }
    }
    for m in &scene.materials {
        for color in [&m.base_color, &m.specular, &m.emissive] {
            finite("colour of a material", color)?;
        }
        finite("number of a material", &[m.opacity, m.roughness, m.metallic, m.normal_scale])?;
        let cutoff = if let AlphaMode::Cutout(least) = m.alpha_mode { least } else { 0.0 };
        // Larger numbers would overflow.
        let limits = [
            ("cut-off of a material's alpha", cutoff, 1.0),
            ("logarithm of a material's shininess", m.shininess_log2 as f32, 10.0),
            ("absolute scale of a material's normals", m.normal_scale.abs(), 1e6),
        ];
        for (what, value, most) in limits {
            if !(0.0..=most).contains(&value) {
                let (range, value) = (format!("0 to {most}"), value.to_string());
                return Err(RenderError::Setting { what, range, value });
            }
        }
        for map in m.maps() {
            finite("position of a texture", &[map.scale, map.offset].concat())?;
            if map.texture as usize >= scene.textures.len() {
                let range = format!("below {}, the number of textures", scene.textures.len());
                let (what, value) = ("texture of a material", map.texture.to_string());
                return Err(RenderError::Setting { what, range, value });
            }
        }
    }
    Ok(())
}
