//! Radix-k beside binary swap on Intrepid, without reduction of pixels: T. Peterka and others, SC09.

use tercio_parallel::Composition;

use super::{BYTES, Job, MEGAPIXEL, Shared, machine};
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Fit, Plot, Series, Table,
};

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "others-radix-k",
    document: Document::Others,
    place: "SC09",
    title: "Radix-k and binary swap on Blue Gene/P",
    run: radix_k,
}];

/// Processes, four a node; the published range is 32 to 35,000.
const RANKS: [usize; 7] = [32, 128, 512, 2048, 8192, 32768, 35000];
/// Nanoseconds in which a pixel is blended: nothing, and more than any processor of its time needs.
const BLENDS: [f64; 3] = [0.0, 10.0, 100.0];

/// What a gain may mean, from the time of binary swap over that of radix-k.
type Percent = fn(f64) -> f64;
const GAINS: [(&str, Percent); 2] =
    [("faster", |ratio| 100.0 * (ratio - 1.0)), ("less time", |ratio| 100.0 * (1.0 - 1.0 / ratio))];

/// Binary swap, the best radix and radix-k in seconds.
fn both(job: &Job, of: &Shared) -> (f64, u32, f64) {
    let (radix, seconds) = job.radix_k(of);
    (job.composite(of, Composition::BinarySwap), radix, seconds)
}

fn radix_k() -> Result<Findings, ExperimentError> {
    let intrepid = machine("intrepid")?;
    let jobs = RANKS.iter().map(|&ranks| Job::new(&intrepid, ranks, 1)).collect::<Result<Vec<_>, _>>()?;
    let full = |megapixels: f64, bytes, blend: f64| Shared {
        pixels: megapixels * MEGAPIXEL,
        share: 1.0,
        bytes,
        blend: blend * 1e-9,
    };
    let mut table = Table::new(
        "times",
        &[
            ("processes", ""),
            ("picture", "Mpixel"),
            ("pixel", "B"),
            ("blending", "ns"),
            ("binary swap", "s"),
            ("best radix", ""),
            ("radix-k", "s"),
            ("radix-k is faster by", "%"),
        ],
    );
    for megapixels in [1.0, 4.0, 16.0, 64.0] {
        for (bytes, blend) in BYTES.iter().flat_map(|&bytes| BLENDS.map(|blend| (bytes, blend))) {
            for job in &jobs {
                let (swap, radix, seconds) = both(job, &full(megapixels, bytes, blend));
                table.push([
                    (job.ranks as f64).into(),
                    megapixels.into(),
                    bytes.into(),
                    blend.into(),
                    swap.into(),
                    f64::from(radix).into(),
                    seconds.into(),
                    (100.0 * (swap / seconds - 1.0)).into(),
                ]);
            }
        }
    }
    // From a picture of 4096 pixels, which nobody composites, to the largest of which anything is published.
    let sizes: Vec<f64> = (-8..=6).map(|power| 2f64.powi(power)).collect();
    let mut comparison = Comparison::new();
    // Processes that are no power of two: binary swap first gives the pixels of the others to some, which blend all of them.
    let mut readings = Vec::new();
    let odd = || jobs.iter().filter(|job| !job.ranks.is_power_of_two());
    for (job, bytes) in odd().flat_map(|job| BYTES.map(|bytes| (job, bytes))) {
        let ratio = |blend: f64| {
            let (swap, _, seconds) = both(job, &full(4.0, bytes, blend));
            (blend, swap / seconds)
        };
        let ratios: Vec<_> = (0..=40).map(|k| ratio(5.0 * f64::from(k))).collect();
        for (what, of) in GAINS {
            let percent = ratios.iter().map(|&(blend, ratio)| (blend, of(ratio))).collect();
            let number = format!("{} processes, 4 Mpixel of {bytes} B, 40 % {what}", job.ranks);
            readings.push(Fit::new(number, "ns in which a pixel is blended", "40", percent));
        }
    }
    comparison.fit_one_of(readings);
    let mut plot = Plot::new(
        "gain",
        "Radix-k beside binary swap, full pictures of 4 B a pixel, nothing for blending",
        Axis::log2("picture in Mpixel"),
        Axis::linear("time of binary swap over that of radix-k"),
    );
    for ranks in [32, 2048, 32768, 35000] {
        let Some(job) = jobs.iter().find(|job| job.ranks == ranks) else { continue };
        let ratio = |&size: &f64| {
            let (swap, _, seconds) = both(job, &full(size, BYTES[0], 0.0));
            (size, swap / seconds)
        };
        let ratios: Vec<_> = sizes.iter().map(ratio).collect();
        let reading = |(what, of): (&str, Percent)| {
            let percent = ratios.iter().map(|&(size, ratio)| (size, of(ratio))).collect();
            Fit::new(format!("{ranks} processes, 40 % {what}"), "Mpixel of the picture", "40", percent)
        };
        if ranks.is_power_of_two() {
            comparison.fit_one_of(GAINS.map(reading).to_vec());
        }
        plot = plot.with(Series::line_points(format!("{ranks} processes"), ratios));
    }
    let ends = [sizes[0], sizes[sizes.len() - 1]];
    plot = plot
        .with(Series::line("published: 40 % faster", ends.map(|x| (x, 1.4)).to_vec()).published())
        .with(Series::line("published: 40 % less time", ends.map(|x| (x, 1.0 / 0.6)).to_vec()).published());
    Ok(Findings {
        tables: vec![table, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            "Published is a gain of about 40 % over binary swap from 32 to 35,000 processes (mcs.anl.gov/~tpeterka/composite.html); \
             the pictures, the radices and whether it is speed or time are not given there. The formulas are those of \
             --organisation auto with Intrepid's torus, links and MPI latency."
                .into(),
            "With full pictures and a power of two of processes both strategies send and blend the same pixels: all but those that a \
             process keeps. In the formulas only rounds and messages differ, which is next to nothing. The paper's abstract names \
             another reason, of which the formulas know nothing: multiporting. A node of Blue Gene/P has six links; radix-k has \
             several partners at once to use them, binary swap one. The formulas have one port a node: for the printed gain that of \
             radix-k would have to be 1.4 to 1.7 times as fast. Where the number of processes is no power of two the formulas do have a \
             gain, because binary swap folds the processes beyond one first."
                .into(),
        ],
        verdict: comparison.verdict(),
    })
}
