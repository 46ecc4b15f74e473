//! A simulation that draws itself while it runs: waves on a membrane whose rows are divided among ranks.
//!
//! ```sh
//! cargo run --release -p tercio-mpi --example wave -- --ranks 2 --pictures wave          # threads of one process
//! cargo build --release -p tercio-mpi --features mpi --example wave
//! mpirun -n 2 target/release/examples/wave --pictures wave                               # processes
//! ```
//!
//! Every tenth step all ranks draw the membrane together; no rank has all of it. At the end the time that this has taken from the
//! simulation is printed. Pictures do not depend on the number of ranks.

mod membrane;
mod stopwatch;

use std::path::{Path, PathBuf};

use membrane::Membrane;
use stopwatch::Stopwatch;
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::parallel::Communicator;
use tercio::parallel::comm::collective::all_max;
use tercio::parallel::comm::threads;
use tercio::scene::{Framing, UpAxis};
use tercio::{Picture, Session, Settings};

const USAGE: &str =
    "wave [--steps 2000] [--every 10] [--cells 256] [--size 1024x768] [--ranks 2] [--pictures FOLDER]
  --ranks is for threads of one process; with mpirun there are as many ranks as processes";

/// The command line.
struct Options {
    steps: u32,
    every: u32,
    cells: usize,
    size: (u32, u32),
    ranks: usize,
    pictures: Option<PathBuf>,
}

fn main() -> tercio::Result<()> {
    let options = match options() {
        Ok(options) => options,
        Err(wrong) => {
            eprintln!("error: {wrong}\n{USAGE}");
            std::process::exit(2);
        }
    };
    if let Some(folder) = &options.pictures {
        std::fs::create_dir_all(folder)?;
    }
    #[cfg(feature = "mpi")]
    if tercio_mpi::processes().is_some() {
        return over_mpi(&options);
    }
    #[cfg(not(feature = "mpi"))]
    if tercio_mpi::processes().is_some_and(|processes| processes > 1) {
        eprintln!(
            "error: built without MPI: cargo build --release -p tercio-mpi --features mpi --example wave"
        );
        std::process::exit(2);
    }
    let results = threads::run(options.ranks, |comm| Ok(simulate(comm, &options)))?;
    results.into_iter().collect()
}

/// Runs this process's rank of a job; if it fails, all processes end.
#[cfg(feature = "mpi")]
fn over_mpi(options: &Options) -> tercio::Result<()> {
    tercio_mpi::run(|comm| simulate(comm, options), tercio_mpi::write_error)
        .map_err(|error| std::io::Error::other(error).into())
}

/// The simulation of one rank.
fn simulate<C: Communicator>(comm: C, options: &Options) -> tercio::Result<()> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    // Ranks are the parallelism here: without a pool of its own, every rank would use all processors.
    let _pool = one_thread.expect("the pool of this thread");
    let (rank, ranks) = (comm.rank(), comm.size());
    let mut membrane = Membrane::new(options.cells, rank, ranks);
    let settings = Settings::new(options.size.0, options.size.1);
    let framing = Framing { up_axis: UpAxis::Z, elevation: 30.0, ..settings.framing() };

    let mut session = Session::new(comm);
    let (mut part, mut camera, mut pictures) = (None, None, 0u32);
    let (mut all, mut drawing, mut writing) = (Stopwatch::new(), Stopwatch::new(), Stopwatch::new());
    all.start();
    for step in 1..=options.steps {
        membrane.step(session.comm_mut(), 1e-8)?;
        if step % options.every != 0 {
            continue;
        }
        drawing.start();
        let surface = membrane.surface();
        // Normals are made, across the seams between ranks, too.
        let arrays = Arrays {
            vertex_colors: Some(&surface.colors),
            ..Arrays::new(Positions::F64(&surface.positions), &surface.triangles)
        };
        match part {
            None => part = Some(session.add(&arrays)?),
            Some(part) => session.update(part, &arrays)?,
        }
        let camera = match camera {
            Some(camera) => camera,
            None => *camera.insert(session.camera(&framing)?),
        };
        let frame = session.render(&camera, &settings)?;
        drawing.stop();
        pictures += 1;
        if let (Some(frame), Some(folder)) = (frame, &options.pictures) {
            writing.start();
            Picture::from_frame(frame).save(folder.join(format!("wave-{step:05}.png")))?;
            writing.stop();
        }
    }
    all.stop();
    report(session.comm_mut(), options, [all, drawing, writing], pictures)
}

/// Prints, on rank 0, what drawing has taken from the simulation, on the rank where it took the most.
fn report(
    comm: &mut impl Communicator,
    options: &Options,
    watches: [Stopwatch; 3],
    pictures: u32,
) -> tercio::Result<()> {
    // Waiting for others is no work of the processor, but time.
    for (what, seconds) in [
        ("elapsed", watches.map(|watch| watch.elapsed.as_secs_f64())),
        ("processor", watches.map(|watch| watch.processor.as_secs_f64())),
    ] {
        let [all, drawing, writing] = all_max(comm, seconds)?;
        if comm.rank() == 0 {
            let simulation = all - drawing - writing;
            let share = 100.0 * drawing / simulation;
            println!(
                "{what} seconds: {simulation:.2} simulation, {drawing:.2} drawing ({share:.1} %), {writing:.2} writing"
            );
        }
    }
    if comm.rank() == 0 {
        let Options { steps, cells, .. } = options;
        println!("{steps} steps of {cells} x {cells} cells on {} ranks, {pictures} pictures", comm.size());
    }
    Ok(())
}

fn options() -> Result<Options, String> {
    let mut o = Options { steps: 2000, every: 10, cells: 256, size: (1024, 768), ranks: 2, pictures: None };
    let mut words = std::env::args().skip(1);
    while let Some(name) = words.next() {
        let value = words.next().ok_or(format!("{name} needs a value"))?;
        let number = || {
            value
                .parse::<u32>()
                .ok()
                .filter(|n| *n > 0)
                .ok_or(format!("{name}: expected a number above 0, found {value}"))
        };
        match &*name {
            "--steps" => o.steps = number()?,
            "--every" => o.every = number()?,
            "--cells" => o.cells = number()? as usize,
            "--ranks" => o.ranks = number()? as usize,
            "--pictures" => o.pictures = Some(Path::new(&value).to_owned()),
            "--size" => {
                let size = value.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
                o.size = size.ok_or(format!("--size: expected WIDTHxHEIGHT, found {value}"))?;
            }
            _ => return Err(format!("unknown option {name}")),
        }
    }
    Ok(o)
}
