# SPDX-License-Identifier: Apache-2.0
"""Progress of a compilation names the last one like it."""

from pathlib import Path

from drill_twin.runs.compilation import LastCompilation


def test_without_a_last_one_only_functions_and_time_are_told(tmp_path: Path) -> None:
    last = LastCompilation(tmp_path)
    assert str(last) == "ten seconds to two minutes on most machines"
    assert last.text(7, 40.0) == "7 functions, 40 s; ten seconds to two minutes on most machines"


def test_the_next_names_functions_and_time_of_the_last(tmp_path: Path) -> None:
    LastCompilation(tmp_path).keep(10, 80.0)
    last = LastCompilation(tmp_path)
    assert str(last) == "the last compilation took 80 s"
    assert last.text(5, 20.0) == "5 of about 10 functions, 20 s; the last compilation took 80 s"
    assert last.text(12, 90.0) == "12 functions, 90 s; the last compilation took 80 s"
    for damaged in ("[[1, 2", "[1]", '["many", 3]', "{}"):
        next(tmp_path.iterdir()).write_text(damaged, "utf-8")
        assert str(LastCompilation(tmp_path)) == "ten seconds to two minutes on most machines", damaged
