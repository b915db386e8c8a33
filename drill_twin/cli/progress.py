# SPDX-License-Identifier: Apache-2.0
"""Progress of a command on stderr: a bar with the time left, or a spinner; without a terminal a line every 10 s."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from drill_twin.cli.show import err, remark

_LINE_PERIOD = 10.0  # s between two lines outside a terminal


def _amount(task: Task) -> str:
    """Amount done, as `12.3 of 30 s` or `4 of 17 runs`."""
    unit = task.fields["unit"]
    done = f"{task.completed:.1f}" if unit == "s" else f"{task.completed:.0f}"
    return " ".join([done, *([f"of {task.total:g}"] if task.total else []), *([unit] if unit else [])])


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
            remark(f"{text}, {_amount(self._task)}" if self._task.total else text)

    def step(self, text: str) -> None:
        """Show what was done, and that it is one more."""
        self.show(text, self._task.completed + 1)


@contextmanager
def shown_progress(text: str, total: float | None = None, *, unit: str = "", left: bool = True) -> Iterator[Bar]:
    """Show progress while a block runs; lines that it prints on stderr stay above the bar.

    Args:
        text: What is in progress.
        total: Amount at the end, of seconds, runs or the like; None: not known, or not known yet.
        unit: Unit of the amounts; with one there is a bar even if the total is not known yet.
        left: Show the time left, where there is a bar.
    """
    words = TextColumn("{task.description}", markup=False)
    columns: tuple[ProgressColumn, ...] = (SpinnerColumn(), words)
    if unit or total is not None:
        columns = (words, BarColumn(), _AmountColumn(), *([TimeRemainingColumn()] if left else []))
    console = err()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        progress.add_task(text, total=total, unit=unit)
        yield Bar(progress)
