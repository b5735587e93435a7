//! What is read from a run: sums of fields over time, turned to the wavelength's frequency.

use super::fields::Fields;
use super::grid::Grid;
use super::medium::Material;
use crate::Complex64;
use crate::solve::crystal::orders::DiffractionOrders;

/// The running Fourier transform at the wavelength, where results are read.
#[derive(Clone)]
pub(super) struct Spectrum {
    /// Columns of e_y and H_y on the reflected line.
    line: [Vec<Complex64>; 2],
    /// Columns of E_x, e_y, h_x, H_y at the exit.
    exit: [Vec<Complex64>; 4],
    /// D where matter may be, column by column.
    matter: [Vec<Complex64>; 3],
    /// E on the planes kept for pictures, column by column.
    pub(super) electric: [Vec<Complex64>; 3],
    /// Sums of the pulse at E's and H̃'s times.
    pulse: [f64; 2],
}

impl Spectrum {
    pub(super) fn new(grid: &Grid) -> Self {
        let columns = || vec![Complex64::ZERO; grid.nx];
        let matter = || vec![Complex64::ZERO; grid.nx * grid.matter.len()];
        let near = || vec![Complex64::ZERO; grid.nx * grid.near.len()];
        Self {
            line: [columns(), columns()],
            exit: [columns(), columns(), columns(), columns()],
            matter: [matter(), matter(), matter()],
            electric: [near(), near(), near()],
            pulse: [0.0; 2],
        }
    }

    pub(super) fn add(&mut self, grid: &Grid, fields: &Fields, t: f64, pulse: [f64; 2]) {
        let turn = Complex64::from_polar(1.0, grid.omega * t);
        let turn_h = Complex64::from_polar(1.0, grid.omega * (t - 0.5 * grid.dt));
        for i in 0..grid.nx {
            self.line[0][i] += turn * fields.get(&fields.e[1], i, grid.line);
            self.line[1][i] += turn_h * fields.get(&fields.h[1], i, grid.line);
            self.exit[0][i] += turn * fields.get(&fields.e[0], i, grid.exit);
            self.exit[1][i] += turn * fields.get(&fields.e[1], i, grid.exit);
            self.exit[2][i] += turn_h * fields.get(&fields.h[0], i, grid.exit - 1);
            self.exit[3][i] += turn_h * fields.get(&fields.h[1], i, grid.exit - 1);
            for (sums, d) in self.matter.iter_mut().zip(&fields.d) {
                let sums = &mut sums[i * grid.matter.len()..(i + 1) * grid.matter.len()];
                for (sum, k) in sums.iter_mut().zip(grid.matter.clone()) {
                    *sum += turn * fields.get(d, i, k);
                }
            }
            for (sums, e) in self.electric.iter_mut().zip(&fields.e) {
                let sums = &mut sums[i * grid.near.len()..(i + 1) * grid.near.len()];
                for (sum, k) in sums.iter_mut().zip(grid.near.clone()) {
                    *sum += turn * fields.get(e, i, k);
                }
            }
        }
        self.pulse[0] += pulse[0];
        self.pulse[1] += pulse[1];
    }

    /// Largest relative change since an earlier state, in the mean square of each group of results.
    pub(super) fn change(&self, before: &Self) -> f64 {
        let groups = |spectrum: &Self| -> [Vec<Complex64>; 3] {
            [spectrum.line.concat(), spectrum.exit.concat(), spectrum.matter.concat()]
        };
        let relative = |now: &Vec<Complex64>, before: &Vec<Complex64>| {
            let change: f64 = now.iter().zip(before).map(|(a, b)| (a - b).norm_sqr()).sum();
            let size: f64 = now.iter().map(Complex64::norm_sqr).sum();
            (change / size).sqrt()
        };
        groups(self)
            .iter()
            .zip(&groups(before))
            .map(|(now, before)| relative(now, before))
            .fold(0.0, f64::max)
    }

    pub(super) fn normalize(&mut self) {
        let [e, h] = self.pulse.map(f64::recip);
        let scale = |values: &mut Vec<Complex64>, by: f64| values.iter_mut().for_each(|value| *value *= by);
        scale(&mut self.line[0], e);
        scale(&mut self.line[1], h);
        for (values, by) in self.exit.iter_mut().zip([e, e, h, h]) {
            scale(values, by);
        }
        self.matter.iter_mut().chain(&mut self.electric).for_each(|values| scale(values, e));
    }

    /// (E_y, H̃_y) of a reflected order, referred to x = z = 0.
    pub(super) fn order(&self, diffraction: &DiffractionOrders, grid: &Grid, m: i32) -> [Complex64; 2] {
        let kz = grid.kz(diffraction, m);
        let kx = diffraction.a(m) * diffraction.k;
        std::array::from_fn(|field| {
            let half = 0.5 * field as f64;
            let sum: Complex64 = (0..grid.nx)
                .map(|i| {
                    self.line[field][i] * Complex64::from_polar(1.0, -kx * (i as f64 + half) * grid.spacing)
                })
                .sum();
            let rise = (-Complex64::I * kz * grid.z(grid.line as f64 + half)).exp();
            // E_y = j e_y
            sum * rise / grid.nx as f64 * if field == 0 { Complex64::I } else { Complex64::ONE }
        })
    }

    pub(super) fn transmitted(&self, grid: &Grid) -> f64 {
        let [ex, ey, hx, hy] = &self.exit;
        (0..grid.nx).map(|i| (ey[i] * hx[i].conj() - ex[i] * hy[i].conj()).re).sum()
    }

    /// k Σ Im(D·E*) over the cells, with E = ξD.
    pub(super) fn absorbed(&self, material: &Material, diffraction: &DiffractionOrders, grid: &Grid) -> f64 {
        let count = grid.matter.len();
        let (nx, nz) = (grid.nx, grid.nz);
        // From one end of the period to the other.
        let turn = Complex64::from_polar(1.0, -diffraction.a0 * diffraction.k * nx as f64 * grid.spacing);
        let mut sum = 0.0;
        for (d, xi) in self.matter.iter().zip(&material.diagonal) {
            for i in 0..nx {
                let (d, xi) = (&d[i * count..], &xi[i * nz + grid.matter.start..]);
                sum -= (0..count).map(|index| xi[index].im * d[index].norm_sqr()).sum::<f64>();
            }
        }
        for &(i, k, xz) in material.cross.iter().filter(|(_, k, _)| grid.matter.contains(k)) {
            let here = i * count + k - grid.matter.start;
            let left = if i == 0 {
                self.matter[0][here + (nx - 1) * count] * turn
            } else {
                self.matter[0][here - count]
            };
            let x = self.matter[0][here] + left;
            let z = self.matter[2][here]
                + if k > grid.matter.start { self.matter[2][here - 1] } else { Complex64::ZERO };
            sum -= 0.5 * xz.im * (x * z.conj()).re;
        }
        sum * diffraction.k * grid.spacing / grid.fz
    }

    /// As [`Self::absorbed`], what the host alone takes between the exit and the lower edge, where `matter` begins at the
    /// exit.
    ///
    /// Power is measured with E at the exit and H̃ half a cell below it, so all of the exit's own cell counts.
    pub(super) fn absorbed_below_the_edge(
        &self,
        material: &Material,
        diffraction: &DiffractionOrders,
        grid: &Grid,
    ) -> f64 {
        let count = grid.matter.len();
        let host = diffraction.host_eps;
        // Part of the cell about a plane that lies below the edge.
        let below = |k: f64| ((grid.edge - grid.z(k)) / grid.spacing + 0.5).clamp(0.0, 1.0);
        let mut sum = 0.0;
        for (index, k) in grid.matter.clone().enumerate() {
            let (on, above) = (below(k as f64), below(k as f64 + 0.5));
            if on == 0.0 {
                break;
            }
            for i in 0..grid.nx {
                let at = i * count + index;
                // Along the edge E goes on from host to rod, across it D does.
                let [x, y] = [0, 1].map(|c| material.diagonal[c][i * grid.nz + k] * self.matter[c][at]);
                let z = self.matter[2][at] / host;
                sum += on * (x.norm_sqr() + y.norm_sqr()) + above * z.norm_sqr();
            }
        }
        sum * host.im * diffraction.k * grid.spacing / grid.fz
    }
}
