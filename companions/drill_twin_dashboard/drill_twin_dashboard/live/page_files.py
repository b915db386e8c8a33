# SPDX-License-Identifier: Apache-2.0
"""Files of the page: HTML, CSS and JavaScript modules of this package, and plotly.js of the plotly package."""

from __future__ import annotations

import gzip
import json
import math
import pkgutil
from functools import cache
from http import HTTPStatus
from importlib.resources import files

from websockets.datastructures import Headers
from websockets.http11 import Response

from drill_twin.core.units.registry import si_factor
from drill_twin.core.units.system import SYSTEMS

_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript"}
_PLOTLY = "/plotly.js"
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Everything comes from this server; plotly writes style attributes and shows heat maps as `data:` images."""


def page_files() -> dict[str, tuple[str, bytes]]:
    """Type and content of each file by its path on the server; `/` is the page."""
    found = {"/": ("text/html", b"")}
    for file in files("drill_twin_dashboard.live").joinpath("page").iterdir():
        kind = _TYPES.get(file.name.rpartition(".")[2])
        if kind is not None:
            found["/" if file.name == "index.html" else f"/{file.name}"] = (kind, file.read_bytes())
    found["/unit_table.js"] = (_TYPES["js"], _unit_table().encode())
    return {**found, _PLOTLY: (_TYPES["js"], b"")}


_DIGITS = {
    "force": {"N": 1, "kN": 1, "klbf": 1, "tf": 1}, "rotation": {"rev/s": 2, "rpm": 0},
    "torque": {"N m": 3, "kN m": 2, "klbf ft": 2}, "rate": {"m/h": 1, "ft/h": 1}, "length": {"m": 1, "ft": 0},
    "offset": {"mm": 1, "in": 2}, "stress": {"MPa": 2, "ksi": 2},
}  # fmt: skip
"""Units that a reader of the page can choose for each quantity, with their digits."""


def _unit_table() -> str:
    """Module with the systems of `drill_twin.core.units.system`, and sizes of units; rotation is in rev/s."""
    systems = {name: {of: getattr(system, of) for of in _DIGITS} for name, system in SYSTEMS.items()}
    units = {
        of: {
            unit: [si_factor(unit)[0] / (math.tau if of == "rotation" else 1.0), digits] for unit, digits in row.items()
        }
        for of, row in _DIGITS.items()
    }
    return f"export const SYSTEMS = {json.dumps(systems)}, UNITS = {json.dumps(units)};\n"


def file_response(path: str, kind: str, content: bytes, *, packed: bool) -> Response:
    """Answer with a file of `page_files`; plotly.js is compressed for a browser that takes it `packed`."""
    more = {}
    if path == _PLOTLY:
        content = _plotly(packed=packed)
        more = {"Content-Encoding": "gzip"} if packed else {}
    return response(kind, content, **more)


def response(kind: str, content: bytes, **more: str) -> Response:
    """Answer 200 with the headers of this page."""
    headers = Headers(
        {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(content)),
            "Content-Security-Policy": _POLICY,
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Referrer-Policy": "no-referrer",
            "Connection": "close",
            **more,
        }
    )
    return Response(HTTPStatus.OK, "OK", headers, content)


@cache
def _plotly(*, packed: bool) -> bytes:
    content = pkgutil.get_data("plotly", "package_data/plotly.min.js") or b""
    return gzip.compress(content, 6, mtime=0) if packed else content
