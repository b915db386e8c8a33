# SPDX-License-Identifier: Apache-2.0
"""The page of the closed search of the paper has the counts of its records."""

import csv
import json
from pathlib import Path

import numpy as np

EVIDENCE = Path(__file__).parents[2]
PAGE = (EVIDENCE / "docs" / "paper_search.md").read_text("utf-8")


def test_the_page_has_the_counts_of_the_record_of_the_search():
    with (EVIDENCE / "docs" / "paper_exclusion.csv").open(encoding="utf-8") as stream:
        pairs = list(csv.DictReader(stream))
    least = {name: np.array([float(pair[name]) for pair in pairs]) for name in list(pairs[0])[2:]}
    strict, loose = (least[name] > 1.0 for name in ("all kept", "none kept"))
    assert (
        f"{strict.sum()} of {len(pairs)} pairs were met by no set; with any choice and any reading,\n{loose.sum()}"
        in PAGE
    )
    for name in list(least)[1:-1]:
        assert f"| {name} | {(strict & (least[name] <= 1.0)).sum()} |" in PAGE
    for pair, excluded in zip(pairs, loose, strict=True):
        assert not excluded or f"| {float(pair['all kept']):.2f} | {float(pair['none kept']):.2f} |" in PAGE


def test_the_page_has_the_counts_of_the_search_by_runs_alone():
    page = PAGE.partition("## The search repeated")[2]
    data = json.loads((EVIDENCE / "pages" / "paper_search.json").read_text("utf-8"))
    pairs = np.tril_indices(len(data["numbers"]), -1)
    least = np.array(list(data["least"].values()), float)[:, *pairs]
    strict = least[0] > 1.0  # all assumptions kept; in the last row none is
    opened = [int((row[strict] <= 1.0).sum()) for row in least]
    assert f"{data['sets']} sets by {data['runs']} runs" in page
    assert f"| pairs met by no set, all kept | 35 | {strict.sum()} |" in page
    assert f"| pairs met by no set, none kept | 4 | {(least[-1] > 1.0).sum()} |" in page
    assert f"R as the diameter alone | 26 | {opened[1]} |" in page
    assert f"any reading alone | 13 | {opened[7]} |" in page
    assert opened[2:7] == [0] * 5
    for before, words in ((10, "all"), (11, "none")):
        most = max(one["met"] for one in data["finalists"] if one["under"] == f"{words} kept")
        assert f"met by one set, {words} kept | {before} | {most} |" in page
