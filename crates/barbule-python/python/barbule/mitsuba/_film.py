"""The BSDF ``barbule_film``: a smooth thin film."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import film
from ._base import MITSUBA_NM, channels, clip, dr, floats, mi, refuse_mono, spectrum, wavelengths


class _Reflectance:
    """A film's reflectance for unpolarized light over cosθ and the wavelength, bilinear."""

    COSINES = 257

    def __init__(self, stack: str) -> None:
        nm = np.arange(MITSUBA_NM[0], MITSUBA_NM[1] + 1.0)
        cosines = np.linspace(0.0, 1.0, self.COSINES)
        found = film(stack, nm, np.degrees(np.arccos(cosines[1:])), progress=False)
        table = np.ones((self.COSINES, len(nm)))  # at grazing all is reflected
        table[1:] = 0.5 * (np.asarray(found["R_s"]) + np.asarray(found["R_p"]))
        self.waves, self.first = len(nm), float(nm[0])
        self.is_jit = bool(dr.is_jit_v(mi.Float))
        self.table: Any = floats(table) if self.is_jit else table.ravel()

    def _at(self, index: Any) -> Any:
        return dr.gather(mi.Float, self.table, index) if self.is_jit else float(self.table[index])

    def at(self, cosine: Any, nm: Any) -> Any:
        """R at cosθ and a wavelength, nm."""
        row, a = self._place(cosine * float(self.COSINES - 1), self.COSINES)
        wave, b = self._place(nm - self.first, self.waves)
        index = row * self.waves + wave
        low = dr.lerp(self._at(index), self._at(index + 1), b)
        return dr.lerp(low, dr.lerp(self._at(index + self.waves), self._at(index + self.waves + 1), b), a)

    def _place(self, at: Any, count: int) -> tuple[Any, Any]:
        low = clip(dr.floor(at), 0.0, float(count - 2))
        return (mi.UInt32(low) if self.is_jit else int(low)), clip(at - low, 0.0, 1.0)


def film_class() -> type:
    """The class of films, in all spectral variants."""

    class BarbuleFilm(mi.BSDF):  # type: ignore[misc]
        """A smooth stack of layers: a mirror with the exact reflectance; what is not reflected is absorbed."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            refuse_mono()
            if "stack" not in props:
                raise ValueError("barbule_film: 'stack' is missing, as in air/keratin:595/air")
            self.stack = str(props["stack"])
            self.reflectance = _Reflectance(self.stack)
            flags = mi.BSDFFlags.DeltaReflection | mi.BSDFFlags.FrontSide
            self.m_components, self.m_flags = [flags], flags

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return dr.zeros(mi.Spectrum)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return mi.Float(0.0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return dr.zeros(mi.Spectrum), mi.Float(0.0)

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
            sampled = dr.zeros(mi.BSDFSample3f)
            if not ctx.is_enabled(mi.BSDFFlags.DeltaReflection):
                return sampled, dr.zeros(mi.Spectrum)
            cosine = si.wi.z
            active = active & (cosine > 0.0)
            sampled.wo = mi.Vector3f(-si.wi.x, -si.wi.y, cosine)
            sampled.pdf = dr.select(active, mi.Float(1.0), 0.0)
            sampled.eta = 1.0
            sampled.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaReflection)
            sampled.sampled_component = mi.UInt32(0)
            values = spectrum(channels([self.reflectance.at(cosine, nm) for nm in wavelengths(si)]))
            return sampled, dr.select(active, values, dr.zeros(mi.Spectrum))

        def to_string(self) -> str:
            return f"BarbuleFilm[stack = {self.stack}]"

    return BarbuleFilm
