# SPDX-License-Identifier: Apache-2.0
"""Headings of columns with a unit in brackets, as in tables of others: `WOB [kN]`, `RPM (rpm)`."""


def name_and_unit(heading: str) -> tuple[str, str]:
    """Split a heading into name and unit, without blanks around; the unit is empty where there is none.

    No regular expression: those for it take a time that grows with a power of the number of blanks.
    """
    text = heading.strip()
    begin = max(text.rfind("["), text.rfind("("))
    unit = text[begin + 1 : -1].strip()
    if begin < 0 or text[-1] not in "])" or not unit or "]" in unit or ")" in unit:
        return text, ""
    return text[:begin].strip(), unit
