//! Rods: round regions of the darkest class, with what is inside them.

use super::field::Grey;
use super::outline::{Outline, around, blur_across};
use super::regions::{Map, Region};

/// A rod.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Its middle, px.
    pub middle: [f64; 2],
    /// Outer diameter, that of the disc with the same area, px.
    pub diameter: f64,
    /// Diameter of the air in it, 0 for none, px.
    pub hollow: f64,
    /// Its outline, the air's behind it.
    pub outlines: Vec<Outline>,
    /// Whether it touches others and was parted from them.
    pub is_parted: bool,
}

/// What rods are looked for with.
pub(super) struct Search<'a> {
    pub(super) grey: &'a Grey,
    pub(super) map: &'a Map,
    /// Grey levels from bright to dark.
    pub(super) levels: &'a [f64],
    /// The level between two classes.
    pub(super) between: &'a dyn Fn(usize, usize) -> f64,
    /// First guess of the blur, px.
    pub(super) blur: f64,
}

/// Rods less round than this are none; noise makes discs of ten pixels about 0.9.
const LEAST_ROUND: f64 = 0.7;

impl Search<'_> {
    fn darkest(&self) -> usize {
        self.levels.len() - 1
    }

    /// The dark regions that are whole.
    fn whole(&self) -> impl Iterator<Item = (usize, &Region)> {
        let dark = self.darkest();
        self.map.regions.iter().enumerate().filter(move |(_, r)| r.class == dark && !r.touches_border())
    }

    /// Outlines of a region without what is in it, and of the brightest regions inside it, before anything is corrected.
    pub(super) fn outlines(&self, index: usize) -> Option<(Outline, Vec<Outline>)> {
        let region = &self.map.regions[index];
        let inside = self.map.inside(index);
        let outer = region.neighbours.iter().find(|(other, _)| !inside.contains(other))?.0;
        let class = self.map.regions[outer].class;
        let level = (self.between)(class, region.class);
        let is_bright = region.class < class;
        let is_inside = |label: usize| label == index || inside.contains(&label);
        let outline = around(self.grey, self.map, region.bounds, level, is_bright, &is_inside)?;
        let holes = inside
            .iter()
            .filter(|hole| region.neighbours.iter().any(|(other, _)| other == *hole))
            .filter_map(|hole| {
                let inner = &self.map.regions[*hole];
                let level = (self.between)(inner.class, region.class);
                let held = self.map.inside(*hole);
                let is_inside = |label: usize| label == *hole || held.contains(&label);
                around(self.grey, self.map, inner.bounds, level, inner.class < region.class, &is_inside)
            })
            .collect();
        Some((outline, holes))
    }

    /// All rods that lie wholly in the picture, those that touch parted, what is around them, and the blur of their edges.
    pub(super) fn rods(&self) -> Found {
        let traced: Vec<_> =
            self.whole().filter_map(|(index, _)| Some((index, self.outlines(index)?))).collect();
        let is_round = |outline: &Outline| outline.roundness() > LEAST_ROUND;
        let mut areas: Vec<f64> = traced
            .iter()
            .filter(|(_, (o, _))| is_round(o))
            .map(|(_, (o, _))| o.area_and_middle().0)
            .collect();
        let usual = super::field::part(&mut areas, 0.5);
        let single: Vec<_> = traced
            .iter()
            .filter(|(_, (o, _))| is_round(o) && o.area_and_middle().0 < MOST_LARGE * usual)
            .collect();
        let outlines: Vec<&Outline> = single.iter().map(|(_, (outline, _))| outline).collect();
        let around = self.class_around();
        let greys = [self.levels[self.darkest()], self.levels[around]];
        let blur = blur_across(self.grey, &outlines, greys, 1.2 * self.blur).unwrap_or(self.blur);
        let mut rods: Vec<Rod> = single
            .iter()
            .map(|(_, (outline, holes))| {
                let outline = outline.clone().unblurred(blur);
                let hole = holes.iter().max_by(|a, b| a.diameter().total_cmp(&b.diameter()));
                let hole = hole.map(|hole| hole.clone().unblurred(blur));
                Rod {
                    middle: outline.area_and_middle().1,
                    diameter: outline.diameter(),
                    hollow: hole.as_ref().map_or(0.0, Outline::diameter),
                    outlines: std::iter::once(outline).chain(hole).collect(),
                    is_parted: false,
                }
            })
            .collect();
        let is_single = |index: usize| single.iter().any(|(single, _)| *single == index);
        for (index, region) in self.map.regions.iter().enumerate() {
            if region.class == self.darkest() && region.area as f64 > usual && !is_single(index) {
                rods.extend(self.parted(index, blur));
            }
        }
        // From the top down and from left to right, whatever parted them.
        rods.sort_by(|a, b| a.middle[1].total_cmp(&b.middle[1]).then(a.middle[0].total_cmp(&b.middle[0])));
        Found { rods, blur, around: [around, self.class_inside(&traced)] }
    }

    /// The class in most of the regions' holes; the brightest if there are none.
    fn class_inside(&self, traced: &[(usize, (Outline, Vec<Outline>))]) -> usize {
        let mut inside = vec![0; self.levels.len()];
        for (index, _) in traced {
            for hole in self.map.inside(*index) {
                inside[self.map.regions[hole].class] += self.map.regions[hole].area;
            }
        }
        (0..self.darkest())
            .rev()
            .max_by_key(|class| inside[*class])
            .filter(|class| inside[*class] > 0)
            .unwrap_or(0)
    }

    /// The class that most dark regions border on from outside.
    fn class_around(&self) -> usize {
        let mut around = vec![0; self.levels.len()];
        for (index, region) in self.whole() {
            let inside = self.map.inside(index);
            for (other, sides) in region.neighbours.iter().filter(|(other, _)| !inside.contains(other)) {
                around[self.map.regions[*other].class] += sides;
            }
        }
        (0..self.darkest()).rev().max_by_key(|class| around[*class]).unwrap_or(0)
    }
}

/// Rods larger than this many times the usual area are several.
const MOST_LARGE: f64 = 1.6;

/// What a search found.
pub(super) struct Found {
    pub(super) rods: Vec<Rod>,
    pub(super) blur: f64,
    /// Classes around rods and in them.
    pub(super) around: [usize; 2],
}
