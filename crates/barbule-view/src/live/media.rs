//! What media look like in pictures of sections: the shades of figures, and hatches beside them.
//!
//! Air, keratin and melanin differ in lightness; every other medium is hatched too, so that nobody needs to see hues.

use barbule::figures::shade;
use barbule::structure::{Medium, Section, Substance};

/// Media that a legend names; further ones are drawn plain.
const MOST_MEDIA: usize = 24;
/// Hatches repeat after so many pixels, and are so many wide.
const HATCH_PX: usize = 8;
const HATCH_WIDE_PX: usize = 2;
/// Shades that are lighter than this in the mean are hatched by darker lines.
const LIGHT: u32 = 100;

/// How a medium is hatched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hatch {
    /// Not at all.
    Plain,
    /// By lines that rise to the right.
    Rising,
    /// By lines that fall to the right.
    Falling,
    /// By level lines.
    Level,
    /// By dots.
    Dotted,
}

impl Hatch {
    /// The hatches of media that are not told by lightness alone, in the order in which they are given out.
    const ORDER: [Self; 4] = [Self::Rising, Self::Falling, Self::Level, Self::Dotted];

    /// Whether it marks a pixel.
    #[must_use]
    pub fn marks(self, column: usize, row: usize) -> bool {
        let within = |k: usize| k % HATCH_PX < HATCH_WIDE_PX;
        match self {
            Self::Plain => false,
            Self::Rising => within(column + row),
            Self::Falling => within(column + HATCH_PX - row % HATCH_PX),
            Self::Level => within(row),
            Self::Dotted => within(column) && within(row),
        }
    }
}

/// A medium in a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its words.
    pub label: String,
    /// sRGB where a mixture has least of its second medium, and where it has most.
    pub shades: [[u8; 3]; 2],
    /// How it is hatched.
    pub hatch: Hatch,
    /// Whether the lines of its hatching are darker than its shade, rather than lighter.
    pub dark_lines: bool,
}

/// What media look like.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Legend {
    /// Every medium once.
    pub entries: Vec<Entry>,
    media: Vec<Medium>,
}

impl Legend {
    /// The media of sections, in the order in which they first come; the same medium looks the same in all of them.
    pub fn of<'a>(sections: impl IntoIterator<Item = &'a Section>) -> Self {
        let mut legend = Self::default();
        for section in sections {
            section.all_media().for_each(|medium| legend.add(medium));
            let rods = section.crystal.iter().flat_map(|crystal| &crystal.lattice.rods);
            for circle in rods.flat_map(|rod| &rod.circles) {
                legend.add(&Medium::Pure(circle.medium.clone()));
            }
        }
        legend
    }

    fn add(&mut self, medium: &Medium) {
        if self.media.len() >= MOST_MEDIA || self.place(medium).is_some() {
            return;
        }
        let hatched = self.entries.iter().filter(|entry| entry.hatch != Hatch::Plain).count();
        let hatch = if is_told_by_lightness(medium) {
            Hatch::Plain
        } else {
            Hatch::ORDER[hatched % Hatch::ORDER.len()]
        };
        let (label, shades) = described(medium);
        if self.entries.iter().any(|entry| entry.label == label) {
            return;
        }
        let mean = shades.iter().flatten().map(|channel| u32::from(*channel)).sum::<u32>() / 6;
        self.entries.push(Entry { label, shades, hatch, dark_lines: mean > LIGHT });
        self.media.push(medium.clone());
    }

    /// Which entry a medium has: mixtures that read alike share one.
    fn place(&self, medium: &Medium) -> Option<usize> {
        let own = self.media.iter().position(|known| known == medium);
        own.or_else(|| {
            let (label, _) = described(medium);
            self.entries.iter().position(|entry| entry.label == label)
        })
    }

    /// How a medium is hatched, and whether by darker lines.
    pub(super) fn hatch(&self, medium: &Medium) -> (Hatch, bool) {
        let entry = self.place(medium).map(|place| &self.entries[place]);
        entry.map_or((Hatch::Plain, true), |entry| (entry.hatch, entry.dark_lines))
    }
}

fn is_told_by_lightness(medium: &Medium) -> bool {
    let is_grey = |name: &str| ["air", "keratin", "melanin"].contains(&name);
    matches!(medium, Medium::Pure(Substance::Named(name)) if is_grey(name))
}

/// A medium's words, and its shades where a mixture has least and most of its second medium.
fn described(medium: &Medium) -> (String, [[u8; 3]; 2]) {
    match medium {
        Medium::Pure(substance) => (substance.label(), [shade(substance); 2]),
        Medium::Mixture { first, second, fraction, .. } => {
            let low = fraction.iter().copied().fold(1.0, f64::min);
            let high = fraction.iter().copied().fold(0.0, f64::max);
            let label = format!(
                "{} with {:.0} to {:.0} % {}",
                first.label(),
                100.0 * low,
                100.0 * high,
                second.label()
            );
            (label, [low, high].map(|part| blend(shade(first), shade(second), part)))
        }
    }
}

/// A shade between two.
pub(super) fn blend(a: [u8; 3], b: [u8; 3], part: f64) -> [u8; 3] {
    std::array::from_fn(|k| (f64::from(a[k]) * (1.0 - part) + f64::from(b[k]) * part).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hatches_mark_some_pixels_of_each_patch() {
        for hatch in [Hatch::Rising, Hatch::Falling, Hatch::Level, Hatch::Dotted] {
            let marked =
                (0..16).flat_map(|c| (0..16).map(move |r| (c, r))).filter(|(c, r)| hatch.marks(*c, *r));
            let count = marked.count();
            assert!((16..=64).contains(&count), "{hatch:?} {count}");
        }
    }
}
