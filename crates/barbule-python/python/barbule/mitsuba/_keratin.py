"""The BSDF ``barbule_keratin``: pigmented keratin, a rough boundary over a diffuse body, the same on both sides.

The model is that of the program's own shafts, rami and undersides (``docs/theory/rendering.md``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _native
from ._base import clip, dr, floats, mi, refuse_mono, refuse_scalar, spectrum


@dataclass
class Side:
    """The side of a surface that is seen, in world coordinates: a shading frame whose y lies along a barbule or fibre, and the normal."""

    x: Any
    y: Any
    z: Any
    normal: Any
    is_upper: Any
    #: Towards the viewer, in the frame.
    wi: Any

    @classmethod
    def of(cls, si: Any, x: Any, y: Any, z: Any) -> Side:
        """From the frame of the upper side."""
        towards = si.to_world(si.wi)
        is_upper = dr.dot(towards, si.n) >= 0.0
        sign = dr.select(is_upper, 1.0, -1.0)
        normal, x, z = si.n * sign, x * sign, z * sign
        # Where the interpolated normal looks away although the face does not, the face itself is shaded.
        looks_away = dr.dot(towards, z) <= 0.0
        flat_y = dr.normalize(y - normal * dr.dot(normal, y))
        x = dr.select(looks_away, dr.cross(flat_y, normal), x)
        y, z = dr.select(looks_away, flat_y, y), dr.select(looks_away, normal, z)
        side = cls(x, y, z, normal, is_upper, None)
        side.wi = side.local(towards)
        return side

    def local(self, w: Any) -> Any:
        """A world direction in the frame."""
        return mi.Vector3f(dr.dot(self.x, w), dr.dot(self.y, w), dr.dot(self.z, w))

    def outwards(self, si: Any, wo: Any) -> tuple[Any, Any]:
        """Mitsuba's local direction in the frame, and whether light that comes from there is reflected."""
        away = si.to_world(wo)
        local = self.local(away)
        return local, (dr.dot(away, self.normal) > 0.0) & (local.z > 0.0) & (self.wi.z > 0.0)

    def of_mitsuba(self, si: Any, w: Any) -> Any:
        """A direction of the frame as Mitsuba's local one."""
        return si.to_local(self.x * w.x + self.y * w.y + self.z * w.z)


class Keratin:
    """A GGX boundary with Fresnel reflectance over a diffuse body."""

    def __init__(self, props: Any, prefix: str, body: str) -> None:
        plugin = props.plugin_name()
        for name in (f"{prefix}roughness", f"{prefix}index", body):
            if name not in props:
                raise ValueError(f"{plugin}: '{name}' is missing")
        self.alpha, self.index = float(props[f"{prefix}roughness"]), float(props[f"{prefix}index"])
        self.body = props[body]
        albedo, self.mean = _native.keratin_boundary(self.alpha, self.index)
        self.steps = len(albedo) - 1
        self.albedo = floats(np.array(albedo))
        #: Of the body, which decides how samples are shared out.
        self.mean_body = float(dr.ravel(self.body.mean())[0])

    def _lookup(self, cosine: Any) -> Any:
        at = clip(cosine, 0.0, 1.0) * float(self.steps)
        low = dr.fmin(dr.floor(at), float(self.steps - 1))
        here, there = (dr.gather(mi.Float, self.albedo, mi.UInt32(low) + step) for step in (0, 1))
        return dr.lerp(here, there, at - low)

    def _lambda(self, w: Any) -> Any:
        slope = self.alpha**2 * (w.x * w.x + w.y * w.y) * dr.rcp(dr.fmax(w.z * w.z, 1e-30))
        return 0.5 * (dr.sqrt(1.0 + slope) - 1.0)

    def _gloss_share(self, cosine: Any) -> Any:
        gloss = self._lookup(cosine)
        return clip(gloss * dr.rcp(dr.fmax(gloss + (1.0 - gloss) * self.mean_body, 1e-9)), 0.1, 0.9)

    def _fresnel(self, cosine: Any) -> Any:
        c = clip(cosine, 0.0, 1.0)
        t = dr.sqrt(dr.fmax(1.0 - (1.0 - c * c) * (1.0 / self.index**2), 0.0))
        s = (c - self.index * t) * dr.rcp(c + self.index * t)
        p = (self.index * c - t) * dr.rcp(self.index * c + t)
        return 0.5 * (s * s + p * p)

    def evaluate(self, wi: Any, wo: Any, si: Any, active: Any) -> tuple[list[Any], Any]:
        """f cosθ of each channel, 1/sr, and the density per sr; both directions in the frame, above the surface."""
        h = dr.normalize(wi + wo)
        t = (h.x * h.x + h.y * h.y) * (1.0 / self.alpha**2) + h.z * h.z
        d = (1.0 / (math.pi * self.alpha**2)) * dr.rcp(t * t)
        lambda_i, lambda_o = self._lambda(wi), self._lambda(wo)
        per_cosine = 0.25 * dr.rcp(wi.z)
        gloss = self._fresnel(dr.dot(wi, h)) * d * per_cosine * dr.rcp(1.0 + lambda_i + lambda_o)
        into, out_of = 1.0 - self._lookup(wi.z), 1.0 - self._lookup(wo.z)
        diffuse = into * out_of * wo.z * (1.0 / (math.pi * (1.0 - self.mean)))
        values = [dr.fma(diffuse, body, gloss) for body in self.body.eval(si, active)]
        share = self._gloss_share(wi.z)
        density = share * d * per_cosine * dr.rcp(1.0 + lambda_i) + (1.0 - share) * wo.z * (1.0 / math.pi)
        return values, density

    def sample(self, wi: Any, choice: Any, u: Any) -> Any:
        """A direction of the frame; z ≤ 0 where nothing is drawn."""
        # A normal that is seen (Dupuy & Benyoub 2023).
        stretched = dr.normalize(mi.Vector3f(wi.x * self.alpha, wi.y * self.alpha, wi.z))
        z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z
        sine = dr.sqrt(clip(1.0 - z * z, 0.0, 1.0))
        sin_azimuth, cos_azimuth = dr.sincos(u.x * (2.0 * math.pi))
        h = mi.Vector3f(sine * cos_azimuth, sine * sin_azimuth, z) + stretched
        h = dr.normalize(mi.Vector3f(h.x * self.alpha, h.y * self.alpha, h.z))
        mirrored = 2.0 * dr.dot(wi, h) * h - wi
        radius, (sin_turn, cos_turn) = dr.sqrt(u.x), dr.sincos(u.y * (2.0 * math.pi))
        diffuse = mi.Vector3f(radius * cos_turn, radius * sin_turn, dr.sqrt(dr.fmax(1.0 - u.x, 0.0)))
        return dr.select(choice < self._gloss_share(wi.z), mirrored, diffuse)


def sampled(side: Side, si: Any, w: Any, found: tuple[list[Any], Any], active: Any, flag: Any) -> tuple[Any, Any]:
    """What ``sample`` returns for a direction of the frame, its values and its density."""
    values, density = found
    wo = side.of_mitsuba(si, w)
    _, is_reflected = side.outwards(si, wo)
    active = active & is_reflected & (density > 0.0)
    sample = dr.zeros(mi.BSDFSample3f)
    sample.wo = dr.select(active, wo, 0.0)
    sample.pdf = dr.select(active, density, 0.0)
    sample.eta = 1.0
    sample.sampled_type = mi.UInt32(+flag)
    sample.sampled_component = mi.UInt32(0)
    weight = dr.rcp(density)
    return sample, dr.select(active, spectrum([value * weight for value in values]), 0.0)


def keratin_class() -> type:
    """The class of compiled variants; others refuse it when it is made."""

    class BarbuleKeratin(mi.BSDF):  # type: ignore[misc]
        """Pigmented keratin: shafts and rami."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            refuse_mono()
            refuse_scalar("barbule_keratin")
            self.keratin = Keratin(props, "", "reflectance")
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | sides
            self.m_components, self.m_flags = [flags], flags

        def _side(self, si: Any) -> Side:
            return Side.of(si, si.sh_frame.s, si.sh_frame.t, si.sh_frame.n)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            side = self._side(si)
            local, is_reflected = side.outwards(si, wo)
            active = active & is_reflected & ctx.is_enabled(mi.BSDFFlags.GlossyReflection)
            values, density = self.keratin.evaluate(side.wi, local, si, active)
            return dr.select(active, spectrum(values), 0.0), dr.select(active, density, 0.0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[1]

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
            side = self._side(si)
            active = active & (side.wi.z > 0.0) & ctx.is_enabled(mi.BSDFFlags.GlossyReflection)
            w = self.keratin.sample(side.wi, sample1, sample2)
            found = self.keratin.evaluate(side.wi, w, si, active)
            return sampled(side, si, w, found, active, mi.BSDFFlags.GlossyReflection)

        def to_string(self) -> str:
            return f"BarbuleKeratin[roughness = {self.keratin.alpha}, index = {self.keratin.index}]"

    return BarbuleKeratin
