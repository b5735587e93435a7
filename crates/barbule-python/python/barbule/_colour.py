"""Colours of spectra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._labels import Axis, Quantity, labelled, numbers, rows_of
from .errors import doubt

if TYPE_CHECKING:
    import xarray


def colours(wavelengths_nm: ArrayLike, reflectance: ArrayLike, illuminant: str = "D65") -> xarray.Dataset:
    """What the standard observer (CIE 1931, 2°) sees of reflectances.

    Args:
        wavelengths_nm: Vacuum wavelengths ``[W]``, rising; 90 % of what the eye sees of white must lie within.
        reflectance: ``[..., W]``.
        illuminant: ``D65``, ``D50``, ``A`` or ``E``.

    Returns:
        ``xyz`` (Y = 1 of a perfect white), ``linear_srgb`` (may leave 0 to 1) and ``srgb`` (the bytes that a screen shows), each
        ``[row, 3]`` with the leading axes of `reflectance` as rows.

    Raises:
        InputError: The wavelengths are too little of what the eye sees, or there is no such illuminant.

    Warns:
        DoubtWarning: The end values are held where more than 1 % of what the eye sees of white lies.

    Example:
        >>> import barbule
        >>> barbule.colours([400, 500, 600, 700], [1, 1, 1, 1])["xyz"].shape
        (1, 3)
    """
    nm = numbers(wavelengths_nm)
    values, rows = rows_of("reflectance", reflectance, nm.size, "wavelengths")
    said = _native.colour_doubt(nm)
    if said is not None:
        doubt(said)
    xyz, linear, shown = _native.xyz_of(nm, rows, illuminant)
    data = {
        "xyz": Quantity(xyz, ("row", "channel"), "CIE 1931 tristimulus values"),
        "linear_srgb": Quantity(linear, ("row", "channel"), "linear sRGB"),
        "srgb": Quantity(shown, ("row", "channel"), "sRGB bytes"),
    }
    return labelled(data, {"row": Axis(np.arange(len(xyz)), "row of the reflectances")}, illuminant=illuminant)


def delta_e_2000(one: ArrayLike, other: ArrayLike) -> float:
    """CIEDE2000 of two colours X, Y, Z under the white of D65.

    Example:
        >>> import barbule
        >>> barbule.delta_e_2000([0.2, 0.2, 0.2], [0.2, 0.2, 0.2])
        0.0
    """
    first, second = ([float(part) for part in np.asarray(given, float)] for given in (one, other))
    return _native.delta_e_2000(first, second)
