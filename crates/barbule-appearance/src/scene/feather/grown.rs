//! What grew: the parts of a feather, apart by what they are made of.

use super::SheetBarbs;
use crate::bsdf::Mark;
use crate::scene::geometry::Geometry;

/// The grown parts, apart by what they are made of.
#[derive(Debug, Clone, Default)]
pub struct Grown {
    /// The shaft.
    pub shaft: Geometry,
    /// The rami of the closed vane's barbs.
    pub rami: Geometry,
    /// The same rami as round fibres, for those who see hair in them: where they have pigment, and where not.
    pub fibres: [Geometry; 2],
    /// All barbs as round fibres, those of the downy part too.
    pub barbs: Geometry,
    /// The barbules towards the feather's tip, and the others: ribbons, or stretches of rows that stand in many places.
    pub barbules: [Geometry; 2],
    /// Barbules without pigment.
    pub pale: Geometry,
    /// Rami and barbules of the closed vane that lie in a zone, from zone 1; all others lie in none.
    pub zones: Vec<ZoneParts>,
    /// Barbs, as round fibres, and barbules of the downy part.
    pub downy: Geometry,
    /// In place of rami and barbules: ribbons about the barbs left and right of the shaft.
    pub envelopes: [Geometry; 2],
    /// The same of the downy part.
    pub downy_envelopes: [Geometry; 2],
    /// In place of them all: sheets through the barbs left and right of the shaft.
    pub sheets: [Geometry; 2],
    /// What the barbs of the sheets measure; nothing where there is no sheet.
    pub sheet_barbs: [Option<SheetBarbs>; 2],
}

/// Parts of the closed vane that lie in one zone.
#[derive(Debug, Clone, Default)]
pub struct ZoneParts {
    /// Rami.
    pub rami: Geometry,
    /// The same rami as round fibres, where they have pigment.
    pub fibres: Geometry,
    /// The barbules towards the feather's tip, and the others.
    pub barbules: [Geometry; 2],
}

impl Grown {
    /// Nothing yet, of so many zones beside the feather's own.
    pub(super) fn new(zones: usize) -> Self {
        Self { zones: vec![ZoneParts::default(); zones], ..Self::default() }
    }

    /// Where rami of a zone belong.
    pub(super) fn rami_at(&mut self, zone: usize) -> &mut Geometry {
        match zone {
            0 => &mut self.rami,
            zone => &mut self.zones[zone - 1].rami,
        }
    }

    /// Where rami as fibres belong.
    pub(super) fn fibres_at(&mut self, mark: Mark) -> &mut Geometry {
        match mark {
            Mark::Zone(0) => &mut self.fibres[0],
            Mark::Zone(zone) => &mut self.zones[zone - 1].fibres,
            Mark::Pale => &mut self.fibres[1],
        }
    }

    /// Where the barbules of one side of a barb belong.
    pub(super) fn barbules_at(&mut self, is_loose: bool, which: usize, mark: Mark) -> &mut Geometry {
        match mark {
            Mark::Pale => &mut self.pale,
            Mark::Zone(_) if is_loose => &mut self.downy,
            Mark::Zone(0) => &mut self.barbules[which],
            Mark::Zone(zone) => &mut self.zones[zone - 1].barbules[which],
        }
    }

    /// All rows of barbules, those of the downy part last.
    fn rows(&self) -> impl Iterator<Item = &Geometry> {
        let of_zones = self.zones.iter().flat_map(|zone| &zone.barbules);
        self.barbules.iter().chain(of_zones).chain([&self.pale, &self.downy])
    }

    /// The barbules of all rows, those of the downy part last.
    #[must_use]
    pub fn all_barbules(&self) -> Geometry {
        let mut all = Geometry::default();
        for row in self.rows() {
            row.ribbons.iter().for_each(|ribbon| all.add_ribbon(row.nodes_of(ribbon), *ribbon));
        }
        all
    }

    /// How many barbs and barbules there are.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let of = |rows: &[&Geometry]| rows.iter().map(|row| row.ribbon_count()).sum::<usize>();
        let [left, right] = &self.envelopes;
        let [downy_left, downy_right] = &self.downy_envelopes;
        Counts {
            barbs: self.barbs.curves.len()
                + of(&[left, right, downy_left, downy_right])
                + self.sheet_barbs.iter().flatten().map(|barbs| barbs.count).sum::<usize>(),
            barbules: self.rows().map(Geometry::ribbon_count).sum(),
        }
    }
}

/// How many of each part were grown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Barbs.
    pub barbs: usize,
    /// Barbules.
    pub barbules: usize,
}
