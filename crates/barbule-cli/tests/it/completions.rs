//! Tab completion as shells ask for it, with real shells where they are.

use std::path::Path;
use std::process::{Command, Stdio};

const PROGRAM: &str = env!("CARGO_BIN_EXE_barbule");

/// A command that finds the program under test on its PATH.
fn shell(name: &str, folder: &Path) -> Command {
    let mut command = Command::new(name);
    let programs = Path::new(PROGRAM).parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let all = std::iter::once(programs).chain(std::env::split_paths(&path));
    command.env("PATH", std::env::join_paths(all).unwrap()).current_dir(folder).stderr(Stdio::inherit());
    command
}

fn is_there(name: &str) -> bool {
    Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

fn lines(mut command: Command) -> Vec<String> {
    let output = command.output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// What Bash puts at the cursor behind `line`: it breaks words at blanks, colons and equals signs and replaces the last.
fn bash(line: &str, folder: &Path) -> Vec<String> {
    let script = r#"
        source <(barbule completions bash)
        COMP_LINE=$1 COMP_POINT=${#1}
        # As Bash does: what breaks words is a word of its own.
        COMP_WORDS=() word=
        for ((i = 0; i < ${#1}; i++)); do
            c=${1:i:1}
            case $c in
                [:=]) [[ -n $word ]] && COMP_WORDS+=("$word"); COMP_WORDS+=("$c"); word= ;;
                ' ') [[ -n $word ]] && COMP_WORDS+=("$word"); word= ;;
                *) word+=$c ;;
            esac
        done
        COMP_WORDS+=("$word") COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        complete -p barbule | grep -q -- '-F _barbule' || exit 1
        _barbule barbule "$word" "${COMP_WORDS[COMP_CWORD - 1]}"
        [[ ${#COMPREPLY[@]} -eq 0 ]] || printf '%s\n' "${COMPREPLY[@]}""#;
    let mut command = shell("bash", folder);
    command.args(["--norc", "-c", script, "bash", line]);
    lines(command)
}

#[test]
fn bash_completes_species_variants_files_and_values() {
    if !is_there("bash") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for name in ["my-bird.toml", "my-section.json", "notes.md", "old.barbule", "n k.csv"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    std::fs::create_dir(folder.path().join("my-folder")).unwrap();
    let after = |line: &str| bash(line, folder.path());
    assert_eq!(after("barbule ren"), ["render"]);
    assert_eq!(after("barbule render st"), ["starling", "starling-feather", "starling-bird"]);
    // The species and its colon stand there already.
    let variants = after("barbule spectrum starling:");
    assert!(variants.contains(&"pink".to_owned()) && variants.contains(&"green".to_owned()), "{variants:?}");
    assert_eq!(after("barbule spectrum starling:pi"), ["pink"]);
    assert_eq!(after("barbule spectrum my-"), ["my-bird.toml", "my-section.json", "my-folder/"]);
    assert_eq!(after("barbule render starling --material ol"), ["old.barbule"]);
    assert_eq!(after("barbule far-field starling --solver "), ["fast", "direct", "shadowed", "full-wave"]);
    assert_eq!(after("barbule far-field starling --solver=d"), ["direct"]);
    assert_eq!(after("barbule film air/keratin:5/air --medium chitin=n"), ["n\\ k.csv"]);
    assert_eq!(after("barbule -v completions ba"), ["bash"]);
    assert!(after("barbule spectrum ").contains(&"hummingbird".to_owned()));
    assert!(after("barbule render starling --figure").is_empty());
    assert_eq!(after("barbule geometry starling --figure-s"), ["--figure-size"]);
}

#[test]
fn zsh_and_fish_scripts_ask_the_program_too() {
    let folder = tempfile::tempdir().unwrap();
    if is_there("fish") {
        let mut command = shell("fish", folder.path());
        let script = "barbule completions fish | source; complete -C 'barbule spectrum starling:pi'";
        command.args(["--no-config", "-c", script]).env("HOME", folder.path());
        let found = lines(command);
        assert!(found.len() == 1 && found[0].starts_with("starling:pink"), "{found:?}");
    }
    if is_there("zsh") {
        let script = "autoload -U compinit && compinit -u -d /dev/null; source <(barbule completions zsh); \
            (( $+functions[_clap_dynamic_completer_barbule] )) && print there";
        let mut command = shell("zsh", folder.path());
        command.args(["-f", "-c", script]).env("HOME", folder.path());
        assert_eq!(lines(command), ["there"]);
    }
    // What both of them call.
    let mut command = shell(PROGRAM, folder.path());
    command.args(["--", "barbule", "spectrum", "starling:pi"]);
    command.env("BARBULE_COMPLETE", "zsh").env("_CLAP_COMPLETE_INDEX", "2").env("_CLAP_IFS", "\n");
    let found = lines(command);
    assert!(found.len() == 1 && found[0].starts_with("starling\\:pink:"), "{found:?}");
}

#[test]
fn every_shell_has_a_script() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = Command::new(PROGRAM).args(["completions", shell]).output().unwrap();
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && script.contains("BARBULE_COMPLETE"), "{shell}");
    }
}
