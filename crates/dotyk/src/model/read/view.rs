//! Data for reading the steps of a stage: places of probes, cuts of sections, remarks on the bodies as they are given, and their outer
//! surfaces. They do not change from step to step.

use crate::mesh::Skin;
use crate::model::nouns::error::Error;
use crate::model::nouns::model::Model;
use crate::model::nouns::presence::Stage;
use crate::model::read::probe::{Site, sites};
use crate::model::read::remarks::body_remarks;
use crate::model::read::section::{Laid, lay_out};
use crate::model::read::singular::Outlines;
use crate::model::system::condition::Condition;
use rayon::prelude::*;
use std::sync::OnceLock;

/// Data made once for all steps of a stage.
pub(crate) struct View<const D: usize> {
    /// Places of each probe.
    pub sites: Vec<Site<D>>,
    /// Cuts of each section.
    pub laid: Vec<Laid<D>>,
    /// Remarks on the bodies as they are given.
    pub remarks: Vec<String>,
    /// Outlines, for places where stresses may be singular.
    pub outlines: Outlines,
    skins: OnceLock<Vec<Skin<D>>>,
}

impl<const D: usize> View<D> {
    /// The view of a model whose contacts are paired.
    ///
    /// Errors: a probe without a place, a section that cannot be cut, with its name.
    pub fn new(stage: &Stage<'_, D>, conditions: &[Condition<D>]) -> Result<Self, Error<D>> {
        let model = stage.model.as_ref();
        Ok(Self {
            sites: sites(model, conditions)?,
            laid: lay_out(stage)?,
            remarks: body_remarks(stage),
            outlines: Outlines::default(),
            skins: OnceLock::new(),
        })
    }

    /// The view of a model with the same bodies and contacts, and other probes, sections or loads.
    ///
    /// Errors: as [`Self::new`].
    pub fn of_same(
        self,
        stage: &Stage<'_, D>,
        conditions: &[Condition<D>],
    ) -> Result<Self, Error<D>> {
        let (outlines, skins) = (self.outlines, self.skins);
        Ok(Self {
            outlines,
            skins,
            ..Self::new(stage, conditions)?
        })
    }

    /// The outer surfaces of all bodies, made on first use.
    pub fn skins(&self, model: &Model<D>) -> &[Skin<D>] {
        let bodies = model.bodies.par_iter();
        self.skins
            .get_or_init(|| bodies.map(|body| Skin::of(&body.mesh)).collect())
    }
}
