# SPDX-License-Identifier: Apache-2.0
"""Members on the workers of a Dask scheduler: the bits of a local ensemble, and one sentence where they cannot run."""

import os
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest
from dask_cluster import ROOT, cluster
from distributed import Client

import drill_twin as dt
from drill_twin.core.errors import RunError
from drill_twin.runs.ensemble import dask_workers

COARSE = {
    "numerics.elements": 8,
    "numerics.step": "10 ms",
    "rig.rotation.duration": 1.0,
    "rig.weight_on_bit.duration": 1.0,
}
VARY = {"seed": [1, 2, 3], "wob": [20, 40, 2e4]}


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    with cluster(tmp_path_factory.mktemp("dask")) as found:
        yield found


@pytest.fixture(scope="module")
def ensemble():
    return dt.Ensemble("pa6_bench", VARY, overrides=COARSE)


def test_workers_give_the_bits_of_this_process(dask, ensemble):
    workers = [dask.worker(), dask.worker()]
    ended = []
    far = ensemble.run(2.0, outputs=("findings", "marks"), dask=dask.address, progress=lambda *said: ended.append(said))
    near = ensemble.run(2.0, outputs=("findings", "marks"))
    assert np.array_equal(far["centre"], near["centre"], equal_nan=True)
    assert [one and one.to_dict() for one in far.summaries] == [one and one.to_dict() for one in near.summaries]
    assert far.failed == near.failed
    assert set(far.failed) == {2, 5, 8}
    assert ended[-1] == (9, 9)
    for worker in workers:
        worker.kill()
        worker.wait()


def test_a_worker_with_other_source_is_refused(dask, ensemble, tmp_path):
    shutil.copytree(ROOT / "drill_twin", tmp_path / "drill_twin", ignore=shutil.ignore_patterns("__pycache__"))
    criteria = tmp_path / "drill_twin" / "dynamics" / "twin" / "twin.py"
    criteria.write_text(criteria.read_text("utf-8") + "\nOTHER = 1\n", "utf-8")
    worker = dask.worker(tmp_path)
    with pytest.raises(RunError, match=r"expected source of the runs \w+ as the client, found \w+; install the same"):
        ensemble.run(2.0, dask=dask.address)
    worker.kill()
    worker.wait()


def test_without_workers_or_scheduler_it_says_so(dask, ensemble, monkeypatch):
    monkeypatch.setattr(dask_workers, "CONNECT", 2.0)
    with pytest.raises(RunError, match=r"expected workers of the Dask scheduler, found none for 2 s; start some with"):
        ensemble.run(2.0, dask=dask.address)
    for address in ("tcp://127.0.0.1:9", "nonsense://x", "host:abc"):
        with pytest.raises(RunError, match="expected a Dask scheduler, found none"):
            ensemble.run(2.0, dask=address)


MAP = {"wob": "1..40 N", "rpm": "30..180", "duration": 3.0, "steps": 8, "growth": False, "runs": 100}


def killing(after, *processes):
    """Progress of a map that kills processes after a number of runs."""

    def progress(_, ended, __):
        if ended >= after:
            for process in processes:
                process.kill()

    return progress


def made(dask, folder, **more):
    return dt.operating_map("pa6_bench", COARSE, folder=folder, dask=dask.address, **MAP, **more)


def lines(folder):
    """Runs in the journal."""
    return len((folder / "runs.jsonl").read_text("utf-8").splitlines()) - 1


@pytest.mark.long
def test_killed_workers_lose_nothing(dask, tmp_path, monkeypatch):
    """All are killed, then one of two: the map goes on, and is that of this process."""
    near = dt.operating_map("pa6_bench", COARSE, **MAP)
    monkeypatch.setattr(dask_workers, "PATIENCE", 5.0)
    with pytest.raises(RunError, match="expected workers of the Dask scheduler, found none for 5 s"):
        made(dask, tmp_path, progress=killing(20, dask.worker()))
    assert 20 <= lines(tmp_path) < len(near.records)
    staying = dask.worker()
    found = made(dask, tmp_path, progress=killing(40, dask.worker()))
    assert staying.poll() is None
    staying.kill()
    assert found.to_dict() == near.to_dict()
    assert lines(tmp_path) == len(near.records)


@pytest.mark.long
def test_a_lost_scheduler_and_workers_that_die_again_and_again_are_said(tmp_path, monkeypatch):
    with cluster(tmp_path) as lost:
        lost.worker()
        with pytest.raises(RunError, match="expected a Dask scheduler to the end, found its connection lost"):
            made(lost, tmp_path, progress=killing(40, lost.scheduler))
    assert lines(tmp_path) >= 40
    (tmp_path / "again").mkdir()
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    with cluster(tmp_path / "again") as broken:
        kill = killing(60, broken.worker())
        with pytest.raises(RunError, match="workers that outlive their members, found that 1 died in the same members"):
            made(broken, tmp_path, progress=kill)


def test_the_ports_of_a_cluster_of_ours_are_of_this_machine_alone(dask):
    """A scheduler and a worker run what anybody sends; by default both listen on all addresses."""
    psutil = pytest.importorskip("psutil", reason="needs psutil, as distributed does")
    worker = dask.worker()
    with Client(dask.address, timeout=60.0, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=60.0)
    for process in (dask.scheduler, worker):
        found = [one.laddr.ip for one in psutil.Process(process.pid).net_connections() if one.status == "LISTEN"]
        assert set(found) == {"127.0.0.1"}
    worker.kill()


RUN = """
import sys
import drill_twin as dt
found = dt.Ensemble("pa6_bench", {"seed": [1, 2]}, overrides=dict(one.split("=") for one in sys.argv[2:]))
print(found.run(0.1, dask=sys.argv[1]).failed)
"""


@pytest.mark.long
def test_tls_as_on_the_page(tmp_path, ensemble, monkeypatch):
    """The two files of `docs/ensembles.md`: with them all talk by TLS, and who has none runs nothing."""
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("needs openssl")
    page = (ROOT / "docs" / "ensembles.md").read_text("utf-8")
    command = next(line.removeprefix("$ ") for line in page.splitlines() if line.startswith("$ openssl"))
    subprocess.run(shlex.split(command), cwd=tmp_path, check=True, capture_output=True)
    settings = page.partition("```yaml\n")[2].partition("```")[0].replace("/etc/dask/", f"{tmp_path}/")
    file = tmp_path / "dask.yaml"
    file.write_text(settings, "utf-8")
    with cluster(tmp_path, "tls", DASK_CONFIG=str(file)) as found:
        found.worker()
        assert found.address.startswith("tls://127.0.0.1:")
        # A client in a process of its own, because it reads the settings of dask as it starts.
        words = [RUN, found.address, *(f"{key}={value}" for key, value in COARSE.items())]
        given = os.environ | {"PYTHONPATH": str(ROOT), "DASK_CONFIG": str(file)}
        done = subprocess.run(
            [sys.executable, "-c", *words], cwd=tmp_path, env=given, capture_output=True, text=True, check=False
        )
        assert done.stdout.strip() == "{}", done.stderr
        monkeypatch.setattr(dask_workers, "CONNECT", 2.0)
        for address in (found.address, found.address.replace("tls", "tcp")):
            with pytest.raises(RunError, match="expected a Dask scheduler, found none"):
                ensemble.run(0.1, dask=address)
