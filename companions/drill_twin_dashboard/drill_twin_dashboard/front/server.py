# SPDX-License-Identifier: Apache-2.0
"""Server of the front door: what is in the folder, requests to run commands, and files of the folder.

All of it needs the right to command, as the folder may be private. The files have addresses that only such a page is
told, and open as documents without an origin: a script in a report reaches neither this server nor what a browser keeps
for it.
"""

import asyncio
import json
import secrets
from collections.abc import Collection, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from pydantic import BaseModel, TypeAdapter
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from drill_twin.cli.emit import folder_name
from drill_twin.core.errors import ArgumentError
from drill_twin_dashboard.front.folder import Folder
from drill_twin_dashboard.front.forms import Form, forms
from drill_twin_dashboard.front.jobs import Jobs
from drill_twin_dashboard.live.server import PageServer, page_files, response
from drill_twin_dashboard.live.web_server import DOWNLOAD

_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""A report has its scripts and pictures in itself; the document has no origin, and loads and sends nothing."""


class _Asked(BaseModel):
    """A request of the page: a command with its arguments, options and texts of files, or the number of one to stop."""

    do: str = ""
    on: list[str] = []
    options: dict[str, str | bool] = {}
    tables: dict[str, str] = {}
    stop: int = 0


class FrontServer(PageServer):
    """Server of the page for a folder."""

    PUBLIC = False
    PERIOD = 0.5
    LARGEST_REQUEST = 1_000_000
    REQUEST = TypeAdapter(_Asked)

    def __init__(self, root: Path, *, host: str = "127.0.0.1", port: int = 8000, names: Collection[str] = ()) -> None:
        """Start to serve.

        Args:
            root: The folder.
            host: Address to listen on.
            port: Port; 0 takes a free one.
            names: Names by which browsers may know this server, besides the machine's names.

        Raises:
            RunError: The port is taken, or the address is none of this machine.
        """
        self._folder, self._forms, self._jobs = Folder(root), forms(), Jobs(root)
        self._files_at = f"/live/files/{secrets.token_urlsafe(24)}/"
        self._pages = ["--port=0", "--no-browser", f"--host={host}", *(f"--allow-host={name}" for name in names)]
        super().__init__(self._picture, self._take, host=host, port=port, allowed_hosts=names)
        script = f"export const FORMS = {json.dumps(self._forms)};\n".encode()
        self._files |= page_files("drill_twin_dashboard.front") | {"/forms.js": ("text/javascript", script)}

    def close(self) -> None:
        """Stop to serve, and all commands that run."""
        super().close()
        self._jobs.close()

    def _picture(self) -> Mapping[str, Any]:
        facts = {"folder": str(self._folder.root), "installed": self._folder.installed, "at": self._files_at}
        return {**facts, "commands": self._jobs.shown, **self._folder.listed()}

    def _take(self, content: Mapping[str, Any]) -> None:
        """Start or stop a command.

        Raises:
            DrillTwinError: The request asks for what the page does not offer, or too many commands run.
        """
        asked = _Asked(**content)
        if asked.stop:
            self._jobs.stop(asked.stop)
            return
        do, on, options = asked.do, asked.on, asked.options
        if (form := self._forms.get(do)) is None or not on:
            raise ArgumentError(f"expected one of {', '.join(self._forms)} on scene or result, found {do[:40]}")
        taken = {job["out"] for job in self._jobs.shown if job["code"] is None}
        name = folder_name(Path(on[0].partition(",")[0]).name.removesuffix(".yaml"))
        if form["target"] == "FILE":
            on = [self._folder.fresh(name, ".yaml", taken)]
            for option, text in asked.tables.items():
                new = folder_name(f"{name}_{option[2:]}")
                options[option] = self._folder.fresh(new, ".csv", content=text.encode("utf-8", "replace"))
        if "--out" in form["fields"]:
            options.setdefault("--out", self._folder.fresh(f"out/{do}_{name}", taken=taken))
        for place in on:
            self._folder.inside(place.partition(",")[0])
        words = [*do.split(), *on, *self._words(form, options), *(self._pages if do == "watch" else ())]
        self._jobs.add(words, str(options.get("--out", on[0])))

    def _words(self, form: Form, options: Mapping[str, str | bool]) -> list[str]:
        """Words of options: a value stands behind the = of its option, so no value is an option itself.

        Raises:
            ArgumentError: An option has no entry in the form, or its value is a path elsewhere.
        """
        words = []
        for option, value in options.items():
            if (field := form["fields"].get(option)) is None:
                raise ArgumentError(f"expected an option of {', '.join(form['fields'])}, found {option[:40]}")
            if field["metavar"] in {"CSV", "DIR", "FILE"}:
                self._folder.inside(str(value))
            lines = str(value).splitlines() if field["kind"] == "list" else [value]
            words += [option if line is True else f"{option}={line}" for line in lines if line]
        return words

    async def _respond(self, connection: ServerConnection, request: Request) -> Response | None:
        path = urlsplit(request.path).path
        if not path.startswith("/live/"):
            return await super()._respond(connection, request)
        told = secrets.compare_digest(path[: len(self._files_at)].encode(), self._files_at.encode())
        if not told or self._access.is_foreign(request.headers) or not self._access.has_cookie(request.headers):
            return connection.respond(HTTPStatus.FORBIDDEN, "expected the address of a file from the page\n")
        connection.close_timeout = DOWNLOAD
        found = await asyncio.to_thread(self._folder.content, unquote(path[len(self._files_at) :]))
        if found is None:
            return connection.respond(HTTPStatus.NOT_FOUND, "expected a page, picture or table of the folder\n")
        return response(*found, _POLICY)
