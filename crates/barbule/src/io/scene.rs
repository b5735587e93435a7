//! What scene files name: spectra of lamps, pictures behind the scene.

use std::path::Path;

use super::image::read_picture;
use super::measured::{Scale, read_measured};
use crate::Result;
use crate::scene::backdrop::{Backdrop, BackdropPicture};
use crate::scene::description::{Background, LightColour, SceneDescription};

/// Reads the files that a scene names and that are not read yet, relative to a folder; all but the sky's image and the
/// material.
///
/// # Errors
/// A file that is missing, too large or of another kind; the message names the key and the file.
pub fn read_scene_files(scene: &mut SceneDescription, folder: &Path) -> Result<()> {
    for (index, light) in scene.lights.iter_mut().enumerate() {
        if let LightColour::Table { file, spectrum: spectrum @ None } = &mut light.colour {
            let table = read_measured(&folder.join(file), None, Some(Scale::Power))
                .map_err(|error| error.at(format!("lights[{index}].spectrum")))?;
            *spectrum = Some(table.mean);
        }
    }
    if let Background::Picture { file, picture: picture @ Backdrop::None } = &mut scene.background {
        let path = folder.join(file);
        let (image, is_radiance) = read_picture(&path).map_err(|error| error.at("background"))?;
        *picture = Backdrop::Picture(
            BackdropPicture::new(image.size, image.pixels, is_radiance)
                .map_err(|error| error.at(path.display()))?,
        );
    }
    Ok(())
}
