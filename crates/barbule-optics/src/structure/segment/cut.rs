//! Planes through a segment: what one sees of it.

use super::{Layers, Line, Sampled, Segment, SegmentGrid};
use crate::Result;
use crate::structure::{BuriedCircle, Medium, PaletteMixture, Substance};

/// Which plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// y = 0: over x and z.
    Across,
    /// x = 0: over y and z.
    Along,
}

/// Media of a plane through a segment, at the centres of equal cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    /// The plane.
    pub plane: Plane,
    /// Size of a cell along the plane, µm; cells lie symmetrically around 0.
    pub step_um: f64,
    /// The top's height at each place along the plane, µm.
    pub top_um: Vec<f64>,
    /// The layers at each place, from the top down, with their extents along z; the last has none.
    pub layers: Vec<Vec<CutLayer>>,
}

/// One layer of a cut.
#[derive(Debug, Clone, PartialEq)]
pub struct CutLayer {
    /// What it is made of, with the fraction of the second.
    pub media: (Substance, Substance, f64),
    /// How far it goes along z, µm.
    pub height_um: f64,
}

impl Segment {
    /// The middle `extent_um` of a plane in so many cells. Of a segment over a crystal, the layers are those along vertical
    /// lines through the crystal's rods, as they hang on the top.
    ///
    /// # Errors
    /// As [`Segment::sampled`].
    pub fn cut(&self, plane: Plane, extent_um: f64, cells: usize) -> Result<Cut> {
        let step_um = extent_um / cells as f64;
        let grid = match plane {
            Plane::Across => SegmentGrid { cells: [cells, 1], step_um: [step_um, 1.0] },
            Plane::Along => SegmentGrid { cells: [1, cells], step_um: [COLUMN_UM, step_um] },
        };
        let sampled = self.sampled(grid, 1)?;
        let (mut line, mut layers) = (Line::default(), Layers::default());
        let circles = self.section.crystal.as_ref().map_or_else(Vec::new, |c| c.circles(self.section.top()));
        let mut cut = Cut { plane, step_um, top_um: Vec::new(), layers: Vec::new() };
        for column in 0..grid.cells[0] {
            sampled.line(column, &mut line);
            sampled.layers(&line, 0, 1, &mut layers);
            for (row, rise) in line.rise_um.iter().enumerate() {
                cut.top_um.push(line.z_um + f64::from(*rise));
                cut.layers.push(match self.section.crystal {
                    Some(_) => self.through_crystal(&circles, line.x_um, line.z_um),
                    None => self.through_layers(&sampled, &line, &layers, row),
                });
            }
        }
        Ok(cut)
    }

    fn through_layers(
        &self,
        sampled: &Sampled<'_>,
        line: &Line,
        layers: &Layers,
        row: usize,
    ) -> Vec<CutLayer> {
        // Layers are thick along the normal; round ends are not drawn as spikes.
        let slant = line.slope.hypot(1.0).min(STEEPEST);
        let layer = |(index, medium): (usize, &PaletteMixture)| {
            let fraction = match &layers.varying {
                Some((slot, fractions)) if *slot == index => fractions[row],
                _ => medium.fraction,
            };
            let thickness = layers.thickness_um.get(index * layers.stride + row).copied().unwrap_or(0.0);
            CutLayer {
                media: (self.substance(sampled, medium.a), self.substance(sampled, medium.b), fraction),
                height_um: slant * thickness,
            }
        };
        let all: Vec<CutLayer> = layers.media.iter().enumerate().map(layer).collect();
        let last = all.len() - 1;
        all.into_iter()
            .enumerate()
            .filter(|(index, layer)| *index == last || layer.height_um > 0.0)
            .map(|(_, l)| l)
            .collect()
    }

    /// The name of an entry of the palette: that of the section's substance with the same material.
    fn substance(&self, sampled: &Sampled<'_>, entry: u16) -> Substance {
        let material = &sampled.columns.palette.materials[usize::from(entry)];
        let is_it =
            |substance: &&Substance| self.section.material(substance).is_ok_and(|own| own == *material);
        let found = self.section.all_media().flat_map(Medium::substances).find(is_it);
        found.cloned().unwrap_or_else(|| Substance::named("air"))
    }

    /// The host and the rods along a vertical line.
    fn through_crystal(&self, circles: &[BuriedCircle], x_um: f64, top_um: f64) -> Vec<CutLayer> {
        let Some(crystal) = &self.section.crystal else { return Vec::new() };
        let lattice = &crystal.lattice;
        let steps = (1.1 * lattice.bottom_um() / CRYSTAL_UM).ceil().max(1.0) as usize;
        let mut found = vec![&lattice.host; steps];
        for circle in circles.iter().filter(|circle| (circle.x_um - x_um).abs() < circle.radius_um) {
            let half = (circle.radius_um.powi(2) - (circle.x_um - x_um).powi(2)).sqrt();
            let step = |z: f64| ((top_um - z) / CRYSTAL_UM).round().max(0.0) as usize;
            let range = step(circle.z_um + half).min(steps)..step(circle.z_um - half).min(steps);
            found[range].fill(&lattice.rods[circle.rod].circles[circle.circle].medium);
        }
        let runs = found.chunk_by(|a, b| a == b);
        runs.map(|run| CutLayer {
            media: (run[0].clone(), run[0].clone(), 0.0),
            height_um: run.len() as f64 * CRYSTAL_UM,
        })
        .collect()
    }
}

/// How finely crystals are looked through, µm.
const CRYSTAL_UM: f64 = 0.004;

/// Layers are drawn no longer along z than so many times their thickness.
const STEEPEST: f64 = 2.0;

/// Width of the column at x = 0 whose slope counts, µm.
const COLUMN_UM: f64 = 0.05;
