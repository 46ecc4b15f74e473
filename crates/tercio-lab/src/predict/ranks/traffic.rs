//! The messages between ranks, computed from the pixels that each of them shows.
//!
//! * Sort-last divides the clusters ([`tercio_raster::Renderer::divide_clusters`]); sort-first gives every rank all, and the tiles of
//!   a [division](tercio_parallel::division) of the picture.
//! * In sort-last all ranks first learn which tiles each of them may have drawn something in: one bit a tile, in words of 8 bytes.
//! * A span, a row of neighbouring pixels of one tile that show something, is sent as 6 bytes, 4 for every pixel's
//!   colour, and 8 for its key where it still has to be composited. What is composited is preceded by 12 bytes a tile.
//! * Every message ends with a trailer of 16 bytes that says what it is.
//! * Tiles of one rank are not composited. The others are sent to one of their ranks
//!   ([`tercio_parallel::Composition::DirectSend`]).

use serde::Serialize;
use tercio_parallel::composite::exchange::TILE_HEAD;
use tercio_parallel::composite::packet::SPAN_HEAD;
use tercio_parallel::composite::{Shared, Touched};
use tercio_parallel::organisation::envelope::TRAILER;
use tercio_parallel::{Composition, Division, Organisation, RankReport};
use tercio_raster::frame::Pixel;
use tercio_raster::screen::{PixelRect, TileGrid};
use tercio_raster::{Frame, TileSet};
use tercio_scene::Background;

use super::drawing::Drawing;

/// Bytes of a pixel's key and of its colour.
const KEY_BYTES: u64 = 8;
const COLOR_BYTES: u64 = 4;

/// How ranks share a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sharing {
    /// Where work is redistributed.
    pub organisation: Organisation,
    /// How the picture is divided in sort-first.
    pub division: Division,
    /// Ranks, at least 1.
    pub ranks: usize,
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Pixels along the edge of a tile.
    pub edge: u32,
}

impl Sharing {
    /// The same for the renderer's ranks.
    pub fn of_ranks(&self) -> tercio_parallel::Sharing {
        tercio_parallel::Sharing { division: self.division, ..self.organisation.into() }
    }

    /// The tiles.
    pub fn grid(&self) -> TileGrid {
        TileGrid::new(self.size.0, self.size.1, self.edge, TileSet::ALL)
    }

    fn rect(&self, tile: u32) -> PixelRect {
        self.grid().rect(tile, self.size.into())
    }

    /// Pixels of a tile.
    pub fn pixels_of(&self, tile: u32) -> u64 {
        let PixelRect { x0, x1, y0, y1 } = self.rect(tile);
        (x1 - x0 + 1) as u64 * (y1 - y0 + 1) as u64
    }

    /// Pixels of the picture.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1)
    }
}

/// Pixels that show something, and the spans in which they are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Pixels {
    /// Rows of neighbours.
    pub spans: u64,
    /// Pixels.
    pub pixels: u64,
    /// Tiles that have some.
    pub tiles: u64,
}

impl Pixels {
    /// Bytes if they are composited, with keys.
    pub fn keyed_bytes(&self) -> u64 {
        self.tiles * TILE_HEAD as u64 + self.pixels * KEY_BYTES + self.bytes()
    }

    /// Bytes if they are finished.
    pub fn bytes(&self) -> u64 {
        self.spans * SPAN_HEAD as u64 + self.pixels * COLOR_BYTES
    }

    fn plus(self, o: Self) -> Self {
        Self { spans: self.spans + o.spans, pixels: self.pixels + o.pixels, tiles: self.tiles + o.tiles }
    }

    /// Those of a tile for which `shows` is true, by their indices in the picture.
    fn in_tile(rect: PixelRect, width: u32, shows: impl Fn(usize) -> bool) -> Self {
        let mut found = Self::default();
        for y in rect.y0..rect.y1 + 1 {
            let mut before = false;
            for x in rect.x0..rect.x1 + 1 {
                let shown = shows(y as usize * width as usize + x as usize);
                found.spans += u64::from(shown && !before);
                found.pixels += u64::from(shown);
                before = shown;
            }
        }
        found.tiles = u64::from(found.pixels > 0);
        found
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
    /// Pixels of the tiles that it finishes in which something is drawn.
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

/// The tiles that a rank finishes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Finished {
    /// Pixels of the tiles that it alone has drawn.
    pub scanned: u64,
    /// What these show: what differs from the background.
    pub shown: Pixels,
    /// What the tiles show that were composited.
    pub composited: Pixels,
    /// Pixels in which something was drawn.
    pub visible: u64,
    /// Whether it sends a message to rank 0.
    pub is_sent: bool,
}

impl Finished {
    /// Pixels that are sent.
    pub fn sent(&self) -> Pixels {
        self.shown.plus(self.composited)
    }
}

/// The messages of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Messages {
    /// Triangles that each rank processes.
    pub triangles: Vec<u64>,
    /// Messages by which each rank learns which tiles the others have drawn, and the bytes of their contents.
    pub gathered: (u64, u64),
    /// What each rank has drawn in tiles of several ranks, and the pixels of these tiles.
    pub shared: Vec<(Pixels, u64)>,
    /// What each rank sends to each other for compositing; `None` where there is no message.
    pub composed: Vec<Vec<Option<Pixels>>>,
    /// The finished pixels of each rank.
    pub finished: Vec<Finished>,
}

impl Messages {
    /// What a rank sends to another for compositing.
    pub fn between(&self, from: usize, to: usize) -> Option<Pixels> {
        self.composed[from].get(to).copied().flatten()
    }

    /// The counters of a rank.
    pub fn counts(&self, rank: usize) -> RankCounts {
        let (messages, bytes) = self.gathered;
        let mut counts =
            RankCounts { triangles: self.triangles[rank], messages, bytes, ..RankCounts::default() };
        for sent in self.composed[rank].iter().flatten() {
            counts.sent += sent.pixels;
            counts.messages += 1;
            counts.bytes += sent.keyed_bytes();
        }
        let taken = (0..self.composed.len()).filter_map(|from| self.between(from, rank));
        counts.compared = taken.map(|p| p.pixels).sum();
        let own = &self.finished[rank];
        counts.visible = own.visible;
        if own.is_sent {
            counts.messages += 1;
            counts.bytes += own.sent().bytes();
        }
        counts.bytes += counts.messages * TRAILER as u64;
        counts
    }

    /// Bytes of the messages that a rank receives.
    pub fn bytes_taken(&self, rank: usize) -> u64 {
        let composed = (0..self.composed.len()).filter_map(|from| self.between(from, rank));
        let finished = self.finished.iter().filter(|f| rank == 0 && f.is_sent);
        let contents = composed.map(|p| p.keyed_bytes()).chain(finished.map(|f| f.sent().bytes()));
        let (messages, gathered) = self.gathered;
        contents.map(|bytes| bytes + TRAILER as u64).sum::<u64>() + gathered + messages * TRAILER as u64
    }

    /// Messages and bytes of all ranks.
    pub fn total(&self) -> (u64, u64) {
        let counts = (0..self.triangles.len()).map(|rank| self.counts(rank));
        counts.fold((0, 0), |sum, c| (sum.0 + c.messages, sum.1 + c.bytes))
    }
}

/// What a rank has in a tile.
#[derive(Clone, Copy, Debug)]
struct InTile {
    tile: u32,
    drawn: Pixels,
    shown: Pixels,
}

/// Collects the messages of a frame, one rank after another.
pub struct Traffic<'a> {
    sharing: &'a Sharing,
    /// The colour of each row.
    background: Vec<Pixel>,
    triangles: Vec<u64>,
    /// What each rank has in the tiles that it touches.
    in_tiles: Vec<Vec<InTile>>,
    /// Pixels that any rank shows.
    by_any: Vec<bool>,
}

impl<'a> Traffic<'a> {
    /// No rank shows anything yet.
    pub fn new(sharing: &'a Sharing, background: &Background) -> Self {
        let height = sharing.size.1;
        Self {
            sharing,
            background: Pixel::of_background_rows(background, 0..height, height, false),
            triangles: Vec::new(),
            in_tiles: Vec::new(),
            by_any: vec![false; sharing.pixels() as usize],
        }
    }

    /// Adds the next rank.
    pub fn add(&mut self, drawing: &Drawing) {
        let Drawing { counters, touched, frame, .. } = drawing;
        let (width, Frame { planes, .. }) = (self.sharing.size.0, frame);
        self.triangles.push(counters.triangles);
        let in_tile = |&tile: &u32| {
            let rect = self.sharing.rect(tile);
            let of_row = |place: usize| self.background[place / width as usize].color;
            InTile {
                tile,
                drawn: Pixels::in_tile(rect, width, |place| planes.keys[place] != 0),
                shown: Pixels::in_tile(rect, width, |place| planes.color[place] != of_row(place)),
            }
        };
        self.in_tiles.push(touched.iter().map(in_tile).collect());
        // Tiles that are not touched have the background.
        self.by_any.iter_mut().zip(&planes.keys).for_each(|(any, key)| *any |= *key != 0);
    }

    /// The messages after all ranks have been added; `owners` has the owner of each tile in sort-first.
    pub fn finish(self, owners: &[u32]) -> Messages {
        let (sharing, ranks) = (self.sharing, self.sharing.ranks);
        let tiles = sharing.grid().count();
        let mut messages = Messages {
            triangles: self.triangles,
            shared: vec![Default::default(); ranks],
            composed: vec![Vec::new(); ranks],
            finished: vec![Finished::default(); ranks],
            ..Messages::default()
        };
        let has =
            |rank: usize, tile: u32| self.in_tiles[rank].binary_search_by_key(&tile, |of| of.tile).is_ok();
        let touched = Touched::new(tiles, (0..ranks).map(|rank| move |tile| has(rank, tile)));
        let is_composited = sharing.organisation.composites(ranks);
        let shared_tiles = if is_composited { touched.shared() } else { Vec::new() };
        let is_shared = |tile: u32| shared_tiles.binary_search(&tile).is_ok();
        let mut owns = vec![false; ranks];
        if is_composited {
            let words = tiles.div_ceil(64) as u64;
            messages.gathered =
                (u64::from(ranks.next_power_of_two().trailing_zeros()), words * 8 * (ranks as u64 - 1));
            let those = touched.ranks_of_any(&shared_tiles);
            let shared = Shared { tiles: &shared_tiles, ranks: &those, touched: &touched };
            let drawn = |rank: usize, tile: u32| {
                let found = self.in_tiles[rank].binary_search_by_key(&tile, |of| of.tile);
                found.map_or(Pixels::default(), |at| self.in_tiles[rank][at].drawn)
            };
            for (place, &rank) in those.iter().enumerate() {
                messages.composed[rank] = vec![None; ranks];
                for (to, sent) in
                    Composition::DirectSend.rounds(&shared, place).into_iter().flat_map(|r| r.sends)
                {
                    let pixels = sent.into_iter().map(|tile| drawn(rank, tile));
                    messages.composed[rank][those[to]] = Some(pixels.fold(Pixels::default(), Pixels::plus));
                }
            }
            for (&tile, place) in shared_tiles.iter().zip(Composition::DirectSend.owners(&shared)) {
                let merged = Pixels::in_tile(sharing.rect(tile), sharing.size.0, |place| self.by_any[place]);
                let own = &mut messages.finished[those[place]];
                own.composited = own.composited.plus(merged);
                own.visible += merged.pixels;
                owns[those[place]] = true;
            }
        } else {
            (0..ranks).for_each(|rank| owns[rank] = owners.contains(&(rank as u32)));
        }
        for (rank, in_tiles) in self.in_tiles.iter().enumerate() {
            for of in in_tiles {
                if is_shared(of.tile) {
                    let (drawn, scanned) = &mut messages.shared[rank];
                    *drawn = drawn.plus(of.drawn);
                    *scanned += sharing.pixels_of(of.tile);
                } else {
                    let own = &mut messages.finished[rank];
                    own.scanned += sharing.pixels_of(of.tile);
                    own.shown = own.shown.plus(of.shown);
                    own.visible += of.drawn.pixels;
                }
            }
            let has_sole = is_composited && touched.has_sole(rank, &shared_tiles);
            messages.finished[rank].is_sent = rank > 0 && (owns[rank] || has_sole);
        }
        messages
    }
}
