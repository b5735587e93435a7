"""Campaign stores on object stores: folders elsewhere whose files are those of the program's own stores.

What a store is made of, the program alone knows. Here its files are copied under their names, in the order in which it writes them: an object
appears whole or not at all, and the last of a unit says that it is done.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError, MachineError
from ._dask import needed

#: Files that are copied at once.
_AT_ONCE = 32

#: Kinds of stores that have no folders.
_FLAT = {"s3", "s3a", "gs", "gcs", "az", "abfs", "adl", "memory"}


def is_url(store: str) -> bool:
    """Whether a store's name is that of something else than a folder here, as in ``s3://bucket/S.zarr``."""
    return "://" in store


class Mirror:
    """A folder of an object store, through fsspec.

    Args:
        url: As in ``s3://bucket/S.zarr``; what fsspec knows.
        options: What fsspec gets of it: credentials, an endpoint. Without, it looks where its own documentation says.

    Raises:
        InputError: fsspec, or what it needs for this kind of URL, is missing.
    """

    def __init__(self, url: str, options: Mapping[str, Any] | None = None) -> None:
        self.url = url.rstrip("/")
        fsspec = needed("fsspec", f"the store {url}")
        # Other workers write while this one looks.
        own = {"use_listings_cache": False, "skip_instance_cache": True, **(options or {})}
        try:
            self._files, self._root = fsspec.core.url_to_fs(self.url, **own)
        except (ImportError, ValueError) as error:
            raise InputError(f"the store {url} cannot be reached: {error}") from error
        kinds = self._files.protocol
        self._is_flat = bool(_FLAT & ({kinds} if isinstance(kinds, str) else set(kinds)))

    def fetch_descriptions(self, folder: Path) -> bool:
        """Copies what describes the store into a folder; False if there is none yet."""
        try:
            if not self._files.exists(self._place("zarr.json")):
                return False
            below = self._files.glob(f"{self._root}/*/zarr.json")
            self._get(folder, [*below, self._place("zarr.json")])
        except OSError as error:
            raise self._failed("read", error) from error
        return True

    def fetch(self, folder: Path, keys: Iterable[str]) -> None:
        """Copies files into a folder, as far as they are there."""
        try:
            there = set(self._files.find(self._root))
            wanted = [place for place in map(self._place, keys) if place in there]
            for first in range(0, len(wanted), _AT_ONCE):
                self._get(folder, wanted[first : first + _AT_ONCE])
        except OSError as error:
            raise self._failed("read", error) from error

    def has(self, key: str) -> bool:
        """Whether there is a file."""
        try:
            return bool(self._files.exists(self._place(key)))
        except OSError as error:
            raise self._failed("read", error) from error

    def put(self, folder: Path, keys: Sequence[str]) -> None:
        """Copies files of a folder to the store, each whole or not at all, and the last when all others are there."""
        try:
            if not self._is_flat:
                for parent in {self._place(key).rsplit("/", 1)[0] for key in keys}:
                    self._files.makedirs(parent, exist_ok=True)
            for some in (keys[:-1], keys[-1:]):
                for first in range(0, len(some), _AT_ONCE):
                    self._files.pipe({self._place(key): (folder / key).read_bytes() for key in some[first : first + _AT_ONCE]})
        except OSError as error:
            raise self._failed("written", error) from error

    def drop(self, keys: Iterable[str]) -> None:
        """Deletes files that are there."""
        try:
            for key in keys:
                if self._files.exists(self._place(key)):
                    self._files.rm_file(self._place(key))
        except OSError as error:
            raise self._failed("written", error) from error

    def _place(self, key: str) -> str:
        return f"{self._root}/{key}"

    def _key(self, place: str) -> str:
        return place.removeprefix(self._root).lstrip("/")

    def _get(self, folder: Path, places: Sequence[str]) -> None:
        if not places:
            return
        for place, bytes_ in self._files.cat(list(places)).items():
            path = folder / self._key(place)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(bytes_)

    def _failed(self, how: str, error: OSError) -> MachineError:
        return MachineError(f"the store {self.url} cannot be {how} ({error})")


def options_text(options: Mapping[str, Any] | None) -> str:
    """What fsspec gets, as text that travels.

    Raises:
        InputError: It has something that is no text, number or list of these.
    """
    try:
        return json.dumps(dict(options or {}), sort_keys=True)
    except TypeError as error:
        raise InputError(f"'storage_options' cannot be sent to workers: {error}; give texts, numbers, lists and dictionaries") from error
