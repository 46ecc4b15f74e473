//! The messages between ranks, computed from the pixels that each of them shows.
//!
//! * Sort-last assigns consecutive clusters, to rank r of n those from `C * r / n` on; sort-first gives every rank all.
//! * Region k of the picture, row by row, belongs to rank k modulo the number of ranks.
//! * A span, a row of neighbouring pixels of one region that show something, is sent as 6 bytes, 4 for every pixel's
//!   colour, and 8 for its key where it still has to be composited.
//! * Ranks without clusters send nothing for compositing, ranks without regions receive nothing and have nothing to
//!   collect.

use serde::Serialize;
use tercio_parallel::{Organisation, RankReport};

use crate::simulators::sorting::{Assignment, Regions};
use crate::workloads::PixelBox;

/// Bytes of a span's header, of a pixel's key and of its colour.
const SPAN_BYTES: u64 = 6;
const KEY_BYTES: u64 = 8;
const COLOR_BYTES: u64 = 4;

/// How ranks share a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sharing {
    /// Where work is redistributed.
    pub organisation: Organisation,
    /// Ranks, at least 1.
    pub ranks: usize,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Pixels along the edge of a region, which is a tile of the renderer.
    pub edge: u32,
}

impl Sharing {
    /// The regions.
    pub fn regions(&self) -> Regions {
        let ((width, height), edge) = (self.size, self.edge);
        Regions { width, height, edge, owners: self.ranks, assignment: Assignment::Interleaved }
    }

    /// Ranks that own a region: the first ones.
    pub fn owners(&self) -> usize {
        usize::try_from(self.regions().count()).map_or(self.ranks, |count| count.min(self.ranks))
    }

    /// Pixels of the picture.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }

    /// Pixels that each rank owns.
    pub fn owned(&self) -> Vec<u64> {
        let regions = self.regions();
        let mut owned = vec![0; self.ranks];
        for (region, pixels) in regions.touched(PixelBox::screen(self.size.0, self.size.1)) {
            owned[regions.owner(region)] += pixels;
        }
        owned
    }
}

/// Pixels that show something, and the spans in which they are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Pixels {
    /// Rows of neighbours.
    pub spans: u64,
    /// Pixels.
    pub pixels: u64,
}

impl Pixels {
    /// Bytes with or without keys.
    pub fn bytes(&self, keys: bool) -> u64 {
        self.spans * SPAN_BYTES + self.pixels * (COLOR_BYTES + if keys { KEY_BYTES } else { 0 })
    }
}

/// The counters of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RankCounts {
    /// Triangles that it processes.
    pub triangles: u64,
    /// Pixels that it sends for compositing.
    pub sent: u64,
    /// Pixels that it composites.
    pub compared: u64,
    /// Pixels of its regions that show something in the end.
    pub visible: u64,
    /// Messages that it sends.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl RankCounts {
    /// The counters that a rank reported.
    pub fn measured(report: &RankReport) -> Self {
        Self {
            triangles: report.frame.frontend.triangles_in,
            sent: report.pixels.sent,
            compared: report.pixels.compared,
            visible: report.pixels.visible,
            messages: report.traffic.sent_messages,
            bytes: report.traffic.sent_bytes,
        }
    }

    /// By name.
    pub fn by_name(&self) -> [(&'static str, u64); 6] {
        [
            ("triangles", self.triangles),
            ("pixels sent", self.sent),
            ("pixels compared", self.compared),
            ("pixels visible", self.visible),
            ("messages", self.messages),
            ("bytes", self.bytes),
        ]
    }
}

/// The messages of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Messages {
    /// Triangles that each rank processes.
    pub triangles: Vec<u64>,
    /// What each rank sends to each other for compositing; `None` where there is no message.
    pub composed: Vec<Vec<Option<Pixels>>>,
    /// The finished pixels of each owner of regions; all but rank 0 send them to rank 0 in a message.
    pub finished: Vec<Pixels>,
}

impl Messages {
    /// What a rank sends to another for compositing.
    pub fn between(&self, from: usize, to: usize) -> Option<Pixels> {
        self.composed[from].get(to).copied().flatten()
    }

    /// The counters of a rank.
    pub fn counts(&self, rank: usize) -> RankCounts {
        let mut counts = RankCounts { triangles: self.triangles[rank], ..RankCounts::default() };
        for sent in self.composed[rank].iter().flatten() {
            counts.sent += sent.pixels;
            counts.messages += 1;
            counts.bytes += sent.bytes(true);
        }
        let taken = (0..self.composed.len()).filter_map(|from| self.between(from, rank));
        counts.compared = taken.map(|p| p.pixels).sum();
        if let Some(own) = self.finished.get(rank) {
            counts.visible = own.pixels;
            if rank > 0 {
                counts.messages += 1;
                counts.bytes += own.bytes(false);
            }
        }
        counts
    }

    /// Bytes of the messages that a rank receives.
    pub fn bytes_taken(&self, rank: usize) -> u64 {
        let composed = (0..self.composed.len()).filter_map(|from| self.between(from, rank));
        let finished = self.finished.iter().skip(1).filter(|_| rank == 0);
        composed.map(|p| p.bytes(true)).chain(finished.map(|p| p.bytes(false))).sum()
    }

    /// Messages and bytes of all ranks.
    pub fn total(&self) -> (u64, u64) {
        let counts = (0..self.triangles.len()).map(|rank| self.counts(rank));
        counts.fold((0, 0), |sum, c| (sum.0 + c.messages, sum.1 + c.bytes))
    }
}

/// Collects the messages of a frame, one rank after another.
pub struct Traffic<'a> {
    sharing: &'a Sharing,
    messages: Messages,
    /// Pixels that any rank shows.
    by_any: Vec<bool>,
}

impl<'a> Traffic<'a> {
    /// No rank shows anything yet.
    pub fn new(sharing: &'a Sharing) -> Self {
        let ranks = sharing.ranks;
        let messages =
            Messages { triangles: vec![0; ranks], composed: vec![Vec::new(); ranks], finished: Vec::new() };
        Self { sharing, messages, by_any: vec![false; sharing.pixels() as usize] }
    }

    /// Adds a rank that processes `triangles` triangles and shows the pixels whose keys are not 0.
    pub fn add(&mut self, rank: usize, triangles: u64, keys: &[u64]) {
        self.messages.triangles[rank] = triangles;
        self.by_any.iter_mut().zip(keys).for_each(|(any, key)| *any |= *key != 0);
        // A rank without clusters sends nothing.
        if self.sharing.organisation == Organisation::SortLast && triangles > 0 {
            let owners = self.sharing.owners();
            let to = by_owner(self.sharing, |place| keys[place] != 0).into_iter().enumerate();
            self.messages.composed[rank] =
                to.map(|(to, pixels)| (to != rank && to < owners).then_some(pixels)).collect();
        }
    }

    /// The messages after all ranks have been added.
    pub fn finish(self) -> Messages {
        let mut finished = by_owner(self.sharing, |place| self.by_any[place]);
        finished.truncate(self.sharing.owners());
        Messages { finished, ..self.messages }
    }
}

/// The pixels that show something, divided among the owners of regions.
fn by_owner(sharing: &Sharing, shows: impl Fn(usize) -> bool) -> Vec<Pixels> {
    let (regions, (width, height)) = (sharing.regions(), sharing.size);
    let columns = u64::from(width.div_ceil(sharing.edge));
    let mut found = vec![Pixels::default(); sharing.ranks];
    for y in 0..height {
        for (column, first) in (0..).zip((0..width).step_by(sharing.edge as usize)) {
            let own = &mut found[regions.owner(u64::from(y / sharing.edge) * columns + column)];
            let mut before = false;
            for x in first..width.min(first + sharing.edge) {
                let shown = shows(y as usize * width as usize + x as usize);
                own.spans += u64::from(shown && !before);
                own.pixels += u64::from(shown);
                before = shown;
            }
        }
    }
    found
}
