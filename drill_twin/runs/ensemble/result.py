# SPDX-License-Identifier: Apache-2.0
"""Result of an ensemble: arrays with one entry a member, and the members that failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from drill_twin.core.errors import ArgumentError, import_extra
from drill_twin.core.table import Table
from drill_twin.runs.ensemble.members import Members
from drill_twin.runs.ensemble.run import MemberRun
from drill_twin.whirl import Summary

if TYPE_CHECKING:
    import xarray

_OF_ALL = ("time", "frequency")  # coordinates, the same for all members
_TEXT = {"motion": "failed"}


class EnsembleResult:
    """Outputs of all members; M members in the order of `members`.

    Attributes:
        members: The members, each with its number and its `values` by key.
        runs: The outcome of each.
        names: Names of the outputs.
        units: Unit of each output, by name.
        dimensions: Dimensions of each output by name, after the dimension of the members.
    """

    def __init__(self, members: Members, runs: Sequence[MemberRun]) -> None:
        self._members, self.runs = members, list(runs)
        self.members = list(members)
        known = [run.values for run in runs if run.values]
        example = known[0] if known else {}
        self.names = [name for name in example if name != "summary"]
        self.units = {name: example[name].unit for name in self.names}
        self.dimensions = {name: example[name].dimensions for name in self.names}

    def __repr__(self) -> str:
        """One line: scene, members, failures."""
        failed = f", {len(self.failed)} failed" if self.failed else ""
        return f"<EnsembleResult of {self._members.base.name}: {self._members.told}{failed}>"

    def _repr_html_(self) -> str:
        """The same line, and the outputs with their units, for a notebook."""
        return f"<p>{escape(repr(self))}</p>{Table(('output', 'unit'), self.units.items()).html()}"

    @property
    def marks(self) -> list[str]:
        """Names of the marks."""
        return [mark.name for mark in self._members.base.string.marks]

    @property
    def failed(self) -> dict[int, str]:
        """Reason by number of each member that could not be followed to the end; its outputs are of the time before."""
        return {number: run.failure for number, run in enumerate(self.runs) if run.failure}

    @cached_property
    def coordinates(self) -> Mapping[str, Any]:
        """Values of the members by key, each of shape (M,): numbers in SI (of `rpm` in rev/min), or texts."""
        values = [self._members.numbers(key) for key in self._members.vary]
        columns = values if self._members.zipped else [axis.ravel() for axis in np.meshgrid(*values, indexing="ij")]
        return dict(zip(self._members.vary, map(np.array, columns), strict=True))

    @property
    def summaries(self) -> list[Summary | None]:
        """Findings of each member as of a single run, where `findings` was asked for."""
        return [run.values["summary"].value if "summary" in run.values else None for run in self.runs]

    @property
    def simulated(self) -> Any:
        """Simulated time of each member [s], shape (M,)."""
        return np.array([run.simulated for run in self.runs])

    @property
    def processor_seconds(self) -> float:
        """Processor time of all members [s]."""
        return sum(run.processor_seconds for run in self.runs)

    def __getitem__(self, name: str) -> Any:
        """Output of all members, shape (M, ...); NaN or "failed" for a member that failed in its first frame.

        Raises:
            ArgumentError: No output of this name.
        """
        if name not in self.names:
            raise ArgumentError(f"expected one of {', '.join(self.names) or 'no outputs'}, found {name!r}")
        found = [run.values.get(name) for run in self.runs]
        example = next(value for value in found if value is not None).value
        if name in _OF_ALL:
            return example
        missing = _TEXT.get(name, np.full(np.shape(example), np.nan))
        return np.array([missing if value is None else value.value for value in found])

    def to_xarray(self) -> xarray.Dataset:
        """Dataset with a dimension for each key that was varied; for zipped values one dimension `member`.

        Further dimensions are `mark`, `axis`, `sample` and `frequency`; each variable has its unit as attribute
        `units`. `failed` is True for a member that could not be followed to the end.

        Raises:
            ArgumentError: xarray is not installed.
        """
        labelled, members = import_extra("xarray"), self._members
        shape = members.shape
        keys = ("member",) if members.zipped else tuple(members.vary)
        coordinates: dict[str, Any] = {
            key: ("member", self.coordinates[key]) if members.zipped else members.numbers(key) for key in members.vary
        }
        coordinates["mark"] = self.marks
        variables: dict[str, Any] = {
            "failed": (keys, np.array([bool(run.failure) for run in self.runs]).reshape(shape))
        }
        for name in self.names:
            values, unit = self[name], {"units": self.units[name]}
            if name in _OF_ALL:
                coordinates[name] = (self.dimensions[name], values, unit)
            else:
                of_member = values.shape[1:]
                variables[name] = ((*keys, *self.dimensions[name]), values.reshape(*shape, *of_member), unit)
        if "axis" in {name for dimensions in self.dimensions.values() for name in dimensions}:
            coordinates["axis"] = ["x", "y"]
        result: xarray.Dataset = labelled.Dataset(variables, coordinates, {"scene": members.base.name})
        return result

    def to_pandas(self) -> Any:
        """DataFrame with a row for each member: its values by key, `failed`, and each output that is a single value.

        Columns are named as `onset_s [s]`, or `mark_1/radius_max [m]` for a mark; series and spectra are left out.

        Raises:
            ArgumentError: pandas is not installed.
        """
        columns = {**self.coordinates, "failed": [bool(run.failure) for run in self.runs]}
        for name in self.names:
            heading = f"{name} [{self.units[name]}]" if self.units[name] else name
            if not self.dimensions[name]:
                columns[heading] = self[name]
            elif self.dimensions[name] == ("mark",):
                columns |= {f"{mark}/{heading}": column for mark, column in zip(self.marks, self[name].T, strict=True)}
        return import_extra("pandas").DataFrame(columns)
