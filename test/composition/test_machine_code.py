# SPDX-License-Identifier: Apache-2.0
"""An effect that is off is not in the compiled code: the machine code is the same whether its file is there or not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drill_twin.solve import compose, keep

ROOT = Path(__file__).resolve().parents[2]

# Compiles the kernel of a scene and prints a hash of its machine code. The files of other effects are hidden once the
# scene is read: whatever the composed kernel wanted of them would now fail.
PROGRAM = """
import hashlib, re, sys
from drill_twin.effects import BLOCKS
from drill_twin.study.verify.rods import rod_scene
from drill_twin.schedule.command import Command
effects = {name: {"linear": 0.1} for name in sys.argv[2:]}
scene = rod_scene(effects=effects, elements=8, step=1e-3, form=sys.argv[1], weight_on_bit=1.0)
from drill_twin.twin import Twin
if HIDE:
    used = {*scene.effect_names, "block", "wall", "gravity"}  # the reader of wall forces and the start know these two
    for name in [*sys.modules]:
        if name.startswith("drill_twin.effects.") and name.rpartition(".")[2] not in used:
            sys.modules[name] = None
twin = Twin(scene)
twin.step(Command(1.0, 1.0), 0.01)
(text,) = twin.machine.kernel.advance.inspect_asm().values()
# Instructions and registers; names hold running numbers of all functions that numba has met in the process.
lines = [line for line in text.splitlines() if re.match(r"\\t[a-z]", line)]
code = [" ".join(re.findall(r"^[a-z0-9]+|%[a-z0-9]+", line.strip())) for line in lines]
print(hashlib.sha256("\\n".join(code).encode()).hexdigest(), len(code))
"""


def machine_code(folder: Path, form: str, *effects: str, hide: bool = False) -> str:
    """Hash and length of the machine code of a scene's kernel, compiled in a process and a cache of its own."""
    environment = dict(os.environ, PYTHONPATH=str(ROOT), DRILL_TWIN_CACHE=str(folder))
    program = PROGRAM.replace("HIDE", str(hide))
    done = subprocess.run(
        [sys.executable, "-c", program, form, *effects], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("form", ["lateral", pytest.param("spatial", marks=pytest.mark.long)])
def test_what_is_off_is_not_in_the_machine_code(tmp_path, form):
    bare = machine_code(tmp_path / "all", form)
    assert machine_code(tmp_path / "hidden", form, hide=True) == bare
    assert machine_code(tmp_path / "drag", form, "drag") != bare


def test_a_kernel_is_named_by_its_own_sources(monkeypatch):
    """Editing an effect renames the kernels with it and no other."""
    bow = compose.effect_module("bow")
    before = {
        effects: compose.fingerprint(effects, "spatial", "straight") for effects in ((), ("drag",), ("bow", "drag"))
    }
    real = keep.inspect.getsource

    def edited(module):
        return real(module) + ("\n# edited" if module is bow else "")

    monkeypatch.setattr(keep.inspect, "getsource", edited)
    after = {effects: compose.fingerprint(effects, "spatial", "straight") for effects in before}
    assert after[()] == before[()]
    assert after[("drag",)] == before[("drag",)]
    assert after[("bow", "drag")] != before[("bow", "drag")]
