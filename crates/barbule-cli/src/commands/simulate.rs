//! `barbule simulate`: a campaign into a store that survives interruptions.

use std::io::Write;
use std::path::PathBuf;

use barbule::campaign::{Keep, Resources, Results, run};
use barbule::io::store::{Status, Store, Survey};
use barbule::progress::Shard;
use barbule::spectrum::Wavelengths;
use barbule::{Error, Result};
use serde_json::json;

use crate::campaign::{CampaignArgs, say_repaired, units_at_once};
use crate::common::{Common, print, print_json};
use crate::materials::catalog;
use crate::progress::Terminal;
use crate::shard::{self, Parts};
use crate::structure_arg::{self, SideArg};

/// Arguments of `barbule simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule simulate starling --thin 4 -o starling.zarr\n  \
    barbule simulate starling.zarr --status\n  \
    barbule simulate starling.zarr --status --shards 16\n  \
    barbule simulate starling --side below --thin 10 -o underside.zarr\n\n\
    Of a structure that is not its own mirror image (given sections, lattices) both signs of φ_i are simulated; -v says so.")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP, long_help = "The structure, or with --status a store")]
    structure: String,
    /// The store to fill, or to resume
    #[arg(short, long, value_name = "S.zarr", required_unless_present = "status")]
    output: Option<PathBuf>,
    /// Only part i of n (i from 0) of the units, for several processes on one store
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = shard::parse)]
    shard: Option<Shard>,
    /// Say what of a store is done, and who computes the rest
    #[arg(long)]
    status: bool,
    /// With --status: what of each of n parts is done [default: as many as those that run have]
    #[arg(long, value_name = "n", requires = "status", conflicts_with = "shard", allow_hyphen_values = true,
        value_parser = shard::count)]
    shards: Option<usize>,
    /// Keep the fields of every instance at these wavelengths (nm)
    #[arg(long, value_name = "SET", value_parser = crate::sets::wavelength_set)]
    keep_fields: Option<Wavelengths>,
    #[command(flatten)]
    side: SideArg,
    #[command(flatten)]
    campaign: CampaignArgs,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        if self.status {
            return self.report(out);
        }
        let Some(path) = &self.output else { return Err(Error::input("give the store's name with -o")) };
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        let structure = self.side.open(&self.structure, &self.common)?;
        let plan = self.campaign.plan(structure, &self.common)?;
        let kept = self.keep_fields.as_ref().map_or(&[][..], Wavelengths::nm);
        let width = self.campaign.width();
        let keep = if kept.is_empty() { Keep::Statistics } else { Keep::Fields };
        let units_at_once = units_at_once(&plan, keep, Results::Stored, &self.common)?;
        let resources = Resources { width, units_at_once };
        let store = plan.store(path, kept, &resources)?;
        let units = store.axes().shard(shard.number(), shard.of());
        let coordinates = store.damaged_coordinates();
        if !coordinates.is_empty() {
            store.prepare_writing()?;
            self.common.say(&format!("{}; they are written again", damaged(&coordinates)));
        }
        if units.iter().all(|unit| store.is_whole(unit.wavelength, unit.theta)) {
            store.end_writing();
            if coordinates.is_empty() {
                self.common.say("everything is there already: nothing to do");
            }
        } else {
            store.prepare_writing()?;
            let _announced = store.announce(shard);
            let progress = Terminal::new(&self.common);
            let outcome = plan
                .campaign(&resources, &catalog(&self.common), &progress)
                .and_then(|campaign| run(&campaign, &units, &store, &progress));
            drop(progress);
            let done = || units.iter().filter(|unit| store.is_done(unit.wavelength, unit.theta)).count();
            let outcome = outcome.map_err(|error| {
                if !error.is_interrupted() {
                    return error;
                }
                let (done, all) = (done(), units.len());
                Error::interrupted_after(format!("{done} of {all} units done; the same command goes on"))
            })?;
            say_repaired(outcome.repaired, &self.common);
            self.common.explain(&format!("{} units computed, {} found", outcome.computed, outcome.found));
            let what = format!("the campaign {}, {} of {} units", store.name(), done(), units.len());
            self.common.wrote(path, &what);
        }
        if self.common.json {
            return print_json(out, &status(&store, &store.survey()));
        }
        Ok(())
    }

    fn report(&self, out: &mut dyn Write) -> Result<()> {
        let store = Store::open(self.output.as_deref().unwrap_or(self.structure.as_ref()))?;
        let survey = store.survey();
        let parts = Parts::of(&survey, self.shard, self.shards);
        if self.common.json {
            let mut document = status(&store, &survey);
            document["shards"] = parts.json();
            return print_json(out, &document);
        }
        let Status { units, done, damaged: broken } = survey.status();
        let text = format!(
            "{}: {done} of {units} units done, {} missing, {broken} damaged",
            store.name(),
            units - done - broken
        );
        print(out, &text)?;
        parts.lines().iter().try_for_each(|line| print(out, line))?;
        let coordinates = store.damaged_coordinates();
        if coordinates.is_empty() {
            return Ok(());
        }
        print(out, &format!("{}; the same simulate command writes them again", damaged(&coordinates)))
    }
}

/// Says of coordinates that other readers of the store would miss them.
pub(super) fn damaged(coordinates: &[&str]) -> String {
    format!("missing or damaged coordinates: {}", coordinates.join(", "))
}

fn status(store: &Store, survey: &Survey) -> serde_json::Value {
    let status = survey.status();
    json!({
        "name": store.name(),
        "units": status.units,
        "done": status.done,
        "missing": status.missing(),
        "damaged": status.damaged,
        "damaged_coordinates": store.damaged_coordinates(),
        "simd": store.width(),
        "running": shard::running(survey),
    })
}
