# SPDX-License-Identifier: Apache-2.0
"""One compiled time loop for exactly the effects of a scene.

The loop is written once (`drill_twin.solve.midpoint`) and takes the effects as functions. For a set of effects a small
module is written that calls their functions in turn, and nothing else; numba compiles it and keeps the machine code
beside it. The module's name is a hash of every source it is built from, of the versions and of the processor, so stale
code cannot be met: an edit makes another name. Numbers, tables and sections are arguments, so they never compile.

An effect's file may define any of these functions; the loop calls those that exist:

* ``point(parameters, rod, here, h2, load, stiff)``: force per length on the string, at the Gauss points;
* ``section(parameters, rod, strain, h2, resultants)``: bending and twist of the section;
* ``stretch(parameters, element, axial, rate)``: viscous axial force and its slope;
* ``end(parameters, rod, command, time, h2, u, v, v_old, ends)``: forces at the bit and the top, as tangent and
  residual, shape (2, 7, 8);
* ``guide(parameters, rod, time, trial)``: velocities of held unknowns at mid-step, where they are not zero;
* ``done(parameters, rod, command, time, step, u, v)``: after a step was taken, for effects that remember something.
"""

import hashlib
import importlib.util
import inspect
import os
import platform
import sys
import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import cast

import llvmlite
import numba
import numpy as np

_FORMS = {
    "spatial": ("solve.work", "solve.spatial", "solve.assembly", "solve.blocks"),
    "lateral": ("solve.lateral", "solve.lateral_assembly", "solve.lateral_blocks"),
}
HOOKS = ("point", "section", "stretch", "end", "guide", "done")
_SOURCES = (
    "rod.jit", "rod.types", "rod.point", "rod.hole", "rod.bit", "rod.mesh", "rod.section", "rod.stretch",
    "solve.state", "solve.bit_frame", "solve.drive", "solve.midpoint", "solve.compose",
)  # fmt: skip


def cache_folder() -> Path:
    """Where compiled kernels are kept: ``$DRILL_TWIN_CACHE``, else the user's cache folder, else a temporary one."""
    named = os.environ.get("DRILL_TWIN_CACHE")
    base = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "drill_twin"
    try:
        base.mkdir(parents=True, exist_ok=True)
        if os.access(base, os.W_OK):
            return base
    except OSError:
        if named:
            raise
    return Path(tempfile.mkdtemp(prefix="drill_twin_kernels_"))


def effect_module(name: str) -> ModuleType:
    """The module of an effect, by its key in the scene."""
    return import_module(f"drill_twin.effects.{name}")


def fingerprint(effects: tuple[str, ...], form: str, hole: str) -> str:
    """Hash of all that decides the machine code: sources, kind of hole, versions, processor."""
    digest = hashlib.sha256(hole.encode())
    for name in (*_SOURCES, *_FORMS[form]):
        digest.update(inspect.getsource(import_module(f"drill_twin.{name}")).encode())
    for name in effects:
        digest.update(name.encode() + inspect.getsource(effect_module(name)).encode())
    for version in (platform.python_version(), numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(version.encode())
    cpu = llvmlite.binding
    digest.update(f"{cpu.get_host_cpu_name()} {sorted(cpu.get_host_cpu_features().items())}".encode())
    return digest.hexdigest()[:16]


def source(effects: tuple[str, ...], form: str) -> str:
    """The text of the module for a set of effects and a form of the string."""

    def calls(hook: str, line: str) -> str:
        names = [name for name in effects if hasattr(effect_module(name), hook)]
        return "\n".join("    " + line.format(name=name) for name in names) or "    pass"

    imports = "\n".join(f"from drill_twin.effects import {name}" for name in effects)
    fields = "\n".join(
        f"    {name}: {name}.Parameters" for name in effects if hasattr(effect_module(name), "Parameters")
    )
    return f'''"""The {form} time loop for: {", ".join(effects) or "no effects"}. Written by drill_twin; do not edit."""
from typing import NamedTuple

from numba import njit

from drill_twin.rod.jit import FLAGS
from drill_twin.solve.drive import Drive, rig_done, rig_ends
from drill_twin.solve import midpoint, {form}
{imports}


class Parameters(NamedTuple):
    drive: Drive
{fields}


@njit(**FLAGS)
def stretch_effects(parameters, element, axial, rate):
    force = 0.0
    slope = 0.0
{calls("stretch", "more = {name}.stretch(parameters, element, axial, rate); force += more[0]; slope += more[1]")}
    return force, slope


@njit(**FLAGS)
def section_effects(parameters, rod, strain, h2, resultants):
{calls("section", "{name}.section(parameters, rod, strain, h2, resultants)")}


@njit(**FLAGS)
def point_effects(parameters, rod, here, h2, load, stiff):
{calls("point", "{name}.point(parameters, rod, here, h2, load, stiff)")}


@njit(**FLAGS)
def end_effects(parameters, rod, command, time, h2, u, v, v_old, ends):
    rig_ends(parameters.drive, command, h2, u, v, v_old, ends)
{calls("end", "{name}.end(parameters, rod, command, time, h2, u, v, v_old, ends)")}


@njit(**FLAGS)
def guide_effects(parameters, rod, time, trial):
{calls("guide", "{name}.guide(parameters, rod, time, trial)")}


@njit(**FLAGS)
def done_effects(parameters, rod, command, time, step, u, v):
    rig_done(parameters.drive, step, u, v)
{calls("done", "{name}.done(parameters, rod, command, time, step, u, v)")}


effects = midpoint.Effects(
    stretch_effects, section_effects, point_effects, end_effects, guide_effects, done_effects
)
loop = midpoint.bind({form}.bind(effects), effects)


@njit(cache=True, **FLAGS)
def advance(parameters, rod, work, fixed, state, limits, command0, command1, start, end, counters):
    return loop(parameters, rod, work, fixed, state, limits, command0, command1, start, end, counters)
'''


def entry(module: ModuleType) -> Callable[..., int]:
    """``advance`` of a composed module; call it once with real arguments before.

    Past numba's dispatcher: with a second kernel in the process that takes 0.4 ms a call to find out again what the
    types are, more than a frame's motion.
    """
    compiled = list(module.advance.overloads.values())
    return cast("Callable[..., int]", compiled[0].entry_point if len(compiled) == 1 else module.advance)


def compose(effects: tuple[str, ...], form: str = "spatial", hole: str = "straight") -> ModuleType:
    """The module with ``advance`` and ``Parameters`` for a set of effects, compiled on first use.

    Args:
        effects: Scene keys in the order of the registry.
        form: "spatial", or "lateral" for a string that neither stretches nor twists.
        hole: "straight" or "curved": the types of the arguments decide what is compiled, and a module holds one kernel.
    """
    name = f"drill_twin_kernel_{fingerprint(effects, form, hole)}"
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        # Several nodes may start at once: write beside, then rename, so that nobody reads half a file.
        with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".part", delete=False) as part:
            part.write(source(effects, form))
        Path(part.name).replace(path)
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"the composed kernel {path} cannot be loaded; remove the file and start again")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
