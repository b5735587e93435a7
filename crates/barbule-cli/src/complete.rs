//! What can be typed next, for shells: species, variants, presets and files beside commands and flags.
//!
//! The scripts that `barbule completions` prints ask the program itself, which alone knows what is built in: with
//! [`VARIABLE`] set to a shell's name it reads the words of the line and prints how the last one may go on.

use std::ffi::{OsStr, OsString};
use std::io;
use std::path::Path;

use barbule::open::eye_names;
use barbule::scene::{feather, preset};
use barbule::structure::{SAMPLES, SpeciesFile, species_names};
use barbule::vision::Light;
use clap::Command;
use clap_complete::CompleteEnv;
use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter, complete,
};
use clap_complete::env::{Elvish, EnvCompleter, Fish, Powershell, Shells, Zsh};

/// The environment variable that asks for completions.
pub(crate) const VARIABLE: &str = "BARBULE_COMPLETE";

/// All shells.
pub(crate) const SHELLS: Shells<'static> = Shells(&[&Bash, &Elvish, &Fish, &Powershell, &Zsh]);

/// Answers a shell's question, if this is one: whether it was.
///
/// # Errors
/// The shell is unknown, or its question or the answer is not as it should be.
pub(crate) fn answer(arguments: &[OsString]) -> clap::error::Result<bool> {
    let folder = std::env::current_dir().ok();
    CompleteEnv::with_factory(command).var(VARIABLE).shells(SHELLS).try_complete(arguments, folder.as_deref())
}

/// The program's commands, with what their values may be.
fn command() -> Command {
    let mut command = crate::command();
    for name in command.get_subcommands().map(|c| c.get_name().to_owned()).collect::<Vec<_>>() {
        command = command.mut_subcommand(&name, |sub| {
            sub.mut_args(|argument| {
                let command = name.as_str();
                match kind(command, argument.get_id().as_str()) {
                    Some(kind) => argument.add(ArgValueCompleter::new(kind)),
                    None => argument,
                }
            })
        });
    }
    command
}

/// What an argument's value is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    /// The names that are built in.
    names: Names,
    /// Extensions of the files that it may be; folders lead to them.
    extensions: &'static [&'static str],
    /// Text before a file, as in `NAME=FILE`.
    after: Option<char>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Names {
    None,
    /// `SPECIES[:VARIANT]`.
    Species,
    /// Presets, and `SPECIES[:VARIANT]`.
    Presets,
    /// Types of feathers, birds' feathers, and `SPECIES[:VARIANT]`.
    Feathers,
    /// Samples of heights.
    Heights,
    /// Kinds of files that have keys.
    Keys,
    /// The program's commands.
    Commands,
    /// Birds that see.
    Eyes,
    /// Lights.
    Lights,
    /// Models of presets that have several.
    Models,
}

const FIGURES: &[&str] = &["svg", "pdf", "png"];
const TABLES: &[&str] = &["csv", "txt", "tsv", "yml", "yaml", "jdx"];

/// The kind of an argument by its name, for all commands that share it.
fn kind(command: &str, argument: &str) -> Option<Kind> {
    let files = |names, extensions| Some(Kind { names, extensions, after: None });
    match (command, argument) {
        ("simulate", "structure") => files(Names::Species, &["toml", "json", "zarr"]),
        ("see", "structures") => files(Names::Species, &["csv", "txt", "tsv", "jdx", "toml", "json"]),
        (_, "structure" | "structures") => files(Names::Species, &["toml", "json"]),
        ("feather", "feather") => files(Names::Feathers, &["toml"]),
        ("feather", "output") => files(Names::None, &["usda", "ply", "obj", "gltf", "pbrt", "txt"]),
        ("diffract", "heights") => {
            files(Names::Heights, &["npy", "tif", "tiff", "png", "gwy", "txt", "csv", "tsv", "asc"])
        }
        ("diffract", "output") => files(Names::None, &["grating", "svg", "pdf", "png"]),
        ("film", "stack") => files(Names::None, &["toml"]),
        (_, "bird" | "birds") => files(Names::Eyes, &["toml", "csv"]),
        (_, "illuminant") => files(Names::Lights, TABLES),
        ("species", "name") => files(Names::Species, &["toml", "json"]),
        ("keys", "kind") => files(Names::Keys, &[]),
        ("man", "commands") => files(Names::Commands, &[]),
        ("render", "model") => files(Names::Models, &[]),
        ("render", "scene") => files(Names::Presets, &["toml"]),
        ("render" | "lobes" | "brdf", "material") | ("render", "under") => {
            files(Names::Species, &["barbule", "toml", "json"])
        }
        ("export", "what") => files(Names::Presets, &["barbule", "toml", "json"]),
        ("export", "output") => {
            files(Names::None, &["xml", "bsdf", "pbrt", "osl", "usda", "gltf", "mtlx", "csv", "exr"])
        }
        ("render", "background") => files(Names::None, &["png", "exr", "hdr"]),
        ("render", "output" | "human") => files(Names::None, &["png", "jpg", "webp", "exr"]),
        ("render", "sensor") => files(Names::None, &["toml", "csv"]),
        (_, "medium") => Some(Kind { names: Names::None, extensions: TABLES, after: Some('=') }),
        (_, "measured") => files(Names::None, TABLES),
        ("atlas", "plan") => files(Names::None, &["toml"]),
        ("trace", "image") => files(Names::None, &["png", "tif", "tiff", "jpg", "jpeg"]),
        ("trace", "output") => files(Names::None, &["json", "toml"]),
        ("geometry", "output") => files(Names::None, &["svg", "pdf", "png", "json"]),
        ("film" | "spectrum" | "species" | "birds" | "see" | "lobes" | "crystal" | "far-field", "output") => {
            files(Names::None, FIGURES)
        }
        ("fit-structure", "model") => files(Names::Species, &["toml"]),
        ("fit-structure", "output") => files(Names::None, &["toml"]),
        ("view", "words") => files(Names::Presets, &["barbule", "grating", "toml", "json"]),
        (_, "picture") => files(Names::None, FIGURES),
        (_, "csv" | "summary") => files(Names::None, &["csv"]),
        _ => None,
    }
}

impl ValueCompleter for Kind {
    fn complete(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        let text = current.to_string_lossy();
        if let Some(mark) = self.after {
            let Some((name, file)) = text.split_once(mark) else { return Vec::new() };
            let before = format!("{name}{mark}");
            return self.files(file.as_ref()).into_iter().map(|c| c.add_prefix(&before)).collect();
        }
        let mut found = self.names.complete(&text);
        found.extend(self.files(current));
        found
    }
}

impl Kind {
    fn files(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        let extensions = self.extensions;
        let wanted = move |path: &Path| {
            path.extension().is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known)))
        };
        let found = PathCompleter::any().filter(wanted).complete(current);
        // Nothing said yet: names come first, and a folder full of others would bury them.
        let is_folder = |c: &CompletionCandidate| c.get_value().to_string_lossy().ends_with(['/', '\\']);
        let bare = current.is_empty() && self.names != Names::None;
        found.into_iter().filter(|candidate| !bare || !is_folder(candidate)).collect()
    }
}

impl Names {
    fn complete(self, text: &str) -> Vec<CompletionCandidate> {
        if self == Self::None {
            return Vec::new();
        }
        if self == Self::Keys {
            return starting(barbule::keys::kinds().into_iter(), text, None);
        }
        if self == Self::Commands {
            let command = crate::command();
            return starting(command.get_subcommands().map(|c| c.get_name().to_owned()), text, None);
        }
        if self == Self::Eyes {
            return starting(eye_names().map(str::to_owned), text, Some("eye"));
        }
        if self == Self::Models {
            return starting(preset::models().map(str::to_owned), text, Some("model"));
        }
        if self == Self::Lights {
            let lights = Light::NAMES.into_iter();
            return lights
                .flat_map(|(name, about)| starting(std::iter::once(name.to_owned()), text, Some(about)))
                .collect();
        }
        if let Some((species, _)) = text.split_once(':') {
            let Ok(file) = SpeciesFile::builtin(species) else { return Vec::new() };
            let variants = file.variants().map(|variant| format!("{species}:{variant}"));
            return starting(variants, text, Some(&file.latin));
        }
        if self == Self::Heights {
            return starting(SAMPLES.map(str::to_owned).into_iter(), text, Some("sample"));
        }
        let species: Vec<&str> = species_names().collect();
        let of = |name: &str| SpeciesFile::builtin(name).map_or_else(|_| String::new(), |f| f.latin.clone());
        let mut found: Vec<_> = species
            .iter()
            .flat_map(|name| starting(std::iter::once((*name).to_owned()), text, Some(&of(name))))
            .collect();
        if self == Self::Presets {
            let others = preset::names().filter(|name| !species.contains(name)).map(str::to_owned);
            found.extend(starting(others, text, Some("preset")));
        }
        if self == Self::Feathers {
            found.extend(starting(feather::names().map(str::to_owned), text, Some("feather")));
        }
        found
    }
}

/// The names that begin with a text, with what is said of them.
fn starting(names: impl Iterator<Item = String>, text: &str, help: Option<&str>) -> Vec<CompletionCandidate> {
    names
        .filter(|name| name.starts_with(text))
        .map(|name| CompletionCandidate::new(name).help(help.map(|words| words.to_owned().into())))
        .collect()
}

/// Bash, whose lines are broken at colons too: `starling:pink` comes as three words, of which it completes the last.
struct Bash;

/// Answers come one a line; Bash sets what must be said of the words.
const BASH: &str = r#"_barbule() {
    local line=${COMP_LINE:0:COMP_POINT} answer
    # What is before the last colon or equals sign of the word is written already, where Bash breaks words there.
    local word=${line##*[[:space:]]} written=
    case $COMP_WORDBREAKS in *:*) [[ $word == *:* ]] && written=${word%"${word##*:}"} ;; esac
    case $COMP_WORDBREAKS in *=*) [[ ${word#"$written"} == *=* ]] && written=${word%"${word##*=}"} ;; esac
    COMPREPLY=()
    while IFS= read -r answer; do
        answer=${answer#"$written"}
        [[ -n $answer ]] && printf -v answer %q "$answer" && COMPREPLY+=("$answer")
    done < <(VARIABLE=bash barbule -- "$line" 2>/dev/null)
    # What ends so goes on without a space.
    [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *[/:=] ]] && compopt -o nospace 2>/dev/null
    return 0
}
complete -o nosort -F _barbule barbule 2>/dev/null || complete -F _barbule barbule
"#;

impl EnvCompleter for Bash {
    fn name(&self) -> &'static str {
        "bash"
    }

    fn is(&self, name: &str) -> bool {
        name == "bash"
    }

    fn write_registration(
        &self,
        variable: &str,
        _name: &str,
        _bin: &str,
        _completer: &str,
        out: &mut dyn io::Write,
    ) -> io::Result<()> {
        out.write_all(BASH.replace("VARIABLE", variable).as_bytes())
    }

    /// The one word is the line up to the cursor.
    fn write_complete(
        &self,
        command: &mut Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn io::Write,
    ) -> io::Result<()> {
        let line = words.first().map(|line| line.to_string_lossy().into_owned()).unwrap_or_default();
        let words: Vec<OsString> = split(&line).into_iter().map(OsString::from).collect();
        let last = words.len() - 1;
        let bare = words[last].is_empty();
        let found = complete(command, words, last, folder)?;
        let is_flag = |c: &CompletionCandidate| c.get_value().to_string_lossy().starts_with('-');
        let any_value = found.iter().any(|c| !is_flag(c));
        for candidate in found.iter().filter(|c| !(bare && any_value && is_flag(c))) {
            writeln!(out, "{}", candidate.get_value().to_string_lossy())?;
        }
        Ok(())
    }
}

/// The words of a line up to the cursor as a shell reads them; the last is empty behind a space.
fn split(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    let mut letters = line.trim_start().chars();
    while let Some(letter) = letters.next() {
        match (quote, letter) {
            (Some(open), _) if letter == open => quote = None,
            (None, '\'' | '"') => quote = Some(letter),
            (None | Some('"'), '\\') => word.extend(letters.next()),
            (None, _) if letter.is_whitespace() => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            _ => word.push(letter),
        }
    }
    words.push(word);
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values and flags after a line.
    fn after(line: &str) -> Vec<String> {
        let mut out = Vec::new();
        Bash.write_complete(&mut command(), vec![line.into()], None, &mut out).unwrap();
        String::from_utf8(out).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn lines_are_broken_as_a_shell_does() {
        assert_eq!(split("barbule  render st"), ["barbule", "render", "st"]);
        assert_eq!(split("barbule film 'air/keratin:5/air' "), ["barbule", "film", "air/keratin:5/air", ""]);
        assert_eq!(split(r#"barbule a\ b "c d"#), ["barbule", "a b", "c d"]);
        assert_eq!(split(""), [""]);
    }

    #[test]
    fn species_variants_presets_and_values_complete() {
        assert_eq!(after("barbule render st"), ["starling", "starling-feather", "starling-bird"]);
        let pink = after("barbule characterize starling:p");
        assert!(pink.contains(&"starling:pink".to_owned()), "{pink:?}");
        let all = after("barbule spectrum ");
        assert!(all.contains(&"peafowl".into()) && !all.iter().any(|word| word.starts_with('-')), "{all:?}");
        assert_eq!(
            after("barbule far-field starling --solver "),
            ["fast", "direct", "shadowed", "full-wave"]
        );
        let scenes = after("barbule render ");
        assert!(preset::names().all(|preset| scenes.contains(&preset.to_owned())), "{scenes:?}");
        assert!(after("barbule render starling --material mal").contains(&"mallard".to_owned()));
        assert_eq!(after("barbule diffract bl"), ["blazed"]);
        assert!(after("barbule -v spec").contains(&"spectrum".to_owned()));
    }

    #[test]
    fn every_argument_that_takes_a_structure_or_a_file_is_known() {
        let command = crate::command();
        for sub in command.get_subcommands() {
            for argument in sub.get_positionals().filter(|a| a.get_possible_values().is_empty()) {
                let known = kind(sub.get_name(), argument.get_id().as_str()).is_some();
                let hint = argument.get_value_hint() != clap::ValueHint::Unknown;
                assert!(known || hint, "{} {}", sub.get_name(), argument.get_id());
            }
        }
    }
}
