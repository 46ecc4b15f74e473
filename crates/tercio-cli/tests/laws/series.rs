//! Files that are hard to read, in any size: the laws have to hold for them.

use std::fmt::Write as _;
use std::io::Write as _;

/// Makes a file of about `n` elements, whatever they are.
pub type Maker = fn(usize) -> Vec<u8>;

/// Triangles of three vertices each as binary PLY.
fn ply(
    vertices: impl ExactSizeIterator<Item = [f32; 3]>,
    triangles: impl ExactSizeIterator<Item = [usize; 3]>,
) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .into_bytes();
    file.extend(vertices.flatten().flat_map(f32::to_le_bytes));
    for t in triangles {
        file.push(3);
        file.extend(t.iter().flat_map(|&v| (v as u32).to_le_bytes()));
    }
    file
}

/// A header for ASCII PLY with three vertices and one face, with additional properties of each and lines after them.
fn ascii_ply(of_vertex: &str, of_face: &str, more: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{of_vertex}\
         element face 1\n{of_face}property list uchar int vertex_indices\n{more}end_header\n"
    )
}

fn repeated(n: usize, line: impl Fn(&mut String, usize)) -> String {
    let mut text = String::new();
    (0..n).for_each(|i| line(&mut text, i));
    text
}

macro_rules! lines {
    ($n:expr, $i:ident => $($format:tt)*) => {
        repeated($n, |text, $i| { let _ = write!(text, $($format)*); })
    };
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

fn round(i: usize, n: usize) -> [f32; 3] {
    let angle = i as f32 / n as f32 * 6.25;
    [angle.cos(), angle.sin(), (i % 3) as f32 * 0.1]
}

/// All triangles share a vertex.
fn fan(n: usize) -> Vec<u8> {
    let rim = (0..n + 2).map(|i| if i == 0 { [0.0, 0.0, 1.0] } else { round(i, n) });
    ply(rim, (0..n).map(|i| [0, i + 1, i + 2]))
}

/// All triangles share an edge.
fn book(n: usize) -> Vec<u8> {
    let edges = (0..n + 2).map(|i| if i < 2 { [0.0, 0.0, i as f32] } else { round(i, n) });
    ply(edges, (0..n).map(|i| [0, 1, i + 2]))
}

fn duplicate_triangles(n: usize) -> Vec<u8> {
    ply((0..3).map(|i| round(i, 3)), (0..n).map(|_| [0, 1, 2]))
}

fn duplicate_vertices(n: usize) -> Vec<u8> {
    ply(
        (0..n).map(|i| [i % 7, i % 5, i % 3].map(|x| x as f32)),
        (0..n).map(|i| [i, (i + 1) % n, (i + 2) % n]),
    )
}

fn one_point(n: usize) -> Vec<u8> {
    ply((0..n).map(|_| [1.0; 3]), (0..n).map(|i| [i, (i + 1) % n, (i + 2) % n]))
}

/// Triangles without area along one long edge.
fn flat_triangles(n: usize) -> Vec<u8> {
    let on_a_line = (0..n + 3).map(|i| [i as f32, if i == n + 2 { 1.0 } else { 0.0 }, 0.0]);
    ply(on_a_line, (0..n).map(|i| if i == 0 { [0, n + 1, n + 2] } else { [0, n + 1, i] }))
}

fn binary_stl(n: usize, corner: impl Fn(usize) -> [u32; 3]) -> Vec<u8> {
    let mut file = vec![0; 80];
    file.extend((n as u32).to_le_bytes());
    for i in 0..n {
        file.extend([0; 12]);
        file.extend((0..3).flat_map(|k| corner(3 * i + k)).flat_map(u32::to_le_bytes));
        file.extend([0; 2]);
    }
    file
}

/// Vertices that collide in a hash with a fixed multiplier, of x and y over a multiple of z.
fn colliding_vertices(n: usize) -> Vec<u8> {
    let mut crafted = Vec::with_capacity(3 * n);
    let mut z = 0x3f80_0000u32;
    while crafted.len() < 3 * n {
        let xy = u64::from(z).wrapping_mul(0xa24b_aed4_963e_e407);
        let point = [xy as u32, (xy >> 32) as u32, z];
        if point.iter().all(|&x| f32::from_bits(x).is_normal()) {
            crafted.push(point);
        }
        z += 1;
    }
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {n}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * n
    )
    .into_bytes();
    bytes.extend(crafted[..3 * n].iter().flatten().flat_map(|bits| bits.to_le_bytes()));
    for face in 0..n as u32 {
        bytes.push(3);
        bytes.extend((3 * face..3 * face + 3).flat_map(u32::to_le_bytes));
    }
    bytes
}

fn soup_with_nan(n: usize) -> Vec<u8> {
    binary_stl(n, |i| [i % 9, i % 7, i % 5].map(|x| if i % 16 == 3 { f32::NAN } else { x as f32 }.to_bits()))
}

fn properties(n: usize) -> Vec<u8> {
    let row = |k: usize| format!("{} {} 0{}\n", k & 1, k >> 1, " 1".repeat(n));
    let header = ascii_ply(&lines!(n, i => "property float p{i}\n"), "", "");
    (header + &row(0) + &row(1) + &row(2) + "3 0 1 2\n").into_bytes()
}

fn list_properties(n: usize) -> Vec<u8> {
    let header = ascii_ply("", &lines!(n, i => "property list uchar int p{i}\n"), "");
    (header + "0 0 0\n1 0 0\n0 1 0\n" + &"0 ".repeat(n) + "3 0 1 2\n").into_bytes()
}

fn elements(n: usize) -> Vec<u8> {
    let header = ascii_ply("", "", &lines!(n, i => "element e{i} 1\nproperty float a\n"));
    (header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" + &"1\n".repeat(n)).into_bytes()
}

fn comments(n: usize) -> Vec<u8> {
    let header = ascii_ply("", "", &"comment TextureFile a.png\ncomment hello\n".repeat(n));
    (header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").into_bytes()
}

/// All faces disagree about the texture coordinates of one vertex.
fn texture_at_corners(n: usize) -> Vec<u8> {
    let header = ascii_ply("", "", "").replace("face 1", &format!("face {n}"));
    let header = header.replace("end_header", "property list uchar float texcoord\nend_header");
    (header + "0 0 0\n1 0 0\n0 1 0\n" + &lines!(n, i => "3 0 1 2 6 {i} 0 0 0 0 0\n")).into_bytes()
}

fn texture_indices(n: usize) -> Vec<u8> {
    let text =
        TRIANGLE.to_owned() + &lines!(n, i => "vt {i} 0\n") + &lines!(n, i => "f 1/{} 2/1 3/1\n", i + 1);
    text.into_bytes()
}

fn names(n: usize) -> Vec<u8> {
    (TRIANGLE.to_owned() + &lines!(n, i => "usemtl m{i}\ng g{i}\no o{i}\nf 1 2 3\n")).into_bytes()
}

fn libraries(n: usize) -> Vec<u8> {
    let text = TRIANGLE.to_owned()
        + &lines!(n, i => "mtllib {}a.mtl b{i}.mtl\nusemtl m{i}\nf 1 2 3\n", "./".repeat(i % 50));
    text.into_bytes()
}

fn continued_lines(n: usize) -> Vec<u8> {
    (TRIANGLE.to_owned() + &" ".repeat(n) + &"\\\n".repeat(n) + "\n" + TRIANGLE).into_bytes()
}

fn long_lines(n: usize) -> Vec<u8> {
    // The line is drawn, which takes longer than reading it.
    let text = format!("{TRIANGLE}# {}\ng{}\nl{}\n", "x".repeat(n), " y".repeat(n), " 1".repeat(n / 20));
    text.into_bytes()
}

fn indices_from_the_end(n: usize) -> Vec<u8> {
    (TRIANGLE.to_owned() + &lines!(n, i => "v {i} {} 0\nf -1 -2 -3\n", i % 7)).into_bytes()
}

fn pentagons(n: usize) -> Vec<u8> {
    ("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 1.2 0\n".to_owned() + &"f 1 2 3 5 4\n".repeat(n)).into_bytes()
}

fn polygon(corners: impl Iterator<Item = [f64; 2]>) -> Vec<u8> {
    let (mut text, mut count) = (String::new(), 0);
    for [x, y] in corners {
        let _ = writeln!(text, "v {x} {y} 0");
        count += 1;
    }
    text += "f";
    (1..=count).for_each(|i| _ = write!(text, " {i}"));
    text.into_bytes()
}

fn comb(n: usize) -> Vec<u8> {
    let teeth = n / 4;
    let below = [[0.0, -1.0], [2.0 * teeth as f64, -1.0]];
    let tooth = |i: f64| [[i + 1.0, 0.0], [i + 1.0, 100.0], [i, 100.0], [i, 0.0]];
    polygon(below.into_iter().chain((0..teeth).rev().flat_map(|i| tooth(2.0 * i as f64))))
}

/// Interleaved teeth that nearly touch, so that nearly no corner is an ear.
fn interleaved_combs(n: usize) -> Vec<u8> {
    let teeth = n / 6;
    let there = |i: f64| [[i, 0.0], [i + 1.0, 1000.0], [i + 2.0, 1000.0], [i + 3.0, 0.0]];
    let back = |i: f64| [[i + 2.4, 0.5], [i + 1.9, 999.0]];
    let there = (0..teeth).flat_map(|i| there(4.0 * i as f64));
    polygon(there.chain((0..teeth).rev().flat_map(|i| back(4.0 * i as f64))))
}

fn crossing_star(n: usize) -> Vec<u8> {
    let turn = std::f64::consts::TAU * (n as f64 / (2 * n + 1) as f64);
    polygon((0..2 * n + 1).map(|i| [(i as f64 * turn).cos(), (i as f64 * turn).sin()]))
}

fn spiral(n: usize) -> Vec<u8> {
    let arm = |i: usize, r: f64| {
        let t = i as f64 * 0.02;
        [(t + r) * t.cos(), (t + r) * t.sin()]
    };
    polygon((0..n / 2).map(|i| arm(i, 0.05)).chain((0..n / 2).rev().map(|i| arm(i, 0.0))))
}

fn off(n: usize) -> Vec<u8> {
    let vertices = lines!(n + 2, i => "{i} {} {}\n", i % 7, i % 3);
    let faces = lines!(n, i => "3 {i} {} {} {} 0 0\n", i + 1, i + 2, i % 2);
    format!("OFF\n{} {n} 0\n{vertices}{faces}", n + 2).into_bytes()
}

/// A large file with a small mesh: numbers of many digits.
fn digits(n: usize) -> Vec<u8> {
    let vertices = lines!(n, i => "v {:.600} {:.600} 0.5\n", i as f64 / 7.0, (i * i) as f64 / 3.0);
    (vertices + &lines!(n - 2, i => "f {} {} {}\n", i + 1, i + 2, i + 3)).into_bytes()
}

/// A gzip file of many members, most of them empty.
fn members(n: usize) -> Vec<u8> {
    let compressed = |text: &str| {
        let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        out.write_all(text.as_bytes()).expect("room");
        out.finish().expect("room")
    };
    [compressed(TRIANGLE), compressed("").repeat(n)].concat()
}

/// A small gzip file that decompresses to a large one.
fn bomb(n: usize) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    (0..n).for_each(|_| out.write_all(TRIANGLE.repeat(100).as_bytes()).expect("room"));
    out.finish().expect("room")
}

/// A small mesh in a large file: of its hundred coordinates three are drawn.
fn wide_vertices(n: usize) -> Vec<u8> {
    let words = [n as u32, 1, 0].map(u32::to_be_bytes);
    let vertex = |i: usize| (0..100).flat_map(move |k| ((i % (k + 7)) as f32).to_be_bytes());
    let mut file = b"nOFF 100 BINARY\n".to_vec();
    file.extend(words.into_iter().flatten().chain((0..n).flat_map(vertex)));
    file.extend([3u32, 0, 1, 2, 0].iter().flat_map(|word| word.to_be_bytes()));
    file
}

/// Faces are scanned before it is known that there is no memory for them.
fn binary_faces(n: usize) -> Vec<u8> {
    let mut words = vec![3, n as u32, 0];
    words.extend([[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.]].iter().flatten().map(|x| x.to_bits()));
    (0..n).for_each(|_| words.extend([3, 0, 1, 2, 0]));
    b"OFF BINARY\n".iter().copied().chain(words.into_iter().flat_map(u32::to_be_bytes)).collect()
}

/// Tetrahedra on one face: all of their faces have few different lowest corners.
fn shared_face(n: usize) -> Vec<u8> {
    let points = n + 3;
    format!(
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {points} float\n{}CELLS {n} {}\n{}CELL_TYPES {n}\n{}",
        lines!(points, i => "{} {} {}\n", i % 9, i % 7, i % 5),
        5 * n,
        lines!(n, i => "4 0 1 2 {}\n", i + 3),
        "10\n".repeat(n)
    )
    .into_bytes()
}

/// Very many pieces of a triangle each, with an array that each has and one that only one has.
fn pieces(n: usize) -> Vec<u8> {
    let piece = lines!(n, i =>
        "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><PointData><DataArray type=\"Float32\" Name=\"all\" format=\"ascii\">1 2 3\
         </DataArray></PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">{i} 0 0 {i} 1 0 0 1 1\
         </DataArray></Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>\
         <DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece>\n"
    );
    format!("<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData>{piece}</PolyData></VTKFile>")
        .into_bytes()
}

/// A table of points with a colour.
fn table(n: usize) -> String {
    lines!(n, i => "{} {} {} {} 7 9\n", i % 9, i % 7, i % 5, i % 255)
}

fn pcd(n: usize) -> Vec<u8> {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z a b c\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH {n}\nHEIGHT 1\n\
         POINTS {n}\nDATA ascii\n{}",
        table(n)
    )
    .into_bytes()
}

/// Points of LAS 1.2 in their simplest form.
fn las(n: usize) -> Vec<u8> {
    let mut file = vec![0u8; 227];
    file[..4].copy_from_slice(b"LASF");
    (file[24], file[25]) = (1, 2);
    file[94..96].copy_from_slice(&227u16.to_le_bytes());
    file[96..100].copy_from_slice(&227u32.to_le_bytes());
    file[105..107].copy_from_slice(&20u16.to_le_bytes());
    file[107..111].copy_from_slice(&(n as u32).to_le_bytes());
    // Scales, offsets, and the largest and smallest coordinate of each axis.
    let numbers = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0, 0.08, 0.0, 0.06, 0.0, 0.04, 0.0];
    for (slot, number) in file[131..].chunks_exact_mut(8).zip(numbers) {
        slot.copy_from_slice(&f64::to_le_bytes(number));
    }
    for i in 0..n as i32 {
        file.extend([i % 9, i % 7, i % 5].into_iter().flat_map(i32::to_le_bytes));
        file.extend([0; 8]);
    }
    file
}

fn padded(model: &[u8], zeros: usize) -> Vec<u8> {
    [model, &vec![0; zeros]].concat()
}

/// Name, number of elements that take a measurable time, and maker.
pub const SERIES: [(&str, usize, Maker); 50] = [
    ("fan.ply", 62_500, fan),
    ("book.ply", 62_500, book),
    ("duplicate_triangles.ply", 12_000, duplicate_triangles),
    ("duplicate_vertices.ply", 12_000, duplicate_vertices),
    ("one_point.ply", 12_000, one_point),
    ("flat_triangles.ply", 12_000, flat_triangles),
    ("colliding_vertices.ply", 3_000, colliding_vertices),
    ("soup_with_nan.stl", 12_000, soup_with_nan),
    ("properties.ply", 5_000, properties),
    ("list_properties.ply", 5_000, list_properties),
    ("elements.ply", 12_000, elements),
    ("comments.ply", 12_000, comments),
    ("texture_at_corners.ply", 12_000, texture_at_corners),
    ("texture_indices.obj", 12_000, texture_indices),
    ("names.obj", 12_000, names),
    ("libraries.obj", 2_000, libraries),
    ("continued_lines.obj", 10_000, continued_lines),
    ("long_lines.obj", 400_000, long_lines),
    ("indices_from_the_end.obj", 12_000, indices_from_the_end),
    ("pentagons.obj", 12_000, pentagons),
    ("comb.obj", 6_000, comb),
    ("interleaved_combs.obj", 6_000, interleaved_combs),
    ("crossing_star.obj", 6_000, crossing_star),
    ("spiral.obj", 12_000, spiral),
    ("tall.off", 12_000, off),
    ("digits.obj", 1_000, digits),
    ("members.obj.gz", 2_000, members),
    ("bomb.obj.gz", 20, bomb),
    ("quoted_comments.ply", 3_000, |n| [comments(n), vec![b'\n'; n]].concat()),
    ("trailing.stl", 3_000, |n| {
        let soup = binary_stl(n, |i| [i % 9, i % 7, i % 5].map(|x| (x as f32).to_bits()));
        [soup, vec![7; n]].concat()
    }),
    ("lone_returns.obj", 12_000, |n| {
        names(n).into_iter().map(|b| if b == b'\n' { b'\r' } else { b }).collect()
    }),
    ("wide.obj", 12_000, |n| names(n).into_iter().flat_map(|b| [b, 0]).collect()),
    ("wide_vertices.off", 12_000, wide_vertices),
    ("binary_faces.off", 150_000, binary_faces),
    ("large.stl", 60_000, |n| binary_stl(n, |i| [i % 9, i % 7, i % 5].map(|x| (x as f32).to_bits()))),
    ("shared_face.vtk", 12_000, shared_face),
    ("pieces.vtp", 1_000, pieces),
    ("table.xyz", 20_000, |n| table(n).into_bytes()),
    ("points.pcd", 20_000, pcd),
    ("points.las", 40_000, las),
    ("padded.obj", 3_000_000, |n| padded(TRIANGLE.as_bytes(), n)),
    ("padded.off", 3_000_000, |n| padded(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", n)),
    ("padded.stl", 3_000_000, |n| {
        padded(&binary_stl(9, |i| [i % 9, i % 7, i % 5].map(|x| (x as f32).to_bits())), n)
    }),
    ("padded.obj.gz", 5_000_000, |n| padded(&members(1), n)),
    ("zeros.stl", 3_000_000, |n| vec![0; n]),
    ("comments_before.obj", 400_000, |n| ("# hello\n".repeat(n) + TRIANGLE).into_bytes()),
    ("comments_inside.off", 400_000, |n| {
        let front = "OFF\n# hello\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n".to_owned();
        (front + &"# hello\n".repeat(n) + &"\n".repeat(8 * n) + "3 0 1 2\n").into_bytes()
    }),
    ("blanks_before.ply", 3_000_000, |n| [vec![b'\n'; n], fan(3)].concat()),
    ("long_comment.ply", 3_000_000, |n| {
        let header = ascii_ply("", "", &format!("comment {}\n", "x".repeat(n)));
        (header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").into_bytes()
    }),
    ("long_comment.obj", 3_000_000, |n| format!("# {}\n{TRIANGLE}", "x".repeat(n)).into_bytes()),
];
