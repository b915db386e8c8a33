# SPDX-License-Identifier: Apache-2.0
"""Result of one check."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Verdicts, by weight: a problem makes the exit code 1."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"


@dataclass(frozen=True)
class Check:
    """One check: what was looked at, what was found, and what to do."""

    section: str
    """Heading under which it is printed."""
    name: str
    found: str
    verdict: Verdict = Verdict.OK
    remedy: str = ""
    """Remedy; empty where there is nothing."""
