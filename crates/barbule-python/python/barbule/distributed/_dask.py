"""Dask, where it is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ..errors import InputError


def dask_distributed() -> Any:
    """The module `distributed`.

    Raises:
        InputError: It is not installed.
    """
    return needed("distributed", "work on a cluster")


def needed(module: str, what: str) -> Any:
    """A module that the package does not depend on.

    Raises:
        InputError: It is not installed.
    """
    try:
        return import_module(module)
    except ImportError as missing:
        raise InputError(
            f"{what} needs the module '{module}', which cannot be imported ({missing}); pip install 'barbule[distributed]'"
        ) from missing


def checked_client(client: Any) -> Any:
    """A client of Dask that waits for what it is asked.

    Raises:
        InputError: It is none, or asynchronous.
    """
    distributed = dask_distributed()
    if not isinstance(client, distributed.Client):
        raise InputError(f"'client' is a {type(client).__name__}; give a distributed.Client")
    if client.asynchronous:
        raise InputError("'client' is asynchronous; give one that is made without asynchronous=True, and call from a thread")
    return client
