//! The parts of a described feather: what is grown, and what it is made of.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::detail::ViewModel;
use super::dress::{BarbuleDress, FeatherObject, RamusDress};
use super::surfaces::FibreDescription;
use crate::bsdf::{
    BarbModel, BarbSurface, Hair, Keratin, Pattern, Ramus, Row, Substance, Surface,
};
use crate::math::rng::hash;
use crate::scene::Object;
use crate::scene::feather::{BarbuleShape, Counts, Grown, Level, SheetBarbs, Swatch, tip_side};
use crate::scene::geometry::{Geometry, Place};
use crate::scene::window::{Layer, Window};
use crate::{Error, Result};

/// Between two feathers side by side, over the width of one.
const GAP: f64 = 0.12;

impl FeatherObject {
    /// How finely it is made in a picture that is so wide on it, mm.
    #[must_use]
    pub fn level(&self, width_mm: f64) -> Level {
        self.detail.level_of(&self.feather, self.window, width_mm)
    }

    /// Shaft, rami, barbules; `width_mm`: of the picture, on the feather.
    pub(super) fn parts(&self, width_mm: f64, seed: u64) -> Result<(Vec<Object>, Counts)> {
        let level = self.level(width_mm);
        let grown = self.feather.grow(self.window, level, seed, hash(seed, &[1]))?;
        let counts = grown.counts();
        let substances = Substances::new(self)?;
        let shaft = (grown.shaft.clone(), Surface::Keratin(self.dress.shaft.build()?));
        let parts = match level {
            Level::Barbules | Level::Barbs => [vec![shaft], substances.one_by_one(grown)].concat(),
            Level::Vane => [vec![shaft], substances.sheets(&grown, seed)?].concat(),
            Level::Envelopes => match self.detail.view_model {
                ViewModel::Fibre => [vec![shaft], substances.looked_up(&grown, BarbModel::Fibre)].concat(),
                ViewModel::Grown | ViewModel::Substructure => {
                    [vec![shaft], substances.looked_up(&grown, BarbModel::Substructure)].concat()
                }
                ViewModel::Both => {
                    let shift = 0.5 * (1.0 + GAP) * width(&grown.envelopes);
                    let mut parts = Vec::new();
                    for (model, side) in [(BarbModel::Fibre, -1.0), (BarbModel::Substructure, 1.0)] {
                        let all = [vec![shaft.clone()], substances.looked_up(&grown, model)].concat();
                        let moved = all
                            .into_iter()
                            .map(|(geometry, surface)| (moved(geometry, side * shift), surface));
                        parts.extend(moved);
                    }
                    parts
                }
            },
        };
        let objects = parts.into_iter().map(|(geometry, surface)| Object { geometry, surface });
        Ok((objects.collect(), counts))
    }

    /// Names of the parts, in their order.
    pub(super) fn part_names(&self, width_mm: f64) -> Vec<&'static str> {
        let barbs = ["shaft", "left barbs", "right barbs", "left down", "right down"];
        match (self.level(width_mm), self.detail.view_model) {
            (Level::Barbules | Level::Barbs, _) => {
                let rows = ["distal barbules", "proximal barbules", "pale barbules"];
                [&["shaft", "barbs", "pale barbs"][..], &rows, &["down"]].concat()
            }
            (Level::Vane, _) => vec!["shaft", "left vane", "right vane", "left down", "right down"],
            (Level::Envelopes, ViewModel::Both) => [barbs, barbs].concat(),
            (Level::Envelopes, _) => barbs.to_vec(),
        }
    }
}

fn width(envelopes: &[Geometry; 2]) -> f64 {
    let all = envelopes.iter().filter_map(Geometry::bounds);
    let both = all.reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]);
    both.map_or(0.0, |[low, high]| f64::from(high.x - low.x))
}

fn moved(geometry: Geometry, right_mm: f64) -> Geometry {
    let place = Place { scale: 1.0, turn: DMat3::IDENTITY, shift: DVec3::X * right_mm, id: 0 };
    Geometry { places: vec![place], ..geometry }
}

/// What a feather's parts are made of.
struct Substances<'a> {
    of: &'a FeatherObject,
    ramus: Substance,
    /// Towards the feather's tip, and the others.
    barbules: [Substance; 2],
    pale: Keratin,
    /// Rami and barbules without pigment, as they stand there one by one.
    pale_ramus: Surface,
    pale_barbule: Surface,
    /// Barbs and barbules of the downy part.
    down: Hair,
}

type Part = (Geometry, Surface);

impl<'a> Substances<'a> {
    fn new(of: &'a FeatherObject) -> Result<Self> {
        let (feather, dress) = (&of.feather, &of.dress);
        let barbule = |dress: &BarbuleDress, shape: &BarbuleShape| match dress {
            BarbuleDress::Hair(fibre) => Ok::<_, Error>(Substance::Fibre(fibre.build()?)),
            BarbuleDress::Barbule(of) => Ok(Substance::Plate(of.barbules(shape.cells(&feather.disorder))?)),
        };
        let ramus = match &dress.ramus {
            RamusDress::Hair(fibre) => Substance::Fibre(fibre.build()?),
            RamusDress::Keratin(keratin) => Substance::Keratin(keratin.build()?),
        };
        let barbules =
            [barbule(&dress.distal, &feather.distal)?, barbule(&dress.proximal, &feather.proximal)?];
        let pale = dress.pale.build()?;
        let pale_fibre = |fibre: &FibreDescription| {
            let [eumelanin, pheomelanin] =
                [fibre.eumelanin, fibre.pheomelanin].map(|pigment| pigment * feather.pattern.pale_pigment);
            Ok::<_, Error>(Surface::Hair(FibreDescription { eumelanin, pheomelanin, ..*fibre }.build()?))
        };
        let pale_ramus = match &dress.ramus {
            RamusDress::Hair(fibre) => pale_fibre(fibre)?,
            RamusDress::Keratin(_) => Surface::Keratin(pale.clone()),
        };
        let pale_barbule = match (&dress.distal, &dress.proximal) {
            (BarbuleDress::Hair(fibre), _) | (_, BarbuleDress::Hair(fibre)) => pale_fibre(fibre)?,
            _ => Surface::Keratin(pale.clone()),
        };
        Ok(Self { of, ramus, barbules, pale, pale_ramus, pale_barbule, down: dress.down.build()? })
    }

    /// Rami and barbules as they were grown.
    fn one_by_one(&self, grown: Grown) -> Vec<Part> {
        let [dark, pale] = grown.fibres;
        let rami = match &self.ramus {
            Substance::Fibre(_) => dark,
            Substance::Keratin(_) | Substance::Plate(_) => grown.rami,
        };
        let surface = |substance: &Substance| match substance {
            Substance::Fibre(hair) => Surface::Hair(hair.clone()),
            Substance::Keratin(keratin) => Surface::Keratin(keratin.clone()),
            Substance::Plate(plate) => Surface::Barbule(plate.clone()),
        };
        let row = |row: Geometry, surface: Surface| {
            (if let Surface::Hair(_) = surface { row.ribbons_as_curves() } else { row }, surface)
        };
        let pale_rami = if let Substance::Fibre(_) = self.ramus { pale } else { Geometry::default() };
        let [distal, proximal] = grown.barbules;
        vec![
            (rami, surface(&self.ramus)),
            (pale_rami, self.pale_ramus.clone()),
            row(distal, surface(&self.barbules[0])),
            row(proximal, surface(&self.barbules[1])),
            row(grown.pale, self.pale_barbule.clone()),
            row(grown.downy, Surface::Hair(self.down.clone())),
        ]
    }

    /// A vane's swatch; without pigment, if it is pale.
    fn layer(&self, swatch: Swatch, is_pale: bool) -> Layer {
        let Swatch { grown, half_width_mm, along_mm } = swatch;
        let mut parts = self.one_by_one(grown);
        if is_pale {
            parts[0].1 = self.pale_ramus.clone();
            parts[2].1 = self.pale_barbule.clone();
            parts[3].1 = self.pale_barbule.clone();
        }
        let objects = parts.into_iter().map(|(geometry, surface)| Object { geometry, surface });
        Layer { objects: objects.collect(), across_mm: [-half_width_mm, half_width_mm], along_mm }
    }

    /// The barbs left and right of the shaft, those of the downy part last.
    fn looked_up(&self, grown: &Grown, model: BarbModel) -> Vec<Part> {
        let feather = &self.of.feather;
        let row = |shape: &BarbuleShape| shape.row(&feather.disorder);
        let rows = [&feather.distal, &feather.proximal].map(row);
        let [distal, proximal] = self.barbules.clone();
        let vane = Barbs {
            ramus: Ramus {
                substance: match (model, &distal) {
                    // A barb that is one fibre looks as its barbules would.
                    (BarbModel::Fibre, Substance::Fibre(_)) => distal.clone(),
                    _ => self.ramus.clone(),
                },
                half_width: 0.5e-3 * feather.barbs.width_um,
                height: feather.barbs.height,
            },
            rows: [(rows[0], distal), (rows[1], proximal)],
            pattern: feather.pattern.pattern(),
        };
        let down = Substance::Fibre(self.down.clone());
        let barbule = (row(&feather.downy.barbules()), down.clone());
        let half_width = 0.5e-3 * feather.downy.ramus_width_um;
        let ramus = Ramus { substance: down, half_width, height: 1.0 };
        let downy = Barbs { ramus, rows: [barbule.clone(), barbule], pattern: None };
        // Down is nothing like one fibre as wide as its barbules reach.
        let sides =
            [(model, &vane, &grown.envelopes), (BarbModel::Substructure, &downy, &grown.downy_envelopes)];
        let parts = sides.into_iter().flat_map(|(model, barbs, envelopes)| {
            envelopes.iter().zip([-1.0, 1.0]).map(move |(geometry, barb_side)| {
                let Barbs { ramus, rows, pattern } = barbs.clone();
                let tip = tip_side(barb_side);
                let barb = BarbSurface::new(model, ramus, rows, tip, pattern, self.pale.clone());
                (geometry.clone(), Surface::Barb(Box::new(barb)))
            })
        });
        parts.collect()
    }
}

impl Substances<'_> {
    /// The vanes left and right of the shaft, then the barbs of the downy part.
    fn sheets(&self, grown: &Grown, seed: u64) -> Result<Vec<Part>> {
        let feather = &self.of.feather;
        let window = |barb_side: f64, barbs: SheetBarbs| {
            let swatch = || feather.swatch(barb_side, &barbs, seed);
            let pale = match feather.pattern.pattern() {
                Some(pattern) => Some((pattern, self.layer(swatch()?, true))),
                None => None,
            };
            Ok::<_, Error>(Arc::new(Window { layer: self.layer(swatch()?, false), pale }))
        };
        let sheets = grown.sheets.iter().zip(grown.sheet_barbs).zip([-1.0, 1.0]);
        let vanes = sheets.map(|((geometry, of_sheet), barb_side)| {
            let window = of_sheet.map(|of_sheet| window(barb_side, of_sheet)).transpose()?;
            // What is met is the window's; the sheet has no light of its own.
            Ok((Geometry { window, ..geometry.clone() }, self.pale_ramus.clone()))
        });
        let down = self.looked_up(grown, BarbModel::Substructure).into_iter().skip(2);
        vanes.chain(down.map(Ok)).collect()
    }
}

/// What barbs of one kind are made of.
#[derive(Clone)]
struct Barbs {
    ramus: Ramus,
    rows: [(Row, Substance); 2],
    pattern: Option<Pattern>,
}
