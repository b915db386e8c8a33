# SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the simulator: named values, and a level with one sentence."""

from __future__ import annotations

import math
from types import SimpleNamespace

from drill_twin.io.messages.diagnostics import Level, Status, exact
from drill_twin.io.messages.topics import RIG_COMMAND, STRING_POSES
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.topics import relative
from drill_twin.ros.simulator.run_control import RunControl
from drill_twin.ros.simulator.simulation import SimulatorRun

_RECENT = 10.0  # s; for so long a single stall is told
_SHARE = 0.01  # of the simulated time; more given up is told until the end


def health(node: TwinNode, control: RunControl) -> Status:
    """Status of the simulator: pace, cost and set-points; begins a new window of the timing."""
    simulation = control.simulation
    values = {"state": control.state_text, **_values(node.settings, simulation)}
    if len(publishers := node.topics.publisher_nodes(STRING_POSES)) > 1:
        topic = node.resolve_topic_name(relative(STRING_POSES))
        text = f"more than one simulator publishes {topic}: {', '.join(publishers)}"
        return Status(node.NAME, Level.ERROR, text, values)
    if not node.active or control.paused:
        return Status(node.NAME, Level.OK, f"{control.state_text} at {simulation.time_text}", values)
    return Status(node.NAME, *_verdict(node.settings, simulation), values)


def _values(settings: SimpleNamespace, simulation: SimulatorRun) -> dict[str, str]:
    arbiter, pacer, written = simulation.commands.arbiter, simulation.pacer, simulation.checkpoints.written
    return {
        "scene": settings.scene,
        "pace": settings.pace,
        **simulation.loop.diagnostics(),
        "overruns": str(pacer.overruns),
        "lag_dropped": f"{pacer.lag_dropped:.3f}",
        "weight_on_bit": f"{arbiter.applied.weight_on_bit:g}",
        "speed_rev_s": f"{arbiter.applied.rotation / math.tau:g}",
        "command_age": f"{arbiter.age:.3f}",
        "commands_accepted": str(arbiter.accepted),
        "commands_refused": str(sum(arbiter.refused.values())),
        **{f"commands_refused_{kind}": str(count) for kind, count in sorted(arbiter.refused.items())},
        "last_refusal": arbiter.last_refusal,
        "range_weight_on_bit": " ".join(map(exact, arbiter.limits.weight_on_bit)),
        "range_surface_rotation": " ".join(map(exact, arbiter.limits.rotation)),
        "commander": arbiter.commander,
        "checkpoint_time": "" if written is None else f"{written:.6f}",
    }


def _verdict(settings: SimpleNamespace, simulation: SimulatorRun) -> tuple[Level, str]:
    """Level and sentence, the most severe first."""
    loop, arbiter, trouble = simulation.loop, simulation.commands.arbiter, simulation.checkpoints.trouble
    waiting = simulation.waits_for_command
    if loop.rejected_steps.stopped:
        return loop.verdict()
    if rivals := simulation.commands.rivals():
        return Level.ERROR, (
            f"expected one publisher of {RIG_COMMAND} as {arbiter.commander}, found several ({', '.join(rivals)}): the "
            "set-points flip between them; stop all but one"
        )
    if waiting and not arbiter.heard and arbiter.refused:
        return Level.WARN, f"waiting for the first good command; the last one was refused: {arbiter.last_refusal}"
    if waiting and not arbiter.heard:
        return Level.OK, "waiting for the first command"
    # Single values are sent on change: who sends one has not fallen silent, unless time or a ramp depends on it.
    if arbiter.silent and not (arbiter.by_hand and settings.on_silence != "ramp" and settings.pace != "lockstep"):
        held = "ramping to the safe set-point" if arbiter.ramps else "the last one is held"
        waits = "the lockstep waits" if settings.pace == "lockstep" else held
        whose = "" if arbiter.by_hand or not arbiter.source else f" of {arbiter.source}"
        refused = f"; the last was refused: {arbiter.last_refusal}" if arbiter.last_was_refused else ""
        return Level.WARN, f"no valid command{whose} for {arbiter.age:.1f} s; {waits}{refused}"
    if arbiter.refused_recently:
        return Level.WARN, f"commands were refused; the last: {arbiter.last_refusal}"
    if trouble:
        return Level.WARN, f"no checkpoint: {trouble}"
    if not loop.rejected_steps.last and (late := _real_lag_dropped(simulation)):
        return Level.WARN, late
    return loop.verdict()


def _real_lag_dropped(simulation: SimulatorRun) -> str:
    """Time given up, in a sentence; empty when there is none, or a single stall is long past."""
    pacer, timing = simulation.pacer, simulation.loop.timing
    if not pacer.dropped_lag_within(_RECENT) and pacer.lag_dropped <= _SHARE * timing.simulated:
        return ""
    return (
        f"real time is not held: {pacer.lag_dropped:.3g} s given up, real-time factor of the last second "
        f"{timing.recent_realtime_factor:.2g}, the physics alone {timing.physics_speed:.2g}; "
        "take fewer elements, or give the node a core of its own"
    )
