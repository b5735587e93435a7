//! Local reflection by layers: the currents of the ideal stacks under the points of a line.

use glam::DVec3;
use num_complex::Complex64;

use super::{COMPONENTS, Currents, Incidence, Place};
use crate::Result;
use crate::math::simd::Width;
use crate::solve::surface::{LANES, Optics, SlotMedium, add_reflectances};
use crate::spectrum::wave_number_per_um;
use crate::structure::{Layers, Line, PaletteMixture, Sampled};

/// The stacks under a segment's top at one wavelength.
pub(super) struct Stacks<'a> {
    sampled: &'a Sampled<'a>,
    k: f64,
    indices: Vec<Complex64>,
    width: Width,
}

/// Room for one line.
#[derive(Default)]
pub(super) struct Room {
    layers: Layers,
    cos_alpha: Vec<f64>,
    /// r_s and r_p, re and im of each.
    reflectances: [Vec<f64>; 4],
}

impl<'a> Stacks<'a> {
    pub(super) fn new(sampled: &'a Sampled<'a>, wavelength_nm: f64, width: Width) -> Result<Self> {
        let indices = sampled.columns.palette.indices(wavelength_nm)?;
        Ok(Self { sampled, k: wave_number_per_um(wavelength_nm), indices, width })
    }

    pub(super) fn currents(
        &self,
        incidence: &Incidence,
        line: &Line,
        room: &mut Room,
        out: &mut Currents,
    ) -> f64 {
        let grid = &self.sampled.grid;
        let area_um2 = grid.step_um[0] * grid.step_um[1];
        let place = |row: usize| Place::new(incidence, line, row, grid.centre_um(1, row), area_um2);
        let Room { cos_alpha, .. } = room;
        cos_alpha.clear();
        // Points in shadow and those that fill a vector reflect for nothing.
        cos_alpha.extend((0..grid.cells[1]).map(|row| place(row).map_or(1.0, |place| place.cos_alpha)));
        cos_alpha.resize(grid.cells[1].next_multiple_of(LANES), 1.0);
        self.reflect(line, room);
        let mut power = 0.0;
        for row in 0..grid.cells[1] {
            let Some(place) = place(row) else {
                for component in out.iter_mut().flatten() {
                    component[row] = Complex64::ZERO;
                }
                continue;
            };
            power += place.power(area_um2);
            let [s_re, s_im, p_re, p_im] = &room.reflectances;
            let scale = place.wave / self.sampled.parts as f64;
            let r_s = Complex64::new(s_re[row], s_im[row]) * scale;
            let r_p = Complex64::new(p_re[row], p_im[row]) * scale;
            let normal = place.normal;
            let s = normal.cross(incidence.omega).try_normalize().unwrap_or(DVec3::Y);
            let across = (2.0 * place.cos_alpha * normal - incidence.omega).cross(s);
            // E = E_s ŝ − H_s d × ŝ and H̃ = H_s ŝ + E_s d × ŝ for a wave along d; J = n × H̃, M = −n × E.
            let (turned_s, turned_across) = (normal.cross(s), normal.cross(across));
            for (q, currents) in out.iter_mut().enumerate() {
                let e = r_s * incidence.electric[q].dot(s);
                let h = r_p * incidence.magnetic[q].dot(s);
                for axis in 0..COMPONENTS / 2 {
                    currents[axis][row] = h * turned_s[axis] + e * turned_across[axis];
                    currents[axis + COMPONENTS / 2][row] = h * turned_across[axis] - e * turned_s[axis];
                }
            }
        }
        power
    }

    /// The sums of the reflectances at all places of the line's cells.
    fn reflect(&self, line: &Line, room: &mut Room) {
        for row in &mut room.reflectances {
            row.clear();
            row.resize(room.cos_alpha.len(), 0.0);
        }
        let contrast = |medium: &PaletteMixture| SlotMedium::Uniform(medium.contrast(&self.indices));
        for part in 0..self.sampled.parts {
            self.sampled.layers(line, part, LANES, &mut room.layers);
            let Layers { media, varying, thickness_um, stride } = &room.layers;
            let mut optics = Optics { k: self.k, slots: media.iter().map(contrast).collect() };
            if let Some((slot, fractions)) = varying {
                let mixed = |fraction: &f64| {
                    PaletteMixture { fraction: *fraction, ..media[*slot] }.contrast(&self.indices)
                };
                let (mut re, mut im): (Vec<f64>, Vec<f64>) =
                    fractions.iter().map(mixed).map(|value| (value.re, value.im)).unzip();
                re.resize(*stride, 0.0);
                im.resize(*stride, 0.0);
                optics.slots[*slot] = SlotMedium::Varying { re, im };
            }
            add_reflectances(self.width, &optics, thickness_um, &room.cos_alpha, &mut room.reflectances);
        }
    }
}
