# SPDX-License-Identifier: Apache-2.0
"""Operating map: what it says of a set-point, and its file."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from drill_twin.api.scenes import Quantity, in_si
from drill_twin.core.arrays import Mask
from drill_twin.core.errors import ArgumentError, SceneError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.table import Table
from drill_twin.core.units import show
from drill_twin.core.units.dimension import ANGULAR_SPEED, FORCE
from drill_twin.core.units.system import UnitSystem
from drill_twin.io.messages.topic_words import digest_of
from drill_twin.scene import Scene
from drill_twin.scene.load import parse_scene
from drill_twin.scene.problems import path_text
from drill_twin_studies.maps.fields import MapFields
from drill_twin_studies.maps.grounds import grounds
from drill_twin_studies.maps.plane import Node, Plane, Span
from drill_twin_studies.maps.regimes import REGIMES, Regime
from drill_twin_studies.maps.runs import Key, RunOfFile, RunRecord, values_of

FORMAT = 3
_FILE = ForeignFile("the map.json of `drill-twin map`", 256_000_000, ArgumentError)


Number = Annotated[float, Field(ge=-1e15, le=1e15)]
"""Number of a file: no quantity of a string in SI is larger, and the product of two is finite."""
_Grid = Sequence[Sequence[Number]]


class MapFile(BaseModel):
    """Fields of `map.json` that are read; all others follow from them."""

    format: Literal[3]
    scene_name: str
    digest: str
    scene: str
    weight: Annotated[tuple[Number, Number], Field(alias="weight_on_bit_N")]
    speed: Annotated[tuple[Number, Number], Field(alias="rotation_rad_s")]
    steps: int
    duration_s: Annotated[Number, Field(gt=0.0)]
    calm_for_s: Annotated[Number, Field(ge=0.0)]
    clean_checks: Annotated[int, Field(ge=0, le=1_000_000)]
    draws: Sequence[Mapping[str, Number | str]]
    notes: Sequence[str]
    growth: _Grid
    torsional_growth: _Grid
    runs: Sequence[RunOfFile]


class Margin(NamedTuple):
    """Distance of a set-point to the boundary of calm operation; negative where it is beyond."""

    weight: float
    """Distance along the weight on bit [N]; infinite where the range has no boundary there."""
    speed: float
    """Distance along the speed [rad/s]; infinite where the range has no boundary there."""
    share: float
    """Shortest distance, as a share of both ranges; infinite where they have no boundary."""

    def text(self, units: UnitSystem) -> str:
        """Distance along each axis that meets the boundary; empty without one."""
        both = ((self.weight, "force"), (self.speed, "rotation"))
        return " or ".join(units.text(abs(value), quantity, ".3g") for value, quantity in both if math.isfinite(value))


@dataclass(frozen=True)
class OperatingMap(MapFields):
    """Regimes over weight on bit and speed: windows that stay calm, margins of a set-point, and the file."""

    def __repr__(self) -> str:
        """One line in place of all fields, which hold each run."""
        return f"OperatingMap({self.name}: {self.said_runs}; calm windows: {len(self.windows)})"

    @property
    def said_runs(self) -> str:
        """Runs of the map, and checks, in words."""
        checks = len(self.checks)
        said = f"{len(self.records) - checks} runs of {self.duration:g} s from rest"
        return f"{said}, and {checks} checks of {self.asked:g} s" if checks else said

    @property
    def basis(self) -> Sequence[str]:
        """Grounds of the windows, as sentences; empty without windows."""
        return list(grounds(self))

    # --- at a set-point -------------------------------------------------------------------------------------------

    def contains(self, weight: float, speed: float) -> bool:
        """The set-point [N], [rad/s] lies in the ranges."""
        return all(0.0 <= place <= self.plane.steps for place in self.plane.place(weight, speed))

    def node(self, weight: float, speed: float) -> Node:
        """Nearest node of a set-point."""
        i, j = (min(max(round(place), 0), self.plane.steps) for place in self.plane.place(weight, speed))
        return i, j

    def is_known(self, weight: float, speed: float) -> bool:
        """The set-point [N], [rad/s] lies in or on the edge of a known cell."""
        return bool(self.known[self.plane.cells_at(self.plane.place(weight, speed))].any())

    def regime(self, weight: Quantity, speed: Quantity) -> Regime:
        """Regime from rest at a set-point: text with units, as "5 N" and "120 rpm", or numbers [N], [rad/s].

        Raises:
            ArgumentError: The set-point lies outside the ranges, or a text is no force or no speed.
        """
        return REGIMES[int(self.regimes[self.node(*self._inside(weight, speed))])]

    def margin(self, weight: Quantity, speed: Quantity) -> Margin | None:
        """Distance of a set-point, given as for `regime`, to the boundary of calm operation; None: nowhere is it calm.

        Raises:
            ArgumentError: As for `regime`.
        """
        found = self.margin_of(self.calm, *self._inside(weight, speed))
        return found if self.calm.any() else None

    def margin_of(self, flags: Mask, weight: float, speed: float) -> Margin:
        """Distance of a set-point [N], [rad/s] in the ranges to the boundary of flagged nodes; negative outside it."""
        i, j = self.node(weight, speed)
        place = np.array(self.plane.place(weight, speed))
        sign = 1.0 if flags[i, j] else -1.0
        other = np.argwhere(flags != flags[i, j]).astype(float)
        if not other.size:
            return Margin(*(sign * math.inf,) * 3)
        step = (self.plane.weight.high - self.plane.weight.low, self.plane.speed.high - self.plane.speed.low)
        along = [
            sign * max(float(np.min(np.abs(line - place[axis]), initial=math.inf)) - 0.5, 0.0)
            for axis, line in ((0, other[other[:, 1] == j, 0]), (1, other[other[:, 0] == i, 1]))
        ]
        nearest = sign * max(float(np.hypot(*(other - place).T).min()) - 0.5, 0.0)
        n = self.plane.steps
        return Margin(along[0] / n * step[0], along[1] / n * step[1], nearest / n)

    def _inside(self, load: Quantity, turn: Quantity) -> tuple[float, float]:
        """Set-point [N], [rad/s] of two arguments, if it lies in the ranges."""
        weight, speed = in_si("weight", load, FORCE), in_si("speed", turn, ANGULAR_SPEED)
        if not self.contains(weight, speed):
            low, high = self.plane.weight, self.plane.speed
            raise ArgumentError(
                f"expected a set-point of the map, {self.units.span(*low, 'force')} and "
                f"{self.units.span(*high, 'rotation')}, found {self.units.set_point(weight, speed)}"
            )
        return weight, speed

    # --- file -----------------------------------------------------------------------------------------------------

    def to_dict(self) -> dict[str, Any]:
        """Plain types for JSON: what `from_dict` reads, and boundaries and window for other readers."""
        return {
            "format": FORMAT,
            "scene_name": self.name,
            "digest": self.digest,
            "duration_s": self.duration,
            "weight_on_bit_N": list(self.plane.weight),
            "rotation_rad_s": list(self.plane.speed),
            "steps": self.plane.steps,
            "regimes": [regime.value for regime in REGIMES],
            "draws": [dict(draw) for draw in self.draws],
            "notes": list(self.notes),
            "calm_for_s": self.asked,
            "clean_checks": self.clean_checks,
            "safe_windows": [
                {"weight_on_bit_N": list(window.weight), "rotation_rad_s": list(window.speed)}
                for window in self.windows
            ],
            "windows_rest_on": list(self.basis),
            "onset_boundary": self.lines(self.whirls),
            "end_of_whirl_boundary": self.lines(self.keeps_whirling) if self.has_second_boundary else [],
            "growth": [list(row) for row in self.growth],
            "torsional_growth": [list(row) for row in self.torsional],
            "runs": [
                {"node": [key.i, key.j], "draw": key.draw, "finer": key.finer,
                 "origin": None if key.origin is None else list(key.origin), **record.to_dict()}
                for key, record in self.records.items()
            ],
            "scene": self.scene,
        }  # fmt: skip

    @classmethod
    def from_json(cls, text: bytes) -> Self:
        """Inverse of `to_dict`, from its JSON.

        Raises:
            ValidationError, ArgumentError, SceneError: A field is missing, or has what no map has.
        """
        file = MapFile.model_validate_json(text, strict=True)
        plane = Plane(Span(*file.weight), Span(*file.speed), file.steps).checked()
        parse_scene(file.scene)
        points = len(file.growth)
        for name, grid in (("growth", file.growth), ("torsional_growth", file.torsional_growth)):
            if grid and (points < 2 or [len(row) for row in grid] != [points] * points):
                raise ArgumentError(
                    f"{name}: expected as many rows as columns, and as many as growth has, 2 at least, found others"
                )
        records: dict[Key, RunRecord] = {}
        for number, run in enumerate(file.runs):
            ends = max(run.node) <= plane.steps * run.finer and max(run.origin or (0,)) <= plane.steps
            if not ends or run.draw >= max(1, len(file.draws)):
                raise ArgumentError(f"runs[{number}]: expected a node of the lattice and a draw, found {run.key}")
            records[run.key] = run.record
        if not any(key.searches and key.draw == 0 for key in records):
            raise ArgumentError("runs: expected one or more runs from rest, found none")
        return cls(file.scene_name, file.digest, file.scene, plane, file.duration_s, file.draws, records, file.notes,
                   file.growth, file.torsional_growth, file.calm_for_s, file.clean_checks)  # fmt: skip

    def check_scene(self, scene: Scene) -> None:
        """Check that the map is of a scene.

        Raises:
            ArgumentError: String, hole, top drive or effects of the scene have other numbers.
        """
        if digest_of(scene) != self.digest:
            raise ArgumentError(
                f"expected a map of {scene.name}, found a map of {self.name} with other numbers of string, hole or "
                f"effects; make one with `drill-twin map {scene.name}`"
            )

    def csv(self) -> str:
        """Table of the runs, one a line."""
        columns = ("onset_s", "whirl_hz", "ratio", "bit", "radius", "wall_force", "torque_swing", "bending_stress",
                   "lateral_rms_g", "lateral_peak_g", "decided_by", "unsettled", "growth",
                   "bit_index", "top_index")  # fmt: skip
        varied = sorted({name for draw in self.draws for name in draw})
        rows = []
        for key, record in self.records.items():
            origin = ("", "") if key.origin is None else self.plane.command(key.origin)
            plain = record.to_dict()
            if record.regime is Regime.SMOOTH:  # the whirl that a run came from has died
                plain.pop("onset_s", None)
            rows.append((
                *self.plane.command(key.place), key.length(self.duration, self.asked), key.draw, *origin,
                *(self.draws[key.draw].get(name, "") for name in varied),
                record.regime.value, "unknown" if record.severity is None else record.severity.word,
                *(plain.get(name, "") for name in columns), record.failure,
            ))  # fmt: skip
        heads = (
            "weight_on_bit_N", "rotation_rad_s", "duration_s", "draw", "from_weight_on_bit_N", "from_rotation_rad_s",
            *varied, "regime", "severity", *columns, "failure",
        )  # fmt: skip
        return Table(heads, rows).csv()

    def command_of(self, key: Key, scene: str) -> str:
        """Command line that repeats a run of a scene, with numbers rounded in the units of its reader."""
        values = values_of(self.plane, self.duration, key, self.draws if key.draw else ())
        changes = "".join(f" --set {self._setting(name, value)}" for name, value in values.items())
        return f"drill-twin run {scene}{changes} --duration {key.length(self.duration, self.asked):.6g}"

    def _setting(self, name: str, value: float | str) -> str:
        _, part, *last = (*name.split("."), "", "")
        if not isinstance(value, float):
            text = f"{name}={value}"
        elif not name.startswith("rig."):
            text = f"{name}={value:.6g}"
        elif last[0] in {"start", "duration"}:
            text = f"{name}={value:.6g} s"
        else:
            text = f"{name}={self.units.text(value, 'force' if part == 'weight_on_bit' else part, '.6g')}"
        return f'"{text}"' if " " in text else text


def read_map(file: str | Path) -> OperatingMap:
    """Read `map.json`.

    Raises:
        ArgumentError: No such file, or not a map.
    """
    content = _FILE.read(file)
    try:
        return OperatingMap.from_json(content)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        value = "nothing" if first["type"] == "missing" else show(first["input"])
        found = f"{value} at {path_text(first['loc']) or 'the top'} ({first['msg']})"
    except SceneError as error:
        found = f"another text at scene ({error})"
    except ArgumentError as error:
        found = f"another file ({error})"
    raise _FILE.refused(file, found)
