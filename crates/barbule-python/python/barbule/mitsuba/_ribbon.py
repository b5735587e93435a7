"""The BSDF ``barbule_ribbon``: barbules as the program's own scenes have them, on the ribbons that those are written as.

Frames, cells and names come with the ribbons (``docs/guide/mitsuba.md`` has the columns of their PLY files).
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from .. import _native
from ._base import channels, clip, dr, mi, refuse_mono, refuse_scalar, spectrum, split_mix, wavelengths, whole
from ._keratin import Keratin, Side, sampled
from ._tables import Tables

#: Length over width of a barbule that is one cell, where several are seen together.
_LONG_CELL = 10.0
#: Below this share of an instance's contrast only the mean is seen.
_LEAST_CONTRAST = 0.1
#: Over this blur, in half widths, an arch is even.
_MOST_BLUR = 3.0


@lru_cache(maxsize=16)
def _tables(path: str, reciprocity: str, variant: str, changed_ns: int) -> Tables:
    header, tables = _native.read_tables(path)
    return Tables({**header, "reciprocity": reciprocity}, tables)


def _read(props: Any, name: str, reciprocity: str) -> Tables:
    """The tables of a file, each once for a variant."""
    path = str(mi.file_resolver().resolve(str(props[name])))
    if not os.path.isfile(path):
        raise ValueError(f"barbule_ribbon: '{name}' is {path}; there is no such file")
    return _tables(path, str(props.get(reciprocity, "steeper")), mi.variant(), os.stat(path).st_mtime_ns)


def _bell(name: Any) -> Any:
    """A number of mean 0 and deviation 1 that a name stands for: the sum of four uniform ones."""
    bits = split_mix(name ^ mi.UInt64(0x5BD1E9957B11C3A1))
    total = sum((mi.Float((bits >> (16 * k)) & 0xFFFF) for k in range(4)), mi.Float(0.0))
    return (total - 131070.0) * math.sqrt(3.0 / 4294967295.0)


def _name(si: Any, attribute: str, active: Any) -> Any:
    """64 bits in singles of 22, 22 and 20."""
    bits = si.shape.eval_attribute_3(attribute, si, active)
    return whole(bits[0]) | (whole(bits[1]) << 22) | (whole(bits[2]) << 44)


@dataclass
class _Arch:
    """The arch of a cross-section: slopes at its edges, and its blur in half widths."""

    low: float
    high: float
    blur: float

    def share(self, x: Any, footprint: Any, wi: Any, wo: Any) -> Any:
        """How much of the light between two directions comes from x, −1 … 1 across, over the mean of the width."""
        blur = dr.sqrt(self.blur**2 + dr.square(footprint))
        half = wi + wo
        low, high = math.sin(self.low), math.sin(self.high)
        across = dr.fmax(dr.sqrt(half.x * half.x + half.z * half.z), 1e-20)
        mirror = clip((2.0 * half.x * dr.rcp(across) - (low + high)) * (1.0 / (high - low)), -1.0, 1.0)
        per_blur = dr.rcp(blur)
        root = math.sqrt(0.5)
        mean = 0.25 * (dr.erf((1.0 - mirror) * per_blur * root) + dr.erf((1.0 + mirror) * per_blur * root))
        share = dr.exp(-0.5 * dr.square((x - mirror) * per_blur)) * per_blur * dr.rcp(mean * math.sqrt(2.0 * math.pi))
        return dr.select(blur > _MOST_BLUR, 1.0, share)


@dataclass
class _Place:
    """Where on a ribbon a hit is."""

    side: Side
    is_wall: Any
    name: Any
    #: Share of the instance's contrast that is seen.
    contrast: Any
    #: Wavelengths over the size of the cell's nanostructure.
    nm: list[Any]
    #: −1 … 1 across.
    x: Any
    #: Radius of the ray's footprint in half widths.
    footprint: Any


def ribbon_class() -> type:
    """The class of compiled variants; others refuse it when it is made."""

    class BarbuleRibbon(mi.BSDF):  # type: ignore[misc]
        """A barbule: its material above, another or keratin below, keratin where its cells meet."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            refuse_mono()
            refuse_scalar("barbule_ribbon")
            if "tables" not in props:
                raise ValueError("barbule_ribbon: 'tables' is missing: a file of BRDF tables")
            self.upper = _read(props, "tables", "reciprocity")
            self.lower = _read(props, "below", "below_reciprocity") if "below" in props else None
            self.keratin = Keratin(props, "", "under")
            self.instances, self.placed = bool(props.get("instances", True)), bool(props.get("placed", False))
            number = {name: float(props.get(name, 0.0)) for name in _NUMBERS}
            self.number = number
            arch = [number[name] for name in ("arch_low", "arch_high", "arch_blur")]
            self.arch = _Arch(*arch) if arch[1] > arch[0] else None
            self.eye = mi.ScalarPoint3f(props["eye"]) if "eye" in props else None
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.Anisotropic | sides
            self.m_components, self.m_flags = [flags], flags

        # -- where a hit is --

        def _place(self, si: Any, active: Any) -> _Place:
            number, u = self.number, si.uv.x
            along = dr.normalize(mi.Vector3f(si.shape.eval_attribute_3("vertex_along", si, active)))
            across = mi.Vector3f(si.shape.eval_attribute_3("vertex_across", si, active))
            half_width = dr.fmax(si.shape.eval_attribute_1("vertex_half", si, active), 1e-9)
            z = dr.normalize(dr.cross(across, along))
            x, cell = dr.cross(along, z), dr.floor(u)
            at, is_wall = u - cell, mi.Bool(False)
            if number["cell_mm"] > 0.0:
                sine, cosine = dr.sincos(number["swelling"] * (1.0 - 2.0 * at))
                along, z = along * cosine + z * sine, z * cosine - along * sine
                is_wall = dr.fmin(at, 1.0 - at) * number["cell_mm"] < 0.5 * number["wall_mm"]
            side = Side.of(si, x, along, z)
            barbule = _name(si, "face_inst", active)
            name = split_mix(barbule ^ split_mix(whole(cell)))
            if self.placed:
                place = split_mix(_name(si, "face_place", active))
                barbule, name = split_mix(barbule ^ place), split_mix(name ^ place)
            nm = wavelengths(si)
            if number["cell_size"] > 0.0 or number["barbule_size"] > 0.0:
                per_size = dr.rcp(1.0 + number["cell_size"] * _bell(name) + number["barbule_size"] * _bell(barbule))
                nm = [wavelength * per_size for wavelength in nm]
            radius = number["footprint_mm"]
            if self.eye is not None:
                radius = number["spread"] * dr.norm(si.p - self.eye)
            return _Place(side, is_wall, name, self._contrast(radius, half_width), nm, si.uv.y, radius * dr.rcp(half_width))

        def _contrast(self, radius: Any, half_width: Any) -> Any:
            """1/√n of n cells that a ray's footprint holds."""
            width = 2.0 * half_width
            length = self.number["cell_mm"] if self.number["cell_mm"] > 0.0 else _LONG_CELL * width
            cells = dr.fmax(2.0 * radius / width, 1.0) * dr.fmax(2.0 * radius / length, 1.0)
            contrast = dr.rsqrt(cells)
            return dr.select(contrast > _LEAST_CONTRAST, contrast, 0.0)

        # -- values --

        def _evaluated(self, place: _Place, wo: Any, si: Any, active: Any) -> tuple[list[Any], Any]:
            wi, is_upper = place.side.wi, place.side.is_upper
            values, density = self.keratin.evaluate(wi, wo, si, active)
            share = None if self.arch is None else self.arch.share(place.x, place.footprint, wi, wo)
            name = place.name if self.instances else None
            for tables, is_here in ((self.upper, is_upper), (self.lower, ~is_upper)):
                if tables is None:
                    continue
                is_here = is_here & ~place.is_wall
                found, own = tables.evaluate(wi, wo, place.nm, name, contrast=place.contrast)
                if share is not None:
                    found = [value * share for value in found]
                values = [dr.select(is_here, value, other) for value, other in zip(channels(found), values)]
                density = dr.select(is_here, own, density)
            return values, density

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            place = self._place(si, active)
            local, is_reflected = place.side.outwards(si, wo)
            active = active & is_reflected & ctx.is_enabled(mi.BSDFFlags.GlossyReflection)
            values, density = self._evaluated(place, local, si, active)
            return dr.select(active, spectrum(values), 0.0), dr.select(active, density, 0.0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[1]

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
            place = self._place(si, active)
            wi, is_upper = place.side.wi, place.side.is_upper
            active = active & (wi.z > 0.0) & ctx.is_enabled(mi.BSDFFlags.GlossyReflection)
            w = self.keratin.sample(wi, sample1, sample2)
            for tables, is_here in ((self.upper, is_upper), (self.lower, ~is_upper)):
                if tables is not None:
                    own = tables.sample(wi, place.nm, sample1, sample2.x, sample2.y)
                    w = dr.select(is_here & ~place.is_wall, own, w)
            active = active & (w.z > 0.0)
            found = self._evaluated(place, w, si, active)
            return sampled(place.side, si, w, found, active, mi.BSDFFlags.GlossyReflection)

        def to_string(self) -> str:
            return f"BarbuleRibbon[cell_mm = {self.number['cell_mm']}, lower side = {self.lower is not None}]"

    return BarbuleRibbon


_NUMBERS = (
    "cell_mm",
    "swelling",
    "wall_mm",
    "cell_size",
    "barbule_size",
    "arch_low",
    "arch_high",
    "arch_blur",
    "footprint_mm",
    "spread",
)
