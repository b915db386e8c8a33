# SPDX-License-Identifier: Apache-2.0
"""A case: a scene that is run and compared with exact numbers, once for each form of the string and each variant."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from drill_twin.studies.verify.row import Row

SPATIAL, LATERAL = "spatial", "lateral"
FORMS = (SPATIAL, LATERAL)
"""Both forms of the string (`drill_twin.twin.form_of`)."""

Function = Callable[..., Iterable[Row]]


@dataclass(frozen=True, eq=False)
class Case:
    """One run, or a few that belong together."""

    name: str
    """`topic.function[variant,form]`."""
    topic: str
    """Module in `drill_twin.studies.verify`, such as `statics.buckling`."""
    form: str
    """"spatial", "lateral", or "both" where the case is about the two."""
    long: bool
    """Takes more than a few seconds; left out of the quick suite."""
    function: Function
    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def about(self) -> str:
        """What is shown and why the tolerance is what it is."""
        return inspect.getdoc(self.function) or ""

    def run(self) -> list[Row]:
        """The rows of the table.

        Raises:
            RunError: The motion could not be followed.
        """
        return list(self.function(**self.arguments))


CASES: list[Case] = []
"""Every case, in the order of the page."""


def case(*, forms: tuple[str, ...] = (SPATIAL,), long: bool = False, **variants: Iterable[Any]) -> Callable[..., Any]:
    """Register a function that yields rows.

    Args:
        forms: Run it for each of these, given as `form` if the function takes that; `()`: it is about both.
        long: Leave it out of the quick suite.
        variants: Run it for each value of these arguments too, and for their combinations.
    """

    def register(function: Function) -> Function:
        topic = ".".join(function.__module__.split(".")[-2:])
        whole = f"{topic.rpartition('.')[2]}.{getattr(function, '__name__', '')}"
        takes_form = "form" in inspect.signature(function).parameters
        for values in product(*variants.values()):
            for form in forms or ("both",):
                arguments = dict(zip(variants, values, strict=True))
                words = [str(value) for value in values] + ([form] if forms else [])
                name = whole + (f"[{','.join(words)}]" if words else "")
                given = arguments | ({"form": form} if takes_form else {})
                CASES.append(Case(name, topic, form, long, function, given))
        return function

    return register
