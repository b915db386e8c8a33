# SPDX-License-Identifier: Apache-2.0
"""Folder of a demo's result; an older result is moved aside, and only results of demos are ever removed."""

from __future__ import annotations

import shutil
from pathlib import Path

from drill_twin.core.errors import DrillTwinError


def prepare_folder(out: Path, *, replace: bool) -> None:
    """Make the folder of the result; an older one is moved aside with `replace`.

    Raises:
        DrillTwinError: The folder exists, or cannot be made.
    """
    try:
        if out.exists():
            if not replace:
                raise DrillTwinError(
                    f"{out}: expected a new folder, found one that exists; choose another, or --replace"
                )
            _move_aside(out)
        (out / "log").mkdir(parents=True)
    except OSError as error:
        raise DrillTwinError(
            f"{out}: expected a place to write the result, found {error.strerror or error}; choose another with --out"
        ) from error


def _move_aside(out: Path) -> None:
    """Rename `out` to `out.old`."""
    old = out.with_name(out.name + ".old")
    if not _is_result(out):
        raise DrillTwinError(
            f"{out}: expected the result of an earlier demo, found something else; choose another --out"
        )
    if old.exists():
        if not _is_result(old):
            raise DrillTwinError(f"{old}: expected the result of an earlier demo, found something else; move it away")
        shutil.rmtree(old)
    out.rename(old)


def _is_result(folder: Path) -> bool:
    return folder.is_dir() and not folder.is_symlink() and ((folder / "log").is_dir() or not any(folder.iterdir()))
