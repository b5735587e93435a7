//! Films that hold a part of a picture's tiles, for several processes; tiles need nothing from each other, so that parts together are
//! the picture to the bit.

use std::sync::Arc;

use super::{Film, Tile, bounds, check_size, tiles};
use crate::identity::hash;
use crate::progress::Shard;
use crate::render::planes::Planes;
use crate::render::response::Response;
use crate::{Error, Result};

impl Film {
    /// A black film of a part of a picture: of tiles that lie evenly over it, so that parts take about equally long. Only these take
    /// memory.
    ///
    /// # Errors
    /// As [`check_size`].
    pub fn part(size: [u32; 2], planes: Planes, shard: Shard) -> Result<Self> {
        check_size(size)?;
        let [across, down] = tiles(size);
        let held = held(size, shard);
        let mut all = vec![Tile::default(); (across * down) as usize];
        for &tile in &held {
            all[tile] = Tile::new(bounds(size, tile), &planes);
        }
        let response = Arc::new(Response::new(&planes.sensor));
        Ok(Self { size, planes, response, shard, held, tiles: all })
    }

    /// Which part of the picture it holds.
    #[must_use]
    pub fn shard(&self) -> Shard {
        self.shard
    }

    /// The tiles of its part, rising.
    #[must_use]
    pub fn held(&self) -> &[usize] {
        &self.held
    }

    /// How many pixels it holds.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.pixels.len() as u64).sum()
    }

    /// Takes over the tiles of a part that have more samples than its own.
    ///
    /// # Errors
    /// A film of another size, other channels or other planes.
    pub fn join(&mut self, part: Self) -> Result<()> {
        let Planes { sensor, compositing, spectral } = &part.planes;
        let own = &self.planes;
        let is_alike = hash("sensor", sensor) == hash("sensor", &own.sensor)
            && (compositing, spectral) == (&own.compositing, &own.spectral);
        if part.size != self.size || !is_alike {
            return Err(Error::input("a film of another size or of other planes is no part of this picture"));
        }
        for (own, other) in self.tiles.iter_mut().zip(part.tiles) {
            if other.count > own.count && other.pixels.len() == own.pixels.len() {
                *own = other;
            }
        }
        Ok(())
    }
}

/// The tiles of a part, rising: neighbours in an order that spreads any run of tiles over the picture.
fn held(size: [u32; 2], shard: Shard) -> Vec<usize> {
    let [across, down] = tiles(size);
    let mut order: Vec<u32> = (0..across * down).collect();
    order.sort_unstable_by_key(|tile| (spread(tile % across, tile / across), *tile));
    let mut held: Vec<usize> = order[shard.range(order.len())].iter().map(|tile| *tile as usize).collect();
    held.sort_unstable();
    held
}

/// Fractions of x/p + y/p², p³ = p + 1: of all lattices by a single number those near each other lie furthest apart (Roberts 2018).
fn spread(x: u32, y: u32) -> u32 {
    x.wrapping_mul(0xC13F_A9A9).wrapping_add(y.wrapping_mul(0x91E1_0DA5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::film::TILE;

    /// Parts are together every tile once, of equal counts, and each has its share of any half of the picture.
    #[test]
    fn parts_are_all_tiles_once_and_lie_evenly() {
        let (across, down) = (41, 26);
        let size = [across * TILE - 5, down * TILE];
        for of in [1, 2, 3, 7, 16, 40, 41, 100, 1066, 2000] {
            let parts: Vec<Vec<usize>> = (0..of).map(|i| held(size, Shard::new(i, of).unwrap())).collect();
            let mut all = parts.concat();
            all.sort_unstable();
            assert_eq!(all, (0..(across * down) as usize).collect::<Vec<_>>());
            for part in &parts {
                assert!(part.is_sorted() && part.len().abs_diff(1066 / of) <= 1, "{of}");
                let left = part.iter().filter(|tile| (**tile as u32 % across) < across / 2).count() as f64;
                let upper = part.iter().filter(|tile| (**tile as u32 / across) < down / 2).count() as f64;
                let half = part.len() as f64 / 2.0;
                // A few tiles, or a twelfth.
                let off = 2.5 + part.len() as f64 / 12.0;
                assert!(
                    (left - half).abs() < off && (upper - half).abs() < off,
                    "{of}: {left} {upper} {half}"
                );
            }
        }
    }

    #[test]
    fn a_part_takes_the_memory_of_its_tiles_and_shows_nothing_elsewhere() {
        let part = Film::part([200, 100], Planes::default(), Shard::new(1, 5).unwrap()).unwrap();
        let sums: usize = part.tiles.iter().map(|tile| tile.sums.len()).sum();
        let whole = Film::new([200, 100]).unwrap();
        let of_whole: usize = whole.tiles.iter().map(|tile| tile.sums.len()).sum();
        assert!(sums * 4 < of_whole && part.pixels() * 4 < whole.pixels());
        assert_eq!(whole.pixels(), 200 * 100);
        let elsewhere = (0..part.tiles()).find(|tile| !part.held().contains(tile)).unwrap();
        let [x, y, ..] = part.bounds(elsewhere);
        assert_eq!((part.pixel(x, y).hits, part.count(x, y), part.xyz(x, y)), (0, 0, [0.0; 3]));
        assert_eq!((part.variance(x, y), part.noise()), (0.0, None));
    }

    #[test]
    fn films_of_other_pictures_are_no_parts() {
        let mut film = Film::new([64, 32]).unwrap();
        let part = |size, compositing| {
            let planes = Planes { compositing, ..Planes::default() };
            Film::part(size, planes, Shard::new(0, 2).unwrap()).unwrap()
        };
        film.join(part([64, 32], false)).unwrap();
        for other in [part([32, 64], false), part([64, 32], true)] {
            assert!(film.join(other).unwrap_err().to_string().contains("is no part of this picture"));
        }
    }
}
