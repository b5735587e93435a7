//! Permittivity averaged over the cells of the grid.
//!
//! Within the cell around each component ε⁻¹ becomes ξ = P⟨ε⁻¹⟩ + (1 − P)⟨ε⟩⁻¹ with P the projection on the normal of
//! the boundary (Farjadpour et al. 2006, Opt. Lett. 31, 2972; Kottke, Farjadpour & Johnson 2008, Phys. Rev. E 77,
//! 036611); absorption is averaged with it, as ε is complex.

use crate::Complex64;
use crate::solve::crystal::Cell;

/// Lines along z by which the average over a cell is taken.
const LINES: usize = 24;

/// A flat layer across the whole period, below the surface.
#[derive(Debug, Clone, Copy)]
pub struct Layer {
    /// Depth of its upper face, µm.
    pub top_um: f64,
    /// Depth of its lower face, µm.
    pub bottom_um: f64,
    /// Relative permittivity.
    pub eps: Complex64,
}

/// Rods and flat layers; rods replace layers where they overlap, later bodies earlier ones.
pub(super) struct Medium<'a> {
    pub cell: &'a Cell,
    pub layers: &'a [Layer],
}

/// ξ of one cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inverse {
    pub xx: Complex64,
    pub yy: Complex64,
    pub zz: Complex64,
    pub xz: Complex64,
}

impl Medium<'_> {
    /// Least and greatest depth of what is not host, µm; `None` where all is.
    pub(super) fn extent(&self) -> Option<(f64, f64)> {
        let rods = self.cell.rods.iter().map(|rod| {
            let radius = rod.shells[0].diameter_um / 2.0;
            (rod.depth_um - radius, rod.depth_um + radius)
        });
        rods.chain(self.layers.iter().map(|layer| (layer.top_um, layer.bottom_um)))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Every permittivity present.
    pub(super) fn materials(&self) -> impl Iterator<Item = Complex64> + '_ {
        let rods = self.cell.rods.iter().flat_map(|rod| rod.shells.iter().map(|shell| shell.eps));
        [self.cell.incidence_eps.into(), self.cell.host_eps]
            .into_iter()
            .chain(rods)
            .chain(self.layers.iter().map(|layer| layer.eps))
    }

    pub(super) fn at(&self, x: f64, depth: f64) -> Complex64 {
        if depth < 0.0 {
            return self.cell.incidence_eps.into();
        }
        let mut eps = self.cell.host_eps;
        for layer in self.layers {
            if layer.top_um < depth && depth < layer.bottom_um {
                eps = layer.eps;
            }
        }
        for rod in &self.cell.rods {
            let distance = self.across(x, rod.x_um).hypot(depth - rod.depth_um);
            if let Some(shell) = rod.shells.iter().rev().find(|shell| distance < shell.diameter_um / 2.0) {
                eps = shell.eps;
            }
        }
        eps
    }

    /// x − from to the nearest period.
    fn across(&self, x: f64, from: f64) -> f64 {
        let period = self.cell.period_um;
        let offset = (x - from) / period;
        (offset - offset.round()) * period
    }

    /// ξ of the square cell of this size about a point.
    pub(super) fn average(&self, x: f64, depth: f64, size_um: f64) -> Inverse {
        let reach = size_um * std::f64::consts::FRAC_1_SQRT_2;
        // Nearest boundary: distance and normal. Flat faces and circles that cross the cell.
        let (mut nearest, mut normal) = (reach, None);
        let mut flat = Vec::new();
        let mut round = Vec::new();
        let faces = self.layers.iter().flat_map(|layer| [layer.top_um, layer.bottom_um]);
        for face in faces.chain([0.0]) {
            let distance = (depth - face).abs();
            if distance < reach {
                flat.push(face);
            }
            if distance < nearest {
                (nearest, normal) = (distance, Some((0.0, 1.0)));
            }
        }
        for rod in &self.cell.rods {
            let (dx, dz) = (self.across(x, rod.x_um), depth - rod.depth_um);
            let center = dx.hypot(dz);
            for shell in &rod.shells {
                let distance = (center - shell.diameter_um / 2.0).abs();
                if distance < reach {
                    round.push((dx, rod.depth_um, shell.diameter_um / 2.0));
                }
                if distance < nearest {
                    (nearest, normal) = (distance, Some((dx / center, dz / center)));
                }
            }
        }
        let Some((nx, nz)) = normal else {
            let inverse = self.at(x, depth).inv();
            return Inverse { xx: inverse, yy: inverse, zz: inverse, xz: Complex64::ZERO };
        };
        let (mean, mean_inverse) = self.means(x, depth, size_um, &flat, &round);
        let along = mean.inv();
        let excess = mean_inverse - along;
        Inverse {
            xx: along + nx * nx * excess,
            yy: along,
            zz: along + nz * nz * excess,
            // Depth runs against z.
            xz: -nx * nz * excess,
        }
    }

    /// ⟨ε⟩ and ⟨ε⁻¹⟩ over a cell that these faces (depths) and circles (offset of the point from the centre along x,
    /// depth of the centre, radius) may cross.
    fn means(
        &self,
        x: f64,
        depth: f64,
        size_um: f64,
        flat: &[f64],
        round: &[(f64, f64, f64)],
    ) -> (Complex64, Complex64) {
        let (top, bottom) = (depth - size_um / 2.0, depth + size_um / 2.0);
        let (mut mean, mut mean_inverse) = (Complex64::ZERO, Complex64::ZERO);
        let mut cuts = Vec::with_capacity(8);
        for line in 0..LINES {
            let offset = ((line as f64 + 0.5) / LINES as f64 - 0.5) * size_um;
            cuts.clear();
            cuts.extend([top, bottom]);
            cuts.extend(flat.iter().copied().filter(|cut| (top..bottom).contains(cut)));
            for &(dx, center, radius) in round {
                let square = radius * radius - (dx + offset) * (dx + offset);
                if square > 0.0 {
                    let half = square.sqrt();
                    cuts.extend(
                        [center - half, center + half].into_iter().filter(|cut| (top..bottom).contains(cut)),
                    );
                }
            }
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                let weight = (pair[1] - pair[0]) / (size_um * LINES as f64);
                let eps = self.at(x + offset, (pair[0] + pair[1]) / 2.0);
                mean += weight * eps;
                mean_inverse += weight * eps.inv();
            }
        }
        (mean, mean_inverse)
    }
}

/// ξ on the grid: at each component's own place, and off the diagonal at the nodes.
pub(super) struct Material {
    /// ξ_xx at (i + ½, k), ξ_yy at (i, k), ξ_zz at (i, k + ½); columns of `nz`.
    pub diagonal: [Vec<Complex64>; 3],
    /// Column, plane and ξ_xz of the nodes where it is not 0.
    pub cross: Vec<(usize, usize, Complex64)>,
}

impl Material {
    /// Averages over the cells of a grid of `nx` columns whose planes lie at the heights `z`, µm.
    ///
    /// E = ξD is a symmetric operator: ξ_xz of a node couples the sum of D_x left and right of it with E_z above and
    /// below and back, each by a quarter (Werner & Cary 2007, J. Comput. Phys. 226, 1085). Where neighbours lie in
    /// different media it is cut so that both the real and the absorbing part stay positive at every node, without
    /// which fields could grow.
    pub(super) fn new(medium: &Medium, nx: usize, z: &[f64], spacing: f64) -> Self {
        let nz = z.len();
        let at = |i: usize, half: f64, k: usize, up: f64| {
            medium.average((i as f64 + half) * spacing, -(z[k] + up * spacing), spacing)
        };
        let fill = |half: f64, up: f64, part: fn(Inverse) -> Complex64| -> Vec<Complex64> {
            (0..nx * nz).map(|index| part(at(index / nz, half, index % nz, up))).collect()
        };
        let diagonal = [
            fill(0.5, 0.0, |inverse| inverse.xx),
            fill(0.0, 0.0, |inverse| inverse.yy),
            fill(0.0, 0.5, |inverse| inverse.zz),
        ];
        let mut cross = Vec::new();
        for i in 0..nx {
            for k in 1..nz - 1 {
                let xz = at(i, 0.0, k, 0.0).xz;
                if xz == Complex64::ZERO {
                    continue;
                }
                let left = (i + nx - 1) % nx;
                let x = [diagonal[0][i * nz + k], diagonal[0][left * nz + k]];
                let z = [diagonal[2][i * nz + k], diagonal[2][i * nz + k - 1]];
                let limit = |part: fn(&Complex64) -> f64| {
                    let least = |pair: &[Complex64; 2]| part(&pair[0]).min(part(&pair[1])).max(0.0);
                    0.95 * (least(&x) * least(&z)).sqrt()
                };
                let (re, im) = (limit(|xi| xi.re), limit(|xi| -xi.im));
                cross.push((i, k, Complex64::new(xz.re.clamp(-re, re), xz.im.clamp(-im, im))));
            }
        }
        Self { diagonal, cross }
    }

    /// The largest ξ' + |ξ''|·cot over all components, with what the nodes around add (Gershgorin), and the least
    /// ξ' − |ξ''|·tan, for the given cot and tan of ω dt/2.
    pub(super) fn bounds(&self, nx: usize, nz: usize, cot: f64, tan: f64) -> (f64, f64) {
        let stiff = |xi: Complex64| xi.re.abs() + xi.im.abs() * cot;
        let mut sums: [Vec<f64>; 3] =
            std::array::from_fn(|c| self.diagonal[c].iter().map(|&xi| stiff(xi)).collect());
        for &(i, k, xz) in &self.cross {
            let half = 0.5 * stiff(xz);
            sums[0][i * nz + k] += half;
            sums[0][(i + nx - 1) % nx * nz + k] += half;
            sums[2][i * nz + k] += half;
            sums[2][i * nz + k - 1] += half;
        }
        let low = self.diagonal.iter().flatten().map(|xi| xi.re + xi.im * tan);
        (sums.into_iter().flatten().fold(0.0, f64::max), low.fold(f64::INFINITY, f64::min))
    }
}
