//! The presets, as `barbule render` names them.

use std::io::Write;

use barbule::Result;
use barbule::scene::preset;

use crate::common::{Common, print, print_json};

/// Examples, and the names of all presets.
pub(super) fn after_help() -> String {
    let names: Vec<&str> = preset::names().collect();
    format!(
        "Examples:\n  barbule render starling -o starling.png\n  \
         barbule render my-bird.toml -o my-bird.png\n  \
         barbule render starling --background none -o starling.exr\n  \
         barbule render starling --frames 25 --arc light=40 -o glints.png\n  \
         barbule render starling --shard 0/4 -o starling.png\n  \
         barbule render starling --sensor bird:starling --human human.png -o bird.png\n  \
         barbule render starling --toml\n  \
         barbule render --list\n\nPresets: {}",
        names.join(", ")
    )
}

/// Prints the presets, with what each shows in a line.
pub(super) fn print_list(common: &Common, out: &mut dyn Write) -> Result<()> {
    let presets = preset::names().map(|name| Ok((name, preset::about(name)?))).collect::<Result<Vec<_>>>()?;
    if common.json {
        let one = |(name, about): &(&str, String)| serde_json::json!({"name": name, "about": about});
        return print_json(out, &presets.iter().map(one).collect::<Vec<_>>());
    }
    let widest = presets.iter().map(|(name, _)| name.len()).max().unwrap_or_default();
    let lines: Vec<String> = presets.iter().map(|(name, about)| format!("{name:widest$}  {about}")).collect();
    print(out, &lines.join("\n"))
}
