# SPDX-License-Identifier: Apache-2.0
"""Shapes and ratios of the kernel's cost, never seconds; and the comparison of peers by the tool that is there."""

import json
import subprocess
import sys

import numpy as np
import pytest

from drill_twin.dynamics.discretisation.kernel_arguments import LATERAL, form_of
from drill_twin_evidence.benchmarks.faults_seeded.__main__ import ROOT
from drill_twin_evidence.benchmarks.faults_seeded.faults import FAULTS
from drill_twin_evidence.benchmarks.kernel.examples import EXAMPLES, forms_of, scene_with
from drill_twin_evidence.benchmarks.kernel.measure import least_cost
from drill_twin_evidence.benchmarks.peers.parts import PARTS
from drill_twin_evidence.benchmarks.peers.rod import rod_of, wall_force
from drill_twin_evidence.benchmarks.peers.rows import contact_time, path_error, result
from drill_twin_evidence.benchmarks.peers.run import TOOLS, Tool, missing, run_apart, run_rounds
from drill_twin_evidence.benchmarks.peers.summary import summary
from drill_twin_evidence.benchmarks.peers.tables import markdown
from drill_twin_evidence.benchmarks.peers.task import Motion, Task

SHORT: dict = {"scene": "pa6_bench", "changes": {"duration": "0.2 s"}}  # a set of effects that other tests compile too
FAR, BARE = "wall and wall_friction, far", "bare rod"


def motion(time, x, reach=0.0) -> Motion:
    """A motion whose mid-span goes along x."""
    x = np.asarray(x, float)
    return Motion(np.asarray(time, float), np.stack([x, 0.0 * x], 1), 0.0 * x, np.full(x.size, reach), 1.0, 10)


def test_cost_grows_linearly_with_elements():
    few, many = (least_cost(scene_with(FAR, LATERAL, n), repeats=12) for n in (50, 400))
    assert few.steps == many.steps
    assert many.elements == 8 * few.elements
    assert 0.3 < many.per_iteration / few.per_iteration < 2.0


def test_a_wall_that_is_not_touched_costs_little():
    bare, idle = (least_cost(scene_with(name, LATERAL, 200), repeats=12) for name in (BARE, FAR))
    assert idle.per_iteration < 2.5 * bare.per_iteration


def test_a_touched_wall_is_touched():
    touched = least_cost(scene_with("wall and wall_friction, touched", LATERAL, 50), repeats=2)
    idle = least_cost(scene_with(FAR, LATERAL, 50), repeats=2)
    assert touched.iterations > idle.iterations


def test_every_row_of_the_kernel_table_is_a_scene():
    for name in EXAMPLES:
        for form in forms_of(name):
            scene = scene_with(name, form, 20)
            assert form_of(scene) == form
            assert set(EXAMPLES[name]) <= set(scene.effect_names)


def test_path_error_ends_at_first_contact():
    true, other = motion([1, 2, 3], [0.0, 2.0, 1.0]), motion([1, 2, 3], [0.1, 2.0, 9.0])
    assert path_error(other, true, until=3.0) == pytest.approx(0.05)
    assert path_error(other, true, until=np.inf) == pytest.approx(4.0)
    assert path_error(motion([1], [0.0]), true, until=np.inf) is None


def test_first_contact_is_found_by_the_clearance():
    task = Task("drill_twin", 8, 2e-3)
    clearance = rod_of(task).law[0]
    assert clearance == pytest.approx(0.09 - 0.00825)
    assert contact_time(task, motion([1, 2], [0.0, 0.0], reach=1.01 * clearance)) == 1.0
    assert contact_time(task, motion([1, 2], [0.0, 0.0], reach=0.99 * clearance)) == np.inf


def test_the_shared_wall_pushes_inwards_and_brakes():
    law = rod_of(Task("drill_twin", 8, 2e-3)).law
    depth = 1e-3
    fx, fy, fz, couple = wall_force(law, law[0] + depth, 0.0, 0.0, 0.0, 0.1, 10.0)
    press = 1e7 * depth**1.5
    assert fx == pytest.approx(-press)
    slip = np.hypot(10.0 * 0.00825, 0.1)
    assert np.hypot(fy, fz) == pytest.approx(0.3 * press / (1.0 + 5.0 * slip), rel=1e-3)
    assert fy < 0.0
    assert fz < 0.0
    assert couple == pytest.approx(0.00825 * fy)
    assert wall_force(law, 0.0, 0.0, 0.0, 0.0, 0.1, 10.0) == (0.0, 0.0, 0.0, 0.0)


def test_a_task_runs_in_a_process_of_its_own():
    task = Task("drill_twin", 12, 5e-3, **SHORT)
    reference = run_apart(Task("drill_twin", 48, 5e-4, **SHORT))
    outcomes = run_rounds([task], 2, lambda _line: None)
    assert outcomes[0].motion.failure == ""
    assert len(outcomes[0].costs) == 2
    found = result(PARTS["contact"]._replace(tasks=(task,)), outcomes, reference, None, 2)
    json.dumps(found, allow_nan=False)
    (row,) = found["rows"]
    assert 1e-7 < row["error"] < 1e-2
    assert row["reached_s"] == pytest.approx(0.2)
    assert "| drill_twin, pa6_bench | 12 |" in markdown(found)


def test_a_run_over_its_limit_says_so():
    broken = run_apart(Task("drill_twin", 48, 5e-4, "pa6_bench", {"duration": "60 s"}, limit=0.2))
    assert "broken off" in broken.failure
    assert 0.0 < broken.time[-1] < 60.0


def test_a_tool_that_is_not_there_is_named_with_its_cure(monkeypatch):
    monkeypatch.setitem(TOOLS, "Other", Tool("other", "no_such_module_at_all", "other-package"))
    assert "pip install other-package" in missing("Other")
    assert missing("drill_twin") is None


def test_an_unknown_part_is_refused():
    command = [sys.executable, "-m", "drill_twin_evidence.benchmarks.peers", "nonsense"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "nonsense" in done.stderr


def peer_row(tool, cost, error, **more):
    return {"tool": tool, "scene": "peers", "plain": False, "failure": "", "cost": cost, "error": error} | more


def test_the_summary_has_errors_in_rows_of_their_own():
    rows = [
        peer_row("drill_twin", 0.02, 1e-5),
        peer_row("drill_twin", 0.01, 9e-5),
        peer_row("drill_twin", 0.005, 2e-4),
        peer_row("MuJoCo flex", 1.0, 3e-3),
        peer_row("MuJoCo flex", 4.0, 6e-4),
        peer_row("MuJoCo flex", 5.0, 1e-6, failure="not a number at 2 s"),
    ]
    lines = summary([{"part": "smooth", "rows": rows}]).splitlines()
    assert lines[0] == "| case | measure | drill_twin | MuJoCo (flex) |"
    assert lines[2:4] == [
        "| smooth motion | CPU s per simulated s | 0.01 | 4 |",
        "|  | error | 9.0e-05 | 6.0e-04 |",
    ]


def test_the_summary_of_a_tool_that_never_ended_has_no_number():
    rows = [peer_row("drill_twin", 0.1, 1e-4), peer_row("MuJoCo flex", 5.0, 1e-6, failure="not a number at 2 s")]
    assert "| buckled by 40 N | CPU s per simulated s | 0.1 | none ended |" in summary(
        [{"part": "buckled", "rows": rows}]
    )


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_seeded_fault_has_a_place_and_tests(fault):
    """A text that has moved or changed would be told by `make faults-seeded` only."""
    assert (ROOT / fault.file).read_text("utf-8").count(fault.old) == 1
    assert fault.old != fault.new
    assert (ROOT / fault.command[0]).is_file()
