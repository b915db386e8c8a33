# SPDX-License-Identifier: Apache-2.0
"""The faults: a text of a source file that occurs once, what replaces it, and the tests that must fail then."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """One fault."""

    name: str
    """Description, unique."""
    file: str
    """Source file, relative to the repository."""
    old: str
    """Text of the file, found exactly once."""
    new: str
    """Text that takes its place."""
    test: str
    """Test file, relative to the repository."""
    only: str = ""
    """Expression of pytest's `-k`; all tests of the file where it is empty."""

    @property
    def command(self) -> tuple[str, ...]:
        """Arguments of pytest that select the tests."""
        return (self.test, *(("-k", self.only) if self.only else ()))


_CASES = "evidence/test/verify/test_cases.py"

FAULTS = (
    # Input and output
    Fault(
        "unit: pound-force mistyped in the fifth digit",
        "drill_twin/core/units/registry.py",
        "4.4482216152605",
        "4.4428216152605",
        "test/scene/test_units.py",
        "oilfield",
    ),
    Fault(
        "unit: single speed command in rad/s instead of rev/s",
        "drill_twin/io/messages/rig_messages.py",
        "command.rotation) / math.tau)",
        "command.rotation))",
        "test/io/messages/test_frame_messages.py",
    ),
    Fault(
        "swapped field: angles of the top drive and of the bit",
        "drill_twin/core/rig_channels.py",
        '"top_drive", "angle of the top drive"),\n    "bit_angle": RigChannel(ANGLE, "position", "bit"',
        '"bit", "angle of the top drive"),\n    "bit_angle": RigChannel(ANGLE, "position", "top_drive"',
        "test/io/messages/test_frame_messages.py",
    ),
    Fault(
        "sign: the wall pulls the string outwards in /marks/state",
        "drill_twin/io/messages/encode.py",
        "np.asarray(-wall_force[",
        "np.asarray(wall_force[",
        "test/io/messages/test_frame_messages.py",
    ),
    Fault(
        "wrong frame id",
        "drill_twin/io/messages/topics.py",
        'FRAME_ID = "hole"',
        'FRAME_ID = "map"',
        "test/io/bag/test_bag_writer.py",
        "schemas_in_the_file",
    ),
    Fault(
        "lost message: the first one of each further file of a bag",
        "drill_twin/io/bag/writer.py",
        "                self._open_next()\n",
        "                self._open_next()\n                return\n",
        "test/io/bag/test_bag_writer.py",
        "split_bag",
    ),
    Fault(
        "chunk of a bag not flushed",
        "drill_twin/io/bag/file_writer.py",
        '        """Close the open chunk and pass it to the operating system."""\n        try:\n'
        "            self._writer.flush()  # type: ignore[no-untyped-call]\n",
        '        """Close the open chunk and pass it to the operating system."""\n        try:\n'
        "            self._stream.flush()\n",
        "test/io/bag/test_bag_killed.py",
        "flushed",
    ),
    Fault(
        "swapped component: set-points of a checkpoint",
        "drill_twin/dynamics/twin/checkpoint.py",
        'Command(*map(float, head["set_points"]))',
        'Command(*map(float, head["set_points"][::-1]))',
        "test/dynamics/twin/test_checkpoint.py",
    ),
    # Analysis
    Fault(
        "off-by-one: mean of a bin over one sample too many",
        "drill_twin/whirl/sample_bins.py",
        "found = n - bins.missed[k]",
        "found = n + 1 - bins.missed[k]",
        "test/whirl/test_precession.py",
    ),
    Fault(
        "wrong divisor: the whirl frequency over the rotation in place of the time",
        "drill_twin/whirl/frequency.py",
        "hz, ratio = float(swept.sum() / length.sum())",
        "hz, ratio = float(swept.sum() / rotated.sum())",
        "test/whirl/test_frequency.py",
    ),
    Fault(
        "sign: left-hand rotation counted as right-hand",
        "drill_twin/whirl/sample_bins.py",
        "clock.angle[0] += increment",
        "clock.angle[0] += abs(increment)",
        "test/whirl/test_precession.py",
    ),
    # Run
    Fault(
        "formula: slope at the ends of the STEP set-point",
        "drill_twin/scene/set_points/schedule.py",
        "x * x * (3.0 - 2.0 * x)",
        "x * x * (2.0 - x)",
        "test/scene/set_points/test_schedule_shapes.py",
    ),
    Fault(
        "real-time factor over computing time instead of wall time",
        "drill_twin/runs/monitor.py",
        "return _ratio(self.simulated, self._wall)",
        "return _ratio(self.simulated, self._computing)",
        "test/runs/test_run_timing.py",
    ),
    Fault(
        "ignored limit: the largest speed of the parameters",
        "drill_twin/ros/simulator/command_limits.py",
        "speed = settings.max_speed or _largest",
        "speed = _largest",
        "test/ros/test_command_arbiter.py",
    ),
    Fault(
        "quality of service: a latched topic is volatile",
        "drill_twin/ros/core/topics.py",
        "latched=row.offered_latched)",
        "latched=False)",
        "test/ros/test_record_and_replay.py",
        "joins_late",
    ),
    Fault(
        "stale kernel: the hash misses modules imported from a package",
        "drill_twin/core/compile/source_hash.py",
        'yield f"{origin}.{name}" if name and _path(f"{origin}.{name}") else origin',
        "yield origin",
        "test/core/compile/test_what_is_compiled.py",
        "named_by_every_source",
    ),
    # Rooms that came last: estimation, maps, ensemble, gateway, analysis of a downhole tool
    Fault(
        "sign: members turned away from the measured phase",
        "companions/drill_twin_studies/drill_twin_studies/estimation/phase.py",
        "predicted[:, known].conj() * measured[known])",
        "predicted[:, known] * measured[known].conj())",
        "companions/drill_twin_studies/test/estimation/test_downhole_correction.py",
        "turned_to_the_measured_phase",
    ),
    Fault(
        "missing root: the correction shrinks the spread of the members twice",
        "companions/drill_twin_studies/drill_twin_studies/estimation/square_root_filter.py",
        "(1.0 / np.sqrt(left) - 1.0)",
        "(1.0 / left - 1.0)",
        "companions/drill_twin_studies/test/estimation/test_square_root_filter.py",
    ),
    Fault(
        "stale set-point: the first of a window is held, not the last",
        "companions/drill_twin_studies/drill_twin_studies/estimation/intake.py",
        "self._held[name] = points[-1]",
        "self._held[name] = points[0]",
        "companions/drill_twin_studies/test/estimation/test_intake.py",
        "interpolated_and_held",
    ),
    Fault(
        "ignored boundary: out of a whirl the advice is that from rest",
        "companions/drill_twin_studies/drill_twin_studies/maps/advice.py",
        "allowed = self._safe if whirls else self.map.calm",
        "allowed = self.map.calm",
        "companions/drill_twin_studies/test/maps/test_advice.py",
    ),
    Fault(
        "swapped axis: margins of a map along weight and speed",
        "companions/drill_twin_studies/drill_twin_studies/maps/operating_map.py",
        "((0, other[other[:, 1] == j, 0]), (1, other[other[:, 0] == i, 1]))",
        "((1, other[other[:, 0] == i, 1]), (0, other[other[:, 1] == j, 0]))",
        "companions/drill_twin_studies/test/maps/test_advice.py",
    ),
    Fault(
        "stale rows: a member that fails keeps the frames of the part before",
        "drill_twin/runs/ensemble/parts.py",
        "yield part.first(count)",
        "yield part",
        "test/runs/ensemble/test_ensemble.py",
        "reported_with_what_came_before",
    ),
    Fault(
        "ignored limit: a heartbeat that stands still keeps control",
        "companions/drill_twin_rig/drill_twin_rig/gateway/control.py",
        "if value != self._beat[0]:",
        "if self.user is user:",
        "companions/drill_twin_rig/test/gateway/test_control.py",
    ),
    Fault(
        "missing factor: a value of the rig is passed on in its own unit",
        "companions/drill_twin_rig/drill_twin_rig/gateway/rig_reader.py",
        "float(reading.value) * self._signal.factor",
        "float(reading.value)",
        "companions/drill_twin_rig/test/gateway/test_signal_quality.py",
    ),
    Fault(
        "sign: gravity by the tilt of a downhole tool",
        "drill_twin/whirl/downhole/motion.py",
        "kept.acceleration + self._axial * kept.tilt",
        "kept.acceleration - self._axial * kept.tilt",
        "test/whirl/test_downhole.py",
        "tilted_section or sense_ratio",
    ),
    Fault(
        "sign: a section that turns to the left counts as at rest",
        "drill_twin/whirl/downhole/sub_findings.py",
        "math.copysign(1.0, mean) * speed < criteria.STANDSTILL",
        "speed < criteria.STANDSTILL",
        "test/whirl/test_downhole.py",
        "stick_slip",
    ),
    # Physics: each costs a compilation of a kernel
    Fault(
        "dropped term: drag across the string in y",
        "drill_twin/physics/effects/drag.py",
        "    load[1] -= c * here.vy\n",
        "",
        "evidence/test/verify/test_conservation.py",
        "invariance and lateral",
    ),
    Fault(
        "swapped component: the low side of an inclined hole",
        "drill_twin/physics/effects/gravity.py",
        "np.array([np.sin(model.inclination), 0.0,",
        "np.array([0.0, np.sin(model.inclination),",
        _CASES,
        "weight_on_the_wall and lateral",
    ),
    Fault(
        "mis-scaled torque of the bit, 2 %",
        "drill_twin/physics/effects/bit_torque_tanh.py",
        "scale, square = law.arm * weight,",
        "scale, square = 1.02 * law.arm * weight,",
        _CASES,
        "smooth_torque_law",
    ),
    Fault(
        "sign: spin in the slip of the contact point",
        "drill_twin/physics/effects/wall_friction.py",
        "+ r * here.spin_rate",
        "- r * here.spin_rate",
        _CASES,
        "pure_rolling and lateral",
    ),
    Fault(
        "sign: loss of the wall on approach",
        "drill_twin/physics/effects/wall.py",
        "factor = max(1.0 + wall.damping * closing, 0.0)",
        "factor = max(1.0 - wall.damping * closing, 0.0)",
        _CASES,
        "restitution",
    ),
    Fault(
        "dropped term: couple of internal damping on the spin",
        "drill_twin/physics/effects/internal_damping.py",
        "    resultants[COUPLE] += mx * strain.px + my * strain.py + mz * strain.pz\n",
        "",
        "evidence/test/verify/test_conservation.py",
        "damped_conical_swing",
    ),
    Fault(
        "ignored limit: torque of the motor",
        "drill_twin/dynamics/solver/boundary.py",
        "return max(-drive.limit, min(drive.limit, torque))",
        "return torque",
        "test/physics/effects/test_top_drive.py",
        "keeps_to_its_limit",
    ),
)
"""In the order of the table."""
