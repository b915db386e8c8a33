# SPDX-License-Identifier: Apache-2.0
"""Pipe tally: a CSV file from the bit up becomes the sections of a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from drill_twin.core.errors import SceneError
from drill_twin.core.units import parse
from drill_twin.core.units.dimension import DENSITY as SOLID
from drill_twin.core.units.dimension import LENGTH
from drill_twin.physics.model.steel import COLLAR, GRADES, HEAVY_WEIGHT, LARGE_COLLAR, Steel
from drill_twin.scene.well_plan.catalogue import (
    DENSITY,
    INCH,
    LARGEST_COLLAR,
    MATERIALS,
    Pipe,
    drill_pipe,
    heavy_weight,
    named_sizes,
)
from drill_twin.scene.well_plan.table import Row, read_table

NAMES = {
    "kind": ("kind", "item", "type", "component"),
    "length": ("length", "len"),
    "od": ("od", "outer diameter"),
    "id": ("id", "inner diameter"),
    "weight": ("weight", "nominal weight", "mass", "mass per length"),
    "grade": ("grade",),
    "material": ("material",),
    "gauge": ("gauge", "blades", "blade diameter"),
    "name": ("name",),
}
KINDS = {
    "dp": "pipe", "drill pipe": "pipe", "pipe": "pipe", "hwdp": "heavy", "heavy-weight": "heavy", "heavy": "heavy",
    "collar": "collar", "dc": "collar", "drill collar": "collar", "bit": "collar", "mwd": "collar", "sub": "collar",
    "motor": "collar", "stabiliser": "stabiliser", "stabilizer": "stabiliser", "stab": "stabiliser",
    "tube": "tube",
}  # fmt: skip
"""Words for the kinds of pipe."""
ROUNDED = 0.05
"""Difference of a weight from the weight of the tube up to which both are the same, rounded [-]."""
REST = "rest"
"""Length of a row that takes what is left of the well."""


MARKED = ("stabiliser", "stabilizer", "stab", "mwd", "motor", "sub")
"""Kinds with a mark at their middle."""


class TallyPiece(NamedTuple):
    """Row of a tally."""

    row: Row
    """With its place, for messages."""
    section: dict[str, Any]
    """As a scene file has it, with units."""
    kind: str
    """Word of the tally, one of `KINDS`."""
    length: float
    """[m]."""
    widest: float
    """Largest outer diameter, blades and tool joints included [m]."""


def read_tally(file: Path, system: str, bottom: float) -> list[TallyPiece]:
    """Read the tally, from the bit up.

    Args:
        file: Table with the columns kind, length and od; id, weight, grade, gauge and name as far as they apply.
        system: `si` or `field`.
        bottom: Measured depth of the bit [m]; a row of the length `rest` takes what the other rows leave of that depth.

    Raises:
        SceneError: A row that cannot be read, or a tally longer than the well; with file, line and remedy.
    """
    rows = read_table(file, NAMES, ("kind", "length", "od"), system)
    lengths = [math.nan if row.text("length").lower() == REST else _positive(row, "length", "depth") for row in rows]
    open_rows = [row for row, length in zip(rows, lengths, strict=True) if math.isnan(length)]
    total = math.fsum(length for length in lengths if not math.isnan(length))
    if not rows or len(open_rows) > 1:
        raise SceneError(
            f"{open_rows[1].place if open_rows else file}: expected rows from the bit up, at most one with the length "
            f'"{REST}", found {len(open_rows)} of {len(rows)}'
        )
    if total > bottom * (1.0 + 1e-9) or (open_rows and total >= bottom):
        last = (open_rows or rows)[-1]
        raise SceneError(
            f"{last.place}: expected a tally of at most the measured depth of the bit "
            f"({last.length_text('length', bottom)}), found {last.length_text('length', total)}; "
            f'shorten the drill pipe or give its length as "{REST}"'
        )
    return [
        _piece(row, bottom - total if math.isnan(length) else length) for row, length in zip(rows, lengths, strict=True)
    ]


def marks(pieces: Sequence[TallyPiece]) -> list[dict[str, Any]]:
    """Marks of a string from the bit up: near the bit, at stabilisers and tools, in the longest collar and half-way up.

    The bit itself is held, so its mark is a metre above its face, or less in a short string.
    """
    length = math.fsum(piece.length for piece in pieces)
    found = {"bit": min(1.0, 0.02 * length)}
    collars = [piece.length for piece in pieces if KINDS[piece.kind] == "collar" and piece.kind not in MARKED]
    place = 0.0
    for piece in pieces:
        middle = place + 0.5 * piece.length
        if piece.kind in MARKED:
            word = KINDS[piece.kind] if KINDS[piece.kind] == "stabiliser" else piece.kind
            same = sum(name.rstrip("0123456789_") == word for name in found)
            found[f"{word}_{same + 1}" if same else word] = middle
        elif piece.length == max(collars, default=0.0):
            found.setdefault("collars", middle)
        place += piece.length
    found["middle"] = 0.5 * length
    return [{"name": name, "distance_from_bit": f"{at:.6g} m"} for name, at in found.items()]


def _positive(row: Row, column: str, kind: str) -> float:
    value = row.number(column, kind)
    if not value > 0.0:
        found = "nothing" if math.isnan(value) else f'"{row.text(column)}"'
        raise SceneError(f"{row.place}, {column}: expected a number above 0, found {found}")
    return value


def _piece(row: Row, length: float) -> TallyPiece:
    word = row.text("kind").lower()
    if word not in KINDS:
        raise SceneError(f'{row.place}, kind: expected one of {", ".join(KINDS)}, found "{row.text("kind")}"')
    kind, outer = KINDS[word], _positive(row, "od", "diameter")
    section: dict[str, Any] = {"name": row.text("name") or row.text("kind"), "length": f"{length:.10g} m"}
    section |= {"pipe": _drill_pipe, "heavy": _heavy, "tube": _plain}.get(kind, _collar)(row, outer)
    if kind == "stabiliser":
        gauge = _positive(row, "gauge", "diameter")
        if gauge < outer:
            raise SceneError(
                f"{row.place}, gauge: expected at least the od ({row.text('od')}), found {row.text('gauge')}; the "
                "gauge is the diameter over the blades"
            )
        section["blade_diameter"] = f"{gauge:.10g} m"
    section |= _material(row)
    if row.text("id") and row.text("weight") and KINDS[word] not in {"pipe", "heavy"}:
        section |= _joints(row, outer, parse(section["inner_diameter"], LENGTH))
    widest = section.get("blade_diameter", section["outer_diameter"])
    return TallyPiece(row, section, word, length, parse(widest, LENGTH))


def _drill_pipe(row: Row, outer: float) -> dict[str, Any]:
    mass = _positive(row, "weight", "mass")
    pipe = drill_pipe(outer, mass)
    if pipe is None:
        raise SceneError(
            f"{row.place}: expected drill pipe of API 5DP ({named_sizes()}), found od {row.text('od')}, weight "
            f"{row.text('weight')}; the weight is the nominal one. For another pipe edit the scene"
        )
    return _jointed(outer, pipe, _grade(row))


def _heavy(row: Row, outer: float) -> dict[str, Any]:
    pipe = heavy_weight(outer)
    if pipe is None:
        raise SceneError(
            f"{row.place}, od: expected heavy-weight pipe of 3 1/2 to 6 5/8 in, found {outer / INCH:.4g} in"
        )
    return _jointed(outer, pipe, HEAVY_WEIGHT)


def _jointed(outer: float, pipe: Pipe, steel: Steel) -> dict[str, Any]:
    """Pipe of the catalogue, with its tool joints."""
    return _tube(outer, pipe.inner_diameter, steel) | {
        "adjusted_mass": f"{pipe.adjusted_mass:.6g} kg/m", "blade_diameter": f"{pipe.joint_diameter:.10g} m",
        "make_up_torque": f"{pipe.make_up_torque:.6g} N m",
    }  # fmt: skip


def _collar(row: Row, outer: float) -> dict[str, Any]:
    return _tube(outer, _bore(row, outer), LARGE_COLLAR if outer > LARGEST_COLLAR else COLLAR)


def _plain(row: Row, outer: float) -> dict[str, Any]:
    """Tube of any size, without tool joints."""
    return _tube(outer, _bore(row, outer), _grade(row) if row.text("grade") else None)


def _bore(row: Row, outer: float) -> float:
    """Bore of a row; without one the bore of a tube of its weight and material (motors seldom have it)."""
    if not row.text("id"):
        if not row.text("weight"):
            raise SceneError(f"{row.place}, id: expected the bore, or a `weight` from which it follows, found neither")
        square = outer**2 - _positive(row, "weight", "mass") / (0.25 * math.pi * _density(row))
        if not square > 0.0:
            raise SceneError(
                f"{row.place}, weight: expected less than the weight of a bar of that od, found {row.text('weight')}"
            )
        return math.sqrt(square)
    inner = _positive(row, "id", "diameter")
    if inner >= outer:
        raise SceneError(f"{row.place}, id: expected less than the od ({row.text('od')}), found {row.text('id')}")
    return inner


def _material(row: Row) -> dict[str, Any]:
    word = row.text("material").lower()
    if word not in MATERIALS:
        raise SceneError(
            f"{row.place}, material: expected one of {', '.join(name for name in MATERIALS if name)}, or nothing for "
            f'steel, found "{row.text("material")}"'
        )
    return MATERIALS[word]


def _density(row: Row) -> float:
    return parse(_material(row).get("density", f"{DENSITY} kg/m^3"), SOLID)


def _joints(row: Row, outer: float, inner: float) -> dict[str, str]:
    """Adjusted mass of a row whose weight is more than the weight of its tube: of tool joints and upsets.

    Raises:
        SceneError: The weight is less than the weight of the tube.
    """
    mass, tube = _positive(row, "weight", "mass"), 0.25 * math.pi * (outer**2 - inner**2) * _density(row)
    if mass < (1.0 - ROUNDED) * tube:
        raise SceneError(
            f"{row.place}, weight: expected at least the weight of a tube of that od, id and material "
            f"({tube:.4g} kg/m), found {row.text('weight')} ({mass:.4g} kg/m); correct one of the four"
        )
    return {"adjusted_mass": f"{mass:.6g} kg/m"} if mass > (1.0 + ROUNDED) * tube else {}


def _grade(row: Row) -> Steel:
    grade = row.text("grade").upper().replace("-", "").replace(" ", "")
    if grade not in GRADES:
        raise SceneError(
            f'{row.place}, grade: expected one of {", ".join(GRADES)}, found "{row.text("grade")}"; the weight has a '
            "column of its own"
        )
    return GRADES[grade]


def _tube(outer: float, inner: float, steel: Steel | None) -> dict[str, Any]:
    tube = {"outer_diameter": f"{outer:.10g} m", "inner_diameter": f"{inner:.10g} m"}
    return tube if steel is None else tube | {"yield_strength": f"{steel.yield_strength / 1e6:.6g} MPa"}
