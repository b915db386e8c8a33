# SPDX-License-Identifier: Apache-2.0
"""Step guard: words for the verdict on a frame, rollback to the last good one, step size control; the frame loop.

The frame loop saves the state before a frame and judges the one after it (`state_judge`). A frame with a violation is
rejected and repeated with half the step, up to `MAX_RETRIES` times; the step is doubled again after every
`GOOD_FRAMES_BEFORE_GROWTH` good frames.
"""

import math
import time
from dataclasses import dataclass

import numpy as np

from drill_twin.dynamics.solver import slices
from drill_twin.dynamics.solver.midpoint import SMALLEST_SHARE
from drill_twin.dynamics.solver.state import HALVINGS, NEXT_STEP, UNFINISHED
from drill_twin.dynamics.twin import state_judge
from drill_twin.dynamics.twin.dynamics import Dynamics
from drill_twin.dynamics.twin.frame import EnergyBalance, Intervention
from drill_twin.dynamics.twin.frame_kernel import FRACTION, GOOD_FRAMES, REPEATED, ROW
from drill_twin.dynamics.twin.state_judge import ALLOWED, FOUND, KIND, NODE

NOT_RETRIED = {"slow": 0, "long": 0, "fold": 1, "slope": 1}
"""Retries of the kinds that a smaller step does not mend."""
REMEDIES = {
    "finite": "look at the parameters of the effect that is named",
    "newton": "try a lower load (the string may have folded), a smaller numerics.step, more elements, or a softer wall",
    "slow": "try a softer contact or one with damping, fewer elements, or a longer numerics.processor_time",
    "long": "try a longer numerics.step, fewer elements, or a longer numerics.processor_time",
    "speed": "try a smaller numerics.step, or look at the parameters of the effect that is named",
    "strain": "try a lower load; no drillstring is meant to be stretched or squeezed so far",
    "fold": "try a lower load, or list `wall`, which keeps the string from folding",
    "fold in a hole": "try a lower load or speed: no wall keeps a string from kinking once it is wound up so far",
    "slope": "list `stretch` and `torsion` (the motion across the hole alone is meant for small slopes), or `wall`",
    "penetration": "try a smaller numerics.step, a stiffer wall, or a lower load",
    "kick": "try a smaller effects.lateral_kick.offset, which bends the string into the wall before the run begins",
    "energy": "try a smaller numerics.step or more elements",
}


@dataclass(frozen=True)
class Violation:
    """Violation of a bound by a state."""

    kind: str
    """finite, newton, slow (steps are cut), long (many steps), speed, strain, fold, slope, penetration or energy."""
    node: int
    """Node at which it is largest."""
    text: str
    """Description for messages: found and expected."""


MAX_RETRIES = 6
"""Largest number of retries of a frame, each with half the step."""
SMALLEST_STEP = 2.0**-10
"""Smallest step of a frame over the nominal one [-]."""
ENERGY_SHARE = 0.2
"""Largest change of the energy residual in a frame over the scale of the balance, with an audit [-]."""

FOLDING = 0.2
"""1 - t_z in a straight hole, a lean of 37 degrees, above which a string that has no solution is said to fold."""


class StepGuard:
    """Step guard of one twin.

    Attributes:
        memory: Fraction of the nominal step and good frames since it was halved; part of a checkpoint.
        suspect: Node rows u and v of the last rejected state, shape (2, n + 1, 7).
    """

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics, self._model = dynamics, dynamics.model
        self.memory = dynamics.bound.guard
        self.suspect = np.zeros((2, *dynamics.unknowns[0].shape))
        self._now, self._before, self._verdict = dynamics.bound.now, dynamics.bound.before, dynamics.bound.verdict

    @property
    def fraction(self) -> float:
        """Current step over the nominal one [-]."""
        return float(self.memory[FRACTION])

    def exhausted(self, found: Violation, tries: int) -> bool:
        """True if a frame with this violation is not to be retried after so many tries."""
        return tries >= NOT_RETRIED.get(found.kind, MAX_RETRIES) or self.fraction <= SMALLEST_STEP

    def roll_back(self) -> None:
        """Restore the saved state, and store the rejected one as `suspect`."""
        self.suspect[0], self.suspect[1] = self._dynamics.unknowns
        self._dynamics.roll_back()

    def halve_step(self) -> None:
        """Halve the step."""
        self.memory[FRACTION] *= 0.5
        self.memory[GOOD_FRAMES] = 0.0

    def implausible(self) -> Violation:
        """Violation of a frame whose state exceeds a bound: the verdict of the frame loop in words."""
        verdict = self._verdict.tolist()
        node, found, allowed = int(verdict[NODE]), verdict[FOUND], verdict[ALLOWED]
        at = self._at(node)
        match int(verdict[KIND]):
            case state_judge.NOT_FINITE:
                return Violation("finite", node, f"the state of {at} is no longer a number")
            case state_judge.TOO_FAST:
                text = f"{at} moved at {found:.3g} m/s, faster than any string can ({allowed:.4g} m/s)"
                return Violation("speed", node, text)
            case state_judge.LEANING:
                lateral = self._dynamics.bound.bounds.lateral
                text = f"the string at {at} leaned {_degrees(found):.0f} degrees from the upright"
                return Violation("slope", node, text) if lateral else Violation(
                    "fold", node, f"{text}, folded back on itself"
                )  # fmt: skip
            case state_judge.STRAINED:
                text = f"the string at {at} was stretched or squeezed by {100.0 * found:.3g} %"
                return Violation("strain", node, f"{text} (expected at most {100.0 * allowed:g} %)")
        text = f"the string at {at} was {found:.3g} m deep in the wall, where the contact law allows {allowed:.3g} m"
        return Violation("penetration", node, text)

    def diverged(self, step: float, halvings: int | None = None) -> Violation:
        """Violation of a frame in which Newton's method failed, or the step was halved too often.

        Args:
            step: Time step [s].
            halvings: Limit of halvings, if that was exceeded.
        """
        u, v = self._dynamics.unknowns
        node = int(np.argmax(np.nan_to_num(np.linalg.norm(v[:, :3], axis=1), nan=np.inf)))
        why = (
            f"the equations had no solution, even at a step of {step * SMALLEST_SHARE:.2g} s"
            if halvings is None
            else f"a step of {step:.2g} s was cut more than {halvings} times within a frame"
        )
        return Violation(
            "newton", node,
            f"{why}; fastest was {self._at(node)}, {np.hypot(u[node, 0], u[node, 1]):.3g} m off the axis at "
            f"{np.linalg.norm(v[node, :3]):.3g} m/s{self._folding()}",
        )  # fmt: skip

    def too_slow(
        self, allowed: float, seconds: float, reached: float, steps: int, halvings: int, node: int
    ) -> Violation:
        """Violation of a frame that took more processor time than it may.

        Args:
            allowed: That time [s].
            seconds: Length of the frame [s].
            reached: Simulated time of it that was computed [s].
            steps: Steps taken.
            halvings: How often one was cut.
            node: Node at which Newton's method failed last.
        """
        cut = (
            f"{halvings} attempts of a step failed and were cut; Newton's method failed last at {self._at(node)}"
            if halvings
            else "none was cut"
        )
        return Violation(
            "slow" if halvings else "long", node,
            f"a frame of {seconds:.6g} s took more than {allowed:.6g} s of processor time (numerics.processor_time): "
            f"{steps} steps of {self._model.rod.length.size} elements led {reached:.3g} s into it, {cut}",
        )  # fmt: skip

    def _folding(self) -> str:
        """Lean of the last good state, where a string in a straight hole was about to fold."""
        lean = float(self._before[state_judge.LEAN])
        if lean <= FOLDING or self._model.wellbore.axis is not None:
            return ""
        place = self._at(int(self._before[state_judge.LEAN_AT]))
        return f"; before, the string at {place} leaned {_degrees(lean):.0f} degrees from the upright: it folds"

    def energy_drift(self, energy: EnergyBalance, grown: float) -> Violation | None:
        """Check the energy balance of a frame; returns its violation, if any.

        Args:
            energy: Energy balance at its end.
            grown: Change of the residual in the frame [J].
        """
        if abs(grown) <= ENERGY_SHARE * energy.scale:
            return None
        node = int(self._now[state_judge.SPEED_AT])
        return Violation(
            "energy", node,
            f"{abs(grown):.3g} J were {'gained' if grown > 0.0 else 'lost'} that nothing accounts for, of "
            f"{energy.scale:.3g} J on the move; fastest was {self._at(node)}{self._folding()}",
        )  # fmt: skip

    def _at(self, node: int) -> str:
        """Describe a node for messages."""
        return f"node {node}, {self._model.rod.arc[node]:.4g} m from the bit"

    def intervention(self, time: float, found: Violation, tries: int, step: float) -> Intervention:
        """Make the record of a repeated frame."""
        return Intervention(
            time, found.kind, found.node, float(self._model.rod.arc[found.node]),
            f"at {time:.6g} s {found.text}; taken back and done again with a step of {step:.3g} s",
            tries, step,
        )  # fmt: skip


def _degrees(lean: float) -> float:
    """Angle from the upright of a tangent with 1 - t_z [degrees]."""
    return math.degrees(math.acos(max(1.0 - lean, -1.0)))


MOST_SECONDS = 60.0
"""Most processor time of a frame unless `numerics.processor_time` says another [s]."""
LAST_STEPS = 100
"""Attempts of a step, beyond that time, until one is cut, which shows where Newton's method fails."""


class FrameLoop:
    """Place of the compiled frame loop in a block of frames, and the processor time of its present frame.

    Attributes:
        longest: Most processor time of a frame, its repetitions included [s].
    """

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics, self._course = dynamics, dynamics.bound.course
        given = dynamics.scene.numerics.processor_time
        self.longest = MOST_SECONDS if given is None else given
        self._iterations = slices.iterations_of(dynamics.rod.length.size)
        self._begun: tuple[float, float] | None = None  # simulated time of a frame that was paused, and clock then [s]
        self._halvings = 0.0  # when that frame was last within `longest`
        self._late = 0  # attempts of a step beyond `longest`

    @property
    def row(self) -> int:
        """Number of the next frame of the block."""
        return int(self._course[ROW])

    def begin(self) -> None:
        """Begin a block."""
        self._course[:] = 0
        self._begun = None

    def take_back(self) -> None:
        """Take back the frame that was recorded last."""
        self._course[ROW] -= 1
        self._dynamics.progress[UNFINISHED] = 1.0

    def repeat(self) -> None:
        """Let the next frame begin from the state that was saved."""
        self._course[REPEATED] = 1

    def abandon(self) -> None:
        """Go back to the end of the last whole frame, if one has been begun since."""
        if self._dynamics.progress[UNFINISHED] != 0.0:
            self._dynamics.roll_back()
            self._dynamics.progress[UNFINISHED] = 0.0

    def next_slice(self) -> float:
        """Newton iterations of the next slice; 0 if the frame takes too long, once it is seen where it is cut."""
        dynamics = self._dynamics
        if dynamics.progress[NEXT_STEP] == 0.0:
            return self._iterations
        now = time.thread_time()
        if self._begun is None or self._begun[0] != dynamics.time:
            self._begun, self._late = (dynamics.time, now), 0
        if now - self._begun[1] <= self.longest:
            self._halvings = dynamics.counters[HALVINGS]
            return self._iterations
        self._late += 1
        return 0.0 if self._late > LAST_STEPS or dynamics.counters[HALVINGS] > self._halvings else 1.0
