# SPDX-License-Identifier: Apache-2.0
"""Access to the page and to its commands: checks of a request's headers, links that open it, what a browser keeps.

A page of another origin cannot open the websocket, and a name that a stranger's DNS points here (DNS rebinding) is no
name of this server. Commands need a right, from this machine too: a proxy here looks like a user here.

A link has a code behind its #, which a browser sends to nobody. The page exchanges the code, once and soon, for a
cookie that no script reads and a key. Both are asked for: a browser sends cookies to all ports of a host, servers of
other people included, and writes to its profile in clear what a page stores.
"""

import hmac
import html
import os
import secrets
import socket
import tempfile
import threading
import time
import webbrowser
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from urllib.parse import urlsplit

from websockets.datastructures import Headers

from drill_twin.core.loopback import in_url, literal_address

WILDCARDS = {"0.0.0.0": "127.0.0.1", "::": "::1", "": "127.0.0.1"}  # noqa: S104 - compared with, not bound
"""Address of this machine for each address that stands for all of them."""
CODE_LIFE = 300.0
"""Life of a code [s]: time to carry a link to another screen, and for a browser to start."""


def _secret() -> str:
    return secrets.token_urlsafe(24)


@dataclass
class Access:
    """Names of this server, and what lets a page command."""

    allowed: Collection[str] = ()
    """Names that a Host header may have besides addresses and the names of this machine."""
    key: str = field(default_factory=_secret)
    """Half of the right to command that a page stores, for its origin alone."""
    _cookie: str = field(default_factory=_secret)
    _codes: dict[str, float] = field(default_factory=dict)  # ends of their lives by code

    def refusal(self, headers: Headers) -> tuple[HTTPStatus, str] | None:
        """Status and sentence for a request that is not for this server; None for a request that is."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        name = _host_name(hosts[0]) if len(hosts) == 1 and len(origins) < 2 else None
        if name is None:
            return HTTPStatus.BAD_REQUEST, "expected one header Host as NAME:PORT, and at most one header Origin\n"
        if not self._is_own(name):
            return (
                HTTPStatus.FORBIDDEN,
                "the page is not known by this name; start drill-twin watch with --allow-host NAME\n",
            )
        return None

    def is_foreign(self, headers: Headers) -> bool:
        """True if a page of another origin asks; programs that are no browsers send no origin."""
        origin = headers.get("Origin")
        host = headers["Host"]
        return origin is not None and origin.lower() not in {f"http://{host}".lower(), f"https://{host}".lower()}

    def may_view(self, headers: Headers) -> bool:
        """True for programs that are no browsers, pages of this server, and pages of an origin that is allowed."""
        origin = headers.get("Origin", "").lower()
        allowed = {name.lower() for name in self.allowed}
        return not self.is_foreign(headers) or origin in allowed or _host_name(origin.partition("://")[2]) in allowed

    def code(self) -> str:
        """A new code, which lets one page in within `CODE_LIFE`."""
        self._codes = {code: end for code, end in self._codes.items() if self.is_live(code)}
        self._codes[code := _secret()] = time.monotonic() + CODE_LIFE
        return code

    def is_live(self, code: str) -> bool:
        """True for a code that is neither spent nor too old; the look-up by a secret hash tells no part of a code."""
        return time.monotonic() < self._codes.get(code, 0.0)

    def enter(self, headers: Headers) -> str | None:
        """Spend the code of a request: the cookie to set, or None if there is no such code any more."""
        live = self.is_live(code := "".join(headers.get_all("X-Code")))
        self._codes.pop(code, None)
        return f"{_cookie_name(headers)}={self._cookie}; Path=/live; HttpOnly; SameSite=Strict" if live else None

    def has_cookie(self, headers: Headers) -> bool:
        """True for a browser that has entered."""
        cookies = (part.strip().partition("=") for text in headers.get_all("Cookie") for part in text.split(";"))
        name = _cookie_name(headers)
        return any(found == name and same(value, self._cookie) for found, _, value in cookies)

    def _is_own(self, name: str) -> bool:
        """True for an address, which no DNS can point elsewhere, and for the names of this machine."""
        if literal_address(name) is not None:
            return True
        own = {"localhost", socket.gethostname().lower(), *(allowed.lower().rstrip(".") for allowed in self.allowed)}
        return name.lower().rstrip(".") in own


_MINUTES = f"{CODE_LIFE / 60:g} minutes"
TOO_LATE = f"expected a new link, at most {_MINUTES} old; open the link that drill-twin watch printed last\n"
READ_ONLY = (
    "expected a page that may command, found a page that reads only, or a page of an earlier drill-twin watch; "
    "open the link that drill-twin watch printed last"
)
_PAGE = """<!doctype html>
<meta charset="utf-8"><meta name="referrer" content="no-referrer"><meta http-equiv="refresh" content="0; url={0}">
<title>drill_twin</title><p><a href="{0}">drill_twin</a>
"""


class Links:
    """Links to the page with a code each, and the file by which the browser of this machine gets one."""

    def __init__(self, access: Access, addresses: Sequence[str]) -> None:
        """Without a link yet.

        Args:
            access: Gives the codes.
            addresses: Address of the page for this machine; then one for other machines, if they can connect.
        """
        self._access, self._addresses = access, addresses
        self._printed = self._opened = ""  # codes
        self._file: Path | None = None
        self._lock = threading.Lock()

    def new(self) -> str:
        """A link that lets one page in."""
        return f"{self._addresses[0]}#code={self._access.code()}"

    def show(self, what: str = "a page that may command") -> None:
        """Print a link for one browser, unless the last one is good still."""
        with self._lock:
            if self._access.is_live(self._printed):
                return
            self._printed = self._access.code()
        links = [f"{address}#code={self._printed}" for address in self._addresses]
        other = "".join(f"\non other machines: {link}" for link in links[1:])
        print(f"{what} at {links[0]} (for one browser, within {_MINUTES}){other}", flush=True)

    def show_beside(self) -> None:
        """Print a link as `show`, in a thread: a terminal may be stopped, or gone."""

        def show() -> None:
            with suppress(OSError):  # nobody reads what is printed
                self.show()

        if not self._access.is_live(self._printed):
            threading.Thread(target=show, daemon=True).start()

    def open_browser(self) -> None:
        """Open the page in the browser of this machine.

        Everybody on a machine can read the words of a command. So the browser gets a file that its user alone can read,
        which leads to the link. It lies in the home folder: a browser in a snap sees neither /tmp nor hidden folders.
        """
        link = self.new()
        self._opened, self._file = link.rpartition("=")[2], _private_file(_PAGE.format(html.escape(link)))
        if self._file is None or not webbrowser.open(self._file.as_uri()):
            self.close()  # the printed link remains

    def tidy(self) -> None:
        """Delete the file once its code is spent or too old."""
        if not self._access.is_live(self._opened):
            self.close()

    def close(self) -> None:
        """Delete the file."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(OSError):  # a file that stays leads to a code that is spent or too old
                file.unlink(missing_ok=True)


def _private_file(text: str) -> Path | None:
    """New file of mode 600 in the home folder, or else in the temporary folder; None where neither can be written."""
    for folder in (os.path.expanduser("~"), tempfile.gettempdir()):  # noqa: PTH111 - Path.home may raise
        with (
            suppress(OSError),
            tempfile.NamedTemporaryFile(
                "w", encoding="utf-8", suffix=".html", prefix="drill_twin_", dir=folder, delete=False
            ) as stream,
        ):
            stream.write(text)
            return Path(stream.name)
    return None


def url(host: str, port: int) -> str:
    """Address of the page for a browser on this machine."""
    return f"http://{in_url(WILDCARDS.get(host, host))}:{port}/"


def same(given: str, secret: str) -> bool:
    """True for a secret; takes the same time for any other text."""
    return hmac.compare_digest(given.encode("utf-8", "surrogatepass"), secret.encode())


def _cookie_name(headers: Headers) -> str:
    """Name by the port that the browser knows: a host has one jar of cookies for all its ports."""
    return f"drill_twin_{urlsplit('//' + headers['Host']).port or ''}"


def _host_name(host: str) -> str | None:
    """Name or address in a Host header, without port and brackets; None if it is malformed."""
    try:
        parts = urlsplit(f"//{host}")
        valid = not (parts.path or parts.query or parts.fragment or parts.username or parts.password)
        return parts.hostname if valid and (parts.port is None or parts.port) else None
    except ValueError:
        return None
