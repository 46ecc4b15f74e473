//! Many megapixels on Intrepid, with reduction of pixels: W. Kendall and others, EGPGV 2010; K. Moreland and others, SC11.

use tercio_parallel::Composition;

use super::{BYTES, Job, MEGAPIXEL, Shared, machine};
use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Fit, Plot, Series, Table,
};

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "others-64-megapixels",
    document: Document::Others,
    place: "EGPGV 2010, SC11",
    title: "64 Mpixel on 32 K processes of Blue Gene/P, and IceT on 64 K",
    run: megapixels,
}];

const PIXELS: f64 = 64.0 * MEGAPIXEL;
/// Of Kendall and others; of Moreland and others, without a time that we found.
const RANKS: [usize; 2] = [1 << 15, 1 << 16];
const BLENDS: [f64; 2] = [0.0, 100.0];
/// Published: seconds, and how many times as fast as binary swap at most.
const SECONDS: &str = "0.08";
const GAIN: &str = "5";
/// Links of a node of the torus.
const LINKS: f64 = 6.0;

fn megapixels() -> Result<Findings, ExperimentError> {
    let intrepid = machine("intrepid")?;
    let jobs = RANKS.iter().map(|&ranks| Job::new(&intrepid, ranks, 1)).collect::<Result<Vec<_>, _>>()?;
    let mut table = Table::new(
        "times",
        &[
            ("processes", ""),
            ("pixel", "B"),
            ("blending", "ns"),
            ("share of the picture that a process has", "%"),
            ("radix-k", "s"),
            ("binary swap", "s"),
            ("binary swap of full pictures", "s"),
        ],
    );
    // From the least of which a picture can consist, to full pictures.
    let shares: Vec<f64> = (0..=30).map(|k| 2f64.powf(-15.0 + 0.5 * f64::from(k))).collect();
    let (mut times, mut gains) = (Vec::new(), Vec::new());
    let mut plot = Plot::new(
        "times",
        "64 Mpixel on 32 K processes of Intrepid",
        Axis::log10("percent of the picture that a process has"),
        Axis::log10("seconds of radix-k"),
    );
    for (job, bytes, blend) in jobs
        .iter()
        .flat_map(|job| BYTES.iter().flat_map(move |&bytes| BLENDS.map(move |blend| (job, bytes, blend))))
    {
        let of = |share| Shared { pixels: PIXELS, share, bytes, blend: blend * 1e-9 };
        let full = job.composite(&of(1.0), Composition::BinarySwap);
        let (mut line, mut of_pairs, mut of_full) = (Vec::new(), Vec::new(), Vec::new());
        for &share in shares.iter().filter(|&&share| share * job.ranks as f64 >= 1.0) {
            let (radix, swap) =
                (job.radix_k(&of(share)).1, job.composite(&of(share), Composition::BinarySwap));
            let percent = 100.0 * share;
            table.push([
                (job.ranks as f64).into(),
                bytes.into(),
                blend.into(),
                percent.into(),
                radix.into(),
                swap.into(),
                full.into(),
            ]);
            line.push((percent, radix));
            of_pairs.push((percent, swap / radix));
            of_full.push((percent, full / radix));
        }
        let what = format!("{bytes} B and {blend} ns a pixel");
        if job.ranks == RANKS[0] {
            let input = "percent of the picture that a process has";
            // "Up to" is said of all pictures, not of that of 0.08 s.
            let of_gain = "percent of the picture that a process has where the gain is greatest";
            times.push(Fit::new(format!("{SECONDS} s, {what}"), input, SECONDS, line.clone()));
            let of_the_same = format!("{GAIN} times as fast as binary swap of the same pixels, {what}");
            gains.push(Fit::new(of_the_same, of_gain, GAIN, of_pairs));
            let of_all = format!("{GAIN} times as fast as binary swap of full pictures, {what}");
            gains.push(Fit::new(of_all, of_gain, GAIN, of_full));
            // The curves of 64 K processes lie on these.
            plot = plot.with(Series::line(what, line));
        }
    }
    let ends = [shares[0], 1.0].map(|share| (100.0 * share, 0.08));
    plot = plot.with(Series::line("published: 0.08 s", ends.to_vec()).published());
    let mut comparison = Comparison::new();
    comparison.fit_one_of(times);
    comparison.fit_one_of(gains);
    let bandwidth = intrepid.need(intrepid.network.as_ref(), "network")?.bandwidth.value;
    let one_link = jobs[0].deliver(PIXELS, BYTES[0]);
    let all_links = PIXELS * BYTES[0] / (LINKS * bandwidth);
    comparison.claim(
        format!(
            "0.08 s leave no time to deliver the picture to one node: that takes {one_link:.2} s over one link, and {all_links:.3} s \
             over all six"
        ),
        all_links > 0.08 && one_link > all_links,
    );
    Ok(Findings {
        tables: vec![table, comparison.intervals()],
        plots: vec![plot],
        remarks: vec![
            "Published are 0.08 s for 64 Mpixel on 32 K processes, and up to 5 times the speed of binary swap (W. Kendall and others, \
             EGPGV 2010, abstract), with bounding boxes and run-length encoding. How much of the picture a process then has is not \
             given there: it is swept. Pixels of several processes are taken to be as scattered as may be. \
             A cube that is divided into 32x32x32 bricks and seen from the front gives each process 1/1024 of its picture, 0.098 %, \
             beside the 0.10 to 0.57 % that give print."
                .into(),
            "Of IceT on 64 K processes (K. Moreland and others, SC11) we found no time: ours stand alone.".into(),
        ],
        verdict: comparison.verdict(),
    })
}
