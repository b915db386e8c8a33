# SPDX-License-Identifier: Apache-2.0
"""Effect, bit law, schedule and command of another package: found, right, and stale kernels never run."""

import json
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from forked import Forked

from drill_twin.core.compile.source_hash import modules_reached, source_hash

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "docs" / "examples" / "drill_twin_example"
SCENE = """
import drill_twin as dt
scene = dt.build_scene(
    "foundation", base="pa6_bench",
    hole={"inclination": "90 deg"},
    string={"bit_end": "guided"},
    rig={"start": "equilibrium", "rotation": {"shape": "half_cosine", "initial": 0, "value": 2.0, "duration": "4 s"},
         "weight_on_bit": {"shape": "constant", "duration": "0 s", "value": 1.0}, "duration": "0.1 s"},
    effects={"lateral_spring": {"stiffness": "1000 N/m^2"}, "bit_torque_viscous": {"damping": "0.01 N m s/rad"},
             "bow": False, "eccentricity": False, "internal_damping": False, "drag": False, "wall": False,
             "wall_friction": False, "bit_friction": False},
)
"""
NAME = """
from drill_twin.physics.effects import Effect, effect_module
from drill_twin.core.compile.kernel_cache import fingerprint
from drill_twin.dynamics.solver.kernel_codegen import packages_of, source
effects = tuple(Effect(key) for key in scene.effect_names if hasattr(effect_module(key), "Parameters"))
name = "drill_twin_kernel_" + fingerprint(source(effects, "spatial"), "straight", packages=packages_of(effects))
"""
RUN = """
import json, sys
result = dt.Simulation(scene).run()
q = scene.string.sections[0].mass_per_length * 9.81
print(json.dumps({
    "name": name, "loaded": name in sys.modules, "deflection": result.centre[-1, 1, 0] / (q / 1000.0),
    "torque": result.bit_torque[-1], "effects": scene.effect_names}))
"""
SCHEDULE = """
import json
from drill_twin.scene.set_points import Schedule, extremes
ramped = dt.override(scene, {"rig.start": "axis"})
schedule = Schedule.from_scene(ramped)
print(json.dumps([schedule.at(time).rotation for time in (0.0, 2.0, 3.0, 9.0)] + [extremes(ramped).rotation]))
"""


@pytest.fixture(scope="module")
def target(tmp_path_factory):
    """Folder into which pip has installed the example."""
    folder = tmp_path_factory.mktemp("example")
    copy = shutil.copytree(EXAMPLE, folder / "source")
    install = ["install", "-q", "--no-deps", "--no-build-isolation", "--target", str(folder / "site"), str(copy)]
    subprocess.run([sys.executable, "-m", "pip", *install], check=True, timeout=300)
    return folder / "site"


def python(target: Path, code: str, warnings: str = "error") -> str:
    first = f"import warnings\nwarnings.filterwarnings({warnings!r}, category=UserWarning)\n"
    process = Forked(first + code, [], environment={}, forget=("drill_twin", "drill_twin_example"), path=target)
    said, told = process.communicate()
    assert process.returncode == 0, told
    return said


@pytest.fixture(scope="module")
def found(target):
    """What a run with the effects of the package gives."""
    return json.loads(python(target, SCENE + NAME + RUN))


def test_effect_and_bit_law_do_what_they_say(found):
    assert found["loaded"]
    assert found["effects"][-2:] == ["bit_torque_viscous", "lateral_spring"]
    # a long beam on an elastic foundation sinks by weight over stiffness, away from its ends
    assert found["deflection"] == pytest.approx(1.0, rel=0.01)
    assert found["torque"] == pytest.approx(-0.01 * 2.0, rel=1e-3)


def test_schedule_is_the_one_of_the_package(target):
    values = json.loads(python(target, SCENE + SCHEDULE))
    assert values == pytest.approx([0.0, 1.0, 1.0 + math.sqrt(0.5), 2.0, 2.0])


@pytest.mark.long
def test_an_edit_of_the_package_gives_another_kernel(target, found, tmp_path):
    edited = shutil.copytree(target, tmp_path / "site")
    file = edited / "drill_twin_example" / "lateral_spring.py"
    name = SCENE + NAME + "print(name)"
    assert python(edited, name).strip() == found["name"]
    text = file.read_text("utf-8")
    file.write_text(text.replace("load[1] -= k * here.y", "load[1] -= 2.0 * k * here.y"), "utf-8")
    assert file.read_text("utf-8") != text
    assert python(edited, name).strip() != found["name"]


def test_relative_imports_of_a_package_are_followed(tmp_path, monkeypatch):
    package = tmp_path / "relative_example"
    package.mkdir()
    (package / "__init__.py").write_text("", "utf-8")
    (package / "effect.py").write_text("from . import law\nfrom .numbers_ import GAIN\n", "utf-8")
    (package / "law.py").write_text("def force(x):\n    return 2.0 * x\n", "utf-8")
    (package / "numbers_.py").write_text("GAIN = 1.0\n", "utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    text, packages = "from relative_example import effect\n", ("relative_example",)
    assert set(modules_reached(text, packages)) == {
        f"relative_example.{name}" for name in ("effect", "law", "numbers_")
    }
    before = source_hash(text, packages)
    (package / "law.py").write_text("def force(x):\n    return 3.0 * x\n", "utf-8")
    assert source_hash(text, packages) != before


def said(target: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """What the command line says with the folder on its path."""
    return subprocess.run(
        [sys.executable, "-m", "drill_twin.cli", *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join((str(target), str(ROOT))), "COLUMNS": "200"},
        cwd=target, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


def test_command_is_one_of_drill_twin(target):
    done = said(target, "study", "clearance", "pa6_bench")
    assert (done.returncode, done.stdout, done.stderr) == (0, "section 1: 81.75 mm\n", "")
    listed = said(target, "study").stdout
    assert "Of the package drill_twin_example" in listed
    assert "Print the radial clearance" in listed


LOADED = """
import sys
from typer.main import get_command
from drill_twin.cli.app import app
group = get_command(app).get_command(None, "study")
for name in ("no such", "clearance"):
    assert (group.get_command(None, name) is None) == (name == "no such")
    print("drill_twin_example.clearance" in sys.modules)
"""


def test_a_package_is_imported_only_for_its_command(target):
    assert python(target, LOADED).split() == ["False", "True"]


LISTED = """
from drill_twin.physics.effects import EFFECTS, LEFT_OUT
import drill_twin as dt
print("lateral_spring" in EFFECTS, LEFT_OUT.get("lateral_spring", ""), sep=": ")
try:
    dt.load_scene("pa6_bench", overrides={"effects.lateral_spring.stiffness": "1 kN/m^2"})
except dt.SceneError as error:
    print(error)
"""


def test_a_misspelled_function_is_refused_with_the_nearest_name(target, tmp_path):
    site = shutil.copytree(target, tmp_path / "site")
    file = site / "drill_twin_example" / "lateral_spring.py"
    text = file.read_text("utf-8")
    file.write_text(text.replace("def distributed_load(", "def distributed_loads("), "utf-8")
    listed, refused = python(site, LISTED, warnings="ignore").splitlines()
    said = 'found "distributed_loads", which nothing calls, did you mean "distributed_load"?'
    assert listed.startswith(f"False: {said}")
    assert 'effects.lateral_spring: expected an effect that can be run, found "lateral_spring"' in refused
    assert f"which is left out: {said}" in refused


HELPERS = """

def stiffness_of(block):
    return block.stiffness

def _distributed_loads(block):
    return block.stiffness

def distributed_load_soft(parameters, rod, here, half_step, load, stiff):
    pass
"""


def test_helpers_and_variants_may_have_their_names(target, tmp_path):
    site = shutil.copytree(target, tmp_path / "site")
    with (site / "drill_twin_example" / "lateral_spring.py").open("a", encoding="utf-8") as file:
        file.write(HELPERS)
    assert python(site, LISTED) == "True: \n"


VARIANT = """
from drill_twin.dynamics.discretisation.kernel_arguments import effects_of
try:
    print(*map(str, effects_of(scene)))
except dt.RunError as error:
    print(error)
"""
SOFT = """    @property
    def variant(self) -> str:
        return "soft"

    stiffness: Annot"""


@pytest.mark.parametrize(("defined", "said"), [("soft", "lateral_spring:soft"), ("sfot", "distributed_load_soft")])
def test_a_variant_without_a_function_is_refused(target, tmp_path, defined, said):
    """It would be the default law, in silence."""
    site = shutil.copytree(target, tmp_path / "site")
    file = site / "drill_twin_example" / "lateral_spring.py"
    text = file.read_text("utf-8").replace("    stiffness: Annot", SOFT) + HELPERS.replace("_soft(", f"_{defined}(")
    file.write_text(text, "utf-8")
    assert said in python(site, SCENE + VARIANT)


@pytest.mark.parametrize(
    ("made", "code"), [("check_finite('/marks/state', np.array([np.nan]))", 1), ("read_clock(b'12')", 2)]
)
def test_a_result_that_is_not_finite_is_no_wrong_input(target, tmp_path, made, code):
    site = shutil.copytree(target, tmp_path / "site")
    info = site / "odd-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: odd\nVersion: 1.0\n", "utf-8")
    (info / "entry_points.txt").write_text("[drill_twin.commands]\nodd = odd_module:odd\n", "utf-8")
    lines = ["import numpy as np", "from drill_twin.io.messages.decode import read_clock",
             "from drill_twin.io.messages.cdr import check_finite", "def odd() -> None:", f"    {made}"]  # fmt: skip
    (site / "odd_module.py").write_text("\n".join(lines), "utf-8")
    done = said(site, "study", "odd")
    assert (done.returncode, done.stderr.count("\n")) == (code, 1), done.stderr


ALL_BROKEN = """
import contextlib, io
from drill_twin.cli import run_command
for words in (["study", "lost"], ["study", "odd"], ["scene", "check", "lost/scene"]):
    with contextlib.redirect_stderr(io.StringIO()) as told:
        code = run_command(words)
    print(f"{code}: {told.getvalue().splitlines()[-1]}")
"""


def test_a_broken_command_is_told_and_leaves_the_others(target, tmp_path):
    site = shutil.copytree(target, tmp_path / "site")
    broken = site / "broken-1.0.dist-info"
    broken.mkdir()
    (broken / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n", "utf-8")
    (broken / "entry_points.txt").write_text(
        "[drill_twin.commands]\nlost = no_such_module:lost\nodd = odd_module:odd\nclearance = odd_module:odd\n"
        "[drill_twin.scenes]\nlost = no_such_module:SCENES\n",
        "utf-8",
    )
    (site / "odd_module.py").write_text("def odd(given: int | str): ...\n", "utf-8")
    told = python(site, ALL_BROKEN)
    assert '2: drill-twin: error: expected the command "lost" of the package broken in no_such_module:lost' in told
    assert "of the package broken in odd_module:odd, found AssertionError" in told
    assert "2: drill-twin: error: lost/: expected the folder of scenes no_such_module:SCENES of another package" in told
    listed = said(site, "study")
    assert "Cannot be loaded" in listed.stdout
    assert listed.stderr.strip() == (
        'drill-twin: the command "clearance" of the package drill_twin_example is left out: there is a '
        "command of that name in broken"
    )
