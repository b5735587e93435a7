"""Sweeps of spectra, far fields and crystals."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _optics
from .._labels import Axis, axis_nm, numbers, one_of
from .._native import Structure
from .._opening import Name, structure_of
from .._progress import ProgressLike
from ..errors import InputError
from ._engine import UNIT_SECONDS, asked
from ._mirror import is_url, options_text
from ._sweep import Field, Layout, Sweep, filled
from ._work import Watch, opened_alike, placed, placed_media

#: Memory that a task is counted with where nothing else is said, bytes.
USUAL_BYTES = 1 << 30

#: What full waves may take, bytes.
FULL_WAVE_BYTES = 8 << 30

Store = Union[str, "PathLike[str]"]
Numbers = tuple[float, ...]


@dataclass(frozen=True)
class SpectraSweep(Sweep):
    """Spectra of structures; an item is a structure."""

    structures: tuple[tuple[str, str], ...]
    media: tuple[tuple[str, str], ...]
    wavelengths_nm: Numbers
    angles_deg: Numbers
    how: tuple[tuple[str, Any], ...]

    label = "spectra"

    @property
    def description(self) -> dict[str, Any]:
        """All that decides the results."""
        return {
            "kind": "spectra",
            "structures": [list(one) for one in self.structures],
            "wavelengths_nm": list(self.wavelengths_nm),
            "angles_deg": list(self.angles_deg),
            **dict(self.how),
        }

    @cached_property
    def layout(self) -> Layout:
        """Mean and spread over the angle and wavelength of each structure."""
        over = ("angle", "wavelength")
        what = "reflected fraction" if dict(self.how)["instrument"] is None else "reading beside white"
        return Layout(
            leading=("structure",),
            axes={
                "structure": Axis(np.arange(len(self.structures)), "number of the structure; names are in the attributes"),
                "angle": Axis(np.array(self.angles_deg), f"angle of incidence, {dict(self.how)['plane']} the barbule", "degree"),
                "wavelength": axis_nm(self.wavelengths_nm),
            },
            fields={
                "reflectance": Field(over, f"{what}, mean over individuals"),
                "std": Field(over, "standard deviation of individuals"),
                "flagged": Field(over, "1 where the simulation is off", dtype="uint8"),
            },
        )

    def opened(self) -> None:
        """Structures are opened as they come."""

    def item(self, opened: Any, index: tuple[int, ...], threads: int, watch: Watch) -> Mapping[str, NDArray[Any]]:
        """The spectra of a structure."""
        structure = opened_alike(self.structures[index[0]][0], self.media, self.structures[index[0]][1])
        how = dict(self.how)
        if structure.count is not None:
            # Of a stack without spreads there is one, and nobody asked for more of it.
            how["instances"] = min(how["instances"], structure.count)
        found = _optics.spectrum(structure, self.wavelengths_nm, self.angles_deg, threads=threads, progress=watch, **how)
        return {name: np.asarray(found[name]) for name in self.layout.fields}


@dataclass(frozen=True)
class FarFieldSweep(Sweep):
    """Far fields of individuals; an item is an individual at a wavelength."""

    structure: tuple[str, str]
    media: tuple[tuple[str, str], ...]
    wavelengths_nm: Numbers
    theta_deg: Numbers
    phi_deg: Numbers
    instances: int
    seed: int
    azimuths: int
    how: tuple[tuple[str, Any], ...]
    memory_bytes: int

    label = "far fields"

    @property
    def description(self) -> dict[str, Any]:
        """All that decides the results."""
        return {
            "kind": "far fields",
            "structure": list(self.structure),
            "wavelengths_nm": list(self.wavelengths_nm),
            "theta_deg": list(self.theta_deg),
            "phi_deg": list(self.phi_deg),
            "instances": self.instances,
            "seed": self.seed,
            "azimuths": self.azimuths,
            **dict(self.how),
        }

    @cached_property
    def layout(self) -> Layout:
        """Amplitudes and intensities of each individual and wavelength."""
        light = ("theta_i", "phi_i", "polarization")
        is_circle = dict(self.how)["solver"] == "full-wave"
        steps = np.arange(self.azimuths)
        phi_o = steps * 360.0 / self.azimuths - 180.0 if is_circle else (steps + 0.5) * 180.0 / self.azimuths - 90.0
        fields = {
            "amplitude": Field((*light, "component", "phi_o"), "far-field amplitude", "µm^0.5", "complex128"),
            "intensity": Field((*light, "phi_o"), "part of the incident power per radian", "1/rad"),
            "reflected": Field(light, "part of the incident power that leaves upwards"),
        }
        if is_circle:
            fields["scattered_um"] = Field(light, "scattering width", "µm")
            fields["absorbed_um"] = Field(light, "absorption width", "µm")
        return Layout(
            leading=("instance", "wavelength"),
            axes={
                "instance": Axis(np.arange(self.instances), "number of the individual"),
                "wavelength": axis_nm(self.wavelengths_nm),
                "theta_i": Axis(np.array(self.theta_deg), "inclination of the light along the barbule", "degree"),
                "phi_i": Axis(np.array(self.phi_deg), "azimuth of the light across the barbule", "degree"),
                "polarization": Axis(np.array([1, 2]), "incident polarization"),
                "component": Axis(np.array([1, 2]), "along e1, along e2"),
                "phi_o": Axis(phi_o, "outgoing azimuth across the barbule", "degree"),
            },
            fields=fields,
        )

    def opened(self) -> Structure:
        """The structure."""
        return opened_alike(self.structure[0], self.media, self.structure[1])

    def item(self, opened: Any, index: tuple[int, ...], threads: int, watch: Watch) -> Mapping[str, NDArray[Any]]:
        """The far fields of an individual at a wavelength."""
        instance, wavelength = index
        found = _optics.far_fields(
            opened.instance(instance, self.seed),
            [self.wavelengths_nm[wavelength]],
            self.theta_deg,
            self.phi_deg,
            azimuths=self.azimuths,
            memory_bytes=self.memory_bytes,
            threads=threads,
            progress=watch,
            **dict(self.how),
        )
        return {name: np.asarray(found[name])[0] for name in self.layout.fields}


@dataclass(frozen=True)
class CrystalSweep(Sweep):
    """Reflectances of a crystal; an item is a wavelength."""

    lattice: str
    #: Of the structure that the name stands for, where it is one.
    lattice_hash: str
    media: tuple[tuple[str, str], ...]
    wavelengths_nm: Numbers
    phi_deg: Numbers
    theta_deg: float
    solver: str

    label = "crystals"

    @property
    def description(self) -> dict[str, Any]:
        """All that decides the results."""
        return {
            "kind": "crystal",
            "lattice": [self.lattice, self.lattice_hash],
            "wavelengths_nm": list(self.wavelengths_nm),
            "phi_deg": list(self.phi_deg),
            "theta_deg": self.theta_deg,
            "solver": self.solver,
        }

    @cached_property
    def layout(self) -> Layout:
        """Reflectance over azimuth and polarization at each wavelength."""
        return Layout(
            leading=("wavelength",),
            axes={
                "wavelength": axis_nm(self.wavelengths_nm),
                "phi_i": Axis(np.array(self.phi_deg), "azimuth of the light across the rods", "degree"),
                "polarization": Axis(np.array([1, 2]), "incident polarization"),
            },
            fields={"R": Field(("phi_i", "polarization"), "reflectance of all orders")},
        )

    def opened(self) -> str:
        """The lattice, which is held against the client's."""
        opened_alike(self.lattice, self.media, self.lattice_hash)
        return self.lattice

    def item(self, opened: Any, index: tuple[int, ...], threads: int, watch: Watch) -> Mapping[str, NDArray[Any]]:
        """The reflectances at a wavelength."""
        nm = [self.wavelengths_nm[index[0]]]
        solver: Any = self.solver
        found = _optics.crystal(
            opened, nm, self.phi_deg, self.theta_deg, solver=solver, media=dict(self.media), threads=threads, progress=watch
        )
        return {"R": np.asarray(found["R"])[:, 0]}


def spectrum(
    structures: Sequence[Name],
    wavelengths_nm: ArrayLike = _optics.VISIBLE_NM,
    angles_deg: ArrayLike = 0.0,
    *,
    client: Any,
    store: Store,
    plane: Literal["across", "along"] = "across",
    instances: int = 50,
    seed: int = 1,
    cone_deg: float | None = None,
    instrument: str | None = None,
    turn_deg: float = 0.0,
    tilt_deg: float | tuple[float, float] = 0.0,
    polarization: Literal[1, 2] | None = None,
    storage_options: Mapping[str, Any] | None = None,
    media: Mapping[str, Name] | None = None,
    memory_bytes: int = USUAL_BYTES,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> Any:
    """Spectra of many structures on a cluster, into a Zarr store: `barbule.spectrum` of each.

    What is in the store is not computed again; the same call goes on after whatever stopped it.

    Args:
        structures: Whatever `barbule.open` opens; files lie where all workers see them.
        wavelengths_nm: Vacuum wavelengths, rising.
        angles_deg: As for `barbule.spectrum`.
        client: A `distributed.Client`.
        store: A folder that all workers see, or a URL of fsspec's (``s3://bucket/S.zarr``).
        plane: As for `barbule.spectrum`, and so the next ones.
        instances: As for `barbule.spectrum`.
        seed: As for `barbule.spectrum`.
        cone_deg: As for `barbule.spectrum`.
        instrument: As for `barbule.spectrum`.
        turn_deg: As for `barbule.spectrum`.
        tilt_deg: As for `barbule.spectrum`.
        polarization: As for `barbule.spectrum`.
        storage_options: What fsspec gets for a URL.
        media: Media of your own by name, each a file of n and k that all workers see.
        memory_bytes: What a task is counted with.
        unit_seconds: What a task is to take at least, as measured with the first structures.
        threads: Threads of each task.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``reflectance``, ``std`` and ``flagged`` over ``[structure, angle, wavelength]``, opened from the store by xarray where it is
        installed, else the Zarr group.

    Raises:
        InputError: No structure, one that workers see differently, or a store of something else.
        MachineError: A task failed too often.
    """
    one_of("plane", plane, ("across", "along"))
    one_of("polarization", polarization, (None, 1, 2))
    if not structures:
        raise InputError("'structures' is empty; give at least one")
    own = placed_media(media)
    names = [placed(name) for name in structures]
    how = {
        "plane": plane,
        "instances": instances,
        "seed": seed,
        "cone_deg": cone_deg,
        "instrument": instrument,
        "turn_deg": turn_deg,
        "tilt_deg": tilt_deg,
        "polarization": polarization,
    }
    sweep = SpectraSweep(
        store=_place(store),
        storage_options=options_text(storage_options),
        structures=tuple((name, structure_of(name, dict(own)).hash) for name in names),
        media=own,
        wavelengths_nm=_tuple(wavelengths_nm),
        angles_deg=_tuple(angles_deg),
        how=tuple(how.items()),
    )
    return filled(
        sweep,
        asked(client),
        unit_seconds=unit_seconds,
        memory_bytes=memory_bytes,
        threads=threads,
        retries=retries,
        progress=progress,
    )


def far_fields(
    structure: Name,
    wavelengths_nm: ArrayLike,
    theta_deg: ArrayLike = 0.0,
    phi_deg: ArrayLike = 0.0,
    *,
    client: Any,
    store: Store,
    instances: int = 10,
    seed: int = 1,
    azimuths: int = 400,
    window: Literal["gaussian", "beam", "none"] = "gaussian",
    solver: str = "full-wave",
    elements_per_wavelength: float = 10.0,
    storage_options: Mapping[str, Any] | None = None,
    media: Mapping[str, Name] | None = None,
    memory_bytes: int = FULL_WAVE_BYTES,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> Any:
    """Far fields of many individuals on a cluster, by full waves unless `solver` says another: `barbule.far_fields` of each.

    Args:
        structure: Whatever `barbule.open` opens; files lie where all workers see them.
        wavelengths_nm: Vacuum wavelengths, rising.
        theta_deg: Inclinations of the light along the barbule.
        phi_deg: Azimuths of the light across it.
        client: A `distributed.Client`.
        store: A folder that all workers see, or a URL of fsspec's.
        instances: Individuals.
        seed: Their seed.
        azimuths: As for `barbule.far_fields`, and so the next ones.
        window: As for `barbule.far_fields`.
        solver: As for `barbule.far_fields`.
        elements_per_wavelength: As for `barbule.far_fields`.
        storage_options: What fsspec gets for a URL.
        media: Media of your own by name, each a file of n and k that all workers see.
        memory_bytes: What a task may take, and is counted with: workers need as much.
        unit_seconds: What a task is to take at least, as measured with the first individuals.
        threads: Threads of each task.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        As `barbule.far_fields`, with ``instance`` in front, opened from the store.

    Raises:
        InputError: Fewer sections than individuals, a structure that workers see differently, or a store of something else.
        MachineError: A task failed too often.
    """
    own, name = placed_media(media), placed(structure)
    opened = structure_of(name, dict(own))
    if instances < 1 or (opened.count is not None and instances > opened.count):
        most = "" if opened.count is None else f" to {opened.count}, as many as there are sections"
        raise InputError(f"'instances' is {instances}; give from 1{most}")
    sweep = FarFieldSweep(
        store=_place(store),
        storage_options=options_text(storage_options),
        structure=(name, opened.hash),
        media=own,
        wavelengths_nm=_tuple(wavelengths_nm),
        theta_deg=_tuple(theta_deg),
        phi_deg=_tuple(phi_deg),
        instances=instances,
        seed=seed,
        azimuths=azimuths,
        how=(("window", window), ("solver", solver), ("elements_per_wavelength", elements_per_wavelength)),
        memory_bytes=memory_bytes,
    )
    return filled(
        sweep,
        asked(client),
        unit_seconds=unit_seconds,
        memory_bytes=memory_bytes,
        threads=threads,
        retries=retries,
        progress=progress,
    )


def crystal(
    lattice: Name,
    wavelengths_nm: ArrayLike = _optics.VISIBLE_NM,
    phi_deg: ArrayLike = 0.0,
    theta_deg: float = 0.0,
    *,
    client: Any,
    store: Store,
    solver: Literal["multipole", "rcwa", "fdtd"] = "multipole",
    storage_options: Mapping[str, Any] | None = None,
    media: Mapping[str, Name] | None = None,
    memory_bytes: int = USUAL_BYTES,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> Any:
    """The reflectance of an infinite crystal on a cluster, wavelength by wavelength: `barbule.crystal`.

    Args:
        lattice: A species with a crystal (``mallard:blue``), or a lattice file that all workers see.
        wavelengths_nm: Vacuum wavelengths, rising.
        phi_deg: Azimuths of the light across the rods.
        theta_deg: Inclination of the light along the rods.
        client: A `distributed.Client`.
        store: A folder that all workers see, or a URL of fsspec's.
        solver: As for `barbule.crystal`.
        storage_options: What fsspec gets for a URL.
        media: Media of your own by name, each a file of n and k that all workers see.
        memory_bytes: What a task is counted with.
        unit_seconds: What a task is to take at least, as measured with the first wavelengths.
        threads: Threads of each task.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        ``R`` over ``[wavelength, phi_i, polarization]``, opened from the store.

    Raises:
        InputError: A lattice that workers see differently, or a store of something else.
        MachineError: A task failed too often.
    """
    own, name = placed_media(media), placed(lattice)
    sweep = CrystalSweep(
        store=_place(store),
        storage_options=options_text(storage_options),
        lattice=name,
        lattice_hash=structure_of(name, dict(own)).hash,
        media=own,
        wavelengths_nm=_tuple(wavelengths_nm),
        phi_deg=_tuple(phi_deg),
        theta_deg=float(theta_deg),
        solver=solver,
    )
    return filled(
        sweep,
        asked(client),
        unit_seconds=unit_seconds,
        memory_bytes=memory_bytes,
        threads=threads,
        retries=retries,
        progress=progress,
    )


def _place(store: Store) -> str:
    text = os.fspath(store)
    return text if is_url(text) else str(Path(text).absolute())


def _tuple(values: ArrayLike) -> Numbers:
    return tuple(float(value) for value in numbers(values))

