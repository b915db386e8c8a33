# SPDX-License-Identifier: Apache-2.0
"""A digital twin of a flexible drillstring as a ROS 2 node set, and its Python API.

>>> import drill_twin as dt
>>> result = dt.Simulation("pa6_bench").run(duration=30)
>>> result.onset_s

`drill_twin.api` defines the names. Each is loaded on first use, so a node that needs one module does not load all.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from drill_twin.core import __version__ as __version__

if TYPE_CHECKING:
    from drill_twin.api import *  # noqa: F403 - all its names


def __getattr__(name: str) -> Any:
    """Load a name of the API on first use."""
    if name.startswith("__") and name != "__all__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    api = import_module("drill_twin.api")
    if name == "__all__":
        return [*api.__all__, "__version__"]
    return getattr(api, name)


def __dir__() -> list[str]:
    """Names of the API, loaded or not."""
    return sorted({*globals(), *__getattr__("__all__")})
