//! A picture in tiles of each size that candidates have, looked at once for all of them.

use tercio_parallel::organisation::tile_edge;
use tercio_parallel::{Division, Organisation, Sharing};
use tercio_raster::context::FrameContext;
use tercio_raster::survey::Effort;
use tercio_raster::{ClusterSet, Settings, TileSet};

use super::Predicted;
use super::candidates::MANY;
use super::frame::{Divided, Grouped};
use super::rates::Rates;
use super::terms::Stage;
use super::tiles::{self, Tiles};
use crate::predict::PredictError;
use crate::predict::ranks::Picture;

/// How much of a scene is looked at for each size of tiles, for up to [`MANY`] ranks, and for more.
const EFFORT: Effort = Effort { clusters: 1024, visits: 1 << 13 };
const EFFORT_OF_MANY: Effort = Effort { clusters: 4096, visits: 1 << 15 };
/// Tiles are at least so large that there are no more than this, or as many as many ranks need.
const MOST_TILES: usize = 4096;

/// A picture that so many ranks are to share.
pub struct Sights<'a> {
    picture: &'a Picture<'a>,
    ranks: usize,
    seen: Vec<Seen>,
    /// How many tiles and parts of tiles were looked at.
    pub steps: u64,
}

impl<'a> Sights<'a> {
    /// Nothing is looked at yet.
    pub fn new(picture: &'a Picture<'a>, ranks: usize) -> Self {
        Self { picture, ranks, seen: Vec::new(), steps: 0 }
    }

    /// Predicts candidates, in their order. The tiles are looked at with the costs of the first call; those of messages, and how
    /// many threads and processors there are, may differ from call to call.
    ///
    /// # Errors
    /// [`PredictError`]: a picture that cannot be drawn.
    pub fn predict(&mut self, candidates: &[Sharing], stage: &Stage) -> Result<Vec<Predicted>, PredictError> {
        self.seen.iter_mut().for_each(|seen| seen.divided.clear());
        let mut predicted = Vec::new();
        for &sharing in candidates {
            let (organisation, division) = (sharing.organisation, sharing.division);
            let edge = edge_for(self.picture, organisation, self.ranks);
            let number = match self.seen.iter().position(|seen| seen.edge == edge) {
                Some(number) => number,
                None => {
                    self.seen.push(Seen::of(self.picture, edge, self.ranks, stage.rates, &mut self.steps)?);
                    self.seen.len() - 1
                }
            };
            let divided =
                self.seen[number].divided(organisation, division, self.ranks, stage, &mut self.steps);
            let (terms, sent) = divided.with(&sharing, stage, &mut self.steps);
            predicted.push(Predicted { sharing, terms, sent });
        }
        Ok(predicted)
    }
}

/// Pixels along the edge of the tiles of an organisation; if there were very many, larger ones stand for them.
fn edge_for(picture: &Picture, organisation: Organisation, ranks: usize) -> u32 {
    let mut edge = tile_edge(picture.scene, picture.settings, organisation, ranks);
    let most = MOST_TILES.max(8 * ranks);
    while edge < 128 && picture.settings.tiles_of(edge) > most {
        edge *= 2;
    }
    edge
}

/// The picture in tiles of one size, and what was found out about it.
struct Seen {
    edge: u32,
    grid: tercio_raster::screen::TileGrid,
    tiles: Tiles,
    /// By the size of groups.
    parts: Vec<(usize, Vec<tiles::Part>)>,
    /// By division and the number of ranks that share the tiles.
    owners: Vec<((Division, usize), Vec<u32>)>,
    divided: Vec<((bool, usize, Division), Divided)>,
}

impl Seen {
    fn of(
        picture: &Picture,
        edge: u32,
        ranks: usize,
        rates: &Rates,
        steps: &mut u64,
    ) -> Result<Self, PredictError> {
        let settings = Settings {
            tile_size: Some(edge),
            clusters: ClusterSet::ALL,
            tiles: TileSet::ALL,
            ..picture.settings.clone()
        };
        let context = FrameContext::new(picture.scene, picture.camera, &settings, 1)?;
        let effort = if ranks > MANY { EFFORT_OF_MANY } else { EFFORT };
        let tiles = Tiles::of(&context, effort, ranks, rates);
        *steps += (2 * tiles.entries() + tiles.load.len()) as u64;
        Ok(Self {
            edge,
            grid: context.grid.clone(),
            tiles,
            parts: Vec::new(),
            owners: Vec::new(),
            divided: Vec::new(),
        })
    }

    /// Where the owners of the tiles are in the list of them, if so many ranks share the tiles.
    fn owners(&mut self, division: Division, ranks: usize, steps: &mut u64) -> usize {
        self.owners.iter().position(|(of, _)| *of == (division, ranks)).unwrap_or_else(|| {
            *steps += self.tiles.load.len() as u64;
            let owners = self.tiles.owners(&self.grid, division, ranks);
            self.owners.push(((division, ranks), owners));
            self.owners.len() - 1
        })
    }

    /// The picture, divided; once for all compositions.
    fn divided(
        &mut self,
        organisation: Organisation,
        division: Division,
        ranks: usize,
        stage: &Stage,
        steps: &mut u64,
    ) -> &Divided {
        let group = organisation.group(ranks);
        let key = (organisation == Organisation::SortFirst, group, division);
        if let Some(number) = self.divided.iter().position(|(of, _)| *of == key) {
            return &self.divided[number].1;
        }
        let number = self.parts.iter().position(|(of, _)| *of == group).unwrap_or_else(|| {
            *steps += (2 * self.tiles.entries() + ranks.div_ceil(group)) as u64;
            self.parts.push((group, self.tiles.parts(group, stage.rates)));
            self.parts.len() - 1
        });
        let shorter = ranks - (ranks.div_ceil(group) - 1) * group;
        let [full, last] = [group, shorter].map(|sharing| self.owners(division, sharing, steps));
        let grouped = Grouped {
            tiles: &self.tiles,
            ranks,
            group,
            parts: &self.parts[number].1,
            owners: &self.owners[full].1,
            owners_of_last: &self.owners[last].1,
        };
        let divided = grouped.divide(organisation, division, stage, steps);
        self.divided.push((key, divided));
        &self.divided[self.divided.len() - 1].1
    }
}
