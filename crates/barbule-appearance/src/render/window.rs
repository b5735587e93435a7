//! Windows ready for rays: what is met in the layer that a mesh shows, and where light goes from there.
//!
//! A ray that meets the mesh goes on in the layer, through a place of it that a hash of the hit's place draws: anywhere with the
//! same chance, as the ray crosses the layer's middle plane. Light scattered there goes on in the layer too, to more scatterings, until it leaves
//! above or below; then it leaves the mesh where it came in. So light in the layer is followed as if all of it stood there, except
//! that it does not move along the mesh, which from afar nobody sees.

use std::sync::Arc;

use glam::DVec3;

use super::stage::Stage;
use crate::Result;
use crate::bsdf::{Frame, Hit, Surface};
use crate::math::rng::{hash, split_mix, unit_of};
use crate::progress::Progress;
use crate::scene::Object;
use crate::scene::window::{Layer, Window};

/// What a window shows.
pub(super) struct Pane {
    layers: Vec<Shown>,
    window: Arc<Window>,
}

struct Shown {
    stage: Stage,
    across_mm: [f64; 2],
    along_mm: [f64; 2],
    /// Lowest and highest z, mm.
    heights_mm: [f64; 2],
}

/// A place in a layer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inside {
    /// The mesh's object, and which of its layers.
    object: u32,
    layer: u32,
    /// The mesh's frame where it was entered.
    frame: Frame,
    /// The place in the layer, mm.
    at: DVec3,
    /// The object of the layer that is there.
    part: u32,
    /// Draws of what is met through this place of the mesh.
    name: u64,
    /// Of the mesh: its hit's place, distance and identity.
    door: DVec3,
    distance: f64,
    id: u64,
}

/// A surface that light meets.
pub(super) struct Met {
    /// The hit; in a layer the mesh's place and distance with what stands in the layer.
    pub(super) hit: Hit,
    pub(super) inside: Option<Inside>,
}

impl Met {
    /// Identity of the shape that stands in the scene.
    #[inline]
    pub(super) fn id(&self) -> u64 {
        self.inside.map_or(self.hit.id, |inside| inside.id)
    }
}

/// Rays that rise less than this start within the layer.
const LEAST_RISE: f64 = 0.02;

impl Pane {
    /// # Errors
    /// Broken geometry, or a stop by `progress`.
    pub(super) fn new(window: &Arc<Window>, progress: &dyn Progress) -> Result<Self> {
        let layers = window.layers.iter().map(|layer| Shown::new(layer, progress)).collect::<Result<_>>()?;
        Ok(Self { layers, window: window.clone() })
    }

    /// Bytes of the layers' hierarchies.
    pub(super) fn bytes(&self) -> usize {
        self.layers.iter().map(|shown| shown.stage.hierarchy_bytes()).sum()
    }

    /// What a ray through a hit of the mesh meets.
    #[inline(never)]
    pub(super) fn enter(&self, hit: &Hit, direction: DVec3) -> Option<Met> {
        let name = hash(hit.id, &hit.position.to_array().map(f64::to_bits));
        let layer = self.window.layer_at(hit.uv, name);
        let shown = &self.layers[layer];
        let along = hit.frame.to_local(direction);
        let between = |[low, high]: [f64; 2], name: u64| low + (high - low) * unit_of(name);
        let draw = split_mix(name);
        let through =
            DVec3::new(between(shown.across_mm, draw), between(shown.along_mm, split_mix(draw)), 0.0);
        let [low, high] = shown.heights_mm;
        let back = if along.z < 0.0 { high.max(0.0) } else { (-low).max(0.0) };
        let back = (back / along.z.abs().max(LEAST_RISE)).min(shown.across_mm[1]);
        let inside = Inside {
            object: hit.object,
            layer: layer as u32,
            frame: hit.frame,
            at: through - along * back,
            part: 0,
            name,
            door: hit.position,
            distance: hit.distance,
            id: hit.id,
        };
        self.follow(&inside, along, 0.0)
    }

    /// What light that is scattered in the layer meets before it leaves it.
    #[inline(never)]
    pub(super) fn go_on(&self, inside: &Inside, direction: DVec3) -> Option<Met> {
        let nearest = self.layers[inside.layer as usize].stage.nearest_mm();
        self.follow(inside, inside.frame.to_local(direction), nearest)
    }

    /// Whether light from a direction does not reach a place in the layer.
    #[inline(never)]
    pub(super) fn is_blocked(&self, inside: &Inside, direction: DVec3) -> bool {
        let stage = &self.layers[inside.layer as usize].stage;
        stage.is_blocked(inside.at, inside.frame.to_local(direction), stage.nearest_mm(), f64::INFINITY)
    }

    /// The surface there.
    pub(super) fn surface(&self, inside: &Inside) -> &Surface {
        &self.layers[inside.layer as usize].stage.objects()[inside.part as usize].surface
    }

    fn follow(&self, inside: &Inside, along: DVec3, nearest: f64) -> Option<Met> {
        let stage = &self.layers[inside.layer as usize].stage;
        let met = stage.hit(inside.at, along, nearest, f64::INFINITY)?;
        let turned = |v: DVec3| inside.frame.to_world(v);
        let Frame { x, y, z } = met.frame;
        let hit = Hit {
            position: inside.door,
            normal: turned(met.normal),
            vane_normal: turned(met.vane_normal),
            frame: Frame { x: turned(x), y: turned(y), z: turned(z) },
            uv_gradients: met.uv_gradients.map(turned),
            object: inside.object,
            id: split_mix(met.id ^ inside.name),
            instance: split_mix(met.instance ^ inside.name),
            distance: inside.distance,
            ..met
        };
        Some(Met { hit, inside: Some(Inside { at: met.position, part: met.object, ..*inside }) })
    }
}

impl Inside {
    /// Index of the mesh's object.
    #[inline]
    pub(super) fn object(&self) -> usize {
        self.object as usize
    }
}

impl Shown {
    fn new(layer: &Layer, progress: &dyn Progress) -> Result<Self> {
        let Layer { objects, across_mm, along_mm } = layer;
        let stage = Stage::watched(objects.clone(), progress)?;
        let heights = objects.iter().fold([0.0_f64; 2], |[low, high], Object { geometry, .. }| {
            let widest = geometry.widest();
            geometry.bounds().map_or([low, high], |[a, b]| {
                [low.min(f64::from(a.z - widest)), high.max(f64::from(b.z + widest))]
            })
        });
        Ok(Self { stage, across_mm: *across_mm, along_mm: *along_mm, heights_mm: heights })
    }
}
