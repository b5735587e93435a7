//! What people type: the small languages, and command lines.

use std::cell::RefCell;

use barbule::confidence::Uncertain;
use barbule::instrument::Instrument;
use barbule::inverse::Open;
use barbule::scene::description::{Background, WhiteBalance};
use barbule::vision::{Eye, FalseColour};
use barbule::{Stack, material, open};

use super::{Target, Weight, bytes_of, finite, library};
use crate::laws::{Held, holds, judged, sentence};
use crate::{Seen, Verdict};

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "stack",
        about: "the language of stacks",
        tokens: &[
            "air",
            "keratin",
            "melanin",
            "mix(keratin,melanin,0.4)",
            "mix(",
            ",bruggeman)",
            "/",
            ":",
            "*(",
            ")",
            "~",
            "100",
            "6*(",
            "1.5+0.02j",
            "%",
            "1e9",
            "?",
        ],
        seeds: || {
            bytes_of([
                "air/6*(melanin:99/keratin:100)/air",
                "air/keratin:320~5%/melanin",
                "1/2*(1.5+0.1j:10/2*(mix(keratin,melanin,0.3):5/air:7)/air:1)/1.33",
            ])
        },
        check: |bytes| {
            judged(Stack::parse(&String::from_utf8_lossy(bytes), library()), |stack| {
                finite("thickness", stack.thickness_nm())?;
                holds(stack.thickness_nm().iter().all(|nm| *nm >= 0.0), || "a thickness under 0".into())
            })
        },
        weight: Weight::Text,
    },
    Target {
        name: "medium",
        about: "expressions of media",
        tokens: &[
            "mix(",
            "keratin",
            "melanin",
            "air",
            ",",
            ")",
            "0.4",
            "volume",
            "bruggeman",
            "+0.02j",
            "1e308",
            "-",
            "i",
            "j",
        ],
        seeds: || {
            bytes_of([
                "keratin",
                "mix(keratin, melanin, 0.4)",
                "1.56+0.02j",
                "mix(mix(air,keratin,0.5,bruggeman),melanin,0.25)",
            ])
        },
        check: |bytes| {
            judged(material::parse(&String::from_utf8_lossy(bytes), library()), |medium| {
                match medium.index(550.0) {
                    Ok(index) => finite("index", [&index.re, &index.im]),
                    Err(error) => crate::laws::refusal(&error),
                }
            })
        },
        weight: Weight::Text,
    },
    Target {
        name: "numbers",
        about: "sets of numbers on command lines",
        tokens: &[":", ",", "400:694:6", "1e-300", "1e308", "-", " "],
        seeds: || bytes_of(["520", "400,442,484", "400:694:6", "0:90:0.1,5"]),
        check: |bytes| {
            judged(barbule_cli::sets::parse("--wavelengths", &String::from_utf8_lossy(bytes)), |values| {
                holds(!values.is_empty(), || "an empty set was accepted".into())?;
                finite("--wavelengths", &values)
            })
        },
        weight: Weight::Text,
    },
    Target {
        name: "options",
        about: "instruments, lights, whites, backgrounds, uncertain and open sizes, false colours",
        tokens: &[
            "probe:",
            "arms:",
            "sphere",
            "microscope:",
            "D65",
            "quanta:",
            "auto",
            "#808080",
            "sky",
            "=",
            "..",
            "%",
            "L,M,S",
            "+UV",
            "5500K",
            ",",
            "nan",
            "1e308",
        ],
        seeds: || {
            bytes_of([
                "probe:10",
                "arms:0,45,5",
                "sphere",
                "microscope:0.5",
                "D65",
                "auto",
                "5500K",
                "#808080",
                "sky",
                "none",
                "keratin=0.005",
                "cortex_um=2%",
                "cortex_um=0.2..0.5",
                "L,M,S",
                "L+UV,M,S+UV",
            ])
        },
        check: options,
        weight: Weight::Text,
    },
    Target {
        name: "model",
        about: "names of models that are fitted",
        tokens: &["film", "multilayer", "lattice", "starling", ":", ".toml", "/"],
        seeds: || bytes_of(["lattice", "starling:green", "mallard", "none.toml:a", "film"]),
        check: |bytes| {
            judged(
                open::subject(&String::from_utf8_lossy(bytes).replace(['/', '\\'], "_"), library()),
                |_| Ok(()),
            )
        },
        weight: Weight::Text,
    },
    Target {
        name: "command-line",
        about: "the arguments of every command, which is not run; a word a line",
        tokens: &[
            "\n",
            "--help",
            "--json\n",
            "--csv\n",
            "--seed\n",
            "--threads\n",
            "--memory\n8GB\n",
            "--shard\n1/2\n",
            "--wavelengths\n400:694:6\n",
            "-o\n",
            "--media\na=b.csv\n",
            "--size\n",
            "--samples\n",
            "--noise\n",
            "--",
            "-",
            "=",
            "--angles\n0:80:20\n",
            "--view\n",
            "--light\n",
            "spectrum\n",
            "render\n",
            "simulate\n",
            "atlas\n",
            "validate\n",
        ],
        seeds: command_lines,
        check: command_line,
        weight: Weight::Picture,
    },
];

fn options(bytes: &[u8]) -> Verdict {
    thread_local! {
        static EYE: Option<Eye> = open::eye("starling").ok();
    }
    let text = &*String::from_utf8_lossy(bytes);
    let any = |_: &dyn std::fmt::Debug| -> Held { Ok(()) };
    let mut seen = vec![
        judged(Instrument::parse(text), |it| any(&it))?,
        judged(WhiteBalance::parse(text), |it| any(&it))?,
        judged(Background::parse(text), |it| any(&it))?,
        judged(Uncertain::parse(text), |it| any(&it))?,
        judged(Open::parse(text), |it| any(&it))?,
        judged(barbule::vision::Light::named(text), |it| any(&it))?,
    ];
    EYE.with(|eye| match eye {
        Some(eye) => judged(FalseColour::parse(text, eye), |it| any(&it)).map(|it| seen.push(it)),
        None => Err("there is no eye of starlings".into()),
    })?;
    Ok(if seen.contains(&Seen::Accepted) { Seen::Accepted } else { Seen::Refused })
}

fn command_lines() -> Vec<Vec<u8>> {
    let lines = [
        "spectrum starling --angles 0:60:20 --csv /dev/stdout",
        "simulate starling -o s.zarr --wavelengths 450:650:50 --directions 3x2 --instances 3 --shard 0/2",
        "characterize mallard -o m.barbule --thin 10 --seed 7",
        "render starling -o p.png --size 48x30 --samples 4 --checkpoint",
        "validate starling --samples 2 -o v",
        "atlas films.toml -o a.zarr",
        "brdf starling --theta-i 30 --theta-o 0:80:10 --wavelength 550",
        "diffract heights.npy --pitch 0.1um -o g.grating",
        "species starling --json",
        "birds",
    ];
    let mut all = bytes_of(lines.map(|line| line.replace(' ', "\n")).iter().map(String::as_str));
    // Each command with each of its flags, a few at a time.
    for command in barbule_cli::command().get_subcommands() {
        let flags: Vec<String> = command
            .get_arguments()
            .filter_map(|argument| argument.get_long().map(|long| format!("--{long}\n1")))
            .collect();
        all.extend(
            flags
                .chunks(5)
                .map(|flags| format!("{}\nstarling\n{}", command.get_name(), flags.join("\n")).into_bytes()),
        );
    }
    all
}

fn command_line(bytes: &[u8]) -> Verdict {
    thread_local! {
        static COMMAND: RefCell<clap::Command> = RefCell::new(barbule_cli::command());
    }
    let text = String::from_utf8_lossy(bytes);
    let words = ["barbule"].into_iter().chain(text.split('\n'));
    COMMAND.with_borrow_mut(|command| match command.try_get_matches_from_mut(words) {
        Ok(_) => Ok(Seen::Accepted),
        Err(error) if !error.use_stderr() => Ok(Seen::Accepted),
        // The help of commands without a subcommand.
        Err(error) if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            Ok(Seen::Refused)
        }
        Err(error) => sentence(&barbule_cli::unclear(&error)).map(|()| Seen::Refused),
    })
}
