"""What all plugins share: Mitsuba itself, wavelengths and colours, names, and arrays on the variant's device."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _native

try:
    # Their types depend on the variant that is set, so nothing is known of them here.
    mi: Any = import_module("mitsuba")
    dr: Any = import_module("drjit")
except ImportError as error:
    raise ImportError("barbule.mitsuba needs Mitsuba 3: pip install mitsuba==3.9.1") from error

#: Vacuum wavelengths that Mitsuba's spectral variants draw, nm.
MITSUBA_NM = (360.0, 830.0)
#: Vacuum wavelengths of the colours of rgb variants, nm.
RGB_NM = tuple(float(nm) for nm in range(400, 701, 20))
#: The largest single below 1.
BELOW_1 = 1.0 - 2.0**-24
MASK = (1 << 64) - 1

GOLDEN = 0x9E3779B97F4A7C15
_MIX = (0xBF58476D1CE4E5B9, 0x94D049BB133111EB)


# ---- Wavelengths and colours --------------------------------------------------------------------------------------------------------


def refuse_mono() -> None:
    """Refuses variants that have no colours."""
    if mi.is_monochromatic:
        raise ValueError(f"barbule: '{mi.variant()}' has no colours; choose a variant such as llvm_ad_spectral")


def refuse_scalar(plugin: str) -> None:
    """Refuses variants that do not compile."""
    if not dr.is_jit_v(mi.Float):
        raise ValueError(f"{plugin}: '{mi.variant()}' does not compile; choose a variant such as llvm_ad_spectral")


@lru_cache(maxsize=1)
def _rgb_weights() -> NDArray[np.float64]:
    """Linear sRGB ``[wavelength, channel]`` of reflectances that are 1 at one of `RGB_NM`, 0 at the others and linear between."""
    _, linear, _ = _native.xyz_of(np.array(RGB_NM), np.eye(len(RGB_NM)), "D65")
    return np.asarray(linear, dtype=np.float64)


def wavelengths(si: Any) -> list[Any]:
    """Those of a path, nm; of rgb variants `RGB_NM`."""
    return [mi.Float(nm) for nm in RGB_NM] if mi.is_rgb else list(si.wavelengths)


def channels(values: Sequence[Any]) -> list[Any]:
    """Values of `wavelengths` as channels: of rgb variants linear sRGB in D65, where what lies outside counts as 0."""
    if not mi.is_rgb:
        return list(values)
    weights = _rgb_weights()
    sums = [sum((float(w) * v for w, v in zip(weights[:, k], values)), 0.0 * values[0]) for k in range(3)]
    return [dr.fmax(total, 0.0) for total in sums]


def spectrum(values: Sequence[Any]) -> Any:
    """Channels as what BSDFs return: of polarized variants a depolarizer."""
    return mi.depolarizer(mi.UnpolarizedSpectrum(list(values)))


# ---- Names --------------------------------------------------------------------------------------------------------------------------


def split_mix(state: Any) -> Any:
    """One step of SplitMix64 (Steele, Lea & Flood 2014) of ``UInt64``."""
    state = state + mi.UInt64(GOLDEN)
    state = (state ^ (state >> 30)) * mi.UInt64(_MIX[0])
    state = (state ^ (state >> 27)) * mi.UInt64(_MIX[1])
    return state ^ (state >> 31)


def split_mix_of(state: int) -> int:
    """The same of a Python number."""
    state = (state + GOLDEN) & MASK
    state = ((state ^ (state >> 30)) * _MIX[0]) & MASK
    state = ((state ^ (state >> 27)) * _MIX[1]) & MASK
    return state ^ (state >> 31)


def whole(x: Any) -> Any:
    """``UInt64`` of whole numbers: negative ones as two's complements, as in the program's scenes."""
    return mi.UInt64(mi.Int64(mi.Int32(x)))


def clip(x: Any, low: Any, high: Any) -> Any:
    """x within low and high. ``dr.clip``, ``dr.minimum`` and ``dr.maximum`` are instructions that LLVM 14 and 15 do not make of single
    numbers, which branches and gathers leave of vectors: they end the process."""
    return dr.fmax(dr.fmin(x, high), low)


# ---- Arrays -------------------------------------------------------------------------------------------------------------------------


def floats(values: NDArray[Any]) -> Any:
    return held(mi.Float, np.ascontiguousarray(values, dtype=np.float32))


def held(kind: Any, values: NDArray[Any]) -> Any:
    """A flat array in memory of Dr.Jit's own.

    As made from NumPy it lies in NumPy's memory, and what is compiled for a load of four numbers depends on where that begins: each process
    would have other kernels, and find none of them in the cache.
    """
    own = dr.empty(kind, values.size)
    dr.scatter(own, kind(values.ravel()), dr.arange(mi.UInt32, values.size))
    dr.eval(own)
    dr.sync_thread()
    return own
