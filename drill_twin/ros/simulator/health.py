# SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the simulator: named values, and a level with one sentence."""

import math
from types import SimpleNamespace

from drill_twin.io.messages.diagnostics import Level, Status, exact
from drill_twin.io.messages.stamps import seconds
from drill_twin.io.messages.topics import RIG_COMMAND, STRING_POSES
from drill_twin.ros.core.node import TwinNode
from drill_twin.ros.core.topics import relative
from drill_twin.ros.simulator.command_quantity import ANONYMOUS, CommandQuantity
from drill_twin.ros.simulator.run_control import RunControl
from drill_twin.ros.simulator.simulation import SimulatorRun

_RECENT = 3.0  # s; for so long a stall is told


def health(node: TwinNode, control: RunControl) -> Status:
    """Status of the simulator: pace, cost and set-points; begins a new window of the timing."""
    simulation = control.simulation
    values = {"state": control.state_text, **_values(node.settings, simulation)}
    if len(publishers := node.topics.publisher_nodes(STRING_POSES)) > 1:
        topic = node.resolve_topic_name(relative(STRING_POSES))
        return node.status(values, (Level.ERROR, f"more than one simulator publishes {topic}: {', '.join(publishers)}"))
    if not node.active or control.paused:
        return node.status(values, (Level.OK, f"{control.state_text} at {simulation.time_text}"))
    rival = next((quantity for quantity in simulation.commands.quantities if quantity.several_send), None)
    if rival and len(publishers := node.topics.publisher_nodes(RIG_COMMAND)) > 1:  # the other may be gone
        text = (
            f"expected one publisher of {RIG_COMMAND} as {rival.source or ANONYMOUS}, found several "
            f"({', '.join(publishers)}): the set-points flip between them; stop all but one, or name them"
        )
        return node.status(values, (Level.ERROR, text))
    return node.status(values, *_verdicts(node.settings, simulation))


def _values(settings: SimpleNamespace, simulation: SimulatorRun) -> dict[str, str]:
    arbiter, pacer, written = simulation.commands, simulation.pacer, simulation.checkpoints.written
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
        "commander_weight_on_bit": arbiter.quantities[0].commander,
        "commander_rotation": arbiter.quantities[1].commander,
        "checkpoint_time": "" if written is None else f"{written:.6f}",
    }


def _verdicts(settings: SimpleNamespace, simulation: SimulatorRun) -> tuple[tuple[Level, str], ...]:
    """Levels and sentences, the most severe first."""
    loop, arbiter, trouble = simulation.loop, simulation.commands, simulation.checkpoints.trouble
    first, last = simulation.waits_for_command and not arbiter.heard, arbiter.last_refusal
    silence = (_lockstep if settings.pace == "lockstep" else _silence)(simulation, settings)
    refused = f"; the last was refused: {last}" if arbiter.last_was_refused else ""
    return (
        (Level.ERROR, loop.rejected_steps.stopped),
        (Level.WARN, f"waiting for the first good command; the last one was refused: {last}" if first and last else ""),
        (Level.OK, "waiting for the first command" if first else ""),
        (Level.WARN, silence and f"{silence}{refused}"),
        (Level.WARN, f"commands were refused; the last: {last}" if arbiter.refused_recently else ""),
        (Level.WARN, trouble and f"no checkpoint: {trouble}"),
        (Level.WARN, "" if loop.rejected_steps.last else _real_lag_dropped(simulation)),
        loop.verdict(),
    )


def _lockstep(simulation: SimulatorRun, settings: SimpleNamespace) -> str:
    """Commands that a lockstep has waited for longer than for silence, in a sentence; empty where it goes on."""
    awaited = simulation.commands.awaited
    if not awaited or simulation.waited <= settings.command_timeout:
        return ""
    last = max(quantity.last_stamp for quantity in awaited)
    stamped = f", the last is stamped {seconds(last):g} s" if last >= 0 else ""
    return (
        f"{_missing(simulation, awaited)} for {simulation.waited:.1f} s; the lockstep waits for a {RIG_COMMAND} with "
        f"the stamp of the next frame, after {simulation.time_text}{stamped}"
    )


def _silence(simulation: SimulatorRun, settings: SimpleNamespace) -> str:
    """Silence of commanders, in a sentence; empty where there is none.

    Single values are sent on change: who sends one has not fallen silent, unless a ramp depends on it.
    """
    found = simulation.commands.quantities
    silent = [one for one in found if one.silent and not (one.by_hand and settings.on_silence != "ramp")]
    if not silent:
        return ""
    held = "ramping to the safe set-point" if any(one.ramps for one in silent) else "the last one is held"
    return f"{_missing(simulation, silent)} for {max(one.age for one in silent):.1f} s; {held}"


def _missing(simulation: SimulatorRun, quantities: list[CommandQuantity]) -> str:
    """Command that is missing, or the part of it where others have the rest, and its sources."""
    others = [one for one in simulation.commands.quantities if one not in quantities and one.age < math.inf]
    sources = sorted({one.source for one in quantities if one.source and not one.by_hand})
    whose = f" of {', '.join(sources)}" if sources else ""
    return f"no valid {quantities[0].name if others else 'command'}{whose}"


def _real_lag_dropped(simulation: SimulatorRun) -> str:
    """Time given up of late, in a sentence with the cause; empty when there is none."""
    pacer, physics = simulation.pacer, 1.0 / (simulation.loop.timing.physics_speed or math.inf)
    if not (dropped := pacer.dropped_lag_within(_RECENT)):
        return ""
    told = f"real time is not held: {dropped:.3g} s given up in the last {_RECENT:g} s; "
    if pacer.need < 1.0:  # with a whole core it would have been on time
        return (
            f"{told}the machine gave this node {pacer.share:.0%} of a core while it was late, and a second needs "
            f"{pacer.need:.2g} s of processor time; end other programs, or give the node a core of its own"
        )
    remedy = "take fewer elements" if 2.0 * physics > pacer.need else "lower frame_rate or marker_rate"
    return f"{told}a second needs {pacer.need:.2g} s of processor time, {physics:.2g} s for the physics; {remedy}"
