# SPDX-License-Identifier: Apache-2.0
"""Result of a demo: check of the bag, and the report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drill_twin.core.errors import BagError, RunError

if TYPE_CHECKING:
    from rich.console import Console


def check_bag(folder: Path) -> None:
    """Check that the bag is complete and holds every topic that each run has.

    Raises:
        RunError: It is damaged, or a topic has no message.
    """
    from drill_twin.io.bag.reader import Bag
    from drill_twin.io.messages.topics import OF_EVERY_RUN

    try:
        bag = Bag(folder)
    except BagError as error:
        raise RunError(str(error)) from error
    missing = [name for name in OF_EVERY_RUN if name not in bag.topics or not bag.topics[name].count]
    if missing:
        raise RunError(f"{folder}: expected every topic of the contract, found no message on {', '.join(missing)}")
    if bag.truncated:
        raise RunError(f"{folder}: expected a whole bag, found {'; '.join(bag.damage)}")


def draw_report(out: Path, console: Console) -> None:
    """Write the report of the bag in a folder, and print its findings."""
    import json

    from drill_twin.core.table import Table
    from drill_twin.report import build_report
    from drill_twin.report.text import findings

    with console.status("drawing the report"):
        build_report(out / "bag_0", out)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    console.print(Table((), findings(summary)))
    console.print(
        f"[bold]{out / 'report.html'}[/]  (bag: {out / 'bag_0'}, figures: {out}/*.png, {out / 'summary.json'})"
    )
