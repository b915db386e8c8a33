# SPDX-License-Identifier: Apache-2.0
"""Pipe tally: a CSV file from the bit up becomes the sections of a scene."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from drill_twin.core.errors import SceneError
from drill_twin.core.units import parse
from drill_twin.core.units.dimension import DENSITY as SOLID
from drill_twin.core.units.dimension import LENGTH
from drill_twin.physics.model.steel import COLLAR, DEFAULT_GRADE, GRADES, HEAVY_WEIGHT, LARGE_COLLAR, Steel
from drill_twin.scene.well_plan.catalogue import (
    ALUMINIUM,
    DENSITY,
    LARGEST_COLLAR,
    MATERIALS,
    PIPES,
    ROUNDED,
    SAME,
    area,
    find_pipe,
    named_sizes,
    same,
)
from drill_twin.scene.well_plan.table import Row, read_table

NAMES = {
    "kind": ("kind", "item", "type", "component", "element", "tool"),
    "length": ("length", "len", "total length", "section length"),
    "od": ("od", "outer diameter", "outside diameter"),
    "id": ("id", "inner diameter", "inside diameter", "bore"),
    "weight": (
        "weight", "wt", "nominal weight", "adjusted weight", "linear weight", "unit weight", "mass", "mass per length",
    ),
    "grade": ("grade",),
    "material": ("material",),
    "gauge": ("gauge", "blades", "blade diameter"),
    "name": ("name",),
}  # fmt: skip
KINDS = {word: kind for kind, words in {
    "pipe": "dp drill_pipe drillpipe pipe", "heavy": "hwdp heavy heavy_weight heavy_weight_drill_pipe",
    "collar": "collar dc nmdc", "stabiliser": "stabiliser stabilizer stab", "bit": "bit", "mwd": "mwd", "lwd": "lwd",
    "rss": "rss rotary_steerable rotary_steerable_system", "motor": "motor pdm", "jar": "jar accelerator",
    "reamer": "reamer underreamer hole_opener", "sub": "sub crossover xo", "tube": "tube",
}.items() for word in words.split() for word in (word, f"{word}s")}  # fmt: skip
"""Last words of what a row is called -> kind of the row."""
NAMED = GRADES | {name[0]: steel for name, steel in GRADES.items()}
"""Steel by its grade, S135 or S."""
SIZES = {"od": "diameter", "id": "diameter", "weight": "mass"}
REST = "rest"
"""Length of a row that takes what is left of the well."""


MOST = {"collar": 1.0 + ROUNDED} | dict.fromkeys(("tube", *PIPES), 1.5)
"""Largest weight of a kind over the weight of its tube [-]: of a collar, rounded, and of pipe with joints; other tools
weigh at most what a bar weighs."""
MARKED = ("stabiliser", "mwd", "lwd", "rss", "motor", "jar", "reamer", "sub")
"""Kinds with a mark at their middle."""
APART = 0.5
"""Distance of two marks that tell the same motion [m]: half of the length of a short tool. Chosen, not measured."""
TOOLS = {
    "motor": "motor: a tube that turns with the string; its bend and the speed and torque of its rotor are left out",
    "rss": "rotary steerable tool: a tube; the force of its pads is left out (effects.bit_side_force)",
    "reamer": "reamer: a tube with blades that rub on the wall; weight and torque of its cutting are left out",
}
"""Sentence on what is modelled of a kind."""
LEAST = {"bit": 0.0} | dict.fromkeys(MARKED[1:], 0.5)
"""Least weight over the weight of the tube [-], else 1 less `ROUNDED`: the od of a tool is its largest."""


class TallyPiece(NamedTuple):
    """Row of a tally."""

    row: Row
    """With its place, for messages."""
    section: dict[str, Any]
    """As a scene file has it, with units."""
    kind: str
    """One of the values of `KINDS`."""
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
    if from_top(rows):
        rows.reverse()
    lengths = [math.nan if row.text("length").lower() == REST else _positive(row, "length", "depth") for row in rows]
    open_rows = [row for row, length in zip(rows, lengths, strict=True) if math.isnan(length)]
    total = math.fsum(length for length in lengths if not math.isnan(length))
    if not rows or len(open_rows) > 1:
        raise SceneError(
            f"{open_rows[1].place if open_rows else file}: expected rows from the bit up, at most one with the length "
            f'"{REST}", found {len(open_rows)} of {len(rows)}'
        )
    if len(bits := [row for row in rows if _kind(row) == "bit"]) > 1:
        raise SceneError(f"{bits[1].place}: expected one bit, found another; take it out, or call it reamer")
    if total > bottom * (1.0 + 1e-9) or (open_rows and total >= bottom):
        last = (open_rows or rows)[-1]
        raise SceneError(
            f"{last.place}: expected a tally of at most the measured depth of the bit "
            f"({last.in_unit('length', bottom)}), found {last.in_unit('length', total)}; "
            f'shorten the drill pipe or give its length as "{REST}"'
        )
    return [
        _piece(row, bottom - total if math.isnan(length) else length) for row, length in zip(rows, lengths, strict=True)
    ]


def from_top(rows: Sequence[Row]) -> bool:
    """True for rows from the top down: the last one is a bit, or the first is drill pipe and the last is none."""
    kinds = [_kind(row) for row in (*rows[:1], *rows[-1:])]
    return kinds[1:] == ["bit"] or (kinds[:1] == ["pipe"] and kinds[1] not in {"tube", *PIPES})


def marks(pieces: Sequence[TallyPiece]) -> list[dict[str, Any]]:
    """Marks of a string from the bit up: near the bit, at stabilisers and tools, in the longest collar and half-way up.

    The bit itself is held, so the lowest mark is a metre above its face, or less in a short string. A place nearer than
    `APART` to a mark has none of its own.
    """
    length = math.fsum(piece.length for piece in pieces)
    found, apart = {"near_bit": min(1.0, 0.02 * length)}, min(APART, 0.01 * length)
    longest = max((piece.length for piece in pieces if piece.kind == "collar"), default=0.0)
    place = 0.0
    for piece in pieces:
        middle, word = place + 0.5 * piece.length, piece.kind
        place += piece.length
        if any(abs(middle - at) < apart for at in found.values()):
            continue
        if word in MARKED:
            same = sum(name.rstrip("0123456789_") == word for name in found)
            found[f"{word}_{same + 1}" if same else word] = middle
        elif word == "collar" and piece.length == longest:
            found.setdefault("collars", middle)
    found["middle"] = 0.5 * length
    return [{"name": name, "distance_from_bit": f"{at:.6g} m"} for name, at in found.items()]


def _positive(row: Row, column: str, kind: str) -> float:
    value = row.number(column, kind)
    if not value > 0.0:
        found = "nothing" if math.isnan(value) else f'"{row.text(column)}"'
        raise SceneError(f"{row.place}, {column}: expected a number above 0, found {found}")
    return value


def _kind(row: Row) -> str:
    """Kind of a row by the last words of what it is called: `6 1/2 in non-mag collars` is a collar."""
    words = row.text("kind").lower().replace("-", " ").split()
    kind = next((KINDS[end] for at in range(len(words)) if (end := "_".join(words[at:])) in KINDS), None)
    if kind is None:
        known = ", ".join(word for word in KINDS if word[:-1] not in KINDS).replace("_", " ")
        raise SceneError(f'{row.place}, kind: expected one of {known}, found "{row.text("kind")[:40]}"')
    return kind


def _piece(row: Row, length: float) -> TallyPiece:
    kind, material = _kind(row), _one_of(row, "material", MATERIALS) or {}
    section: dict[str, Any] = {"name": row.text("name") or row.text("kind"), "length": f"{length:.10g} m"}
    section |= _jointed(row, kind) if kind in PIPES and not material else _made(row, kind, material)
    if kind == "stabiliser" or row.text("gauge"):
        if (gauge := _positive(row, "gauge", "diameter")) < parse(section["outer_diameter"], LENGTH):
            raise SceneError(
                f"{row.place}: expected a gauge, the diameter over the blades, of at least the od, found {_found(row)}"
            )
        section["blade_diameter"] = f"{gauge:.10g} m"
    widest = section.get("blade_diameter", section["outer_diameter"])
    return TallyPiece(row, section, kind, length, parse(widest, LENGTH))


def _jointed(row: Row, kind: str) -> dict[str, Any]:
    """Pipe of the catalogue, with its tool joints: of its nominal weight, or of the weight and bore of the row."""
    outer, inner, mass = _sizes(row)
    pipe = find_pipe(kind, outer, inner, mass)
    if pipe is None or inner < 0.0:
        raise SceneError(
            f"{row.place}: expected pipe of the catalogue, {named_sizes(kind, outer)}, found {_found(row)}; give "
            "another pipe as `tube`, with joints"
        )
    grade = HEAVY_WEIGHT if kind == "heavy" else _one_of(row, "grade", NAMED) or GRADES[DEFAULT_GRADE]
    return _tube(outer, pipe.inner_diameter if math.isnan(inner) else inner, grade) | {
        "adjusted_mass": f"{pipe.adjusted_mass:.6g} kg/m", "blade_diameter": f"{pipe.joint_diameter:.10g} m",
        "make_up_torque": f"{pipe.make_up_torque:.6g} N m",
    }  # fmt: skip


def _made(row: Row, kind: str, material: dict[str, Any]) -> dict[str, Any]:
    """Section of od, bore, weight and material: the fourth follows from three, and a weight beside a bore is kept.

    Raises:
        SceneError: Two of the four are missing, or they contradict one another; the message has both weights.
    """
    outer, inner, mass = _sizes(row)
    square = mass / (area(1.0, 0.0) * _density(material))
    if math.isnan(outer):
        outer = math.sqrt(inner**2 + square)
    if math.isnan(inner) and (kind == "bit" or not math.isnan(mass)):
        inner = 0.0 if math.isnan(mass) else math.sqrt(max(outer**2 - square, 0.0))
    if not 0.0 <= inner < outer:
        raise SceneError(
            f"{row.place}: expected two or three of od, id and `weight`, the id less than the od, found {_found(row)}"
        )
    if kind == "tube" and not row.text("material") and same(area(outer, inner) * _density(ALUMINIUM), mass, ROUNDED):
        material = ALUMINIUM
    collar = LARGE_COLLAR if outer > LARGEST_COLLAR else COLLAR
    steel = None if material else _one_of(row, "grade", NAMED) if kind in {"tube", *PIPES} else collar
    weight = _weighed(row, kind, area(outer, inner), area(outer, inner) * _density(material), mass)
    return _tube(outer, inner, steel) | material | weight


def _weighed(row: Row, kind: str, section: float, tube: float, mass: float) -> dict[str, str]:
    """Key by which a section has the weight of its row: more than its tube's for joints, less for grooves.

    Args:
        row: Where it stands.
        kind: One of the values of `KINDS`.
        section: Cross-section of the tube [m^2].
        tube: Mass per length of the tube [kg/m].
        mass: Mass per length of the row [kg/m]; NaN: not given.

    Raises:
        SceneError: The weight is below the tube's by more than `LEAST` allows, or above what a collar or a bar has.
    """
    if math.isnan(mass) or same(tube, mass, SAME):
        return {}
    widest = max(row.number(name, "diameter") for name in ("od", "gauge") if row.text(name))
    most = tube * MOST[kind] if kind in MOST else max(tube * area(widest, 0.0) / section, tube)
    if mass < LEAST.get(kind, 1.0 - ROUNDED) * tube or mass > most:
        known, highest, found = (row.in_unit("weight", value, "mass") for value in (tube, most, mass))
        raise SceneError(
            f"{row.place}, weight: expected {known} by od, id and `material`, at most {highest}, found {found}"
        )
    heavier = mass >= tube and kind not in {"stabiliser", "bit"}
    return {"adjusted_mass": f"{mass:.10g} kg/m"} if heavier else {"density": f"{mass / section:.10g} kg/m^3"}


def _sizes(row: Row) -> Iterator[float]:
    """Outer diameter and bore [m] and weight [kg/m] of a row; NaN where it has none."""
    for name, kind in SIZES.items():
        yield _positive(row, name, kind) if row.text(name) and name != "id" else row.number(name, kind)


def _density(material: dict[str, Any]) -> float:
    return parse(material.get("density", f"{DENSITY} kg/m^3"), SOLID)


def _found(row: Row) -> str:
    return ", ".join(
        f"{name} {row.text(name)} {row.units.get(name, '')}".rstrip() for name in (*SIZES, "gauge") if row.text(name)
    )


def _one_of(row: Row, column: str, known: Mapping[str, Any]) -> Any:
    """Value of a cell's word, such as S-135 or aluminium; None for an empty cell."""
    word = row.text(column).upper().replace("-", "").replace(" ", "")
    if word and word not in known:
        raise SceneError(
            f'{row.place}, {column}: expected one of {", ".join(known)}, or nothing, found "{row.text(column)[:40]}"; '
            "weights and diameters have columns of their own"
        )
    return known.get(word)


def _tube(outer: float, inner: float, steel: Steel | None) -> dict[str, Any]:
    tube = {"outer_diameter": f"{outer:.10g} m", "inner_diameter": f"{inner:.10g} m"}
    return tube if steel is None else tube | {"yield_strength": f"{steel.yield_strength / 1e6:.6g} MPa"}
