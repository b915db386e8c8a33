# SPDX-License-Identifier: Apache-2.0
"""Topic contract, one row a topic; source of the tables in README and reference."""

import re
from dataclasses import replace

from drill_twin.io.messages.topic_row import (
    CLOCK,
    DIAGNOSTIC_ARRAY,
    FLOAT64,
    IMU,
    JOINT_STATE,
    MARKER_ARRAY,
    POSE_ARRAY,
    STRING,
    TF_TYPE,
    TIME_REFERENCE,
    Topic,
)

FRAME_ID = "hole"
"""Frame of every stamped message: origin at the top clamp on the hole axis, z up along the axis."""

RIG_COMMAND = "/rig/command"
WOB_COMMAND = "/rig/wob_command"
RPS_COMMAND = "/rig/rps_command"
COMMANDER = "/rig/commander"
RIG_STATE = "/rig/state"
MEASURED_RIG_STATE = "/measured/rig/state"
SURFACE_STATE = "/surface/state"
MEASURED = "/measured"
"""Namespace of what a real rig measures."""
STRING_POSES = "/string/poses"
STRING_MARKERS = "/string/markers"
STRING_STRESS = "/string/stress"
MARKS_STATE = "/marks/state"
WHIRL_STATE = "/whirl/state"
WHIRL_MOTION = "/whirl/motion"
WHIRL_ONSET = "/whirl/onset"
ADVICE_STATE = "/advice/state"
ADVICE_MAP = "/advice/map"
ESTIMATE_STATE = "/estimate/state"
ESTIMATE = "/estimate"
"""Namespace of the twin that is nearest to the rig."""
TWIN_SCENE = "/twin/scene"
OF_NEAREST_TWIN = (TWIN_SCENE, RIG_STATE, MARKS_STATE, STRING_POSES)
"""Topics of that twin."""
TWIN_SUMMARY = "/twin/summary"
REALTIME_FACTOR = "/twin/realtime_factor"
DIAGNOSTICS = "/diagnostics"
CLOCK_TOPIC = "/clock"
TF, TF_STATIC = "/tf", "/tf_static"

_FULL_RATE = "every frame (100-200 Hz)"

_ROWS = (
    Topic(
        RIG_COMMAND,
        JOINT_STATE,
        "rig_driver, gateway, or rig software",
        _FULL_RATE,
        "set-points: `top_drive` velocity [rad/s], `bit_axial` effort = weight on bit [N], `block` velocity [m/s]; "
        "NaN or no joint = as before; `header.frame_id` names the source: the first keeps weight or speed until it is "
        "silent, others are refused; stamp: end of the next frame, wall clock or zero",
    ),
    Topic(WOB_COMMAND, FLOAT64, "a person", "on change", "weight on bit [N], while nobody commands", optional=True),
    Topic(
        RPS_COMMAND, FLOAT64, "a person", "on change", "top-drive speed [rev/s], while nobody commands", optional=True
    ),
    Topic(
        COMMANDER,
        STRING,
        "simulator",
        "on change",
        "who drives: source of `/rig/command`, `by hand` for single values, `anonymous`; a list where weight and speed "
        "have another; empty = nobody",
        latched=True,
    ),
    Topic(
        RIG_STATE,
        JOINT_STATE,
        "simulator",
        _FULL_RATE,
        "as applied, position, velocity, effort: `top_drive` angle [rad], speed [rad/s], torque [N m]; `bit` angle "
        "[rad], speed [rad/s], torque of the rock on it [N m]; `block` position [m], velocity [m/s], hookload [N]; "
        "`bit_axial` depth drilled [m], rate of penetration [m/s], weight on bit [N]; never NaN",
    ),
    Topic(
        MEASURED_RIG_STATE,
        JOINT_STATE,
        "gateway",
        "as the rig is read (10 Hz)",
        "measured on a rig: joints of `/rig/state` of which something is measured, NaN in a field that is not, or "
        "has no sound value; stamp = source timestamp of the newest value",
        optional=True,
    ),
    Topic(
        SURFACE_STATE,
        JOINT_STATE,
        "simulator, where the scene lists it",
        "rate of the scene's `sensors.surface`",
        "measured at the surface: joints `top_drive` and `block` of `/rig/state`, never NaN; torque of the drive, its "
        "own inertia included; angle and block velocity derived from speed and position; stamp = time of the "
        "measurement",
        optional=True,
    ),
    Topic(
        STRING_POSES,
        POSE_ARRAY,
        "simulator",
        _FULL_RATE,
        "pose of every node, 0 = bit: position [m]; orientation turns z into the tangent after the spin",
    ),
    Topic(
        STRING_STRESS,
        JOINT_STATE,
        "simulator",
        _FULL_RATE,
        "of a scene with `fatigue`, per section, in position: `<section>/moment_x`, `/moment_y` [N m] in the turning "
        "material, `/axial_force` [N], `/stress` and `/largest_stress` so far [Pa], `/cycles` and `/damage` so far",
        optional=True,
    ),
    Topic(
        MARKS_STATE,
        JOINT_STATE,
        "simulator",
        _FULL_RATE,
        "per mark `<mark>/x`, `/y`, `/z` [m], `/spin` [rad]; velocity [m/s, rad/s]; effort = normal force of "
        "the wall on the string there [N] (x and y; it has no part along z and no torque)",
    ),
    Topic(
        STRING_MARKERS,
        MARKER_ARRAY,
        "simulator",
        "20-30 Hz",
        "string, hole, marks and contacts for RViz and Foxglove; lateral motion exaggerated, the text says by how much",
    ),
    Topic(
        WHIRL_STATE,
        JOINT_STATE,
        "analyzer",
        _FULL_RATE,
        "per mark, in position: `<mark>/orbit_radius` [m], `/precession` [rad/s, positive = forward], "
        "`/ratio` of precession to rotation, `/confidence` (0 to 1), `/motion` (code); NaN where not known",
    ),
    Topic(
        WHIRL_MOTION,
        DIAGNOSTIC_ARRAY,
        "analyzer",
        "on change and 1 Hz",
        "motion state in words, as the message of the statuses `motion: string`, `motion: <mark>` and `motion: bit` "
        "(stick-slip); values `criterion` that decided and, of the string, `onset`; the level is always OK; codes: "
        "`/whirl/state`, `/twin/summary`",
        latched=True,
    ),
    Topic(
        WHIRL_ONSET,
        TIME_REFERENCE,
        "analyzer",
        "at the start and at the onset",
        "first onset of whirl of the run, none later: `time_ref` its time, 0 = none so far, and again after a reset; "
        "`source` the mark; `header.stamp` when it was announced",
        latched=True,
    ),
    Topic(
        ADVICE_STATE,
        JOINT_STATE,
        "advisor",
        "on change and 1 Hz",
        "in position, never NaN: `advice` (0 none, 1 hold, 2 near a boundary, 3 leave), `weight_on_bit` [N], "
        "`rotation` [rad/s], `regime` (code, -1 outside the map), `whirls`, `existing_whirl` (1 goes on), "
        "`margin/weight_on_bit`, `margin/rotation`, `margin/share` (1e9 without a boundary), `target` (0 or 1), "
        "`target/weight_on_bit`, `target/rotation`, `target/share`; the sentence is in `/diagnostics`",
        optional=True,
    ),
    Topic(
        ADVICE_MAP,
        STRING,
        "advisor",
        "once it has the map",
        "operating map (JSON): ranges, regime of each node, boundaries, calm window",
        latched=True,
        optional=True,
    ),
    Topic(
        ESTIMATE_STATE,
        JOINT_STATE,
        "estimator",
        "each window (1 s)",
        "of the ensemble that follows a rig, in position [SI]: `trust` (0 good, 1 doubtful, 2 unusable), `alarm`, "
        "`whirls` and `chance_of_whirl` (shares of members); for each number and virtual sensor `<name>` (mean), "
        "`<name>/deviation`, `<name>/low`, `<name>/high` (90 % band); the sentence is in `/diagnostics`",
        optional=True,
    ),
    Topic(
        TWIN_SCENE,
        STRING,
        "simulator",
        "at the start",
        "resolved scene (YAML) with a `run` block: version, seed, elements, step",
        latched=True,
    ),
    Topic(
        TWIN_SUMMARY,
        JOINT_STATE,
        "analyzer",
        "5 Hz of simulated time",
        "for a dashboard, in position, never NaN: `rate_of_penetration` [m/s], `weight_on_bit` [N], `rotation` [rad/s] "
        "as means of 0.2 s; `lateral_rms/<mark>`, `lateral_peak/<mark>` [m/s^2] over the last 5 s; `whirl`, "
        "`stick_slip` (codes), `stick_slip_severity` (index); `severity` (grade 0 to 4 of lateral acceleration and "
        "stick-slip), `lateral_severity` (of the former alone), -1 = unknown; `onset` [s, 0 = none so far]; "
        "`realtime_factor`",
    ),
    Topic(
        REALTIME_FACTOR,
        FLOAT64,
        "simulator",
        "1 Hz",
        "real-time factor of the last second: simulated over wall time, 0 while paused",
    ),
    Topic(
        DIAGNOSTICS,
        DIAGNOSTIC_ARRAY,
        "all nodes",
        "1 Hz",
        "health of each node: real-time factor, time of a frame, guard events, age of the command, refused input, "
        "messages unread and dropped",
    ),
    Topic(CLOCK_TOPIC, CLOCK, "simulator", _FULL_RATE, "simulated time, at every pace", keeps_last=True),
)

_SUB = "SUB"
_IMU_MEANING = (
    "sub: specific force [m/s^2] and rate of rotation [rad/s]; x outwards through the sensor, y in the sense of "
    "rotation, z towards the top, turning with the string; covariances = noise; stamp = time of the measurement"
)
_SUMMARY_MEANING = (
    "sub, in position, of each half second or so: least, mean and largest speed [rad/s]; rms and peak of radial, "
    "tangential and axial acceleration about their mean, mean of the radial one [m/s^2]"
)
_LISTED, _OF_A_RIG = "simulator, where the scene lists it", "gateway, or a bag of a rig"
OF_SUBS = (
    Topic(f"/downhole/{_SUB}/imu", IMU, _LISTED, "rate of the sub", _IMU_MEANING, optional=True),
    Topic(f"/downhole/{_SUB}/summary", JOINT_STATE, _LISTED, "as the scene says", _SUMMARY_MEANING, optional=True),
    Topic(f"{MEASURED}/downhole/{_SUB}/imu", IMU, _OF_A_RIG, "rate of the sub", _IMU_MEANING, optional=True),
    Topic(f"{MEASURED}/downhole/{_SUB}/summary", JOINT_STATE, _OF_A_RIG, "as sent up", _SUMMARY_MEANING, optional=True),
)
"""Topics of downhole subs, with SUB for the name of the sub."""
OF_TF = {
    TF: Topic(TF, TF_TYPE, "simulator", "20-30 Hz", "frames of the string", optional=True),
    TF_STATIC: Topic(TF_STATIC, TF_TYPE, "simulator", "once", "frame of the hole", latched=True, optional=True),
}
"""Topics of frames, where the package tf2_msgs is installed; a bag may hold frames of any node."""
_NAMED = re.compile(r"(?:/measured)?/downhole/([A-Za-z][A-Za-z0-9_]{0,59})/(?:imu|summary)")


class _Contract(dict[str, Topic]):
    """Topics by name. Topics of subs and frames are found by name too, but not listed."""

    def __missing__(self, name: str) -> Topic:
        if name in OF_TF:
            return OF_TF[name]
        if not (sub := sub_of(name)):
            raise KeyError(name)
        rows = {row.name.replace(_SUB, sub): row for row in OF_SUBS}
        return replace(rows[name], name=name)

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or name in OF_TF or (isinstance(name, str) and bool(sub_of(name)))


def sub_of(topic: str) -> str:
    """Name of the sub of a topic such as `/downhole/near_bit/imu`; empty for other topics."""
    found = _NAMED.fullmatch(topic)
    return found[1] if found else ""


def imu_topic(sub: str) -> str:
    """Topic of the readings of a sub."""
    return OF_SUBS[0].name.replace(_SUB, sub)


def summary_topic(sub: str) -> str:
    """Topic of the summaries of a sub."""
    return OF_SUBS[1].name.replace(_SUB, sub)


TOPICS: dict[str, Topic] = _Contract({row.name: row for row in _ROWS})
"""Topics of the contract by name; topics of subs (`OF_SUBS`) and frames (`OF_TF`) are found, not listed."""

OF_EVERY_RUN = tuple(name for name, topic in TOPICS.items() if not topic.optional)
"""Topics that each run has."""

GENERIC = frozenset({DIAGNOSTICS, CLOCK_TOPIC, *OF_TF})
"""Topics of any ROS system; a bag with no other topics is not of this package."""
