# SPDX-License-Identifier: Apache-2.0
"""Survey of a well plan: measured depth, inclination and azimuth from a CSV file, checked row by row."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from drill_twin.core.errors import SceneError
from drill_twin.physics.model.survey import dogleg
from drill_twin.scene.well_plan.table import Row, read_table

NAMES: dict[str, tuple[str, ...]] = {
    "md": ("md", "measured depth", "depth", "measured_depth"),
    "inclination": ("inclination", "inc", "incl", "inclination angle"),
    "azimuth": ("azimuth", "azi", "az", "azim"),
}
JUMP = math.radians(20.0) / 30.0
"""Dog-leg severity from which a change of direction is taken for an error of the table [rad/m]: 20 deg/30 m."""


def read_survey(file: Path, system: str) -> list[dict[str, float]]:
    """Stations of a survey, as a scene has them (`hole.survey`), SI.

    A survey that begins below the surface is extended upwards: vertical, if its first station is.

    Raises:
        SceneError: A row that goes back, repeats another, jumps, or cannot be read; with file, line and remedy.
    """
    rows = read_table(file, NAMES, ("md", "inclination", "azimuth"), system)
    if not rows:
        raise SceneError(f"{file}: expected at least two stations, found none")
    stations = [_station(row) for row in rows]
    first = stations[0]
    if first["depth"] > 0.0:
        if first["inclination"] > math.radians(1.0):
            raise SceneError(
                f"{rows[0].place}: expected a first station at 0, the rotary table, found {first['depth']:.6g} m at "
                f"{math.degrees(first['inclination']):.4g} deg; add the stations above it"
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
            raise SceneError(f"{row.place}: expected a number for {name}, found none; give it, or take the row out")
    if not 0.0 <= found["inclination"] <= math.pi:
        raise SceneError(
            f"{row.place}: expected an inclination from 0 to 180 deg, found "
            f"{math.degrees(found['inclination']):.4g} deg; correct it"
        )
    if found["depth"] < 0.0:
        raise SceneError(f"{row.place}: expected a depth from 0, found {found['depth']:.6g} m; take the row out")
    return found


def _follows(row: Row, above: dict[str, float], here: dict[str, float]) -> None:
    run = here["depth"] - above["depth"]
    if run == 0.0:
        raise SceneError(
            f"{row.place}: expected a depth below the row above, found {here['depth']:.6g} m again; take "
            "one of them out"
        )
    if run < 0.0:
        raise SceneError(
            f"{row.place}: expected a depth below the row above ({above['depth']:.6g} m), found {here['depth']:.6g} m: "
            "the survey goes back; sort the rows, or correct this one"
        )
    pair = np.array([[above["inclination"], above["azimuth"]], [here["inclination"], here["azimuth"]]])
    turn = float(dogleg(pair[:, 0], pair[:, 1])[0])
    if turn > JUMP * run:
        raise SceneError(
            f"{row.place}: expected at most 20 deg/30 m, found a jump of {math.degrees(turn):.4g} deg in {run:.4g} m; "
            "correct inclination and azimuth, or add the stations between"
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
