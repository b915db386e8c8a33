# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin_evidence.validation.drawn_plans [COUNT]`: plans drawn at random, made scenes and balanced.

Each plan goes the way of `drill-twin scene new` and `drill-twin statics`; every number must be finite, and hookload and
torque of a string that turns off bottom must agree with sums of this file over the survey (Johancsik et al. 1984).
"""

from __future__ import annotations

import math
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import drill_twin as dt
from drill_twin.scene import Scene
from drill_twin.scene.well_plan.plan import WellPlan

HOLES = {"8 1/2 in": (6.75, 5.0, 19.5, 8.535), "12 1/4 in": (8.0, 5.0, 19.5, 12.415), "6 in": (4.75, 3.5, 13.3, 6.184)}
"""By hole: diameter of collars and pipe [in], weight of pipe [lb/ft], inner diameter of the casing [in]."""
GRAVITY, STEEL = 9.80665, 7850.0
TURNING = "rotate"
STEP = 1.0  # m along the hole, of the sums; half of it changes no digit that is compared
CLOSE = 0.01


@dataclass(frozen=True)
class Drawn:
    """A plan, and what became of it."""

    number: int
    scene: Scene
    hookload: float
    """Of the twin over the sum's."""
    torque: float
    """Of the twin's soft string over the sum's."""

    @property
    def agrees(self) -> bool:
        """True where both are within `CLOSE`; an unknown ratio is not."""
        return all(abs(ratio - 1.0) < CLOSE for ratio in (self.hookload, self.torque))


def plan(number: int, folder: Path) -> WellPlan:
    """Plan of a number, its tables in a folder."""
    draw = np.random.default_rng(number)
    hole = draw.choice(list(HOLES))
    collar, pipe, weight, casing = HOLES[hole]
    length = draw.uniform(700.0, 4500.0)
    kick_off, rate = draw.uniform(0.1, 0.5) * length, draw.uniform(0.5, 3.0) / 30.0  # deg/m
    inclination = draw.choice([0.0, draw.uniform(2.0, 20.0), draw.uniform(20.0, 70.0)])
    stations, azimuth = [(0.0, 0.0)], draw.uniform(0.0, 360.0)
    if inclination:
        built = min(kick_off + inclination / rate, 0.9 * length)
        inclination = (built - kick_off) * rate
        stations += [(kick_off, 0.0), (built, inclination)]
        if draw.random() < 0.4 and built < 0.7 * length:
            stations.append((built + 0.5 * (0.9 * length - built), max(inclination - 300.0 * rate, 2.0)))
    stations.append((length, stations[-1][1]))
    turn = draw.uniform(-0.5, 0.5) / 30.0 * (draw.random() < 0.5)
    rows = "".join(f"{md:.3f},{deg:.4f},{(azimuth + turn * md) % 360.0:.4f}\n" for md, deg in stations)
    (folder / "survey.csv").write_text("md [m],inclination [deg],azimuth [deg]\n" + rows, "utf-8")
    size = float(hole.split()[0]) + {"1/2": 0.5, "1/4": 0.25}.get(hole.split()[1], 0.0)
    kind = draw.choice(["PDC bit", "roller-cone bit", "hybrid bit", "bit"])
    tally = [f"{kind},0.3,{size},2.25,,,,bit"]
    if draw.random() < 0.4:
        tally.append(f"motor,8,{collar},2,,,{size - draw.uniform(0.03, 0.25):.4f},motor")
    for _ in range(draw.integers(0, 4)):
        tally += [f"stabiliser,1.5,{collar},2.25,,,{size - draw.uniform(0.03, 0.5):.4f},",
                  f"collar,{draw.uniform(5.0, 30.0):.2f},{collar},2.25,,,,"]  # fmt: skip
    tally.append(f"collar,{draw.uniform(40.0, 150.0):.1f},{collar},2.25,,,,collars")
    if draw.random() < 0.5:
        tally.append(f"jar,9.5,{collar},2.25,,,,jar")
    tally += [f"hwdp,{draw.uniform(50.0, 200.0):.1f},{pipe},,,,,", f"drill pipe,rest,{pipe},,{weight},S-135,,"]
    heading = "kind,length [m],od [in],id [in],weight [lb/ft],grade,gauge [in],name\n"
    (folder / "tally.csv").write_text(heading + "\n".join(tally) + "\n", "utf-8")
    shoe = draw.uniform(0.2, 0.8) * length
    return WellPlan(
        f"drawn_{number}", folder / "survey.csv", folder / "tally.csv", hole, (f"ID {casing} in to {shoe:.1f} m",),
        mud=f"{draw.uniform(8.6, 15.0):.2f} ppg", viscosity=f"{draw.uniform(5.0, 40.0):.1f} cP",
        friction=float(draw.uniform(0.15, 0.35)), cased_friction=float(draw.uniform(0.1, 0.25)),
        weight_on_bit=f"{draw.uniform(5.0, 25.0):.1f} klbf", rotation=f"{draw.uniform(60.0, 180.0):.0f} rpm",
    )  # fmt: skip


def sums(scene: Scene) -> tuple[float, float]:
    """Hookload [N] and torque [N m] of a string that turns off bottom, by sums along the survey from the bit up."""
    survey = [(one.depth, one.inclination, one.azimuth) for one in scene.hole.survey]
    survey = survey or [(0.0, scene.hole.inclination, 0.0), (scene.string.length, scene.hole.inclination, 0.0)]
    depth = np.array([one[0] for one in survey])
    tangents = np.array([
        (math.sin(leans) * math.cos(turns), math.sin(leans) * math.sin(turns), math.cos(leans))
        for _, leans, turns in survey
    ])  # fmt: skip
    mud, wall = scene.effects.mud, scene.effects.wall_friction
    tension = torque = 0.0
    bottom = scene.string.length
    for section in scene.string.sections:
        area = 0.25 * math.pi * (section.outer_diameter**2 - section.inner_diameter**2)
        mass = section.adjusted_mass or section.density * area
        weight = mass * (1.0 - mud.density / section.density) * GRAVITY
        radius = 0.5 * (section.blade_diameter or section.outer_diameter)
        count = max(1, round(section.length / STEP))
        step = section.length / count
        for k in range(count):
            here = bottom - (k + 0.5) * step
            leg = min(max(int(np.searchsorted(depth, here)) - 1, 0), len(depth) - 2)
            angle = math.acos(min(1.0, float(tangents[leg] @ tangents[leg + 1])))
            share = (here - depth[leg]) / (depth[leg + 1] - depth[leg])
            along = tangents[leg]
            bend = np.zeros(3)
            if angle > 1e-9:
                at = share * angle
                side = (tangents[leg + 1] - math.cos(angle) * tangents[leg]) / math.sin(angle)
                along = math.cos(at) * tangents[leg] + math.sin(at) * side
                bend = angle / (depth[leg + 1] - depth[leg]) * (math.cos(at) * side - math.sin(at) * tangents[leg])
            down = np.array([0.0, 0.0, weight])
            across = down - (down @ along) * along
            middle = tension + 0.5 * step * weight * along[2]
            # The tension pulls the string towards the inside of a bend; its weight pulls it down.
            force = float(np.linalg.norm(across + middle * bend)) * step
            friction = next(
                (one.coefficient for one in wall.intervals if one.top <= here <= one.bottom), wall.coefficient
            )
            torque += friction * force * radius
            tension += step * weight * along[2]
        bottom -= section.length
    return tension, torque


def drawn(number: int) -> Drawn:
    """Draw a plan, make its scene, balance it, and compare.

    Raises:
        DrillTwinError: The plan is refused, or has no balance.
        AssertionError: A number is not finite.
    """
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        scene, _ = plan(number, Path(folder)).scene()
        found = dt.statics(scene)
    for loads in found.operations:
        numbers = [loads.hookload, loads.surface_torque, loads.twist, *loads.along.tension, *loads.along.side_force]
        if not np.isfinite(numbers).all():
            raise AssertionError(f"plan {number}, {loads.operation.name}: expected finite numbers, found {numbers[:3]}")
    loads = next(loads for loads in found.operations if loads.operation.rotation and not loads.operation.is_on_bottom)
    hookload, torque = sums(scene)
    straight = all(station.inclination == 0.0 for station in scene.hole.survey)
    ratio = 1.0 if straight else abs(loads.soft.surface_torque) / torque
    return Drawn(number, scene, loads.soft.hookload / hookload, ratio)


def main(count: Annotated[int, typer.Argument(help="Number of plans.")] = 200, first: int = 1) -> None:
    """Draw plans, and print each that does not agree, then how many do."""
    good = 0
    for number in range(first, first + count):
        found = drawn(number)
        good += found.agrees
        if not found.agrees:
            print(f"plan {number}: hookload {found.hookload:.4f}, torque {found.torque:.4f} of the sums")
    print(f"{good} of {count} plans agree with sums by hand within {CLOSE:.0%}, every number finite")


if __name__ == "__main__":
    typer.run(main)
