//! Whether structures are their own mirror images about the middle plane, x → −x.

use super::lattice::{Lattice, Rod};
use super::section::{Inclusion, Loop, Medium, Polyline, Section, profile};

/// Images coincide when they differ by no more than this part of the section's size.
const ALIKE: f64 = 1e-9;

/// Whether light from −φ_i is scattered as the mirror image of light from φ_i, in the mean over the individuals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Symmetry {
    /// It is: the individuals are as probable as their mirror images.
    Mirrored,
    /// It need not be; says what is not its own mirror image.
    OneSided(String),
}

impl Symmetry {
    /// Whether the structure is its own mirror image.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        *self == Self::Mirrored
    }
}

impl Section {
    /// Whether the section is its own mirror image about x = 0, within 1e-9 of its size.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        let reach = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let tops = self.boundaries.iter().map(|b| reach(&b.x_um).max(reach(&b.z_um)));
        let most = ALIKE * tops.fold(self.width_um, f64::max);
        self.boundaries.iter().all(|b| curve_is_mirrored(b, most))
            && self.media.iter().all(|medium| is_image(medium, medium))
            && have_images(&self.inclusions, &self.inclusions, |one| &one.outline, most, &|a, b| {
                are_images(a, b, most)
            })
            && self.crystal.as_ref().is_none_or(|crystal| {
                // At arc length s the crystal looks like the flat one at s − offset.
                let regularity = crystal.regularity.as_ref();
                crystal.lattice.is_mirrored_about(-crystal.offset_um, most)
                    && regularity.is_none_or(|r| values_are_images([&r.x_um, &r.x_um], [&r.value, &r.value]))
            })
    }
}

impl Lattice {
    /// Whether some x → 2c − x maps the crystal onto itself.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        let places: Vec<f64> = self.placed().map(|placed| placed.x_um).collect();
        let Some(first) = places.first() else { return true };
        // The first rod's image is some rod.
        places.iter().any(|x| self.is_mirrored_about(0.5 * (first + x), ALIKE * self.period_um))
    }

    /// Whether x → 2·`axis_um` − x maps the crystal onto itself, within `most` µm.
    fn is_mirrored_about(&self, axis_um: f64, most: f64) -> bool {
        let placed: Vec<_> = self.placed().collect();
        placed.iter().all(|rod| {
            placed.iter().any(|other| {
                let across = (rod.x_um + other.x_um - 2.0 * axis_um) / self.period_um;
                (across - across.round()).abs() * self.period_um <= 2.0 * most
                    && (rod.depth_um - other.depth_um).abs() <= most
                    && circles_are_alike(&self.rods[rod.rod], &self.rods[other.rod], most)
            })
        })
    }
}

fn circles_are_alike(a: &Rod, b: &Rod, most: f64) -> bool {
    let pairs = || a.circles.iter().zip(&b.circles);
    a.circles.len() == b.circles.len()
        && pairs().all(|(a, b)| a.medium == b.medium && (a.diameter_um - b.diameter_um).abs() <= most)
}

/// Whether an open curve is its own mirror image, with the same points or with others on it.
fn curve_is_mirrored(curve: &Polyline, most: f64) -> bool {
    let (xs, zs) = (&curve.x_um, &curve.z_um);
    let near = |a: f64, b: f64| (a - b).abs() <= most;
    let points = || xs.iter().zip(zs);
    let reversed = points().rev();
    if points().zip(reversed).all(|((x, z), (back_x, back_z))| near(*x, -back_x) && near(*z, *back_z)) {
        return true;
    }
    // A curve and its image that agree where either bends agree everywhere.
    near(xs[0], -xs[xs.len() - 1]) && points().all(|(x, z)| near(curve.height(-x), *z))
}

/// Whether a medium is another one with x → −x.
fn is_image(a: &Medium, b: &Medium) -> bool {
    match (a, b) {
        (
            Medium::Mixture { first, second, x_um, fraction },
            Medium::Mixture { first: other_first, second: other_second, x_um: other_x, fraction: other },
        ) => {
            (first, second) == (other_first, other_second)
                && values_are_images([x_um, other_x], [fraction, other])
        }
        _ => a == b,
    }
}

/// Whether one profile of values up to about 1 is the other's mirror image; linear between their places.
fn values_are_images(x_um: [&[f64]; 2], values: [&[f64]; 2]) -> bool {
    let agree = |x: &f64, here: usize| {
        let there = 1 - here;
        (profile(x_um[here], values[here], *x) - profile(x_um[there], values[there], -x)).abs() <= ALIKE
    };
    x_um[0].iter().all(|x| agree(x, 0)) && x_um[1].iter().all(|x| agree(x, 1))
}

fn are_images(a: &Inclusion, b: &Inclusion, most: f64) -> bool {
    is_image(&a.medium, &b.medium)
        && loops_are_images(&a.outline, &b.outline, most)
        && a.holes.len() == b.holes.len()
        && have_images(&a.holes, &b.holes, |hole| hole, most, &|a, b| loops_are_images(a, b, most))
}

/// Whether each of `all` has its image among `others`; these are found by their left ends.
fn have_images<T>(
    all: &[T],
    others: &[T],
    outline: fn(&T) -> &Loop,
    most: f64,
    are_images: &dyn Fn(&T, &T) -> bool,
) -> bool {
    let mut by_left: Vec<(f64, &T)> = others.iter().map(|one| (extent(outline(one))[0], one)).collect();
    by_left.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.iter().all(|one| {
        let left = -extent(outline(one))[1];
        let from = by_left.partition_point(|(x, _)| *x < left - most);
        by_left[from..].iter().take_while(|(x, _)| *x <= left + most).any(|(_, other)| are_images(one, other))
    })
}

/// The smallest and the largest x of a loop.
fn extent(shape: &Loop) -> [f64; 2] {
    match shape {
        Loop::Circle { x_um, radius_um, .. } => [x_um - radius_um, x_um + radius_um],
        Loop::Polygon(corners) => corners
            .x_um
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]),
    }
}

fn loops_are_images(a: &Loop, b: &Loop, most: f64) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= most;
    match (a, b) {
        (
            Loop::Circle { x_um, z_um, radius_um },
            Loop::Circle { x_um: other_x, z_um: other_z, radius_um: other_radius },
        ) => near(*x_um, -other_x) && near(*z_um, *other_z) && near(*radius_um, *other_radius),
        (Loop::Polygon(a), Loop::Polygon(b)) => {
            let count = a.x_um.len();
            let is_corner = |i: usize, j: usize| near(a.x_um[i], -b.x_um[j]) && near(a.z_um[i], b.z_um[j]);
            // The corners may begin anywhere and go either way round.
            count == b.x_um.len()
                && (0..count).filter(|&start| is_corner(0, start)).any(|start| {
                    (0..count).all(|i| is_corner(i, (start + count - i) % count))
                        || (0..count).all(|i| is_corner(i, (start + i) % count))
                })
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::structure::{Circle, CrystalLayer, Parts, Structure, Substance};

    fn section(parts: Parts) -> Section {
        let parts = Parts { name: "given".into(), width_um: Some(10.0), ..parts };
        Section::new(parts, Library::builtin()).unwrap()
    }

    fn film(z_um: [f64; 4]) -> Parts {
        let line = |depth: f64| Polyline {
            x_um: vec![-5.0, -1.0, 1.0, 5.0],
            z_um: z_um.iter().map(|z| z - depth).collect(),
        };
        Parts {
            boundaries: vec![line(0.0), line(1.0)],
            media: ["air", "keratin", "air"].map(Medium::named).to_vec(),
            ..Parts::default()
        }
    }

    fn with(inclusions: Vec<(Loop, &str)>) -> Section {
        let inclusion = |(outline, medium): (Loop, &str)| Inclusion {
            outline,
            medium: Medium::named(medium),
            holes: vec![],
        };
        section(Parts { inclusions: inclusions.into_iter().map(inclusion).collect(), ..film([0.0; 4]) })
    }

    #[test]
    fn boundaries_count_by_where_they_are_and_not_by_their_points() {
        assert!(section(film([-1.0, 0.0, 0.0, -1.0])).is_mirrored());
        assert!(!section(film([-1.0, 0.0, 0.0, -1.0 + 1e-7])).is_mirrored());
        assert!(section(film([-1.0, 0.0, 0.0, -1.0 + 1e-12])).is_mirrored());
        assert!(!section(film([-0.5, -0.1, 0.1, 0.5])).is_mirrored());
        // One side has a point more, on its line.
        let mut more = film([0.0; 4]);
        for boundary in &mut more.boundaries {
            boundary.x_um.insert(2, 0.3);
            boundary.z_um.insert(2, boundary.z_um[1]);
        }
        assert!(section(more.clone()).is_mirrored());
        more.boundaries[0].z_um[2] += 0.01;
        assert!(!section(more).is_mirrored());
        // As wide on both sides.
        let mut shifted = film([0.0; 4]);
        shifted.boundaries.iter_mut().for_each(|b| b.x_um[3] = 4.95);
        assert!(!section(shifted).is_mirrored());
    }

    #[test]
    fn mixtures_and_inclusions_have_their_images() {
        let mix = |fraction: [f64; 3]| Medium::Mixture {
            first: Substance::named("keratin"),
            second: Substance::named("melanin"),
            x_um: vec![-2.0, 0.0, 2.0],
            fraction: fraction.to_vec(),
        };
        let filled = |medium: Medium| {
            let mut parts = film([0.0; 4]);
            parts.media[1] = medium;
            section(parts).is_mirrored()
        };
        assert!(filled(mix([0.2, 0.5, 0.2])) && !filled(mix([0.2, 0.5, 0.3])));
        let circle = |x_um: f64| Loop::Circle { x_um, z_um: -0.5, radius_um: 0.2 };
        let box_at =
            |x: f64, dx: f64| Loop::polygon(vec![x, x + dx, x + dx, x], vec![-0.7, -0.7, -0.3, -0.3]);
        assert!(with(vec![(circle(1.0), "melanin"), (circle(-1.0), "melanin")]).is_mirrored());
        assert!(with(vec![(circle(0.0), "melanin")]).is_mirrored());
        assert!(!with(vec![(circle(1.0), "melanin"), (circle(-1.0), "air")]).is_mirrored());
        assert!(!with(vec![(circle(1.0), "melanin"), (circle(-1.1), "melanin")]).is_mirrored());
        assert!(with(vec![(box_at(1.0, 0.5), "melanin"), (box_at(-1.5, 0.5), "melanin")]).is_mirrored());
        assert!(with(vec![(box_at(-0.5, 1.0), "melanin")]).is_mirrored());
        assert!(!with(vec![(box_at(-0.5, 1.1), "melanin")]).is_mirrored());
    }

    #[test]
    fn lattices_are_mirrored_about_some_axis_and_sections_about_their_middle() {
        let lattice = |row_shift: f64, x_um: f64, rows: usize| Lattice {
            period_um: 0.2,
            host: Substance::named("keratin"),
            incidence: Substance::named("air"),
            depth_to_center_um: 0.3,
            rows,
            row_pitch_um: 0.18,
            row_shift,
            rods: vec![Rod {
                x_um,
                z_um: 0.0,
                rows: None,
                circles: vec![Circle { diameter_um: 0.1, medium: Substance::named("melanin") }],
            }],
            library: Library::builtin(),
        };
        for shift in [0.0, 0.5, -0.5, 1.0] {
            assert!(lattice(shift, 0.03, 3).is_mirrored(), "{shift}");
        }
        assert!(!lattice(0.3, 0.0, 3).is_mirrored() && lattice(0.3, 0.0, 1).is_mirrored());
        let under = |lattice: Lattice, offset_um: f64| {
            let parts = Parts {
                boundaries: film([0.0; 4]).boundaries[..1].to_vec(),
                media: ["air", "keratin"].map(Medium::named).to_vec(),
                crystal: Some(CrystalLayer { lattice, offset_um, regularity: None }),
                ..Parts::default()
            };
            section(parts).is_mirrored()
        };
        assert!(under(lattice(0.5, 0.0, 3), 0.0) && under(lattice(0.5, 0.0, 3), 0.1));
        assert!(under(lattice(0.5, 0.03, 3), -0.03) && !under(lattice(0.5, 0.03, 3), 0.0));
    }

    #[test]
    fn species_and_stacks_are_mirrored_and_given_sections_where_each_is() {
        for name in ["starling", "rock-dove", "hummingbird", "mallard", "magpie", "peafowl"] {
            assert!(Structure::builtin(name).unwrap().symmetry().is_mirrored(), "{name}");
        }
        for stack in ["air/keratin:300/air", "air/3*(melanin:90/keratin:100±5%)/air"] {
            assert!(Structure::flat(stack).unwrap().symmetry().is_mirrored(), "{stack}");
        }
        let starling = Structure::builtin("starling").unwrap();
        let even = section(film([-1.0, 0.0, 0.0, -1.0]));
        let sections = vec![even.clone(), starling.instance(1, 0).unwrap()];
        let folder = Structure::Sections { name: "mine/".into(), sections };
        assert_eq!(
            folder.symmetry(),
            Symmetry::OneSided("section 1 of mine/ is not its own mirror image".into())
        );
        let one = Structure::Sections { name: "even".into(), sections: vec![even] };
        assert!(one.symmetry().is_mirrored());
    }
}
