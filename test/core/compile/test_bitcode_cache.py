# SPDX-License-Identifier: Apache-2.0
"""Compiled parts that kernels share: used by other kernels, never stale, made again where damaged or not ours."""

import re
import shutil
from pathlib import Path

import pytest
from forked import Forked
from numba import float64, types

from drill_twin.core.compile.inlined_compiler import lasting_name, type_text
from drill_twin.dynamics.solver import parameter_records
from drill_twin.dynamics.solver.parameter_records import fields_read, record_name
from drill_twin.physics.effects import wall_friction

ROOT = Path(__file__).parents[3]
# Compiles a kernel of its own for each factor, which calls a function of the package; prints what was compiled.
USE = '''
import sys
import numpy as np
from numba.core import event
from drill_twin.core.compile.kernel_cache import load_generated
compiled = []
class Listener(event.Listener):
    def on_start(self, found):
        name = found.data["dispatcher"].py_func.__name__
        compiled.extend([name] if name in ("total", "probe") else [])
    def on_end(self, found): pass
event.register("numba:compile", Listener())
module = load_generated("probe", f"""
from drill_twin.core.compile.jit import entry_kernel
from drill_twin.physics.model.survey import probe
@entry_kernel
def total(values):
    return {sys.argv[1]} * probe(values)
""")
print(module.total(np.arange(3.0)), *compiled)
'''
PART = """
from drill_twin.core.compile.jit import kernel
@kernel
def probe(values):
    return values[1] + values[2]
"""


@pytest.fixture
def package(tmp_path):
    """A copy of the package with a small function for kernels."""
    shutil.copytree(ROOT / "drill_twin", tmp_path / "drill_twin", ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "drill_twin" / "physics" / "model" / "survey.py").open("a", encoding="utf-8") as stream:
        stream.write(PART)
    return tmp_path


def use(package, factor):
    """What a kernel computes in a new process and what was compiled for it, and the lines on stderr."""
    cache = {"DRILL_TWIN_CACHE": str(package / "cache")}
    process = Forked(USE, [factor], environment=cache, forget=("drill_twin",), path=package)
    said, told = process.communicate()
    assert process.returncode == 0, told
    return said.strip(), told.splitlines()


def test_a_part_is_shared_made_again_and_never_stale(package):
    assert use(package, 1) == ("3.0 total probe", [])
    (part,) = (package / "cache").glob("*.bitcode")
    assert part.stat().st_mode & 0o777 == 0o600
    assert use(package, 2) == ("6.0 total", [])

    part.write_bytes(part.read_bytes()[:-1] + b"?")
    said, lines = use(package, 3)
    assert said == "9.0 total probe"
    assert len(lines) == 1
    assert re.search(r"bitcode: damaged, made again$", lines[0])

    part.chmod(0o666)
    said, lines = use(package, 8)
    assert said == "24.0 total probe"
    assert "of another user, or writable by others" in lines[0]

    source = package / "drill_twin" / "physics" / "model" / "survey.py"
    source.write_text(source.read_text("utf-8") + "# a comment\n", "utf-8")
    assert use(package, 9) == ("27.0 total", [])
    source.write_text(source.read_text("utf-8").replace("values[1] + values[2]", "values[1] - values[2]"), "utf-8")
    assert use(package, 10) == ("-10.0 total probe", [])
    imported = package / "drill_twin" / "core" / "arrays.py"
    imported.write_text(imported.read_text("utf-8") + "EDITED = 1\n", "utf-8")
    assert use(package, 11) == ("-11.0 total probe", [])


def test_types_are_told_apart_by_class_and_fields():
    """numba writes both as `wall__drag(float64 x 2)`; a part compiled for one must not be taken for the other."""
    one, other = parameter_records.wall__drag, parameter_records.drag__wall
    pair = [types.NamedUniTuple(float64, 2, found) for found in (one, other)]
    assert type_text(pair[:1]) != type_text(pair[1:])
    assert type_text([types.NamedUniTuple(pair[0], 2, one)]) != type_text([types.NamedUniTuple(pair[1], 2, one)])
    assert type_text([types.UniTuple(pair[0], 2)]) != type_text([types.UniTuple(pair[1], 2)])


@pytest.mark.parametrize(
    ("body", "fields"),
    [
        ("return p.wall.lever[0] * p.drag.linear", ("drag", "wall")),
        ("law = p.drag", ("drag",)),
        ("return other(p)", None),
        ("q = p", None),
        ("return getattr(p, 'drag')", None),
        ("pass", ()),
    ],
)
def test_fields_that_a_function_reads(body, fields, tmp_path, monkeypatch):
    name = f"probe_effect_{abs(hash(body))}"
    (tmp_path / f"{name}.py").write_text(f"def after_step(p, v):\n    {body}\n", "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    module = __import__(name)
    assert fields_read(module.after_step) == fields


def bind(called):
    """A function that is bound to a variable."""

    def after_step(p):
        return called(p)

    return after_step


def test_fields_that_a_bound_function_reads():
    assert fields_read(wall_friction.distributed_load_arctan) == ("wall", "wall_friction")


def test_functions_of_one_source_are_told_apart_by_their_constants():
    variants = ("", "_arctan", "_sliding", "_arctan_sliding")
    found = [getattr(wall_friction, f"distributed_load{variant}").py_func for variant in variants]
    assert len({lasting_name(function) for function in found}) == len(found)
    assert lasting_name(bind(3.0)) != lasting_name(bind(4.0))
    assert lasting_name(bind(lasting_name)) == ""


def test_names_of_records():
    assert record_name(("drag", "wall")) == "drag__wall"
    assert parameter_records.drag__wall._fields == ("drag", "wall")
    for fields in ((), ("drag__wall",), ("_drag",), ("drag", "")):
        assert record_name(fields) is None
    for name in ("_name", "__path__", "drag__"):
        assert not hasattr(parameter_records, name)


def test_without_the_inlined_compiler_all_is_compiled_by_numba(package):
    """The way back in `evidence/docs/private_compiler.md`, if a new numba cannot be used as this one is."""
    source = package / "drill_twin" / "core" / "compile" / "jit.py"
    text = source.read_text("utf-8")
    assert text.count('(function, "InlinedCompiler"') == 2
    source.write_text(text.replace('(function, "InlinedCompiler"', '(function, "EntryCompiler"'), "utf-8")
    assert use(package, 2) == ("6.0 total probe", [])
    assert not list((package / "cache").glob("*.bitcode"))
