# SPDX-License-Identifier: Apache-2.0
"""Work of the readers of foreign tables grows as their files: long repeats in names, headers, tags and lines."""

import time
import tracemalloc
from contextlib import suppress

import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.units import factor_of, parse
from drill_twin.core.units.dimension import LENGTH
from drill_twin.core.units.parse import name_and_unit
from drill_twin.scene.records import read_columns
from drill_twin.scene.well_plan.plan import read_survey

CLASSES = (
    " ",
    "\t",
    "0",
    "a",
    "[",
    "]",
    "(",
    ")",
    "[ ",
    "( a",
    ",",
    ";",
    ".",
    "-",
    "_",
    "=",
    "/",
    "1 /",
    "1/",
    "'",
    '"',
    "\x0b",
)
ENDS = ("", "x", "]", " kN]", "=")


def work(call, *given):
    """Processor time of a call [s], the least of two; a refusal is an answer."""
    times = []
    for _ in range(2):
        begin = time.process_time()
        with suppress(DrillTwinError):
            call(*given)
        times.append(time.process_time() - begin)
    return min(times)


def grows_as_its_size(call, small, large):
    """Eight times the size takes less than thirty times the work; a square law would take 64."""
    first = work(call, small)
    return work(call, large) < 30.0 * first + 0.02


@pytest.mark.parametrize("text", CLASSES)
def test_texts_of_one_repeat_take_a_time_that_grows_as_they_do(text):
    for call in (name_and_unit, lambda one: parse(one, LENGTH), lambda one: factor_of(one, LENGTH)):
        for end in ENDS:
            for begin in ("", "WOB [", "1"):
                small, large = (begin + text * count + end for count in (1000, 8000))
                assert grows_as_its_size(call, small, large), (begin, end)


@pytest.mark.parametrize("text", CLASSES)
def test_headings_of_one_repeat_do_so_too(tmp_path, text):
    """1,200 blanks in a heading took a minute once."""
    for number, end in enumerate(ENDS):
        for read, name in ((read_columns, "r.csv"), (lambda file: read_survey(file, "si"), "survey.csv")):
            files = []
            for count in (100, 800):
                files.append(tmp_path / f"{number}_{count}_{name}")
                files[-1].write_text(f'time [s],"WOB [{text.replace(chr(34), "") * count}{end}",md\n0,1,2\n1,1,2\n')
            assert grows_as_its_size(read, *files), (name, end)


def las(well, curves, blanks=0):
    names = "".join(f"C{number} . : \n" for number in range(curves))
    more = "".join(f"X{number} . {number} : more\n" for number in range(well))
    row = " ".join(["1"] * (curves + 1))
    return (  # upper case of the sharp s is longer
        f"#\xdf\xdf\n~Version\nVERS. 2.0 :\nWRAP. NO :\n{chr(10) * blanks}~Well\nNULL. -999.25 :\n{more}"
        f"~Curve\nTIME .s : \n{names}~A\n{row}\n{row}\n"
    )


def witsml(attribute=0, rows=2, delimiter=","):
    data = f"<data>0{delimiter}1</data>" * rows
    return (
        f'<logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1" a="{"x" * attribute}"><log>'
        f"<indexType>elapsed time</indexType><dataDelimiter>{delimiter}</dataDelimiter><logData>"
        f"<mnemonicList>T,WOB</mnemonicList><unitList>s,kN</unitList>{data}</logData></log></logs>"
    )


LARGE = {
    "header of LAS": ("las", lambda n: las(250 * n, 2)),
    "curves of LAS": ("las", lambda n: las(0, 100 * n)),
    "rows of LAS": ("las", lambda n: las(0, 2) + "1 1 1\n" * (2000 * n)),
    "dates and texts of LAS": ("las", lambda n: las(0, 2) + "1 2026-05-14 on\n" * (2000 * n)),
    "wrapped rows of LAS": ("las", lambda n: las(0, 2).replace("WRAP. NO", "WRAP. YES") + "1\n1\n1\n" * (1000 * n)),
    "blank lines of LAS": ("las", lambda n: las(0, 2, 2000 * n)),
    "attribute of WITSML": ("xml", lambda n: witsml(200_000 * n)),
    "rows of WITSML": ("xml", lambda n: witsml(rows=1000 * n)),
    "line of CSV": ("csv", lambda n: "t,a" * (100_000 * n)),
    "rows of CSV": ("csv", lambda n: "t,a\n" + "0,1\n" * (2000 * n)),
    "gaps and quotes of CSV": ("csv", lambda n: "t,a\n" + '0,\n"1","2"\n' * (1000 * n)),
    "columns of CSV": (
        "csv",
        lambda n: ",".join(f"c{k}" for k in range(500 * n)) + "\n" + ",".join(["1"] * 500 * n) + "\n",
    ),
}


@pytest.mark.parametrize("kind", LARGE)
def test_eight_times_the_file_takes_less_than_thirty_times_the_work(tmp_path, kind):
    ending, files = LARGE[kind][0], []
    for count in (1, 8):
        files.append(tmp_path / f"{count}.{ending}")
        files[-1].write_text(LARGE[kind][1](count), "latin-1")
    assert grows_as_its_size(read_columns, *files)


def test_memory_of_an_endless_line_is_bounded(tmp_path):
    (tmp_path / "r.csv").write_text("1," * 10_000_000)
    tracemalloc.start()
    with pytest.raises(DrillTwinError, match=r"r.csv:1: expected a line of at most 1000000 characters"):
        read_columns(tmp_path / "r.csv")
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()


def test_what_is_refused_for_its_size_is_told(tmp_path):
    for name, text, words in (
        ("curves.las", las(0, 1000), "expected at most 1000 curves, found 1001"),
        ("tag.xml", witsml(5_000_000), "expected tags of at most 1000000 characters"),
        (
            "name.csv",
            f"time,{'x' * 1001}\n0,1\n",
            "names of columns of at most 1000 characters, found a name of 1001",
        ),
        ("delimiter.xml", witsml(delimiter="abc"), 'expected a dataDelimiter of one character, found "abc"'),
    ):
        (tmp_path / name).write_text(text, "latin-1")
        with pytest.raises(DrillTwinError, match=words):
            read_columns(tmp_path / name)


@pytest.mark.parametrize("cell", ["1_0", "\u0661\u0662", "\uff11", "1_0.5e1_0"])
def test_numbers_of_other_scripts_and_of_python_are_texts(tmp_path, cell):
    (tmp_path / "r.csv").write_text(f"t,a\n0,1\n1,{cell}\n", "utf-8")
    assert "a" not in read_columns(tmp_path / "r.csv")
