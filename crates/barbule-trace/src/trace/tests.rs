use super::*;

/// Lattices of solid and of hollow rods, hexagonal and square, turned by up to 10°.
fn rods(seed: u64) -> Rods {
    let is_hexagonal = seed.is_multiple_of(2);
    Rods {
        middle: [240.0, 190.0],
        period: if is_hexagonal { 80.0 } else { 76.0 },
        pitch: 72.0,
        shift: if is_hexagonal { 0.5 } else { 0.0 },
        diameter: 56.0,
        hollow: if seed % 4 < 2 { 29.0 } else { 0.0 },
        rows: 4,
        columns: 5,
        turn_deg: 2.5 * (seed % 5) as f64,
        spread: 0.02,
        seed,
    }
}

/// Shading to 40 %, stain to 20 %, blur to 3 px, noise to 8 % in all mixtures.
fn microscope(seed: u64) -> Micrograph {
    Micrograph {
        size: [480, 380],
        shading: 0.1 * (seed % 5) as f64,
        stain: 0.1 * (seed % 3) as f64,
        blur: [0.0, 1.0, 2.0, 3.0][(seed % 4) as usize],
        noise: 0.02 * ((seed / 2) % 5) as f64,
        seed,
        ..Micrograph::default()
    }
}

/// Holds a measure within a part of the truth.
fn hold(what: &str, found: f64, truth: f64, part: f64) {
    assert!((found - truth).abs() <= part * truth, "{what}: {found}, but {truth}");
}

#[test]
fn lattices_come_back_within_a_percent() {
    for seed in [0, 1, 2, 3, 5, 8, 11, 14, 18, 19] {
        let rods = rods(seed);
        let (shapes, diameters) = rods.shapes();
        let scope = microscope(seed);
        let traced = trace(&scope.of(1, &shapes).unwrap(), &Options::default()).unwrap();
        let what = format!("{seed}: {scope:?} {rods:?}");
        assert_eq!((traced.kind, traced.rods.len()), (Kind::Lattice, 20), "{what}");
        let lattice = traced.lattice.as_ref().unwrap();
        let truth = Spread::of(&diameters);
        // The places of rods are random to a percent of the period, which a row of five leaves in the mean.
        hold(&format!("period {what}"), lattice.period.mean, rods.period, 0.01);
        hold(&format!("pitch {what}"), lattice.row_pitch.mean, rods.pitch, 0.01);
        assert!((lattice.row_shift.mean - rods.shift).abs() < 0.02, "{what}: {:?}", lattice.row_shift);
        assert!((lattice.turn_deg - rods.turn_deg).abs() < 0.5, "{what}: {}", lattice.turn_deg);
        // Reached: 0.06 % in diameters and in what is hollow.
        hold(&format!("diameter {what}"), lattice.diameter.mean, truth.mean, 2e-3);
        hold(&format!("hollow {what}"), lattice.hollow.mean, truth.mean * rods.hollow / rods.diameter, 3e-3);
        hold(&format!("spread {what}"), lattice.diameter.std, truth.std, 0.05);
        assert!((traced.blur - scope.blur).abs() < 0.55, "{what}: {}", traced.blur);
        // The class that is not there is none.
        assert_eq!(traced.levels.len(), if rods.hollow > 0.0 { 3 } else { 2 }, "{what}");
    }
}

#[test]
fn layers_come_back_within_a_percent() {
    let thick = [80.0, 34.0, 50.0, 26.0];
    for seed in [0, 3, 5, 7, 10, 11, 14] {
        let scope = microscope(seed);
        let turn = ((seed % 6) as f64 - 2.0).to_radians();
        // A sagitta of 6 px.
        let bow = if seed % 3 == 0 { 1e-4 } else { 0.0 };
        let below = if seed % 2 == 0 { 1 } else { 0 };
        let mut height = 80.0;
        let mut shapes = Vec::new();
        for (thickness, medium) in thick.iter().zip([1, 2, 1, 2]).chain([(&0.0, below)]) {
            shapes.push((Shape::Below { height, slope: turn.tan(), bow }, medium));
            height += thickness / turn.cos();
        }
        let traced = trace(&scope.of(0, &shapes).unwrap(), &Options::default()).unwrap();
        let what = format!("{seed}: {scope:?}");
        assert_eq!(traced.bands.classes, [0, 1, 2, 1, 2, below], "{what}");
        for (layer, thickness) in traced.layers.iter().zip(thick) {
            // Reached: 0.4 % of the thinnest at 6 % of noise and 3 px of blur.
            hold(&what, layer.thickness.mean, thickness, 6e-3);
            assert!(layer.thickness.std < 0.6, "{what}: {:?}", layer.thickness);
        }
    }
}

#[test]
fn rods_that_touch_are_parted() {
    for seed in [1, 2, 3] {
        let is_hexagonal = seed == 2;
        let rods = Rods {
            period: 60.0,
            pitch: if is_hexagonal { 52.0 } else { 60.0 },
            diameter: 60.0,
            hollow: if seed == 3 { 26.0 } else { 0.0 },
            spread: 0.0,
            ..rods(seed)
        };
        let scope = Micrograph { noise: 0.03, ..microscope(seed) };
        let traced = trace(&scope.of(1, &rods.shapes().0).unwrap(), &Options::default()).unwrap();
        let lattice = traced.lattice.as_ref().unwrap();
        assert_eq!(traced.rods.iter().filter(|rod| rod.is_parted).count(), 20, "{seed}");
        hold("diameter", lattice.diameter.mean, 60.0, 3e-3);
        hold("period", lattice.period.mean, 60.0, 2e-3);
        hold("pitch", lattice.row_pitch.mean, rods.pitch, 2e-3);
        hold("hollow", lattice.hollow.mean, rods.hollow, 5e-3);
    }
}

#[test]
fn the_surface_above_rods_is_their_cortex_and_anything_else_is_a_section() {
    let scope = microscope(5);
    let mut shapes = vec![(Shape::Below { height: 40.0, slope: 0.0, bow: 0.0 }, 1)];
    let rods = Rods { turn_deg: 0.0, spread: 0.0, middle: [240.0, 210.0], ..rods(1) };
    shapes.extend(rods.shapes().0);
    let picture = scope.of(0, &shapes).unwrap();
    let traced = trace(&picture, &Options::default()).unwrap();
    // The first row's middle is at 102, its upper edge at 74.
    hold("cortex", traced.cortex.unwrap().mean, 34.0, 0.01);
    let options = Options { kind: Some(Kind::Section), ..Options::default() };
    let section = trace(&picture, &options).unwrap();
    assert_eq!((section.kind, section.bands.classes.as_slice()), (Kind::Section, [0, 1].as_slice()));
    // Rods, and the air in each.
    let of = |class: usize| section.inclusions.iter().filter(|(c, _)| *c == class).count();
    assert_eq!((of(2), of(0), of(1)), (20, 20, 0));
    for (class, outline) in &section.inclusions {
        hold("diameter", outline.diameter(), if *class == 2 { 56.0 } else { 29.0 }, 5e-3);
    }
}

#[test]
fn thresholds_that_are_given_are_taken_and_bias_what_they_should() {
    let rods = Rods { hollow: 0.0, spread: 0.0, ..rods(0) };
    let picture = Micrograph { blur: 2.0, noise: 0.01, ..microscope(0) }.of(1, &rods.shapes().0).unwrap();
    let of = |threshold: f64| {
        let options = Options { thresholds: Some(vec![threshold]), ..Options::default() };
        trace(&picture, &options).unwrap().lattice.unwrap().diameter.mean
    };
    // A brighter threshold makes larger rods: at a quarter and three quarters of the step an edge is blurred by 0.674 σ to either side.
    let sigma = 2.0_f64.hypot(0.7);
    let wider = of(40.0 + 0.75 * 175.0) - of(40.0 + 0.25 * 175.0);
    hold("bias", wider, 4.0 * 0.6745 * sigma, 0.05);
}

#[test]
fn scale_bars_are_found_and_cut_away() {
    let clean = microscope(5).of(1, &rods(1).shapes().0).unwrap();
    let mut values = clean.values().to_vec();
    for y in 352..358 {
        values[y * 480 + 330..y * 480 + 450].fill(1.5);
    }
    // Words beside it.
    for y in 338..346 {
        values[y * 480 + 380..y * 480 + 383].fill(1.5);
    }
    let marked = Grey::new(480, 380, values).unwrap();
    let bar = scale_bar(&marked).unwrap();
    assert_eq!((bar.bounds, bar.length), ([330, 352, 450, 358], 120.0));
    assert_eq!(bar.free, [0, 334]);
    assert!(scale_bar(&clean).is_none());
}

#[test]
fn strips_that_hold_the_bar_are_cut_away_with_it() {
    let clean = microscope(5).of(1, &rods(1).shapes().0).unwrap();
    let [width, height] = clean.size();
    // A strip of 60 rows with a bar 30 rows in, and words high in it; at the picture's lower or its upper border.
    let with_strip = |ground: f32, ink: f32, is_below: bool| {
        let mut strip = vec![ground; width * 60];
        for y in 30..36 {
            strip[y * width + 300..y * width + 420].fill(ink);
        }
        for y in 8..20 {
            strip[y * width + 20..y * width + 120].fill(ink);
        }
        let picture = clean.values();
        let values = if is_below { [picture, &strip].concat() } else { [&strip, picture].concat() };
        Grey::new(width, height + 60, values).unwrap()
    };
    for (ground, ink) in [(-0.5, 1.5), (1.5, -0.5)] {
        let bar = scale_bar(&with_strip(ground, ink, true)).unwrap();
        assert_eq!((bar.bounds, bar.length), ([300, height + 30, 420, height + 36], 120.0));
        assert_eq!(bar.free, [0, height - 4]);
        let bar = scale_bar(&with_strip(ground, ink, false)).unwrap();
        assert_eq!((bar.bounds, bar.free), ([300, 30, 420, 36], [64, height + 60]));
    }
    // A layer of some grey that is as even is part of the section: only the bar's own rows and their words go.
    let bar = scale_bar(&with_strip(0.5, 1.5, true)).unwrap();
    assert!(bar.free[1] > height, "{:?}", bar.free);
}

#[test]
fn pictures_that_show_nothing_are_refused() {
    let refusal = |picture: Result<Grey>, options: &Options| {
        let error = picture.and_then(|picture| trace(&picture, options)).unwrap_err();
        assert!(error.is_input());
        error.to_string()
    };
    let usual = Options::default();
    let blank = |value: f32| Grey::new(100, 80, vec![value; 8000]);
    assert!(refusal(blank(0.5), &usual).contains("no two classes"));
    assert!(refusal(blank(f32::NAN), &usual).contains("NaN at pixel 0, 0"));
    assert!(refusal(Grey::new(1, 1, vec![0.0]), &usual).contains("1 × 1 pixels"));
    assert!(refusal(Grey::new(1 << 40, 1 << 40, Vec::new()), &usual).contains("at most 16777216"));
    // Noise alone, and light alone.
    let noise = Micrograph { noise: 0.1, ..microscope(1) }.of(1, &[]);
    assert!(refusal(noise, &usual).contains("no two classes"));
    let light = Micrograph { noise: 0.02, shading: 0.4, ..microscope(1) }.of(1, &[]);
    assert!(refusal(light, &usual).contains("no two classes"));
    let picture = || microscope(1).of(1, &rods(2).shapes().0);
    let of = |kind: Kind| Options { kind: Some(kind), ..Options::default() };
    assert!(refusal(picture(), &of(Kind::Layers)).contains("shows no layers"));
    let few = microscope(1).of(1, &rods(1).shapes().0[..6]);
    assert!(refusal(few, &of(Kind::Lattice)).contains("six rods are needed"));
    let at = |levels: &[f64]| Options { thresholds: Some(levels.to_vec()), ..Options::default() };
    for bad in [&[90.0, 100.0][..], &[0.0], &[], &[200.0, 100.0, 50.0], &[f64::NAN]] {
        assert!(refusal(picture(), &at(bad)).contains("`thresholds`"), "{bad:?}");
    }
    assert!(refusal(picture(), &at(&[254.0])).contains("of one class"));
    let squares =
        (0..1 << 20).map(|at| if (at % 1024 / 8 + at / 8192) % 2 == 0 { 0.2 } else { 0.8 }).collect();
    assert!(refusal(Grey::new(1024, 1024, squares), &usual).contains("regions at these thresholds"));
    let crop = picture().unwrap().part([400, 0, usize::MAX, 40]).unwrap_err();
    assert!(crop.to_string().contains("leaves the picture of 480 × 380"));
}

#[test]
fn curves_of_constant_distance_are_circles_and_blur_takes_what_it_must() {
    // A disc's blurred area is π (r² − σ²) to first order in σ²/r², and unblurring gives π r² back.
    for (radius, blur, part) in [(20.0, 1.0, 4e-4), (20.0, 3.0, 1e-3), (10.0, 3.0, 6e-3)] {
        let scope =
            Micrograph { size: [64, 64], shading: 0.0, stain: 0.0, blur, noise: 0.0, ..microscope(0) };
        let disc = Shape::Disc { center: [31.7, 32.2], radius };
        let picture = scope.of(1, &[(disc, 2)]).unwrap();
        let middle = 0.5 * (0.55 + 0.18);
        let mut classes = regions::classes(&picture, &[middle]);
        let map = Map::of(&mut classes, [64, 64], 5);
        let dark = map.regions.iter().position(|region| region.class == 1).unwrap();
        let bounds = map.regions[dark].bounds;
        let outline = outline::around(&picture, &map, bounds, middle, false, &|label| label == dark).unwrap();
        let found = outline.diameter();
        assert!(found < 2.0 * radius);
        let across = outline::blur_across(&picture, &[&outline], [0.18, 0.55], 1.2 * blur).unwrap();
        assert!((across - blur).abs() < 0.2, "{across}");
        let whole = outline.unblurred(blur);
        hold("area", whole.diameter(), 2.0 * radius, part);
        let (_, [x, y]) = whole.area_and_middle();
        assert!((x - 31.7).abs() < 0.01 && (y - 32.2).abs() < 0.01, "{x} {y}");
    }
}
