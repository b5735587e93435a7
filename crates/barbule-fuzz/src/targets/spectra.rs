//! Tables of numbers: measured spectra, lights, refractive indices.

use std::path::Path;

use barbule::io::measured::{Measured, Scale, parse_measured, read_measurements};
use barbule::io::tables::{parse_index_csv, parse_index_yaml};
use barbule::material::Table;
use barbule::open;

use super::{Target, Weight, bytes_of, finite};
use crate::laws::{Held, holds, judged, sentence};
use crate::{Verdict, scratch};

const TABLE_WORDS: &[&str] = &[
    ",",
    ";",
    "\t",
    " ",
    "\n",
    "\r",
    "\"",
    "%",
    "nm",
    "1/cm",
    "wavelength",
    "wl,",
    "reflectance",
    "sample",
    "angle",
    "30deg",
    "theta_30",
    "400,0.1\n",
    "400;0,1\n",
    "NA",
    "NaN",
    "\u{feff}",
    "\u{b5}m",
    "-",
    ">>>>>Begin Spectral Data<<<<<\n",
    "long",
    "specimen",
];
const JCAMP_WORDS: &[&str] = &[
    "##TITLE=",
    "##JCAMP-DX=",
    "##XUNITS=NANOMETERS\n",
    "##XUNITS=1/CM\n",
    "##YUNITS=REFLECTANCE\n",
    "##XFACTOR=",
    "##YFACTOR=",
    "##FIRSTX=",
    "##LASTX=",
    "##NPOINTS=",
    "##DELTAX=",
    "##XYDATA=(X++(Y..Y))\n",
    "##XYPOINTS=(XY..XY)\n",
    "##END=\n",
    "##BLOCKS=2\n",
    "##DATA TYPE=LINK\n",
    "$$",
    "@A",
    "%J",
    "j12",
    "S",
];
const YAML_WORDS: &[&str] = &[
    "DATA:\n",
    "  - type: tabulated nk\n",
    "  - type: tabulated n\n",
    "  - type: formula 1\n",
    "    data: |\n",
    "    wavelength_range: ",
    "    coefficients: ",
    "&a ",
    "*a",
    "- ",
    ": ",
    "\n",
    "? ",
    "<<: ",
    "---\n",
    "!!str ",
    "'",
    "\"",
    "|\n",
    ">\n",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "measured-table",
        about: "measured spectra as text",
        tokens: TABLE_WORDS,
        seeds: || {
            bytes_of([
                include_str!("../../../../examples/measured/from-r.csv"),
                include_str!("../../../../examples/measured/spectrometer.txt"),
                include_str!("../../../../examples/measured/starling-back.csv"),
                "wl,a 30deg,a 60deg\n400,10,12\n410,11,13\n420,12,14\n430,11,13\n",
                "specimen;wavelength;reflectance\na;400;0,1\na;500;0,2\nb;400;0,3\nb;500;0,4\n",
            ])
            .into_iter()
            .map(|text| text.into_iter().take(6_000).collect())
            .collect()
        },
        check: measured,
        weight: Weight::Text,
    },
    Target {
        name: "measured-jcamp",
        about: "measured spectra in JCAMP-DX",
        tokens: JCAMP_WORDS,
        seeds: || {
            bytes_of([
                include_str!("../../../../examples/measured/starling.jdx"),
                "##TITLE=a\n##JCAMP-DX=4.24\n##XUNITS=NANOMETERS\n##YUNITS=REFLECTANCE\n##XFACTOR=1\n##YFACTOR=0.01\n##FIRSTX=400\n##LASTX=440\n##NPOINTS=5\n##XYDATA=(X++(Y..Y))\n400 10 11 12\n430 13 14\n##END=\n",
            ])
        },
        check: measured,
        weight: Weight::Text,
    },
    Target {
        name: "measured-angles",
        about: "measured spectra of several angles, by the names of samples",
        tokens: TABLE_WORDS,
        seeds: || {
            bytes_of([
                "wl,a 30deg,b 30deg,a 60deg\n400,10,12,9\n410,11,13,8\n420,12,14,7\n430,11,13,6\n",
                "angle,wavelength,reflectance\n0,400,0.1\n0,500,0.2\n45,400,0.3\n45,500,0.4\n",
            ])
        },
        check: |bytes| {
            let path = scratch::file("angles.csv", bytes);
            judged(read_measurements(&[path.to_string_lossy().into_owned()], None, None), |found| {
                found.angles.iter().try_for_each(|at| plausible(&at.measured))
            })
        },
        weight: Weight::Text,
    },
    Target {
        name: "light-file",
        about: "lights as tables of power or quanta",
        tokens: TABLE_WORDS,
        seeds: || {
            bytes_of(["wavelength,power\n300,1\n400,2\n500,3\n600,4\n700,3\n", "300 0\n500 1e-3\n830 0\n"])
        },
        check: |bytes| {
            let path = scratch::file("light.csv", bytes);
            let first = judged(open::light(&path.to_string_lossy()), |_| Ok(()))?;
            judged(open::light(&format!("quanta:{}", path.display())), |_| Ok(()))?;
            Ok(first)
        },
        weight: Weight::Text,
    },
    Target {
        name: "index-table",
        about: "refractive indices in CSV",
        tokens: &[
            "nm",
            "um",
            "\u{b5}m",
            "n",
            "k",
            "wavelength",
            "wl",
            ",",
            ";",
            "\t",
            "\n",
            "eps1",
            "1.5",
            "0.01",
        ],
        seeds: || {
            bytes_of([
                "300,1.6,0.01\n500,1.55,0.005\n830,1.5,0\n",
                "wavelength_nm,n,k\n300,1.6,0.01\n830,1.5,0\n",
                "wl,n\n0.3,1.6\n0.5,1.55\n0.83,1.5\n\nwl,k\n0.3,0.01\n0.5,0.005\n0.83,0\n",
            ])
        },
        check: |bytes| {
            judged(parse_index_csv("index.csv", &String::from_utf8_lossy(bytes)), |table| indices(&table))
        },
        weight: Weight::Text,
    },
    Target {
        name: "index-yaml",
        about: "refractive indices in the YAML of refractiveindex.info",
        tokens: YAML_WORDS,
        seeds: || {
            bytes_of([
                "REFERENCES: \"a\"\nDATA:\n  - type: tabulated nk\n    data: |\n        0.3 1.6 0.01\n        0.5 1.55 0.005\n        0.83 1.5 0\n",
                "DATA:\n  - type: formula 1\n    wavelength_range: 0.3 0.9\n    coefficients: 0 1.03961212 0.0774641735 0.231792344 0.141484679\n  - type: tabulated k\n    data: |\n        0.3 0.1\n        0.9 0\n",
                "DATA:\n  - type: formula 5\n    wavelength_range: 0.3 0.9\n    coefficients: 1.5 0.004 -2\n",
            ])
        },
        check: |bytes| {
            judged(parse_index_yaml("index.yml", &String::from_utf8_lossy(bytes)), |table| indices(&table))
        },
        weight: Weight::Text,
    },
];

fn measured(bytes: &[u8]) -> Verdict {
    let read = |scale| parse_measured("measured.csv", bytes, None, scale);
    let first = judged(read(None), |found| plausible(&found))?;
    judged(read(Some(Scale::Power)), |found| plausible(&found))?;
    judged(parse_measured("measured.csv", bytes, Some("2"), None), |found| plausible(&found))?;
    Ok(first)
}

fn plausible(found: &Measured) -> Held {
    sentence(&found.reading)?;
    holds(!found.samples.is_empty(), || "no sample was accepted".into())?;
    for sample in &found.samples {
        finite(&sample.name, sample.spectrum.values())?;
        holds(sample.spectrum.wavelengths() == found.mean.wavelengths(), || {
            "samples of other wavelengths".into()
        })?;
    }
    finite("mean", found.mean.values())?;
    finite("deviation", found.std.iter().flatten())
}

fn indices(table: &Table) -> Held {
    let nm = table.wavelengths_nm();
    finite("wavelength", nm)?;
    holds(nm.windows(2).all(|pair| pair[0] < pair[1]), || {
        "wavelengths that do not rise were accepted".into()
    })?;
    table.indices().iter().try_for_each(|index| {
        finite("index", [&index.re, &index.im])?;
        holds(index.im >= 0.0, || format!("gain was accepted: {index}"))
    })?;
    holds(Path::new(table.name()).components().count() > 0, || "a table without a name".into())
}
