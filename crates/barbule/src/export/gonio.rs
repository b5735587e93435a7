//! Tables as goniometers measure them: a value for every pair of directions of a grid, of materials that were simulated.

use std::fmt::Write as _;

use rayon::prelude::*;

use crate::brdf::FeatherBrdf;
use crate::progress::Progress;
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::Observer;
use crate::{DVec3, Error, Result};

/// Most values of a table: 160 MB as text.
pub const MOST_VALUES: usize = 16_000_000;

/// Wavelengths of one call of the BRDF.
const LANES: usize = 8;

/// The directions and wavelengths of a table: polar angles from the normal and azimuths from +x (across the barbule) towards +y (along it),
/// degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct GonioGrid {
    /// Polar angles of the light, rising, from 0 and under 90.
    pub theta_i_deg: Vec<f64>,
    /// Its azimuths, rising, from 0 and under 360.
    pub phi_i_deg: Vec<f64>,
    /// Polar angles of the detector, rising, from 0 and under 90.
    pub theta_s_deg: Vec<f64>,
    /// Its azimuths, rising, from 0 and under 360.
    pub phi_s_deg: Vec<f64>,
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
}

impl Default for GonioGrid {
    /// Light every 15° to 75° and 45° around, detectors every 5° to 85° and 10° around, 400 to 700 nm in steps of 20 nm.
    fn default() -> Self {
        let steps = |step: f64, last: f64| (0..=(last / step) as usize).map(|k| step * k as f64).collect();
        Self {
            theta_i_deg: steps(15.0, 75.0),
            phi_i_deg: steps(45.0, 315.0),
            theta_s_deg: steps(5.0, 85.0),
            phi_s_deg: steps(10.0, 350.0),
            wavelengths: Wavelengths::new(
                steps(20.0, 300.0).iter().map(|nm| 400.0 + nm).collect::<Vec<f64>>(),
            )
            .unwrap_or_else(|_| Wavelengths::usual()),
        }
    }
}

impl GonioGrid {
    /// Refuses angles that are not as described, and tables over [`MOST_VALUES`].
    ///
    /// # Errors
    /// These.
    pub fn check(&self) -> Result<()> {
        for (name, angles, end) in [
            ("theta_i", &self.theta_i_deg, 90.0),
            ("phi_i", &self.phi_i_deg, 360.0),
            ("theta_s", &self.theta_s_deg, 90.0),
            ("phi_s", &self.phi_s_deg, 360.0),
        ] {
            let rises = angles.windows(2).all(|pair| pair[0] < pair[1]);
            if angles.first() != Some(&0.0) || !rises || angles.last().is_none_or(|last| *last >= end) {
                return Err(Error::input(format!(
                    "the angles {name} of a table rise from 0 to under {end} degrees; give such"
                )));
            }
        }
        let values = self.lengths().iter().fold(self.wavelengths.len(), |all, n| all.saturating_mul(*n));
        if values > MOST_VALUES {
            return Err(Error::input(format!(
                "a table of {values} values is over the limit of {MOST_VALUES}; take fewer angles or wavelengths"
            )));
        }
        Ok(())
    }

    /// How many θ_i, φ_i, θ_s, φ_s.
    #[must_use]
    pub fn lengths(&self) -> [usize; 4] {
        [&self.theta_i_deg, &self.phi_i_deg, &self.theta_s_deg, &self.phi_s_deg].map(Vec::len)
    }
}

/// The unit vector of a polar angle and an azimuth, degrees.
#[must_use]
pub fn polar_direction(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let (theta, phi) = (theta_deg.to_radians(), phi_deg.to_radians());
    let (sine, cosine) = (libm::sin(theta), libm::cos(theta));
    DVec3::new(sine * libm::cos(phi), sine * libm::sin(phi), cosine)
}

/// A table of the mean over a material's barbules.
#[derive(Debug, Clone, PartialEq)]
pub struct Gonio {
    grid: GonioGrid,
    /// f in 1/sr, `[θ_i, φ_i, θ_s, φ_s, λ]`.
    values: Vec<f32>,
}

impl Gonio {
    /// The table of a material; `progress` counts directions of light.
    ///
    /// # Errors
    /// As [`GonioGrid::check`], or a stop by `progress`.
    pub fn of(brdf: &FeatherBrdf, grid: GonioGrid, progress: &dyn Progress) -> Result<Self> {
        grid.check()?;
        let waves: Vec<[f32; LANES]> = grid
            .wavelengths
            .nm()
            .chunks(LANES)
            // Where fewer are left, the last fills up.
            .map(|some| std::array::from_fn(|k| some[k.min(some.len() - 1)] as f32))
            .collect();
        let [thetas, phis, ..] = grid.lengths();
        progress.begin("table", (thetas * phis) as u64);
        let blocks: Vec<Vec<f32>> = (0..thetas * phis)
            .into_par_iter()
            .map(|at| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let wi = polar_direction(grid.theta_i_deg[at / phis], grid.phi_i_deg[at % phis]);
                let prepared: Vec<_> = waves.iter().map(|nm| brdf.prepare(*nm, wi)).collect();
                let mut block = Vec::new();
                for &theta in &grid.theta_s_deg {
                    for &phi in &grid.phi_s_deg {
                        let wo = polar_direction(theta, phi);
                        let row = prepared.iter().flat_map(|prepared| prepared.eval(wo, None));
                        block.extend(row.take(grid.wavelengths.len()));
                    }
                }
                progress.advance(1);
                Ok(block)
            })
            .collect::<Result<_>>()?;
        Ok(Self { grid, values: blocks.concat() })
    }

    /// Its directions and wavelengths.
    #[must_use]
    pub fn grid(&self) -> &GonioGrid {
        &self.grid
    }

    /// f in 1/sr of each wavelength at a node: places of θ_i, φ_i, θ_s, φ_s in the grid.
    ///
    /// # Panics
    /// A place past the grid's end.
    #[must_use]
    pub fn at(&self, places: [usize; 4]) -> &[f32] {
        let row = places.iter().zip(self.grid.lengths()).fold(0, |row, (place, length)| row * length + place);
        let waves = self.grid.wavelengths.len();
        &self.values[row * waves..][..waves]
    }

    /// f cosθ_s in 1/sr of each wavelength for any two directions above the horizon, linear between the nodes of each angle; beyond the
    /// last polar angle its own values hold. What a program reads out of the table that does nothing clever.
    #[must_use]
    pub fn interpolated(&self, wi: DVec3, wo: DVec3) -> Vec<f64> {
        let GonioGrid { theta_i_deg, phi_i_deg, theta_s_deg, phi_s_deg, .. } = &self.grid;
        let angles = |w: DVec3| {
            let polar = libm::atan2(w.x.hypot(w.y), w.z).to_degrees();
            (polar, libm::atan2(w.y, w.x).to_degrees().rem_euclid(360.0))
        };
        let ((theta_i, phi_i), (theta_s, phi_s)) = (angles(wi), angles(wo));
        let ends = [
            held(theta_i_deg, theta_i),
            around(phi_i_deg, phi_i),
            held(theta_s_deg, theta_s),
            around(phi_s_deg, phi_s),
        ];
        let mut sums = vec![0.0; self.grid.wavelengths.len()];
        for corner in 0..16_usize {
            let side = |axis: usize| corner >> axis & 1;
            let weight: f64 = (0..4).map(|axis| ends[axis][side(axis)].1).product();
            if weight > 0.0 {
                let values = self.at(std::array::from_fn(|axis| ends[axis][side(axis)].0));
                sums.iter_mut().zip(values).for_each(|(sum, f)| *sum += weight * f64::from(*f));
            }
        }
        sums.iter().map(|f| f * wo.z).collect()
    }

    /// The table as text: lines of comments, then a line of names and one for each pair of directions, comma separated. Polar angles and
    /// azimuths are those of ASTM E2387, values f in 1/sr, without the cosine.
    #[must_use]
    pub fn csv(&self, notes: &[(&str, &str)]) -> String {
        let mut text =
            String::from("# BRDF of a simulated feather's barbules, mean over them, unpolarized light\n");
        for (name, note) in notes {
            let _ = writeln!(text, "# {name}: {}", note.replace(['\n', '\r'], " "));
        }
        text += "# theta: polar angle from the barbule's normal, degrees; phi: azimuth from x (across the barbule) towards y (along it), degrees\n";
        text += "# i: towards the source; s: towards the detector; both away from the surface; f_NNN: BRDF in 1/sr at NNN nm (no cosine)\n";
        text += "theta_i,phi_i,theta_s,phi_s";
        for nm in self.grid.wavelengths.nm() {
            let _ = write!(text, ",f_{nm}");
        }
        text.push('\n');
        let mut rows = self.values.chunks(self.grid.wavelengths.len());
        for theta_i in &self.grid.theta_i_deg {
            for phi_i in &self.grid.phi_i_deg {
                for theta_s in &self.grid.theta_s_deg {
                    for phi_s in &self.grid.phi_s_deg {
                        let _ = write!(text, "{theta_i},{phi_i},{theta_s},{phi_s}");
                        for f in rows.next().unwrap_or_default() {
                            let _ = write!(text, ",{f}");
                        }
                        text.push('\n');
                    }
                }
            }
        }
        text
    }

    /// The table as planes of a picture: a tile for each direction of light, θ_i from top to bottom and φ_i from left to right; in it the
    /// detector's θ_s from top to bottom and φ_s from left to right. Values are f cosθ_s in 1/sr: planes R, G, B in linear sRGB (D65) and
    /// one for each wavelength, called as pictures call theirs (`S0.550,0nm`).
    #[must_use]
    pub fn planes(&self) -> GonioPlanes {
        let [thetas_i, phis_i, thetas_s, phis_s] = self.grid.lengths();
        let size = [phis_i * phis_s, thetas_i * thetas_s];
        let nm = self.grid.wavelengths.nm();
        let weights = Observer::default().weights(&self.grid.wavelengths);
        let mut planes: Vec<(String, Vec<f32>)> =
            ["R", "G", "B"].iter().map(|name| ((*name).to_owned(), Vec::new())).collect();
        planes.extend(
            nm.iter().map(|nm| (format!("S0.{}nm", format!("{nm:?}").replace('.', ",")), Vec::new())),
        );
        for y in 0..size[1] {
            let theta_s = y % thetas_s;
            let cosine = libm::cos(self.grid.theta_s_deg[theta_s].to_radians());
            for x in 0..size[0] {
                let row = self.at([y / thetas_s, x / phis_s, theta_s, x % phis_s]);
                let seen: Vec<f64> = row.iter().map(|f| f64::from(*f) * cosine).collect();
                let all = weights.linear_rgb(&seen).into_iter().chain(seen);
                planes.iter_mut().zip(all).for_each(|((_, plane), value)| plane.push(value as f32));
            }
        }
        GonioPlanes { size: size.map(|side| side as u32), planes, facts: self.facts() }
    }

    /// What a reader of the planes needs: the angles of the tiles.
    fn facts(&self) -> Vec<(String, String)> {
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        [
            ("layout", "tiles: theta_i down, phi_i across; in a tile: theta_s down, phi_s across".to_owned()),
            ("value", "f cos(theta_s), 1/sr".to_owned()),
            ("theta_i_deg", list(&self.grid.theta_i_deg)),
            ("phi_i_deg", list(&self.grid.phi_i_deg)),
            ("theta_s_deg", list(&self.grid.theta_s_deg)),
            ("phi_s_deg", list(&self.grid.phi_s_deg)),
        ]
        .map(|(name, text)| (name.to_owned(), text))
        .into()
    }
}

/// A table as [`io::image::write_exr`](crate::io::image::write_exr) takes it.
#[derive(Debug, Clone, PartialEq)]
pub struct GonioPlanes {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Names and values, row by row from the top.
    pub planes: Vec<(String, Vec<f32>)>,
    /// Attributes: the angles of the tiles, and what values mean.
    pub facts: Vec<(String, String)>,
}

/// Two places of a rising list and their shares, for a value between them; past its ends these hold.
fn held(nodes: &[f64], value: f64) -> [(usize, f64); 2] {
    let above = nodes.partition_point(|node| *node <= value);
    if above == 0 || above == nodes.len() {
        let end = above.saturating_sub(1);
        return [(end, 1.0), (end, 0.0)];
    }
    let share = (value - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
    [(above - 1, 1.0 - share), (above, share)]
}

/// The same of azimuths, which close at 360°.
fn around(nodes: &[f64], value: f64) -> [(usize, f64); 2] {
    let last = nodes.len() - 1;
    if value < nodes[last] || last == 0 {
        return held(nodes, value);
    }
    let share = (value - nodes[last]) / (360.0 - nodes[last]);
    [(last, 1.0 - share), (0, share)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Options;
    use crate::brdf::fixtures::example;
    use crate::io::image::{read_exr, write_exr};
    use crate::progress::Unobserved;

    fn table() -> (FeatherBrdf, Gonio) {
        let brdf = FeatherBrdf::new(&example(3), Options::default()).unwrap();
        let grid = GonioGrid {
            theta_i_deg: vec![0.0, 30.0],
            phi_i_deg: vec![0.0, 90.0, 200.0],
            theta_s_deg: vec![0.0, 20.0, 70.0],
            phi_s_deg: vec![0.0, 90.0, 180.0, 270.0],
            wavelengths: Wavelengths::new([430.0, 500.0, 560.0, 610.0, 690.0]).unwrap(),
        };
        let table = Gonio::of(&brdf, grid, &Unobserved).unwrap();
        (brdf, table)
    }

    fn direct(brdf: &FeatherBrdf, wi: DVec3, wo: DVec3, nm: f64) -> f32 {
        brdf.eval([nm as f32; 4], wi, wo, None)[0]
    }

    /// What the text says is what the material has, number by number, and directions are told from their mirror images.
    #[test]
    fn text_is_read_back_as_the_material() {
        let (brdf, table) = table();
        let text = table.csv(&[("material", "example\nmore"), ("material_hash", "ab")]);
        assert!(text.contains("# material: example more\n"));
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        assert_eq!(lines.next().unwrap(), "theta_i,phi_i,theta_s,phi_s,f_430,f_500,f_560,f_610,f_690");
        let mut count = 0;
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let (wi, wo) = (polar_direction(cells[0], cells[1]), polar_direction(cells[2], cells[3]));
            for (nm, f) in table.grid.wavelengths.iter().zip(&cells[4..]) {
                let expected = f64::from(direct(&brdf, wi, wo, *nm));
                assert!((f - expected).abs() <= 1e-5 * expected.abs(), "{line}: {nm} {expected}");
            }
            count += 1;
        }
        assert_eq!(count, 2 * 3 * 3 * 4);
        // x is across: light from 30° across leaves towards the opposite side, not along.
        let mirror = table.at([1, 0, 1, 2])[1];
        let along = table.at([1, 0, 1, 1])[1];
        assert!(mirror > 10.0 * along, "{mirror} {along}");
    }

    #[test]
    fn interpolation_is_the_node_at_nodes_and_between_them_between() {
        let (_, table) = table();
        let (wi, wo) = (polar_direction(30.0, 200.0), polar_direction(20.0, 270.0));
        for (between, node) in table.interpolated(wi, wo).iter().zip(table.at([1, 2, 1, 3])) {
            assert!((between - f64::from(*node) * wo.z).abs() < 1e-6 * between.abs().max(1e-6));
        }
        // Half-way around from the last azimuth to the first.
        let half = polar_direction(20.0, 315.0);
        let ends = [table.at([1, 2, 1, 3])[2], table.at([1, 2, 1, 0])[2]].map(f64::from);
        let found = table.interpolated(wi, half)[2];
        assert!((found - 0.5 * (ends[0] + ends[1]) * half.z).abs() < 1e-6 * found.max(1e-6));
        // Beyond the last polar angle its values hold.
        let (low, last) = (polar_direction(85.0, 0.0), polar_direction(70.0, 0.0));
        let ratio = table.interpolated(wi, low)[0] / table.interpolated(wi, last)[0];
        assert!((ratio - low.z / last.z).abs() < 1e-6);
    }

    /// The picture has every value where docs/formats/gonio.md says.
    #[test]
    fn planes_are_read_back_from_a_file() {
        let (brdf, table) = table();
        let GonioPlanes { size, planes, facts } = table.planes();
        assert_eq!(size, [12, 6]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let facts: Vec<(&str, &str)> = facts.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
        let given = planes.iter().map(|(name, plane)| (name.as_str(), plane.clone())).collect();
        write_exr(&path, size, given, Vec::new(), &facts, &[]).unwrap();
        let back = read_exr(&path).unwrap();
        let (wi, wo) = (polar_direction(30.0, 90.0), polar_direction(20.0, 270.0));
        let pixel = (3 + 1) * 12 + 4 + 3;
        let plane = &planes.iter().find(|(name, _)| name == "S0.500,0nm").unwrap().1;
        let expected = direct(&brdf, wi, wo, 500.0) * wo.z as f32;
        assert!(expected > 0.0 && (plane[pixel] / expected - 1.0).abs() < 1e-5);
        assert_eq!(back.pixels[pixel], [0, 1, 2].map(|c| planes[c].1[pixel]));
    }

    #[test]
    fn grids_are_refused_before_anything_is_computed() {
        let message = |grid: GonioGrid| grid.check().unwrap_err().to_string();
        let usual = GonioGrid::default();
        assert!(usual.check().is_ok());
        assert!(message(GonioGrid { theta_s_deg: vec![0.0, 90.0], ..usual.clone() }).contains("theta_s"));
        assert!(message(GonioGrid { phi_i_deg: vec![10.0], ..usual.clone() }).contains("phi_i"));
        assert!(message(GonioGrid { theta_i_deg: vec![0.0, 5.0, 5.0], ..usual.clone() }).contains("theta_i"));
        let fine = (0..3600).map(|k| 0.1 * f64::from(k)).collect();
        assert!(message(GonioGrid { phi_s_deg: fine, ..usual }).contains("over the limit"));
    }
}
