use glam::DVec3;
use std::sync::Arc;
use std::time::Instant;
use tercio_mesh::cluster::*;
use tercio_mesh::*;
use tercio_raster::*;
use tercio_scene::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t = Instant::now();
    let mut mesh = io::read(a[1].as_ref(), &Default::default()).unwrap().mesh;
    println!("read {:?}", t.elapsed());
    let sub: u32 = a.get(2).map_or(0, |s| s.parse().unwrap());
    for _ in 0..sub {
        let mut map = std::collections::HashMap::new();
        let mut out = Vec::new();
        let mut pos = mesh.positions.clone();
        let mut mid = |a: u32, b: u32| {
            *map.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (pos[a as usize], pos[b as usize]);
                pos.push([0, 1, 2].map(|k| (p[k] + q[k]) * 0.5));
                pos.len() as u32 - 1
            })
        };
        for &[a, b, c] in &mesh.triangles {
            let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
            out.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        mesh.positions = pos;
        mesh.triangles = out;
    }
    let mut n = vec![DVec3::ZERO; mesh.positions.len()];
    for t in &mesh.triangles {
        let p = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3());
        let g = (p[1] - p[0]).cross(p[2] - p[0]);
        for &v in t {
            n[v as usize] += g;
        }
    }
    mesh.normals =
        Some(n.iter().map(|n| OctNormal::encode(n.normalize_or_zero().as_vec3().to_array())).collect());
    let b = mesh.bounds();
    let tris = mesh.triangles.len();
    let t = Instant::now();
    let m = partition(mesh, &PartitionOptions::default());
    println!(
        "partition {:?} {} clusters {:.1} tri/cl",
        t.elapsed(),
        m.clusters.len(),
        tris as f64 / m.clusters.len() as f64
    );
    let mut scene = Scene::of_mesh(Arc::new(m));
    if a.iter().any(|s| s == "onelight") {
        scene.lights = vec![Light::headlight([0.9; 3]), Light::Ambient { color: [0.1; 3] }];
        scene.instances[0].surface.specular = 0.0;
    }
    let mut r = Renderer::new();
    let mut frame = Frame::default();
    let mut s = Settings::new(1024, 1024);
    if a.iter().any(|s| s == "back") {
        s.cull = Cull::Back;
    }
    for l in a.iter() {
        if let Ok(l) = l.parse() {
            s.simd = Some(l);
        }
        if let Some(t) = l.strip_prefix("tile=") {
            s.tile_size = t.parse().ok();
        }
    }
    let ext = b.size().max_element();
    let mut times = vec![];
    let mut fe = vec![];
    let mut be = vec![];
    for f in 0..36 {
        let th = f as f64 * std::f64::consts::TAU / 36.0;
        let dist = ext * 2.2;
        let eye = b.center() + DVec3::new(dist * th.sin(), dist * 0.2, dist * th.cos());
        let cam = Camera {
            eye,
            target: b.center(),
            up: DVec3::Y,
            projection: Projection::Perspective { fov_y: 2.0 * (0.5f64 / 0.8 * ext / dist).atan() },
            near: None,
        };
        r.render_into(&scene, &cam, &s, &mut frame).unwrap();
        times.push(frame.stats.milliseconds.total);
        fe.push(frame.stats.milliseconds.frontend);
        be.push(frame.stats.milliseconds.backend);
    }
    let med = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    println!(
        "threads {} median {:.2} ms  front {:.2} back {:.2}  {:.0} Mtri/s",
        rayon::current_num_threads(),
        med(&mut times),
        med(&mut fe),
        med(&mut be),
        tris as f64 / med(&mut times) / 1e3
    );
    println!("{:?}", frame.stats);
    let mut o = format!("P6 1024 1024 255\n").into_bytes();
    frame.color.iter().for_each(|c| o.extend(&c[..3]));
    std::fs::write("/tmp/spin.ppm", o).unwrap();
}
