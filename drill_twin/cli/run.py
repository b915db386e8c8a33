# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin run`: simulate a scene, analyse and record it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drill_twin.cli import options
from drill_twin.cli.emit import emit, folder_name, new_folder
from drill_twin.cli.interrupt import Interrupted, stop_request
from drill_twin.cli.show import findings_shown, remark, shown_progress
from drill_twin.core.errors import RunStopped

if TYPE_CHECKING:
    from drill_twin.report.recording import Recording
    from drill_twin.runs import Outcome, Session
    from drill_twin.studies.accuracy import AccuracyPlan


def run(
    scene: options.SceneArgument,
    wob: options.WeightOption = "",
    rpm: options.RpmOption = "",
    duration: options.DurationOption = "",
    accuracy: Annotated[
        str,
        typer.Option(
            "--accuracy",
            metavar="SHARE",
            help='Largest error until whirl begins, as "1 %": elements and time step are chosen for it.',
        ),
    ] = "",
    rerun: Annotated[
        bool, typer.Option("--check/--no-check", help="With --accuracy: measure the error after the run.")
    ] = True,
    change: options.SetOption = [],  # noqa: B006  typer makes a new list of it
    out: Annotated[Path | None, options.folder_option("New folder of the result.", "out/SCENE")] = None,
    replace: options.ReplaceOption = False,
    with_report: Annotated[
        bool, typer.Option("--report", help="Draw the report of the run too, as report.html and figures.")
    ] = False,
    units: options.UnitsOption = "",
    everything: options.AllOption = False,
    json: options.JsonOption = False,
) -> None:
    """Simulate a scene and analyse it; write a bag and summary.json to a new folder.

    Physics, analysis and bag are the same as with the ROS nodes. Ctrl-C ends the run early and keeps the bag.
    """
    from drill_twin.scene import load_scene
    from drill_twin.scene.set_points import Schedule

    described = load_scene(
        scene, overrides=options.overrides(change, wob=wob, rpm=rpm, duration=duration, accuracy=accuracy, units=units)
    )
    schedule = Schedule.from_scene(described)
    folder = out or Path("out") / folder_name(described.name)
    new_folder(folder, replace=replace)
    plan = None
    if described.numerics.accuracy is not None:
        with _stoppable("reading the cost curve") as show:
            from drill_twin.studies.accuracy import resolve
            from drill_twin.studies.accuracy.measure import in_words

            plan = resolve(described, progress=in_words(show), compiling=show)
        remark(plan.sentence)
        described = plan.scene
    with _stoppable("loading the effects of the scene") as show:
        from drill_twin.runs import Session

        session = Session(described, schedule, show)
    if schedule.record is not None:
        remark(schedule.record.report)
    outcome, stopped_by = _drill(session, folder / "bag_0")
    if not outcome.finished:
        remark(
            f"stopped at {outcome.simulated:.2f} s; the bag is whole up to there: {outcome.bag} "
            f"(drill-twin analyze {outcome.bag})"
        )
        raise typer.Exit(128 + stopped_by)
    with shown_progress("analysing the bag", kept=f"the bag is whole: {outcome.bag}"):
        from drill_twin.report.recording import read_recording
        from drill_twin.report.summary import summarise

        recording = read_recording(outcome.bag)
        summary = summarise(recording)
    if plan is not None:
        summary["accuracy"] = _checked(plan, recording, outcome.motion_seconds, rerun=rerun)
    if with_report:
        from drill_twin.cli.analyze import draw

        draw(recording, folder)
    shown = findings_shown(summary, outcome.bag, f"drill-twin analyze {outcome.bag} --all", everything=everything)
    also = ["bag_0", *(["report.html and figures"] if with_report else [])]
    emit(summary, shown, json=json, folder=folder, files={"summary.json": summary}, also=also)


def _checked(plan: AccuracyPlan, recording: Recording, motion_seconds: float, *, rerun: bool) -> dict[str, Any]:
    """Compare a run with its plan, print the result, and return it for the summary."""
    from drill_twin.studies.accuracy import check

    what = "checking: the part before the onset at a finer resolution"
    with shown_progress(what, recording.duration, unit="s") as bar:
        result = check(plan, recording, motion_seconds, rerun=rerun, progress=lambda time: bar.show(what, time))
    actual = "not checked" if result.actual is None else f"{result.actual * 100:.2g} %"
    remark(
        f"error before the onset: {actual}, expected {result.expected * 100:.2g} %, asked {result.asked * 100:g} %; "
        f"processor time of the motion: {result.actual_seconds:.2g} s, expected {result.expected_seconds:.2g} s"
        f"{f'; of the check: {result.check_seconds:.2g} s' if rerun else ''}"
    )
    return asdict(result)


@contextmanager
def _stoppable(first: str) -> Iterator[Callable[[str], None]]:
    """Progress in words; SIGINT and SIGTERM end the block between two of them, or between slices of compiled work."""
    with stop_request() as asked, shown_progress(first) as progress:

        def check() -> None:
            if asked:
                raise Interrupted(asked[0])

        def show(text: str) -> None:
            check()
            progress.show(text)

        from drill_twin.dynamics.solver.slices import checked

        with checked(check):
            yield show
    check()


def _drill(session: Session, bag: Path) -> tuple[Outcome, int]:
    """Run with a progress bar; SIGINT and SIGTERM end the run, and a frame that takes long is taken back.

    Returns:
        The outcome, and the number of the signal; 0 without one.
    """
    from drill_twin.runs import Progress as State

    announced = False
    with stop_request() as asked, shown_progress("drilling", session.schedule.duration, unit="s") as progress:

        def show(state: State) -> None:
            nonlocal announced
            findings = state.findings
            motion = findings.motion.value if findings else "drilling"
            progress.show(f"{motion}, {state.realtime_factor:.3g} x real time", state.simulated)
            if findings and findings.onset and not announced:
                announced = True
                remark(f"whirl began at {findings.onset.time_s:.2f} s at {findings.onset.mark}")

        try:
            outcome = session.run(bag, progress=show, stop=lambda: bool(asked))
        except RunStopped:
            raise Interrupted(asked[0]) from None
    return outcome, asked[0] if asked else 0
