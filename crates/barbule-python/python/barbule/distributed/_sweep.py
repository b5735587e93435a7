"""Results of many calls in one Zarr store: a chunk of each array for each item, and a mark behind them when all are there."""

from __future__ import annotations

import json
import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._labels import Axis
from .._progress import ProgressLike
from ..errors import InputError, MachineError
from ._dask import needed
from ._engine import Cluster, refuse_unlike
from ._fill import fill
from ._mirror import is_url
from ._work import VERSION, Prepared, Watch, identity_of

#: The array that says which items are there.
DONE = "done"

#: The attribute that says what a store is of, and the version of its layout.
ABOUT, LAYOUT = "barbule_sweep", 1


@dataclass(frozen=True)
class Field:
    """An array of a sweep: what trails the items' dimensions, and what it is."""

    trailing: tuple[str, ...]
    long_name: str
    units: str = ""
    dtype: str = "float64"


@dataclass(frozen=True)
class Layout:
    """What a store holds.

    Attributes:
        leading: The dimensions that items go through, the last fastest.
        axes: The coordinates of all dimensions.
        fields: The arrays.
    """

    leading: tuple[str, ...]
    axes: Mapping[str, Axis]
    fields: Mapping[str, Field]

    def shape(self, dims: Sequence[str]) -> tuple[int, ...]:
        """Lengths of dimensions."""
        return tuple(len(self.axes[name].values) for name in dims)

    @property
    def count(self) -> int:
        """How many items there are."""
        return prod(self.shape(self.leading))


@dataclass(frozen=True)
class Sweep(ABC):
    """Calls of one function, whose results go into a store; an item is a call.

    Attributes:
        store: A folder by its whole path, or a URL.
        storage_options: JSON; not in the identity, since it has credentials.
    """

    store: str
    storage_options: str

    label = "computing"

    @property
    @abstractmethod
    def description(self) -> dict[str, Any]:
        """All that decides the results, for JSON."""

    @property
    @abstractmethod
    def layout(self) -> Layout:
        """What the store holds."""

    @abstractmethod
    def opened(self) -> Any:
        """What the items need, opened on a worker."""

    @abstractmethod
    def item(self, opened: Any, index: tuple[int, ...], threads: int, watch: Watch) -> Mapping[str, NDArray[Any]]:
        """The results of an item, each of its field's trailing shape."""

    @property
    def identity(self) -> str:
        """A hash of what is computed and where it goes."""
        return identity_of(store=self.store, **self.description)

    def group(self, mode: str) -> Any:
        """The store, opened."""
        zarr = needed("zarr", "a sweep")
        options = json.loads(self.storage_options) if is_url(self.store) else None
        return zarr.open_group(self.store, mode=mode, storage_options=options, zarr_format=3)

    def prepare(self, folder: Path, slots: int) -> Prepared:
        """Opens what the items need."""
        return PreparedSweep(self)


class PreparedSweep:
    """A sweep on a worker."""

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep
        self._layout = sweep.layout
        self._group = sweep.group("r+")
        self._opened = sweep.opened()

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Computes an item, unless it is marked; the mark is written last."""
        place = np.unravel_index(item, self._layout.shape(self._layout.leading))
        index = tuple(int(part) for part in place)
        if self._group[DONE][index]:
            return
        found = self._sweep.item(self._opened, index, threads, watch)
        for name, field in self._layout.fields.items():
            self._group[name][index] = np.asarray(found[name], dtype=field.dtype).reshape(self._layout.shape(field.trailing))
        self._group[DONE][index] = 1

    def close(self) -> None:
        """Nothing stays open."""


def filled(
    sweep: Sweep,
    cluster: Cluster,
    *,
    unit_seconds: float,
    memory_bytes: float,
    threads: int,
    retries: int,
    progress: ProgressLike,
) -> Any:
    """Fills the store of a sweep, or goes on with it; the dataset, by xarray where it is installed, else the Zarr group."""
    refuse_unlike(cluster, sweep.label)
    group = _made(sweep, cluster.simd)
    fill(
        sweep,
        lambda: _missing(group),
        cluster,
        unit_seconds=unit_seconds,
        memory_bytes=memory_bytes,
        threads=threads,
        retries=retries,
        progress=progress,
        place=sweep.store,
    )
    return _dataset(sweep, group)


def _missing(group: Any) -> list[int]:
    return [int(item) for item in np.flatnonzero(np.asarray(group[DONE][...]).ravel() == 0)]


def _made(sweep: Sweep, simd: str) -> Any:
    """The store, made where it is not there.

    Raises:
        InputError: There is something else, or a store of other calls.
        MachineError: It cannot be written.
    """
    zarr = needed("zarr", "a sweep")
    layout = sweep.layout
    described = {"layout": LAYOUT, "version": VERSION, "simd": simd, **sweep.description}
    described = json.loads(json.dumps(described))
    try:
        group = sweep.group("a")
        about = group.attrs.get(ABOUT)
        if about is None and (len(list(group.keys())) or len(group.attrs)):
            raise InputError(f"{sweep.store}: is another Zarr store; give another name")
        if about is not None and about != described:
            key = next(key for key in [*described, *about] if described.get(key) != about.get(key))
            raise InputError(
                f"{sweep.store}: was made with another '{key}' ({_short(about.get(key))} there, {_short(described.get(key))} here); "
                "give another name, or the same to go on"
            )
        if about is None:
            group.attrs[ABOUT] = described
        # It is made last: where it is not, nothing else counts.
        if DONE not in set(group.keys()):
            _make_arrays(group, layout)
        if group.metadata.consolidated_metadata is None:
            with warnings.catch_warnings():
                # Zarr 3 calls them an extension; all readers take them.
                warnings.simplefilter("ignore")
                zarr.consolidate_metadata(group.store, path=group.path)
            group = sweep.group("r+")
        return group
    except InputError:
        raise
    except ValueError as error:
        # Zarr's own, of what is there and is no group.
        raise InputError(f"{sweep.store}: is no store of a sweep ({error}); give another name") from error
    except OSError as error:
        raise MachineError(f"the store {sweep.store} cannot be written ({error})") from error


def _make_arrays(group: Any, layout: Layout) -> None:
    for name, axis in layout.axes.items():
        values = np.asarray(axis.values)
        _array(group, name, (name,), values.shape, values.shape, values, axis.long_name, axis.units)
    for name, field in layout.fields.items():
        dims = (*layout.leading, *field.trailing)
        chunks = (*(1 for _ in layout.leading), *layout.shape(field.trailing))
        _array(group, name, dims, layout.shape(dims), chunks, None, field.long_name, field.units, field.dtype)
    shape = layout.shape(layout.leading)
    words = "1 where all arrays have their values"
    _array(group, DONE, layout.leading, shape, tuple(1 for _ in shape), None, words, "", "uint8")


def _array(
    group: Any,
    name: str,
    dims: Sequence[str],
    shape: Sequence[int],
    chunks: Sequence[int],
    values: NDArray[Any] | None,
    long_name: str,
    units: str,
    dtype: str | None = None,
) -> None:
    attributes = {"long_name": long_name, **({"units": units} if units else {})}
    kind = np.dtype(dtype) if dtype is not None else np.asarray(values).dtype
    fill = 0 if kind.kind in "iub" else np.nan
    array = group.create_array(
        name,
        shape=tuple(shape),
        chunks=tuple(max(1, length) for length in chunks),
        dtype=kind,
        fill_value=fill,
        dimension_names=tuple(dims),
        attributes=attributes,
        overwrite=True,
    )
    if values is not None:
        array[...] = values


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}…"


def _dataset(sweep: Sweep, group: Any) -> Any:
    try:
        import xarray
    except ImportError:
        return group
    options = json.loads(sweep.storage_options) if is_url(sweep.store) else None
    return xarray.open_zarr(sweep.store, storage_options=options, consolidated=True).drop_vars(DONE)
