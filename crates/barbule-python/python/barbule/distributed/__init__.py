"""Campaigns, sweeps, comparisons and pictures on a cluster of Dask.

Each function is that of `barbule` with a `client`, and a place for results that all workers see: a folder of a shared file system or, for stores,
a URL such as ``s3://bucket/S.zarr``. Work is cut into tasks of a few seconds that run inside the workers' processes, one thread
each, on what each worker prepares once. Tasks return nothing but their number; results are in the store, so that killed workers
and stopped calls cost what was at work, and the same call goes on to the same bits.

Dask is not needed for the rest of the package: ``pip install 'barbule[distributed]'``.

Example:
    >>> import barbule.distributed, tempfile
    >>> from distributed import Client, LocalCluster
    >>> with (
    ...     LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
    ...     Client(cluster) as client,
    ...     tempfile.TemporaryDirectory() as folder,
    ... ):
    ...     barbule.distributed.simulate("starling", folder + "/S.zarr", client=client, thin=10, progress=False)
    ...     material = barbule.fit(folder + "/S.zarr")
    >>> len(material.wavelengths_nm)
    6
"""

from __future__ import annotations

from ._atlas import atlas
from ._calls import crystal, far_fields, spectrum
from ._campaign import characterize, simulate
from ._frames import render_frames
from ._picture import render
from ._validate import validate

__all__ = ["atlas", "characterize", "crystal", "far_fields", "render", "render_frames", "simulate", "spectrum", "validate"]
