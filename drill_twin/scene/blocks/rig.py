# SPDX-License-Identifier: Apache-2.0
"""The `rig:` part of a scene: weight on bit and rotation over time, top drive, recorded table."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from drill_twin.core.companions import entries
from drill_twin.core.units import AngularSpeed, Force, Length, Speed, Stiffness, Time, Torque, Within
from drill_twin.physics.effects.config import Part, Problem, refuse_all
from drill_twin.scene.blocks.top_drive import TopDrive

GROUP = "drill_twin.schedules"
"""Entry-point group of shapes in other packages: the entry's name is the shape in a scene, its value a function
(``saw = my_package.shapes:saw``) from a set-point to its value over time."""
BUILT_IN = ("constant", "step", "ramp", "table")
"""Shapes of this package; another package cannot replace them."""
ADDED = {entry.name: entry for entry in entries(GROUP) if entry.name not in BUILT_IN}
"""Entry points of the shapes of other packages, by name."""
SHAPES = (*BUILT_IN, *sorted(ADDED))
"""Names of all shapes."""
if TYPE_CHECKING:
    Shape = str
else:
    Shape = Literal[SHAPES]
LARGEST_LOAD, FASTEST_BLOCK, FASTEST_ROTATION = 1e8, 10.0, 100.0
"""Largest set-points, up and down: weight on bit [N], speed of the block [m/s] and of the top drive [rev/s]."""
_LoadRange = Within(at_least="-100 MN", at_most="100 MN")
_BlockRange = Within(at_least="-10 m/s", at_most="10 m/s", reason="no block moves faster")
_SpeedRange = Within(at_least="-100 rev/s", at_most="100 rev/s", reason="no rig turns faster")


class SetPoint(Part):
    """Set-point over time."""

    needs_value: ClassVar[bool] = True
    """False for a set-point that is zero unless the scene has a `value`."""
    shape: Shape = "constant"
    """`constant`: `value` throughout; `step`: smooth cubic from `initial` to `value` (STEP of ADAMS); `ramp`: straight
    line; `table`: the column in `rig.table`; or a shape of another package (entry points `drill_twin.schedules`)."""
    start: Annotated[Time, Within(at_least="0 s", at_most="1e6 s")] = 0.0
    """Time at which the change begins [s]."""
    duration: Annotated[Time, Within(at_least="0 s", at_most="1e6 s")] = 0.0
    """Duration of the change [s]; 0 s = a jump."""
    initial: float = 0.0
    value: float = 0.0

    @model_validator(mode="before")
    @classmethod
    def _has_a_value(cls, data: Any) -> Any:
        needed = isinstance(data, dict) and cls.needs_value and data.get("shape") != "table"
        if needed and data.get("at") != "block" and "value" not in data:
            field = cls.model_fields["value"]
            expected = next(part.dimension.expected for part in field.metadata if hasattr(part, "dimension"))
            raise refuse_all([(("value",), f"expected {expected}, found nothing (the key is required)")])
        return data

    def problems(self) -> Iterator[Problem]:
        """Keys that the shape does not use."""
        changes = ("initial", "start", "duration")
        for key in {"constant": changes, "table": ("value", *changes)}.get(self.shape, ()):
            if getattr(self, key) != 0.0:
                others = f'shapes "step" and "ramp" take it; `{key}: ~` takes away the value of the base'
                yield (key,), f'expected no `{key}` with shape "{self.shape}", found one; {others}'


class WeightOnBit(SetPoint):
    """Weight on bit; negative = tension."""

    value: Annotated[Force, _LoadRange] = 0.0
    """Final weight on bit [N]."""
    initial: Annotated[Force, _LoadRange] = 0.0
    """Weight on bit before `start` [N]."""
    at: Literal["bit", "top", "block"] = "bit"
    """Point of application of the load: upwards at the bit, or at the top; `block`: none, the top hangs in `rig.block`,
    and the weight is what its motion and the rock make of it."""


class Rotation(SetPoint):
    """Speed of the top drive; positive is right-handed about the upward axis."""

    value: Annotated[AngularSpeed, _SpeedRange] = 0.0
    """Final speed [rad/s]."""
    initial: Annotated[AngularSpeed, _SpeedRange] = 0.0
    """Speed before `start` [rad/s]."""


class AutoDriller(Part):
    """Controller that lowers the block to hold the weight on bit, as surface measurements give it: the string's weight
    less the hookload. Rate and torque are upper limits, so the one reached first is held.
    """

    rate: Annotated[Speed, Within(above="0 m/s", at_most="1 m/s")]
    """Fastest lowering, and lifting, of the block [m/s]: the rate of penetration that is held under a large weight."""
    torque: Annotated[Torque, Within(above="0 N m", at_most="1e8 N m")] | None = None
    """Torque of the top drive on the string that is held [N m]; no limit if left out."""
    response: Annotated[Time, Within(at_least="0.01 s", at_most="1e4 s")] = 2.0
    """Time constant T of the weight [s]: proportional gain 1 / (k T), k the stiffness of lines and string in series,
    integral gain half of it over T."""


class Block(SetPoint):
    """Speed of the travelling block, which carries the string's top on the drilling lines; positive is upwards."""

    needs_value: ClassVar[bool] = False
    value: Annotated[Speed, _BlockRange] = 0.0
    """Final speed [m/s]; none with an auto-driller."""
    initial: Annotated[Speed, _BlockRange] = 0.0
    """Speed before `start` [m/s]."""
    stiffness: Annotated[Stiffness, Within(above="0 N/m", at_most="1e12 N/m")] = 1e8
    """Stiffness of drilling lines and derrick between block and top [N/m]."""
    off_bottom: Annotated[Length, Within(at_least="0 m", at_most="1000 m")] = 0.0
    """Height of the bit above the rock at the start [m]."""
    auto_driller: AutoDriller | None = None
    """Auto-driller, whose set-point is `rig.weight_on_bit`; it moves the block from the start on."""

    def problems(self) -> Iterator[Problem]:
        """As of every set-point, and a speed beside an auto-driller."""
        yield from super().problems()
        if self.auto_driller is not None and (self.value != 0.0 or self.initial != 0.0):
            yield (
                ("auto_driller",),
                "expected either a speed or `auto_driller`, which moves the block itself, found both",
            )


class Column(Part):
    """Column of a recorded table."""

    column: Annotated[str, Field(min_length=1, max_length=200)]
    """Header of the column in a CSV file, or name of the variable in a MAT file."""
    unit: str
    """Unit of its numbers, such as `rpm`."""


class RecordedTable(Part):
    """Recorded set-points of a rig; without `file` the scene loads, but cannot be run."""

    file: str = ""
    """CSV, MAT, LAS or WITSML file; paths begin at the scene file, in overrides at the working folder."""
    time: Column | None = None
    """Time stamps."""
    weight_on_bit: Column | None = None
    """Measured weight on bit."""
    rotation: Column | None = None
    """Measured speed of the top drive."""
    start: Annotated[Time, Within(at_least="0 s", at_most="1e6 s")] = 0.0
    """Start of the playback in the record, from its first stamp [s]."""
    longest_gap: Annotated[Time, Within(above="0 s", at_most="1e6 s")] = 1.0
    """Longest gap to be interpolated linearly [s]; longer gaps are errors."""
    spike_window: Annotated[Time, Within(at_least="0 s", at_most="100 s")] = 0.1
    """Width of the median filter that detects spikes [s]; 0 s = keep them."""


class Rig(Part):
    """Set-points of the rig and duration of the run."""

    weight_on_bit: WeightOnBit = WeightOnBit(value=0.0)
    """Weight on bit over time."""
    rotation: Rotation = Rotation(value=0.0)
    """Top-drive speed over time."""
    block: Block | None = None
    """Travelling block over time, with `rig.weight_on_bit.at: block`."""
    top_drive: TopDrive = TopDrive()
    """Top drive."""
    duration: Annotated[Time, Within(above="0 s", at_most="1e6 s")]
    """Simulated time [s]."""
    start: Literal["axis", "rotating", "equilibrium", "whirl-state"] = "axis"
    """Initial state. `axis`: the string on the axis of the hole, at rest, set-points from their `initial`. `rotating`:
    the string turns at the first set-points and lies on the wall in balance, twisted by the resisting torques; where
    no balance is found, as of buckled pipe, it turns on the axis; under a record it begins at rest. `equilibrium`: the
    set-points hold their `value` from the first instant; the string is in static equilibrium under that weight, twisted
    by the resisting torques, and rotates rigidly. `whirl-state`: the set-points hold their `value` too; the string is
    in a steady whirl, a stable one if there is one (`drill-twin whirl`)."""
    table: RecordedTable | None = None
    """Recorded table of the set-points of shape `table`."""

    def problems(self) -> Iterator[Problem]:
        """A shape `table` without a table, a start that does not fit, and what contradicts the block."""
        for key in ("weight_on_bit", "rotation"):
            is_recorded = getattr(self, key).shape == "table"
            if is_recorded and self.table is None:
                yield (key, "shape"), 'expected `rig.table` with shape "table", found none'
            if is_recorded and self.holds_values:
                text = f'expected "axis" or "rotating" with a recorded `{key}`, found "{self.start}": it has no `value`'
                yield ("start",), text
        weight, block = self.weight_on_bit, self.block
        if (weight.at == "block") != (block is not None):
            found = "no `rig.block`" if block is None else f"`at: {weight.at}`"
            text = f"expected `rig.weight_on_bit.at: block` and `rig.block` together, found {found}"
            yield ("weight_on_bit", "at"), text
        if block is None or weight.at != "block":
            return
        driller = block.auto_driller
        checks = (
            (block.shape == "table", ("block", "shape"), 'expected "constant", "step" or "ramp", found "table"'),
            (self.holds_values, ("start",), f'expected "axis" or "rotating" with a block, found "{self.start}"'),
            (driller is None and any((weight.value, weight.initial, weight.shape == "table")), ("weight_on_bit",),
             "expected no weight without `rig.block.auto_driller`, which holds a weight, found one"),
            (block.off_bottom > 0.0 and weight.initial != 0.0, ("weight_on_bit", "initial"),
             "expected no weight at the start off bottom, found one; `initial: ~` takes away the value of the base"),
            (driller is not None and driller.torque is not None and self.top_drive.model == "prescribed",
             ("block", "auto_driller", "torque"),
             "expected a top drive with a motor (`rig.top_drive.model`) to hold its torque, found a prescribed speed"),
        )  # fmt: skip
        for wrong, place, text in checks:
            if wrong:
                yield place, text

    @property
    def moves_block(self) -> bool:
        """The speed of the block is a set-point: there is a block, and no auto-driller moves it."""
        return self.block is not None and self.block.auto_driller is None

    @property
    def first(self) -> tuple[float, float]:
        """Weight on bit [N] and speed of the top drive [rad/s] at the first instant; 0 for recorded set-points."""
        load, turn = (self._first_of(point) for point in (self.weight_on_bit, self.rotation))
        return load, turn

    @property
    def holds_values(self) -> bool:
        """The set-points hold their `value` from the first instant, whatever their shape."""
        return self.start in {"equilibrium", "whirl-state"}

    def _first_of(self, point: SetPoint) -> float:
        jumps = point.shape in {"step", "ramp"} and point.start == point.duration == 0.0
        begun = self.start == "rotating" and (point.shape == "constant" or jumps)
        return point.value if self.holds_values or begun else point.initial
