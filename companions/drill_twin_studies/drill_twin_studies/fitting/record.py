# SPDX-License-Identifier: Apache-2.0
"""Records to fit to: channels of a rig over time, in SI, from a CSV, MAT, LAS or WITSML file or a bag."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError, TableError
from drill_twin.core.rig_channels import FIELDS, INSTANT, channel_of
from drill_twin.core.units import Dimension
from drill_twin.core.units.dimension import ANGULAR_SPEED
from drill_twin.scene.records import read_columns
from drill_twin.scene.records.channels import BLOCK, NULL, ChannelColumn, channel_column

_COMPUTED = ("torque", "motor_torque", "top_drive_speed", "bit_speed", "bit_torque", "bit_force", "hookload")
CHANNELS: Mapping[str, Dimension] = {name: channel_of(name).dimension for name in _COMPUTED}
"""Channels that a run computes (`drill_twin.runs.ensemble.outputs.Channels`), and their dimensions."""
SET_POINTS: Mapping[str, Dimension] = {name: channel_of(name).dimension for name in ("weight_on_bit", "rotation")}
"""Set-points of a rig, as commanded or indicated, and dimensions: inputs of the estimator."""
_KNOWN = {**CHANNELS, **SET_POINTS}
GAP = 2.5
"""Distance of two samples over the usual distance, from which there is a gap between the two; not measured."""
_OF_BAG = {name: FIELDS[name] for name in _KNOWN if name != "motor_torque"}


@dataclass(frozen=True)
class Record:
    """Channels over time.

    Attributes:
        source: File or bag of the record.
        series: Time [s] and values [SI] by channel, each of shape (rows,).
        subs: Time [s] and readings (force, rates) by downhole sub, `measured/NAME` for subs of a real rig, shapes
            (rows,) and (rows, 6); of a bag only, if asked for.
        instant: Channels whose samples are values at their times; other samples are means since the last sample.
        ends: Channels whose means are stamped with their end, as in files; other means are stamped with their middle.
        notes: Sentences on what was left out of a file and on its units, for the user.
    """

    source: str
    series: Mapping[str, tuple[Array, Array]]
    subs: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    instant: frozenset[str] = frozenset()
    ends: frozenset[str] = frozenset()
    notes: Sequence[str] = ()

    def at(self, channel: str, time: Array) -> Array:
        """Means over the spacing before each of equally spaced times [s], as of a run; linear in a coarser record.

        Of a channel whose samples are instants: its values at these times.

        NaN in a gap: where the samples beside the middle of the mean lie `GAP` times their usual distance apart, and
        farther than the times.

        Raises:
            ArgumentError: The record has no values over a part of the times.
        """
        stamps, values = self.series[channel]
        spacing = float(time[1] - time[0])
        if time[0] < stamps[0] - spacing or time[-1] > stamps[-1] + spacing:
            raise ArgumentError(
                f"{self.source}: expected {channel} from {time[0]:g} s to {time[-1]:g} s, "
                f"found {stamps[0]:g} s to {stamps[-1]:g} s; choose another window"
            )
        usual, middle = float(np.median(np.diff(stamps))), time - (0.0 if channel in self.instant else 0.5 * spacing)
        stamps = stamps - 0.5 * usual if channel in self.ends else stamps
        after = np.clip(np.searchsorted(stamps, middle), 1, stamps.size - 1)
        missing = stamps[after] - stamps[after - 1] > max(GAP * usual, spacing)
        if usual > 0.5 * spacing or channel in self.instant:
            return np.where(missing, np.nan, np.interp(middle, stamps, values))
        edges = np.clip(np.append(time - spacing, time[-1]), stamps[0], stamps[-1])
        total = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(stamps))))
        return np.where(missing, np.nan, np.diff(np.interp(edges, stamps, total)) / np.diff(edges))


def read_record(
    path: str | Path, columns: Sequence[str | ChannelColumn], *, start: float = 0.0, subs: Sequence[str] = ()
) -> Record:
    """Read channels of a CSV, MAT, LAS or WITSML file, or of `/rig/state` of a bag.

    Args:
        path: The file; a bag may be a folder.
        columns: Names of channels of a bag; of a file column and unit of each channel, of the set-points
            `weight_on_bit` and `rotation` and of `time`, and null values (`null_value=-555`), as `channel_column`
            parses them. Set-points of a bag come from `/rig/command`; where it has none, load and speed of
            `/rig/state`. Without `time`, times come from the column whose name begins with ``time`` or ``t_``, in s
            where the file gives no unit.
        start: Time in the record that is time zero of the scene [s].
        subs: Downhole subs of a bag whose readings are read too, `measured/NAME` for subs of a real rig.

    Raises:
        TableError: No such file or column, or no unit or a unit of another dimension.
        ArgumentError: No channel, one twice, a channel or sub that a bag does not hold, or subs of a file.
    """
    file = Path(path)
    items = [channel_column(item) if isinstance(item, str) else item for item in columns]
    instant = frozenset(item.channel.removesuffix(INSTANT) for item in items if item.channel.endswith(INSTANT))
    items = [item._replace(channel=item.channel.removesuffix(INSTANT)) for item in items]
    names = [item.channel for item in items if item.channel not in {NULL, BLOCK}]
    if not {*names} - {"time"}:
        raise ArgumentError(
            f"channel: expected one or more, as bit_speed=COLUMN:rpm, found {', '.join(names) or 'none'}"
        )
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ArgumentError(f"channel: expected each one once, found {', '.join(twice)} again; give it one column")
    if file.is_dir() or file.suffix in {".mcap", ".db3"}:
        return replace(_of_bag(file, items, start, subs), instant=instant)
    if subs and file.exists():
        raise ArgumentError(
            f"{file}: expected a bag, which alone has readings of subs, found a file; leave out {', '.join(subs)}"
        )
    found = read_columns(file, [f"{channel}={column}{unit and ':'}{unit}" for channel, column, unit in items])
    time = found.channel("time", "s").values - start
    values = {channel: found.channel(channel).values for channel in names if channel != "time"}
    series = {channel: _present(file, channel, time, column) for channel, column in values.items()}
    return Record(str(file), series, instant=instant, ends=frozenset(CHANNELS) - instant, notes=found.told)


def _of_bag(path: Path, items: Sequence[ChannelColumn], start: float, subs: Sequence[str]) -> Record:
    from drill_twin.io.bag.sensor_series import Measured
    from drill_twin.report.recording import Recording
    from drill_twin.report.selection import Selection, open_bag

    for channel, column, unit in items:
        if channel not in _OF_BAG:
            raise ArgumentError(f"channel: expected of a bag one of {', '.join(_OF_BAG)}, found {channel!r}")
        if column or unit:
            raise ArgumentError(
                f'channel: expected of a bag the name alone, as "{channel}", found "{channel}={column}'
                f'{unit and ":"}{unit}"; a bag has topics in SI, no columns'
            )
    bag = open_bag(path, Selection())
    recording = Recording(bag)
    rig, commands = recording.rig, recording.commands
    time = np.asarray(rig.time) - start
    middle = time - 0.5 * float(np.median(np.diff(time)))  # forces and torques are means of a frame
    series = {}
    for channel, _, _ in items:
        if channel in SET_POINTS and len(commands):
            stamps, values = np.asarray(commands.time) - start, getattr(commands, channel)
        else:
            stamps = time if _KNOWN[channel] is ANGULAR_SPEED else middle
            values = np.asarray(getattr(rig, _OF_BAG[channel]))
        series[channel] = _present(path, channel, stamps, values)
    found = Measured(bag).subs if subs else {}
    if odd := [name for name in subs if name not in found or not len(found[name].imu)]:
        raise ArgumentError(
            f"{path}: expected readings of {', '.join(odd)}, found readings of {', '.join(found) or 'none'}"
        )
    readings = {name: found[name].imu for name in subs}
    own = {name: (np.asarray(imu.time) - start, np.asarray(imu.values)) for name, imu in readings.items()}
    return Record(str(path), series, own)


def _present(source: Path, channel: str, time: Array, values: Array) -> tuple[Array, Array]:
    """Time and values without the missing ones."""
    good = np.isfinite(time) & np.isfinite(values)
    found = time[good], values[good]
    if found[0].size < 2 or np.any(np.diff(found[0]) <= 0.0):
        raise TableError(f"{source}: expected two values of {channel} or more at increasing times; mend the record")
    return found
