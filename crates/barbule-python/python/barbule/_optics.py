"""Films, spectra, far fields, crystals and gratings."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import Axis, Quantity, axis_nm, labelled, media_of, numbers
from ._native import Section, Structure
from ._opening import Name, structure_of
from ._progress import ProgressLike, watched

if TYPE_CHECKING:
    import xarray

#: 400 to 700 nm in steps of 5.
VISIBLE_NM = tuple(float(nm) for nm in range(400, 701, 5))

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
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """Exact reflection and transmission of a stack of flat layers.

    Args:
        stack: As in ``air/6*(melanin:99/keratin:100)/air``: media with thicknesses in nm, or a stack file (.toml).
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: Angles in the first medium, from the normal.
        gradients: Whether derivatives of the reflected amplitudes and reflectances are wanted too.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        Complex amplitudes ``r_s, r_p, t_s, t_p`` and powers ``R_s, R_p, T_s, T_p, A_s, A_p`` over ``[angle, wavelength]``, and
        ``A_layer_s, A_layer_p`` over ``[layer, angle, wavelength]``. Amplitudes of s belong to E, those of p to H, so at normal incidence
        r_p = −r_s. With gradients: ``dr_dd_s`` (1/nm, ``[angle, wavelength, layer]``), ``dr_dn_s`` (by n + jk, ``[…, medium]`` of layers
        and exit), ``dR_dd_s``, ``dR_dn_s``, ``dR_dk_s``, and the same for p.

    Raises:
        InputError: Not the stack language, an unknown medium, an angle at or past grazing.

    Example:
        >>> import barbule
        >>> film = barbule.film("air/keratin:595/air", [450, 550, 650], [0, 45])
        >>> film["r_s"].shape
        (2, 3)
    """
    nm, angles, own = numbers(wavelengths_nm), numbers(angles_deg), media_of(media)
    with watched(progress) as watch:
        found = _native.film(str(stack), nm, angles, own, threads, watch)
    data = {name: Quantity(found[name], dims, words) for name, (words, dims) in _FILM.items()}
    coords = {"angle": Axis(angles, "angle of incidence", "degree"), "wavelength": axis_nm(nm)}
    if gradients:
        values = _native.film_gradients(str(stack), nm, angles, own, threads)
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
    return labelled(data, coords, stack=str(stack))


def spectrum(
    structure: Structure | Name,
    wavelengths_nm: ArrayLike = VISIBLE_NM,
    angles_deg: ArrayLike = 0.0,
    *,
    plane: Literal["across", "along"] = "across",
    instances: int = 50,
    seed: int = 1,
    cone_deg: float | None = None,
    polarization: Literal[1, 2] | None = None,
    media: Mapping[str, Name] | None = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> xarray.Dataset:
    """What barbules reflect over the wavelength: mean, spread and every individual.

    Args:
        structure: A structure, or whatever `barbule.open` opens.
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: Angles of the light from the normal.
        plane: Whether the light turns across the barbule or along it.
        instances: Number of random individuals.
        seed: Their seed.
        cone_deg: Only what falls within this angle of the mirror direction; all of it without.
        polarization: Incident polarization 1 or 2; unpolarized light without.
        media: Media of your own by name, each a file of n and k.
        threads: Threads; all cores without a number.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``reflectance`` and ``std`` over ``[angle, wavelength]``, ``individuals`` over ``[instance, angle, wavelength]``, and ``flagged``: where
        light grazes so that the simulation is off.

    Example:
        >>> import barbule
        >>> found = barbule.spectrum("starling", [450, 550, 650], [0, 30], instances=4)
        >>> found["individuals"].shape
        (4, 2, 3)
    """
    opened = structure_of(structure, media)
    nm, angles = numbers(wavelengths_nm), numbers(angles_deg)
    nothing = np.zeros_like(angles)
    theta, phi = (nothing, angles) if plane == "across" else (angles, nothing)
    weights = {None: [0.5, 0.5], 1: [1.0, 0.0], 2: [0.0, 1.0]}[polarization]
    with watched(progress) as watch:
        mean, std, individuals, flagged = _native.spectra(
            opened, nm, theta, phi, instances, seed, cone_deg, weights, threads, watch
        )
    over = ("angle", "wavelength")
    data = {
        "reflectance": Quantity(mean, over, "reflected fraction, mean over individuals"),
        "std": Quantity(std, over, "standard deviation of individuals"),
        "individuals": Quantity(individuals, ("instance", *over), "reflected fraction of each individual"),
        "flagged": Quantity(flagged, over, "whether the simulation is off there"),
    }
    coords = {
        "angle": Axis(angles, f"angle of incidence, {plane} the barbule", "degree"),
        "wavelength": axis_nm(nm),
        "instance": Axis(np.arange(individuals.shape[0]), "number of the individual"),
    }
    return labelled(data, coords, structure=opened.name, seed=seed)


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
        elements_per_wavelength: Nodes per wavelength of full waves.
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
    return labelled(data, coords, section=section.name, solver=solver)


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
    nm, phi = numbers(wavelengths_nm), numbers(phi_deg)
    with watched(progress) as watch:
        found = _native.crystal(str(lattice), nm, theta_deg, phi, solver, media_of(media), threads, watch)
    data = {
        "reflectance": Quantity(found.mean(axis=-1), ("phi_i", "wavelength"), "reflectance, unpolarized"),
        "R": Quantity(found, ("phi_i", "wavelength", "polarization"), "reflectance"),
    }
    coords = {
        "phi_i": Axis(phi, "azimuth of the light across the rods", "degree"),
        "wavelength": axis_nm(nm),
        "polarization": Axis(np.array([1, 2]), "incident polarization"),
    }
    return labelled(data, coords, lattice=str(lattice), solver=solver)


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
