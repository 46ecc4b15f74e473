//! Frames of distributed renderers: what of a published frame's time compositing and delivery take.

use tercio_parallel::Composition;

use super::{BYTES, Job, MEGAPIXEL, Shared, machine};
use crate::experiments::{
    Axis, Document, Experiment, ExperimentError, Findings, Plot, Series, Table, Verdict,
};
use crate::machines::Machine;
use crate::predict::advise::ends::ends;

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "others-framebuffer",
        document: Document::Others,
        place: "EuroVis 2019",
        title: "The Distributed FrameBuffer: compositing and delivery in published frames",
        run: framebuffer,
    },
    Experiment {
        id: "others-slic",
        document: Document::Others,
        place: "PVG 2003",
        title: "SLIC: frames a second on 64 nodes of 100BaseT",
        run: slic,
    },
];

/// A published frame.
struct Published {
    /// What is drawn.
    name: &'static str,
    machine: &'static str,
    nodes: usize,
    /// Pixels.
    pixels: f64,
    /// Frames a second.
    rate: f64,
    /// Every node draws all pixels of its part of the data, which the owners of tiles composite; otherwise nodes draw tiles.
    by_data: bool,
}

/// The Distributed FrameBuffer, W. Usher and others, EuroVis 2019, figure 1.
const FRAMES: [Published; 3] = [
    Published {
        name: "two isosurfaces",
        machine: "stampede2-skx",
        nodes: 16,
        pixels: 4.0 * MEGAPIXEL,
        rate: 8.0,
        by_data: false,
    },
    Published {
        name: "isosurface and volume",
        machine: "stampede2-knl",
        nodes: 64,
        pixels: 4.0 * MEGAPIXEL,
        rate: 5.0,
        by_data: true,
    },
    Published {
        name: "spheres",
        machine: "theta",
        nodes: 128,
        pixels: 4.0 * MEGAPIXEL,
        rate: 2.0,
        by_data: true,
    },
];

impl Published {
    fn job<'a>(&self, machine: &'a Machine) -> Result<Job<'a>, ExperimentError> {
        Job::new(machine, self.nodes, machine.most_threads() as usize)
    }

    /// Seconds of compositing and of delivery, if each node has that share of the picture.
    fn rest(&self, job: &Job, share: f64, bytes: f64, blend: f64) -> [f64; 2] {
        let of = Shared { pixels: self.pixels, share, bytes, blend };
        let composite = if self.by_data { job.composite(&of, Composition::DirectSend) } else { 0.0 };
        // A finished pixel has four bytes.
        [composite, job.deliver(self.pixels, BYTES[0])]
    }

    /// Seconds in which a thread may blend a pixel, so that compositing and delivery take all of the frame.
    fn slowest_blending(&self, job: &Job, share: f64, bytes: f64) -> Option<f64> {
        let [free, some] = [0.0, 1e-6].map(|blend| self.rest(job, share, bytes, blend).iter().sum::<f64>());
        let left = 1.0 / self.rate - free;
        (some > free && left > 0.0).then(|| left / (some - free) * 1e-6)
    }
}

fn framebuffer() -> Result<Findings, ExperimentError> {
    let mut table = Table::new(
        "frames",
        &[
            ("picture", ""),
            ("machine", ""),
            ("nodes", ""),
            ("published", "frames/s"),
            ("published frame", "ms"),
            ("pixel", "B"),
            ("share of the picture that a node has", "%"),
            ("compositing", "ms"),
            ("delivery", "ms"),
            ("both, assumed numbers at their fast ends", "ms"),
            ("both, at their slow ends", "ms"),
            ("blending may take", "ns"),
        ],
    );
    let mut beside = Vec::new();
    let (mut full, mut sparse) = (Vec::new(), Vec::new());
    for (number, frame) in FRAMES.iter().enumerate() {
        let machine = machine(frame.machine)?;
        let of_ends = ends(&machine).ok_or_else(|| format!("{} has no section uncertainty", machine.name))?;
        let x = number as f64 + 1.0;
        for (bytes, share) in BYTES.iter().flat_map(|&bytes| [0.1, 1.0].map(|share| (bytes, share))) {
            let job = frame.job(&machine)?;
            let [composite, deliver] = frame.rest(&job, share, bytes, 0.0).map(|seconds| seconds * 1e3);
            let mut at_ends = [0.0; 2];
            for (both, end) in at_ends.iter_mut().zip(&of_ends) {
                *both = 1e3 * frame.rest(&frame.job(&end.machine)?, share, bytes, 0.0).iter().sum::<f64>();
            }
            let blending = frame.slowest_blending(&job, share, bytes).map(|seconds| seconds * 1e9);
            table.push([
                frame.name.into(),
                frame.machine.into(),
                (frame.nodes as f64).into(),
                frame.rate.into(),
                (1e3 / frame.rate).into(),
                bytes.into(),
                (100.0 * share).into(),
                composite.into(),
                deliver.into(),
                at_ends[0].into(),
                at_ends[1].into(),
                blending.into(),
            ]);
            if bytes == BYTES[1] {
                let line = if share == 1.0 { &mut full } else { &mut sparse };
                line.push((x, 100.0 * (composite + deliver) * 1e-3 * frame.rate));
                if share == 1.0 {
                    beside.push(format!(
                        "{}: {:.1} ms ({:.1} to {:.1}) of the {:.0} ms of a frame",
                        frame.name,
                        composite + deliver,
                        at_ends[0],
                        at_ends[1],
                        1e3 / frame.rate
                    ));
                }
            }
        }
    }
    let plot = Plot::new(
        "frames",
        "Compositing and delivery on the wires, beside the frames that others measured",
        Axis::categories("picture", 1, FRAMES.map(|frame| frame.name)),
        Axis::linear("percent of the measured frame"),
    )
    .with(Series::points("every node has the whole picture", full))
    .with(Series::points("every node has a tenth", sparse));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "Published are 8, 5 and 2 frames a second (W. Usher and others, EuroVis 2019, figure 1). Ray tracing, which takes most of \
             them, is not predicted: samples a pixel, shading and what rays hit are not published with the figure. Predicted is what \
             compositing by direct send and delivery to one node take on the wires, with nothing for blending; the last column says how \
             long blending a pixel may take before these two alone take the whole frame."
                .into(),
            "The first picture is drawn by tiles, which are not composited. Tiles of the Distributed FrameBuffer are composited while \
             others are drawn; the formulas draw first."
                .into(),
            "Not predicted for want of inputs, by name: the display wall of Han and others (2020; the wall's link and how much JPEG \
             shrinks a picture), VisIt's ordered compositing (4 and 40 times its sort-first, whose work is not given), TOD-Tree and DSRB \
             (curves that we do not have), 2-3 swap (first page only), EnSight and LANL (rates of drawing)."
                .into(),
        ],
        verdict: Verdict::None {
            why: "Whole frames are printed, of which compositing and delivery are a part that is not given: only a model that is wrong by \
                  about a factor of twenty would contradict print."
                .into(),
            beside: format!("full pictures of 16 B a pixel take, on the wires: {}.", beside.join("; ")),
        },
    })
}

fn slic() -> Result<Findings, ExperimentError> {
    let machine = machine("slic-cluster")?;
    let [fast, slow] = ends(&machine).ok_or("slic-cluster has no section uncertainty")?;
    let frame = |machine: &Machine, share: f64| -> Result<[f64; 2], ExperimentError> {
        let job = Job::new(machine, 64, 1)?;
        let of = Shared { pixels: MEGAPIXEL, share, bytes: BYTES[0], blend: 0.0 };
        Ok([job.composite(&of, Composition::DirectSend), job.deliver(MEGAPIXEL, BYTES[0])])
    };
    let rate = |seconds: [f64; 2]| 1.0 / seconds.iter().sum::<f64>();
    let mut table = Table::new(
        "rates",
        &[
            ("share of the picture that a node has", "%"),
            ("compositing", "ms"),
            ("delivery", "ms"),
            ("at most", "frames/s"),
            ("assumed numbers at their slow ends", "frames/s"),
            ("at their fast ends", "frames/s"),
        ],
    );
    let mut lines = [Vec::new(), Vec::new(), Vec::new()];
    for share in (0..=24).map(|k| 2f64.powf(-6.0 + 0.25 * f64::from(k))) {
        let ours = frame(&machine, share)?;
        let rates = [rate(ours), rate(frame(&slow.machine, share)?), rate(frame(&fast.machine, share)?)];
        let percent = 100.0 * share;
        let [composite, deliver] = ours.map(|seconds| seconds * 1e3);
        let [at_most, slow, fast] = rates.map(Into::into);
        table.push([percent.into(), composite.into(), deliver.into(), at_most, slow, fast]);
        lines.iter_mut().zip(rates).for_each(|(line, rate)| line.push((percent, rate)));
    }
    let best = lines[0].iter().map(|point| point.1).fold(0.0, f64::max);
    let several = lines[0].iter().filter(|point| point.1 >= 2.0).map(|point| point.0).fold(0.0, f64::max);
    let full = rate(frame(&machine, 1.0)?);
    let [middle, slower, faster] = lines;
    let plot = Plot::new(
        "rates",
        "1024x1024 pixels on 64 nodes of 100BaseT",
        Axis::log2("percent of the picture that a node has"),
        Axis::linear("frames a second at most"),
    )
    .with(Series::line("direct send and delivery", middle))
    .with(Series::line("assumed numbers at their slow ends", slower))
    .with(Series::line("assumed numbers at their fast ends", faster));
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![format!(
            "Published: 1024x1024 pixels at several frames a second on 64 nodes of 100BaseT (A. Stompel and others, PVG 2003, \
             abstract). Our formulas have no schedule of lines: direct send stands for it. Without drawing and blending, 2 frames a second \
             are reached while a node has up to {several:.1} % of the picture; delivery alone, uncompressed to one node, allows {:.2}.",
            1.0 / frame(&machine, 1.0)?[1]
        )],
        verdict: Verdict::None {
            why: "Printed is 'several frames a second': no number, no share of the picture that a node has, and not whether the picture is \
                  compressed."
                .into(),
            beside: format!(
                "compositing and delivery allow {full:.1} frames a second with full pictures, and {best:.1} at most."
            ),
        },
    })
}
