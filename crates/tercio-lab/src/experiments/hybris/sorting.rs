//! The sorting classes of section 2.3 on networks, from one processor to a million.

use tercio_mesh::builtin;

use crate::experiments::{
    Axis, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::machines::{Topology, load};
use crate::predict::views;
use crate::simulators::sorting::{Organisation, Setting, sweep};
use crate::workloads::projection::Model;

pub(crate) const EXPERIMENTS: &[Experiment] = &[Experiment {
    id: "hybris-sec-2-3-classes",
    document: Document::Hybris,
    place: "section 2.3",
    title: "Where to sort: time of a frame by the number of processors, on four networks",
    run: classes,
}];

const MODEL: &str = "builtin:teapot@300k";
const SIZE: (u32, u32) = (1024, 1024);
const NETWORKS: [Topology; 4] = [Topology::Ring, Topology::Mesh, Topology::FatTree, Topology::Crossbar];
const CLASSES: [(&str, Organisation); 4] = [
    ("sort-first", Organisation::SortFirst),
    ("sort-middle", Organisation::SortMiddle),
    ("sort-last", Organisation::SortLast),
    ("sort-twice, groups of 64", Organisation::SortTwice(64)),
];

fn classes() -> Result<Findings, ExperimentError> {
    let machine = load("cluster-64")?;
    let mesh = builtin::make(MODEL)?;
    let camera = views::camera(&mesh.bounds(), SIZE, 0, 1);
    let boxes = Model::new(mesh).boxes(&camera, SIZE)?;
    let mut table = Table::new(
        "classes",
        &[
            ("network", ""),
            ("class", ""),
            ("processors", ""),
            ("geometry", "ms"),
            ("redistribution", "ms"),
            ("rasterization", "ms"),
            ("composition", "ms"),
            ("delivery", "ms"),
            ("frame", "ms"),
            ("overlap", ""),
            ("bytes", "B"),
        ],
    );
    let mut plots = Vec::new();
    let mut comparison = Comparison::new();
    let (mut plans, mut once) = (Vec::new(), true);
    for topology in NETWORKS {
        for (_, organisation) in CLASSES {
            for power in (0..=20).step_by(4) {
                let setting = Setting::of(&machine, 1 << power, SIZE, Some(topology), &[organisation])?;
                plans.push((organisation, setting));
            }
        }
    }
    let reports = sweep(&boxes, &plans, || ())?;
    for (topology, of_network) in NETWORKS.into_iter().zip(reports.chunks(reports.len() / NETWORKS.len())) {
        // All classes deliver to processor 0, message by message: with many processors that hides everything else.
        let mut delivery = Vec::new();
        let mut plot = Plot::new(
            topology.name(),
            format!("Time of a frame before delivery: {}", topology.name()),
            Axis::log2("processors"),
            Axis::log10("milliseconds"),
        );
        for ((name, organisation), of_class) in
            CLASSES.into_iter().zip(of_network.chunks(of_network.len() / CLASSES.len()))
        {
            let mut points = Vec::new();
            for r in of_class {
                let processors = r.processors as f64;
                table.push([
                    topology.name().into(),
                    name.into(),
                    processors.into(),
                    (r.geometry.seconds * 1e3).into(),
                    (r.redistribution_seconds * 1e3).into(),
                    (r.raster.seconds * 1e3).into(),
                    (r.composition_seconds * 1e3).into(),
                    (r.delivery_seconds * 1e3).into(),
                    (r.seconds() * 1e3).into(),
                    r.overlap.into(),
                    ((r.redistribution.bytes + r.composition.bytes + r.delivery.bytes) as f64).into(),
                ]);
                points.push((processors, (r.seconds() - r.delivery_seconds) * 1e3));
                if organisation == Organisation::SortLast {
                    once &= r.overlap == 1.0;
                    delivery.push((processors, r.delivery_seconds * 1e3));
                }
            }
            plot = plot.with(Series::line_points(name, points));
        }
        plots.push(plot.with(Series::line_points("delivery of sort-last's picture", delivery)));
    }
    comparison
        .claim("sort-last: every triangle in one place, on every network and number of processors", once);
    Ok(Findings {
        tables: vec![table],
        plots,
        remarks: vec![
            format!(
                "{MODEL} at 1024x1024, costs and network of the machine cluster-64 in other shapes. Sort-middle \
                 divides the screen ever finer and meets ever more overlap and messages; sort-last sends pictures, \
                 whose cost does not depend on the triangles."
            ),
            "Times are lower bounds: congestion of the busiest link, hops of the longest way, messages of the busiest \
             processor."
                .into(),
        ],
        verdict: comparison.qualitative("The section argues in words and prints no numbers."),
    })
}
