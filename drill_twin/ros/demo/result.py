# SPDX-License-Identifier: Apache-2.0
"""What a demo leaves: a bag that must be whole, and its report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from drill_twin.errors import BagError, RunError


def check_bag(folder: Path) -> None:
    """See that the bag is whole and holds every topic of the contract.

    Raises:
        RunError: It does not.
    """
    from drill_twin.io.bag.reader import Bag
    from drill_twin.io.messages.topics import TOPICS

    try:
        bag = Bag(folder)
    except BagError as error:
        raise RunError(str(error)) from error
    missing = [name for name in TOPICS if name not in bag.topics or not bag.topics[name].count]
    if missing:
        raise RunError(f"{folder}: expected every topic of the contract, found no message on {', '.join(missing)}")
    if bag.truncated:
        raise RunError(f"{folder}: expected a whole bag, found {'; '.join(bag.damage)}")


def draw_report(out: Path, console: Any) -> None:
    """Draw the report of the bag in a folder, and print what was found."""
    import json

    from rich.table import Table

    from drill_twin.report import build_report

    with console.status("drawing the report"):
        build_report(out / "bag_0", out)
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    for name, value in _findings(summary):
        table.add_row(name, value)
    console.print(table)
    console.print(
        f"[bold]{out / 'report.html'}[/]  (bag: {out / 'bag_0'}, figures: {out}/*.png, {out / 'summary.json'})"
    )


def _findings(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The findings worth a line, in words."""

    def number(key: str, form: str) -> str:
        value = summary.get(key)
        return "none" if value is None else form.format(value)

    yield "onset of whirl", number("onset_s", "{:.2f} s")
    yield "whirl frequency", number("whirl_frequency_hz", "{:+.3f} Hz")
    yield "precession ratio", number("precession_ratio", "{:+.3f}")
    for mark, radius in (summary.get("max_radius_m") or {}).items():
        yield f"largest radius at {mark}", "none" if radius is None else f"{radius * 1e3:.1f} mm"
    yield "real-time factor", number("realtime_factor", "{:.1f}")
