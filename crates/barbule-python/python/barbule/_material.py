"""Materials: values, samples and densities in batches, and the tables behind them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._labels import floats, media_of, one_of, text_of
from ._progress import ProgressLike, watched
from .errors import InputError

Reciprocity = Literal["none", "steeper", "mean"]


class Material:
    """A feather's material: the BRDF of its barbules, as a mean and barbule by barbule.

    Directions are unit vectors of shape ``[..., 3]`` in the barbule's frame: x across, y along, z up; both point away from the surface.
    All leading axes are broadcast against each other. Values are in 1/sr without the cosine. Numbers of any type and stride are taken, lists
    among them.

    Example:
        >>> import barbule
        >>> material = barbule.Material.load("starling")
        >>> material.eval([450, 500, 550, 600], wi=[0, 0, 1], wo=[0, 0, 1], instance=range(3)).shape
        (3, 4)
    """

    def __init__(self, native: _native.Material) -> None:
        self._native = native

    @classmethod
    def load(
        cls,
        name: str | PathLike[str],
        *,
        media: Mapping[str, Union[str, "PathLike[str]"]] | None = None,
        cache: str | PathLike[str] | None = None,
        seed: int | None = None,
        may_compute: bool = True,
        reciprocity: Reciprocity = "none",
        sigma: float | None = None,
        polarization: Literal[1, 2] | None = None,
        threads: int | None = None,
        progress: ProgressLike = True,
    ) -> Material:
        """Opens a material: a file, or the material of a structure, which ships, is in the cache, or is made now (minutes).

        Args:
            name: A ``.barbule`` file, or whatever `barbule.open` takes.
            media: Media of your own by name, each a file of n and k.
            cache: Folder of computed materials; that of the command line without one.
            seed: Seed of what is simulated where it is made.
            may_compute: Whether a material that is not there is made; else it is refused.
            reciprocity: What makes values the same when light and eye change places; scenes take ``steeper``.
            sigma: Another spread along the barbule than the material's own.
            polarization: Incident polarization 1 or 2; unpolarized light without.
            threads: Threads; all cores without a number.
            progress: True for a bar, False for none, or a function ``(label, done, total)``.

        Raises:
            InputError: Nothing is called so, or the file is damaged.
        """
        text = text_of("name", name)
        one_of("polarization", polarization, (None, 1, 2))
        with watched(progress) as watch:
            return cls(
                _native.Material.open(
                    text,
                    media_of(media),
                    None if cache is None else Path(cache),
                    seed,
                    may_compute,
                    reciprocity,
                    sigma,
                    polarization,
                    threads,
                    watch,
                )
            )

    def eval(
        self,
        wavelengths_nm: ArrayLike,
        wi: ArrayLike,
        wo: ArrayLike,
        instance: ArrayLike | None = None,
        *,
        place: float | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]:
        """f in 1/sr, without the cosine; 0 where either direction is below the surface.

        Args:
            wavelengths_nm: Vacuum wavelengths, ``[W]`` for all, or ``[..., W]`` with axes that are broadcast with the others; a single
                number leaves the last axis out.
            wi: Towards the light, ``[..., 3]``.
            wo: Towards the eye, ``[..., 3]``.
            instance: Names of barbules, whole numbers ``[...]``, each with a speckle of its own; the mean over all without.
            place: What one place across the barbule gives of it, from -1 to 1 as x goes: where its section is an arch, each place
                mirrors its own pairs of directions. The whole barbule's without, which is the mean over places.
            threads: Threads; all cores without a number.

        Returns:
            ``[..., W]``, single precision, as the kernel computes it.
        """
        rows = _Rows(wavelengths_nm, wi, wo, instance=instance)
        found = self._native.eval_rows(rows.nm, rows.wi, rows.wo, rows.instance, rows.count, threads)
        if place is not None:
            found *= self._native.shares_rows(float(place), rows.wi, rows.wo, rows.count)[:, None].astype(np.float32)
        return rows.shaped(found)

    def pdf(
        self, wavelengths_nm: ArrayLike, wi: ArrayLike, wo: ArrayLike, *, threads: int | None = None
    ) -> NDArray[np.float64]:
        """The density per sr with which `sample` draws `wo`, ``[..., W]``; arguments as for `eval`."""
        rows = _Rows(wavelengths_nm, wi, wo)
        return rows.shaped(self._native.pdf_rows(rows.nm, rows.wi, rows.wo, rows.count, threads))

    def sample(
        self, wavelength_nm: ArrayLike, wi: ArrayLike, u: ArrayLike, *, threads: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Outgoing directions drawn from the mean lobes.

        Args:
            wavelength_nm: Vacuum wavelengths, ``[...]``.
            wi: Towards the light, ``[..., 3]``.
            u: Two uniform numbers each, from 0 to below 1, ``[..., 2]``.
            threads: Threads; all cores without a number.

        Returns:
            Directions ``[..., 3]`` and their densities per sr ``[...]``: NaN and 0 where none is drawn.
        """
        nm, wi_, u_ = floats(wavelength_nm)[..., None], floats(wi), floats(u)
        shape = _shape({"wavelength_nm": nm.shape[:-1], "wi": _lead(wi_, "wi", 3), "u": _lead(u_, "u", 2)})
        count = int(np.prod(shape))
        nm, wi_, u_ = (_rows(array, shape) for array in (nm, wi_, u_))
        wo, density = self._native.sample_rows(nm, wi_, u_, count, threads)
        return wo.reshape(*shape, 3), density.reshape(shape)

    def albedo(
        self, wavelength_nm: ArrayLike, wi: ArrayLike, *, threads: int | None = None
    ) -> NDArray[np.float64]:
        """What the mean reflects of light from `wi` in all, ``[...]``, as fitted: `reciprocity` changes values, not this."""
        nm, wi_ = floats(wavelength_nm)[..., None], floats(wi)
        shape = _shape({"wavelength_nm": nm.shape[:-1], "wi": _lead(wi_, "wi", 3)})
        count = int(np.prod(shape))
        found = self._native.albedo_rows(_rows(nm, shape), _rows(wi_, shape), count, threads)
        return found.reshape(shape)

    def tables(self) -> dict[str, NDArray[Any]]:
        """All that is evaluated, by name: read-only arrays on this material's own memory.

        What each holds, and how values follow, stands in ``docs/formats/brdf-tables.md``.
        """
        return self._native.tables()

    def header(self) -> dict[str, Any]:
        """What the tables mean: version, kind, sides, polarization, reciprocity, sigma, halo, seed and sizes."""
        return self._native.header()

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a ``.barbule`` file, whole or not at all."""
        self._native.save(Path(path))

    def to_bytes(self) -> bytes:
        """The bytes of its file."""
        return self._native.to_bytes()

    @property
    def info(self) -> dict[str, Any]:
        """How it was made."""
        found: dict[str, Any] = json.loads(self._native.info_json())
        return found

    @property
    def name(self) -> str:
        """What it is of."""
        return self._native.name

    @property
    def hash(self) -> str:
        """BLAKE3 of its file, hexadecimal."""
        return self._native.hash

    @property
    def source(self) -> str:
        """``shipped``, ``memory``, or the file that it was read from."""
        return self._native.source

    @property
    def wavelengths_nm(self) -> NDArray[np.float64]:
        """The wavelengths of its nodes; beyond them the end values hold."""
        return self._native.wavelengths_nm

    @property
    def cos_theta_i(self) -> NDArray[np.float64]:
        """cosθ_i of its nodes."""
        return self._native.cos_theta_i

    @property
    def cos_phi_i(self) -> NDArray[np.float64]:
        """cosφ_i of its nodes."""
        return self._native.cos_phi_i

    @property
    def sigma(self) -> float:
        """The spread along the barbule: with a halo, of the narrow part."""
        return self._native.sigma

    @property
    def halo_sigmas(self) -> list[float]:
        """The spreads of the halo's Gaussians."""
        return self._native.halo_sigmas

    def __repr__(self) -> str:
        nm = self.wavelengths_nm
        return f"<barbule.Material {self.name}, {nm[0]:g} to {nm[-1]:g} nm, {self.source}>"

    def _repr_html_(self) -> str:
        """The colours of what it reflects at 0°, 20°, 40° and 60° across, as swatches."""
        nm = np.arange(400.0, 701.0, 10.0)
        angles = np.radians([0.0, 20.0, 40.0, 60.0])
        wi = np.stack([np.sin(angles), np.zeros(4), np.cos(angles)], axis=-1)
        _, linear, _ = _native.xyz_of(nm, self.albedo(nm, wi[:, None, :]), "D65")
        shown = np.clip(linear / max(float(linear.max()), 1e-9), 0.0, 1.0) ** (1 / 2.2)
        cells = "".join(
            f'<td style="width:3em;height:2em;background:rgb{tuple(int(255 * c) for c in colour)}" title="{angle:g}°"></td>'
            for angle, colour in zip((0, 20, 40, 60), shown)
        )
        return f"<table><tr>{cells}<td>{self.name}</td></tr></table>"


def _lead(array: NDArray[np.float64], name: str, width: int) -> tuple[int, ...]:
    if array.ndim == 0 or array.shape[-1] != width:
        raise InputError(f"'{name}' has the shape {array.shape}; its last axis must be {width} long")
    return array.shape[:-1]


def _shape(shapes: dict[str, tuple[int, ...]]) -> tuple[int, ...]:
    """The shape over which arguments are evaluated, each without its last axis."""
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        said = ", ".join(f"'{name}' {shape}" for name, shape in shapes.items())
        raise InputError(f"the arguments' shapes do not fit: {said}") from None


def _rows(array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Rows of the last axis: one if it serves all, else as many as there are values, in order and without gaps."""
    width = array.shape[-1]
    if array.size == width:
        return np.ascontiguousarray(array.reshape(1, width))
    return np.ascontiguousarray(np.broadcast_to(array, (*shape, width))).reshape(-1, width)


class _Rows:
    """Arguments as the native module takes them, and the shape of what it gives."""

    def __init__(
        self, wavelengths_nm: ArrayLike, wi: ArrayLike, wo: ArrayLike, instance: ArrayLike | None = None
    ) -> None:
        nm, wi_, wo_ = (floats(given) for given in (wavelengths_nm, wi, wo))
        self._is_single = nm.ndim == 0
        nm = np.atleast_1d(nm)
        shapes = {"wavelengths_nm": nm.shape[:-1], "wi": _lead(wi_, "wi", 3), "wo": _lead(wo_, "wo", 3)}
        names = None if instance is None else _names(instance)
        if names is not None:
            shapes["instance"] = names.shape
        self.shape = _shape(shapes)
        self.count = int(np.prod(self.shape))
        self.nm, self.wi, self.wo = (_rows(array, self.shape) for array in (nm, wi_, wo_))
        self.instance = None if names is None else _rows(names[..., None], self.shape).reshape(-1)

    def shaped(self, values: NDArray[Any]) -> NDArray[Any]:
        if self._is_single:
            return values.reshape(self.shape)
        return values.reshape(*self.shape, values.shape[-1])


def _names(instance: ArrayLike) -> NDArray[np.uint64]:
    names = np.asarray(instance)
    if names.dtype.kind not in "iu":
        raise TypeError(f"'instance' holds {names.dtype}; names of barbules are whole numbers")
    if names.dtype.kind == "i" and names.size and int(names.min()) < 0:
        raise InputError(f"'instance' holds {int(names.min())}; names of barbules are 0 or more")
    # Whole numbers that are not negative have the same bits with a sign and without: no copy.
    is_alike = names.dtype.itemsize == 8 and names.dtype.isnative
    return names.view(np.uint64) if is_alike else names.astype(np.uint64)
