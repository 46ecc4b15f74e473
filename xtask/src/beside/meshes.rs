//! The meshes and the texture of the scenes.

use tercio_mesh::{Mesh, OctNormal, builtin};
use tercio_testkit::Picture;

/// A built-in model.
pub fn model(spec: &str) -> Mesh {
    builtin::make(spec).expect("the name of a model")
}

/// A teapot beside a ball, on a floor in front of a wall.
pub fn table() -> Mesh {
    let mut mesh = model("builtin:teapot@60k");
    let bounds = mesh.bounds();
    let (floor, size) = (bounds.min.y as f32, bounds.size().max_element() as f32);
    let ball = model("builtin:sphere@20k");
    let radius = 0.2 * size;
    append(&mut mesh, &ball, |p| {
        [radius * p[0] + 0.6 * size, radius * (p[1] + 1.0) + floor, radius * p[2] + 0.35 * size]
    });
    let edge = 1.4 * size;
    let corners = [[-edge, floor, edge], [edge, floor, edge], [edge, floor, -edge], [-edge, floor, -edge]];
    append(&mut mesh, &quad(corners, [0.0, 1.0, 0.0]), |p| p);
    let (top, back) = (floor + size, -0.8 * size);
    let corners = [[-edge, floor, back], [edge, floor, back], [edge, top, back], [-edge, top, back]];
    append(&mut mesh, &quad(corners, [0.0, 0.0, 1.0]), |p| p);
    mesh
}

/// A hollow ball: what is between two spheres.
pub fn hollow_ball() -> Mesh {
    let mut mesh = model("builtin:sphere@40k");
    let mut inside = model("builtin:sphere@20k");
    inside.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    for normal in inside.normals.iter_mut().flatten() {
        *normal = OctNormal::encode(normal.decode().map(|c| -c));
    }
    append(&mut mesh, &inside, |p| [0.6 * p[0] + 0.1, 0.6 * p[1] + 0.15, 0.6 * p[2]]);
    mesh
}

/// A floor that begins behind the camera at 0, 1, 0, with texture coordinates that count its units.
pub fn floor() -> Mesh {
    let (edge, behind, far) = (30.0, 5.0, -100.0);
    let corners = [[-edge, 0.0, behind], [edge, 0.0, behind], [edge, 0.0, far], [-edge, 0.0, far]];
    let mut mesh = quad(corners, [0.0, 1.0, 0.0]);
    mesh.texcoords = Some(corners.map(|[x, _, z]| [x * 0.5, -z * 0.5]).to_vec());
    mesh
}

/// Squares of two colours, and a mark that shows which side is up and which is left.
pub fn tiles() -> Picture {
    const EDGE: u32 = 512;
    let color = |x: u32, y: u32| match (x * 8 / EDGE, y * 8 / EDGE) {
        // The letter F.
        (1, 1..=6) | (2..=4, 1) | (2..=3, 3) => [200, 40, 30],
        (i, j) if (i + j) % 2 == 0 => [225, 215, 190],
        _ => [40, 70, 110],
    };
    let pixels = (0..EDGE * EDGE).flat_map(|i| {
        let [r, g, b] = color(i % EDGE, i / EDGE);
        [r, g, b, 255]
    });
    Picture::new(EDGE, EDGE, pixels.collect())
}

/// A fence on a floor, with the coordinates of [`bars`].
pub fn fence() -> Mesh {
    let normal = glam::Vec3::new(-0.3, 0.0, 3.0).normalize().to_array();
    let corners = [[-1.5, 0.2, 0.0], [1.5, 0.2, 0.3], [1.5, 2.2, 0.3], [-1.5, 2.2, 0.0]];
    let mut mesh = quad(corners, normal);
    let floor = [[-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0], [-3.0, 0.0, -3.0]];
    append(&mut mesh, &quad(floor, [0.0, 1.0, 0.0]), |p| p);
    // The floor shows the middle of the disc, a single colour.
    let all = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().chain([[0.5, 0.5]; 4]);
    mesh.texcoords = Some(all.collect());
    mesh
}

/// Bars and a disc; everything else is invisible.
pub fn bars() -> Picture {
    const EDGE: i32 = 512;
    let pixel = |x: i32, y: i32| {
        let (dx, dy) = (2 * x + 1 - EDGE, 2 * y + 1 - EDGE);
        let is_bar = |c: i32| c / 32 % 4 == 0 || c >= EDGE - 32;
        match dx * dx + dy * dy {
            ..40_000 => [190, 190, 180, 255],
            // The upper left corner has another colour.
            _ if (is_bar(x) || is_bar(y)) && x + y < 200 => [40, 90, 190, 255],
            _ if is_bar(x) || is_bar(y) => [180, 70, 50, 255],
            _ => [180, 70, 50, 0],
        }
    };
    let pixels = (0..EDGE * EDGE).flat_map(|i| pixel(i % EDGE, i / EDGE));
    Picture::new(EDGE as u32, EDGE as u32, pixels.collect())
}

/// Two triangles with one normal; `corners` are counter-clockwise.
fn quad(corners: [[f32; 3]; 4], normal: [f32; 3]) -> Mesh {
    Mesh {
        positions: corners.to_vec(),
        normals: Some(vec![OctNormal::encode(normal); 4]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Adds the triangles of another mesh, whose positions are changed without turning them.
fn append(mesh: &mut Mesh, other: &Mesh, place: impl Fn([f32; 3]) -> [f32; 3]) {
    let first = u32::try_from(mesh.positions.len()).expect("few vertices");
    // Both origins are 0: these meshes are small and round it.
    mesh.positions.extend(other.positions.iter().map(|p| place(*p)));
    mesh.normals.get_or_insert_default().extend(other.normals.iter().flatten());
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
}
