//! A film as bytes: to go on with a picture later, or to join what several processes rendered of it, to the same bits as without.
//!
//! Layout, little-endian: `BARBFILM`, version (u32), width and height (u32), which part of how many the film holds (u32), 32 bytes that name the scene and its
//! settings; of each tile that it holds, row by row, its sample count, how many samples were left out and of the first of them
//! sample, column, row, and its object's index and 1 (0: none) (u32), the channels, alpha and weight of its pixels and of a border of one (f64), of each pixel
//! luminance, squares, normal, depth (f64), hits and identity (u32), and of eight runs of its samples the luminance (f32); where the film keeps them of each pixel the albedo's channels and its own (f64)
//! and of six shapes identity, object and hits (u32), and of each pixel with the border its radiance in each band (f64); and a BLAKE3
//! checksum of all before it. Channels are X, Y, Z of the human eye, and of other sensors eight, those that they lack 0.

use super::faults::{Fault, Faults};
use super::film::{Film, Pixel, RUNS, stride};
use super::planes::{COVERS, Compositing, Cover, Planes};
use super::response::lanes;
use crate::identity::{Hasher, Identify};
use crate::{Error, Result};

const MAGIC: &[u8; 8] = b"BARBFILM";
const VERSION: u32 = 7;
const TILE_HEAD: usize = 6 * 4;
const HEAD: usize = 8 + 5 * 4 + 32;
const PIXEL: usize = 6 * 8 + 2 * 4 + RUNS * 4;
const COVERED: usize = COVERS * 3 * 4;
const SUM: usize = 32;

/// Names a picture by all that decides its samples: the scene with what it names, the seed, the program's version, who sees the film,
/// and what it keeps.
#[must_use]
pub fn name(scene: &impl Identify, seed: u64, program: &str, planes: &Planes) -> [u8; 32] {
    let mut hasher = Hasher::new("picture");
    hasher.part("scene", scene).count("seed", seed).text("program", program);
    let Planes { sensor, compositing, spectral } = planes;
    if *compositing || !spectral.nm().is_empty() {
        hasher.count("compositing", u64::from(*compositing)).numbers("bands", spectral.nm());
    }
    if !sensor.is_human() {
        hasher.part("sensor", sensor);
    }
    hasher.finish()
}

/// Bytes of a checkpoint of a film.
#[must_use]
pub fn bytes(film: &Film) -> u64 {
    let planes = film.planes();
    let pixel = PIXEL + if planes.compositing { COVERED + 2 * lanes(&planes.sensor) * 8 } else { 0 };
    let sums = (stride(&planes.sensor) + planes.spectral.nm().len()) * 8;
    let tile = |&tile: &usize| {
        let [x0, y0, x1, y1] = film.bounds(tile).map(u64::from);
        let ([width, height], [pixel, sums]) = ([x1 - x0, y1 - y0], [pixel as u64, sums as u64]);
        TILE_HEAD as u64 + (width + 2) * (height + 2) * sums + width * height * pixel
    };
    (HEAD + SUM) as u64 + film.held().iter().map(tile).sum::<u64>()
}

/// The film as bytes.
#[must_use]
pub fn write(film: &Film, name: &[u8; 32]) -> Vec<u8> {
    let mut to = Vec::with_capacity(bytes(film) as usize);
    to.extend_from_slice(MAGIC);
    let ([width, height], [number, of]) = (film.size(), place(film));
    for word in [VERSION, width, height, number, of] {
        to.extend_from_slice(&word.to_le_bytes());
    }
    to.extend_from_slice(name);
    for tile in film.held().iter().map(|&tile| &film.tiles[tile]) {
        let Faults { count, first } = tile.faults;
        let place = first.map_or([0; 4], |Fault { pixel: [x, y], sample, object }| {
            [sample, x, y, object.map_or(0, |object| object + 1)]
        });
        let left_out = u32::try_from(count).unwrap_or(u32::MAX);
        for word in [tile.count, left_out].into_iter().chain(place) {
            to.extend_from_slice(&word.to_le_bytes());
        }
        for value in &tile.sums {
            to.extend_from_slice(&value.to_le_bytes());
        }
        for pixel in &tile.pixels {
            let Pixel { luminance, squares, normal, depth, hits, id, runs } = pixel;
            for value in [luminance, squares].into_iter().chain(normal).chain([depth]) {
                to.extend_from_slice(&value.to_le_bytes());
            }
            to.extend_from_slice(&hits.to_le_bytes());
            to.extend_from_slice(&id.to_le_bytes());
            for run in runs {
                to.extend_from_slice(&run.to_le_bytes());
            }
        }
        let lanes = lanes(&film.planes().sensor);
        let channels = tile.albedo.chunks_exact(lanes).zip(tile.own.chunks_exact(lanes));
        for (Compositing { covers }, (albedo, own)) in tile.compositing.iter().zip(channels) {
            for value in albedo.iter().chain(own) {
                to.extend_from_slice(&value.to_le_bytes());
            }
            for word in covers.iter().flat_map(|cover| [cover.id, cover.object, cover.hits]) {
                to.extend_from_slice(&word.to_le_bytes());
            }
        }
        for value in &tile.spectra {
            to.extend_from_slice(&value.to_le_bytes());
        }
    }
    let sum = blake3::hash(&to);
    to.extend_from_slice(sum.as_bytes());
    to
}

/// Which part of a picture a film holds, and of how many; shards are not over what 32 bits hold.
fn place(film: &Film) -> [u32; 2] {
    [film.shard().number() as u32, film.shard().of() as u32]
}

/// The film of a checkpoint. `film`: one of the same size, planes and part, which is filled.
///
/// # Errors
/// Not a checkpoint, damaged, of another version, size, part or picture.
pub fn read(bytes: &[u8], name: &[u8; 32], mut film: Film) -> Result<Film> {
    let refuse = |what: &str| Err(Error::input(format!("the checkpoint {what}")));
    if bytes.len() < HEAD + SUM || !bytes.starts_with(MAGIC) {
        return refuse("is not one of this program");
    }
    let (body, sum) = bytes.split_at(bytes.len() - SUM);
    if blake3::hash(body).as_bytes() != sum {
        return refuse("is damaged (its checksum differs)");
    }
    let mut words = Words(&body[MAGIC.len()..]);
    if words.count() != VERSION {
        return refuse("is of another version of this program");
    }
    if [words.count(), words.count()] != film.size() {
        return refuse("is of a picture of another size");
    }
    if [words.count(), words.count()] != place(&film) {
        return refuse("is of another part of the picture");
    }
    if words.take::<32>() != *name {
        return refuse(
            "is of another picture (scene, material, light, view, sensor or seed differ; of a part also samples, noise or instruction set)",
        );
    }
    if bytes.len() as u64 != self::bytes(&film) {
        return refuse("is damaged (its length is wrong)");
    }
    let lanes = lanes(&film.planes().sensor);
    for number in film.held().to_vec() {
        let tile = &mut film.tiles[number];
        tile.count = words.count();
        let left_out = words.count();
        let [sample, x, y, object] = std::array::from_fn(|_| words.count());
        let fault = Fault { pixel: [x, y], sample, object: object.checked_sub(1) };
        tile.faults = Faults { count: left_out.into(), first: (left_out > 0).then_some(fault) };
        for value in &mut tile.sums {
            *value = words.number();
        }
        for pixel in &mut tile.pixels {
            *pixel = Pixel {
                luminance: words.number(),
                squares: words.number(),
                normal: std::array::from_fn(|_| words.number()),
                depth: words.number(),
                hits: words.count(),
                id: words.count(),
                runs: std::array::from_fn(|_| f32::from_le_bytes(words.take())),
            };
        }
        let channels = tile.albedo.chunks_exact_mut(lanes).zip(tile.own.chunks_exact_mut(lanes));
        for (compositing, (albedo, own)) in tile.compositing.iter_mut().zip(channels) {
            albedo.iter_mut().chain(own).for_each(|value| *value = words.number());
            let mut cover = || Cover { id: words.count(), object: words.count(), hits: words.count() };
            *compositing = Compositing { covers: std::array::from_fn(|_| cover()) };
        }
        for value in &mut tile.spectra {
            *value = words.number();
        }
    }
    Ok(film)
}

/// Takes words off the front; past the end there are zeros (lengths are checked before).
struct Words<'a>(&'a [u8]);

impl Words<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        if let Some((front, rest)) = self.0.split_at_checked(N) {
            bytes.copy_from_slice(front);
            self.0 = rest;
        }
        bytes
    }

    fn count(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Shard;
    use crate::render::planes::Bands;
    use crate::spectrum::dense::DenseSpectrum;
    use crate::spectrum::sensor::{Band, Curve, Sensor};

    fn planes(sensor: Sensor) -> Planes {
        let spectral = Bands::new(&[450.0, 550.0], sensor.band()).unwrap();
        Planes { sensor, compositing: true, spectral }
    }

    fn cone() -> Sensor {
        let channel = Curve { name: "cone".to_owned(), response: DenseSpectrum::new(|_| 1.0) };
        Sensor::new("one cone", Band::new(300, 700).unwrap(), vec![channel]).unwrap()
    }

    fn empty(sensor: Sensor) -> Film {
        Film::with([40, 10], planes(sensor)).unwrap()
    }

    fn film(sensor: Sensor) -> Film {
        let mut film = empty(sensor);
        film.tiles[1].count = 8;
        film.tiles[1].faults.add(Fault { pixel: [33, 2], sample: 7, object: Some(0) });
        film.tiles[1].sums[35..40].copy_from_slice(&[0.1, 0.2, 0.3, 0.4, 0.5]);
        film.tiles[0].albedo[27..30].copy_from_slice(&[0.6, 0.5, 0.4]);
        film.tiles[0].own[27..30].copy_from_slice(&[0.3, 0.2, 0.1]);
        film.tiles[0].compositing[9].covers[2] = Cover { id: 5, object: 2, hits: 4 };
        film.tiles[1].spectra[11] = 0.125;
        film.tiles[0].pixels[5] =
            Pixel { luminance: 0.2, squares: 0.7, hits: 3, id: 9, runs: [0.5; RUNS], ..Pixel::default() };
        film
    }

    #[test]
    fn a_checkpoint_gives_the_same_film_back() {
        for sensor in [Sensor::human(), cone()] {
            let bytes = write(&film(sensor.clone()), &[1; 32]);
            assert_eq!(bytes.len() as u64, self::bytes(&empty(sensor.clone())));
            assert_eq!(read(&bytes, &[1; 32], empty(sensor.clone())).unwrap(), film(sensor));
        }
    }

    /// Two tiles in two parts, and one part more than there are tiles.
    #[test]
    fn parts_have_their_own_tiles_and_together_make_the_film() {
        let whole = film(cone());
        for of in 1..4 {
            let part =
                |number| Film::part([40, 10], planes(cone()), Shard::new(number, of).unwrap()).unwrap();
            let mut joined = empty(cone());
            for number in 0..of {
                let mut own = part(number);
                for tile in own.held().to_vec() {
                    own.tiles[tile] = whole.tiles[tile].clone();
                }
                let bytes = write(&own, &[1; 32]);
                assert_eq!(bytes.len() as u64, self::bytes(&own));
                let read = |film| read(&bytes, &[1; 32], film);
                assert_eq!(read(part(number)).unwrap(), own);
                if of > 1 {
                    let other = part((number + 1) % of);
                    assert!(read(other).unwrap_err().to_string().contains("another part"));
                }
                joined.join(own).unwrap();
            }
            // Tiles without samples bring none.
            assert!(joined.count(33, 2) == 8 && joined.pixel(33, 2) == whole.pixel(33, 2));
            assert_eq!(joined.faults(), whole.faults());
            assert_eq!(joined.tiles[1], whole.tiles[1]);
        }
    }

    #[test]
    fn damaged_and_foreign_checkpoints_are_refused() {
        let bytes = write(&film(Sensor::human()), &[1; 32]);
        let message = |bytes: &[u8], n: u8, size| {
            let film = Film::with(size, planes(Sensor::human())).unwrap();
            read(bytes, &[n; 32], film).unwrap_err().to_string()
        };
        assert!(message(&bytes, 2, [40, 10]).contains("another picture"));
        assert!(message(&bytes, 1, [40, 11]).contains("another size"));
        assert!(message(b"hello", 1, [40, 10]).contains("not one of this program"));
        let mut flipped = bytes.clone();
        flipped[100] ^= 1;
        assert!(message(&flipped, 1, [40, 10]).contains("checksum"));
        assert!(message(&bytes[..bytes.len() - 1], 1, [40, 10]).contains("checksum"));
    }
}
