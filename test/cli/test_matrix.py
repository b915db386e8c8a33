# SPDX-License-Identifier: Apache-2.0
"""Every shipped scene through every command that takes one, or a bag of its run: it ends well, or with one sentence.

Runs are short and studies small, meshes those of the scenes. A third of the pairs is long, each command with a third
of the scenes and each scene with a third of the commands; the others run each night.
"""

from itertools import product
from pathlib import Path

import pytest

from drill_twin.cli import run_command
from drill_twin.scene import load_scene

CONFIG = Path(__file__).resolve().parents[2] / "config"
SCENES = {path.stem: path for room in ("scenes", "wells") for path in sorted((CONFIG / room).glob("*.yaml"))}
LONG_ONES = {"extended_reach": "0.1 s"}
"""Simulated time of the slow scenes; the others run for 0.5 s."""
MUST_RUN = {f"{command} {name}" for command in ("scene", "statics", "modes") for name in ("s_shaped", "pa6_bench")}
"""Pairs that must not be refused, so that the matrix is no list of refusals."""
LIGHT = [("pa6_bench", "analyze"), ("two_mass", "rerun"), ("s_shaped", "check"), ("drillbotics", "statics"),
         ("pa6_calibrated", "estimate"), ("ufrj_rig", "modes")]  # fmt: skip
"""Pairs of the normal run; the others are long."""
OF_SCENE = {
    "check": ("scene", "check", "{scene}"),
    "statics": ("statics", "{scene}"),
    "modes": ("modes", "{scene}", "--out", "{out}"),
    "whirl": ("whirl", "{scene}", "--starts", "0"),
    "equilibrium": ("run", "{scene}", "--set", "rig.start=equilibrium", "--duration", "{time}", "--out", "{out}"),
    "compare": ("compare", "{scene}", "{scene},numerics.seed=7", "--duration", "{time}", "--out", "{out}"),
    "cost": ("cost", "{scene}", "--elements", "20,30", "--duration", "{time}", "--repeats", "0", "--out", "{out}"),
    "map": ("map", "{scene}", "--wob", "{wob}", "--rpm", "60..120", "--runs", "4", "--steps", "2", "--duration",
            "{time}", "--out", "{out}"),
}  # fmt: skip
NUMBER = ("--scene", "{scene}", "--free", "load_factor=0.8..1.2", "--channel", "torque")
OF_BAG = {
    "analyze": ("analyze", "{bag}"),
    "report": ("report", "{bag}", "--out", "{out}"),
    "rerun": ("rerun", "{bag}", "--out", "{out}"),
    "export": ("export", "{bag}", "--csv", "--out", "{out}"),
    "drillbotics": ("export", "--drillbotics", "{bag}", "--out", "{out}"),
    "fit": ("fit", "{bag}", *NUMBER, "--rounds", "1", "--members", "8"),
    "estimate": ("estimate", "{bag}", *NUMBER, "--members", "4", "--window", "0.1"),
}  # fmt: skip


@pytest.fixture(scope="module")
def bag_of(tmp_path_factory):
    """Folder of a short run of a scene, made once."""
    made: dict[str, Path] = {}

    def of(name: str) -> Path:
        if name not in made:
            bag = tmp_path_factory.mktemp("runs") / name
            record = load_scene(SCENES[name]).rig.table
            if record is not None and not record.file:
                pytest.skip("the record that the scene plays is not part of the package")
            line = ("run", SCENES[name], "--duration", LONG_ONES.get(name, "0.5 s"), "--out", bag)
            assert run_command([str(word) for word in line]) == 0
            made[name] = bag
        return made[name]

    return of


@pytest.fixture
def ends_well(bag_of, tmp_path, monkeypatch, capsys):
    """Run a command on a scene; an exception that is no sentence fails the test by itself."""
    monkeypatch.chdir(tmp_path)

    def ends(name: str, line: tuple[str, ...]) -> None:
        bag = bag_of(name) if "{bag}" in line else ""
        weight = load_scene(SCENES[name]).rig.weight_on_bit.value
        capsys.readouterr()
        wob = f"{0.5 * abs(weight) or 1.0}..{abs(weight) or 2.0} N"
        values = {"scene": SCENES[name], "bag": bag, "out": tmp_path / "out", "time": LONG_ONES.get(name, "0.5 s"),
                  "wob": wob}  # fmt: skip
        code = run_command([word.format(**values) for word in line])
        said = capsys.readouterr()
        last = said.err.strip().splitlines()[-1:] or [""]
        assert "Traceback" not in said.out + said.err
        assert code == 0 or (code in {1, 2} and last[0].startswith("drill-twin: error: ")), said.err
        assert code == 0 or f"{line[0]} {name}" not in MUST_RUN, said.err

    return ends


@pytest.mark.parametrize(("name", "command"), LIGHT)
def test_shipped_scenes_go_through_commands(ends_well, name, command):
    ends_well(name, (OF_SCENE | OF_BAG)[command])


def pairs():
    """Each scene with each command."""
    for (i, name), (j, command) in product(enumerate(SCENES), enumerate([*OF_SCENE, *OF_BAG])):
        held = (i + j) % 3 == 0 or f"{OF_SCENE.get(command, ('',))[0]} {name}" in MUST_RUN
        yield pytest.param(name, command, marks=pytest.mark.long if held else pytest.mark.nightly)


@pytest.mark.parametrize(("name", "command"), list(pairs()))
def test_each_shipped_scene_goes_through_each_command(ends_well, name, command):
    ends_well(name, (OF_SCENE | OF_BAG)[command])
