//! Descriptions in TOML and JSON.

use barbule::atlas::Plan;
use barbule::fields::{Record as _, parse_toml};
use barbule::io::{
    kind_of, lattice_toml, parse_section, parse_stack, read_eye, read_lattice, read_sensor,
    read_species_file, section_json,
};
use barbule::scene::feather::Feather;
use barbule::structure::{SpeciesFile, Structure};
use barbule::vision::Eye;
use barbule::{Error, Result, SceneDescription, Sensor};
use barbule_birds::{BIRDS, EYES};

use super::{Target, Weight, bytes_of, finite, library};
use crate::laws::{Held, comes_back, holds, judged};
use crate::{Verdict, scratch};

const SCENE_WORDS: &[&str] = &[
    "preset = \"starling\"\n",
    "preset = ",
    "material = ",
    "[camera]\n",
    "[light]\n",
    "[window]\n",
    "[sky_image]\n",
    "[[objects]]\n",
    "[feather]\n",
    "[coat]\n",
    "up = [0, 0, 1]\n",
    "up = [1e-9, 1, 1e300]\n",
    "width_mm = ",
    "shows_feather = false\n",
    "nan",
    "inf",
    "= [",
    "]",
    "\"",
    "'",
    "= {",
    "}",
    "#",
    "\n",
    "1979-05-27",
    "true",
];
const SPECIES_WORDS: &[&str] = &[
    "barbule = 1\n",
    "generator = ",
    "name = ",
    "[parameters]\n",
    "[[variants]]\n",
    "[materials]\n",
    "[lattice]\n",
    "[[lattice.rod]]\n",
    "[feather]\n",
    "preset = ",
    "default = ",
    "U(0.1, 0.2)",
    "keratin = [1.56, 0.01]\n",
    "x = \"none.csv\"\n",
    "nan",
    "= [",
    "]",
    "\"",
    "\n",
];
const LATTICE_WORDS: &[&str] = &[
    "[lattice]\n",
    "[[lattice.rod]]\n",
    "[materials]\n",
    "period = ",
    "host = ",
    "incidence = ",
    "cortex = ",
    "rows = ",
    "row_pitch = ",
    "row_shift = ",
    "rod = ",
    "depth_to_center = ",
    "{index = [1.5, 0.1]}",
    "\"keratin\"",
    "\"lattice\": ",
    "\"rod\": [",
    "null",
    "{",
    "}",
];
const JSON_WORDS: &[&str] = &[
    "\"boundaries\": ",
    "\"media\": ",
    "\"inclusions\": ",
    "\"holes\": ",
    "\"materials\": ",
    "\"lattice\": ",
    "\"width\": ",
    "\"units\": \"um\"",
    "\"x\": [",
    "\"z\": [",
    "\"mix\": [",
    "\"fraction\": ",
    "\"index\": [1.5, 0.1]",
    "null",
    "true",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "NaN",
    "\\u0000",
];
const SENSOR_WORDS: &[&str] = &[
    "wavelength_nm = [",
    "[[channels]]\n",
    "name = ",
    "values = [",
    "to_xyz = [",
    "wavelength_nm,",
    "300,",
    "830,",
    "nan",
    "1e308",
    "]",
    "\n",
];
const EYE_WORDS: &[&str] = &[
    "[[cones]]\n",
    "[double]\n",
    "pigment_nm = ",
    "peak_nm = ",
    "droplet = ",
    "cut_nm = ",
    "mid_nm = ",
    "abundance = ",
    "ocular_half_nm = ",
    "weber = ",
    "beta = true\n",
    "1e308",
    "nan",
    "inf",
    "\n",
];
const PLAN_WORDS: &[&str] = &[
    "barbule = 1\n",
    "[[vary]]\n",
    "[[patches]]\n",
    "[material]\n",
    "[patches.set]\n",
    "key = ",
    "values = [",
    "steps = ",
    "samples = ",
    "structure = ",
    "wavelengths_nm = ",
    "impossible = ",
    "unit_cells = ",
    "birds = [",
    "nan",
    "1e308",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "species",
        about: "species in TOML",
        tokens: SPECIES_WORDS,
        seeds: || bytes_of(BIRDS.iter().filter_map(|bird| bird.species)),
        check: species,
        weight: Weight::Text,
    },
    Target {
        name: "stack-file",
        about: "stacks in TOML",
        tokens: &[
            "stack = ",
            "entry = ",
            "exit = ",
            "[[layers]]\n",
            "medium = ",
            "thickness_nm = ",
            "spread_nm = ",
            "repeat = ",
            "[materials]\n",
            "layers = [",
            "*(",
        ],
        seeds: || {
            bytes_of([
                "stack = \"air/6*(melanin:99/keratin:100~5)/air\"\n",
                "entry = \"air\"\nexit = \"resin\"\n[[layers]]\nmedium = \"keratin\"\nthickness_nm = 320\n[[layers]]\nrepeat = 3\n[[layers.layers]]\nmedium = \"mix(keratin,melanin,0.4)\"\nthickness_nm = 99.5\n[materials]\nresin = [1.6, 0.01]\n",
            ])
        },
        check: stack,
        weight: Weight::Text,
    },
    Target {
        name: "lattice-toml",
        about: "lattices in TOML",
        tokens: LATTICE_WORDS,
        seeds: || bytes_of([include_str!("../../../../examples/lattices/square-holes.toml")]),
        check: |bytes| lattice("lattice.toml", bytes),
        weight: Weight::Text,
    },
    Target {
        name: "lattice-json",
        about: "lattices in JSON",
        tokens: LATTICE_WORDS,
        seeds: || {
            let toml = parse_toml(include_str!("../../../../examples/lattices/square-holes.toml"));
            toml.iter().map(|value| value.to_string().into_bytes()).collect()
        },
        check: |bytes| lattice("lattice.json", bytes),
        weight: Weight::Text,
    },
    Target {
        name: "section",
        about: "sections in JSON",
        tokens: JSON_WORDS,
        seeds: sections,
        check: section,
        weight: Weight::Text,
    },
    Target {
        name: "scene",
        about: "scenes in TOML",
        tokens: SCENE_WORDS,
        seeds: || {
            let presets = BIRDS.iter().flat_map(|bird| {
                [bird.scene, bird.feather, bird.wing]
                    .into_iter()
                    .flatten()
                    .chain(bird.presets.iter().map(|(_, text)| *text))
            });
            let own = [
                include_str!("../../../barbule/tests/it/data/close-up.toml"),
                "preset = \"starling\"\n[camera]\nwidth_mm = 1.7\nup = [0.1, 0.2, 0.97]\n",
            ];
            bytes_of(presets.chain(own))
        },
        check: |bytes| {
            judged(SceneDescription::parse(&String::from_utf8_lossy(bytes)), |scene| {
                let write = |scene: &SceneDescription| scene.to_toml().map(String::into_bytes);
                comes_back(&scene, write, |bytes| SceneDescription::parse(&String::from_utf8_lossy(bytes)))
            })
        },
        weight: Weight::Text,
    },
    Target {
        name: "feather",
        about: "feathers: the table of species and scenes, and feather types",
        tokens: &[
            "type = \"down\"\n",
            "[shaft]\n",
            "[barbs]\n",
            "[distal]\n",
            "[proximal]\n",
            "[vane]\n",
            "[eye]\n",
            "[disorder]\n",
            "length_mm = ",
            "leading = ",
            "= [",
            "]",
            "nan",
        ],
        seeds: || {
            let types = [
                include_str!("../../../barbule-appearance/src/scene/feather/types/contour.toml"),
                include_str!("../../../barbule-appearance/src/scene/feather/types/down.toml"),
                include_str!("../../../barbule-appearance/src/scene/feather/types/primary.toml"),
                include_str!("../../../barbule-appearance/src/scene/feather/types/train.toml"),
            ];
            bytes_of(
                types
                    .into_iter()
                    .chain(BIRDS.iter().filter_map(|bird| bird.primary))
                    .chain(["type = \"tail\"\n"]),
            )
        },
        check: |bytes| {
            let read = |bytes: &[u8]| {
                parse_toml(&String::from_utf8_lossy(bytes)).and_then(|table| Feather::read(&table, "feather"))
            };
            judged(read(bytes), |feather| comes_back(&feather, |feather| toml_of(&feather.table()), read))
        },
        weight: Weight::Text,
    },
    Target {
        name: "atlas-plan",
        about: "plans of atlases in TOML",
        tokens: PLAN_WORDS,
        seeds: || {
            bytes_of([
                include_str!("../../../../examples/atlas/doves.toml"),
                include_str!("../../../../examples/atlas/ducks.toml"),
                include_str!("../../../../examples/atlas/films.toml"),
                include_str!("../../../../examples/atlas/hummingbirds.toml"),
            ])
        },
        check: |bytes| {
            let read = |bytes: &[u8]| Plan::parse(&String::from_utf8_lossy(bytes));
            judged(read(bytes), |plan| comes_back(&plan, |plan| toml_of(&plan.table()), read))
        },
        weight: Weight::Text,
    },
    Target {
        name: "sensor-toml",
        about: "sensors in TOML",
        tokens: SENSOR_WORDS,
        seeds: || {
            bytes_of([
                "name = 'a'\nwavelength_nm = [300.5, 310, 400.5]\n[[channels]]\nname = 'UV'\nvalues = [0, 1, 1]\n[[channels]]\nname = 'S'\nvalues = [1, 1, 0]\n",
                "wavelength_nm = [400, 700]\nto_xyz = [[0.95], [1], [1.09]]\n[[channels]]\nname = 'v'\nvalues = [1, 1]\n",
            ])
        },
        check: |bytes| judged(read_sensor(&scratch::file("sensor.toml", bytes)), |sensor| sound(&sensor)),
        weight: Weight::Text,
    },
    Target {
        name: "sensor-table",
        about: "sensors in CSV",
        tokens: SENSOR_WORDS,
        seeds: || {
            bytes_of([
                "wavelength_nm,UV,\"S\"\n# cones\n300.5,0,1\n310,1,1\n400.5,1,0\n",
                "wavelength_nm,r,g,b\n400,0,0,1\n550,0.5,1,0\n700,1,0,0\n",
            ])
        },
        check: |bytes| judged(read_sensor(&scratch::file("sensor.csv", bytes)), |sensor| sound(&sensor)),
        weight: Weight::Text,
    },
    Target {
        name: "eye-toml",
        about: "birds' eyes in TOML",
        tokens: EYE_WORDS,
        seeds: || bytes_of(EYES.iter().map(|(_, _, text)| *text)),
        check: |bytes| judged(read_eye(&scratch::file("eye.toml", bytes)), |eye| eye_is_sound(&eye)),
        weight: Weight::Text,
    },
    Target {
        name: "eye-table",
        about: "birds' eyes as curves in CSV",
        tokens: SENSOR_WORDS,
        seeds: || bytes_of(["wavelength_nm,UV,double\n300,0,0\n360,2,0\n400,0,1\n500,0,0\n"]),
        check: |bytes| judged(read_eye(&scratch::file("eye.csv", bytes)), |eye| eye_is_sound(&eye)),
        weight: Weight::Text,
    },
    Target {
        name: "kind",
        about: "what a file is, by its content",
        tokens: &[
            "{",
            "\"boundaries\"",
            "[lattice]",
            "stack =",
            "preset =",
            "generator =",
            "\u{feff}",
            "zarr",
        ],
        seeds: || {
            let texts = [
                "stack = 'air/keratin:300/air'",
                "[lattice]\nperiod = 0.2",
                "{\"lattice\": {}}",
                "preset = 'starling'",
            ];
            bytes_of(texts.into_iter().chain(BIRDS.iter().take(2).filter_map(|bird| bird.species)))
        },
        check: |bytes| judged(kind_of(&scratch::file("kind", bytes)), |_| Ok(())),
        weight: Weight::Text,
    },
];

/// A table as TOML.
fn toml_of(table: &serde_json::Value) -> Result<Vec<u8>> {
    toml::to_string(table)
        .map(String::into_bytes)
        .map_err(|error| Error::machine(format!("no TOML: {error}")))
}

fn species(bytes: &[u8]) -> Verdict {
    judged(read_species_file(&scratch::file("species.toml", bytes), library()), |(file, library)| {
        if let Err(error) = file.model(None, library) {
            return crate::laws::refusal(&error);
        }
        // A copy calls itself one; a copy of the copy is the same text.
        let flat = |file: &SpeciesFile| file.flat_toml(None).map(String::into_bytes);
        let read = |bytes: &[u8]| SpeciesFile::parse(&String::from_utf8_lossy(bytes));
        let copy = flat(&file).and_then(|text| read(&text));
        comes_back(&copy.map_err(|error| format!("no copy can be made: {error}"))?, flat, read)
    })
}

fn stack(bytes: &[u8]) -> Verdict {
    judged(parse_stack(&String::from_utf8_lossy(bytes), &scratch::folder(), library()), |stack| {
        finite("thickness", stack.thickness_nm())
    })
}

fn lattice(name: &str, bytes: &[u8]) -> Verdict {
    judged(read_lattice(&scratch::file(name, bytes), library()), |lattice| {
        // A file of its own says nothing of media that another file defined.
        let read = |bytes: &[u8]| read_lattice(&scratch::file("again.toml", bytes), &lattice.library);
        comes_back(&lattice, |lattice| lattice_toml(lattice).map(String::into_bytes), read)
    })
}

fn sections() -> Vec<Vec<u8>> {
    let shipped = ["starling", "mallard"].into_iter().map(Structure::builtin);
    let made = shipped.chain([Structure::flat("air/keratin:300/melanin:20/air")]);
    let sections = made.filter_map(|structure| structure.and_then(|structure| structure.instance(1, 0)).ok());
    let example = include_str!("../../../../examples/granules.json");
    // Long ones teach nothing that short ones do not.
    let texts = sections.map(|section| section_json(&section).to_string()).filter(|text| text.len() < 30_000);
    bytes_of([example]).into_iter().chain(texts.map(String::into_bytes)).collect()
}

fn section(bytes: &[u8]) -> Verdict {
    let folder = scratch::folder();
    judged(parse_section(&String::from_utf8_lossy(bytes), &folder, library()), |section| {
        let library = section.library.clone();
        let read = |bytes: &[u8]| parse_section(&String::from_utf8_lossy(bytes), &folder, &library);
        comes_back(&section, |section| Ok(section_json(section).to_string().into_bytes()), read)
    })
}

/// Channels answer in numbers, and to some light.
fn sound(sensor: &Sensor) -> Held {
    for channel in sensor.channels() {
        finite(&channel.name, channel.response.values())?;
        let sum = sensor.band().integral(&channel.response);
        holds(sum.is_finite() && sum > 0.0, || format!("{}: its integral is {sum}", channel.name))?;
    }
    finite("white", sensor.white())
}

/// Cones answer in numbers from 0 to 1.
fn eye_is_sound(eye: &Eye) -> Held {
    for cone in eye.all_cones() {
        let values = cone.sensitivity.values();
        finite(&cone.name, values)?;
        holds(values.iter().all(|value| (0.0..=1.0 + 1e-9).contains(value)), || {
            format!("{}: not within 0 to 1", cone.name)
        })?;
        holds(values.iter().any(|value| *value > 0.5), || format!("{}: answers to nothing", cone.name))?;
        finite(&cone.name, [&cone.peak_nm, &cone.abundance])?;
    }
    Ok(())
}
