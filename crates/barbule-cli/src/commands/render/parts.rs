//! `--shard` of one picture: some of its tiles, kept in a file beside it until the same command without `--shard` joins all parts.

use std::path::{Path, PathBuf};
use std::time::Instant;

use barbule::picture::{Joined, Parts, part_path};
use barbule::progress::{Progress as _, Shard};
use barbule::render::film::Film;
use barbule::render::run::{Ended, is_done};
use barbule::scene::description::ReadyScene;
use barbule::{Error, Result};

use super::Args;
use super::checkpoints::Checkpoints;
use super::job::Job;
use crate::common::path_json;
use crate::progress::Terminal;

impl Args {
    /// The part of a single picture that is asked for.
    pub(super) fn part(&self) -> Option<Shard> {
        self.shard.filter(|_| self.frames == 1)
    }

    /// Where it is kept.
    pub(super) fn part_file(&self, picture: &Path) -> Option<PathBuf> {
        self.part().map(|shard| part_path(picture, shard))
    }

    /// Draws a part as far as it is not there, and keeps it; gives its report.
    pub(super) fn draw_part(
        &self,
        scene: &ReadyScene,
        job: &Job<'_>,
        shard: Shard,
    ) -> Result<serde_json::Value> {
        for (flag, is_given) in [("--resume", self.resume), ("--preview", self.preview.is_some())] {
            if is_given {
                self.common.idle(flag, "a part goes on from its own file, which is no picture");
            }
        }
        let parts = self.parts(scene, job);
        let (mut film, refused) = parts.film(shard)?;
        if let Some(error) = refused {
            self.common.say(&format!("{error}; it is rendered anew"));
        }
        let (path, before) = (parts.path(shard), film.samples());
        let (mut begun, mut ended) = (Instant::now(), Ended::Done);
        if is_done(&film, &job.goal) {
            self.common.say(&format!("part {shard} is done, there is nothing to do"));
        } else {
            let set = self.set(scene, &Terminal::new(&self.common).writing_nothing())?;
            let terminal = Terminal::new(&self.common).keeping_what_is_done();
            let checkpoints = Checkpoints::new(&self.common, true);
            let mut kept = checkpoints.at(path.clone(), *parts.name());
            begun = Instant::now();
            ended = set.render(scene, &mut film, self.common.seed, job.goal, &terminal, &mut |film| {
                kept.now_and_then(film);
                Ok(())
            })?;
            if film.samples() > before {
                parts.keep(&film)?;
            }
            if terminal.is_cancelled() && !is_done(&film, &job.goal) {
                ended = Ended::Stopped;
            }
        }
        let samples = film.samples() as f64 / (film.pixels() as f64).max(1.0);
        let what = format!(
            "part {shard}: {} of {} tiles, {samples:.1} samples each",
            film.held().len(),
            film.tiles()
        );
        if ended == Ended::Stopped {
            return Err(Error::interrupted_after(format!("{what}; the same command goes on")));
        }
        let (paths, seconds) = (film.samples() - before, begun.elapsed().as_secs_f64());
        if paths > 0 {
            self.common.wrote(&path, &format!("{what}; the same command without --shard joins all parts"));
            self.say_faults(&film.faults(), scene);
        }
        Ok(serde_json::json!({
            "output": path_json(&path), "shard": shard.to_string(), "tiles": film.held().len(),
            "paths": paths, "seconds": seconds, "ended": "done", "impossible_samples": film.faults().count,
        }))
    }

    /// Takes what several processes rendered of a picture into its film.
    pub(super) fn join(&self, scene: &ReadyScene, job: &Job<'_>, film: &mut Film) -> Result<(Parts, Joined)> {
        let parts = self.parts(scene, job);
        if self.frames > 1 {
            return Ok((parts, Joined::default()));
        }
        let joined = parts.join(film)?;
        for error in &joined.refused {
            self.common.say(&format!("{error}; it is not joined"));
        }
        if !joined.taken.is_empty() {
            let (what, lack) = match joined.taken.len() {
                1 => ("1 part is joined".to_owned(), "it lacks"),
                count => (format!("{count} parts are joined"), "they lack"),
            };
            let is_whole = is_done(film, &job.goal);
            let rest = if is_whole { String::new() } else { format!("; what {lack} is rendered here") };
            self.common.say(&format!("{what}{rest}"));
        }
        Ok((parts, joined))
    }

    fn parts(&self, scene: &ReadyScene, job: &Job<'_>) -> Parts {
        Parts::new(job.file, (scene, self.common.seed), &job.goal, (job.size, job.planes))
    }
}
