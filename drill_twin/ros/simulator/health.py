# SPDX-License-Identifier: Apache-2.0
"""How the simulator is doing, in numbers and in one sentence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING

from drill_twin.io.messages.diagnostics import Level
from drill_twin.ros.core.pacing import Pacer
from drill_twin.ros.simulator.checkpoint_writer import CheckpointWriter
from drill_twin.ros.simulator.command_arbiter import CommandArbiter

if TYPE_CHECKING:
    from drill_twin.ros.simulator.twin_publisher import TwinPublisher


def health_values(
    settings: SimpleNamespace,
    stage: TwinPublisher,
    desk: CommandArbiter,
    pacer: Pacer,
    keeper: CheckpointWriter,
    sources: Sequence[str],
) -> dict[str, str]:
    """Named values for the diagnostics."""
    return {
        "scene": settings.scene,
        "pace": settings.pace,
        "simulated_time": f"{stage.twin.time:.6f}",
        "frames": str(stage.frames),
        **stage.cost.values(),
        **stage.effect_cost.values(stage.cost.seconds_per_iteration),
        **stage.drilled.values(),
        "overruns": str(pacer.overruns),
        "time_given_up": f"{pacer.given_up:.3f}",
        "elements": str(stage.twin.elements),
        "step_s": repr(float(stage.twin.step_size)),
        "weight_on_bit": f"{desk.good.weight_on_bit:g}",
        "speed_rev_s": f"{desk.good.rotation / math.tau:g}",
        "command_age": f"{desk.age:.3f}",
        "commands_accepted": str(desk.accepted),
        "commands_refused": str(sum(desk.refused.values())),
        **{f"commands_refused_{kind}": str(count) for kind, count in sorted(desk.refused.items())},
        "last_refusal": desk.last_refusal,
        "command_sources": ", ".join(sources),
        "commands_from_others": str(desk.from_others),
        **stage.omissions.values(),
        **stage.interventions.values(),
        "checkpoint_time": "" if keeper.kept is None else f"{keeper.kept:.6f}",
    }


def verdict(
    settings: SimpleNamespace,
    stage: TwinPublisher,
    desk: CommandArbiter,
    keeper: CheckpointWriter,
    sources: Sequence[str],
    *,
    waiting: bool,
) -> tuple[Level, str]:
    """Level and sentence; what most needs a hand comes first."""
    guard = stage.interventions
    if guard.stopped:
        return Level.ERROR, guard.stopped
    if waiting and not desk.heard and desk.refused:
        return Level.WARN, f"waiting for the first good command; the last one was refused: {desk.last_refusal}"
    if waiting and not desk.heard:
        return Level.OK, "waiting for the first command"
    if len(sources) > 1 or desk.others_speak:
        others = "" if len(sources) > 1 else f"; {desk.from_others} single values from others were not followed"
        return Level.WARN, f"more than one source of commands: {', '.join(sources)}{others}"
    if desk.silent:
        held = "ramping to the safe set-point" if settings.on_silence == "ramp" else "the last one is held"
        waits = "the lockstep waits" if settings.pace == "lockstep" else held
        return Level.WARN, f"no command for {desk.age:.1f} s; {waits}"
    if keeper.trouble:
        return Level.WARN, f"no checkpoint: {keeper.trouble}"
    if desk.refused:
        return Level.WARN, f"commands were refused; the last: {desk.last_refusal}"
    if guard.last:
        return Level.WARN, guard.last
    if stage.omissions.found:
        return Level.WARN, stage.omissions.found[-1]
    return Level.OK, stage.cost.text()
