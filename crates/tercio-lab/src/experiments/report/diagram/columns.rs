//! The columns of a diagram: what a description says of a machine's stages, or what its class says of its processors.

use super::{INK, ROWS, SORT, network};
use crate::machines::{Arrangement, DataKind, Machine, Network, SortingClass, Topology};

/// How what travels comes from the column before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// From each box to those that belong to it.
    Own,
    /// From each to all.
    All,
    /// Over a network; inside groups of neighbours only, if so.
    Over { topology: Topology, in_groups: bool },
}

/// Equal boxes below each other, and what comes to them.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub title: String,
    /// A second line: how many there are, or how they are arranged.
    pub note: String,
    pub count: u64,
    /// Boxes that stand for several of `count` each, if there are fewer of them.
    boxes: u64,
    /// Those that are drawn, three at most: the last one stands for all between.
    pub labels: Vec<String>,
    pub arrangement: Arrangement,
    pub link: Link,
    pub sorted: bool,
    pub receives: Option<String>,
    /// What the network is.
    pub way: Option<String>,
}

impl Column {
    fn new(title: &str, note: &str, count: u64, label: impl Fn(u64) -> String) -> Self {
        let labels = numbers(count).into_iter().map(label).collect();
        let (title, note) = (title.to_owned(), note.to_owned());
        Self {
            title,
            note,
            count,
            boxes: count,
            labels,
            arrangement: Arrangement::Parallel,
            link: Link::Own,
            sorted: false,
            receives: None,
            way: None,
        }
    }

    /// Boxes, if all were drawn.
    pub fn units(&self) -> u64 {
        self.boxes
    }

    pub fn rows(&self) -> &'static [f64] {
        ROWS[self.labels.len().clamp(1, 3) - 1]
    }

    pub fn color(&self) -> [u8; 4] {
        if self.sorted { SORT } else { INK }
    }

    /// Heights at which lines leave it.
    pub fn outputs(&self) -> Vec<f64> {
        match self.arrangement {
            Arrangement::Tree => network::leaves(self.count),
            _ => self.rows().to_vec(),
        }
    }

    /// Heights at which lines reach it.
    pub fn inputs(&self) -> Vec<f64> {
        match self.arrangement {
            Arrangement::Tree => vec![ROWS[0][0]],
            _ => self.rows().to_vec(),
        }
    }

    /// What leaves it: the number of boxes, and which of them are at `outputs`.
    fn leaving(&self) -> (u64, Vec<u64>) {
        match self.arrangement {
            Arrangement::Tree => {
                let (leaves, drawn) = (self.count.div_ceil(2), network::leaves(self.count).len() as u64);
                // The last one that is drawn stands for those between.
                (leaves, (1..drawn).chain([leaves]).collect())
            }
            _ => (self.boxes, numbers(self.boxes)),
        }
    }

    fn reached(&self) -> (u64, Vec<u64>) {
        if self.arrangement == Arrangement::Tree { (1, vec![1]) } else { (self.boxes, numbers(self.boxes)) }
    }
}

/// The numbers of the boxes that are drawn.
fn numbers(count: u64) -> Vec<u64> {
    match count {
        0..=3 => (1..=count.max(1)).collect(),
        _ => vec![1, 2, count],
    }
}

/// Heights of the two ends of the lines between two columns.
pub(super) fn joined(from: &Column, to: &Column) -> Vec<[f64; 2]> {
    let (outputs, inputs) = (from.outputs(), to.inputs());
    let ((many, leaving), (more, reached)) = (from.leaving(), to.reached());
    // Only the ends of a pipeline have lines to a single box beside it.
    let last_only = from.arrangement == Arrangement::Pipeline && more == 1;
    let first_only = to.arrangement == Arrangement::Pipeline && many == 1;
    let belongs = |a: u64, b: u64| match to.link {
        _ if last_only => a == many,
        _ if first_only => b == 1,
        Link::Own if more >= many && more % many == 0 => b.div_ceil(more / many) == a,
        Link::Own if many % more == 0 => a.div_ceil(many / more) == b,
        _ => true,
    };
    let pairs = leaving.iter().zip(outputs).flat_map(|(&a, from)| {
        let inputs = reached.iter().zip(&inputs);
        inputs.filter(move |&(&b, _)| belongs(a, b)).map(move |(_, &to)| [from, to]).collect::<Vec<_>>()
    });
    pairs.collect()
}

/// The columns of a machine, from the scene to the picture.
pub(super) fn columns(machine: &Machine) -> Vec<Column> {
    if machine.stages.is_empty() { of_class(machine) } else { of_stages(machine) }
}

fn of_stages(machine: &Machine) -> Vec<Column> {
    let mut columns = vec![Column::new("scene", "", 1, |_| "model".into())];
    for stage in &machine.stages {
        let count = stage.count.whole();
        let title = format!("{count} {}", if count == 1 { stage.name.clone() } else { plural(&stage.name) });
        let mut column = Column::new(&title, "", count, |k| k.to_string());
        if count == 1 {
            column.labels = vec![stage.name.clone()];
        }
        column.arrangement = stage.arrangement;
        column.sorted = stage.sorted;
        column.receives.clone_from(&stage.receives);
        // A pipeline or a tree sorts what passes through it.
        let sorts_inside = stage.arrangement != Arrangement::Parallel;
        column.link = match stage.over {
            Some(topology) => Link::Over { topology, in_groups: false },
            None if stage.sorted && !sorts_inside => Link::All,
            None => Link::Own,
        };
        column.way = stage.over.map(|topology| way(topology, machine.network.as_ref()));
        match stage.arrangement {
            Arrangement::Pipeline => column.note = "in a pipeline".into(),
            Arrangement::Tree => column.note = "in a binary tree".into(),
            Arrangement::Parallel => gather(&mut column, &columns),
        }
        columns.push(column);
    }
    columns.push(Column::new("picture", "", 1, |_| "pixels".into()));
    columns
}

/// One box for all units of a stage that a unit of the stage before serves.
fn gather(column: &mut Column, before: &[Column]) {
    let Some(parents) = before.last() else { return };
    let [many, more] = [parents.boxes, column.count];
    let are_groups = column.link == Link::Own && parents.arrangement != Arrangement::Tree && many > 1;
    if !are_groups || parents.count != many || more <= many || more % many != 0 {
        return;
    }
    let each = more / many;
    column.boxes = many;
    column.note = format!("{each} for each");
    let label = |k: u64| match each {
        2 => format!("{}, {}", k * each - 1, k * each),
        _ => format!("{} to {}", (k - 1) * each + 1, k * each),
    };
    column.labels = numbers(many).into_iter().map(label).collect();
}

fn of_class(machine: &Machine) -> Vec<Column> {
    let p = &machine.processors;
    let count = p.count.whole();
    let per_node = p.per_node.as_ref().map_or(1, |n| n.whole().max(1));
    let (boxes, unit) =
        if p.per_node.is_some() { (count.div_ceil(per_node), "node") } else { (count, "processor") };
    let named = if boxes == 1 { unit.to_owned() } else { plural(unit) };
    let note = if per_node > 1 {
        format!("{boxes} {named} of {per_node} processors")
    } else {
        format!("{boxes} {named}")
    };
    let processors = |title: &str| Column::new(title, &note, boxes, |k| format!("{unit} {k}"));
    let mut columns = vec![
        Column::new("scene", "", boxes, |k| format!("share {k}")),
        processors("geometry"),
        processors("rasterization"),
        Column::new("picture", "", boxes, |k| format!("part {k}")),
    ];
    for &(column, kind, in_groups) in sorts(machine.sorting.class) {
        let to = &mut columns[column];
        to.sorted = true;
        to.receives = Some(travelling(machine, kind));
        let topology = machine.network.as_ref().map(|n| n.topology);
        to.link = match (topology, in_groups) {
            (None, false) => Link::All,
            (None, true) => Link::Over { topology: Topology::Crossbar, in_groups },
            (Some(topology), _) => Link::Over { topology, in_groups },
        };
        let words = topology.map(|topology| way(topology, machine.network.as_ref()));
        to.way = words.map(|words| if in_groups { format!("in groups; {words}") } else { words });
    }
    columns
}

/// The columns before which a class sorts, what, and whether inside groups only.
fn sorts(class: SortingClass) -> &'static [(usize, DataKind, bool)] {
    match class {
        SortingClass::None => &[],
        SortingClass::SortFirst => &[(1, DataKind::Primitive, false)],
        SortingClass::SortMiddle => &[(2, DataKind::Descriptor, false)],
        SortingClass::SortLast => &[(3, DataKind::Sample, false)],
        SortingClass::SortTwice => &[(2, DataKind::Descriptor, true), (3, DataKind::Sample, false)],
        // What document 001, 2.3.4, calls hybrid: sort-middle and sort-last in one. Those with tile engines are drawn as such.
        SortingClass::Hybrid => &[(2, DataKind::Descriptor, false), (3, DataKind::Sample, false)],
    }
}

/// What travels, with its size if the description gives it.
fn travelling(machine: &Machine, kind: DataKind) -> String {
    let what = match kind {
        DataKind::Primitive => "polygons",
        DataKind::Descriptor => "descriptors",
        DataKind::Sample | DataKind::Pixel => "pixels",
    };
    machine.bytes.get(&kind).map_or(what.into(), |size| format!("{what}, {size} each"))
}

/// A network in words, with the bandwidth of a link if it is that of the section `network`.
fn way(topology: Topology, network: Option<&Network>) -> String {
    match network.filter(|n| n.topology == topology) {
        Some(network) => format!("{}, {} a link", topology.name(), network.bandwidth),
        None => topology.name().into(),
    }
}

fn plural(name: &str) -> String {
    if name.ends_with('s') { format!("{name}es") } else { format!("{name}s") }
}
