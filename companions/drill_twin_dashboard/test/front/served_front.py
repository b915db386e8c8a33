# SPDX-License-Identifier: Apache-2.0
"""The front door of a folder, and a client of it that is no browser."""

import http.client
import json
import time
from contextlib import contextmanager

from websockets.sync.client import connect

from drill_twin_dashboard.front.server import FrontServer


class Front:
    """A server of a folder, and what a page of it asks for."""

    def __init__(self, folder):
        self.folder = folder
        self.server = FrontServer(folder, port=0)
        self.place = self.server.url.split("/")[2]
        code = self.server.links.new().partition("#code=")[2]
        status, headers, key = self.get("/enter", **{"X-Code": code})
        assert status == 200
        self.cookie, self.key = headers["Set-Cookie"].partition(";")[0], key.decode()

    def get(self, path, **headers):
        """Status, headers and content of a path."""
        connection = http.client.HTTPConnection(self.place, timeout=20.0)
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()

    def file(self, name, **headers):
        """Status, headers and content of a file of the folder, as the page opens it."""
        with self.client() as client:
            at = picture(client)["at"]
        return self.get(f"{at}{name}", **{"Cookie": self.cookie, **headers})

    @contextmanager
    def client(self, cookie=None, key=None):
        """A websocket, with the right to command unless another cookie or key is given."""
        headers = {"Cookie": self.cookie if cookie is None else cookie}
        with connect(f"ws://{self.place}/live", additional_headers=headers, max_size=None) as client:
            client.send(json.dumps({"key": self.key if key is None else key}))
            yield client

    def ask(self, **request):
        """Answer to a request: empty, or a sentence that refuses."""
        with self.client() as client:
            assert answer(client) == ""
            client.send(json.dumps(request))
            return answer(client)

    def commands(self):
        """The commands, the newest first."""
        with self.client() as client:
            return picture(client)["commands"]

    def ended(self, seconds=300.0):
        """The newest command, once it has ended."""
        return self.until(lambda: (found := self.commands()[0])["code"] is not None and found, seconds)

    def until(self, happened, seconds=300.0):
        end = time.monotonic() + seconds
        while not (found := happened()):
            assert time.monotonic() < end, self.commands()
            time.sleep(0.2)
        return found


def answer(client):
    while "error" not in (said := json.loads(client.recv(timeout=30.0))):
        pass
    return said["error"]


def picture(client):
    while "folder" not in (said := json.loads(client.recv(timeout=30.0))):
        pass
    return said
