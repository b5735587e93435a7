"""A starling's material on a PBS cluster, by dask-jobqueue.

    pip install 'barbule[distributed]' dask-jobqueue
    python pbs.py

Adapt what is marked. Run again after whatever stopped it; what is in the store is not computed again.
"""

from __future__ import annotations

import os

from dask_jobqueue import PBSCluster


def cluster() -> PBSCluster:
    """Jobs of 16 cores, each one process with 16 slots: its instances are prepared once, and each task has one thread."""
    return PBSCluster(
        queue="workq",  # yours
        account=None,  # yours, where jobs need one
        cores=16,
        processes=1,
        memory="32GB",
        resource_spec="select=1:ncpus=16:mem=32gb",
        walltime="02:00:00",
        # A job whose time ends stops taking tasks before it is killed. The resource is the memory that tasks may take, bytes.
        worker_extra_args=["--lifetime", "110m", "--lifetime-stagger", "5m", "--resources", "barbule-memory=30e9"],
        local_directory=os.environ.get("TMPDIR", "/tmp"),
    )


def main() -> None:
    """Up to ten jobs, 160 slots; those whose time is over are followed by others while there is work."""
    import barbule
    from distributed import Client

    with cluster() as jobs, Client(jobs) as client:
        jobs.adapt(minimum_jobs=1, maximum_jobs=10)
        client.wait_for_workers(1)
        # A folder that every node sees.
        material = barbule.distributed.characterize("starling:green", client=client, store="starling-green.zarr")
        material.save("starling-green.barbule")


if __name__ == "__main__":
    main()
