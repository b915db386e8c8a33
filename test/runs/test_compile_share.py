# SPDX-License-Identifier: Apache-2.0
"""Share done of a compilation: by the course of the last one like it."""

from pathlib import Path

from drill_twin.core.compile.kernel_cache import fingerprint
from drill_twin.runs.compilation import FIRST_COURSE, CompileShare


def test_the_first_goes_by_the_shipped_course(tmp_path: Path) -> None:
    share = CompileShare(tmp_path)
    assert share.before == "one to two minutes on most machines"
    assert share.text(0, 0.1) == f"0 of about {FIRST_COURSE[-1][0]} functions, 0 s; 0% done"
    functions, done = FIRST_COURSE[2]
    assert f"{done:.0%} done, about 60 s left" in share.text(functions, 40.0)
    assert share.text(FIRST_COURSE[-1][0], 100.0) == f"{FIRST_COURSE[-1][0]} functions, 100 s"


def test_the_next_goes_by_the_course_of_the_last(tmp_path: Path) -> None:
    first = CompileShare(tmp_path)
    for functions, seconds in ((1, 2.0), (5, 10.0), (10, 70.0)):
        first.text(functions, seconds)
    first.save(80.0)
    share = CompileShare(tmp_path)
    assert share.before == "the last such took 80 s"
    assert share.text(5, 20.0) == "5 of about 10 functions, 20 s; 12% done, about 140 s left"
    next(tmp_path.iterdir()).write_text("[[1, 2", "utf-8")
    assert CompileShare(tmp_path).before == "one to two minutes on most machines"


def test_a_further_set_is_of_another_kind(tmp_path: Path) -> None:
    """With the machine code that all sets share in the cache; that of an older version is not."""
    part = "part_drill_twin.dynamics.twin.observation.observe_nodes"
    (tmp_path / f"{part}_0123.0.bitcode").touch()
    assert "one to two minutes" in CompileShare(tmp_path).before
    (tmp_path / f"{part}_{fingerprint('import drill_twin.dynamics.twin.observation')}.0.bitcode").touch()
    share = CompileShare(tmp_path)
    assert "ten seconds" in share.before
    assert share.text(3, 4.0) == "3 functions, 4 s"  # how many there are is not known
