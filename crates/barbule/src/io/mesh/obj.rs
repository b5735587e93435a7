//! Wavefront OBJ: positions, normals, texture coordinates and faces; groups and materials are passed over.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::{MOST_VERTICES, Parts};
use crate::error::shortened;
use crate::{Error, Result};

/// One corner of a face: position, texture coordinates and normal, from 0.
type Corner = (usize, Option<usize>, Option<usize>);

/// Reads a mesh. Where some corners have normals or texture coordinates and others none, nobody has.
pub(super) fn read(text: &str) -> Result<Parts> {
    let (mut positions, mut uvs, mut normals) = (Vec::new(), Vec::new(), Vec::new());
    let mut faces: Vec<Vec<Corner>> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        let place = |error: Error| error.in_line(number + 1);
        match words.next() {
            Some("v") => positions.push(Vec3::from_array(numbers(words).map_err(place)?)),
            Some("vn") => normals.push(Vec3::from_array(numbers(words).map_err(place)?)),
            Some("vt") => uvs.push(Vec2::from_array(numbers(words).map_err(place)?)),
            Some("f") => {
                let counts = [positions.len(), uvs.len(), normals.len()];
                let face = words.map(|word| corner(word, counts)).collect::<Result<Vec<_>>>();
                faces.push(face.map_err(place)?);
            }
            _ => {}
        }
        if positions.len().max(faces.len()) > MOST_VERTICES {
            return Err(Error::input(format!("has over {MOST_VERTICES} vertices or faces")));
        }
    }
    let has = |which: fn(&Corner) -> bool| faces.iter().flatten().all(which);
    let (has_uvs, has_normals) = (has(|corner| corner.1.is_some()), has(|corner| corner.2.is_some()));
    let mut parts = Parts::default();
    let mut known: HashMap<Corner, u32> = HashMap::new();
    for face in &faces {
        let mut corners = Vec::with_capacity(face.len());
        for &(position, uv, normal) in face {
            let corner = (position, uv.filter(|_| has_uvs), normal.filter(|_| has_normals));
            let next = known.len() as u32;
            corners.push(*known.entry(corner).or_insert_with(|| {
                parts.positions.push(positions[position]);
                parts.uvs.extend(corner.1.map(|at| uvs[at]));
                parts.normals.extend(corner.2.map(|at| normals[at]));
                next
            }));
        }
        parts.add_polygon(&corners)?;
    }
    Ok(parts)
}

fn numbers<'a, const N: usize>(mut words: impl Iterator<Item = &'a str>) -> Result<[f32; N]> {
    let mut values = [0.0; N];
    for value in &mut values {
        let word = words.next().ok_or_else(|| Error::input(format!("{N} numbers are needed")))?;
        *value = word.parse().map_err(|_| Error::input(format!("'{}' is not a number", shortened(word))))?;
    }
    Ok(values)
}

/// `7`, `7/1`, `7//3` or `7/1/3`, each from 1, or from −1 backwards.
fn corner(word: &str, counts: [usize; 3]) -> Result<Corner> {
    let mut found = [None; 3];
    for ((found, part), count) in found.iter_mut().zip(word.split('/')).zip(counts) {
        if part.is_empty() {
            continue;
        }
        let number: i64 = part
            .parse()
            .map_err(|_| Error::input(format!("'{}' is no corner of a face", shortened(word))))?;
        let index = if number < 0 { count as i64 + number } else { number - 1 };
        if !(0..count as i64).contains(&index) {
            return Err(Error::input(format!("the corner '{}' does not exist", shortened(word))));
        }
        *found = Some(index as usize);
    }
    let position =
        found[0].ok_or_else(|| Error::input(format!("'{}' is no corner of a face", shortened(word))))?;
    Ok((position, found[1], found[2]))
}
