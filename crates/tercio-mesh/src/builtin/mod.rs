//! Models made by the program: they need no file, have any number of triangles, and have the same bits on every
//! machine (see [`crate::trig`]). +Y is up, and each is about two units large, except for the teapot, which keeps its
//! classic size.

mod gyroid;
mod noise;
mod soup;
mod sphere;
mod teapot;
mod terrain;

use crate::Mesh;

/// Each built-in model's name, default number of triangles, and function that makes it.
const MODELS: [(&str, u64, Maker); 5] = [
    ("teapot", 100_000, |count, _| teapot::teapot(count)),
    ("gyroid", 1_000_000, |count, _| gyroid::gyroid(count)),
    ("terrain", 1_000_000, terrain::terrain),
    ("sphere", 100_000, |count, _| sphere::sphere(count)),
    ("soup", 100_000, soup::soup),
];

type Maker = fn(u64, u64) -> Mesh;

/// The most triangles that can be requested; a soup has three vertices per triangle, and they must be numbered.
const MAX_COUNT: u64 = crate::mesh::MAX_ELEMENTS / 3;

/// Why a built-in model could not be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuiltinError {
    /// The text does not have the expected form.
    #[error("{spec}: expected builtin:NAME[@COUNT[k|M|G]][?seed=N], found \"{found}\" for {part}")]
    Syntax {
        /// The text as the user gave it.
        spec: String,
        /// The part that is wrong.
        part: &'static str,
        /// What was found there.
        found: String,
    },
    /// There is no model of this name.
    #[error("{spec}: there is no model \"{name}\"; there are teapot, gyroid, terrain, sphere and soup")]
    UnknownName {
        /// The text as the user gave it.
        spec: String,
        /// The name.
        name: String,
    },
    /// The number of triangles is zero or too large.
    #[error("{spec}: {count} triangles, expected 1 to {MAX_COUNT}")]
    Count {
        /// The text as the user gave it.
        spec: String,
        /// The requested number of triangles.
        count: u64,
    },
}

/// Makes the model `builtin:NAME[@COUNT[k|M|G]][?seed=N]`.
///
/// NAME is teapot, gyroid, terrain, sphere or soup. COUNT is a decimal number of triangles (`5.4M`) that the model
/// comes close to: within 5 % from 1000 triangles on, exactly for the soup; each model has a minimum number. The seed
/// (default 0) shapes terrain and soup and has no effect on the others.
///
/// The mesh has vertex normals, except for the soup; terrain has vertex colours and the soup face colours.
///
/// # Errors
/// [`BuiltinError`] if there is no such model.
pub fn make(spec: &str) -> Result<Mesh, BuiltinError> {
    let Plan { maker, count, seed } = plan(spec)?;
    Ok(maker(count, seed))
}

/// Approximate number of bytes that [`make`] takes for a model: its mesh and temporary memory.
///
/// # Errors
/// As [`make`].
pub fn needed_bytes(spec: &str) -> Result<u64, BuiltinError> {
    // The soup takes most: three vertices, three vertex numbers and a colour per triangle.
    const A_TRIANGLE: u64 = 3 * 12 + 12 + 4;
    Ok(plan(spec)?.count.saturating_mul(A_TRIANGLE))
}

/// A parsed specification.
struct Plan {
    maker: Maker,
    count: u64,
    seed: u64,
}

fn plan(spec: &str) -> Result<Plan, BuiltinError> {
    let syntax = |part, found: &str| BuiltinError::Syntax { spec: spec.into(), part, found: found.into() };
    let rest = spec.strip_prefix("builtin:").ok_or_else(|| syntax("the scheme", spec))?;
    let (rest, query) = rest.split_once('?').map_or((rest, None), |(r, q)| (r, Some(q)));
    let (name, count) = rest.split_once('@').map_or((rest, None), |(n, c)| (n, Some(c)));
    let &(_, default, maker) = MODELS
        .iter()
        .find(|m| m.0 == name)
        .ok_or_else(|| BuiltinError::UnknownName { spec: spec.into(), name: name.into() })?;
    let count = match count {
        None => default,
        Some(text) => parse_count(text).ok_or_else(|| syntax("COUNT", text))?,
    };
    if count == 0 || count > MAX_COUNT {
        return Err(BuiltinError::Count { spec: spec.into(), count });
    }
    let seed = match query {
        None => 0,
        Some(q) => {
            q.strip_prefix("seed=").and_then(|n| n.parse().ok()).ok_or_else(|| syntax("the seed", q))?
        }
    };
    Ok(Plan { maker, count, seed })
}

/// A decimal number with an optional suffix k, M or G, rounded to whole triangles.
fn parse_count(text: &str) -> Option<u64> {
    let (digits, unit) = match text.char_indices().next_back()? {
        (at, 'k' | 'K') => (&text[..at], 1e3),
        (at, 'm' | 'M') => (&text[..at], 1e6),
        (at, 'g' | 'G') => (&text[..at], 1e9),
        _ => (text, 1.0),
    };
    let plain = digits.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let value: f64 = digits.parse().ok().filter(|_| plain)?;
    Some((value * unit).round() as u64)
}

/// A grid of `a` by `b` cells, row after row of `a + 1` vertices from number `first` on; each cell is split into two
/// triangles.
///
/// The triangles are counter-clockwise seen from the side where a is to the right and b upwards.
fn grid_cell(first: u64, a: u64, i: u64, j: u64) -> [[u32; 3]; 2] {
    let at = |i: u64, j: u64| (first + j * (a + 1) + i) as u32;
    let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
    [[p, q, r], [p, r, s]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    pub(super) fn check_normals(mesh: &Mesh, least: f64) {
        let p = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
        let normals = mesh.normals.as_ref().unwrap();
        for &[a, b, c] in &mesh.triangles {
            let face = (p(b) - p(a)).cross(p(c) - p(a)).normalize();
            for v in [a, b, c] {
                let n = DVec3::from(normals[v as usize].decode().map(f64::from)).normalize();
                assert!(face.dot(n) > least, "{face} {n} at {}", p(v));
            }
        }
    }

    #[test]
    fn counts_are_met() {
        for name in ["teapot", "gyroid", "terrain", "sphere", "soup"] {
            let mut counts = vec![1000u64, 2_000_000];
            counts.extend((0..60).map(|i| 1000 + i * i * 37 + i * 13));
            let mut bad = Vec::new();
            for count in counts {
                let mesh = make(&format!("builtin:{name}@{count}")).unwrap();
                let made = mesh.triangles.len() as f64;
                if (made / count as f64 - 1.0).abs() > 0.05 {
                    bad.push((count, made));
                }
                assert!(mesh.normals.as_ref().is_none_or(|n| n.len() == mesh.positions.len()));
                if count < 10_000 {
                    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
                    assert_eq!(crate::clean::clean(&mut mesh.clone()), Default::default(), "{name}@{count}");
                }
            }
            assert!(bad.is_empty(), "{name}: {bad:?}");
            for count in [1, 2, 10, 100, 500] {
                assert!(!make(&format!("builtin:{name}@{count}")).unwrap().triangles.is_empty());
            }
        }
    }

    #[test]
    fn bits_do_not_depend_on_threads() {
        for name in ["teapot", "gyroid", "terrain", "sphere", "soup"] {
            let spec = format!("builtin:{name}@100k?seed=3");
            let made = [1, 2, 3, 7].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let m = pool.install(|| make(&spec)).unwrap();
                (m.positions, m.triangles, m.normals, m.vertex_colors, m.face_colors)
            });
            assert!(made.iter().all(|m| *m == made[0]), "{name}");
        }
    }

    #[test]
    fn specs_are_parsed() {
        assert_eq!(parse_count("5.4M"), Some(5_400_000));
        assert_eq!(parse_count("12k"), Some(12_000));
        assert_eq!(parse_count("7"), Some(7));
        for wrong in ["", "k", "-1", "1e3", "inf", "5.4.1M", "M5", "nan"] {
            assert_eq!(parse_count(wrong), None, "{wrong}");
        }
        let wrong = |s: &str| make(s).unwrap_err().to_string();
        assert!(wrong("builtin:cow").contains("teapot, gyroid"));
        assert!(wrong("builtin:soup@x").contains("\"x\" for COUNT"));
        assert!(wrong("builtin:soup?sed=1").contains("the seed"));
        assert!(wrong("builtin:soup?seed=-1").contains("the seed"));
        assert!(wrong("soup").contains("builtin:NAME"));
        assert!(matches!(make("builtin:soup@0"), Err(BuiltinError::Count { count: 0, .. })));
        assert!(matches!(make("builtin:soup@99999999G"), Err(BuiltinError::Count { .. })));
        assert_ne!(
            make("builtin:soup@9?seed=1").unwrap().positions,
            make("builtin:soup@9").unwrap().positions
        );
    }
}
