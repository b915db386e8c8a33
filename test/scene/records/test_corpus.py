# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: E501  a line a record
"""A corpus of records in the layouts of the trade, made here with their right values: wrong must be 0."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pytest

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.bag.virtual_bags import RecordBag

ROWS = 40
K = np.arange(ROWS)
WOB = np.round(21.0 + 3.0 * np.sin(0.3 * K), 2)
RPM = np.round(118.0 + 2.0 * np.cos(0.5 * K), 1)
TQ = np.round(9.4 + 1.7 * np.sin(0.9 * K), 3)
HKL = np.round(186.0 + 4.0 * np.cos(0.2 * K), 1)
KLBF, FTLBF, KGF, TURN = 4448.2216152605, 1.3558179483, 9.80665, math.pi / 30.0
START = datetime(2025, 11, 7, 23, 59, 42, tzinfo=UTC)
NAN = math.nan


class Case(NamedTuple):
    """File of the corpus, and its right values."""

    text: str | bytes
    factors: tuple[float, float, float, float] = (KLBF, TURN, 1e3 * FTLBF, KLBF)
    gaps: Mapping[str, object] = MappingProxyType({})
    options: tuple[str, ...] = ()
    refused: str = ""
    ending: str = "csv"
    step: float = 1.0
    absent: tuple[str, ...] = ()
    said: str = ""


NAMES = ("weight_on_bit", "rotation", "torque", "hookload")
VALUES = (WOB, RPM, TQ, HKL)
HEAD = "Time [s],WOB [klbf],RPM [rpm],TQA [kft.lbf],HKLD [klbf]"


def rows(times=None, values=VALUES, between=",", form=str, more=(), order=K):
    times = [str(k) for k in K] if times is None else times
    found = [
        between.join((times[k], *(form(float(column[k])) for column in values), *(one[k] for one in more)))
        for k in order
    ]
    return "\n".join(found) + "\n"


def table(head=HEAD, **given):
    return f"{head}\n{rows(**given)}"


def stamps(form, step=1.0, start=START):
    return [(start + timedelta(seconds=step * float(k))).strftime(form) for k in K]


def holed(null, column=0, at=slice(10, 15), head=HEAD, between=","):
    lines = table(head=head, between=between).splitlines()
    for k in range(*at.indices(ROWS)):
        cells = lines[1 + k].split(between)
        cells[1 + column] = null
        lines[1 + k] = between.join(cells)
    return "\n".join(lines) + "\n"


def comma(value):
    return str(value).replace(".", ",")


def las(
    unit="S", times=None, units=("klbf", "rpm", "kft.lbf", "klbf"), names=("WOB", "RPM", "TQA", "HKLD"), null="-999.25"
):
    curves = "".join(f" {name}.{one} : {name}\n" for name, one in zip(("TIME", *names), (unit, *units), strict=True))
    head = f"~Version\n VERS. 2.0 : LAS\n WRAP. NO : one line\n~Well\n NULL. {null} : null\n~Curve\n{curves}~A\n"
    return head + rows(times=times, between=" ")


def titled(*words, **given):
    return table(head=",".join(words), **given)


GAP = {"weight_on_bit": slice(10, 15)}
DATE_HEAD = "Date Time,WOB [klbf],RPM [rpm],TQA [kft.lbf],HKLD [klbf]"
SECONDS = [f"{(START + timedelta(seconds=int(k))).timestamp():.0f}" for k in K]
PASON = "YYYY/MM/DD,HH:MM:SS,Weight on Bit (klbs),Rotary RPM (RPM),Convertible Torque (kft_lb),Hook Load (klbs)"
TWO = [f"{day},{clock}" for day, clock in zip(stamps("%Y/%m/%d"), stamps("%H:%M:%S"), strict=True)]
CORPUS = {
    "plain": Case(table()),
    **{f"null {null}": Case(holed(null), gaps=GAP) for null in (
        "-999.25", "-999.2500", "-9.9925e2", "-999", "-999.0", "-9999", "-9999.00", "-9999.25", "-8888", "9999", "9999.0",
        "+9999", "99999", "-32768", "", "NaN", "nan", "#N/A", "No Data", "NO DATA", "1.#QNAN", "-1.#IND", "NULL", "--", "#VALUE!",
    )},
    "null of the user": Case(holed("-555"), gaps=GAP, options=("null_value=-555",)),
    "null of a LAS header": Case(las(null="-777").replace(str(TQ[3]), "-777.0"), gaps={"torque": TQ[3] == TQ}, ending="las"),
    "another null than the header's": Case(las().replace(str(TQ[3]), "-9999"), gaps={"torque": TQ[3] == TQ}, ending="las"),
    "no weight of a rig": Case(holed("-3.8e6"), gaps=GAP, said="beyond any weight on bit"),
    "torque that passes 9999": Case(
        titled("Time [s]", "WOB [klbf]", "RPM [rpm]", "TQA [ft.lbf]", "HKLD [klbf]", values=(WOB, RPM, 9979.0 + K, HKL)),
        (KLBF, TURN, FTLBF, KLBF)),
    "torque that passes -999": Case(
        titled("Time [s]", "WOB [klbf]", "RPM [rpm]", "TQA [N.m]", "HKLD [klbf]", values=(WOB, RPM, -1019.0 + K, HKL)),
        (KLBF, TURN, 1.0, KLBF)),
    "semicolons and decimal commas": Case(table(head=HEAD.replace(",", ";"), between=";", form=comma)),
    "sep=": Case("sep=;\n" + table(head=HEAD.replace(",", ";"), between=";")),
    "tabs": Case(table(head=HEAD.replace(",", "\t"), between="\t")),
    "quoted decimal commas": Case(table(form=lambda value: f'"{comma(value)}"')),
    "thousands": Case(table(values=(WOB, RPM, TQ, HKL + 1000.0), form=lambda value: f'"{value:,.3f}"')),
    "thousands with points": Case(table(head=HEAD.replace(",", ";"), between=";", values=(WOB, RPM, TQ, HKL + 1000.0),
        form=lambda value: f"{value:,.3f}".translate(str.maketrans(",.", ".,")))),
    "commas that may be either": Case("Time [s]\tRPM [rpm]\n0\t1,150\n1\t1,151\n", refused="which may be either"),
    "Latin-1": Case(table(head=HEAD + ",Öl [°C]", more=[["20"] * ROWS]).encode("latin-1")),
    "UTF-16": Case(table().encode("utf-16")),
    "UTF-8 with a mark": Case(table().encode("utf-8-sig")),
    "Windows lines": Case(table().replace("\n", "\r\n")),
    "preamble": Case("Company,Example Drilling\nRig,12\nWell,A-4\n\n" + table()),
    "preamble filled by a spreadsheet": Case("Company,Example,,,\nRig,12,,,\n" + table()),
    "preamble of text": Case("Export of 7 November 2025\n" + table()),
    "row of units": Case("Time,WOB,RPM,TQA,HKLD\ns,klbf,rpm,kft.lbf,klbf\n" + rows()),
    "row of units in brackets": Case("Time,WOB,RPM,TQA,HKLD\n(s),(klbs),(RPM),(kft_lb),(klbs)\n" + rows()),
    "preamble and row of units": Case("Well,A-4\nTime,WOB,RPM,TQA,HKLD\ns,klbf,rpm,kft.lbf,klbf\n" + rows()),
    "rows that end with a comma": Case(table(more=[[""] * ROWS])),
    "column of text": Case(table(head=HEAD + ",Rig Mode", more=[["Drilling"] * ROWS]), said='text, "Drilling" in row 1'),
    "column twice": Case(table(head=HEAD + ",Flow,Flow", more=[["1"] * ROWS] * 2), said="twice in the header"),
    "column without a unit": Case(titled("Time [s]", "WOB", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        absent=("weight_on_bit",), said='no unit: give it, as --channel "weight_on_bit=WOB:UNIT"'),
    "unit by an option": Case(titled("Time [s]", "WOB", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        options=("weight_on_bit=WOB:klbf",)),
    "column by an option": Case(titled("Time [s]", "Sensor 7", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        options=("weight_on_bit=Sensor 7:1000 lbs",)),
    "unknown unit": Case(titled("Time [s]", "WOB [furlong]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        absent=("weight_on_bit",), said="unknown unit furlong"),
    "time without a unit": Case(titled("TIME", "WOB [klbf]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        refused='TIME: no unit: give it, as --channel "time=TIME:UNIT"'),
    "time by an option": Case(titled("TIME", "WOB [klbf]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"),
        options=("time=TIME:s",)),
    **{f"date {form}": Case(table(head=DATE_HEAD, times=stamps(form))) for form in (
        "%Y-%m-%dT%H:%M:%S", "%Y-%m-%dT%H:%M:%SZ", "%Y-%m-%d %H:%M:%S+01:00", "%Y/%m/%d %H:%M:%S", "%d/%m/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S",
        "%d.%m.%Y %H:%M:%S", "%d-%b-%Y %H:%M:%S", "%d %B %Y %H:%M:%S", "%d-%b-%y %H:%M:%S", "%b %d %Y %I:%M:%S %p",
        "%m/%d/%Y %I:%M:%S %p", "%y/%m/%d %H:%M:%S", "%Y%m%dT%H%M%S",
    )},
    "day above 12": Case(table(head=DATE_HEAD, times=stamps("%m/%d/%Y %H:%M:%S", start=START + timedelta(days=10)))),
    "fractions of seconds": Case(table(head=DATE_HEAD, times=[f"2025-11-07 10:00:{0.2 * k:06.3f}" for k in K]), step=0.2),
    "month first by an option": Case(
        table(head=DATE_HEAD, times=stamps("%m/%d/%Y %H:%M:%S")), options=("time=Date Time:MM/DD/YYYY",)),
    "two columns of Pason": Case(f"{PASON}\n" + rows(times=TWO), said="a date or a clock"),
    "two columns, names": Case(table(head="Date,Time,WOB [klbf],RPM [rpm],TQA [kft.lbf],HKLD [klbf]", times=TWO)),
    "clock past midnight": Case(table(head=HEAD.replace("Time [s]", "Time"), times=stamps("%H:%M:%S"))),
    "seconds since 1970": Case(table(head=DATE_HEAD, times=SECONDS)),
    "seconds since 1970 with a unit": Case(table(times=SECONDS)),
    "milliseconds since 1970": Case(table(head=DATE_HEAD, times=[f"{one}250" for one in SECONDS])),
    "nanoseconds since 1970": Case(table(head=DATE_HEAD, times=[f"{one}000000000" for one in SECONDS])),
    "days of a spreadsheet": Case(table(head=DATE_HEAD, times=[f"{45968.0 + k / 86400.0:.9f}" for k in K])),
    "newest first": Case(table(order=K[::-1]), said="newest came first"),
    "newest date first": Case(table(head=DATE_HEAD, times=stamps("%d/%m/%Y %H:%M:%S"), order=K[::-1])),
    "two rows changed": Case(table(order=[*K[:20], 21, 20, *K[22:]]), said="rows sorted by time"),
    "stamps twice": Case(table(order=np.repeat(K, 2)), said="40 rows with a repeated stamp"),
    "one row": Case(table(order=[3]), refused="at least two time stamps"),
    "one stamp": Case(table(times=["5"] * ROWS), refused="at least two time stamps"),
    "hour of autumn": Case(table(head=DATE_HEAD, times=[f"2025-10-26 02:{'59' if k < 20 else '00'}:{(40 + k) % 60:02}" for k in K]), said="set back by an hour"),
    "two runs in one file": Case(table() + rows(), refused="give each run a file of its own"),
    "minutes": Case(titled("Time (min)", "WOB [klbf]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"), step=60.0),
    "hrs": Case(titled("Elapsed Time (hrs)", "WOB [klbf]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"), step=3600.0),
    "Totco": Case(titled("Time (secs)", "Weight on Bit (1000 lbs)", "RPM - Surface (r/min)", "Rotary Torque (klb-ft)", "Hook Load (1000 lbs)")),
    "Volve": Case(titled("Time s", "Averaged WOB kkgf", "Average Rotary Speed rpm", "Average Surface Torque kN.m", "Total Hookload kkgf"),
        (1e3 * KGF, TURN, 1e3, 1e3 * KGF)),
    "Volve GS_": Case(titled("TIME [s]", "GS_SWOB [kkgf]", "GS_RPM [rpm]", "GS_TQA [kN.m]", "GS_HKLD [kkgf]"),
        (1e3 * KGF, TURN, 1e3, 1e3 * KGF)),
    "WITS names and metric units": Case(titled("TIME (s)", "WOBA (KDN)", "RPMA (RPM)", "TQA (KNM)", "HKLA (KDN)"),
        (1e4, TURN, 1e3, 1e4)),
    "tonnes": Case(titled("Time_s", "SWOB_tonne", "TDRPM", "STOR_kgf.m", "HKLD_tf"), (1e3 * KGF, TURN, KGF, 1e3 * KGF)),
    "ton": Case(titled("Time_s", "SWOB [ton]", "TDRPM [rev/min]", "STOR [daN.m]", "HKLD [ton]"), (1e3 * KGF, TURN, 10.0, 1e3 * KGF),
        said="is taken for tonnes-force"),
    "pounds": Case(titled("Time_s", "SWOB [lb]", "RPM", "TQ [ft_lbs]", "HKLD [lbs]"), (KLBF / 1e3, TURN, FTLBF, KLBF / 1e3),
        said="is taken for pounds-force"),
    "Drillbotics": Case(table(head="timestamp_utc_iso,wob_kN,rpm,torque_kNm,hookload_kN", times=stamps("%Y-%m-%dT%H:%M:%SZ")),
        (1e3, TURN, 1e3, 1e3)),
    "LAS": Case(las(), ending="las"),
    "LAS with units in brackets": Case(las("[s]", units=("[klbf]", "[rpm]", "[kft.lbf]", "[klbf]")), ending="las"),
    "LAS with day first": Case(las("DD/MM/YYYY-HH:MM:SS", stamps("%d/%m/%Y-%H:%M:%S")), ending="las"),
    "LAS with other names": Case(las(names=("SWOB", "TDRPM", "TORQ", "HOOK")), ending="las"),
    "over depth": Case(titled("Depth [m]", "WOB [klbf]", "RPM [rpm]", "TQA [kft.lbf]", "HKLD [klbf]"), refused="expected columns of time"),
}  # fmt: skip


def judged(name, folder):
    """Verdict on a file of the corpus, and what was found."""
    case = CORPUS[name]
    path = Path(folder) / f"{len(name)}.{case.ending}"
    path.write_bytes(case.text if isinstance(case.text, bytes) else case.text.encode())
    try:
        bag = RecordBag(path, case.options)
    except DrillTwinError as error:
        return ("refused rightly" if case.refused and case.refused in str(error) else "wrong"), str(error)
    found = {name: values for name, values in bag._values.items() if name in NAMES}
    told = "; ".join((*bag.notes, *(f"{one['why']} {one['left_out']}" for one in bag.columns)))
    right = not case.refused and case.said in told and {*NAMES} - {*found} == {*case.absent}
    stamps_found = (bag._stamps - bag._stamps[0]) * 1e-9
    right &= stamps_found.size == ROWS and np.allclose(stamps_found, case.step * K, atol=2e-3)
    for channel, values, factor in zip(NAMES, VALUES, case.factors, strict=True):
        if not right or channel in case.absent:
            continue
        expected = values * factor
        if "passes" in name and channel == "torque":
            expected = ((9979.0 if "9999" in name else -1019.0) + K) * factor
        if "thousands" in name and channel == "hookload":
            expected = expected + 1000.0 * factor
        expected[case.gaps.get(channel, slice(0))] = NAN
        right &= np.allclose(found[channel], expected, rtol=1e-6, equal_nan=True)
    return (
        "right with one option" if case.options else "right"
    ) if right else "wrong", f"{told} {found} {stamps_found}"


@pytest.mark.parametrize("name", CORPUS)
def test_a_record_of_the_trade_is_read_right_or_refused(name, tmp_path):
    verdict, found = judged(name, tmp_path)
    assert verdict != "wrong", found


def test_the_table_of_the_corpus(tmp_path, capsys):
    count = Counter(judged(name, tmp_path)[0] for name in CORPUS)
    with capsys.disabled():
        print(f"\n{sum(count.values())} records of the trade: {dict(count)}")
    assert not count["wrong"]
    assert count["refused rightly"] <= 0.1 * count.total()
