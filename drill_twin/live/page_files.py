# SPDX-License-Identifier: Apache-2.0
"""Files of the page: HTML, CSS and JavaScript modules of this package, and plotly.js of the plotly package."""

from __future__ import annotations

import gzip
import pkgutil
from functools import cache
from http import HTTPStatus
from importlib.resources import files

from websockets.datastructures import Headers
from websockets.http11 import Response

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
    for file in files("drill_twin.live").joinpath("page").iterdir():
        kind = _TYPES.get(file.name.rpartition(".")[2])
        if kind is not None:
            found["/" if file.name == "index.html" else f"/{file.name}"] = (kind, file.read_bytes())
    return {**found, _PLOTLY: (_TYPES["js"], b"")}


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
