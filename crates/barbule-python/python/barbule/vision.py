"""What birds see: quanta that cones catch, just noticeable differences, places in the tetrahedron.

Example:
    >>> import barbule
    >>> single, double = barbule.vision.catches([300, 700], [0.25, 0.25], "starling")
    >>> single.shape
    (4,)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import Axis, Quantity, axis_nm, floats, labelled, media_of, numbers, one_of, rows_of, text_of
from ._opening import Name
from ._optics import INSTANCES
from ._progress import ProgressLike, watched
from .errors import InputError, idle

if TYPE_CHECKING:
    import xarray

#: 300 to 700 nm in steps of 4: where birds see.
BIRDS_NM = tuple(float(nm) for nm in range(300, 701, 4))

_PLACES = {
    "x": ("from the short to the long cone's corner", ""),
    "y": ("towards the middle cone's corner", ""),
    "z": ("towards the ultraviolet cone's corner", ""),
    "theta": ("hue about the axis of the ultraviolet", "degree"),
    "phi": ("hue towards the ultraviolet", "degree"),
    "r": ("chroma: distance from the centre", ""),
    "r_achieved": ("chroma over the largest of its hue", ""),
}


def birds() -> list[str]:
    """The names of the birds whose eyes are built in.

    Example:
        >>> import barbule
        >>> "starling" in barbule.birds()
        True
    """
    return _native.eye_names()


def sensitivities(bird: Name) -> xarray.Dataset:
    """What a bird's cones answer to quanta, 1 at their peaks.

    Args:
        bird: A name as `birds` lists it, or a file of an eye (.toml, .csv).

    Returns:
        ``sensitivity`` and ``peak_nm``, ``abundance`` over ``[cone]``, the first over ``[cone, wavelength]`` too, from 300 to 830 nm; ``double``
        over ``[wavelength]`` where there are double cones. Attributes ``weber``, ``weber_double`` and ``source``.

    Raises:
        InputError: No such bird or file, or a key of it.

    Example:
        >>> import barbule
        >>> [float(nm) for nm in barbule.vision.sensitivities("starling")["peak_nm"]]
        [367.0, 456.0, 542.0, 606.0]
    """
    name, latin, cones, double, weber, sources = _native.eye(text_of("bird", bird))
    data = {
        "sensitivity": Quantity(np.stack([cone[4] for cone in cones]), ("cone", "wavelength"), "answer to a quantum"),
        "peak_nm": Quantity(np.array([cone[1] for cone in cones]), ("cone",), "wavelength of the largest answer", "nm"),
        "abundance": Quantity(np.array([cone[2] for cone in cones]), ("cone",), "how many cones there are"),
    }
    if double is not None:
        data["double"] = Quantity(double[4], ("wavelength",), "answer of double cones to a quantum")
    coords = {
        "cone": Axis(np.array([cone[0] for cone in cones]), "class of cones"),
        "wavelength": axis_nm(np.arange(300.0, 831.0)),
    }
    about = {"bird": name, "latin": latin, "weber": weber[0], "weber_double": weber[1], "source": "; ".join(sources)}
    return labelled(data, coords, **about)


def catches(
    wavelengths_nm: ArrayLike, reflectance: ArrayLike, bird: Name, illuminant: Name = "D65"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Quanta that cones catch of reflectances, each over those of white in the same light (von Kries).

    Args:
        wavelengths_nm: Vacuum wavelengths ``[W]``, rising; 98.5 % of what each cone catches of white must lie within.
        reflectance: ``[..., W]``.
        bird: A name as `birds` lists it, or a file of an eye.
        illuminant: ``D65``, ``forest``, ``sky``, ``ideal``, ``D50``, ``A``, ``E``, a file of power per nm, or ``quanta:FILE``.

    Returns:
        ``[..., cone]``, and of the double cones ``[...]`` (NaN without any).

    Raises:
        InputError: Too much of what a cone sees lies outside the wavelengths: nothing is invented there.

    Example:
        >>> import barbule
        >>> single, double = barbule.vision.catches([300, 700], [0.25, 0.25], "starling")
        >>> single.round(9).tolist()
        [0.25, 0.25, 0.25, 0.25]
    """
    nm = numbers(wavelengths_nm)
    values, rows = rows_of("reflectance", reflectance, nm.size, "wavelengths")
    single, double = _native.catches(nm, rows, text_of("bird", bird), text_of("illuminant", illuminant))
    return single.reshape(*values.shape[:-1], -1), double.reshape(values.shape[:-1])


def jnd(
    catches: ArrayLike,
    ratio: ArrayLike = (1, 2, 2, 4),
    weber: float = 0.1,
    reference: Literal["longest", "rarest"] = "longest",
) -> NDArray[np.float64]:
    """ΔS of each colour from each in just noticeable differences (Vorobyev & Osorio 1998), for any number of cones.

    Args:
        catches: ``[row, cone]``, cones from short to long wavelengths.
        ratio: How many cones of each class there are ``[cone]``.
        weber: The Weber fraction ω of the reference class; of the others it is ω √(n_ref / n).
        reference: The class with the longest wavelengths, or the one of which there are fewest.

    Returns:
        ``[row, row]``, NaN where a catch is not above 0.

    Example:
        >>> import barbule
        >>> round(float(barbule.vision.jnd([[0.1, 0.3, 0.5, 0.4], [0.1, 0.3, 0.5, 0.42]])[0, 1]), 5)
        0.36366
    """
    rows = np.ascontiguousarray(np.atleast_2d(floats(catches)))
    if rows.ndim != 2:
        raise InputError(f"'catches' has the shape {rows.shape}; give [row, cone]")
    one_of("reference", reference, ("longest", "rarest"))
    if not 0.0 < weber < np.inf:
        raise InputError(f"'weber' is {weber}; give a number over 0, as in 0.1")
    return _native.jnd(rows, numbers(ratio), weber, reference == "rarest")


def tetrahedral(catches: ArrayLike) -> xarray.Dataset:
    """Where colours of four cones lie in their tetrahedron (Stoddard & Prum 2008).

    Args:
        catches: ``[..., 4]``, from the ultraviolet to the long cone.

    Returns:
        ``x``, ``y``, ``z``, ``theta``, ``phi`` (degrees), ``r`` and ``r_achieved`` over ``[row]``, NaN where there is no place. One colour
        is one row too, and further axes are laid out as rows.

    Example:
        >>> import barbule
        >>> place = barbule.vision.tetrahedral([[1, 0, 0, 0], [1, 1, 1, 1]])
        >>> [round(float(r), 9) for r in place["r"]]
        [0.75, 0.0]
    """
    _, rows = rows_of("catches", catches, 4, "cones")
    found = _native.tetrahedral(rows)
    data = {name: Quantity(found[:, k], ("row",), *words) for k, (name, words) in enumerate(_PLACES.items())}
    return labelled(data, {"row": Axis(np.arange(len(rows)), "row of the catches")})


def see(
    things: Name | Sequence[Name],
    bird: Name,
    illuminant: Name = "D65",
    *,
    ratio: ArrayLike | None = None,
    weber: float | None = None,
    weber_double: float | None = None,
    samples: bool = False,
    wavelengths_nm: ArrayLike | None = None,
    angle_deg: float | None = None,
    instances: int | None = None,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """Whether a bird tells things apart.

    Args:
        things: Measured files or structures, or one of them.
        bird: A name as `birds` lists it, or a file of an eye.
        illuminant: As `catches`.
        ratio: How many cones of each class there are; the bird's without it.
        weber: Weber fraction of the reference class; the bird's without it.
        weber_double: Of the double cones; the bird's without it.
        samples: Every sample of a file by itself, not their mean.
        wavelengths_nm: Of structures, `BIRDS_NM` without.
        angle_deg: Angle of incidence of structures, across the barbule; 0 without.
        instances: Random individuals of structures, 50 without.
        seed: Their seed.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``catches`` over ``[item, cone]`` and ``double`` over ``[item]``, each over white; ``delta_s``, ``delta_s_rarest`` (just noticeable differences by
        the Weber fraction of the longest or rarest cones), ``delta_l`` (by the double cones) over ``[item, other]``; ``theta``, ``phi``, ``r``,
        ``r_achieved`` over ``[item]`` for birds with four cones. NaN where something is not defined.

    Raises:
        InputError: A reflectance does not reach where a cone sees; the message says which and what to do.

    Warns:
        DoubtWarning: An argument changes nothing, such as an angle where all things are measured.

    Example:
        >>> import barbule
        >>> stacks = ["air/keratin:320/melanin", "air/keratin:340/melanin"]
        >>> seen = barbule.see(stacks, "starling", instances=1, progress=False)
        >>> seen["delta_s"].shape
        (2, 2)
    """
    nm, angles = numbers(BIRDS_NM if wavelengths_nm is None else wavelengths_nm), numbers(0.0 if angle_deg is None else angle_deg)
    count = INSTANCES if instances is None else instances
    if angles.size != 1:
        raise InputError(f"'angle_deg' holds {angles.size} angles; give one")
    eye = sensitivities(bird)
    fraction, of_doubles = (
        _fraction(name, float(eye.attrs[name]) if given is None else given)
        for name, given in (("weber", weber), ("weber_double", weber_double))
    )
    names: list[str] = []
    measured: list[bool] = []
    rows: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    asked = [things] if isinstance(things, str) or not isinstance(things, Sequence) else list(things)
    with watched(progress) as watch:
        for thing in asked:
            found = _native.things(
                text_of("things", thing), samples, nm, angles, count, seed, media_of(media), threads, watch
            )
            names += [name for name, _, _, _ in found]
            rows += [(at, values) for _, at, values, _ in found]
            measured += [is_measured for _, _, _, is_measured in found]
    if not rows:
        raise InputError("'things' is empty; give at least one")
    differences = {"weber": weber, "weber_double": weber_double, "ratio": ratio}
    simulated = {"angle_deg": angle_deg, "instances": instances, "wavelengths_nm": wavelengths_nm}
    for is_idle, why, given in (
        (len(rows) == 1, "one thing has no differences", differences),
        (len(rows) > 1 and "double" not in eye, "this eye has no double cones", {"weber_double": weber_double}),
        (all(measured), "all that is seen is measured, and no structure simulated", simulated),
        (not any(measured), "nothing that is seen is measured", {"samples": samples or None}),
    ):
        for name in (name for name, value in given.items() if is_idle and value is not None):
            idle(name, why)
    seen = [catches(at, values, bird, illuminant) for at, values in rows]
    single, double = np.stack([cones for cones, _ in seen]), np.array([float(of) for _, of in seen])
    numbers_of_cones = np.asarray(eye["abundance"]) if ratio is None else numbers(ratio)
    pair = ("item", "other")
    with np.errstate(invalid="ignore", divide="ignore"):
        logarithm = np.log(double)
    delta_l = np.abs(logarithm[:, None] - logarithm[None, :]) / of_doubles
    data = {
        "catches": Quantity(single, ("item", "cone"), "quanta caught over those of white"),
        "double": Quantity(double, ("item",), "quanta caught by double cones over those of white"),
        "delta_s": Quantity(jnd(single, numbers_of_cones, fraction), pair, "chromatic difference, reference longest", "jnd"),
        "delta_s_rarest": Quantity(
            jnd(single, numbers_of_cones, fraction, "rarest"), pair, "chromatic difference, reference rarest", "jnd"
        ),
        "delta_l": Quantity(delta_l, pair, "achromatic difference", "jnd"),
    }
    if single.shape[1] == 4:
        places = _native.tetrahedral(np.ascontiguousarray(single))
        for k, (name, words) in enumerate(_PLACES.items()):
            data[name] = Quantity(places[:, k], ("item",), *words)
    coords = {
        "item": Axis(np.array(names), "thing that is seen"),
        "other": Axis(np.array(names), "thing that it is compared with"),
        "cone": Axis(np.asarray(eye["cone"]), "class of cones"),
    }
    return labelled(data, coords, bird=eye.attrs["bird"], illuminant=str(illuminant), weber=fraction, weber_double=of_doubles)


def _fraction(name: str, value: float) -> float:
    """A Weber fraction."""
    if not 0.0 < value <= 10.0:
        raise InputError(f"'{name}' is {value}; give a number over 0 and up to 10, as in 0.1")
    return value


__all__ = ["BIRDS_NM", "birds", "catches", "jnd", "see", "sensitivities", "tetrahedral"]
