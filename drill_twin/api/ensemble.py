# SPDX-License-Identifier: Apache-2.0
"""An ensemble in Python: many runs of one scene with other numbers (docs/ensembles.md)."""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

from drill_twin.api.scenes import Overrides, Quantity, as_scene, in_si, with_resolution
from drill_twin.core.arrays import Array
from drill_twin.core.errors import ArgumentError
from drill_twin.core.units.dimension import FREQUENCY, TIME
from drill_twin.io.messages.stamps import NANOSECONDS, seconds
from drill_twin.runs import compile_kernel
from drill_twin.runs.ensemble import OUTPUTS, EnsembleResult, Executor, Threads, expand
from drill_twin.runs.ensemble.outputs import Request
from drill_twin.runs.ensemble.run import MemberRun
from drill_twin.scene import Scene
from drill_twin.scene.set_points import Schedule

DEFAULT_OUTPUTS = ("findings", "extremes", "contact")
MARK_RATE = 25.0
"""Samples of the marks per simulated second."""


class Ensemble:
    """Runs of a scene that differ in numbers: values of effects, seeds, set-points, start.

    >>> ensemble = Ensemble("pa6_bench", {"wall_friction.coefficient": [0.1, 0.2, 0.3], "eccentricity.angle": range(6)})
    >>> found = ensemble.run(duration=30)
    >>> found["onset_s"].reshape(3, 6)

    Attributes:
        scene: The base scene, with elements and step in place of an accuracy, for all members.
        members: The members.
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        vary: Mapping[str, Sequence[float | str]],
        *,
        zipped: bool = False,
        overrides: Overrides | None = None,
    ) -> None:
        """Check the members; nothing runs yet.

        Args:
            scene: The scene, or its name or file.
            vary: Values by key, as in overrides; a key of an effect needs no `effects.`, `seed` is `numerics.seed`.
            zipped: Take the values of all keys together, one after the other, instead of each with each.
            overrides: Values that replace the scene's values for all members.

        Raises:
            ArgumentError: No values, too many members, or members that need another kernel.
            SceneError: A value does not fit the scene.
        """
        self.scene = with_resolution(as_scene(scene, overrides))
        self.members = expand(self.scene, vary, zipped=zipped)

    def __repr__(self) -> str:
        """One line: scene and members."""
        return f"<Ensemble of {self.scene.name}: {self.members.told}>"

    def run(
        self,
        duration: Quantity | None = None,
        *,
        outputs: Sequence[str] = DEFAULT_OUTPUTS,
        mark_rate: Quantity = MARK_RATE,
        workers: int | None = None,
        dask: str | None = None,
        progress: Callable[[int, int], None] | None = None,
        played: Mapping[str, tuple[Array, Array]] | None = None,
    ) -> EnsembleResult:
        """Run all members, each from its start; a member that fails is reported and stops no other.

        Args:
            duration: Simulated time [s]; left out: to the end of the base scene.
            outputs: Of "findings", "extremes", "contact", "marks", "channels", "instants", "spectra" and "energy".
            mark_rate: Samples of "marks", "channels" and "instants" per simulated second [Hz], at most the frame rate.
            workers: Threads; by default one for each processor core.
            dask: Address of a Dask scheduler, on whose workers the members are run instead.
            progress: Called with the number of members that have ended and of all.
            played: Times [s] and values [SI] of recorded set-points in place of the members' own, by name.

        Raises:
            ArgumentError: An argument cannot be used.
            DrillTwinError: The first member cannot be begun, such as a record that cannot be played.
            RunError: The scheduler or its workers cannot run members.
        """
        request = replace(self._request(duration, outputs, mark_rate), played=played or {})
        first = self.members.scene(next(iter(self.members)))
        with executor_of(workers, dask) as executor:
            compile_kernel(first, request.period, analysis="findings" in request.names)
            runs = [MemberRun()] * len(self.members)
            with closing(executor.run(self.members, request)) as ended:
                for count, (number, run) in enumerate(ended, 1):
                    runs[number] = run
                    if progress is not None:
                        progress(count, len(runs))
        return EnsembleResult(self.members, runs)

    def _request(self, duration: Quantity | None, outputs: Sequence[str], mark_rate: Quantity) -> Request:
        numerics = self.scene.numerics
        names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        for name in names:
            if name not in OUTPUTS:
                raise ArgumentError(f"outputs: expected some of {', '.join(OUTPUTS)}, found {name!r}")
        if "energy" in names and numerics.audit != "energy":
            raise ArgumentError("outputs: expected numerics.audit: energy in the scene for `energy`, found none")
        length = Schedule.from_scene(self.scene).duration if duration is None else in_si("duration", duration, TIME)
        if length <= 0.0:
            raise ArgumentError(f"duration: expected a time above 0 s, found {length:g} s")
        rate = in_si("mark_rate", mark_rate, FREQUENCY)
        if not 0.0 < rate <= numerics.frame_rate:
            raise ArgumentError(
                f"mark_rate: expected up to the frame rate of {numerics.frame_rate:g} Hz, found {rate:g} Hz; "
                "raise numerics.frame_rate for more"
            )
        period = numerics.frame_period_ns
        frames = max(1, math.ceil(length * NANOSECONDS / period - 0.5))
        return Request(names, seconds(period), frames, round(numerics.frame_rate / rate))


MOST_THREADS = 4096


@contextmanager
def executor_of(workers: int | None, dask: str | None) -> Iterator[Executor]:
    """Threads, or the workers of a scheduler until the end of the `with` block.

    Args:
        workers: Threads; None: one for each processor core.
        dask: Address of a Dask scheduler; None or empty: threads.

    Raises:
        ArgumentError: The number is absurd, or distributed is not installed.
        RunError: No scheduler answers at the address, or it has no workers.
    """
    if dask:
        from drill_twin.runs.ensemble.dask_workers import DaskWorkers

        with DaskWorkers(dask) as cluster:
            yield cluster
        return
    threads = len(os.sched_getaffinity(0)) if workers is None else workers
    if not isinstance(threads, int) or not 1 <= threads <= MOST_THREADS:
        raise ArgumentError(f"workers: expected a whole number of 1 or more, found {workers!r}")
    yield Threads(threads)
