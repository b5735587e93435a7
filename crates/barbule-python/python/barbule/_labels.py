"""Labelled results: xarray datasets where xarray is installed, else `Arrays`, which have the same names."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike, fsdecode, fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Axis:
    """A coordinate: its values along one dimension, what they are and in which unit.

    Example:
        >>> import barbule, numpy as np
        >>> angle = barbule.Axis(np.array([0.0, 45.0]), "angle of incidence", "degree")
        >>> angle.long_name, angle.units
        ('angle of incidence', 'degree')
    """

    values: NDArray[Any]
    long_name: str
    units: str = ""


@dataclass(frozen=True)
class Quantity:
    """An array with the names of its dimensions, what it is and in which unit.

    Example:
        >>> import barbule, numpy as np
        >>> one = barbule.Quantity(np.zeros((2, 3)), ("angle", "wavelength"), "reflectance")
        >>> one.shape, np.asarray(one).mean().item()
        ((2, 3), 0.0)
    """

    values: NDArray[Any]
    dims: tuple[str, ...]
    long_name: str
    units: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.values.shape

    @property
    def attrs(self) -> dict[str, str]:
        """`long_name` and `units`, as xarray has them."""
        return {"long_name": self.long_name, "units": self.units}

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype=dtype) if copy else np.asarray(self.values, dtype=dtype)

    def __getitem__(self, index: Any) -> Any:
        return self.values[index]


@dataclass(frozen=True, eq=False)
class Arrays(Mapping[str, Quantity]):
    """Named arrays with coordinates, where xarray is not installed.

    Example:
        >>> import barbule, numpy as np
        >>> nm = barbule.Axis(np.array([450.0, 550.0]), "vacuum wavelength", "nm")
        >>> one = barbule.Arrays({"R": barbule.Quantity(np.array([0.1, 0.2]), ("wavelength",), "reflectance")}, {"wavelength": nm})
        >>> list(one), one["wavelength"].attrs["units"]
        (['R'], 'nm')
    """

    data: dict[str, Quantity]
    coords: dict[str, Axis]
    attrs: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Quantity:
        if name in self.coords:
            axis = self.coords[name]
            return Quantity(axis.values, (name,), axis.long_name, axis.units)
        return self.data[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __repr__(self) -> str:
        rows = [f"  {name:<14} {', '.join(q.dims):<28} {q.long_name} ({q.units or '1'})" for name, q in self.data.items()]
        return "\n".join(["<barbule.Arrays>", *rows])

    def to_xarray(self) -> xarray.Dataset:
        """The same as an xarray dataset, which has to be installed."""
        import xarray

        variables = {
            name: (q.dims, q.values, {"long_name": q.long_name, "units": q.units}) for name, q in self.data.items()
        }
        coords = {
            name: (name, axis.values, {"long_name": axis.long_name, "units": axis.units})
            for name, axis in self.coords.items()
        }
        return xarray.Dataset(variables, coords, self.attrs)


def labelled(data: Mapping[str, Quantity], coords: Mapping[str, Axis], **attrs: Any) -> xarray.Dataset:
    """A dataset of xarray, or `Arrays` where it is not installed."""
    arrays = Arrays(dict(data), dict(coords), attrs)
    try:
        import xarray  # noqa: F401
    except ImportError:
        # Its names are those of a dataset; annotations say the usual case.
        return arrays  # type: ignore[return-value]
    from . import _accessor  # noqa: F401

    return arrays.to_xarray()


def numbers(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as a flat array of 64-bit floats."""
    return np.atleast_1d(floats(values)).ravel()


def floats(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as an array of 64-bit floats.

    Raises:
        InputError: Some are masked.
    """
    if np.ma.is_masked(values):
        raise InputError("some values are masked; leave them out, or fill them")
    return np.asarray(values, dtype=np.float64)


def rows_of(name: str, values: ArrayLike, width: int, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Numbers as an array of at least one axis, and as rows of its last one, which is `width` long.

    Raises:
        InputError: It is not.
    """
    array = np.atleast_1d(floats(values))
    if array.shape[-1] != width:
        raise InputError(f"'{name}' has the shape {array.shape}; its last axis must hold {width} {what}")
    return array, np.ascontiguousarray(array.reshape(-1, width))


def media_of(media: Mapping[str, Any] | None) -> list[tuple[str, str]]:
    """Media of the caller's own, as the native module takes them."""
    return [(name, str(path)) for name, path in (media or {}).items()]


def one_of(name: str, value: Any, choices: Sequence[Any]) -> None:
    """Refuses what is none of the choices of an argument."""
    if any(value is choice or (isinstance(value, (str, int, np.integer)) and value == choice) for choice in choices):
        return
    *others, last = [repr(choice) for choice in choices]
    raise InputError(f"'{name}' is {value!r}; give {', '.join(others)} or {last}")


def text_of(name: str, given: Any) -> str:
    """What people type, or the path of a file, as text.

    Raises:
        TypeError: It is something else, such as what is open already.
    """
    if isinstance(given, (str, PathLike)):
        return fsdecode(fspath(given))
    kind = type(given).__name__
    what = "None" if given is None else f"{'an' if kind[0] in 'aeiouAEIOU' else 'a'} {kind}"
    raise TypeError(f"'{name}' is {what}; give its name or a file")


def plain(name: str, value: Any) -> Any:
    """An option as JSON has it: numbers of NumPy as Python's, sequences as lists.

    Raises:
        InputError: It is no finite number, or holds one that is none.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        return [plain(name, one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"'{name}' is {value}; give a finite number")
    return value


def axis_nm(values: Sequence[float] | NDArray[np.float64]) -> Axis:
    """The coordinate of vacuum wavelengths."""
    return Axis(np.asarray(values, dtype=np.float64), "vacuum wavelength", "nm")
