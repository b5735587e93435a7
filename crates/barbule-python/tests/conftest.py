"""What several files of tests share."""

import pytest


@pytest.fixture(scope="session")
def client():
    """A client of a cluster of two processes with a slot each."""
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    with (
        # Workers that were killed take their time to come back where much else is done.
        dask.config.set({"distributed.deploy.lost-worker-timeout": "10 minutes"}),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client
