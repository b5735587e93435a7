//! A film as bytes: to go on with a picture later, to the same bits as without the break.
//!
//! Layout, little-endian: `BARBFILM`, version (u32), width and height (u32), 32 bytes that name the scene and its
//! settings, the sample counts of all tiles (u32), per pixel X, Y, Z, squares, normal, depth (f64), hits and identity
//! (u32), and a BLAKE3 checksum of all before it.

use super::film::{Film, Pixel};
use crate::identity::{Hasher, Identify};
use crate::{Error, Result};

const MAGIC: &[u8; 8] = b"BARBFILM";
const VERSION: u32 = 2;
const HEAD: usize = 8 + 3 * 4 + 32;
const PIXEL: usize = 8 * 8 + 2 * 4;
const SUM: usize = 32;

/// Names a picture by all that decides its samples: the scene, BLAKE3 of its material's bytes, the seed, the program's
/// version, and what names the sky's image (empty without one).
#[must_use]
pub fn name(scene: &impl Identify, material: &str, seed: u64, program: &str, sky: &str) -> [u8; 32] {
    let mut hasher = Hasher::new("picture");
    hasher.part("scene", scene).text("material", material).count("seed", seed);
    hasher.text("program", program).text("sky", sky).finish()
}

/// Bytes of a checkpoint of this size of picture, at most.
#[must_use]
pub fn largest(size: [u32; 2]) -> u64 {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    // There are never more tiles than pixels.
    (HEAD + SUM) as u64 + pixels * (PIXEL + 4) as u64
}

/// The film as bytes.
#[must_use]
pub fn write(film: &Film, name: &[u8; 32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + 4 * film.counts.len() + PIXEL * film.pixels.len() + SUM);
    bytes.extend_from_slice(MAGIC);
    for word in [VERSION, film.size()[0], film.size()[1]] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.extend_from_slice(name);
    for count in &film.counts {
        bytes.extend_from_slice(&count.to_le_bytes());
    }
    for pixel in &film.pixels {
        for value in pixel.xyz.into_iter().chain([pixel.squares]).chain(pixel.normal).chain([pixel.depth]) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        bytes.extend_from_slice(&pixel.hits.to_le_bytes());
        bytes.extend_from_slice(&pixel.id.to_le_bytes());
    }
    let sum = blake3::hash(&bytes);
    bytes.extend_from_slice(sum.as_bytes());
    bytes
}

/// The film of a checkpoint.
///
/// # Errors
/// Not a checkpoint, damaged, of another version, size or picture.
pub fn read(bytes: &[u8], name: &[u8; 32], size: [u32; 2]) -> Result<Film> {
    let refuse = |what: &str| Err(Error::input(format!("the checkpoint {what}; delete it to begin again")));
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
    if [words.count(), words.count()] != size {
        return refuse("is of a picture of another size");
    }
    if words.take::<32>() != *name {
        return refuse("is of another picture (scene, material, light, view or seed differ)");
    }
    let mut film = Film::new(size)?;
    if body.len() != HEAD + 4 * film.counts.len() + PIXEL * film.pixels.len() {
        return refuse("is damaged (its length is wrong)");
    }
    for count in &mut film.counts {
        *count = words.count();
    }
    for pixel in &mut film.pixels {
        *pixel = Pixel {
            xyz: std::array::from_fn(|_| words.number()),
            squares: words.number(),
            normal: std::array::from_fn(|_| words.number()),
            depth: words.number(),
            hits: words.count(),
            id: words.count(),
        };
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

    fn film() -> Film {
        let mut film = Film::new([40, 10]).unwrap();
        film.counts[1] = 8;
        film.pixels[5] = Pixel { xyz: [0.1, 0.2, 0.3], squares: 0.7, hits: 3, id: 9, ..Pixel::default() };
        film
    }

    #[test]
    fn a_checkpoint_gives_the_same_film_back() {
        let bytes = write(&film(), &[1; 32]);
        assert_eq!(read(&bytes, &[1; 32], [40, 10]).unwrap(), film());
    }

    #[test]
    fn damaged_and_foreign_checkpoints_are_refused() {
        let bytes = write(&film(), &[1; 32]);
        let message = |bytes: &[u8], n: u8, size| read(bytes, &[n; 32], size).unwrap_err().to_string();
        assert!(message(&bytes, 2, [40, 10]).contains("another picture"));
        assert!(message(&bytes, 1, [40, 11]).contains("another size"));
        assert!(message(b"hello", 1, [40, 10]).contains("not one of this program"));
        let mut flipped = bytes.clone();
        flipped[100] ^= 1;
        assert!(message(&flipped, 1, [40, 10]).contains("checksum"));
        assert!(message(&bytes[..bytes.len() - 1], 1, [40, 10]).contains("checksum"));
    }
}
