//! Do all ranks draw the same frame? Ranks that load different models, or run with different options, would otherwise compose
//! a wrong picture, or wait for each other for ever.

use std::fmt::{self, Debug};

use bytemuck::{Pod, Zeroable, bytes_of, pod_read_unaligned};
use tercio_mesh::checksum;
use tercio_raster::{ClusterSet, Settings, TileSet};
use tercio_scene::{Instance, Scene, SurfaceEdges};

use crate::ParallelError;
use crate::comm::{CommError, Communicator, children, parent};
use crate::organisation::{Task, tile_edge};

/// That of this build.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What ranks have to agree on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Matter {
    /// The version of tercio.
    Version,
    /// The number of ranks, and how they share the frame.
    Organisation,
    /// Width and height of the picture.
    Size,
    /// The meshes.
    Models,
    /// Their places, colours, edges, materials and textures, the lights and the background.
    Scene,
    /// The camera.
    Camera,
    /// Everything else that determines the picture.
    Settings,
}

impl Matter {
    /// All of them, in the order in which they are compared: of several that differ, the first is reported.
    const ALL: [Self; 7] = [
        Self::Version,
        Self::Organisation,
        Self::Size,
        Self::Models,
        Self::Scene,
        Self::Camera,
        Self::Settings,
    ];
}

impl fmt::Display for Matter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Version => "with another version of tercio",
            Self::Organisation => "another organisation or number of ranks",
            Self::Size => "a picture of another size",
            Self::Models => "another model",
            Self::Scene => {
                "a scene with other places, colours, edges, materials, textures, light or background"
            }
            Self::Camera => "another camera",
            Self::Settings => "other settings",
        })
    }
}

/// Checksums of a rank's task, in the order of [`Matter::ALL`].
type Digest = [u64; Matter::ALL.len()];

/// What some consecutive ranks have found out.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Found {
    /// The digest of the first of them.
    digest: Digest,
    /// The first rank whose digest differs from that, or [`NONE`].
    differs: u64,
    /// Its digest.
    other: Digest,
}

/// No rank differs.
const NONE: u64 = u64::MAX;

/// Waits until all ranks have called this, and compares what they are going to draw. The messages, two for each rank but one,
/// go up and down a binomial tree.
///
/// # Errors
/// On rank 0 [`ParallelError::Differs`], if any rank's task is another one; the others wait until rank 0 is gone, and return
/// that: so the error is reported once. [`ParallelError::Comm`].
pub fn agree(comm: &mut impl Communicator, task: &Task) -> Result<(), ParallelError> {
    agree_as(comm, task, VERSION)
}

/// The same as a program of some version.
fn agree_as(comm: &mut impl Communicator, task: &Task, version: &str) -> Result<(), ParallelError> {
    if comm.size() == 1 {
        return Ok(());
    }
    let how = format!("{:?} {}", task.sharing, comm.size());
    agree_on(comm, digest(task, comm.size(), how, version))
}

/// The same before the organisation is known: the ranks compare how they are going to choose it instead, which is no way to
/// share a frame. What the task says about that is ignored.
///
/// # Errors
/// As [`agree`].
pub fn agree_to_choose(comm: &mut impl Communicator, task: &Task, how: &str) -> Result<(), ParallelError> {
    if comm.size() == 1 {
        return Ok(());
    }
    let how = format!("{how} {}", comm.size());
    agree_on(comm, digest(task, comm.size(), how, VERSION))
}

fn agree_on(comm: &mut impl Communicator, digest: Digest) -> Result<(), ParallelError> {
    let (rank, size) = (comm.rank(), comm.size());
    let mut found = Found { digest, differs: NONE, other: Digest::default() };
    for child in children(rank, size) {
        let theirs = read(child, &comm.receive(child)?)?;
        if found.differs == NONE && theirs.digest != digest {
            (found.differs, found.other) = (child as u64, theirs.digest);
        } else if found.differs == NONE {
            (found.differs, found.other) = (theirs.differs, theirs.other);
        }
    }
    if rank > 0 {
        let parent = parent(rank);
        comm.send(parent, bytes_of(&found).to_vec())?;
        comm.await_signal(parent)?;
    } else if found.differs != NONE {
        let different = (0..digest.len()).find(|&k| found.other[k] != digest[k]).unwrap_or(0);
        return Err(ParallelError::Differs { rank: found.differs as usize, what: Matter::ALL[different] });
    }
    children(rank, size).try_for_each(|child| comm.signal(child))?;
    Ok(())
}

fn read(from: usize, message: &[u8]) -> Result<Found, CommError> {
    if message.len() == size_of::<Found>() {
        return Ok(pod_read_unaligned(message));
    }
    let reason =
        format!("{} bytes where the ranks compare their tasks: is it of this version?", message.len());
    Err(CommError::Transport { rank: from, reason })
}

/// A digest of those parts of a task that take no time to read: how it is shared, camera and settings. Messages of a frame have
/// it, so that one of another task is no part of this picture.
pub fn frame_digest(task: &Task, ranks: usize) -> u64 {
    let parts = [Matter::Version, Matter::Organisation, Matter::Size, Matter::Camera, Matter::Settings];
    let text = texts(task, ranks, format!("{:?} {ranks}", task.sharing), VERSION);
    checksum::of(parts.map(text).concat().as_bytes())
}

/// `how` is what is compared of the organisation.
fn digest(task: &Task, ranks: usize, how: String, version: &str) -> Digest {
    let text = texts(task, ranks, how, version);
    Matter::ALL.map(|matter| checksum::of(text(matter).as_bytes()))
}

/// What ranks have to agree on, in words.
fn texts(task: &Task, ranks: usize, how: String, version: &str) -> impl Fn(Matter) -> String {
    let Task { sharing, scene, camera, settings } = *task;
    let Settings { width, height, .. } = *settings;
    // What does not change the picture or the messages may differ.
    let settings = Settings {
        width: 1,
        height: 1,
        tile_size: Some(tile_edge(scene, settings, sharing.organisation, ranks)),
        shadows: None,
        clusters: ClusterSet::ALL,
        tiles: TileSet::ALL,
        layer_memory: 0,
        simd: None,
        ..settings.clone()
    };
    let shadow_bytes = task.settings.shadows.as_ref().map_or(0, |maps| maps.bytes());
    move |matter| match matter {
        Matter::Version => version.to_owned(),
        Matter::Organisation => how.clone(),
        Matter::Size => format!("{width} {height}"),
        Matter::Models => format!("{:?}", scene.instances.iter().map(model).collect::<Vec<_>>()),
        Matter::Scene => look(scene),
        Matter::Camera => format!("{camera:?}"),
        Matter::Settings => format!("{settings:?} {shadow_bytes}"),
    }
}

/// Of a model in parts, what all parts have in common.
fn model(instance: &Instance) -> (u64, Option<impl Debug>) {
    (instance.mesh.checksum(), instance.share.map(|share| (share.triangles, share.faces, share.base)))
}

fn look(scene: &Scene) -> String {
    let Scene { instances, lights, environment, background, materials, textures } = scene;
    let of_instance = |i: &Instance| {
        // The sides of all triangles would be a long text.
        let edges = i.edges.as_ref().map(|edges| {
            let SurfaceEdges { color, opacity, width, sides, beyond } = &**edges;
            let beyond = (beyond.triangles(), checksum::of(bytemuck::cast_slice(beyond.numbers())));
            (color, opacity, width, sides.as_ref().map(|sides| checksum::of(sides)), beyond)
        });
        let of_mesh = i.materials.as_ref().map(|materials| {
            let numbers = 0..i.mesh.materials.len() as u32;
            numbers.map(|number| materials.of_triangle(number)).collect::<Vec<_>>()
        });
        let materials = (&i.mesh.materials, of_mesh);
        format!("{:?} {:?} {materials:?} {:?} {edges:?}", i.world_from_object, i.surface, i.data)
    };
    let instances: Vec<String> = instances.iter().map(of_instance).collect();
    let textures: Vec<u64> = textures.iter().map(|texture| texture.checksum()).collect();
    format!("{instances:?} {lights:?} {environment:?} {background:?} {materials:?} {textures:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comm::threads;

    /// What rank 0 of so many ranks finds, some of which have another digest.
    fn found(ranks: usize, others: &[usize], what: usize) -> Result<(), ParallelError> {
        threads::run(ranks, |comm| {
            let mut digest = [5; Matter::ALL.len()];
            digest[what] += u64::from(others.contains(&comm.rank()));
            agree_on(comm, digest)
        })
        .map(|_| ())
    }

    #[test]
    fn the_first_rank_that_differs_is_reported() {
        for ranks in 1..=17 {
            found(ranks, &[], 0).expect("all agree");
            for first in 1..ranks {
                for others in [vec![first], vec![first, ranks - 1], (first..ranks).collect()] {
                    let what = (first + ranks) % Matter::ALL.len();
                    let error = found(ranks, &others, what).expect_err("a rank differs");
                    let ParallelError::Differs { rank, what: reported } = error else { panic!("{error}") };
                    assert_eq!((rank, reported), (first, Matter::ALL[what]), "{others:?} of {ranks}");
                }
            }
        }
    }

    /// One message, of rank 0: the others wait until it has ended.
    #[test]
    fn a_rank_of_another_version_is_reported_once() {
        let mesh = tercio_mesh::builtin::make("builtin:sphere@100").expect("a model");
        let partitioned = tercio_mesh::cluster::partition(mesh, &Default::default());
        let scene = Scene::from_mesh(std::sync::Arc::new(partitioned));
        let camera = tercio_scene::Framing::default().camera_for_scene(&scene);
        let settings = Settings::new(40, 30);
        let task = Task {
            sharing: crate::Organisation::SortLast.into(),
            scene: &scene,
            camera: &camera,
            settings: &settings,
        };
        for ranks in [2, 3, 9] {
            let of_versions = |last: &str| {
                let done = std::sync::Mutex::new(Vec::new());
                let result = threads::run(ranks, |comm| {
                    let version = if comm.rank() + 1 == ranks { last } else { VERSION };
                    let agreed = agree_as(comm, &task, version);
                    let found = agreed.as_ref().map_err(ToString::to_string).copied();
                    done.lock().expect("no panic").push((comm.rank(), found));
                    agreed
                });
                let mut done = done.into_inner().expect("no panic");
                done.sort_unstable();
                (result.map(|_| ()).map_err(|error| error.to_string()), done)
            };
            assert!(of_versions(VERSION).0.is_ok());
            let (error, of_rank) = of_versions("0.0.7");
            let last = ranks - 1;
            let expected = format!(
                "rank {last} would draw with another version of tercio than rank 0: all ranks have to draw the same frame"
            );
            assert_eq!(error, Err(expected.clone()));
            let says = of_rank.iter().filter(|(_, found)| *found == Err(expected.clone()));
            assert_eq!(says.map(|(rank, _)| *rank).collect::<Vec<_>>(), [0], "{of_rank:?}");
            assert!(of_rank.iter().all(|(_, found)| found.is_err()), "a rank goes on to draw: {of_rank:?}");
        }
    }

    #[test]
    fn all_ranks_wait_for_the_last_one() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let came = AtomicUsize::new(0);
        threads::run(9, |comm| {
            std::thread::sleep(std::time::Duration::from_millis(3 * (comm.rank() as u64 * 5 % 9)));
            came.fetch_add(1, Ordering::SeqCst);
            agree_on(comm, Digest::default())?;
            assert_eq!(came.load(Ordering::SeqCst), 9);
            Ok(())
        })
        .expect("all agree");
    }
}
