//! `tercio lab simulate sorting`: the four sorting classes on any described machine.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tercio_lab::machines::{Machine, Operation, Packing, load};
use tercio_lab::simulators::sorting::{Assignment, Organisation, Setting, SortReport, sweep, usual_group};
use tercio_lab::words::counted;
use tercio_lab::workloads::{MAX_SCREEN_PIXELS, PolygonScene};

use super::super::plan::NetworkName;
use super::super::predict::ranks;
use super::{boxes, is_polygons};
use crate::args::{RunningArgs, values};
use crate::progress::Display;

/// Sort-first, -middle, -last and -twice on a described machine and network, message by message.
#[derive(Debug, Args)]
#[command(after_help = "\
What each processor computes and what each link carries is counted exactly; times are those of the busiest
processor and the busiest link; a machine whose processors are 'simd' runs by the rules of
'tercio lab simulate ring'. The finished picture is delivered to processor 0, or to a display. Costs, bytes and network
are the machine's: to change them, write its description to a file ('tercio lab machines NAME'), edit it and name the
file. Lists are combined with one another, on all cores.

Examples:
  tercio lab simulate sorting teapot.boxes --size 768x512
  tercio lab simulate sorting dragon.polygons --machine cluster-64 --processors 64,256,1024 --network mesh
  tercio lab simulate sorting made.boxes -O sort-twice --group 4,16,64 --region 32 --assignment blocks --json

Exit code: 0 success, 1 error (in a file, with its line), 2 wrong usage.")]
pub struct Sorting {
    /// The workload: boxes, or polygons, of which the bounding boxes are used.
    #[arg(value_name = "SCENE")]
    pub(super) scene: PathBuf,
    /// Size of the screen in pixels [default: that of the polygons, or of the machine; 768x512 for boxes].
    #[arg(short, long, value_name = "WxH", value_parser = values::size)]
    size: Option<(u32, u32)>,
    /// Where polygons and pixels are redistributed.
    #[arg(short = 'O', long, value_name = "CLASS,...", value_enum, value_delimiter = ',')]
    #[arg(default_values_t = [Class::SortFirst, Class::SortMiddle, Class::SortLast, Class::SortTwice])]
    organisation: Vec<Class>,
    /// Numbers of processors [default: the machine's].
    #[arg(short = 'n', long, value_name = "N,...", value_delimiter = ',', value_parser = ranks)]
    processors: Vec<usize>,
    /// Processors of a group of sort-twice [default: 16, or all of fewer; of a machine whose processors are 'simd' the
    /// most up to 16 that divide them].
    #[arg(short, long, value_name = "G,...", value_delimiter = ',', value_parser = ranks)]
    group: Vec<usize>,
    /// Pixels along the edge of a region [default: the largest that gives every owner a region].
    #[arg(long, value_name = "PIXELS,...", value_delimiter = ',')]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=32768))]
    region: Vec<u32>,
    /// How regions are assigned to owners.
    #[arg(long, value_name = "HOW,...", value_enum, value_delimiter = ',', default_value = "interleaved")]
    assignment: Vec<AssignmentName>,
    /// A machine with a network and the sizes of messages ('tercio lab machines'), or a file.
    #[arg(short, long, value_name = "MACHINE", default_value = "princeton-engine")]
    pub(super) machine: String,
    /// Another network than the machine's, with the machine's bandwidth and latency.
    #[arg(long, value_name = "SHAPE", value_enum)]
    network: Option<NetworkName>,
    /// A message for every polygon and destination, instead of one for all polygons of a destination [default: as the
    /// machine's description says].
    #[arg(long)]
    unbatched: bool,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    running: RunningArgs,
}

/// The sorting classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[expect(clippy::enum_variant_names, reason = "the names of the field, as the command line takes them")]
enum Class {
    /// Polygons are sent before the geometry work.
    SortFirst,
    /// Set-up polygons are sent.
    SortMiddle,
    /// Pictures are composited.
    SortLast,
    /// Polygons inside groups, pictures between them.
    SortTwice,
}

/// How regions are assigned to owners.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum AssignmentName {
    /// Neighbouring regions to different owners.
    Interleaved,
    /// Runs of neighbouring regions to one owner.
    Blocks,
}

impl Sorting {
    pub fn run(&self) -> Result<String> {
        let machine = load(&self.machine)?;
        let (scene, own) = if is_polygons(&self.scene) {
            let scene = PolygonScene::read(&self.scene)?;
            (scene.boxes(), Some((scene.width, scene.height)))
        } else {
            (boxes(&self.scene)?, screen(&machine))
        };
        let size = self.size.or(own).unwrap_or((768, 512));
        if u64::from(size.0) * u64::from(size.1) > MAX_SCREEN_PIXELS {
            bail!("expected a screen of at most {MAX_SCREEN_PIXELS} pixels, found {}x{}", size.0, size.1);
        }
        let plans = self.plans(&machine, size)?;
        let pool = self.running.pool()?;
        let display = Display::new(self.running.progress_mode());
        display.progress.begin("settings", plans.len() as u64);
        let reports = pool.install(|| sweep(&scene, &plans, || display.progress.advance(1)))?;
        drop(display);
        let runs: Vec<_> = plans.into_iter().zip(reports).collect();
        Ok(if self.json { self.as_json(&machine, &runs) } else { table(&machine, size, &runs) })
    }

    /// All combinations of the requested values, without those that make no difference.
    fn plans(&self, machine: &Machine, size: (u32, u32)) -> Result<Vec<(Organisation, Setting)>> {
        let own = [machine.processors.count.whole() as usize];
        let counts = if self.processors.is_empty() { &own[..] } else { &self.processors };
        let edges: Vec<_> =
            if self.region.is_empty() { vec![None] } else { self.region.iter().copied().map(Some).collect() };
        let mut plans = Vec::new();
        for &processors in counts {
            let network = self.network.map(Into::into);
            let organisations = self.organisations(machine, processors);
            let mut of_machine = Setting::of(machine, processors, size, network, &organisations)?;
            if self.unbatched {
                of_machine.network.packing = Packing::OneAPolygon;
            }
            for organisation in organisations {
                for (&region, assignment) in
                    edges.iter().flat_map(|e| self.assignment.iter().map(move |a| (e, a)))
                {
                    let assignment = match assignment {
                        AssignmentName::Interleaved => Assignment::Interleaved,
                        AssignmentName::Blocks => Assignment::Blocks,
                    };
                    let setting = Setting { region, assignment, ..of_machine };
                    plans.push((organisation, setting));
                    // An owner of the whole screen needs no regions.
                    if organisation == Organisation::SortLast {
                        break;
                    }
                }
            }
        }
        Ok(plans)
    }

    fn organisations(&self, machine: &Machine, processors: usize) -> Vec<Organisation> {
        let usual = [usual_group(machine, processors)];
        let groups = if self.group.is_empty() { &usual[..] } else { &self.group };
        let of = |class: &Class| match class {
            Class::SortFirst => vec![Organisation::SortFirst],
            Class::SortMiddle => vec![Organisation::SortMiddle],
            Class::SortLast => vec![Organisation::SortLast],
            Class::SortTwice => groups.iter().copied().map(Organisation::SortTwice).collect(),
        };
        self.organisation.iter().flat_map(of).collect()
    }

    fn as_json(&self, machine: &Machine, runs: &[((Organisation, Setting), SortReport)]) -> String {
        let row = |((organisation, setting), report): &((Organisation, Setting), SortReport)| {
            let same = organisation.without_groups(setting.processors).map(name);
            json!({ "setting": setting, "report": report, "total_seconds": report.seconds(), "same_as": same })
        };
        let value = json!({
            "machine": machine.name, "uncharged": uncharged(runs), "runs": runs.iter().map(row).collect::<Value>(),
        });
        format!("{value:#}\n")
    }
}

/// Work that has no cost in the machine's description and is therefore missing in the times.
fn uncharged(runs: &[((Organisation, Setting), SortReport)]) -> Vec<&'static str> {
    let mut work: Vec<_> =
        runs.iter().flat_map(|((organisation, s), _)| s.costs.uncharged(*organisation)).collect();
    work.sort_unstable();
    work.dedup();
    work.into_iter().map(Operation::name).collect()
}

/// An organisation, with the size of its groups.
fn name(organisation: Organisation) -> String {
    match organisation {
        Organisation::SortTwice(group) => format!("{} {group}", organisation.class().name()),
        _ => organisation.class().name().into(),
    }
}

/// Lines on runs of sort-twice that are another organisation, because groups are single processors or all of them.
fn without_groups(runs: &[((Organisation, Setting), SortReport)]) -> String {
    let line = |((organisation, setting), _): &((Organisation, Setting), SortReport)| {
        let processors = setting.processors;
        let same = organisation.without_groups(processors)?;
        let groups = match same {
            Organisation::SortLast => "each group is one processor",
            _ => "one group has all processors",
        };
        let (twice, same) = (name(*organisation), name(same));
        let on = counted(processors as u64, "processor", "processors");
        Some(format!("{twice} on {on} is {same}: {groups} (--group)\n"))
    };
    let mut lines: Vec<_> = runs.iter().filter_map(line).collect();
    lines.dedup();
    lines.concat()
}

/// The screen of a description.
fn screen(machine: &Machine) -> Option<(u32, u32)> {
    let side = |count: u64| u32::try_from(count).ok().filter(|n| *n > 0);
    machine.screen.as_ref().and_then(|s| Some((side(s.width.whole())?, side(s.height.whole())?)))
}

fn table(machine: &Machine, size: (u32, u32), runs: &[((Organisation, Setting), SortReport)]) -> String {
    let mut text = format!("{}, screen of {}x{} pixels; milliseconds\n", machine.name, size.0, size.1);
    let head = ["geometry", "to owners", "raster", "composing", "delivery", "frame"]
        .map(|name| format!(" {name:>11}"));
    let _ = writeln!(
        text,
        "{:14} {:>10} {:>6} {:11}{} {:>8} {:>9} {:>14} {:>13}",
        "organisation",
        "processors",
        "region",
        "assignment",
        head.concat(),
        "overlap",
        "imbalance",
        "bytes sent",
        "busiest link"
    );
    for ((organisation, setting), report) in runs {
        let name = name(*organisation);
        let region = setting.region.map_or("auto".into(), |edge| edge.to_string());
        let assignment = match setting.assignment {
            Assignment::Interleaved => "interleaved",
            Assignment::Blocks => "blocks",
        };
        let seconds = [
            report.geometry.seconds,
            report.redistribution_seconds,
            report.raster.seconds,
            report.composition_seconds,
            report.delivery_seconds,
            report.seconds(),
        ];
        let times = seconds.map(|s| format!(" {:11.4}", s * 1e3)).concat();
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "{name:14} {:10} {region:>6} {assignment:11}{times} {:8.3} {:9.2} {:14} {:13.0}",
            report.processors,
            report.overlap,
            report.raster.imbalance(),
            report.redistribution.bytes + report.composition.bytes + report.delivery.bytes,
            [report.redistribution, report.composition, report.delivery]
                .map(|traffic| traffic.busiest_link.max(traffic.inside.busiest_link))
                .iter()
                .sum::<f64>(),
        );
    }
    text += &without_groups(runs);
    let missing = uncharged(runs);
    if !missing.is_empty() {
        let _ = writeln!(text, "the description charges nothing for {}", missing.join(", "));
    }
    text
}
