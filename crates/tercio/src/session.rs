//! Draws what a program computes, while it computes it: in situ.
//!
//! The processes of a simulation hold parts of a surface each. A [`Session`] makes models of them that no process holds as a whole,
//! and draws these, with all processes, from one picture to the next.
//!
//! ```
//! use tercio::mesh::arrays::{Arrays, Positions};
//! use tercio::{Picture, Session, Settings};
//!
//! // One process; with several, `Session::new` takes what they send each other messages by.
//! let mut session = Session::alone();
//! let settings = Settings::new(160, 120);
//! let triangles = [[0, 1, 2], [0, 2, 3]];
//! let mut camera = None;
//! let mut part = None;
//! for step in 0..3 {
//!     // The simulation.
//!     let lifted = [0.0, 0.1, 0.2][step];
//!     let corners = [[0.0, 0.0, lifted], [1.0, 0.0, 0.0], [1.0, 1.0, lifted], [0.0, 1.0, 0.0f64]];
//!     // Its picture.
//!     let arrays = Arrays::new(Positions::F64(&corners), &triangles);
//!     match part {
//!         None => part = Some(session.add(&arrays)?),
//!         Some(part) => session.update(part, &arrays)?,
//!     }
//!     // The camera of the first picture stays.
//!     let camera = match camera {
//!         Some(camera) => camera,
//!         None => *camera.insert(session.camera(&settings.framing())?),
//!     };
//!     if let Some(frame) = session.render(&camera, &settings)? {
//!         let picture = Picture::from_frame(frame);
//!         assert_eq!((picture.width, picture.height), (160, 120));
//!         assert!(frame.planes.color.iter().any(|pixel| *pixel != frame.planes.color[0]));
//!     }
//! }
//! # Ok::<(), tercio::Error>(())
//! ```

mod call;

use std::sync::Arc;
use std::time::{Duration, Instant};

use call::Function;
use glam::DAffine3;
use tercio_mesh::arrays::Arrays;
use tercio_parallel::comm::CommError;
use tercio_parallel::comm::threads::ThreadComm;
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{
    Communicator, FrameReport, Organisation, ParallelError, Sharing, between_processes, parts,
};
use tercio_raster::{Frame, RenderError, Settings, ShadowArea, ShadowMaps};
use tercio_scene::light::Light;
use tercio_scene::{Background, Camera, Environment, Framing, Instance, Scene, Surface};

pub use call::Call;

use crate::{Error, LoadOptions, Normals};

/// A part of a session's scene. The same on all ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PartId(u32);

impl PartId {
    /// The part with a number.
    pub fn from_number(number: u32) -> Self {
        Self(number)
    }

    /// Its number: 0 for the first part of a session, 1 for the next one.
    pub fn number(self) -> u32 {
        self.0
    }
}

/// Why a session could not do something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// There is no such part, or it was removed.
    #[error("there is no part {}", .0.0)]
    NoPart(PartId),
    /// Ranks called different functions, or with different parts.
    #[error(
        "rank {rank} called {theirs}, and rank 0 {first}: collective functions are called by all ranks, in the same order"
    )]
    Calls {
        /// The first rank that differs from rank 0.
        rank: usize,
        /// What it called.
        theirs: Call,
        /// What rank 0 called.
        first: Call,
    },
    /// An earlier call left the ranks at different places.
    #[error("the session failed before: {0}")]
    Failed(String),
}

/// What one of several ranks, or a program alone, draws its data with.
///
/// Functions that the documentation calls *collective* have to be called by all ranks, in the same order and with the same
/// parts, camera and settings; each passes its own arrays. They work in the rayon pool they are called in, and send and receive
/// messages on the calling thread. Ranks compare what they call: if one calls another function, all get [`SessionError::Calls`].
///
/// An error that all ranks get, as for arrays that make no mesh on one of them, or a part that none has, changes nothing. After any other error of a
/// collective function the session is of no use any more: it returns [`SessionError::Failed`] from then on, and when it is dropped, or
/// [taken apart](Self::into_comm) and its communicator closed, the other ranks get an error instead of waiting.
#[derive(Debug)]
pub struct Session<C> {
    comm: C,
    own: Rank,
    scene: Scene,
    /// Those of the first instances of the scene; the others are for one picture.
    parts: Vec<PartId>,
    next_part: u32,
    frame: Frame,
    report: Option<FrameReport>,
    sharing: Sharing,
    normals: Normals,
    spent: Duration,
    failed: Option<String>,
}

impl Session<ThreadComm> {
    /// A session of one process.
    pub fn alone() -> Self {
        Self::new(ThreadComm::alone())
    }
}

impl<C: Communicator> Session<C> {
    /// A session of all ranks of a communicator, without parts, under [`Light::studio`], on the default background. Ranks share a
    /// picture by sort-last: each draws its parts where they are.
    pub fn new(comm: C) -> Self {
        let mut own = Rank::new();
        own.tell_partners(false);
        Self {
            comm,
            own,
            scene: Scene { lights: Light::studio(), ..Scene::default() },
            parts: Vec::new(),
            next_part: 0,
            frame: Frame::default(),
            report: None,
            sharing: Organisation::SortLast.into(),
            normals: Normals::default(),
            spent: Duration::ZERO,
            failed: None,
        }
    }

    /// Adds a part that stays until it is removed. Collective: the model is that of all ranks' triangles, in their order, joined where
    /// they have vertices at the same position; a rank may have none. The arrays are copied.
    ///
    /// # Errors
    /// As [`LoadOptions::load_arrays`].
    pub fn add(&mut self, arrays: &Arrays) -> Result<PartId, Error> {
        self.timed(Function::Add, None, |session| {
            let instance = session.instance(arrays)?;
            let id = PartId(session.next_part);
            session.scene.instances.insert(session.parts.len(), instance);
            session.parts.push(id);
            session.next_part += 1;
            Ok(id)
        })
    }

    /// Replaces the arrays of a part; transform and surface stay. Collective.
    ///
    /// # Errors
    /// [`SessionError::NoPart`], and as [`LoadOptions::load_arrays`]: the part is unchanged then.
    pub fn update(&mut self, part: PartId, arrays: &Arrays) -> Result<(), Error> {
        self.timed(Function::Update, Some(part), |session| {
            let place = session.place(part)?;
            let Instance { mesh, share, .. } = session.instance(arrays)?;
            let instance = &mut session.scene.instances[place];
            (instance.mesh, instance.share) = (mesh, share);
            Ok(())
        })
    }

    /// Removes a part. All ranks have to do the same before the next picture.
    ///
    /// # Errors
    /// [`SessionError::NoPart`].
    pub fn remove(&mut self, part: PartId) -> Result<(), Error> {
        let place = self.place(part)?;
        self.parts.remove(place);
        self.scene.instances.remove(place);
        Ok(())
    }

    /// Adds something for the next picture only, as [`Self::add`] does. Collective.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn show(&mut self, arrays: &Arrays) -> Result<(), Error> {
        self.timed(Function::Show, None, |session| {
            let instance = session.instance(arrays)?;
            session.scene.instances.push(instance);
            Ok(())
        })
    }

    /// The transform of a part to world space. All ranks have to set the same one.
    ///
    /// # Errors
    /// [`SessionError::NoPart`].
    pub fn transform_mut(&mut self, part: PartId) -> Result<&mut DAffine3, Error> {
        let place = self.place(part)?;
        Ok(&mut self.scene.instances[place].world_from_object)
    }

    /// How the surface of a part reflects light: colour, opacity. All ranks have to set the same.
    ///
    /// # Errors
    /// [`SessionError::NoPart`].
    pub fn surface_mut(&mut self, part: PartId) -> Result<&mut Surface, Error> {
        let place = self.place(part)?;
        Ok(&mut self.scene.instances[place].surface)
    }

    /// The lights. All ranks have to set the same.
    pub fn lights_mut(&mut self) -> &mut Vec<Light> {
        &mut self.scene.lights
    }

    /// The background. All ranks have to set the same.
    pub fn background_mut(&mut self) -> &mut Background {
        &mut self.scene.background
    }

    /// The light from all around. All ranks have to set the same.
    pub fn environment_mut(&mut self) -> &mut Option<Arc<Environment>> {
        &mut self.scene.environment
    }

    /// How ranks share a picture, which looks the same. All ranks have to set the same.
    pub fn sharing_mut(&mut self) -> &mut Sharing {
        &mut self.sharing
    }

    /// Which normals parts get from now on. All ranks have to set the same.
    pub fn normals_mut(&mut self) -> &mut Normals {
        &mut self.normals
    }

    /// The camera that frames all there is. Collective. Used for many pictures, it shows how things move; made for each, it follows them.
    ///
    /// # Errors
    /// [`ParallelError::Comm`].
    pub fn camera(&mut self, framing: &Framing) -> Result<Camera, Error> {
        self.timed(Function::Camera, None, |session| {
            Ok(parts::camera_for_scene(&mut session.comm, framing, &session.scene)?)
        })
    }

    /// The shadows of all parts, for [`Settings::shadows`], in maps of `size` times `size` texels. Collective.
    ///
    /// # Errors
    /// As [`ShadowMaps::draw`], and [`ParallelError::Comm`].
    pub fn shadow_maps(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        size: u32,
    ) -> Result<ShadowMaps, Error> {
        self.timed(Function::ShadowMaps, None, |session| {
            settings.check()?;
            camera.basis().map_err(RenderError::from)?;
            let of = (size, ShadowArea::Scene);
            Ok(parts::shadow_maps(&mut session.comm, &session.scene, camera, settings, of)?)
        })
    }

    /// Draws a picture of all there is. Collective. Rank 0 gets it, with the bytes that one process with all triangles gets;
    /// the others get `None`.
    ///
    /// # Errors
    /// [`RenderError`](tercio_raster::RenderError) for settings that are not valid; [`ParallelError`], on rank 0
    /// [`ParallelError::Differs`] if the ranks have set different things.
    pub fn render(&mut self, camera: &Camera, settings: &Settings) -> Result<Option<&Frame>, Error> {
        self.timed(Function::Render, None, |session| {
            // All ranks have the same.
            settings.check()?;
            camera.basis().map_err(RenderError::from)?;
            let Self { comm, own, scene, frame, sharing, .. } = session;
            let task = Task { sharing: *sharing, scene, camera, settings };
            let drawn = between_processes::draw_frame(own, comm, &task, frame);
            session.scene.instances.truncate(session.parts.len());
            session.report = None;
            session.report = drawn?;
            // The program may compute for long now.
            session.comm.flush()?;
            Ok(())
        })?;
        Ok(self.frame())
    }

    /// The last picture; `None` on other ranks than rank 0, and before the first one.
    pub fn frame(&self) -> Option<&Frame> {
        self.report.is_some().then_some(&self.frame)
    }

    /// Whether [reports](Self::report) have counts of messages [by partner](tercio_parallel::RankReport::partners), on all ranks the
    /// same. Not at first: they are sent to rank 0 with each picture, and of n ranks there are up to n² of them.
    pub fn tell_partners(&mut self, tells: bool) {
        self.own.tell_partners(tells);
    }

    /// What all ranks did for the last picture; `None` on other ranks than rank 0, and before the first one. Messages by what they are
    /// for are only in it after [`Self::tell_partners`].
    pub fn report(&self) -> Option<&FrameReport> {
        self.report.as_ref()
    }

    /// Wall time that this rank has spent in the session's collective functions so far: the time that drawing has taken from the
    /// program, waiting for other ranks included.
    pub fn spent(&self) -> Duration {
        self.spent
    }

    /// What the ranks send each other messages by, for the program's own use between calls.
    pub fn comm_mut(&mut self) -> &mut C {
        &mut self.comm
    }

    /// Ends the session.
    pub fn into_comm(self) -> C {
        self.comm
    }

    fn instance(&mut self, arrays: &Arrays) -> Result<Instance, Error> {
        let options = LoadOptions { normals: self.normals, ..LoadOptions::default() };
        Ok(options.load_arrays(&mut self.comm, arrays)?.instance())
    }

    /// Fails on all ranks if they call different functions.
    fn compare(&mut self, own: Call) -> Result<(), Error> {
        let blocks = self.comm.all_gather(own.bytes())?;
        let Some(rank) = blocks.iter().position(|block| *block != blocks[0]) else { return Ok(()) };
        let call = |rank: usize| {
            let reason = || "it is in no function of a session".to_owned();
            Call::of_bytes(&blocks[rank]).ok_or_else(|| CommError::Transport { rank, reason: reason() })
        };
        Err(SessionError::Calls { rank, theirs: call(rank)?, first: call(0)? }.into())
    }

    fn place(&self, part: PartId) -> Result<usize, SessionError> {
        self.parts.iter().position(|&id| id == part).ok_or(SessionError::NoPart(part))
    }

    /// Runs a collective function if all ranks do, adds its time, and remembers if it failed in a way that other ranks do not know of.
    fn timed<T>(
        &mut self,
        function: Function,
        part: Option<PartId>,
        work: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if let Some(earlier) = &self.failed {
            return Err(SessionError::Failed(earlier.clone()).into());
        }
        let begin = Instant::now();
        let part = part.map(|id| (id.0, self.place(id).is_ok()));
        self.failed = Some("a function panicked".into());
        let done = match self.compare(Call { function, part }) {
            Ok(()) => work(self),
            Err(error) => Err(error),
        };
        self.failed = None;
        self.spent += begin.elapsed();
        if let Err(error) = &done
            && !is_known_to_all(error)
        {
            self.failed = Some(error.to_string());
        }
        done
    }
}

/// Do all ranks get this error, or one that says that a rank got it, at the same place?
fn is_known_to_all(error: &Error) -> bool {
    match error {
        Error::Session(SessionError::NoPart(_)) | Error::Render(_) => true,
        Error::Load(error) => matches!(error, crate::LoadError::Arrays(_)),
        Error::Parallel(error) => matches!(error, ParallelError::Parts(_)),
        _ => false,
    }
}
