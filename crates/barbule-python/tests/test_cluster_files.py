"""The files for clusters in examples/ pass the validation of the tools that take them."""

import importlib.util
import json
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

FILES = Path(__file__).parents[3] / "examples/cluster/dask"


@pytest.mark.parametrize("name, mark, wanted", [
    ("slurm", "#SBATCH", ["-p normal", "--cpus-per-task=16", "--mem=30G", "-t 02:00:00"]),
    ("pbs", "#PBS", ["-q workq", "-l select=1:ncpus=16:mem=32gb", "-l walltime=02:00:00"]),
])  # fmt: skip
def test_dask_jobqueue_makes_jobs_of_the_scripts(name, mark, wanted, tmp_path):
    pytest.importorskip("dask_jobqueue")
    with runpy.run_path(str(FILES / f"{name}.py"))["cluster"]() as cluster:
        script = cluster.job_script()
    for directive in wanted:
        assert f"{mark} {directive}" in script, script
    # One process with a slot for each core.
    assert "--nthreads 16" in script and "--nworkers" not in script and "--memory-limit" in script
    if shell := shutil.which("bash"):
        (tmp_path / "job.sh").write_text(script)
        subprocess.run([shell, "-n", tmp_path / "job.sh"], check=True)


def test_the_operator_takes_the_name_of_the_cluster():
    validation = pytest.importorskip("dask_kubernetes.operator.validation", exc_type=ImportError)
    yaml = pytest.importorskip("yaml")
    cluster = yaml.safe_load((FILES / "kubernetes.yaml").read_text(encoding="utf-8"))
    validation.validate_cluster_name(cluster["metadata"]["name"])


def without_references(schema):
    """A schema in which what is referred to may be anything: Kubernetes' own types are validated by themselves."""
    if isinstance(schema, dict):
        return {} if "$ref" in schema else {key: without_references(value) for key, value in schema.items()}
    return [without_references(value) for value in schema] if isinstance(schema, list) else schema


def test_the_operator_and_kubernetes_take_the_cluster():
    yaml = pytest.importorskip("yaml")
    jsonschema = pytest.importorskip("jsonschema")
    kubernetes = pytest.importorskip("kubernetes_validate")
    operator = importlib.util.find_spec("dask_kubernetes")
    if operator is None or operator.origin is None:
        pytest.skip("dask-kubernetes is not installed")
    cluster = yaml.safe_load((FILES / "kubernetes.yaml").read_text(encoding="utf-8"))
    folder = Path(operator.origin).parent / "operator/customresources"
    definition = yaml.safe_load((folder / "daskcluster.yaml").read_text(encoding="utf-8"))
    assert cluster["kind"] == definition["spec"]["names"]["kind"]
    version = definition["spec"]["versions"][0]
    assert cluster["apiVersion"] == f"{definition['spec']['group']}/{version['name']}"
    types = yaml.safe_load((folder / "templates.yaml").read_text(encoding="utf-8"))["definitions"]
    parts = {"DaskCluster": cluster, "DaskWorker": cluster["spec"]["worker"], "DaskScheduler": cluster["spec"]["scheduler"]}
    for name, part in parts.items():
        jsonschema.validate(part, without_references(types[f"dask.k8s.api.v1.{name}"]))
    latest = ".".join(kubernetes.latest_version().split(".")[:2])
    for kind, spec in (
        ("Pod", cluster["spec"]["worker"]["spec"]),
        ("Pod", cluster["spec"]["scheduler"]["spec"]),
        ("Service", cluster["spec"]["scheduler"]["service"]),
    ):
        resource = {"apiVersion": "v1", "kind": kind, "metadata": {"name": "feathers"}, "spec": spec}
        kubernetes.validate(json.loads(json.dumps(resource)), latest, strict=True)
    # Tasks are told what the container has, less what Python itself takes.
    limit = cluster["spec"]["worker"]["spec"]["containers"][0]["resources"]["limits"]
    assert limit == {"cpu": "8", "memory": "16Gi"}
