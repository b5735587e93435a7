//! What scene files name: spectra of lamps, pictures behind the scene.

use std::path::Path;
use std::sync::Arc;

use super::curves::read_curves;
use super::grating::read_grating;
use super::hash_file;
use super::image::{Meaning, read_picture};
use super::measured::{Scale, read_measured};
use super::mesh::read_mesh;
use crate::Result;
use crate::bsdf::Texture;
use crate::scene::backdrop::{Backdrop, BackdropPicture};
use crate::scene::description::{
    Background, CoatBody, GratingDescription, GratingSource, LightColour, NamedSurface, ObjectShape,
    SceneDescription, TextureFile,
};

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
        let (image, is_radiance) =
            read_picture(&path, Meaning::Colour).map_err(|error| error.at("background"))?;
        *picture = Backdrop::Picture(
            BackdropPicture::new(image.size, image.pixels, is_radiance)
                .map_err(|error| error.in_file(&path))?,
        );
    }
    for (index, object) in scene.objects.iter_mut().enumerate() {
        match &mut object.shape {
            ObjectShape::Mesh { file, mesh: mesh @ None, content } => {
                let path = folder.join(file);
                let (read, hash) =
                    read_mesh(&path).map_err(|error| error.at(format!("objects[{index}].mesh")))?;
                (*mesh, *content) = (Some(Arc::new(read)), hash);
            }
            ObjectShape::Curves { file, basis, curves: curves @ None, content } => {
                let path = folder.join(file);
                let read = read_curves(&path, *basis)
                    .map_err(|error| error.at(format!("objects[{index}].curves")))?;
                (*curves, *content) = (Some(Arc::new(read)), hash_file(&path)?);
            }
            _ => {}
        }
    }
    if let Some(CoatBody::Mesh { file, mesh: mesh @ None, content }) =
        scene.coat.as_mut().map(|coat| &mut coat.body)
    {
        let (read, hash) = read_mesh(&folder.join(file)).map_err(|error| error.at("coat.mesh"))?;
        (*mesh, *content) = (Some(Arc::new(read)), hash);
    }
    for (name, surface) in &mut scene.named_surfaces {
        if let NamedSurface::Grating(grating @ GratingDescription { powers: None, .. }) = surface
            && let GratingSource::File(file) = &grating.source
        {
            let path = folder.join(file);
            let read = read_grating(&path).map_err(|error| error.at(format!("surfaces.{name}.file")))?;
            (grating.powers, grating.content) = (Some(Arc::new(read.powers)), hash_file(&path)?);
        }
        for (key, picture) in surface.pictures_mut() {
            if picture.texture.is_none() {
                let meaning = if key == "albedo" { Meaning::Colour } else { Meaning::Number };
                read_texture(picture, folder, meaning)
                    .map_err(|error| error.at(format!("surfaces.{name}.{key}")))?;
            }
        }
    }
    Ok(())
}

/// Reads a texture: a PNG's values, or an EXR's of 0 to 1.
fn read_texture(texture: &mut TextureFile, folder: &Path, meaning: Meaning) -> Result<()> {
    let path = folder.join(&texture.file);
    let (image, _) = read_picture(&path, meaning)?;
    let read = Texture::new(image.size, image.pixels).map_err(|error| error.in_file(&path))?;
    (texture.texture, texture.content) = (Some(read), hash_file(&path)?);
    Ok(())
}
