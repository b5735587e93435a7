//! Mattes by name, as compositors read them: which shapes cover a pixel, and how much of it.
//!
//! After the Cryptomatte specification 1.2.0 (Friedman and Jones 2015): a name's MurmurHash3, made a finite float, is its identity;
//! a pixel has pairs of identity and coverage, the largest first, two pairs a layer of four channels.

use std::collections::{BTreeMap, HashMap};

use super::film::Film;
use super::planes::Channel;
use super::planes::{COVERS, Cover};

/// Planes and what a reader must know of them.
pub struct Matte {
    /// R, G, B, A of each layer.
    pub planes: Vec<Channel<f32>>,
    /// Names and texts for the header of the file.
    pub attributes: Vec<(String, String)>,
}

/// Which of a shape's names a matte goes by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Each shape for itself: one barbule.
    Shape,
    /// All shapes of one object: all barbules.
    Object,
}

/// The matte of a film that keeps covers, in layers whose names begin with `layer`. `objects`: names of the scene's objects in
/// their order.
#[must_use]
pub fn matte(film: &Film, objects: &[String], by: By, layer: &str) -> Matte {
    let [width, height] = film.size();
    let name = |cover: &Cover| {
        let object = objects.get(cover.object as usize).map_or("object", String::as_str);
        match by {
            By::Shape => format!("{object}/{:08x}", cover.id),
            By::Object => object.to_owned(),
        }
    };
    let mut manifest: BTreeMap<String, u32> = BTreeMap::new();
    let mut channels = vec![Vec::new(); 2 * COVERS];
    let mut known = HashMap::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let count = f64::from(film.count(x, y).max(1));
        let mut covers = pairs(film, x, y, by);
        // Equal coverage: in the order in which the shapes were hit.
        covers.sort_by_key(|cover| std::cmp::Reverse(cover.hits));
        for slot in 0..COVERS {
            let pair = covers.get(slot).map_or([0.0; 2], |cover| {
                let shape = if by == By::Shape { cover.id } else { 0 };
                let identity = *known.entry((cover.object, shape)).or_insert_with(|| {
                    let name = name(cover);
                    let identity = hash(&name);
                    manifest.insert(name, identity);
                    identity
                });
                [f32::from_bits(identity), (f64::from(cover.hits) / count) as f32]
            });
            channels[2 * slot].push(pair[0]);
            channels[2 * slot + 1].push(pair[1]);
        }
    }
    let plane = |(index, values): (usize, Vec<f32>)| {
        let letter = ["R", "G", "B", "A"][index % 4];
        Channel { name: format!("{layer}{:02}.{letter}", index / 4), values }
    };
    let key = format!("cryptomatte/{}", &format!("{:08x}", murmur3(layer.as_bytes()))[..7]);
    let entries: Vec<String> =
        manifest.iter().map(|(name, identity)| format!("\"{name}\":\"{identity:08x}\"")).collect();
    let attributes = [
        ("name", layer.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", format!("{{{}}}", entries.join(","))),
    ];
    Matte {
        planes: channels.into_iter().enumerate().map(plane).collect(),
        attributes: attributes.into_iter().map(|(end, text)| (format!("{key}/{end}"), text)).collect(),
    }
}

/// What covers a pixel; by object, shapes of one object are one.
fn pairs(film: &Film, x: u32, y: u32, by: By) -> Vec<Cover> {
    let kept = film.compositing(x, y).map(|pixel| pixel.covers).unwrap_or_default();
    let mut covers: Vec<Cover> = Vec::with_capacity(COVERS);
    for cover in kept.into_iter().filter(|cover| cover.hits > 0) {
        match covers.iter_mut().find(|other| by == By::Object && other.object == cover.object) {
            Some(other) => other.hits += cover.hits,
            None => covers.push(cover),
        }
    }
    covers
}

/// A name's identity: its MurmurHash3 with an exponent that makes it a finite, normal float.
fn hash(name: &str) -> u32 {
    let bits = murmur3(name.as_bytes());
    let exponent = bits >> 23 & 255;
    if exponent == 0 || exponent == 255 { bits ^ 1 << 23 } else { bits }
}

/// MurmurHash3, x86, 32 bits, seed 0 (Appleby 2011, public domain).
fn murmur3(bytes: &[u8]) -> u32 {
    let scrambled = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = words.iter().fold(0_u32, |hash, word| {
        (hash ^ scrambled(u32::from_le_bytes(*word)))
            .rotate_left(13)
            .wrapping_mul(5)
            .wrapping_add(0xe654_6b64)
    });
    let last = rest.iter().rev().fold(0_u32, |word, byte| word << 8 | u32::from(*byte));
    hash ^= if rest.is_empty() { 0 } else { scrambled(last) };
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::planes::Planes;

    /// Values of the reference implementation.
    #[test]
    fn names_hash_as_elsewhere() {
        for (name, expected) in [("", 0), ("hello", 0x248b_fa47), ("hello, world", 0x149b_bb7f)] {
            assert_eq!(murmur3(name.as_bytes()), expected, "{name}");
        }
        // The specification's own example: the layer `uCryptoObject` has the key ae93ba3.
        assert!(format!("{:08x}", murmur3(b"uCryptoObject")).starts_with("ae93ba3"));
        assert!((0..2000).all(|i| f32::from_bits(hash(&i.to_string())).is_normal()));
    }

    #[test]
    fn pixels_have_their_largest_cover_first_and_every_name_is_listed() {
        let planes = Planes { compositing: true, ..Planes::default() };
        let mut film = Film::with([2, 1], planes).unwrap();
        film.tiles[0].count = 8;
        film.tiles[0].compositing[1].covers[..3].copy_from_slice(&[
            Cover { id: 7, object: 1, hits: 2 },
            Cover { id: 8, object: 0, hits: 3 },
            Cover { id: 9, object: 1, hits: 2 },
        ]);
        let names = ["shaft".to_owned(), "barbs".to_owned()];
        let shapes = matte(&film, &names, By::Shape, "CryptoObject");
        let value = |matte: &Matte, name: &str| {
            matte.planes.iter().find(|plane| plane.name == name).unwrap().values.clone()
        };
        assert_eq!(shapes.planes.len(), 12);
        assert_eq!(value(&shapes, "CryptoObject00.G"), [0.0, 0.375]);
        assert_eq!(value(&shapes, "CryptoObject00.R")[1].to_bits(), hash("shaft/00000008"));
        assert_eq!(value(&shapes, "CryptoObject00.A"), [0.0, 0.25]);
        let manifest = &shapes.attributes[3].1;
        let entry = format!("\"barbs/00000007\":\"{:08x}\"", hash("barbs/00000007"));
        assert!(manifest.contains(&entry) && manifest.matches(':').count() == 3, "{manifest}");
        let objects = matte(&film, &names, By::Object, "CryptoMaterial");
        assert_eq!(value(&objects, "CryptoMaterial00.G"), [0.0, 0.5]);
        assert_eq!(value(&objects, "CryptoMaterial00.R")[1].to_bits(), hash("barbs"));
    }
}
