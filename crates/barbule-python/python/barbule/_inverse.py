"""From measured spectra to the sizes of what reflected them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import floats, media_of, numbers, one_of, text_of
from ._measured import Measured
from ._opening import Name
from ._progress import ProgressLike, watched
from .errors import InputError, idle

_Files = Union[str, "PathLike[str]", Sequence[Union[str, "PathLike[str]"]]]

#: Random individuals of a species unless told otherwise: each table has dozens of spectra.
INSTANCES = 8

#: Models of flat layers.
_FLAT = ("film", "multilayer")


@dataclass(frozen=True)
class Size:
    """A size with its 95 % interval.

    Example:
        >>> import barbule
        >>> cortex = barbule.Size(595.0, 588.0, 602.0, "nm", (False, False), None)
        >>> f"{cortex.value:g} {cortex.unit} ({cortex.low:g} to {cortex.high:g})"
        '595 nm (588 to 602)'
    """

    #: The best value.
    value: float
    #: The ends of the interval.
    low: float
    high: float
    #: nm, µm, or nothing.
    unit: str
    #: Whether the lower and the upper end are those of the range that was searched.
    open: tuple[bool, bool]
    #: Standard deviation between samples (individuals); None of fewer than three.
    between_samples_std: float | None


@dataclass(frozen=True)
class Solution:
    """Sizes that fit, as `fit_structure` gives them.

    Example:
        >>> import barbule, numpy as np
        >>> nm = np.arange(400.0, 701.0, 5.0)
        >>> film = barbule.film("air/keratin:595/air", nm, progress=False)
        >>> measured = 0.5 * (film["R_s"][0] + film["R_p"][0])
        >>> found = barbule.fit_structure((nm, measured), "film", progress=False).solutions
        >>> all(isinstance(one, barbule.Solution) for one in found), bool(found[0].as_good)
        (True, True)
    """

    #: Each size by its name.
    parameters: dict[str, Size]
    #: Root mean square of measured − fitted.
    rmse: float
    #: The part of the measurement's variance that is fitted.
    explained: float
    #: How much worse than the best it fits, Δχ².
    worse_by: float
    #: Whether the measurement does not decide, at 95 %, between this and the best.
    as_good: bool
    #: What the model is multiplied by for each reading, and what is added.
    level: NDArray[np.float64]
    offset: NDArray[np.float64]
    #: Covariance of the sizes, ``[size, size]``; not a number where nothing depends on them.
    covariance: NDArray[np.float64]
    #: The fitted curve of each reading, at its wavelengths.
    fitted: list[NDArray[np.float64]]


@dataclass(frozen=True)
class Fitted:
    """What `fit_structure` found.

    Example:
        >>> import barbule, numpy as np
        >>> nm = np.arange(400.0, 701.0, 5.0)
        >>> film = barbule.film("air/keratin:595/air", nm, progress=False)
        >>> measured = 0.5 * (film["R_s"][0] + film["R_p"][0])
        >>> found = barbule.fit_structure((nm, measured), "film", progress=False)
        >>> isinstance(found, barbule.Fitted), "keratin:595" in found.toml
        (True, True)
    """

    #: The solutions, the best first.
    solutions: list[Solution]
    #: The text of a file of the best one, which `barbule.open` opens once it is saved.
    toml: str
    #: What is doubtful, a sentence each.
    doubts: list[str]
    #: The readings: name, wavelength_nm, measured, samples, noise.
    readings: list[dict[str, Any]] = field(repr=False)

    @property
    def best(self) -> Solution:
        """The first solution."""
        return self.solutions[0]

    def save(self, path: Union[str, "PathLike[str]"]) -> None:
        """Writes the best solution as a stack, species or lattice file (.toml)."""
        Path(path).write_text(self.toml, encoding="utf-8")


def fit_structure(
    measured: _Files | tuple[ArrayLike, ArrayLike],
    model: str = "film",
    *,
    angles_deg: ArrayLike | None = None,
    stack: str | None = None,
    free: str | Sequence[str] = (),
    instrument: str | None = None,
    plane: Literal["across", "along"] | None = None,
    range_nm: tuple[float, float] | None = None,
    column: str | int | None = None,
    level: Literal["free", "fixed"] = "free",
    offset: bool = False,
    solutions: int = 3,
    instances: int | None = None,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Fitted:
    """Finds the sizes with which a model reflects what was measured.

    Args:
        measured: Files as on the command line (``FILE``, ``FILE@ANGLE`` or a folder; several in a list), or a pair of arrays: wavelengths
            in nm and reflectances ``[wavelength]``, ``[angle, wavelength]`` or ``[angle, sample, wavelength]``.
        model: ``film``, ``multilayer``, ``lattice``, a species with or without a variant, or the .toml file of a species or lattice.
        angles_deg: The angles of arrays, 0 without; files say theirs.
        stack: The stack of a film or multilayer, with ``?`` or ``LOW..HIGH`` for what is to be found.
        free: Sizes of a species or lattice to be found, ``KEY`` or ``KEY=LOW..HIGH``, one or several; those that set the colour most without.
        instrument: What it was measured with, of flat layers: ``probe:CONE``, ``arms:IN,OUT,CONE``, ``sphere``, ``microscope:NA``.
        plane: Whether angles lie ``across`` the barbule or ``along`` it; across without.
        range_nm: The wavelengths that are fitted; without all that are measured from 300 to 830 nm.
        column: Of files the one column or sample to use, by name or by number from 1.
        level: Whether each reading has a factor of its own, or reflectances are absolute.
        offset: Whether each reading has a constant of its own too.
        solutions: How many solutions are given at least; those that fit as well as the best always are.
        instances: Random individuals of a species in each simulated spectrum, 8 without.
        seed: Their seed.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        The solutions, the best first, each size with its 95 % interval.

    Raises:
        InputError: Files, a model or a stack that cannot be read; too few samples for so many sizes.

    Warns:
        DoubtWarning: `plane` or `instances` of flat layers, which have neither.

    Example:
        >>> import barbule, numpy as np
        >>> nm = np.arange(400.0, 701.0, 5.0)
        >>> film = barbule.film("air/keratin:595/air", nm, progress=False)
        >>> reflectance = 0.5 * (film["R_s"][0] + film["R_p"][0])
        >>> found = barbule.fit_structure((nm, reflectance), "film", progress=False)
        >>> round(found.best.parameters["thickness_nm"].value, 2)
        595.0
    """
    files: list[str] = []
    nm = values = np.zeros(0)
    angles = numbers(0.0 if angles_deg is None else angles_deg)
    one_of("plane", "across" if plane is None else plane, ("across", "along"))
    one_of("level", level, ("free", "fixed"))
    if isinstance(measured, tuple) and len(measured) == 2 and not isinstance(measured[0], (str, PathLike, Measured)):
        nm, values = numbers(measured[0]), floats(measured[1])
        _check_shape(values.shape, len(nm), len(angles))
        if column is not None:
            raise InputError("'column' is of files; leave it out beside arrays")
    else:
        several = measured if isinstance(measured, Iterable) and not isinstance(measured, (str, PathLike)) else [measured]
        files = [text_of("measured", file) for file in several]
        if angles_deg is not None:
            raise InputError("'angles_deg' is of arrays; files say theirs, as in 'back.csv@40'")
    if model in _FLAT:
        for name, value, why in (
            ("instances", instances, "flat layers have no random individuals"),
            ("plane", plane, "flat layers reflect the same in every plane"),
        ):
            if value is not None:
                idle(name, why)
    with watched(progress) as watch:
        text, toml = _native.fit_structure(
            files,
            nm,
            values,
            angles,
            model,
            stack,
            [free] if isinstance(free, str) else list(free),
            instrument,
            plane == "along",
            None if range_nm is None else list(range_nm),
            None if column is None else str(column),
            level == "fixed",
            offset,
            solutions,
            INSTANCES if instances is None else instances,
            seed,
            media_of(media),
            threads,
            watch,
        )
    document = json.loads(text)
    return Fitted([_solution(one) for one in document["solutions"]], toml, document["doubts"], document["readings"])


def _check_shape(shape: tuple[int, ...], wavelengths: int, angles: int) -> None:
    """Refuses reflectances whose axes are others than those of wavelengths and angles."""
    is_of_one = len(shape) == 1 and angles == 1
    if shape and shape[-1] == wavelengths and (is_of_one or (len(shape) in (2, 3) and shape[0] == angles)):
        return
    raise InputError(
        f"'measured' holds reflectances of the shape {shape}; give [angle, wavelength] or [angle, sample, wavelength] "
        f"of {angles} by {wavelengths}"
    )


def _solution(given: dict[str, Any]) -> Solution:
    def size(one: dict[str, Any]) -> Size:
        lower, upper = one["open"]
        return Size(one["value"], one["low"], one["high"], one["unit"], (lower, upper), one["between_samples_std"])

    arrays = {key: np.asarray(given[key], dtype=float) for key in ("level", "offset", "covariance")}
    return Solution(
        parameters={name: size(one) for name, one in given["parameters"].items()},
        rmse=given["rmse"],
        explained=given["explained"],
        worse_by=given["worse_by"],
        as_good=given["as_good"],
        fitted=[np.asarray(curve, dtype=float) for curve in given["fitted"]],
        **arrays,
    )
