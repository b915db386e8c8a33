# SPDX-License-Identifier: Apache-2.0
"""Well plan: survey, casing, hole, tally, mud, bit and rates, and the scene made of them."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drill_twin.core.errors import SceneError
from drill_twin.core.units import parse
from drill_twin.core.units.dimension import ANGULAR_SPEED, DENSITY, FORCE, LENGTH, VISCOSITY
from drill_twin.core.units.parse import short
from drill_twin.core.units.system import typed_in_pounds, unit_system
from drill_twin.physics.model.survey import dogleg
from drill_twin.scene import Scene
from drill_twin.scene.load import build_scene
from drill_twin.scene.well_plan.catalogue import INCH, SAME, bit_law, bit_type, casing_size, plan_bit, same
from drill_twin.scene.well_plan.table import Row, quantity, read_table
from drill_twin.scene.well_plan.tally import TOOLS, TallyPiece, marks, read_tally

NAMES: dict[str, tuple[str, ...]] = {
    "md": ("md", "measured depth", "depth", "measured_depth"),
    "inclination": ("inclination", "inc", "incl", "inclination angle"),
    "azimuth": ("azimuth", "azi", "az", "azim"),
}
WIDEST = 2.0
"""Widest hole of a well plan [m]."""
JUMP = math.radians(20.0) / 30.0
"""Dog-leg severity from which a change of direction is taken for an error of the table [rad/m]: 20 deg/30 m."""


def read_survey(file: Path, system: str) -> list[dict[str, float]]:
    """Stations of a survey, as a scene has them (`hole.survey`), SI.

    A survey that begins below the surface is extended upwards: vertical, if its first station is.

    Raises:
        SceneError: A row that goes back, repeats another, jumps, or cannot be read; with file, line and remedy.
    """
    rows = read_table(file, NAMES, ("md", "inclination", "azimuth"), system)
    stations = [_station(row) for row in rows]
    if not rows or (len(rows) == 1 and stations[0]["depth"] == 0.0):
        raise SceneError(f"{file}: expected two or more stations down to the bit, found {len(rows)}")
    first = stations[0]
    if first["depth"] > 0.0:
        if first["inclination"] > math.radians(1.0):
            raise SceneError(
                f"{rows[0].place}: expected a first station at 0, the rotary table, found "
                f"{rows[0].in_unit('md', first['depth'])} at {math.degrees(first['inclination']):.4g} deg; "
                "add the stations above it"
            )
        stations.insert(0, first | {"depth": 0.0})
        rows.insert(0, rows[0])
    for k in range(1, len(rows)):
        _follows(rows[k], stations[k - 1], stations[k])
    return stations


def _station(row: Row) -> dict[str, float]:
    found = {
        "depth": row.number("md", "depth"),
        "inclination": row.number("inclination", "angle"),
        "azimuth": row.number("azimuth", "angle"),
    }
    for name, value in found.items():
        if not math.isfinite(value):
            raise SceneError(f"{row.place}: expected a number for {name}, found none; give it, or drop the row")
    if not 0.0 <= found["inclination"] <= math.pi:
        raise SceneError(
            f"{row.place}: expected an inclination from 0 to 180 deg, found "
            f"{math.degrees(found['inclination']):.4g} deg; correct it"
        )
    if found["depth"] < 0.0:
        raise SceneError(
            f"{row.place}: expected a depth from 0, found {row.in_unit('md', found['depth'])}; take the row out"
        )
    return found


def _follows(row: Row, above: dict[str, float], here: dict[str, float]) -> None:
    run, depth = here["depth"] - above["depth"], row.in_unit("md", here["depth"])
    if run <= 0.0:
        raise SceneError(
            f"{row.place}: expected a depth below the row above ({row.in_unit('md', above['depth'])}), "
            f"found {depth}: the survey does not go down; sort the rows, or correct or drop this row"
        )
    pair = np.array([[above["inclination"], above["azimuth"]], [here["inclination"], here["azimuth"]]])
    turn = float(dogleg(pair[:, 0], pair[:, 1])[0])
    if turn > JUMP * run:
        raise SceneError(
            f"{row.place}: expected at most 20 deg/30 m, found a jump of {math.degrees(turn):.4g} deg in "
            f"{row.in_unit('md', run)}; correct inclination and azimuth, or add the stations between"
        )


def as_block(stations: list[dict[str, float]]) -> list[dict[str, Any]]:
    """Stations as `hole.survey` of a scene file has them, with units."""
    return [
        {
            "depth": f"{station['depth']:.10g} m",
            "inclination": f"{math.degrees(station['inclination']):.10g} deg",
            "azimuth": f"{math.degrees(station['azimuth']):.10g} deg",
        }
        for station in stations
    ]


BIT = 0.99
"""Largest diameter of the section of a bit over the diameter of its hole [-]."""
LONG = 200.0
"""Length from which wall, eccentricity and frame rate are chosen for a well and not for a test bench [m]."""


class WellPlan(NamedTuple):
    """Texts of a plan with their units, as on the command line."""

    name: str
    survey: Path
    tally: Path
    hole: str
    """Diameter of the open hole."""
    casing: tuple[str, ...] = ()
    """Inner diameter and shoe of each casing from the top down: `12.415 in to 1500 m`; after `ID` any diameter."""
    bit: str = ""
    """Diameter and type of the bit, as `8 1/2 in pdc`, or one of them. Without a diameter the bit has the tally's, else
    the hole's; without a type the one of its kind or name in the tally, as `PDC bit`, else the law `BIT_TORQUE`."""
    depth: str = ""
    """Measured depth of the bit; empty: the last station."""
    mud: str = "1.2 sg"
    viscosity: str = "20 cP"
    friction: float = 0.25
    cased_friction: float | None = None
    """Friction coefficient in the casing; None: the coefficient of the open hole."""
    weight_on_bit: str = "100 kN"
    rotation: str = "120 rpm"
    units: str = ""
    """Units of the scene, and of numbers whose column names none: `si` or `field`; empty: such lengths and weights are
    refused, and a weight on bit in pounds makes it a scene in `field`."""

    def scene(self) -> tuple[Scene, dict[str, Any]]:
        """The scene, and its data as a scene file has them.

        Raises:
            SceneError: The plan contradicts itself; the message names row and remedy.
        """
        data = self.data()
        return build_scene(data, name=self.name), data

    def data(self) -> dict[str, Any]:
        """Data of the scene file, with units."""
        stations = read_survey(self.survey, self.units)
        shown = self.units or ("field" if typed_in_pounds(self.weight_on_bit) else "")
        system = unit_system(shown or "si")
        bottom = quantity("--depth", self.depth, LENGTH) if self.depth else stations[-1]["depth"]
        if bottom > stations[-1]["depth"]:
            raise SceneError(
                f"--depth: expected a bit within the survey ({system.text(stations[-1]['depth'], 'length', '.6g')}), "
                f"found {short(self.depth)}; add the planned stations to the survey"
            )
        pieces = read_tally(self.tally, self.units, bottom)
        length = math.fsum(piece.length for piece in pieces)
        hole = quantity("--hole", self.hole, LENGTH)
        if hole > WIDEST:
            raise SceneError(f'--hole: expected a diameter of at most {WIDEST:g} m, found "{short(self.hole)}"')
        casing = self._casing()
        _check_fit(pieces, hole, casing)
        kind, bit = self._bit(pieces, hole)
        if quantity("--viscosity", self.viscosity, VISCOSITY) <= 0.0:
            raise SceneError(f'--viscosity: expected a viscosity above 0, found "{short(self.viscosity)}"')
        weight = quantity("--wob", self.weight_on_bit, FORCE, 0.0, "" if self.units == "field" else "N")
        turn = quantity("--rpm", self.rotation, ANGULAR_SPEED, 0.0, "rpm")
        straight = all(station["inclination"] == 0.0 for station in stations)
        axis: dict[str, Any] = {} if straight else {"survey": as_block(stations)}
        intervals = [
            {"top": f"{top:g} m", "bottom": f"{bottom:g} m", "radius": f"{0.5 * inner:.10g} m"}
            for top, bottom, inner in casing
        ]
        long = length > LONG
        long_text = unit_system(shown or "auto", length, weight).text(length, "length")
        return {
            "name": self.name,
            **({"units": shown} if shown else {}),
            "description": f"Well plan: {long_text} of string, survey {self.survey.name}, tally {self.tally.name}.",
            "provenance": "Plan. Adjusted weight and make-up torque after API 5DP and RP 7G (drill pipe) and makers' "
            "tables (heavy-weight); torque law of the bit, "
            "specific energy of the rock, friction, eccentricity, wall and damping are stand-ins."
            + "".join(f" {TOOLS[kind]}." for kind in sorted({piece.kind for piece in pieces} & TOOLS.keys())),
            "string": {
                "sections": [piece.section for piece in pieces],
                "marks": marks(pieces),
                "bit_end": "pinned",
            },
            "hole": {"radius": f"{0.5 * hole:.10g} m", **({"intervals": intervals} if intervals else {}), **axis},
            "rig": {
                "weight_on_bit": {"value": f"{weight:g} N"},
                "rotation": {"value": f"{turn:.10g} rad/s"},
                "duration": "60 s",
                "start": "rotating",
            },
            "effects": {
                "gravity": {}, "stretch": {}, "torsion": {}, "eccentricity": {"offset": "1 mm" if long else "0.1 mm"},
                "mud": {"density": f"{quantity('--mud', self.mud, DENSITY):g} kg/m^3", "viscosity": self.viscosity},
                "internal_damping": dict.fromkeys(("bending_time", "stretch_time", "torsion_time"), "1 ms"),
                "added_mass": {"confined": True}, "quadratic_drag": {}, "rotation_drag": {}, "viscous_drag": {},
                "wall": {"stiffness": "1e10 N/m^2.5" if long else "1e8 N/m^2.5"},
                "wall_friction": {"coefficient": self.friction, **self._cased_friction(casing)},
                "bit_torque_stribeck": {"radius": f"{bit / 3.0:.6g} m", **bit_law(kind)},
            },
            "numerics": {"frame_rate": "50 Hz", "lateral_from": "auto"} if long else {"frame_rate": "200 Hz"},
        }  # fmt: skip

    def _bit(self, pieces: list[TallyPiece], hole: float) -> tuple[str, float]:
        """Type of the bit, empty if none is named, and its diameter [m], of plan and tally, which must agree."""
        kind, size = plan_bit(self.bit)
        bit = quantity("--bit", size, LENGTH) if size else hole
        if bit > hole * (1.0 + 1e-9):
            raise SceneError(f"--bit: expected at most the hole ({short(self.hole)}), found {short(self.bit)}")
        for piece in [piece for piece in pieces if piece.kind == "bit"]:
            own = bit_type(piece.row.text("kind")) or bit_type(piece.row.text("name"))
            if (size and not same(bit, piece.widest, SAME)) or (kind and own not in {"", kind}):
                raise SceneError(
                    f"{piece.row.place}: expected the bit of --bit ({short(self.bit)}), found "
                    f"{piece.row.in_unit('od', piece.widest, 'diameter')} {own or 'bit'}; correct the row, or --bit"
                )
            return kind or own, bit if size else piece.widest
        return kind, bit

    def _cased_friction(self, casing: list[tuple[float, float, float]]) -> dict[str, Any]:
        if self.cased_friction is None:
            return {}
        if not casing:
            raise SceneError("--cased-friction: expected a casing with it, found none; give --casing, or leave it out")
        if self.friction == 0.0:
            raise SceneError(
                "--friction: expected a coefficient above 0 beside --cased-friction, which scales the same law, found 0"
            )
        ends = {"top": f"{casing[0][0]:g} m", "bottom": f"{casing[-1][1]:g} m"}
        return {"intervals": [ends | {"coefficient": self.cased_friction}]}

    def _casing(self) -> list[tuple[float, float, float]]:
        """Top, bottom and inner diameter of the casing that is innermost there [m], from the top down."""
        found, top, above = list[tuple[float, float, float]](), 0.0, "0 m"
        for casing in self.casing:
            inner, _, shoe = casing.partition(" to ")
            if not shoe:
                raise SceneError(f'--casing: expected ID and shoe as "12.415 in to 1500 m", found "{short(casing)}"')
            bore = inner.strip().removeprefix("ID ")
            diameter, depth = quantity("--casing", bore, LENGTH), quantity("--casing", shoe, LENGTH)
            if bore == inner.strip() and (size := casing_size(diameter)):
                raise SceneError(
                    f'--casing "{short(casing)}": expected the inner diameter of the casing, found {size} in, an outer '
                    f'diameter of API 5CT; give the inner diameter that its weight leaves, as "12.415 in to 1500 m" '
                    f'for 13 3/8 in of 68 lb/ft, or "ID {short(casing)}" if that is the inner diameter'
                )
            if depth <= top:
                raise SceneError(
                    f'--casing "{casing}": expected a shoe below {above}, found {shoe.strip()}; give the casings '
                    "from the top down, each with the depth to which it is the innermost"
                )
            found.append((top, depth, diameter))
            top, above = depth, shoe.strip()
        return found


def _check_fit(pieces: list[TallyPiece], hole: float, casing: list[tuple[float, float, float]]) -> None:
    """Refuse pipe wider than the hole: a piece passes every diameter above its lower end.

    A bit may fill the hole that it drills; its section is then `BIT` of it, as a scene needs a clearance.
    """
    shoe = casing[-1][1] if casing else 0.0
    depth = math.fsum(piece.length for piece in pieces)
    for piece in pieces:
        passed = [inner for top, _, inner in casing if top <= depth] + [hole] * (depth >= shoe)
        narrow = min(passed)
        if piece.kind == "bit" and piece.widest <= narrow * (1.0 + 1e-9):
            for key in {"outer_diameter", "blade_diameter"} & piece.section.keys():
                piece.section[key] = f"{min(parse(piece.section[key], LENGTH), BIT * narrow):.10g} m"
        elif piece.widest >= narrow:
            what, column = ("blades or tool joints", "gauge") if "blade_diameter" in piece.section else ("pipe", "od")
            raise SceneError(
                f'{piece.row.place} ("{piece.section["name"]}"): expected {what} of less than the narrowest hole that '
                f"it passes ({narrow / INCH:.4g} in, {narrow * 1e3:.4g} mm), found {piece.widest / INCH:.4g} in "
                f"({piece.widest * 1e3:.4g} mm); take a smaller {column}, or correct hole "
                "and casing"
            )
        depth -= piece.length
