//! A snake's scales, as those of the preset, with as many triangles as an adapter draws.

use barbule_appearance::scene::description::SceneDescription;
use barbule_appearance::scene::geometry::Mesh;
use barbule_base::{Error, Result};

use super::names::name_at;
use super::ribbon::{add_mesh, kept};
use super::{MOST_TRIANGLES, Naming, Part, Shape};

/// The preset that has one.
const PRESET: &str = "snake";

/// The scales of the preset's snake. Tangents lead to the tail; texture coordinates are across and along each scale.
///
/// # Errors
/// None, as long as there is a preset with a snake.
pub fn snake() -> Result<Shape> {
    let scene = SceneDescription::named(PRESET)?;
    let object = scene.objects.iter().find(|object| object.label() == PRESET);
    let object = object.ok_or_else(|| Error::machine("the preset of the snake shows no snake"))?;
    let geometry = object.geometry(0)?;
    let (Some(mesh), Some(place)) = (geometry.meshes.first(), geometry.places.first()) else {
        return Err(Error::machine("the preset's snake has no scales"));
    };
    let name = name_at(mesh.id, place.id);
    let mut stride = 1;
    let mut thinned = mesh.clone();
    while thinned.triangles.len() > MOST_TRIANGLES {
        stride += 1;
        thinned = of_every(mesh, stride)?;
    }
    let mut shape = Shape::new(Naming::Plain);
    add_mesh(&mut shape, &thinned, name, Part::Grating.code(0));
    Ok(shape)
}

/// The same patches of every `stride`-th of their columns and rows: a patch is a grid whose texture coordinates go from edge to edge.
fn of_every(mesh: &Mesh, stride: usize) -> Result<Mesh> {
    let irregular =
        || Error::machine("the scales of the snake are no grids of vertices, so they cannot be thinned");
    let columns = mesh.uvs.iter().take_while(|uv| uv.y == mesh.uvs[0].y).count();
    let is_new =
        |row: usize| mesh.uvs.get(row * columns).is_none_or(|uv| uv.y <= mesh.uvs[(row - 1) * columns].y);
    let rows = if columns > 1 { (1..).find(|&row| is_new(row)).unwrap_or(0) } else { 0 };
    if rows < 2 || !mesh.positions.len().is_multiple_of(rows * columns) {
        return Err(irregular());
    }
    let (of_columns, of_rows): (Vec<_>, Vec<_>) =
        (kept(columns, stride).collect(), kept(rows, stride).collect());
    let mut thinned = Mesh { id: mesh.id, ..Mesh::default() };
    for patch in (0..mesh.positions.len()).step_by(rows * columns) {
        let first = thinned.positions.len() as u32;
        for at in
            of_rows.iter().flat_map(|row| of_columns.iter().map(move |column| patch + row * columns + column))
        {
            thinned.positions.push(mesh.positions[at]);
            thinned.normals.push(mesh.normals[at]);
            thinned.tangents.push(mesh.tangents[at]);
            thinned.uvs.push(mesh.uvs[at]);
        }
        let (across, along) = (of_columns.len() as u32, of_rows.len() as u32);
        for (j, i) in (0..along - 1).flat_map(|j| (0..across - 1).map(move |i| (j, i))) {
            let at = first + j * across + i;
            let (right, above) = (at + 1, at + across);
            thinned.triangles.extend([[at, right, above], [right, above + 1, above]]);
        }
    }
    Ok(thinned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn scales_are_thinned_and_keep_their_edges() {
        let shape = snake().unwrap();
        shape.check().unwrap();
        assert!(shape.triangles.len() > 50_000, "{}", shape.triangles.len());
        let scene = SceneDescription::named(PRESET).unwrap();
        let geometry = scene.objects[0].geometry(0).unwrap();
        let mesh = &geometry.meshes[0];
        assert!(mesh.triangles.len() > shape.triangles.len());
        let bounds = |points: &mut dyn Iterator<Item = Vec3>| {
            points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
        };
        let [low, high] = bounds(&mut mesh.positions.iter().copied());
        let [own_low, own_high] = shape.bounds_mm().unwrap();
        assert!(
            low.distance(own_low) < 0.5 && high.distance(own_high) < 0.5,
            "{low} {own_low} {high} {own_high}"
        );
        // Faces look where normals do, but for slivers at the tips.
        let against = shape.triangles.iter().filter(|corners| {
            let [a, b, c] = corners.map(|corner| Vec3::from(shape.vertices[corner as usize].position_mm));
            (b - a).cross(c - a).dot(shape.vertices[corners[0] as usize].normal.into()) < 0.0
        });
        assert!(against.count() * 100 < shape.triangles.len());
    }

    #[test]
    fn patches_that_are_no_grids_are_refused() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec3::X; 3],
            uvs: vec![glam::Vec2::ZERO, glam::Vec2::X, glam::Vec2::Y],
            triangles: vec![[0, 1, 2]],
            id: 1,
        };
        assert!(of_every(&mesh, 2).unwrap_err().to_string().contains("no grids"));
    }
}
