# SPDX-License-Identifier: Apache-2.0
"""An effect that is off is not in the compiled code: the machine code is the same whether its file is there or not."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from forked import Forked
from variants import long_one_of

from drill_twin.core.compile.source_hash import modules_reached
from drill_twin.dynamics.solver import kernel_codegen
from drill_twin.physics.effects import EFFECTS, Effect

ROOT = Path(__file__).resolve().parents[3]

# Compiles the kernel of a scene and prints a hash of its machine code. The files of other effects are hidden once the
# scene is read: whatever the composed kernel wanted of them would now fail.
PROGRAM = """
import hashlib, re, sys
from drill_twin.physics.effects import EFFECTS
from rod_scenes import rod_scene
from drill_twin.scene.set_points.command import Command
effects = {name: {"linear": 0.1} for name in sys.argv[2:]}
scene = rod_scene(effects=effects, elements=8, step=1e-3, form=sys.argv[1], weight_on_bit=1.0)
from drill_twin.dynamics.twin.twin import Twin
if HIDE:
    used = {*scene.effect_names, "config", "wall", "gravity"}  # the reader of wall forces and the start know these two
    for name in [*sys.modules]:
        if name.startswith("drill_twin.physics.effects.") and name.rpartition(".")[2] not in used:
            sys.modules[name] = None
twin = Twin(scene)
twin.advance(Command(1.0, 1.0), 0.01)
(text,) = twin.dynamics.kernel.run.inspect_asm().values()
# Instructions and registers; names hold running numbers of all functions that numba has met in the process.
lines = [line for line in text.splitlines() if re.match(r"\\t[a-z]", line)]
code = [" ".join(re.findall(r"^[a-z0-9]+|%[a-z0-9]+", line.strip())) for line in lines]
print(hashlib.sha256("\\n".join(code).encode()).hexdigest(), len(code))
"""


def machine_code(folder: Path, form: str, *effects: str, hide: bool = False) -> str:
    """Hash and length of the machine code of a scene's kernel, compiled in a process and a cache of its own."""
    environment = dict(
        os.environ, PYTHONPATH=os.pathsep.join((str(ROOT), str(ROOT / "test"))), DRILL_TWIN_CACHE=str(folder)
    )
    program = PROGRAM.replace("HIDE", str(hide))
    done = subprocess.run(
        [sys.executable, "-c", program, form, *effects], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("form", ["lateral", "spatial"])
@pytest.mark.parametrize("on", [(), ("drag",), ("drag", "internal_damping")])
def test_a_kernel_reaches_the_source_of_its_own_effects_only(form, on):
    """What is compiled is compiled from these; the machine code itself is compared in a long test."""
    reached = modules_reached(kernel_codegen.source([*map(Effect, on)], form))
    assert {name for name in EFFECTS if f"drill_twin.physics.effects.{name}" in reached} == set(on)


@pytest.mark.parametrize("form", long_one_of(2, ["spatial", "lateral"]))
def test_what_is_off_is_not_in_the_machine_code(tmp_path, form):
    bare = machine_code(tmp_path / "all", form)
    assert machine_code(tmp_path / "hidden", form, hide=True) == bare
    assert machine_code(tmp_path / "all", form, "drag") != bare


# Edits each source of a copy of the package in turn, and prints which kernels get another name by it.
EDITS = """
import importlib.util, json, pathlib
from drill_twin.core.compile import kernel_cache
from drill_twin.dynamics.solver import kernel_codegen
from drill_twin.core.compile.source_hash import modules_reached
from drill_twin.physics.effects import Effect
sets = {"bare": (), "drag": ("drag",), "bow": ("bow", "drag")}
text = {name: kernel_codegen.source([*map(Effect, effects)], "spatial") for name, effects in sets.items()}
def names():
    return {name: kernel_cache.fingerprint(source) for name, source in text.items()}
before, told = names(), {}
for module in modules_reached(text["bow"]):
    path = pathlib.Path(importlib.util.find_spec(module).origin)
    source = path.read_text("utf-8")
    changed = []
    for edit in ("\\n# a comment\\n", "\\n_EDITED = 1\\n"):
        path.write_text(source + edit, "utf-8")
        after = names()
        changed.append([name for name in sets if after[name] != before[name]])
    path.write_text(source, "utf-8")
    told[module] = changed
print(json.dumps(told))
"""


def test_a_kernel_is_named_by_every_source_that_it_reaches(tmp_path):
    """An edit of any of them gives another name to the kernels that reach it and to no other; a comment does not."""
    shutil.copytree(ROOT / "drill_twin", tmp_path / "drill_twin", ignore=shutil.ignore_patterns("__pycache__"))
    process = Forked(EDITS, [], environment={}, forget=("drill_twin",), path=tmp_path)
    said, error = process.communicate()
    assert process.returncode == 0, error
    told = json.loads(said)
    wanted = {
        "drill_twin.physics.effects.bow",
        "drill_twin.physics.effects.drag",
        "drill_twin.dynamics.solver.midpoint",
        "drill_twin.physics.model.section",
    }
    assert wanted <= set(told)
    frames = {f"drill_twin.dynamics.twin.{name}" for name in ("frame", "frame_kernel", "observation", "state_judge")}
    assert {name for name in told if name.startswith(("drill_twin.scene", "drill_twin.dynamics.twin"))} == frames
    only = {"drill_twin.physics.effects.bow": ["bow"], "drill_twin.physics.effects.drag": ["drag", "bow"]}
    only["drill_twin.physics.effects.random_draws"] = ["bow"]
    shared = ("drill_twin.core", "drill_twin.dynamics.solver", "drill_twin.physics.model")
    # drag takes numbers of its block alone, nothing of the model
    of_one = {"drill_twin.physics.model.mesh", "drill_twin.physics.model.discrete_model"}
    for module, (by_comment, by_edit) in told.items():
        assert not by_comment, module
        assert by_edit == only.get(module, by_edit), module
        assert "bow" in by_edit, module
        if module.startswith(shared) and module not in of_one:
            assert {"drag", "bow"} <= set(by_edit), module
