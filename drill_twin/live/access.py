# SPDX-License-Identifier: Apache-2.0
"""Access to the page and to its commands: checks of a request's headers, its address and its token.

A page of another origin cannot open the websocket, and a name that a stranger's DNS points here (DNS rebinding) is no
name of this server. Commands need the token of the printed address, from this machine too: a proxy here looks like a
user here. It stands behind the # of the address, which a browser sends to nobody; the page takes it out of there, and
sends it as its first message.
"""

from __future__ import annotations

import hmac
import secrets
import socket
from collections.abc import Collection
from dataclasses import dataclass, field
from http import HTTPStatus
from urllib.parse import urlsplit

from websockets.datastructures import Headers

from drill_twin.core.loopback import in_url, literal_address

WILDCARDS = ("0.0.0.0", "::", "")  # noqa: S104 - compared with, not bound
_TOKEN_BYTES = 24


@dataclass
class Access:
    """Names of this server, and the token for commands."""

    allowed: Collection[str] = ()
    """Names that a Host header may have besides those of this machine and addresses."""
    token: str = field(default_factory=lambda: secrets.token_urlsafe(_TOKEN_BYTES))

    def refusal(self, headers: Headers) -> tuple[HTTPStatus, str] | None:
        """Status and sentence for a request that is not for this server; None for one that is."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return HTTPStatus.BAD_REQUEST, "expected one Host and at most one Origin\n"
        name = _host_name(hosts[0])
        if name is None:
            return HTTPStatus.BAD_REQUEST, "expected the Host as NAME:PORT\n"
        if not self._is_own(name):
            return HTTPStatus.FORBIDDEN, "this page is not known by that name; start it with --allow-host NAME\n"
        return None

    def is_foreign(self, headers: Headers) -> bool:
        """True if a page of another origin asks; programs that are no browsers send no origin."""
        origin = headers.get("Origin")
        host = headers["Host"]
        return origin is not None and origin.lower() not in {f"http://{host}".lower(), f"https://{host}".lower()}

    def may_view(self, headers: Headers) -> bool:
        """True for programs that are no browsers, pages of this server, and those of an origin that is allowed."""
        origin = headers.get("Origin", "").lower()
        allowed = {name.lower() for name in self.allowed}
        return not self.is_foreign(headers) or origin in allowed or _host_name(origin.partition("://")[2]) in allowed

    def is_token(self, given: str) -> bool:
        """True for the token; takes the same time for any other."""
        return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), self.token.encode())

    def url(self, host: str, port: int) -> str:
        """Address of the page, with the token that lets it command."""
        return f"{url(host, port)}#token={self.token}"

    def _is_own(self, name: str) -> bool:
        """True for an address, which no DNS can point elsewhere, and for the names of this machine."""
        if literal_address(name) is not None:
            return True
        own = {"localhost", socket.gethostname().lower(), *(allowed.lower().rstrip(".") for allowed in self.allowed)}
        return name.lower().rstrip(".") in own


def url(host: str, port: int) -> str:
    """Address of the page for a browser on this machine."""
    if host in {"::", "::1"}:
        shown = "[::1]"
    elif host in WILDCARDS:
        shown = "127.0.0.1"
    else:
        shown = in_url(host)
    return f"http://{shown}:{port}/"


def _host_name(host: str) -> str | None:
    """Name or address in a Host header, without port and brackets; None if it is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        valid = not (parts.path or parts.query or parts.fragment or parts.username or parts.password)
        return parts.hostname if valid and (parts.port is None or parts.port) else None
    except ValueError:
        return None
