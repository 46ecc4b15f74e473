//! Times the stages from a model file to clusters: `time_stages FILE [THREADS]`, the best of five runs.
//!
//! With one thread the time is processor time, so that other load on the machine does not affect it.

use std::time::Instant;

use tercio_mesh::cluster::{Order, PartitionOptions, partition_blocks};
use tercio_mesh::io::{ReadOptions, read};
use tercio_mesh::{BlockedMesh, clean, weld};

type Times = Vec<(&'static str, f64)>;
type Anything = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Anything> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let file = args.first().ok_or("usage: time_stages FILE [THREADS]")?;
    let threads = args.get(1).map_or(Ok(1), |s| s.parse())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build()?;
    let clock = if threads == 1 { processor_seconds } else { wall_seconds };
    let mut best = Times::new();
    let mut triangles = 0;
    for _ in 0..5 {
        let (times, count) = pool.install(|| run(file, clock))?;
        triangles = count;
        if best.is_empty() {
            best = times;
        } else {
            best.iter_mut().zip(times).for_each(|(b, t)| b.1 = b.1.min(t.1));
        }
    }
    println!("{file}: {triangles} triangles, {threads} threads");
    for (stage, seconds) in best {
        println!(
            "{stage:10} {:8.1} ms {:6.1} ns per triangle",
            seconds * 1e3,
            seconds * 1e9 / triangles as f64
        );
    }
    Ok(())
}

/// Seconds of each stage, and the number of triangles.
fn run(file: &str, clock: fn() -> f64) -> Result<(Times, usize), Anything> {
    let mut times = Times::new();
    let mut last = clock();
    let mut lap = |stage| {
        let now = clock();
        times.push((stage, now - last));
        last = now;
    };
    let mut mesh = read(file, &ReadOptions::default())?.mesh;
    lap("read");
    let is_soup = weld::is_soup(&mesh);
    clean::clean(&mut mesh);
    lap("clean");
    if is_soup {
        weld::weld(&mut mesh);
    }
    lap("weld");
    let count = mesh.triangles.len();
    let mut blocks = BlockedMesh::new(mesh, Order::Auto);
    lap("blocks");
    if blocks.mesh().normals.is_none() {
        blocks.make_normals(std::f64::consts::FRAC_PI_3);
    }
    lap("normals");
    let out = partition_blocks(blocks, &PartitionOptions::default());
    lap("clusters");
    drop(out);
    lap("free");
    Ok((times, count))
}

fn wall_seconds() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// Processor time of this thread in seconds; wall time where the system does not report it.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|t| t.parse::<f64>().ok());
    nanoseconds.map_or_else(wall_seconds, |n| n * 1e-9)
}
