# SPDX-License-Identifier: Apache-2.0
"""File of the gateway: a line a signal, with its name, quantity and unit."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from drill_twin.core.errors import DrillTwinError, nearest
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.yaml_reader import LARGEST_TEXT, Place, read_yaml
from drill_twin.core.units import UnitError, factor_of, show
from drill_twin_rig.gateway.quantities import MEASURED, QUANTITIES, downhole, measured_dimension

_RIG = ("node", "unit", "low", "high", "stale_after", "frozen_after")
_SECTIONS = {
    "show": ("value", "unit", "class"),
    "command": ("value", "unit", "low", "high"),
    "measure": _RIG,
    "follow": _RIG,
}
_STALE_AFTER = 2.0  # s
_WITS_UNITS = {"kdaN": ("daN", 1000.0)}
"""Units of WITS that no other file of this package has."""
SET_POINTS = ("weight_on_bit", "surface_rotation")
"""Quantities that can be commanded."""


class SignalsError(DrillTwinError):
    """A file of signals that cannot be used; the message has file and line."""


_FILE = ForeignFile("a file of signals", LARGEST_TEXT, SignalsError)


@dataclass(frozen=True)
class Signal:
    """Quantity in a unit."""

    quantity: str
    """Key of `QUANTITIES`; of a signal of the rig, key of `MEASURED`; of a set-point, one of `SET_POINTS`."""
    unit: str
    """Unit on the server."""
    factor: float
    """SI value of one unit."""


@dataclass(frozen=True)
class ShownSignal(Signal):
    """Signal of the twin on the OPC UA server."""

    name: str
    """Name of its node."""
    kind: str
    """Class: prototype of D-WIS, proposed one, or a name of the user."""


@dataclass(frozen=True)
class CommandTarget(Signal):
    """Set-point that a client with control writes."""

    name: str
    """Name of its node."""
    low: float
    """Smallest value taken, in the unit."""
    high: float
    """Largest value taken, in the unit."""


@dataclass(frozen=True)
class RigSignal(Signal):
    """Signal of the rig, on its server."""

    node: str
    """Node id on the rig's server, as `ns=2;s=WOB` or `nsu=urn:rig;s=WOB`."""
    low: float
    """Smallest value that is used, in the unit."""
    high: float
    """Largest value that is used, in the unit."""
    stale_after: float
    """Age of its stamp at which it is not used any more [s]; 0: none."""
    frozen_after: float
    """Time without a change at which it is not used any more [s]; 0: none."""
    is_typed: bool = False
    """True for a set-point, which a person types: a number that sensors send for no value is one."""


Limits = dict[str, tuple[float, float]]
"""Lowest and highest set-point that the simulator takes, by quantity [SI]; empty while it has not told them."""


def why_refused(signal: CommandTarget | RigSignal, value: float, limits: Limits) -> str:
    """Reason why a set-point in its unit is refused, by the file's range and the simulator's; empty if it is taken."""
    low, high = (one / signal.factor for one in limits.get(signal.quantity, (-math.inf, math.inf)))
    low, high = max(low, signal.low), min(high, signal.high)
    if not (math.isfinite(low) and math.isfinite(high)):
        return "expected a simulator, whose diagnostics tell its limits, or low and high in the file, found none so far"
    return "" if low <= value <= high else f"expected {low:g} to {high:g} {signal.unit}, found {value:g} {signal.unit}"


class Signals(NamedTuple):
    """Signals of a gateway."""

    show: tuple[ShownSignal, ...] = ()
    """Twin -> OPC UA."""
    command: tuple[CommandTarget, ...] = ()
    """OPC UA -> twin."""
    measure: tuple[RigSignal, ...] = ()
    """Server of the rig -> `/measured/rig/state` and `/measured/downhole/SUB/summary`."""
    follow: tuple[RigSignal, ...] = ()
    """Set-points on the server of the rig -> twin."""


def signals_path(name: str) -> Path:
    """File of signals, by its path or the name of an installed one.

    Raises:
        SignalsError: There is none.
    """
    known = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.yaml"))}
    path = known.get(name, Path(name))
    if not path.is_file():
        raise SignalsError(f"{name}: expected a file of signals or one of {', '.join(known)}, found none of that name")
    return path


def read_signals(path: Path) -> Signals:
    """Signals of a file.

    Raises:
        SignalsError: The file cannot be read, or a line is not valid.
    """
    data, lines = read_yaml(_FILE.text(path), str(path))
    return _Reader(path, lines).signals(data)


class _Reader:
    def __init__(self, path: Path, lines: Mapping[Place, int]) -> None:
        self._path, self._lines = path, lines

    def signals(self, data: Any) -> Signals:
        if not isinstance(data, dict) or not data:
            raise self._error((), f"expected the sections {', '.join(_SECTIONS)}, found none")
        self._known((), data, tuple(_SECTIONS))
        show, command, measure, follow = (self._section(data, name) for name in _SECTIONS)
        return Signals(
            tuple(
                ShownSignal(*self._quantity(("show", name), line), name, str(line.get("class", name)))
                for name, line in show.items()
            ),
            tuple(
                CommandTarget(*self._quantity(place, line, SET_POINTS), name, *self._range(place, line))
                for name, line in command.items()
                for place in [("command", name)]
            ),
            tuple(self._of_rig(("measure", name), line) for name, line in measure.items()),
            tuple(self._of_rig(("follow", name), line) for name, line in follow.items()),
        )

    def _section(self, data: Mapping[str, Any], name: str) -> dict[str, dict[str, Any]]:
        section = data.get(name) or {}
        if not isinstance(section, dict):
            raise self._error((name,), f"{name}: expected a line a signal, found {show(section)}")
        for signal, line in section.items():
            if not isinstance(line, dict):
                raise self._error((name, signal), f"{signal}: expected {{value: ..., unit: ...}}, found {show(line)}")
            self._known((name, signal), line, _SECTIONS[name])
        return section

    def _of_rig(self, place: Place, line: Mapping[str, Any]) -> RigSignal:
        known = SET_POINTS if place[0] == "follow" else tuple(MEASURED)
        if place[0] == "measure" and all(downhole(str(place[-1]))):
            known = (str(place[-1]),)
        quantity, unit, factor = self._quantity(place, {"value": place[-1], **line}, known)
        node = line.get("node")
        if not isinstance(node, str) or "=" not in node:
            raise self._error(place, f'{quantity}: expected a node such as "ns=2;s=WOB", found {show(node)}')
        times = [line.get("stale_after", _STALE_AFTER), line.get("frozen_after", 0.0)]
        if not all(isinstance(one, int | float) and 0.0 <= one < math.inf for one in times):
            raise self._error(place, f"{quantity}: expected times [s] from 0, found {' and '.join(map(show, times))}")
        low, high = self._range(place, line)
        stale, frozen = map(float, times)
        return RigSignal(quantity, unit, factor, node, low, high, stale, frozen, is_typed=place[0] == "follow")

    def _range(self, place: Place, line: Mapping[str, Any]) -> tuple[float, float]:
        low, high = (line.get(key, default) for key, default in (("low", -math.inf), ("high", math.inf)))
        if not (isinstance(low, int | float) and isinstance(high, int | float) and low < high):
            raise self._error(place, f"{place[-1]}: expected numbers low < high, found {show(low)}, {show(high)}")
        return float(low), float(high)

    def _quantity(
        self, place: Place, line: Mapping[str, Any], known: tuple[str, ...] = tuple(QUANTITIES)
    ) -> tuple[str, str, float]:
        """Quantity, unit and its SI factor."""
        quantity, unit = str(line.get("value", "")), str(line.get("unit", ""))
        self._known((*place, "value"), (quantity,), known)
        dimension = measured_dimension(quantity)
        base, multiple = _WITS_UNITS.get(unit, (unit, 1.0))
        try:
            return quantity, unit, multiple * factor_of(base, dimension)
        except UnitError as error:
            raise self._error((*place, "unit"), f"{place[-1]}: {error}") from None

    def _known(self, place: Place, found: Mapping[str, Any] | tuple[str, ...], known: tuple[str, ...]) -> None:
        for name in found:
            if name not in known:
                told = f"expected one of {', '.join(known)}, found {show(name)}{nearest(name, known)}"
                raise self._error((*place, name), told)

    def _error(self, place: Place, message: str) -> SignalsError:
        line = next((self._lines[place[:n]] for n in range(len(place), -1, -1) if place[:n] in self._lines), 1)
        return SignalsError(f"{self._path}:{line}: {message}")
