//! The manual: a page for each command, which programs that read manuals take without complaint.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::run_inside;

/// What a reader of manuals says of a page on either output, if it is installed.
fn complaints(program: &str, words: &[&str], page: &Path) -> Option<String> {
    let output = Command::new(program).args(words).arg(page).stdin(Stdio::null()).output().ok()?;
    Some([output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat())
}

#[test]
fn every_command_has_a_page_with_what_its_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("deep/man1");
    let (code, out, _) = run_inside(["man", "-o", at.to_str().unwrap(), "--quiet"]);
    assert!(code == 0 && out.is_empty());
    let (_, list, _) = run_inside(["man", "--list"]);
    let names: Vec<&str> = list.lines().collect();
    let written = std::fs::read_dir(&at).unwrap().count();
    assert_eq!(written, names.len());
    assert_eq!(names[0], "barbule");

    let mut open = vec![("barbule".to_owned(), barbule_cli::command())];
    while let Some((name, command)) = open.pop() {
        assert!(names.contains(&name.as_str()), "{name}");
        let page = at.join(format!("{name}.1"));
        let text = std::fs::read_to_string(&page).unwrap();
        // As whatis and apropos read it: one line, `name - what it is`.
        let about = command.get_about().unwrap().to_string();
        let plain = text.replace("\\*(Aq", "'").replace('\\', "");
        let line = format!(".SH NAME\n{name} - {about}\n");
        assert!(plain.contains(&line), "{name}:\n{}", plain.chars().take(400).collect::<String>());
        for argument in command.get_arguments().filter_map(clap_long) {
            assert!(plain.contains(&format!("--{argument}")), "{name}: --{argument}");
        }
        for sub in command.get_subcommands() {
            open.push((format!("{name}-{}", sub.get_name()), sub.clone()));
        }
        if let Some(said) = complaints("mandoc", &["-Tlint", "-Wwarning"], &page) {
            // Pages are of a version, not of a day.
            let others: Vec<_> = said.lines().filter(|line| !line.contains("missing date")).collect();
            assert!(others.is_empty(), "mandoc on {name}: {others:?}");
        }
        if let Some(said) = complaints("lexgrog", &[], &page) {
            assert!(said.contains(&format!("\"{name} - {about}\"")), "{said}");
        }
        if let Some(said) = complaints("groff", &["-man", "-Kutf8", "-ww", "-z", "-Tutf8"], &page) {
            assert_eq!(said, "", "groff on {name}");
        }
    }
}

fn clap_long(argument: &clap::Arg) -> Option<String> {
    argument.get_long().filter(|_| !argument.is_hide_set()).map(str::to_owned)
}

#[test]
fn one_page_goes_to_standard_output_or_a_folder() {
    let (code, page, _) = run_inside(["man", "render"]);
    assert!(code == 0 && page.contains(".TH barbule-render 1") && page.contains("starling"));
    let (_, own, _) = run_inside(["man"]);
    assert!(own.contains("barbule \\- Turns") && own.contains("barbule\\-render(1)"));
    let (_, deep, _) = run_inside(["man", "bench", "render"]);
    assert!(deep.contains(".TH barbule-bench-render 1"));
    let (_, json, _) = run_inside(["man", "render", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((json["name"].as_str(), json["roff"].as_str()), (Some("barbule-render"), Some(&*page)));

    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().to_str().unwrap();
    let (code, out, _) = run_inside(["man", "render", "-o", at, "--quiet"]);
    assert!(code == 0 && out.is_empty());
    let written: Vec<_> = std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(written, ["barbule-render.1"]);
    let (_, json, _) = run_inside(["man", "render", "-o", at, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(json["files"][0].as_str().unwrap().ends_with("barbule-render.1"), "{json}");
}
