//! Time and quality of the partition, compared with those of meshoptimizer (64 vertices, 124 triangles, weight 0.5).
//!
//! `cargo run --release -p tercio-mesh --example partition_quality -- [MODEL.ply] [SUBDIVISIONS] [shuffle]`
//!
//! Reads an ASCII PLY of triangles, or makes a bumpy sphere; splits each triangle into four SUBDIVISIONS times;
//! `shuffle` puts the triangles into random order. Prints, one line each: number of clusters, triangles and vertices
//! per cluster, surface area of the clusters' boxes over that of the mesh, mean angle of the cones, share of
//! triangles that survive the cone test from 36 eyes around the model, vectors of 16 vertices or triangles that those
//! survivors need per 1000 triangles, and the best time of five.

use std::collections::HashMap;
use std::time::Instant;

use glam::Vec3;
use tercio_mesh::cluster::{ClusterView, Order, PartitionOptions, partition};
use tercio_mesh::{ClusteredMesh, Mesh};

type Anything = Box<dyn std::error::Error>;

fn main() -> Result<(), Anything> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let mut mesh = match args.first() {
        Some(path) => load(path)?,
        None => sphere(600),
    };
    for _ in 0..args.get(1).map_or(Ok(0), |s| s.parse())? {
        mesh = subdivide(&mesh);
    }
    if args.get(2).is_some_and(|s| s == "shuffle") {
        shuffle(&mut mesh.triangles);
    }
    println!("{} triangles, {} vertices", mesh.triangles.len(), mesh.positions.len());
    println!("who               clusters  tri/cl  vert/cl  box/area  angle  survive  vectors  Mtri/s");
    let eyes = eyes(&mesh);
    for threads in [1, rayon::current_num_threads()] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        for order in [Order::File, Order::Spatial, Order::Auto] {
            let (mut best, mut out) = (f64::INFINITY, ClusteredMesh::default());
            for _ in 0..5 {
                let copy = mesh.clone();
                let options = PartitionOptions { order, ..Default::default() };
                let start = Instant::now();
                out = pool.install(|| partition(copy, &options));
                best = best.min(start.elapsed().as_secs_f64());
            }
            let pieces: Vec<Piece> = out.views().map(Piece::ours).collect();
            report(&format!("{order:?}, {threads} threads"), &pieces, &eyes, best);
            let bytes = out.core_bytes() as f64 / out.triangle_count() as f64;
            println!("    {bytes:.2} bytes a triangle without attributes");
        }
    }
    let (pieces, time) = meshopt_pieces(&mesh)?;
    report("meshopt", &pieces, &eyes, time);
    Ok(())
}

/// Measured properties of a cluster.
struct Piece {
    vertices: usize,
    triangles: usize,
    box_area: f64,
    area: f64,
    cutoff: f32,
    cull: Box<dyn Fn(Vec3) -> bool>,
}

impl Piece {
    fn new(triangles: &[[Vec3; 3]], vertices: usize, cutoff: f32, cull: Box<dyn Fn(Vec3) -> bool>) -> Self {
        let (mut min, mut max, mut area) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
        for &[a, b, c] in triangles {
            (min, max) = (min.min(a).min(b).min(c), max.max(a).max(b).max(c));
            area += f64::from((b - a).cross(c - a).length()) * 0.5;
        }
        let s = max - min;
        let box_area = f64::from(2.0 * (s.x * s.y + s.y * s.z + s.z * s.x));
        Self { vertices, triangles: triangles.len(), box_area, area, cutoff, cull }
    }

    fn ours(cluster: ClusterView) -> Self {
        let corners = |t| cluster.corner_positions(t).map(Vec3::from);
        let triangles: Vec<_> = (0..cluster.triangles()).map(corners).collect();
        let c = *cluster.head();
        let cutoff = f32::from(c.cone_cutoff) / 127.0;
        let cull = move |eye: Vec3| c.faces_away(eye.to_array());
        Self::new(&triangles, usize::from(c.vertices), cutoff, Box::new(cull))
    }
}

fn meshopt_pieces(mesh: &Mesh) -> Result<(Vec<Piece>, f64), Anything> {
    let bytes: Vec<u8> = mesh.positions.iter().flatten().flat_map(|v| v.to_ne_bytes()).collect();
    let adapter = meshopt::VertexDataAdapter::new(&bytes, 12, 0)?;
    let start = Instant::now();
    let meshlets = meshopt::build_meshlets(mesh.triangles.as_flattened(), &adapter, 64, 124, 0.5);
    let bounds: Vec<_> = meshlets.iter().map(|m| meshopt::compute_meshlet_bounds(m, &adapter)).collect();
    let time = start.elapsed().as_secs_f64();
    let pieces = meshlets.iter().zip(bounds).map(|(m, b)| {
        let corner = |&i: &u8| Vec3::from(mesh.positions[m.vertices[usize::from(i)] as usize]);
        let triangles: Vec<_> =
            m.triangles.chunks_exact(3).map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect();
        let (apex, axis) = (Vec3::from(b.cone_apex), Vec3::from(b.cone_axis));
        let cull = move |eye: Vec3| (apex - eye).normalize_or_zero().dot(axis) >= b.cone_cutoff;
        Piece::new(&triangles, m.vertices.len(), b.cone_cutoff, Box::new(cull))
    });
    Ok((pieces.collect(), time))
}

fn report(name: &str, pieces: &[Piece], eyes: &[Vec3], seconds: f64) {
    let sum = |f: &dyn Fn(&Piece) -> f64| pieces.iter().map(f).sum::<f64>();
    let (triangles, clusters) = (sum(&|p| p.triangles as f64), pieces.len() as f64);
    let vectors = |p: &Piece| (p.vertices.div_ceil(16) + p.triangles.div_ceil(16)) as f64;
    let (mut survivors, mut work) = (0.0, 0.0);
    for &eye in eyes {
        for p in pieces.iter().filter(|p| !(p.cull)(eye)) {
            survivors += p.triangles as f64;
            work += vectors(p);
        }
    }
    let all = triangles * eyes.len() as f64;
    println!(
        "{name:<18}{clusters:>8}{:>8.1}{:>9.1}{:>10.2}{:>7.1}{:>8.2}%{:>9.1}{:>8.1}",
        triangles / clusters,
        sum(&|p| p.vertices as f64) / clusters,
        sum(&|p| p.box_area) / sum(&|p| p.area),
        sum(&|p| f64::from(p.cutoff.clamp(-1.0, 1.0).asin().to_degrees())) / clusters,
        survivors / all * 100.0,
        work / all * 1000.0,
        triangles / seconds / 1e6,
    );
}

/// 36 eyes on a circle around the model.
fn eyes(mesh: &Mesh) -> Vec<Vec3> {
    let bounds = mesh.bounds();
    let (center, size) = ((bounds.center() - mesh.origin).as_vec3(), bounds.size().max_element() as f32);
    let turn = |i: i32| i as f32 / 36.0 * std::f32::consts::TAU;
    (0..36).map(|i| center + Vec3::new(turn(i).sin(), 0.2 / 2.2, turn(i).cos()) * (2.2 * size)).collect()
}

fn load(path: &str) -> Result<Mesh, Anything> {
    let text = std::fs::read_to_string(path)?;
    let (header, body) = text.split_once("end_header\n").ok_or("not an ASCII PLY file")?;
    let count = |what: &str| -> Result<usize, Anything> {
        let line = header.lines().find(|l| l.starts_with(what)).ok_or("element missing")?;
        Ok(line.rsplit(' ').next().unwrap_or("").trim().parse()?)
    };
    let mut lines = body.lines();
    let mut mesh = Mesh::default();
    for line in lines.by_ref().take(count("element vertex")?) {
        let mut v = line.split_ascii_whitespace().map(str::parse);
        let mut next = || v.next().ok_or("coordinate missing");
        mesh.positions.push([next()??, next()??, next()??]);
    }
    for line in lines.take(count("element face")?) {
        let mut v = line.split_ascii_whitespace().skip(1).map(str::parse);
        let mut next = || v.next().ok_or("corner missing");
        mesh.triangles.push([next()??, next()??, next()??]);
    }
    Ok(mesh)
}

/// A bumpy sphere, row by row.
fn sphere(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, j) in (0..=n).flat_map(|i| (0..2 * n).map(move |j| (i as f32 / n as f32, j as f32 / n as f32))) {
        let (theta, phi) = (i * std::f32::consts::PI, j * std::f32::consts::PI);
        let r = 1.0 + 0.05 * (theta * 20.0).sin() * (phi * 20.0).cos();
        mesh.positions.push([r * theta.sin() * phi.cos(), r * theta.sin() * phi.sin(), r * theta.cos()]);
    }
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let at = |i, j| i * 2 * n + j % (2 * n);
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

fn subdivide(mesh: &Mesh) -> Mesh {
    let mut out = Mesh { positions: mesh.positions.clone(), ..Mesh::default() };
    let mut middles = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let (p, q) = (mesh.positions[i as usize], mesh.positions[j as usize]);
                out.positions.push(std::array::from_fn(|k| (p[k] + q[k]) * 0.5));
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    out
}

fn shuffle(triangles: &mut [[u32; 3]]) {
    let mut random = 1u64;
    for i in (1..triangles.len()).rev() {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        triangles.swap(i, (((random >> 32) * (i as u64 + 1)) >> 32) as usize);
    }
}
