"""The BSDF ``barbule``: a feather's material on any surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .._material import Material
from ._base import BELOW_1, MASK, channels, dr, mi, refuse_mono, spectrum, split_mix, split_mix_of, wavelengths, whole
from ._tables import Tables

Instances = Literal["none", "uv", "face", "prim"]

INSTANCES: tuple[Instances, ...] = ("none", "uv", "face", "prim")
RECIPROCITY = ("none", "steeper", "mean")
#: Which of a surface's parameters grows along barbules.
ALONG = ("u", "v")


@dataclass(frozen=True)
class _Asked:
    """Parameters of a ``barbule``."""

    material: str
    instances: Instances
    cells: float
    reciprocity: Any
    polarization: Any
    two_sided: bool
    along: Literal["u", "v"]

    @classmethod
    def of(cls, props: Any) -> _Asked:
        """Read from Mitsuba's properties."""
        if "material" not in props:
            raise ValueError("barbule: 'material' is missing: a species, or a .barbule file")
        polarization = int(props.get("polarization", 0))
        if polarization not in (0, 1, 2):
            raise ValueError(f"barbule: 'polarization' is {polarization}; give 1 or 2, or 0 for unpolarized light")
        asked = cls(
            str(props["material"]),
            _one_of(props, "instances", INSTANCES),
            float(props.get("cells", 1.0)),
            _one_of(props, "reciprocity", RECIPROCITY),
            polarization or None,
            bool(props.get("two_sided", False)),
            _one_of(props, "along", ALONG),
        )
        if not asked.cells > 0.0:
            raise ValueError(f"barbule: 'cells' is {asked.cells}; give a number over 0")
        return asked

    def load(self) -> Material:
        """Its material."""
        return _material(self.material, self.reciprocity, self.polarization)

    def __str__(self) -> str:
        return f"Barbule[material = {self.material}, instances = {self.instances}, two_sided = {self.two_sided}]"


def _one_of(props: Any, name: str, words: Sequence[str]) -> Any:
    word = str(props.get(name, words[0]))
    if word not in words:
        raise ValueError(f"barbule: '{name}' is '{word}'; there are {', '.join(words)}")
    return word


@lru_cache(maxsize=16)
def _material(name: str, reciprocity: Any, polarization: Any) -> Material:
    return Material.load(name, reciprocity=reciprocity, polarization=polarization)


def _named(asked: _Asked, si: Any, active: Any, split_mix: Callable[[Any], Any], whole: Callable[[Any], Any]) -> Any:
    """The name of the instance at a hit, below 2⁶⁴; None for the mean.

    A cell is named as those of ribbons in the program's own scenes are, ``split_mix(barbule ^ split_mix(cell))``.
    """
    if asked.instances == "none":
        return None
    if asked.instances == "prim":
        return whole(si.prim_index)
    if asked.instances == "uv":
        u, v = si.uv.x * asked.cells, si.uv.y * asked.cells
        return split_mix(split_mix(whole(dr.floor(v))) ^ split_mix(whole(dr.floor(u))))
    # 64 bits in singles, which hold whole numbers below 2²⁴.
    bits = si.shape.eval_attribute_3("face_inst", si, active)
    barbule = whole(bits[0]) | (whole(bits[1]) << 22) | (whole(bits[2]) << 44)
    return split_mix(barbule ^ split_mix(whole(dr.floor(si.uv.x))))


def _of_barbule(w: Any, sign: Any, along: str) -> Any:
    """Mitsuba's local direction in the barbule's frame: y along dp_du (or dp_dv), z along the normal, x across; the lower side is the
    upper one turned by 180° about y."""
    return mi.Vector3f(w.x * sign, w.y, w.z * sign) if along == "v" else mi.Vector3f(-w.y * sign, w.x, w.z * sign)


def _of_mitsuba(w: Any, sign: Any, along: str) -> Any:
    return mi.Vector3f(w.x * sign, w.y, w.z * sign) if along == "v" else mi.Vector3f(w.y, -w.x * sign, w.z * sign)


def _glossy(bsdf: Any, asked: _Asked) -> Any:
    flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.Anisotropic | mi.BSDFFlags.FrontSide
    if asked.two_sided:
        flags |= mi.BSDFFlags.BackSide
    bsdf.m_components, bsdf.m_flags = [flags], flags


def jit_class() -> type:
    """The class of variants that compile."""

    class Barbule(mi.BSDF):  # type: ignore[misc]
        """A feather's barbules."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            refuse_mono()
            self.asked = _Asked.of(props)
            material = self.asked.load()
            self.tables = Tables(material.header(), material.tables())
            _glossy(self, self.asked)

        def _turned(self, si: Any) -> tuple[Any, Any]:
            sign = dr.select(si.wi.z < 0.0, -1.0, 1.0) if self.asked.two_sided else mi.Float(1.0)
            return _of_barbule(si.wi, sign, self.asked.along), sign

        def _name(self, si: Any, active: Any) -> Any:
            return _named(self.asked, si, active, split_mix, whole)

        def _evaluated(self, ctx: Any, si: Any, wo: Any, active: Any, valued: bool, dense: bool) -> tuple[Any, Any]:
            if not ctx.is_enabled(mi.BSDFFlags.GlossyReflection):
                return dr.zeros(mi.Spectrum), mi.Float(0.0)
            wi, sign = self._turned(si)
            wo = _of_barbule(wo, sign, self.asked.along)
            active = active & (wi.z > 0.0) & (wo.z > 0.0)
            name = self._name(si, active) if valued else None
            values, density = self.tables.evaluate(wi, wo, wavelengths(si), name, valued, dense)
            found = dr.select(active, spectrum(channels(values)), 0.0) if valued else None
            return found, dr.select(active, density, 0.0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self._evaluated(ctx, si, wo, active, True, False)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self._evaluated(ctx, si, wo, active, False, True)[1]

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return self._evaluated(ctx, si, wo, active, True, True)

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
            sampled = dr.zeros(mi.BSDFSample3f)
            if not ctx.is_enabled(mi.BSDFFlags.GlossyReflection):
                return sampled, dr.zeros(mi.Spectrum)
            wi, sign = self._turned(si)
            active = active & (wi.z > 0.0)
            wo = self.tables.sample(wi, wavelengths(si), sample1, sample2.x, sample2.y)
            active &= wo.z > 0.0
            values, density = self.tables.evaluate(wi, wo, wavelengths(si), self._name(si, active))
            active &= density > 0.0
            sampled.wo = dr.select(active, _of_mitsuba(wo, sign, self.asked.along), 0.0)
            sampled.pdf = dr.select(active, density, 0.0)
            sampled.eta = 1.0
            sampled.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            sampled.sampled_component = mi.UInt32(0)
            weight = dr.rcp(density)
            return sampled, dr.select(active, spectrum([value * weight for value in channels(values)]), 0.0)

        def to_string(self) -> str:
            return str(self.asked)

    return Barbule


def scalar_class() -> type:
    """The class of scalar variants: a call of the native module for each direction."""

    class Barbule(mi.BSDF):  # type: ignore[misc]
        """A feather's barbules."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            refuse_mono()
            self.asked = _Asked.of(props)
            self.material = self.asked.load()
            _glossy(self, self.asked)

        def _sign(self, si: Any) -> float:
            return -1.0 if self.asked.two_sided and si.wi.z < 0.0 else 1.0

        def _values(self, si: Any, wi: Any, wo: Any, active: Any) -> NDArray[np.float64]:
            name = _named(self.asked, si, active, split_mix_of, lambda x: int(x) & MASK)
            instance = None if name is None else np.uint64(name)
            found = self.material.eval(wavelengths(si), wi, wo, instance, threads=1)
            return np.array(channels(list(found * wo[2])), dtype=np.float64)

        def _density(self, si: Any, wi: Any, wo: Any) -> float:
            return float(self.material.pdf(wavelengths(si), wi, wo, threads=1).mean())

        def _seen(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any] | None:
            sign = self._sign(si)
            wi, wo = _unit(_of_barbule(si.wi, sign, self.asked.along)), _unit(_of_barbule(wo, sign, self.asked.along))
            is_seen = active and wi[2] > 0.0 and wo[2] > 0.0 and ctx.is_enabled(mi.BSDFFlags.GlossyReflection)
            return (wi, wo) if is_seen else None

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            seen = self._seen(ctx, si, wo, active)
            return dr.zeros(mi.Spectrum) if seen is None else spectrum(self._values(si, *seen, active).tolist())

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> float:
            seen = self._seen(ctx, si, wo, active)
            return 0.0 if seen is None else self._density(si, *seen)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, float]:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def sample(self, ctx: Any, si: Any, sample1: float, sample2: Any, active: Any = True) -> tuple[Any, Any]:
            sampled, nothing = mi.BSDFSample3f(), dr.zeros(mi.Spectrum)
            sampled.pdf, sign = 0.0, self._sign(si)
            wi = _unit(_of_barbule(si.wi, sign, self.asked.along))
            if not (active and wi[2] > 0.0 and ctx.is_enabled(mi.BSDFFlags.GlossyReflection)):
                return sampled, nothing
            nm = wavelengths(si)
            wave = min(int(sample1 * len(nm)), len(nm) - 1)
            u = [min(sample1 * len(nm) - wave, BELOW_1), min(sample2.x, BELOW_1)]
            wo, density = self.material.sample(nm[wave], wi, u, threads=1)
            if float(density) == 0.0:
                return sampled, nothing
            sampled.pdf = self._density(si, wi, wo)
            sampled.wo = _of_mitsuba(mi.Vector3f(wo), sign, self.asked.along)
            sampled.eta = 1.0
            sampled.sampled_type = +mi.BSDFFlags.GlossyReflection
            sampled.sampled_component = 0
            return sampled, spectrum((self._values(si, wi, wo, active) / sampled.pdf).tolist())

        def to_string(self) -> str:
            return str(self.asked)

    return Barbule


def _unit(w: Any) -> NDArray[np.float64]:
    """In double precision, of length 1."""
    array = np.array([w.x, w.y, w.z], dtype=np.float64)
    return np.asarray(array / np.linalg.norm(array))
