"""From micrographs to structures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import media_of, one_of
from ._opening import Name
from .errors import InputError


class Traced:
    """What a micrograph shows, traced by `trace`.

    Example:
        >>> import barbule, numpy as np
        >>> y, x = np.mgrid[0:240, 0:320]
        >>> found = barbule.trace(np.where(y < 60, 0.9, np.where(y < 150, 0.5, 0.1)), nm_per_px=2.0)
        >>> isinstance(found, barbule.Traced), found.measures["kind"]
        (True, 'layers')
    """

    def __init__(self, native: _native.Traced) -> None:
        self._native = native
        self._measures: dict[str, Any] = json.loads(native.json())

    @property
    def measures(self) -> dict[str, Any]:
        """What was measured: `kind`; `layers` (each `medium`, `thickness_nm`) or `lattice` (`period_nm`, `row_pitch_nm`, `row_shift`,
        `diameter_nm`, `hollow_nm`, `rows`), each measure with `mean` and `std`; `thresholds`, `blur_px`, `notes`."""
        return self._measures

    @property
    def flat(self) -> NDArray[np.float32]:
        """The picture with even light, smoothed, in grey levels 0 to 255, `[row, column]`."""
        return self._native.flat

    @property
    def rods_px(self) -> NDArray[np.float64]:
        """Rods that lie wholly in the picture, `[rod, (x, y, diameter, hollow)]`, px."""
        return self._native.rods_px

    def text(self, format: str = "toml") -> str:
        """The text of a file that simulates: `toml` of a lattice, or of layers as a species; `json` of a lattice or a section."""
        one_of("format", format, ("toml", "json"))
        return self._native.text(format == "json")

    def save(self, path: Union[str, "PathLike[str]"]) -> None:
        """Writes a file that `barbule.open` opens, ``.toml`` or ``.json`` as for `text`."""
        ending = Path(path).suffix.lower()
        if ending not in (".toml", ".json"):
            raise InputError(f"'path' is {str(path)!r}; end its name with .toml or .json")
        self._native.save(Path(path), ending == ".json")

    def figure(self, format: str = "svg") -> bytes:
        """Outlines, thresholds and measures over the picture, as ``svg``, ``pdf`` or ``png``."""
        return self._native.figure(format)

    def _repr_svg_(self) -> str:
        return self.figure("svg").decode()

    def __repr__(self) -> str:
        return f"<barbule.Traced {self.measures['kind']}, {self.measures['nm_per_px']:.4g} nm per px>"


def trace(
    image: Union[str, "PathLike[str]", ArrayLike],
    *,
    nm_per_px: float,
    thresholds: Sequence[float] | None = None,
    classes: Sequence[str] | None = None,
    kind: str | None = None,
    cortex_nm: float | None = None,
    crop: tuple[int, int, int, int] | None = None,
    media: Mapping[str, Name] | None = None,
) -> Traced:
    """Traces a micrograph of a section: even light, classes of grey, outlines between pixels, a lattice of rods or layers.

    Args:
        image: A file (PNG, TIFF, JPEG), or an array ``[row, column]`` of greys: whole numbers over their type's range, floats from 0
            black to 1 white.
        nm_per_px: How long a pixel is.
        thresholds: One or two grey levels, 0 to 255 of the flattened picture, between the classes, the brighter first; found without.
        classes: Media of the classes of grey from the brightest; air, keratin and melanin, or the last two, without.
        kind: ``lattice``, ``layers`` or ``section``; what it looks like without.
        cortex_nm: Keratin above the first row of a lattice, where the picture does not show it.
        crop: The part to trace: left, top, width and height in pixels.
        media: Media of your own by name, each a file of n and k.

    Raises:
        InputError: No picture, no two classes of grey, nothing of the kind that is asked for.

    Example:
        >>> import barbule
        >>> import numpy as np
        >>> y, x = np.mgrid[0:240, 0:320]
        >>> stripes = np.where(y < 60, 0.9, np.where(y < 150, 0.5, 0.1))
        >>> found = barbule.trace(stripes, nm_per_px=2.0)
        >>> round(found.measures["layers"][0]["thickness_nm"]["mean"])
        180
    """
    if isinstance(image, (str, PathLike)):
        given: NDArray[np.float32] | Path = Path(image)
    else:
        array = np.asarray(image)
        given = np.ascontiguousarray(_grey(array), dtype=np.float32)
        if given.ndim != 2:
            raise InputError(f"'image' has {given.ndim} axes; give greys [row, column], of colours one channel or their mean")
    return Traced(
        _native.trace(
            given,
            float(nm_per_px),
            None if thresholds is None else [float(level) for level in thresholds],
            None if classes is None else list(classes),
            kind,
            cortex_nm,
            crop,
            media_of(media),
        )
    )



def _grey(image: NDArray[Any]) -> NDArray[Any]:
    """Greys from 0 to 1.

    Raises:
        InputError: Whole numbers of which nobody knows what is white, or greys that are none.
    """
    if image.dtype.kind == "b":
        return image
    if image.dtype.kind == "u" and image.dtype.itemsize <= 2:
        return image / np.iinfo(image.dtype).max
    if image.dtype.kind != "f":
        raise InputError(f"'image' holds {image.dtype}; give uint8, uint16, or numbers from 0 to 1")
    if image.size and not (np.min(image) >= 0.0 and np.max(image) <= 1.0):
        raise InputError(f"'image' holds {np.min(image):g} to {np.max(image):g}; give numbers from 0 to 1, or uint8 or uint16")
    return image
