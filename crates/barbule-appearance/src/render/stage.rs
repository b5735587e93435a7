//! What stands in a scene, with the hierarchy that rays search: built once, lit and looked at as often as one likes.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::accelerator::{Accelerator, Beam, Instances};
use super::window::{Met, Pane};
use crate::Result;
use crate::bsdf::{Hit, Surface};
use crate::progress::{Progress, Unobserved};
use crate::scene::Object;
use crate::scene::window::Window;

/// Objects ready for rays.
pub struct Stage {
    objects: Vec<Object>,
    accelerator: Accelerator,
    instances: Option<Instances>,
    /// Of each object that is a window; empty, if there is none.
    panes: Vec<Option<Arc<Pane>>>,
    nearest_mm: f64,
    is_opaque: bool,
}

impl Stage {
    /// Checks the objects and builds their hierarchy.
    ///
    /// # Errors
    /// Broken geometry; the message names the object and the shape.
    pub fn new(objects: Vec<Object>) -> Result<Self> {
        Self::watched(objects, &Unobserved)
    }

    /// The same for who may stop it.
    ///
    /// # Errors
    /// As [`Stage::new`], or a stop by `progress`.
    pub fn watched(objects: Vec<Object>, progress: &dyn Progress) -> Result<Self> {
        for (index, object) in objects.iter().enumerate() {
            object.geometry.check().map_err(|error| error.at(format!("object {index}")))?;
        }
        let accelerator = Accelerator::new(&objects, progress)?;
        let instances = Instances::new(&objects, progress)?;
        let nearest_mm = nearest_mm(&objects);
        let is_opaque = |one: &Object| one.geometry.window.is_none() && one.surface.is_opaque();
        let is_opaque = objects.iter().all(is_opaque);
        let panes = panes(&objects, progress)?;
        Ok(Self { objects, accelerator, instances, panes, nearest_mm, is_opaque })
    }

    /// The objects.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Number of primitives that rays are tested against, those of instances once.
    #[must_use]
    pub fn primitives(&self) -> usize {
        self.objects.iter().map(|object| object.geometry.primitives()).sum()
    }

    /// Bytes of the hierarchies, primitives included.
    #[must_use]
    pub fn hierarchy_bytes(&self) -> usize {
        let mut panes: Vec<&Arc<Pane>> = self.panes.iter().flatten().collect();
        panes.sort_by_key(|pane| Arc::as_ptr(pane));
        panes.dedup_by_key(|pane| Arc::as_ptr(pane));
        self.accelerator.bytes()
            + self.instances.as_ref().map_or(0, Instances::bytes)
            + panes.into_iter().map(|pane| pane.bytes()).sum::<usize>()
    }

    /// Nearest distance at which a ray that leaves a surface may hit another, mm: a hundred-thousandth of the
    /// stage's size, far less than a barbule's width and far more than rounding. Where one object is much smaller than the stage, down to a
    /// millionth of that.
    #[inline]
    #[must_use]
    pub fn nearest_mm(&self) -> f64 {
        self.nearest_mm
    }

    /// Whether no surface lets light pass straight through.
    #[inline]
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// The nearest hit between `nearest` and `farthest`, mm along the unit direction. Its footprint is 0.
    #[inline]
    #[must_use]
    pub fn hit(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> Option<Hit> {
        let hit = self.accelerator.hit(&self.objects, origin, direction, nearest, farthest);
        let Some(instances) = &self.instances else { return hit };
        let farthest = hit.as_ref().map_or(farthest, |hit| hit.distance);
        instances.hit(&self.objects, origin, direction, nearest, farthest).or(hit)
    }

    /// Whether anything stands between `nearest` and `farthest`, mm.
    #[inline]
    #[must_use]
    pub fn is_blocked(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> bool {
        let blocks = |instances: &Instances| instances.is_blocked(origin, direction, nearest, farthest);
        self.accelerator.is_blocked(origin, direction, nearest, farthest)
            || self.instances.as_ref().is_some_and(blocks)
    }

    /// Whether a ray of a beam may meet anything; where not, none does.
    #[must_use]
    pub(super) fn may_meet(&self, beam: &Beam) -> bool {
        self.accelerator.may_meet(beam)
            || self.instances.as_ref().is_some_and(|instances| instances.may_meet(beam))
    }

    /// What is seen through an object that is a window.
    #[inline]
    pub(super) fn pane(&self, object: usize) -> Option<&Pane> {
        self.panes.get(object)?.as_deref()
    }

    /// The surface that light met.
    #[inline]
    pub(super) fn met_surface(&self, met: &Met) -> &Surface {
        let inside = met.inside.as_ref().and_then(|inside| Some((inside, self.pane(inside.object())?)));
        inside.map_or_else(|| self.surface(&met.hit), |(inside, pane)| pane.surface(inside))
    }

    /// The surface that was hit.
    #[inline]
    #[must_use]
    pub fn surface(&self, hit: &Hit) -> &Surface {
        &self.objects[hit.object as usize].surface
    }
}

/// What is seen through each object that is a window, made once for all that show the same; nothing, if there is none.
fn panes(objects: &[Object], progress: &dyn Progress) -> Result<Vec<Option<Arc<Pane>>>> {
    if objects.iter().all(|object| object.geometry.window.is_none()) {
        return Ok(Vec::new());
    }
    let mut made: Vec<(&Arc<Window>, Arc<Pane>)> = Vec::new();
    let mut panes = Vec::new();
    for object in objects {
        let Some(window) = &object.geometry.window else {
            panes.push(None);
            continue;
        };
        let same = made.iter().find(|(of, _)| Arc::ptr_eq(of, window)).map(|(_, pane)| pane.clone());
        let pane = same.map_or_else(|| Pane::new(window, progress).map(Arc::new), Ok)?;
        made.push((window, pane.clone()));
        panes.push(Some(pane));
    }
    Ok(panes)
}

/// An object is much smaller than the stage below this share.
const MUCH_SMALLER: f64 = 0.25;

fn nearest_mm(objects: &[Object]) -> f64 {
    let bounds = || objects.iter().filter_map(|object| object.geometry.bounds());
    let length = |[low, high]: [Vec3; 2]| f64::from((high - low).length());
    let Some(whole) = bounds().reduce(|[low, high], [a, b]| [low.min(a), high.max(b)]).map(length) else {
        return 1e-5;
    };
    let smallest = bounds().map(length).fold(whole, f64::min);
    if smallest < MUCH_SMALLER * whole { (1e-5 * smallest).max(1e-6 * whole) } else { 1e-5 * whole }
}
