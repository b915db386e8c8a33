# SPDX-License-Identifier: Apache-2.0
"""`python -m drill_twin_evidence.pictures [NAME ...]`: pictures of the README and the introduction."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

import drill_twin as dt
from drill_twin.cli.show import remark
from drill_twin_evidence.pictures import orbits, sketches

FIGURES = Path(__file__).resolve().parents[3] / "docs" / "figures"


def draw_whirl(path: Path) -> None:
    """Draw the model rod in motion: it buckles, and whirls."""
    dt.Simulation("pa6_bench").run(duration=11.0).animate(path, begin=4.0, end=11.0)


PICTURES: dict[str, Callable[[Path], None]] = {
    "whirl.gif": draw_whirl,
    "orbits.png": orbits.draw,
    "frames.svg": sketches.draw_frames,
    "nodes.svg": sketches.draw_nodes,
}
"""Function that draws each file."""


def main(
    names: Annotated[list[str] | None, typer.Argument(help=f"Any of {', '.join(PICTURES)}; all if omitted.")] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder of the pictures.")] = FIGURES,
) -> None:
    """Draw the pictures: whirl.gif and orbits.png from runs of the installed scenes, the others as sketches."""
    for name in names or PICTURES:
        if name not in PICTURES:
            raise typer.BadParameter(f"expected one of {', '.join(PICTURES)}, found {name!r}")
        out.mkdir(parents=True, exist_ok=True)
        PICTURES[name](out / name)
        remark(f"{out / name}: {(out / name).stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    typer.run(main)
