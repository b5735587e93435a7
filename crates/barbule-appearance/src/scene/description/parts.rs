//! The parts of a described feather: what is grown, and what it is made of.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::detail::ViewModel;
use super::dress::{BarbuleDress, FeatherObject, RamusDress, Zone};
use super::surfaces::FibreDescription;
use crate::bsdf::{
    BarbModel, BarbSurface, Dress as BarbDress, Hair, Keratin, Mark, Markings, Ramus, Row, Substance,
    Surface, ZoneDress,
};
use crate::math::rng::hash;
use crate::progress::Progress;
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
    pub(super) fn parts(
        &self,
        width_mm: f64,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<(Vec<Object>, Counts)> {
        if let Some(coloured) = self.coloured()? {
            return coloured.parts(width_mm, seed, progress);
        }
        let level = self.level(width_mm);
        let zones = self.zone_plan()?.map(|plan| self.feather.zones(plan)).transpose()?;
        let names = (seed, hash(seed, &[1]));
        let grown = self.feather.grow_watched(self.window, level, zones.as_ref(), names, progress)?;
        let counts = grown.counts();
        let substances = Substances::new(self, self.feather.markings(zones.as_ref()))?;
        let shaft = (grown.shaft.clone(), Surface::Keratin(self.dress.shaft.build()?));
        let parts = match level {
            Level::Barbules | Level::Barbs => {
                [vec![shaft], substances.one_by_one(grown, Mark::Zone(0))].concat()
            }
            Level::Vane => [vec![shaft], substances.sheets(&grown, seed)?].concat(),
            Level::Envelopes => match self.detail.view_model {
                ViewModel::Fibre => [vec![shaft], substances.looked_up(&grown, BarbModel::Fibre)?].concat(),
                ViewModel::Grown | ViewModel::Substructure => {
                    [vec![shaft], substances.looked_up(&grown, BarbModel::Substructure)?].concat()
                }
                ViewModel::Both => {
                    let shift = 0.5 * (1.0 + GAP) * width(&grown.envelopes);
                    let mut parts = Vec::new();
                    for (model, side) in [(BarbModel::Fibre, -1.0), (BarbModel::Substructure, 1.0)] {
                        let all = [vec![shaft.clone()], substances.looked_up(&grown, model)?].concat();
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

    /// Names of the parts, in their order; what stands there one by one in a zone has its number.
    pub(super) fn part_names(&self, width_mm: f64) -> Vec<String> {
        let barbs = ["shaft", "left barbs", "right barbs", "left down", "right down"];
        let level = self.level(width_mm);
        let names = match (level, self.detail.view_model) {
            (Level::Barbules | Level::Barbs, _) => {
                let rows = ["distal barbules", "proximal barbules", "pale barbules"];
                [&["shaft", "barbs", "pale barbs"][..], &rows, &["down"]].concat()
            }
            (Level::Vane, _) => vec!["shaft", "left vane", "right vane", "left down", "right down"],
            (Level::Envelopes, ViewModel::Both) => [barbs, barbs].concat(),
            (Level::Envelopes, _) => barbs.to_vec(),
        };
        let zones = if matches!(level, Level::Barbules | Level::Barbs) { self.zone_count() } else { 0 };
        let parts = ["barbs", "distal barbules", "proximal barbules"];
        let zoned = (1..=zones).flat_map(|zone| parts.map(|part| format!("zone {zone} {part}")));
        names.into_iter().map(str::to_owned).chain(zoned).collect()
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
    markings: Markings,
    /// What its zones wear, from zone 1.
    zones: Vec<ZoneDress>,
    /// Rami and barbules without pigment, as they stand there one by one.
    pale_ramus: Surface,
    pale_barbule: Surface,
    /// Barbs and barbules of the downy part.
    down: Hair,
}

type Part = (Geometry, Surface);

impl<'a> Substances<'a> {
    fn new(of: &'a FeatherObject, markings: Markings) -> Result<Self> {
        let (feather, dress) = (&of.feather, &of.dress);
        let cover = feather.cover();
        let barbule = |dress: &BarbuleDress, shape: &BarbuleShape| match dress {
            BarbuleDress::Hair(fibre) => Ok::<_, Error>(Substance::Fibre(fibre.build_on(cover)?)),
            BarbuleDress::Barbule(of) => Ok(Substance::Plate(of.barbules(shape.cells(&feather.disorder))?)),
            BarbuleDress::Film(film) => Ok(Substance::Film(film.build()?)),
            BarbuleDress::Paint(paint) => Ok(Substance::Paint(paint.build()?)),
        };
        let of_ramus = |dress: &RamusDress| match dress {
            RamusDress::Hair(fibre) => Ok::<_, Error>(Substance::Fibre(fibre.build_on(cover)?)),
            RamusDress::Keratin(keratin) => Ok(Substance::Keratin(keratin.build()?)),
            RamusDress::Paint(paint) => Ok(Substance::Paint(paint.build()?)),
        };
        let ramus = of_ramus(&dress.ramus)?;
        let barbules =
            [barbule(&dress.distal, &feather.distal)?, barbule(&dress.proximal, &feather.proximal)?];
        let pale = dress.pale.build()?;
        let pale_fibre = |fibre: &FibreDescription| {
            let [eumelanin, pheomelanin] =
                [fibre.eumelanin, fibre.pheomelanin].map(|pigment| pigment * feather.pattern.pale_pigment);
            Ok::<_, Error>(Surface::Hair(
                FibreDescription { eumelanin, pheomelanin, ..*fibre }.build_on(cover)?,
            ))
        };
        let pale_ramus = match &dress.ramus {
            RamusDress::Hair(fibre) => pale_fibre(fibre)?,
            RamusDress::Keratin(_) | RamusDress::Paint(_) => Surface::Keratin(pale.clone()),
        };
        let pale_barbule = match (&dress.distal, &dress.proximal) {
            (BarbuleDress::Hair(fibre), _) | (_, BarbuleDress::Hair(fibre)) => pale_fibre(fibre)?,
            _ => Surface::Keratin(pale.clone()),
        };
        let zone = |zone: &Zone| {
            let side = |dress: &Option<BarbuleDress>, shape: &BarbuleShape| {
                dress.as_ref().map(|dress| barbule(dress, shape)).transpose()
            };
            Ok(ZoneDress {
                ramus: zone.ramus.as_ref().map(of_ramus).transpose()?,
                barbules: [side(&zone.distal, &feather.distal)?, side(&zone.proximal, &feather.proximal)?],
            })
        };
        let zones = of.zones.iter().map(zone).collect::<Result<Vec<_>>>()?;
        let down = dress.down.build()?;
        Ok(Self { of, ramus, barbules, pale, markings, zones, pale_ramus, pale_barbule, down })
    }

    /// What rami and either row of barbules are made of where something marks them, as they stand there one by one.
    fn surfaces(&self, mark: Mark) -> [Surface; 3] {
        let surface = |substance: &Substance| match substance {
            Substance::Fibre(hair) => Surface::Hair(hair.clone()),
            Substance::Keratin(keratin) => Surface::Keratin(keratin.clone()),
            Substance::Plate(plate) => Surface::Barbule(plate.clone()),
            Substance::Film(film) => Surface::ThinFilm(film.clone()),
            Substance::Paint(paint) => Surface::Lambertian(paint.clone()),
        };
        let [distal, proximal] = &self.barbules;
        let own = [&self.ramus, distal, proximal];
        match mark {
            Mark::Pale => [self.pale_ramus.clone(), self.pale_barbule.clone(), self.pale_barbule.clone()],
            Mark::Zone(0) => own.map(surface),
            Mark::Zone(zone) => {
                let ZoneDress { ramus, barbules: [distal, proximal] } = &self.zones[zone - 1];
                let worn = [ramus, distal, proximal];
                std::array::from_fn(|part| surface(worn[part].as_ref().unwrap_or(own[part])))
            }
        }
    }

    /// Rami and barbules as they were grown, those of zones last; what is marked by none is as where `mark` is.
    fn one_by_one(&self, grown: Grown, mark: Mark) -> Vec<Part> {
        let rami = |meshes: Geometry, fibres: Geometry, surface: Surface| {
            (if let Surface::Hair(_) = surface { fibres } else { meshes }, surface)
        };
        let row = |row: Geometry, surface: Surface| {
            (if let Surface::Hair(_) = surface { row.ribbons_as_curves() } else { row }, surface)
        };
        let [dark, pale] = grown.fibres;
        let [ramus, of_distal, of_proximal] = self.surfaces(mark);
        let [distal, proximal] = grown.barbules;
        let mut parts = vec![
            rami(grown.rami, dark, ramus),
            rami(Geometry::default(), pale, self.pale_ramus.clone()),
            row(distal, of_distal),
            row(proximal, of_proximal),
            row(grown.pale, self.pale_barbule.clone()),
            row(grown.downy, Surface::Hair(self.down.clone())),
        ];
        for (index, zone) in grown.zones.into_iter().enumerate() {
            let [ramus, of_distal, of_proximal] = self.surfaces(Mark::Zone(index + 1));
            let [distal, proximal] = zone.barbules;
            parts.push(rami(zone.rami, zone.fibres, ramus));
            parts.extend([row(distal, of_distal), row(proximal, of_proximal)]);
        }
        parts
    }

    /// A vane's swatch where something marks the vane.
    fn layer(&self, swatch: Swatch, mark: Mark) -> Layer {
        let Swatch { grown, half_width_mm, along_mm } = swatch;
        let parts = self.one_by_one(grown, mark);
        let objects = parts.into_iter().map(|(geometry, surface)| Object { geometry, surface });
        Layer { objects: objects.collect(), across_mm: [-half_width_mm, half_width_mm], along_mm }
    }

    /// The barbs left and right of the shaft, those of the downy part last.
    fn looked_up(&self, grown: &Grown, model: BarbModel) -> Result<Vec<Part>> {
        Ok([self.vane_looked_up(grown, model)?, self.down_looked_up(grown)?].concat())
    }

    /// The barbs of the closed vane.
    fn vane_looked_up(&self, grown: &Grown, model: BarbModel) -> Result<Vec<Part>> {
        let feather = &self.of.feather;
        let row = |shape: &BarbuleShape| shape.row(&feather.disorder);
        let rows = [&feather.distal, &feather.proximal].map(row);
        let [distal, proximal] = self.barbules.clone();
        // A barb that is one fibre looks as its barbules would.
        let is_barbule = matches!((model, &distal), (BarbModel::Fibre, Substance::Fibre(_)));
        let zone = |dress: &ZoneDress| {
            let ramus = if is_barbule { &dress.barbules[0] } else { &dress.ramus };
            ZoneDress { ramus: ramus.clone(), ..dress.clone() }
        };
        let vane = Barbs {
            ramus: Ramus {
                substance: if is_barbule { distal.clone() } else { self.ramus.clone() },
                half_width: 0.5e-3 * feather.barbs.width_um,
                height: feather.barbs.height,
            },
            rows: [(rows[0], distal), (rows[1], proximal)],
            dress: BarbDress {
                markings: self.markings.clone(),
                zones: self.zones.iter().map(zone).collect(),
                pale: self.pale.clone(),
            },
        };
        vane.on(&grown.envelopes, model)
    }

    /// Those of the downy part, which is nothing like one fibre as wide as its barbules reach.
    fn down_looked_up(&self, grown: &Grown) -> Result<Vec<Part>> {
        let feather = &self.of.feather;
        let down = Substance::Fibre(self.down.clone());
        let barbule = (feather.downy.barbules().row(&feather.disorder), down.clone());
        let half_width = 0.5e-3 * feather.downy.ramus_width_um;
        let ramus = Ramus { substance: down, half_width, height: 1.0 };
        let plain = BarbDress { markings: Markings::default(), zones: Vec::new(), pale: self.pale.clone() };
        let downy = Barbs { ramus, rows: [barbule.clone(), barbule], dress: plain };
        downy.on(&grown.downy_envelopes, BarbModel::Substructure)
    }
}

impl Substances<'_> {
    /// The vanes left and right of the shaft, then the barbs of the downy part.
    fn sheets(&self, grown: &Grown, seed: u64) -> Result<Vec<Part>> {
        let feather = &self.of.feather;
        let window = |barb_side: f64, barbs: SheetBarbs| {
            let swatch = feather.swatch(barb_side, &barbs, seed)?;
            let zones = (0..=self.zones.len()).map(Mark::Zone);
            let pale = self.markings.pattern.map(|_| Mark::Pale);
            let layers = zones.chain(pale).map(|mark| self.layer(swatch.clone(), mark)).collect();
            Ok::<_, Error>(Arc::new(Window { layers, markings: self.markings.clone(), side: barb_side }))
        };
        let sheets = grown.sheets.iter().zip(grown.sheet_barbs).zip([-1.0, 1.0]);
        let vanes = sheets.map(|((geometry, of_sheet), barb_side)| {
            let window = of_sheet.map(|of_sheet| window(barb_side, of_sheet)).transpose()?;
            // What is met is the window's; the sheet has no light of its own.
            Ok((Geometry { window, ..geometry.clone() }, self.pale_ramus.clone()))
        });
        vanes.chain(self.down_looked_up(grown)?.into_iter().map(Ok)).collect()
    }
}

/// What barbs of one kind are made of.
struct Barbs {
    ramus: Ramus,
    rows: [(Row, Substance); 2],
    dress: BarbDress,
}

impl Barbs {
    /// They on envelopes left and right of the shaft.
    fn on(&self, envelopes: &[Geometry; 2], model: BarbModel) -> Result<Vec<Part>> {
        let parts = envelopes.iter().zip([-1.0, 1.0]).map(|(geometry, barb_side)| {
            let Self { ramus, rows, dress } = self;
            let barb =
                BarbSurface::new(model, ramus.clone(), rows.clone(), tip_side(barb_side), dress.clone())?;
            Ok((geometry.clone(), Surface::Barb(Box::new(barb))))
        });
        parts.collect()
    }
}

#[cfg(test)]
mod tests;
