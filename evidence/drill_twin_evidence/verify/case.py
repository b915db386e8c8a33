# SPDX-License-Identifier: Apache-2.0
"""Case: a function that runs scenes and yields rows, registered once for each formulation and variant."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from drill_twin_evidence.verify.row import Row

SPATIAL, LATERAL = "spatial", "lateral"
FORMS = (SPATIAL, LATERAL)
"""Both formulations (`drill_twin.dynamics.discretisation.kernel_arguments.form_of`)."""

Function = Callable[..., Iterable[Row]]


@dataclass(frozen=True, eq=False)
class Case:
    """One variant of a check, run in one formulation."""

    name: str
    """Name as `module.function[variant,form]`."""
    topic: str
    """Module in `drill_twin_evidence.verify`, as `statics.buckling`."""
    form: str
    """"spatial", "lateral", or "both" for a comparison of the two."""
    long: bool
    """Takes more than a few seconds; left out by `--quick` and run by `make test-long`."""
    function: Function
    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def about(self) -> str:
        """Description of the case and reason of its tolerance: the docstring of its function."""
        return inspect.getdoc(self.function) or ""

    def run(self) -> list[Row]:
        """Run the case and return its rows.

        Raises:
            RunError: A time step did not converge.
        """
        return list(self.function(**self.arguments))


CASES: list[Case] = []
"""Every registered case."""


def case(*, forms: tuple[str, ...] = (SPATIAL,), long: bool = False, **variants: Iterable[Any]) -> Callable[..., Any]:
    """Decorator that registers a function that yields rows.

    Args:
        forms: Formulations to run, passed as `form` if the function takes it; `()`: one case for both.
        long: Leave the case out of the quick ones.
        variants: Values of further arguments; a case for each combination.
    """

    def register(function: Function) -> Function:
        topic = ".".join(function.__module__.split(".")[-2:])
        name_of_function = f"{topic.rpartition('.')[2]}.{getattr(function, '__name__', '')}"
        takes_form = "form" in inspect.signature(function).parameters
        for values in product(*variants.values()):
            for form in forms or ("both",):
                arguments = dict(zip(variants, values, strict=True))
                labels = [str(value) for value in values] + ([form] if forms else [])
                name = name_of_function + (f"[{','.join(labels)}]" if labels else "")
                given = arguments | ({"form": form} if takes_form else {})
                CASES.append(Case(name, topic, form, long, function, given))
        return function

    return register
