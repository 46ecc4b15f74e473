//! Times the reading of model files: `time_read FILE...`, the best of five runs each.

use std::time::Instant;

use tercio_mesh::io::{ReadOptions, read};

fn main() {
    for file in std::env::args().skip(1) {
        let mut best = f64::INFINITY;
        let mut shown = String::new();
        for _ in 0..5 {
            let begin = Instant::now();
            match read(&file, &ReadOptions::default()) {
                Ok(m) => {
                    shown = format!(
                        "{}: {} vertices, {} triangles, {:?}",
                        m.report.format,
                        m.mesh.positions.len(),
                        m.mesh.triangles.len(),
                        m.report.warnings
                    );
                    best = best.min(begin.elapsed().as_secs_f64());
                }
                Err(error) => shown = error.to_string(),
            }
        }
        let bytes = std::fs::metadata(&file).map_or(0, |m| m.len());
        println!("{file}: {best:.4} s, {:.0} MB/s. {shown}", bytes as f64 / best / 1e6);
    }
}
