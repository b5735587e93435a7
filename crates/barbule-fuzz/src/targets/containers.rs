//! Files of Barbule's own, and of measured materials.

use std::sync::OnceLock;

use barbule::brdf::BrdfTables;
use barbule::io::{
    Units, decode_bsdf, decode_grating, decode_material, decode_tables, encode_bsdf, encode_material,
    encode_tables, read_keyed_orders, rgl_arrays, write_grating, write_orders,
};
use barbule::progress::Shard;
use barbule::render::checkpoint;
use barbule::render::film::Film;
use barbule::render::planes::Planes;

use super::{Target, Weight};
use crate::laws::{comes_back, holds, judged, refusal};
use crate::{Seen, Verdict, scratch, seal};

const CONTAINER_WORDS: &[&str] = &[
    "\"__metadata__\":",
    "\"data_offsets\":[",
    "\"dtype\":\"F64\"",
    "\"dtype\":\"U16\"",
    "\"shape\":[",
    "\\\"schema\\\":",
    "\\\"checksum\\\":",
    "\\\"sigma\\\":",
    "null",
    "-1",
    "1e300",
    "18446744073709551615",
];

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "material",
        about: "materials, .barbule",
        tokens: CONTAINER_WORDS,
        seeds: Vec::new,
        check: |bytes| {
            either(bytes, seal::container(bytes, "barbule"), |bytes| {
                judged(decode_material(bytes), |material| {
                    comes_back(&material, encode_material, decode_material)
                })
            })
        },
        weight: Weight::Numbers,
    },
    Target {
        name: "grating",
        about: "gratings, .grating",
        tokens: CONTAINER_WORDS,
        seeds: Vec::new,
        check: |bytes| {
            either(bytes, seal::container(bytes, "barbule-grating"), |bytes| {
                judged(decode_grating(bytes), |grating| {
                    let path = scratch::folder().join("again.grating");
                    let write = |grating: &_| {
                        write_grating(&path, grating).and_then(|()| barbule::io::read_bytes(&path))
                    };
                    comes_back(&grating, write, decode_grating)
                })
            })
        },
        weight: Weight::Numbers,
    },
    Target {
        name: "brdf-tables",
        about: "tables of BRDFs",
        tokens: CONTAINER_WORDS,
        seeds: || {
            let materials = crate::past::files("seeds", "material");
            let tables = materials.iter().filter_map(|(_, bytes)| {
                let material = decode_material(bytes).ok()?;
                let brdf = barbule::FeatherBrdf::new(&material, barbule::brdf::Options::default()).ok()?;
                encode_tables(brdf.tables()).ok()
            });
            tables.collect()
        },
        check: |bytes| {
            either(bytes, seal::container(bytes, "barbule-tables"), |bytes| {
                judged(decode_tables(bytes), |tables: BrdfTables| {
                    comes_back(&tables, encode_tables, decode_tables)
                })
            })
        },
        weight: Weight::Large,
    },
    Target {
        name: "orders",
        about: "a crystal's orders in the cache",
        tokens: CONTAINER_WORDS,
        seeds: Vec::new,
        check: |bytes| {
            either(bytes, seal::orders(bytes, "barbule-orders"), |bytes| {
                judged(read_keyed_orders(&scratch::file("orders", bytes)), |(key, table)| {
                    let path = scratch::folder().join("again.orders");
                    let write = |(key, table): &(String, _)| {
                        write_orders(&path, key, table).and_then(|()| barbule::io::read_bytes(&path))
                    };
                    comes_back(&(key, table), write, |bytes| {
                        read_keyed_orders(&scratch::file("orders", bytes))
                    })
                })
            })
        },
        weight: Weight::Numbers,
    },
    Target {
        name: "bsdf",
        about: "measured materials, .bsdf",
        tokens: &[
            "tensor_file",
            "phi_i",
            "theta_i",
            "ndf",
            "sigma",
            "vndf",
            "luminance",
            "spectra",
            "rgb",
            "wavelengths",
            "jacobian",
            "description",
        ],
        seeds: Vec::new,
        check: |bytes| {
            // Arrays alone may be of sizes that do not go together, which only the material made of them tells.
            if let Err(error) = rgl_arrays(bytes) {
                refusal(&error)?;
            }
            judged(decode_bsdf(bytes).and_then(|_| rgl_arrays(bytes)), |arrays| {
                comes_back(&arrays, |arrays| Ok(encode_bsdf(arrays, "again")), rgl_arrays)
            })
        },
        weight: Weight::Numbers,
    },
    Target {
        name: "checkpoint",
        about: "checkpoints of pictures",
        tokens: &["BARBFILM"],
        seeds: || vec![checkpoint::write(film(), &NAME)],
        check: |bytes| kept(bytes, film()),
        weight: Weight::Numbers,
    },
    Target {
        name: "part",
        about: "parts of pictures",
        tokens: &["BARBFILM"],
        seeds: || vec![checkpoint::write(part(), &NAME)],
        check: |bytes| kept(bytes, part()),
        weight: Weight::Numbers,
    },
    Target {
        name: "unit",
        about: "finished pieces of validate",
        tokens: &["[", "]", ",", "null", "1e308", "-0.0", "\n"],
        seeds: || {
            let rest = format!("{IDENTITY}\n[0.1,0.30000000000000004,-0.0,1e300,5e-324]\n");
            vec![[blake3::hash(rest.as_bytes()).to_hex().as_bytes(), b"\n", rest.as_bytes()].concat()]
        },
        check: |bytes| {
            either(bytes, seal::first_line_blake3(bytes), |bytes| {
                let name = format!("units/a-{}.unit", &IDENTITY[..16]);
                let path = scratch::file(&name, bytes);
                let units = Units::new(path.parent().unwrap_or(&path));
                let Some(values) = units.get::<Vec<f64>>("a", IDENTITY) else { return Ok(Seen::Refused) };
                units
                    .keep("b", IDENTITY, &values)
                    .map_err(|error| format!("what was read cannot be kept: {error}"))?;
                let back = units.get::<Vec<f64>>("b", IDENTITY).unwrap_or_default();
                let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                holds(bits(&back) == bits(&values), || "numbers come back as others".into())?;
                Ok(Seen::Accepted)
            })
        },
        weight: Weight::Text,
    },
];

/// The input as it is, and where its checksum can be mended, so.
fn either(bytes: &[u8], mended: Option<Vec<u8>>, check: impl Fn(&[u8]) -> Verdict) -> Verdict {
    let plain = check(bytes)?;
    let mended = mended.filter(|mended| mended != bytes).map_or(Ok(plain), |mended| check(&mended))?;
    Ok(if plain == Seen::Accepted { plain } else { mended })
}

const NAME: [u8; 32] = [7; 32];
const IDENTITY: &str = "1111111111111111111111111111111111111111111111111111111111111111";

fn film() -> &'static Film {
    static FILM: OnceLock<Film> = OnceLock::new();
    FILM.get_or_init(|| made(Shard::WHOLE))
}

fn part() -> &'static Film {
    static FILM: OnceLock<Film> = OnceLock::new();
    FILM.get_or_init(|| match Shard::new(1, 2) {
        Ok(shard) => made(shard),
        Err(error) => panic!("{error}"),
    })
}

fn made(shard: Shard) -> Film {
    Film::part([20, 3], Planes::default(), shard).unwrap_or_else(|error| panic!("{error}"))
}

fn kept(bytes: &[u8], empty: &Film) -> Verdict {
    either(bytes, seal::trailing_blake3(bytes), |bytes| {
        let read = |bytes: &[u8]| checkpoint::read(bytes, &NAME, empty.clone());
        judged(read(bytes), |film| comes_back(&film, |film| Ok(checkpoint::write(film, &NAME)), read))
    })
}
