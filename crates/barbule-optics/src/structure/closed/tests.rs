//! Closed regions against the sections that they come from.

use super::crystal::SHRUNK_UM;
use super::*;
use crate::structure::{Structure, species_names};

/// Points over a section's width and height.
fn grid(section: &Section) -> impl Iterator<Item = [f64; 2]> {
    let half = 0.5 * section.width_um;
    (0..400).flat_map(move |i| {
        let x = half * (2.0 * (f64::from(i) + 0.5) / 400.0 - 1.0);
        (0..300).map(move |k| [x, 1.5 - 10.0 * (f64::from(k) + 0.5) / 300.0])
    })
}

#[test]
fn regions_are_the_layers_of_the_section() {
    for name in species_names() {
        for instance in [0, 3] {
            let section = Structure::builtin(name).unwrap().instance(1, instance).unwrap();
            let closed = section
                .closed(Beneath::Absorbing, Ends::Closed)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(closed.regions.boundaries.is_empty() && closed.regions.width_um == section.width_um);
            if section.crystal.is_some() {
                continue;
            }
            let inside = 0.5 * section.width_um - 0.7;
            let (mut same, mut all) = (0, 0);
            for [x, z] in grid(&section).filter(|[x, _]| x.abs() < inside) {
                // Air around is not counted.
                if z < section.top().height(x)
                    && z > section.boundaries[section.boundaries.len() - 1].height(x)
                {
                    all += 1;
                    same += usize::from(closed.fast.medium_at(x, z) == closed.regions.medium_at(x, z));
                }
            }
            assert!(same * 1000 >= all * 995, "{name} {instance}: {same} of {all} points are the same");
        }
    }
}

#[test]
fn every_rod_of_a_crystal_is_there() {
    for name in ["mallard", "magpie", "peafowl"] {
        let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
        let layer = section.crystal.as_ref().unwrap();
        let circles = layer.circles(section.top()).len();
        for (beneath, more) in [(Beneath::Absorbing, 1 + RAMP.len()), (Beneath::Host, 1)] {
            let closed = section.closed(beneath, Ends::Closed).unwrap();
            let left_out = circles + more - closed.regions.inclusions.len();
            assert!(left_out * 20 <= circles, "{name}: {left_out} of {circles}");
            assert!(closed.fast.crystal.as_ref().unwrap().regularity.is_none());
        }
        let touching = closed_changes(&section);
        // Hollow rods of the magpie touch everywhere.
        assert!(name != "magpie" || touching.contains("would touch"), "{touching}");
    }
}

/// Circles of closed crystals: centre, radius, medium.
fn closed_circles(closed: &Closed) -> Vec<([f64; 2], f64, &Medium)> {
    let circle = |inclusion: &'_ Inclusion| match inclusion.outline {
        Loop::Circle { x_um, z_um, radius_um } => Some(([x_um, z_um], radius_um)),
        Loop::Polygon(_) => None,
    };
    let inclusions = closed.regions.inclusions.iter();
    inclusions.filter_map(|i| circle(i).map(|(centre, radius)| (centre, radius, &i.medium))).collect()
}

#[test]
fn rods_keep_their_distance_and_their_media() {
    for name in ["mallard", "magpie", "peafowl"] {
        let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
        let closed = section.closed(Beneath::Absorbing, Ends::Closed).unwrap();
        let mut circles = closed_circles(&closed);
        circles.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let (mut least_um, mut compared) = (f64::INFINITY, 0);
        for (i, (a, r, medium)) in circles.iter().enumerate() {
            let mut is_innermost = true;
            let near = |other: &&([f64; 2], f64, &Medium)| (other.0[0] - a[0]).abs() < 1.0;
            let others = circles[i + 1..].iter().take_while(near);
            for (b, q, _) in others.chain(circles[..i].iter().rev().take_while(near)) {
                let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
                // Beside each other, or one in the other.
                let gap = if apart < r.max(*q) { (r - q).abs() - apart } else { apart - r - q };
                least_um = least_um.min(gap);
                compared += 1;
                is_innermost &= apart >= *r || q > r;
            }
            if is_innermost {
                assert_eq!(closed.regions.medium_at(a[0], a[1]), *medium, "{name}, rod at {a:?}");
            }
        }
        assert!(compared > circles.len() && least_um > 0.99 * 2.0 * SHRUNK_UM, "{name}: {least_um} µm");
        // Between the rods and the absorbing region is the host, around the body air.
        let [x, top] = [0.0, section.top().height(0.0)];
        assert_eq!(closed.regions.medium_at(x, top + 0.1), &section.media[0]);
        let at = closed.regions.medium_at(x, top - 0.5 * GAP_UM);
        assert_eq!(at, &section.media[1], "{name}");
        let deep = closed.regions.medium_at(x, top - 3.5);
        assert_eq!(deep, &Medium::named("absorbing-host-4"), "{name}");
    }
}

/// Crossings of vertical lines with all curves: they come in pairs, and no two are nearer than the gap.
#[test]
fn layers_keep_their_gap_along_z() {
    for name in ["starling", "rock-dove", "bronzewing"] {
        let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
        let closed = section.closed(Beneath::Absorbing, Ends::Closed).unwrap();
        let polygons: Vec<Polyline> =
            closed.regions.inclusions.iter().map(|inclusion| inclusion.outline.corners()).collect();
        let half = 0.5 * section.width_um - 0.5;
        let (mut least_um, mut layered) = (f64::INFINITY, 0);
        for i in 0..500 {
            let x = half * (2.0 * (f64::from(i) + 0.43) / 500.0 - 1.0);
            let mut z = Vec::new();
            for corners in &polygons {
                let count = corners.x_um.len();
                for (i, k) in (0..count).map(|i| (i, (i + 1) % count)) {
                    let (a, b) = (corners.x_um[i], corners.x_um[k]);
                    if (a > x) != (b > x) {
                        let t = (x - a) / (b - a);
                        z.push(corners.z_um[i] + t * (corners.z_um[k] - corners.z_um[i]));
                    }
                }
            }
            z.sort_by(f64::total_cmp);
            assert!(z.len() >= 2 && z.len().is_multiple_of(2), "{name} at {x}: {z:?}");
            layered += usize::from(z.len() >= 4);
            least_um = z.windows(2).map(|pair| pair[1] - pair[0]).fold(least_um, f64::min);
        }
        assert!(layered > 400, "{name}: layers at {layered} of 500 places");
        assert!(least_um > 0.9 * GAP_UM, "{name}: {least_um} µm");
    }
}

fn closed_changes(section: &Section) -> String {
    section.closed(Beneath::Absorbing, Ends::Closed).unwrap().changes.join("; ")
}

#[test]
fn interfaces_that_give_way_are_said_to() {
    let said = closed_changes(&Structure::builtin("bronzewing").unwrap().instance(1, 0).unwrap());
    assert!(said.contains("melanin keeps 10 nm from the boundaries around it"), "{said}");
    let said = closed_changes(&Structure::builtin("starling").unwrap().instance(1, 0).unwrap());
    assert!(!said.contains("keeps 10 nm from"), "{said}");
}

#[test]
fn a_layer_without_its_like_below_keeps_a_gap() {
    let section = Structure::builtin("rock-dove").unwrap().instance(1, 0).unwrap();
    let said = closed_changes(&section);
    assert!(said.contains("keeps 10 nm of air under it"), "{said}");
    assert!(said.contains("uniform: 0.890"), "{said}");
    let open = Structure::flat("air/keratin:500/melanin").unwrap().instance(1, 0).unwrap();
    assert!(open.closed(Beneath::Absorbing, Ends::Closed).is_err());
}

/// Layers that air parts end in it, and the fast section loses what the regions lose; what touches lies in walls as ever.
#[test]
fn open_ends_are_slabs_in_air() {
    let section = Structure::builtin("rock-dove").unwrap().instance(1, 0).unwrap();
    let closed = section.closed(Beneath::Absorbing, Ends::Open).unwrap();
    let said = closed.changes.join("; ");
    assert!(said.contains("keratin and mix(air,melanin,0.8") && said.contains("end freely in air"), "{said}");
    assert!(
        said.contains("the keratin under mix(air,melanin,0.8") && said.contains("is left out on both sides"),
        "{said}"
    );
    assert_eq!((closed.regions.inclusions.len(), closed.fast.boundaries.len()), (2, 4));
    assert_eq!(closed.fast.media.last(), Some(&Medium::named("air")));
    let edge = 0.5 * section.width_um - 0.01;
    for x in [-edge, -3.0, 0.0, 5.0, edge] {
        let mut parts = closed.fast.boundaries.iter().map(|curve| curve.height(x));
        let heights: [f64; 4] = std::array::from_fn(|_| parts.next().unwrap());
        for (k, pair) in heights.windows(2).enumerate() {
            let middle = 0.5 * (pair[0] + pair[1]);
            assert_eq!(closed.regions.medium_at(x, middle), &closed.fast.media[k + 1], "{x} {k}");
        }
        assert_eq!(closed.regions.medium_at(x, heights[3] - 0.05), &section.media[0]);
    }
    // One body in air is the same either way.
    for name in ["starling", "hummingbird", "bronzewing"] {
        let section = Structure::builtin(name).unwrap().instance(1, 0).unwrap();
        let [open, closed] =
            [Ends::Open, Ends::Closed].map(|ends| section.closed(Beneath::Absorbing, ends).unwrap());
        assert_eq!((open.regions, open.fast), (closed.regions, closed.fast), "{name}");
    }
    // Nothing is left out that light reaches.
    let film = Structure::flat("air/keratin:300/melanin:200/air").unwrap().instance(1, 0).unwrap();
    let open = film.closed(Beneath::Absorbing, Ends::Open).unwrap();
    assert_eq!(open.fast.boundaries.len(), 3);
    assert!(
        open.changes.join("; ").contains("melanin keeps 10 nm of keratin under it"),
        "{:?}",
        open.changes
    );
}

/// The flat crystal has the rods of the regions: as much area in each row, where the beam's light is.
#[test]
fn both_sides_get_the_same_rods() {
    for (name, width_um) in [("magpie", 3.0), ("magpie", 12.0), ("peafowl", 12.0), ("mallard:blue", 10.0)] {
        let species = match Structure::builtin(name).unwrap() {
            Structure::Species(model) => model.with_parameters(&[("width_um", width_um.into())]).unwrap(),
            other => panic!("{other:?}"),
        };
        let section = Structure::Species(Box::new(species)).instance(1, 0).unwrap();
        let closed = section.closed(Beneath::Absorbing, Ends::Open).unwrap();
        assert_eq!(closed.ends, None);
        let layer = section.crystal.as_ref().unwrap();
        let flat = &closed.fast.crystal.as_ref().unwrap().lattice;
        flat.check().unwrap();
        let area = |lattice: &crate::structure::Lattice| -> f64 {
            lattice.placed().map(|placed| lattice.rods[placed.rod].circles[0].diameter_um.powi(2)).sum()
        };
        let of_flat = area(flat) / area(&layer.lattice);
        let within = |x: f64| x.abs() <= 0.25 * width_um;
        let squares = |circles: &mut dyn Iterator<Item = (f64, f64)>| -> f64 {
            circles.filter(|(x, _)| within(*x)).map(|(_, radius)| radius * radius).sum()
        };
        let all = layer.circles(section.top());
        let whole = squares(&mut all.iter().filter(|c| c.circle == 0).map(|c| (c.x_um, c.radius_um)));
        // Of concentric circles the outermost: the others lie in it.
        let circles = closed_circles(&closed);
        let is_outer = |(a, r, _): &&([f64; 2], f64, &Medium)| {
            !circles.iter().any(|(b, q, _)| q > r && (a[0] - b[0]).hypot(a[1] - b[1]) < 0.5 * (q - r) + 1e-9)
        };
        let left =
            squares(&mut circles.iter().filter(is_outer).map(|(centre, radius, _)| (centre[0], *radius)));
        let of_regions = left / whole;
        // Rows have not the same number of rods in the middle.
        assert!((of_flat - of_regions).abs() < 0.02, "{name}, {width_um} µm: {of_flat} {of_regions}");
        assert!(name != "magpie" || of_flat < 0.99, "{name}: {of_flat}");
    }
}
