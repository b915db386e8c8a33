# SPDX-License-Identifier: Apache-2.0
"""Output in a terminal: tables on stdout, remarks and progress on stderr."""

import textwrap
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import timedelta
from functools import cache, partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.text import Text

from drill_twin.cli.interrupt import Interrupted
from drill_twin.core.errors import printable
from drill_twin.core.files.plain_json import json_text
from drill_twin.core.table import Table


class PrintableConsole(Console):
    """Console that spells control characters out, as in the name of a bag."""

    def say(self, text: str | Text, style: str = "") -> None:
        """Print a text: in a terminal its lines are broken between words, elsewhere it is as it is."""
        if self.is_terminal and isinstance(text, str):
            fill = partial(textwrap.fill, width=self.width, break_long_words=False, break_on_hyphens=False)
            text = "\n".join(map(fill, text.split("\n")))
        self.print(text, style=style, markup=False, soft_wrap=True)

    def _render_buffer(self, buffer: Iterable[Segment]) -> str:
        return super()._render_buffer(
            segment if segment.control else Segment(printable(segment.text), segment.style) for segment in buffer
        )


def out() -> PrintableConsole:
    """Console for results, on stdout."""
    return PrintableConsole(highlight=False, emoji=False)


@cache
def err() -> PrintableConsole:
    """Console for progress and remarks, on stderr: one console for both, so that remarks stay above a bar."""
    return PrintableConsole(stderr=True, highlight=False, emoji=False)


def print_json(value: Any) -> None:
    """Print JSON on stdout."""
    print(json_text(value), end="")


def remark(text: str, style: str = "") -> None:
    """Print a line on stderr: above the bar of a progress that is shown."""
    err().say(text, style)


def findings_shown(
    summary: Mapping[str, Any], bag: Path, more: str = "--all", *, everything: bool
) -> Iterator[Table | str]:
    """Verdict on a summary and five rows; with `everything` all rows, marks and timeline.

    Notes on what limits the findings go to stderr.

    Args:
        summary: Summary of a run or a record.
        bag: Path of the bag, for the commands that go on from here.
        more: Command or option that shows everything.
        everything: Value of `--all`.
    """
    from drill_twin.report.load_text import answers
    from drill_twin.report.text import column_rows, findings, limitations, mark_rows, provenance, timeline_rows
    from drill_twin.report.verdict import first_rows, verdict

    yield from verdict(summary, str(bag))
    yield ""
    if not everything:
        yield Table((), list(first_rows(summary)))
        _note(limitations(summary))
        remark(f"all rows and the motion over time: {more}; a page with pictures: drill-twin report {bag}")
        return
    rows = [row for row in (*answers(summary), *findings(summary)) if not row[0].startswith("largest radius")]
    yield Table((), [*rows, *provenance(summary)])
    if marks := list(mark_rows(summary)):
        yield Table(("mark", "largest radius", "over the threshold", "motion at the end"), marks, right=(2,))
    if periods := timeline_rows(summary["motion"]):
        yield Table(("from", "to", "motion of the string", "what decided it"), periods, right=(0, 1))
    if columns := list(column_rows(summary)):
        yield Table(("column", "what is done with it"), columns)
    _note(limitations(summary))


def _note(troubles: Iterable[str]) -> None:
    for trouble in troubles:
        remark(f"note: {trouble}", "yellow")


def marks_shown(summary: Mapping[str, Any]) -> Iterator[Table]:
    """Timeline of every mark."""
    from drill_twin.report.text import timeline_rows

    if rows := [(mark, *row) for mark, periods in summary["mark_motion"].items() for row in timeline_rows(periods)]:
        yield Table(("mark", "from", "to", "motion", "what decided it"), rows, right=(1, 2))


_LINE_PERIOD = 10.0
"""Time between two lines of progress outside a terminal [s]."""


def _amount(task: Task) -> str:
    """Amount done, as `12.3 of 30 s` or `4 of 17 runs`."""
    unit = task.fields["unit"]
    done = f"{task.completed:.1f}" if unit == "s" else f"{task.completed:.0f}"
    most = "at most " * task.fields["most"]
    return " ".join([done, *([f"of {most}{task.total:g}"] if task.total else []), *([unit] if unit else [])])


class _AmountColumn(ProgressColumn):
    def render(self, task: Task) -> Text:
        return Text(_amount(task))


class Bar:
    """Progress that is shown now; `shown_progress` makes it."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._task = progress, progress.tasks[0]
        self._printed = time.monotonic()

    def show(self, text: str, done: float | None = None, total: float | None = None) -> None:
        """Show what is in progress, and how much of it is done."""
        self._progress.update(self._task.id, description=text, completed=done, total=total)
        if self._progress.disable and time.monotonic() - self._printed >= _LINE_PERIOD:
            self._printed = time.monotonic()
            left = self._task.time_remaining
            most = "at most " * self._task.fields["most"]
            told = [text, *([_amount(self._task)] if self._task.total else [])]
            told += [f"{most}{timedelta(seconds=round(left))} left"] if left else []
            remark(", ".join(told))

    def step(self, text: str) -> None:
        """Show what was done, and count it."""
        self.show(text, self._task.completed + 1)


@contextmanager
def shown_progress(
    text: str, total: float | None = None, *, unit: str = "", kept: str = "nothing was kept", most: bool = False
) -> Iterator[Bar]:
    """Show progress while a block runs: a bar with the time left, or a spinner; without a terminal a line every 10 s.

    Lines that are printed on stderr meanwhile stay above the bar. Ctrl-C ends the block.

    Args:
        text: What is in progress.
        total: Seconds, runs or the like at the end; None: not known, or not known yet.
        unit: Unit of the amounts; with one there is a bar even if the total is not known yet.
        kept: Sentence on what is kept after Ctrl-C, and how to go on.
        most: The total is a bound, before which the block may end.
    """
    words = TextColumn("{task.description}", markup=False)
    columns: tuple[ProgressColumn, ...] = (SpinnerColumn(), words)
    if unit or total is not None:
        columns = (words, BarColumn(), _AmountColumn(), TimeRemainingColumn())
    console = err()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        progress.add_task(text, total=total, unit=unit, most=most)
        try:
            yield Bar(progress)
        except Interrupted as stopped:
            stopped.kept = stopped.kept or kept
            raise
