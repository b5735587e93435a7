//! A segment on a grid: line by line, so that no map of it is ever held.

use super::pancakes::Pancakes;
use super::relief::{Part, Relief, Relieved};
use super::{Granules, Roughness, Segment, Under};
use crate::Result;
use crate::structure::cast::layers;
use crate::structure::{Columns, PaletteMixture, Ray, Section, Substance};

/// Cells that show which layers a section has, µm.
pub(super) const COARSE_UM: f64 = 0.05;

/// Equal cells over a segment; values belong to their centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentGrid {
    /// Along x and y.
    pub cells: [usize; 2],
    /// Along x and y, µm.
    pub step_um: [f64; 2],
}

impl SegmentGrid {
    /// Cells of at most `step_um`.
    #[must_use]
    pub fn new(segment: &Segment, step_um: [f64; 2]) -> Self {
        let sizes = [segment.section.width_um, segment.length_um];
        let cells = [0, 1].map(|axis| (sizes[axis] / step_um[axis]).ceil().max(1.0));
        Self {
            cells: cells.map(|cells| cells as usize),
            step_um: [0, 1].map(|axis| sizes[axis] / cells[axis]),
        }
    }

    /// One row of cells of at most `step_um` across a section.
    pub(super) fn across(section: &Section, step_um: f64) -> Self {
        let cells = (section.width_um / step_um).ceil().max(1.0);
        Self { cells: [cells as usize, 1], step_um: [section.width_um / cells, 1.0] }
    }

    /// Centre of the cell in this column or row, µm.
    #[must_use]
    pub fn centre_um(&self, axis: usize, index: usize) -> f64 {
        (index as f64 + 0.5 - 0.5 * self.cells[axis] as f64) * self.step_um[axis]
    }

    /// Rays under so many places of each cell across a section, along the normal of the top's chord in the cell.
    pub(super) fn rays(&self, section: &Section, parts: usize) -> Vec<Ray> {
        let top = section.top();
        let step = self.step_um[0];
        let cell = |index: usize| {
            let x = self.centre_um(0, index);
            let rise = (top.height(x + 0.5 * step) - top.height(x - 0.5 * step)) / step;
            let length = rise.hypot(1.0);
            (0..parts).map(move |part| {
                let x_um = x + ((part as f64 + 0.5) / parts as f64 - 0.5) * step;
                Ray { x_um, z_um: top.height(x_um), normal: [-rise / length, 1.0 / length] }
            })
        };
        (0..self.cells[0]).flat_map(cell).collect()
    }
}

/// A segment prepared on a grid.
pub struct Sampled<'a> {
    segment: &'a Segment,
    /// The grid.
    pub grid: SegmentGrid,
    /// Places of each cell across at which layers are known.
    pub parts: usize,
    /// The section's layers under those places; media of layers point at its palette.
    pub columns: Columns,
    /// Keratin, melanin and air, where there are pancakes.
    pure: [Option<PaletteMixture>; 3],
    y_um: Vec<f64>,
    top: Option<Relieved<'a>>,
    boundaries: Vec<Relieved<'a>>,
    /// Depth and melanin of granules.
    granules: Option<(&'a Granules, [Relieved<'a>; 2])>,
}

/// The top along one line x = constant. Arrays are over y.
#[derive(Debug, Clone, Default)]
pub struct Line {
    /// Which column of cells.
    pub column: usize,
    /// Its place across, µm.
    pub x_um: f64,
    /// Height and slope of the section there.
    pub z_um: f64,
    /// ∂z/∂x of the section there.
    pub slope: f64,
    /// Heights over the section, µm.
    pub rise_um: Vec<f32>,
    /// ∂z/∂x and ∂z/∂y over the section's.
    pub slopes: [Vec<f32>; 2],
    /// How far each boundary below the top is over the section's, µm.
    boundaries_um: Vec<Vec<f32>>,
    granules: [Vec<f32>; 2],
}

/// The layers under one place across, along y.
#[derive(Debug, Clone, Default)]
pub struct Layers {
    /// From the top down, the substrate last.
    pub media: Vec<PaletteMixture>,
    /// A layer whose fraction of its second medium varies: which, and the fraction over y.
    pub varying: Option<(usize, Vec<f64>)>,
    /// All but the substrate's, µm. Shape: `[layer][stride]`.
    pub thickness_um: Vec<f64>,
    /// Values of a layer: y, and what fills up a vector.
    pub stride: usize,
}

impl Segment {
    /// Prepares the segment on a grid, with layers known at `parts` places of each cell across.
    ///
    /// # Errors
    /// As [`cast`](crate::structure::cast()).
    pub fn sampled(&self, grid: SegmentGrid, parts: usize) -> Result<Sampled<'_>> {
        let columns = layers(&self.section, &grid.rays(&self.section, parts))?;
        let y_um: Vec<f64> = (0..grid.cells[1]).map(|row| grid.centre_um(1, row)).collect();
        let needed = match &self.under {
            Under::Pancakes(pancakes) => pancakes.layers.len(),
            _ => columns.slots - 1,
        };
        let pure = match &self.under {
            Under::Pancakes(_) => self.pancake_media(&columns)?,
            _ => Default::default(),
        };
        let granules = match &self.under {
            Under::Granules(granules) => {
                Some((granules, [&granules.gap, &granules.melanin].map(|map| map.relief.on(&y_um))))
            }
            _ => None,
        };
        Ok(Sampled {
            segment: self,
            grid,
            parts,
            pure,
            top: self.top.as_ref().map(|top| top.on(&y_um)),
            boundaries: self.boundaries.iter().take(needed).map(|relief| relief.on(&y_um)).collect(),
            granules,
            columns,
            y_um,
        })
    }

    /// Keratin, melanin and air in the palette of a hummingbird's section.
    fn pancake_media(&self, columns: &Columns) -> Result<[Option<PaletteMixture>; 3]> {
        let mut media = [None; 3];
        for (medium, name) in media.iter_mut().zip(["keratin", "melanin", "air"]) {
            let material = self.section.material(&Substance::named(name))?;
            let at = columns.palette.materials.iter().position(|known| *known == material);
            *medium = at.map(|at| PaletteMixture { a: at as u16, b: at as u16, fraction: 0.0 });
        }
        Ok(media)
    }

    /// Fields of roughness that are known at each cell: height and slopes of the top, heights of the boundaries.
    #[must_use]
    pub fn roughened(&self) -> usize {
        self.boundaries.len() + 3
    }

    /// Bytes that preparing it on a grid takes.
    #[must_use]
    pub fn sampled_bytes(&self, grid: &SegmentGrid, parts: usize) -> u64 {
        let lines = self.roughened().saturating_mul(Relief::bytes_on(grid.cells[1]));
        let rays = grid.cells[0].saturating_mul(parts).saturating_mul(40 * (self.boundaries.len() + 8));
        lines.saturating_add(rays) as u64
    }
}

impl Sampled<'_> {
    /// The segment's roughness.
    #[must_use]
    pub fn roughness(&self) -> Roughness {
        self.segment.roughness
    }

    /// The top along a column of cells.
    pub fn line(&self, column: usize, line: &mut Line) {
        let count = self.y_um.len();
        let step = self.grid.step_um[0];
        let top = self.segment.section.top();
        let x = self.grid.centre_um(0, column);
        line.column = column;
        line.x_um = x;
        line.z_um = top.height(x);
        line.slope = (top.height(x + 0.5 * step) - top.height(x - 0.5 * step)) / step;
        let amplitude = self.segment.roughness.amplitude_um;
        let read = |relief: Option<&Relieved<'_>>, part: Part, scale: f64, row: &mut Vec<f32>| {
            row.resize(count, 0.0);
            match relief {
                Some(relief) => relief.at(x, part, scale, row),
                None => row.fill(0.0),
            }
        };
        read(self.top.as_ref(), Part::Value, amplitude, &mut line.rise_um);
        read(self.top.as_ref(), Part::SlopeX, amplitude, &mut line.slopes[0]);
        read(self.top.as_ref(), Part::SlopeY, amplitude, &mut line.slopes[1]);
        line.boundaries_um.resize_with(self.boundaries.len(), Vec::new);
        for (relief, row) in self.boundaries.iter().zip(&mut line.boundaries_um) {
            read(Some(relief), Part::Value, amplitude, row);
        }
        if let Some((_, reliefs)) = &self.granules {
            for (relief, row) in reliefs.iter().zip(&mut line.granules) {
                read(Some(relief), Part::Value, 1.0, row);
            }
        }
    }

    /// The layers under one place of a line's cells; arrays are filled up to a multiple of `lanes`.
    pub fn layers(&self, line: &Line, part: usize, lanes: usize, layers: &mut Layers) {
        layers.media.clear();
        layers.thickness_um.clear();
        layers.varying = None;
        layers.stride = self.y_um.len().next_multiple_of(lanes);
        match &self.segment.under {
            Under::Pancakes(pancakes) => self.pancakes(pancakes, line, part, layers),
            Under::Section | Under::Granules(_) => self.section(line, part, layers),
        }
    }

    fn section(&self, line: &Line, part: usize, layers: &mut Layers) {
        let columns = &self.columns;
        let ray = line.column * self.parts + part;
        // Roughness is along z, layers are along the normal.
        let cosine = line.slope.hypot(1.0).recip();
        let mut granules = self.granules.as_ref().map(|(granules, _)| *granules);
        // How much deeper granules begin than the section's.
        let mut deeper = vec![0.0; if granules.is_some() { self.y_um.len() } else { 0 }];
        for slot in 0..columns.slots - 1 {
            let Some(mixture) = columns.mixture[slot].at(ray) else { continue };
            let base = columns.thickness_um[slot * columns.rays + ray];
            if base <= 0.0 {
                continue;
            }
            let start = layers.thickness_um.len();
            layers.thickness_um.resize(start + layers.stride, 0.0);
            let row = &mut layers.thickness_um[start..start + self.y_um.len()];
            let above = if slot == 0 { Some(&line.rise_um) } else { line.boundaries_um.get(slot - 1) };
            match (above, line.boundaries_um.get(slot)) {
                (Some(above), Some(below)) => {
                    for (value, (above, below)) in row.iter_mut().zip(above.iter().zip(below)) {
                        *value = (base + cosine * f64::from(above - below)).max(0.0);
                    }
                }
                _ => row.fill(base),
            }
            // Granules begin below the second layer, air, and fill the third, down to where the section has its end.
            match (granules, layers.media.len()) {
                (Some(granules), 1) => {
                    for ((value, field), moved) in row.iter_mut().zip(&line.granules[0]).zip(&mut deeper) {
                        *moved = granules.gap.value(*field) - *value;
                        *value += *moved;
                    }
                }
                (Some(found), 2) => {
                    for (value, moved) in row.iter_mut().zip(&deeper) {
                        *value = (*value - moved).max(0.0);
                    }
                    let fractions = line.granules[1].iter().map(|field| found.melanin.value(*field));
                    layers.varying = Some((2, fractions.collect()));
                    granules = None;
                }
                _ => {}
            }
            layers.media.push(mixture);
        }
        layers.media.extend(columns.mixture[columns.slots - 1].at(ray));
    }

    fn pancakes(&self, pancakes: &Pancakes, line: &Line, part: usize, layers: &mut Layers) {
        let stride = layers.stride;
        let [Some(keratin), Some(melanin), Some(air)] = self.pure else { return };
        let cosine = line.slope.hypot(1.0).recip();
        let x = line.x_um + ((part as f64 + 0.5) / self.parts as f64 - 0.5) * self.grid.step_um[0];
        let section = &self.segment.section;
        let local = section
            .boundaries
            .get(1)
            .map_or(pancakes.thickness_um, |bottom| (section.top().height(x) - bottom.height(x)) * cosine);
        // Layers follow a blend of both surfaces.
        let scale = (local / pancakes.thickness_um).max(0.0);
        for _ in &pancakes.layers {
            layers.media.extend([keratin, melanin, air, melanin]);
        }
        layers.media.extend([keratin, air]);
        layers.thickness_um.resize((layers.media.len() - 1) * stride, 0.0);
        for (row, &y) in self.y_um.iter().enumerate() {
            let mut bottom = 0.0;
            let mut at = row;
            let mut push = |thickness: f64| {
                layers.thickness_um[at] = thickness;
                at += stride;
                bottom += thickness;
                bottom
            };
            let mut above = 0.0;
            for (index, layer) in pancakes.layers.iter().enumerate() {
                let halves = pancakes.at(layer, x, y);
                let rough =
                    line.boundaries_um.get(index).map_or(0.0, |b| f64::from(line.rise_um[row] - b[row]));
                let wall = halves.outer_um - halves.air_um;
                push((layer.depth_um * scale + cosine * rough - halves.outer_um - above).max(0.0));
                push(wall);
                push(2.0 * halves.air_um);
                above = push(wall);
            }
            push((pancakes.thickness_um * scale - above).max(0.0));
        }
    }
}
