"""Films, spectra, far fields, crystals and gratings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import Axis, Quantity, axis_nm, labelled, media_of, numbers, one_of, text_of
from ._material import Material
from ._native import Section, Structure
from ._opening import Name, structure_of
from ._progress import ProgressLike, watched
from .errors import InputError, doubt, idle

if TYPE_CHECKING:
    import xarray

#: 400 to 694 nm in steps of 6: what commands take, too, unless they are told otherwise.
VISIBLE_NM = tuple(float(nm) for nm in range(400, 695, 6))

#: Random individuals unless told otherwise.
INSTANCES = 50

_FILM: dict[str, tuple[str, tuple[str, ...]]] = {
    f"{letter}_{polarization}": (f"{what}, {polarization}-polarized", dims)
    for polarization in ("s", "p")
    for letter, what, dims in (
        ("r", "reflected over incident amplitude", ("angle", "wavelength")),
        ("t", "transmitted over incident amplitude", ("angle", "wavelength")),
        ("R", "reflectance", ("angle", "wavelength")),
        ("T", "transmittance", ("angle", "wavelength")),
        ("A", "absorptance", ("angle", "wavelength")),
        ("A_layer", "absorptance of each layer", ("layer", "angle", "wavelength")),
    )
}


def film(
    stack: Name,
    wavelengths_nm: ArrayLike = VISIBLE_NM,
    angles_deg: ArrayLike = 0.0,
    *,
    gradients: bool = False,
    instances: int | None = None,
    seed: int = 1,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """Exact reflection and transmission of a stack of flat layers.

    Args:
        stack: As in ``air/6*(melanin:99/keratin:100)/air``: media with thicknesses in nm, which may spread as in
            ``air/keratin:595±40/air``; or a stack file (.toml).
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: Angles in the first medium, from the normal.
        gradients: Whether derivatives of the reflected amplitudes and reflectances are wanted too, of a stack without spreads.
        instances: Number of random individuals of a stack whose thicknesses spread, 50 without.
        seed: Their seed.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        Complex amplitudes ``r_s, r_p, t_s, t_p`` and powers ``R_s, R_p, T_s, T_p, A_s, A_p`` over ``[angle, wavelength]``, and
        ``A_layer_s, A_layer_p`` over ``[layer, angle, wavelength]``. Amplitudes of s belong to E, those of p to H, so at normal incidence
        r_p = −r_s. Of a stack whose thicknesses spread these are means over individuals, and ``std`` is the standard deviation of the
        unpolarized reflectance. With gradients: ``dr_dd_s`` (1/nm, ``[angle, wavelength, layer]``), ``dr_dn_s`` (by n + jk, ``[…, medium]`` of layers
        and exit), ``dR_dd_s``, ``dR_dn_s``, ``dR_dk_s``, and the same for p.

    Raises:
        InputError: Not the stack language, an unknown medium, an angle at or past grazing, gradients of a stack whose thicknesses spread.

    Warns:
        DoubtWarning: A layer is thinner than 1 nm, as if micrometres were meant; wavelengths are further apart than fringes.

    Example:
        >>> import barbule
        >>> film = barbule.film("air/keratin:595/air", [450, 550, 650], [0, 45])
        >>> film["r_s"].shape
        (2, 3)
    """
    nm, angles, own, text = numbers(wavelengths_nm), numbers(angles_deg), media_of(media), text_of("stack", stack)
    # Refused before there is any work.
    values = _native.film_gradients(text, nm, angles, own, threads) if gradients else []
    with watched(progress) as watch:
        count = INSTANCES if instances is None else instances
        found = _native.film(text, nm, angles, count, seed, own, threads, watch)
    data = {name: Quantity(found[name], dims, words) for name, (words, dims) in _FILM.items()}
    drawn = {"seed": seed, "instances": count} if "std" in found else {}
    if instances is not None and not drawn:
        idle("instances", "no thickness of this stack spreads, as keratin:200±5% does")
    if drawn:
        data["std"] = Quantity(found["std"], ("angle", "wavelength"), "standard deviation of individuals, unpolarized reflectance")
    coords = {"angle": Axis(angles, "angle of incidence", "degree"), "wavelength": axis_nm(nm)}
    if gradients:
        for polarization, by_d, by_n in (("s", values[0], values[1]), ("p", values[2], values[3])):
            r = found[f"r_{polarization}"][..., None].conj()
            layers, media_ = ("angle", "wavelength", "layer"), ("angle", "wavelength", "medium")
            words = f"{polarization}-polarized"
            data |= {
                f"dr_dd_{polarization}": Quantity(by_d, layers, f"d(amplitude)/d(thickness), {words}", "1/nm"),
                f"dr_dn_{polarization}": Quantity(by_n, media_, f"d(amplitude)/d(n + jk), {words}"),
                f"dR_dd_{polarization}": Quantity(2 * (r * by_d).real, layers, f"d(reflectance)/d(thickness), {words}", "1/nm"),
                f"dR_dn_{polarization}": Quantity(2 * (r * by_n).real, media_, f"d(reflectance)/dn, {words}"),
                f"dR_dk_{polarization}": Quantity(-2 * (r * by_n).imag, media_, f"d(reflectance)/dk, {words}"),
            }
    return labelled(data, coords, stack=text, **drawn)


def spectrum(
    structure: Structure | Material | Name,
    wavelengths_nm: ArrayLike = VISIBLE_NM,
    angles_deg: ArrayLike = 0.0,
    *,
    plane: Literal["across", "along"] = "across",
    instances: int | None = None,
    seed: int = 1,
    cone_deg: float | None = None,
    instrument: str | None = None,
    turn_deg: float = 0.0,
    tilt_deg: ArrayLike = 0.0,
    polarization: Literal[1, 2] | None = None,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """What barbules reflect over the wavelength: mean, spread and every individual.

    Args:
        structure: A structure, or whatever `barbule.open` opens; with an instrument also a `Material`, whose smooth mean is read.
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: Angles of the light from the normal; of an instrument how far the feather is turned away from its axis.
        plane: Whether the light turns across the barbule or along it.
        instances: Number of random individuals, 50 without.
        seed: Their seed.
        cone_deg: Only what falls within this angle of the mirror direction; all of it without.
        instrument: Reading of ``probe:CONE``, ``arms:IN,OUT,CONE``, ``sphere`` or ``microscope:NA`` (degrees, CONE the half angle) beside
            a perfect white standard, which mirrors may exceed; all that is reflected without.
        turn_deg: Under an instrument, how far the feather is turned about its own normal.
        tilt_deg: Under an instrument, standard deviation of barbules' slopes out of the vane and of their turns about their axes: one number for both,
            or two.
        polarization: Incident polarization 1 or 2; unpolarized light without.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``reflectance`` and ``std`` over ``[angle, wavelength]``, ``individuals`` over ``[instance, angle, wavelength]``, and ``flagged``: where
        light grazes so that the simulation is off. Of a `Material` only ``reflectance``.

    Example:
        >>> import barbule
        >>> found = barbule.spectrum("starling", [450, 550, 650], [0, 30], instances=4)
        >>> found["individuals"].shape
        (4, 2, 3)
        >>> barbule.spectrum("air/keratin:200/air", [500], instrument="probe:10")["reflectance"].shape
        (1, 1)
    """
    nm, angles = numbers(wavelengths_nm), numbers(angles_deg)
    one_of("plane", plane, ("across", "along"))
    one_of("polarization", polarization, (None, 1, 2))
    if isinstance(structure, Material):
        if instrument is None or polarization is not None or cone_deg is not None:
            raise InputError("a Material is read by an instrument in unpolarized light: give instrument='probe:10' or another alone")
        for name, given in (("instances", instances), ("media", media)):
            if given is not None:
                idle(name, "a Material is made already, and its smooth mean is read")
        with watched(progress) as watch:
            found = _native.material_readings(
                structure._native, nm, angles, instrument, plane == "along", turn_deg, _both(tilt_deg), threads, watch
            )
        return labelled(
            {"reflectance": Quantity(found, ("angle", "wavelength"), "reading beside white")},
            {"angle": Axis(angles, "turn away from the instrument's axis", "degree"), "wavelength": axis_nm(nm)},
            instrument=instrument,
            reference="white",
        )
    if instrument is None and (turn_deg != 0.0 or _both(tilt_deg) != (0.0, 0.0)):
        raise InputError("'turn_deg' and 'tilt_deg' belong to an instrument; give one, as in instrument='probe:10'")
    if instrument is not None and cone_deg is not None:
        raise InputError("'cone_deg' and 'instrument' both say what is collected; give one of them")
    opened = structure_of(structure, media)
    nothing = np.zeros_like(angles)
    theta, phi = (nothing, angles) if plane == "across" else (angles, nothing)
    count = INSTANCES if instances is None else instances
    given = opened.count
    if instances is not None and given is not None and instances > given:
        there_are = "is 1 section: it is" if given == 1 else f"are {given} sections: all are"
        doubt(f"'instances' is {instances}, but there {there_are} simulated")
    weights = {None: [0.5, 0.5], 1: [1.0, 0.0], 2: [0.0, 1.0]}[polarization]
    with watched(progress) as watch:
        if instrument is None:
            mean, std, individuals, flagged = _native.spectra(
                opened, nm, theta, phi, count, seed, cone_deg, weights, threads, watch
            )
        else:
            mean, std, individuals, flagged = _native.readings(
                opened, nm, angles, instrument, plane == "along", turn_deg, _both(tilt_deg), count, seed, weights, threads, watch
            )
    over = ("angle", "wavelength")
    what = "reflected fraction" if instrument is None else "reading beside white"
    data = {
        "reflectance": Quantity(mean, over, f"{what}, mean over individuals"),
        "std": Quantity(std, over, "standard deviation of individuals"),
        "individuals": Quantity(individuals, ("instance", *over), f"{what} of each individual"),
        "flagged": Quantity(flagged, over, "whether the simulation is off there"),
    }
    coords = {
        "angle": Axis(angles, f"angle of incidence, {plane} the barbule", "degree"),
        "wavelength": axis_nm(nm),
        "instance": Axis(np.arange(individuals.shape[0]), "number of the individual"),
    }
    how: dict[str, Any] = {"structure": opened.name, "seed": seed, "instances": individuals.shape[0], "plane": plane}
    how |= {} if instrument is None else {"instrument": instrument, "reference": "white"}
    how |= {} if cone_deg is None else {"cone_deg": cone_deg}
    how |= {} if polarization is None else {"polarization": polarization}
    return labelled(data, coords, **how)


def _both(tilt_deg: ArrayLike) -> tuple[float, float]:
    """The tilts of slopes and of turns."""
    tilts = numbers(tilt_deg)
    if tilts.size not in (1, 2):
        raise InputError(f"'tilt_deg' holds {tilts.size} numbers; give one for slopes and turns, or one for each")
    return float(tilts[0]), float(tilts[-1])


@dataclass(frozen=True)
class Interval:
    """A value and its 95 % confidence interval; `high` is None where it has no bound.

    Example:
        >>> import barbule
        >>> index = barbule.angle_law([0, 20, 40, 60], [640.0, 624.3, 580.2, 525.0]).index
        >>> isinstance(index, barbule.Interval), index.low < index.value < index.high
        (True, True)
    """

    value: float
    low: float
    high: float | None


@dataclass(frozen=True)
class AngleLaw:
    """How a peak moves with the angle: ``λ₀ √(1 − sin²θ/n²)``, and the line ``a − b E`` of the angle ``E = 2θ`` between light and viewer.

    Example:
        >>> import barbule
        >>> law = barbule.angle_law([0, 20, 40, 60], [640.0, 624.3, 580.2, 525.0])
        >>> isinstance(law, barbule.AngleLaw), round(law.normal_nm.value)
        (True, 641)
    """

    normal_nm: Interval
    index: Interval | None
    rmse_nm: float
    a_nm: Interval
    b_nm_per_deg: Interval
    line_rmse_nm: float


def angle_law(angles_deg: ArrayLike, peaks_nm: ArrayLike) -> AngleLaw:
    """Fits the law of peaks against the angle by least squares, with 95 % intervals (Student's t).

    Args:
        angles_deg: Angles θ at which the layers are lit, at least three: of arms half the angle between them, else the angle of incidence.
        peaks_nm: The peak of one order of interference at each.

    Raises:
        InputError: Fewer than three peaks, or all at one angle.

    Example:
        >>> import barbule
        >>> law = barbule.angle_law([0, 20, 40, 60], [640.0, 624.3, 580.2, 525.0])
        >>> 1.4 < law.index.value < 1.6
        True
    """
    found = _native.angle_law(numbers(angles_deg), [float(nm) for nm in numbers(peaks_nm)])
    normal, index, rmse, a, b, line_rmse = found
    return AngleLaw(
        Interval(*normal), None if index is None else Interval(*index), rmse, Interval(*a), Interval(*b), line_rmse
    )


def far_fields(
    section: Section,
    wavelengths_nm: ArrayLike,
    theta_deg: ArrayLike = 0.0,
    phi_deg: ArrayLike = 0.0,
    *,
    azimuths: int = 400,
    window: Literal["gaussian", "beam", "none"] = "gaussian",
    solver: str = "fast",
    elements_per_wavelength: float = 10.0,
    memory_bytes: int = 8 << 30,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """What one section scatters, by the fast simulation or by full waves.

    Args:
        section: A section, as `Structure.instance` gives it.
        wavelengths_nm: Vacuum wavelengths.
        theta_deg: Inclinations of the light along the barbule.
        phi_deg: Azimuths of the light across it.
        azimuths: Outgoing azimuths: over the upper half, of full waves over the whole circle.
        window: The light: ``gaussian`` on the top, ``beam``, or ``none``, a plane wave.
        solver: ``fast``, ``direct``, ``shadowed`` or ``full-wave``.
        elements_per_wavelength: Nodes per wavelength of full waves, 4 to 200.
        memory_bytes: What full waves may take at most.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``amplitude`` (complex, ``[wavelength, theta_i, phi_i, polarization, component, phi_o]``), ``intensity`` (part of the incident power per
        radian) and ``reflected``; of full waves also ``scattered_um`` and ``absorbed_um``.

    Example:
        >>> import barbule
        >>> section = barbule.open("starling").instance(0)
        >>> barbule.far_fields(section, [550], phi_deg=[0, 30])["intensity"].shape
        (1, 1, 2, 2, 400)
    """
    nm, theta, phi = numbers(wavelengths_nm), numbers(theta_deg), numbers(phi_deg)
    with watched(progress) as watch:
        found = _native.far_fields(
            section, nm, theta, phi, azimuths, window, solver, elements_per_wavelength, memory_bytes, threads, watch
        )
    light = ("wavelength", "theta_i", "phi_i", "polarization")
    data = {
        "amplitude": Quantity(found["amplitude"], (*light, "component", "phi_o"), "far-field amplitude", "µm^0.5"),
        "intensity": Quantity(found["intensity"], (*light, "phi_o"), "part of the incident power per radian", "1/rad"),
        "reflected": Quantity(found["reflected"], light, "part of the incident power that leaves upwards"),
    }
    for name, words in (("scattered_um", "scattering width"), ("absorbed_um", "absorption width")):
        if name in found:
            data[name] = Quantity(found[name], light, words, "µm")
    coords = {
        "wavelength": axis_nm(nm),
        "theta_i": Axis(theta, "inclination of the light along the barbule", "degree"),
        "phi_i": Axis(phi, "azimuth of the light across the barbule", "degree"),
        "polarization": Axis(np.array([1, 2]), "incident polarization"),
        "phi_o": Axis(found["phi_o"], "outgoing azimuth across the barbule", "degree"),
    }
    return labelled(data, coords, section=section.name, solver=solver, window=window)


def crystal(
    lattice: Name,
    wavelengths_nm: ArrayLike = VISIBLE_NM,
    phi_deg: ArrayLike = 0.0,
    theta_deg: float = 0.0,
    *,
    solver: Literal["multipole", "rcwa", "fdtd"] = "multipole",
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """The reflectance of an infinite crystal of rods, all orders, by three independent methods.

    Args:
        lattice: A species with a crystal (``mallard:blue``), or a lattice file.
        wavelengths_nm: Vacuum wavelengths, rising.
        phi_deg: Azimuths of the light across the rods.
        theta_deg: Its inclination along them.
        solver: Cylinder multipoles, the Fourier modal method, or finite differences in time.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``reflectance`` over ``[phi_i, wavelength]``, unpolarized, and ``R`` over ``[phi_i, wavelength, polarization]``.

    Example:
        >>> import barbule
        >>> barbule.crystal("mallard", [500, 550], [0, 20, 40])["reflectance"].shape
        (3, 2)
    """
    nm, phi, text = numbers(wavelengths_nm), numbers(phi_deg), text_of("lattice", lattice)
    with watched(progress) as watch:
        found = _native.crystal(text, nm, theta_deg, phi, solver, media_of(media), threads, watch)
    data = {
        "reflectance": Quantity(found.mean(axis=-1), ("phi_i", "wavelength"), "reflectance, unpolarized"),
        "R": Quantity(found, ("phi_i", "wavelength", "polarization"), "reflectance"),
    }
    coords = {
        "phi_i": Axis(phi, "azimuth of the light across the rods", "degree"),
        "wavelength": axis_nm(nm),
        "polarization": Axis(np.array([1, 2]), "incident polarization"),
    }
    return labelled(data, coords, lattice=text, solver=solver)


class Heights:
    """A patch of heights that diffracts light.

    Example:
        >>> import barbule
        >>> patch = barbule.Heights.sample("blazed")
        >>> patch.height_um.ndim
        2
    """

    def __init__(self, native: _native.Heights) -> None:
        self._native = native

    @classmethod
    def of(cls, height_um: ArrayLike, size_um: tuple[float, float]) -> Heights:
        """Heights in µm, ``[row along y, column along x]``, over a patch with these sides along x and y."""
        values = np.ascontiguousarray(height_um, dtype=np.float64)
        return cls(_native.Heights.of(values, list(size_um)))

    @classmethod
    def load(
        cls, path: Union[str, "PathLike[str]"], *, pitch_um: float | None = None, range_um: float | None = None
    ) -> Heights:
        """A file of heights: NPY, TIFF, PNG, text or Gwyddion's; `pitch_um` and `range_um` say what it does not."""
        return cls(_native.Heights.open(Path(path), pitch_um, range_um))

    @classmethod
    def sample(cls, name: str, seed: int = 1) -> Heights:
        """One of the samples: ``blazed``, ``sinusoid`` and the snakes' (an unknown name is refused with a list)."""
        return cls(_native.Heights.sample(name, seed))

    @property
    def height_um(self) -> NDArray[np.float64]:
        """Heights, µm, ``[row along y, column along x]``."""
        return self._native.height_um

    @property
    def size_um(self) -> tuple[float, float]:
        """Sides of the patch along x and y, µm."""
        x, y = self._native.size_um
        return (x, y)

    def spectrum(
        self,
        wavelengths_nm: ArrayLike,
        wi: ArrayLike,
        wo: ArrayLike,
        *,
        coherence_um: float | None = None,
        index: float | None = None,
        threads: int | None = None,
        progress: ProgressLike = True,
    ) -> xarray.Dataset:
        """The BRDF of the patch between two directions, ``f`` over ``[wavelength]``, 1/sr.

        Args:
            wavelengths_nm: Vacuum wavelengths, rising.
            wi: Towards the light, a unit vector with z up.
            wo: Towards the eye.
            coherence_um: Standard deviation of the light's coherence; 16.25 without a number.
            index: Refractive index of the surface.
            threads: Threads; all cores without a number.
            progress: True for a bar, False for none, or a function ``(label, done, total)``.
        """
        nm = numbers(wavelengths_nm)
        from_, to = ([float(part) for part in np.asarray(given, float)] for given in (wi, wo))
        with watched(progress) as watch:
            found = self._native.spectrum(nm, from_, to, coherence_um, index, threads, watch)
        data = {"f": Quantity(found, ("wavelength",), "BRDF, without the cosine", "1/sr")}
        return labelled(data, {"wavelength": axis_nm(nm)})

    def __repr__(self) -> str:
        return repr(self._native)
