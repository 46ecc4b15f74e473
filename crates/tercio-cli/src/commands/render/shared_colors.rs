//! One scale for all models of a picture that are coloured by the same data in the same way: then a colour means the same everywhere.

use std::sync::Arc;

use anyhow::{Context as _, Result};
use tercio::glam::DVec3;
use tercio::mesh::strokes::Strokes;
use tercio::scene::Instance;

use super::Render;
use super::load::Opened;
use crate::args::data::{DataArgs, RangeOver, Survey};

impl Render {
    /// How each model of the picture is coloured, where up is there; `files[file_of[i]]` is that of model i, which draws `strokes[i]`.
    ///
    /// # Errors
    /// Data that are not there, of several models that share them.
    pub(super) fn shared_colors(
        &self,
        (files, file_of): (&[Opened], &[usize]),
        strokes: &[Arc<Strokes>],
        up: DVec3,
    ) -> Result<Vec<DataArgs>> {
        let members: Vec<&Self> = self.members().collect();
        let mut all: Vec<DataArgs> = members.iter().map(|member| member.data.clone()).collect();
        if self.is_measured {
            return Ok(all);
        }
        let keys: Vec<String> = all.iter().map(|data| format!("{data:?}")).collect();
        for first in 0..members.len() {
            let alike: Vec<usize> = (first..members.len()).filter(|&i| keys[i] == keys[first]).collect();
            let is_first = !keys[..first].contains(&keys[first]);
            let over = all[first].range_over().filter(|over| *over != RangeOver::Each);
            let Some(over) = over.filter(|_| is_first && alike.len() > 1 && !all[first].is_of_series())
            else {
                continue;
            };
            let surveyed = if over == RangeOver::First { &alike[..1] } else { &alike[..] };
            let mut survey = Survey::default();
            for &i in surveyed {
                let member = members[i];
                let mut instance = Instance::new(Arc::clone(&files[file_of[i]].loaded.mesh));
                instance.world_from_object = member.place.transform();
                let own = member.data.survey(&instance, &strokes[i], up);
                survey = survey.and(own.with_context(|| member.model.name())?);
            }
            for &i in &alike {
                let own = all[i].of_series(&survey);
                all[i] = if i > first { own.behind_the_first() } else { own };
            }
        }
        Ok(all)
    }
}
