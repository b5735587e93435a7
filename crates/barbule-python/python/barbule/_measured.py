"""What was measured beside what is simulated, and how sure simulated numbers are."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import media_of, numbers, one_of, text_of
from ._opening import Name
from ._optics import VISIBLE_NM
from ._progress import ProgressLike, watched
from .errors import InputError

if TYPE_CHECKING:
    import xarray

_Places = Union[str, "PathLike[str]", Sequence[Union[str, "PathLike[str]"]]]

#: Angles that differ by less, degrees, are one, as of files.
_SAME_DEG = 0.05


@dataclass(frozen=True)
class Measured:
    """What was measured at one angle: samples at common wavelengths.

    Example:
        >>> import barbule, numpy as np
        >>> nm, birds = np.array([400.0, 500.0]), np.array([[0.05, 0.07], [0.07, 0.09]])
        >>> one = barbule.Measured(0.0, ["first", "second"], nm, birds, birds.mean(axis=0), "made here")
        >>> one.mean.round(3).tolist()
        [0.06, 0.08]
    """

    #: Degrees; None where nothing says any.
    angle_deg: float | None
    #: What the samples are called.
    names: list[str]
    wavelength_nm: NDArray[np.float64]
    #: Reflectance as a part of 1, ``[sample, wavelength]``.
    samples: NDArray[np.float64] = field(repr=False)
    #: Their mean, ``[wavelength]``.
    mean: NDArray[np.float64] = field(repr=False)
    #: How the files were read, in sentences.
    reading: str = field(repr=False)


def measured(places: _Places, *, column: str | int | None = None, percent: bool | None = None) -> list[Measured]:
    """Reads measured spectra: files, files with an angle behind ``@`` or a folder, as ``barbule spectrum --measured`` does.

    Args:
        places: One or several of them.
        column: The column or sample to use, by name or by number from 1; all and their mean without.
        percent: Whether values are percent; guessed without, and said in ``reading``.

    Returns:
        One `Measured` for each angle, in the order of the angles.

    Raises:
        InputError: A file cannot be read, or in two ways.

    Example:
        >>> import barbule, pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "back.csv")
        ...     _ = file.write_text("wl;back_1;back_2\\n400;5,1;5,3\\n450;5,6;5,8\\n500;6,4;6,6\\n550;6,8;6,9\\n600;6,1;6,3\\n700;4,6;4,8\\n")
        ...     read = barbule.measured(file)[0]
        >>> read.names, read.mean.round(3).tolist()[0]
        (['back_1', 'back_2'], 0.052)
    """
    given = [places] if isinstance(places, (str, PathLike)) else list(places)
    texts = [text_of("places", place) for place in given]
    found = _native.measured(texts, None if column is None else str(column), percent)
    return [Measured(angle, names, nm, samples, mean, reading) for angle, names, nm, samples, mean, reading in found]


def compare(
    simulated: xarray.Dataset,
    against: _Places | Measured | Sequence[Measured],
    *,
    peak_range_nm: tuple[float, float] | None = None,
) -> list[dict[str, Any] | None]:
    """Holds simulated spectra against measured ones, angle by angle.

    Args:
        simulated: What `spectrum` gives.
        against: What `measured` gives or takes. Of several at one angle all samples are individuals; what has no angle is held against those
            angles at which nothing else was measured.
        peak_range_nm: Where the peak is looked for.

    Returns:
        For each simulated angle the numbers that ``barbule spectrum --measured --json`` has under ``comparison``: peaks, half widths, levels and how
        they differ between individuals, RMSE, ΔE, and what the difference looks like; None where nothing was measured at that angle.

    Raises:
        InputError: Nothing is measured, or several at one angle at different wavelengths.
        TypeError: `Measured` and files are mixed.

    Example:
        >>> import barbule, pathlib, tempfile
        >>> found = barbule.spectrum("starling", range(400, 701, 10), instances=5)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     file = pathlib.Path(folder, "back.csv")
        ...     _ = file.write_text("wl;back_1;back_2\\n400;5,1;5,3\\n450;5,6;5,8\\n500;6,4;6,6\\n550;6,8;6,9\\n600;6,1;6,3\\n700;4,6;4,8\\n")
        ...     differs = barbule.compare(found, file)[0]
        >>> differs["delta_e_2000"] < 10
        True
    """
    known = _known(against)
    if not known:
        raise InputError("'against' holds no measurement; give at least one")
    if peak_range_nm is not None and not peak_range_nm[0] < peak_range_nm[1]:
        raise InputError(f"'peak_range_nm' is {peak_range_nm}; give two rising wavelengths")
    nm = numbers(simulated["wavelength"])
    found: list[dict[str, Any] | None] = []
    for index, angle in enumerate(numbers(simulated["angle"])):
        # What says no angle is for all of them, but no better than what was measured at this one.
        exact = [m for m in known if m.angle_deg is not None and abs(m.angle_deg - angle) < _SAME_DEG]
        meant = exact or [m for m in known if m.angle_deg is None]
        if not meant:
            found.append(None)
            continue
        at, samples = _pooled(meant)
        mean = np.asarray(simulated["reflectance"], float)[index]
        each = np.asarray(simulated["individuals"], float)[:, index] if "individuals" in simulated else mean[np.newaxis]
        text = _native.compare(nm, mean, each, at, samples, peak_range_nm)
        found.append(json.loads(text))
    return found


def _known(against: _Places | Measured | Sequence[Measured]) -> list[Measured]:
    """Measurements, read where they are files.

    Raises:
        TypeError: Some are, and some are not.
    """
    if isinstance(against, (str, PathLike)):
        return measured(against)
    given = [against] if isinstance(against, Measured) else list(against)
    read = [one for one in given if isinstance(one, Measured)]
    if len(read) == len(given):
        return read
    places = [one for one in given if not isinstance(one, Measured)]
    if read:
        raise TypeError(
            f"'against' holds a Measured and {places[0]!r} in one list; read files first: barbule.measured({places[0]!r}) gives a list to add"
        )
    return measured(places)


def _pooled(several: Sequence[Measured]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Wavelengths and all samples of measurements at one angle.

    Raises:
        InputError: They have different wavelengths.
    """
    first = several[0]
    for other in several[1:]:
        if not np.array_equal(first.wavelength_nm, other.wavelength_nm):
            angle = "at no angle" if first.angle_deg is None else f"at {first.angle_deg:g}°"
            raise InputError(
                f"'against' holds two measurements {angle} with different wavelengths, {_named(first)} and {_named(other)}; "
                "give one file with both as columns, or both files to barbule.measured at once"
            )
    return first.wavelength_nm, np.concatenate([one.samples for one in several])


def _named(one: Measured) -> str:
    return f"'{one.names[0]}'" if len(one.names) == 1 else f"'{one.names[0]}' to '{one.names[-1]}'"


def intervals(
    structure: Name,
    wavelengths_nm: ArrayLike = VISIBLE_NM,
    angles_deg: ArrayLike = 0.0,
    *,
    uncertain: Mapping[str, float | str] | None = None,
    plane: Literal["across", "along"] = "across",
    instances: int = 50,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> list[dict[str, Any]]:
    """How sure the numbers of a colour are: 95 % intervals over individuals, and over sizes and indices that are not known exactly.

    Args:
        structure: Whatever `barbule.open` opens, but as its text.
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: Angles of incidence.
        uncertain: Standard deviations by name: of media their index (``{"keratin": 0.005}``), of species keys (``{"cortex_um": "2%"}``), of stacks
            ``layer1`` and so on, nm.
        plane: Whether the light turns across the barbule or along it.
        instances: Number of random individuals.
        seed: Their seed, and that of the resampling.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        For each angle ``individuals`` and ``numbers``: of ``peak_nm``, ``half_width_nm``, ``peak_reflectance``, ``mean_reflectance``, ``luminous_reflectance``,
        ``x``, ``y`` and ``delta_e_2000`` (how far the colour may be from the mean's) each ``value``, ``low``, ``high``, ``std_of_individuals``,
        ``std_of_uncertain``, ``enough`` and ``individuals_enough``.

    Example:
        >>> import barbule
        >>> found = barbule.intervals("air/keratin:260/air", range(400, 701, 5), uncertain={"layer1": "2%", "keratin": 0.005}, progress=False)
        >>> peak = found[0]["numbers"]["peak_nm"]
        >>> peak["low"] < peak["value"] < peak["high"]
        True
    """
    nm, angles, opened = numbers(wavelengths_nm), numbers(angles_deg), text_of("structure", structure)
    one_of("plane", plane, ("across", "along"))
    nothing = np.zeros_like(angles)
    theta, phi = (nothing, angles) if plane == "across" else (angles, nothing)
    texts = [f"{name}={amount}" for name, amount in (uncertain or {}).items()]
    with watched(progress) as watch:
        text = _native.intervals(opened, nm, theta, phi, instances, seed, texts, media_of(media), threads, watch)
    found: list[dict[str, Any]] = json.loads(text)
    return found
