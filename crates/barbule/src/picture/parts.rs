//! A picture that several processes render, each some of its tiles: parts are kept in files beside it until somebody joins them.

use std::path::{Path, PathBuf};

use crate::identity::Hasher;
use crate::io::{delete_file, endings_beside, read_own, write_whole};
use crate::math::simd::Width;
use crate::progress::Shard;
use crate::render::checkpoint;
use crate::render::film::{Film, TILE, bytes_per_pixel};
use crate::render::planes::Planes;
use crate::render::run::Goal;
use crate::scene::description::SceneDescription;
use crate::{Error, Result};

/// What stands between the name of a picture and that of a part, as in `F.png.part-3-of-16`.
const MIDDLE: &str = ".part-";
const OF: &str = "-of-";

/// The parts of one picture. What decides them is that of the picture (scene with what it names, seed, sensor, planes, this program's version), how
/// many samples are taken or how little noise is to be left, and the processor's instruction set, by which the last bits go.
#[derive(Debug, Clone)]
pub struct Parts {
    picture: PathBuf,
    name: [u8; 32],
    size: [u32; 2],
    planes: Planes,
}

/// What was found beside a picture.
#[derive(Debug, Default)]
pub struct Joined {
    /// The parts that are its own, begun ones too.
    pub taken: Vec<Shard>,
    /// Why others are not: damaged, or of another picture.
    pub refused: Vec<Error>,
}

impl Parts {
    /// Those of the picture in this file, which need not be there. `goal`: its time does not count.
    #[must_use]
    pub fn new(
        picture: &Path,
        (scene, seed): (&SceneDescription, u64),
        goal: &Goal,
        (size, planes): ([u32; 2], &Planes),
    ) -> Self {
        let whole = checkpoint::name(scene, seed, env!("CARGO_PKG_VERSION"), planes);
        let mut hasher = Hasher::new("part of a picture");
        hasher.text("picture", &blake3::Hash::from_bytes(whole).to_hex());
        hasher.numbers("size", &size.map(f64::from)).count("samples", goal.samples.into());
        hasher.numbers("noise", goal.noise.as_slice()).text("instructions", Width::best().name());
        Self { picture: picture.to_owned(), name: hasher.finish(), size, planes: planes.clone() }
    }

    /// What tells them from those of other pictures.
    #[must_use]
    pub fn name(&self) -> &[u8; 32] {
        &self.name
    }

    /// The file of a part.
    #[must_use]
    pub fn path(&self, shard: Shard) -> PathBuf {
        part_path(&self.picture, shard)
    }

    /// A part as far as it is kept, else a black film of it with the reason why what is there does not count.
    ///
    /// # Errors
    /// A size that no film can have.
    pub fn film(&self, shard: Shard) -> Result<(Film, Option<Error>)> {
        let (path, empty) = (self.path(shard), Film::part(self.size, self.planes.clone(), shard)?);
        if !path.exists() {
            return Ok((empty, None));
        }
        let read = read_own(&path, checkpoint::bytes(&empty)).and_then(|bytes| {
            checkpoint::read(&bytes, &self.name, empty.clone()).map_err(|error| error.at(path.display()))
        });
        Ok(match read {
            Ok(film) => (film, None),
            Err(error) => (empty, Some(error)),
        })
    }

    /// Keeps a part.
    ///
    /// # Errors
    /// Its file cannot be written.
    pub fn keep(&self, film: &Film) -> Result<()> {
        write_whole(&self.path(film.shard()), &checkpoint::write(film, &self.name))
    }

    /// Takes the samples of all parts that are kept, of however many each is one, into the film of the whole picture.
    ///
    /// # Errors
    /// A size that no film can have.
    pub fn join(&self, film: &mut Film) -> Result<Joined> {
        let mut joined = Joined::default();
        for shard in self.kept() {
            match self.film(shard)? {
                (part, None) => {
                    film.join(part)?;
                    joined.taken.push(shard);
                }
                (_, Some(error)) => joined.refused.push(error),
            }
        }
        Ok(joined)
    }

    /// Deletes parts that are joined.
    ///
    /// # Errors
    /// One cannot be deleted.
    pub fn delete(&self, shards: &[Shard]) -> Result<()> {
        shards.iter().try_for_each(|shard| delete_file(&self.path(*shard)))
    }

    /// The parts of which there are files.
    fn kept(&self) -> Vec<Shard> {
        let parsed = |ending: String| {
            let (number, of) = ending.split_once(OF)?;
            let shard = Shard::new(number.parse().ok()?, of.parse().ok()?).ok()?;
            (ending == named(shard)).then_some(shard)
        };
        let mut kept: Vec<Shard> =
            endings_beside(&self.picture, MIDDLE).into_iter().filter_map(parsed).collect();
        kept.sort_by_key(|shard| (shard.of(), shard.number()));
        kept
    }
}

fn named(shard: Shard) -> String {
    format!("{}{OF}{}", shard.number(), shard.of())
}

/// Where a part of the picture in a file is kept: beside it, as `F.png.part-3-of-16`.
#[must_use]
pub fn part_path(picture: &Path, shard: Shard) -> PathBuf {
    let mut name = picture.as_os_str().to_owned();
    name.push(format!("{MIDDLE}{}", named(shard)));
    name.into()
}

/// Memory that a part of a picture of this size takes, bytes: its pixels while they are rendered and as they are written, and the program; what stands in
/// the scene aside.
#[must_use]
pub fn part_bytes_needed(size: [u32; 2], planes: &Planes, shard: Shard) -> u64 {
    let tiles = size.map(|side| side.div_ceil(TILE) as usize);
    let pixels = shard.range(tiles[0] * tiles[1]).len() as u64 * u64::from(TILE * TILE);
    super::PROGRAM + pixels * (bytes_per_pixel(planes) * 3 / 2) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(picture: &Path, samples: u32, noise: Option<f64>) -> Parts {
        let scene = SceneDescription::named("starling").unwrap();
        let goal = Goal { noise, ..Goal::samples(samples) };
        Parts::new(picture, (&scene, 1), &goal, ([100, 40], &Planes::default()))
    }

    #[test]
    fn parts_are_found_by_their_names_and_told_apart_by_what_decides_them() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("f.png");
        let own = parts(&picture, 4, None);
        let shard = |number, of| Shard::new(number, of).unwrap();
        let mut film = Film::new([100, 40]).unwrap();
        assert!(own.join(&mut film).unwrap().taken.is_empty());
        for shard in [shard(10, 16), shard(2, 16), shard(0, 3)] {
            own.keep(&own.film(shard).unwrap().0).unwrap();
        }
        assert!(folder.path().join("f.png.part-10-of-16").is_file());
        for name in
            ["f.png.part-2-of-2", "f.png.part-02-of-16", "f.png.part-x", "g.png.part-1-of-2", "f.png.part-"]
        {
            std::fs::write(folder.path().join(name), "others").unwrap();
        }
        let found = own.join(&mut film).unwrap();
        assert_eq!((found.taken, found.refused.len()), (vec![shard(0, 3), shard(2, 16), shard(10, 16)], 0));
        for other in [parts(&picture, 8, None), parts(&picture, 4, Some(0.1))] {
            let found = other.join(&mut film).unwrap();
            assert!(found.taken.is_empty() && found.refused.len() == 3);
            assert!(found.refused[0].to_string().contains("another picture"), "{}", found.refused[0]);
        }
        own.delete(&[shard(0, 3), shard(0, 3)]).unwrap();
        assert_eq!(own.kept(), [shard(2, 16), shard(10, 16)]);
    }

    #[test]
    fn what_is_damaged_is_begun_again() {
        let folder = tempfile::tempdir().unwrap();
        let own = parts(&folder.path().join("f.exr"), 4, None);
        let shard = Shard::new(1, 2).unwrap();
        own.keep(&own.film(shard).unwrap().0).unwrap();
        let path = own.path(shard);
        let good = std::fs::read(&path).unwrap();
        for at in [0, 9, 30, good.len() / 2, good.len() - 1] {
            let mut bad = good.clone();
            bad[at] ^= 1;
            for bad in [&bad[..], &good[..at]] {
                std::fs::write(&path, bad).unwrap();
                let (film, error) = own.film(shard).unwrap();
                assert!(film.samples() == 0 && error.unwrap().to_string().contains("part-1-of-2"), "{at}");
            }
        }
        // One that only says to be of this picture, and is larger than any.
        std::fs::write(&path, [&good[..], &good[..]].concat()).unwrap();
        assert!(own.film(shard).unwrap().1.unwrap().to_string().contains("over the limit"));
    }
}
