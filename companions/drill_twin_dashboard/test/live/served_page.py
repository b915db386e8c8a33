# SPDX-License-Identifier: Apache-2.0
"""A server of the page that keeps what is asked of it, and clients without a browser."""

import http.client
import json
import socket
import threading
from contextlib import contextmanager, suppress

from websockets.sync.client import connect

from drill_twin_dashboard.live.server import PageServer

PICTURE = {"scene": None, "text": "x" * 20_000}
UPGRADE = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
)


class Served:
    """A server and the requests that reached it."""

    def __init__(self, snapshot=lambda: PICTURE, port=0, **options):
        self.requests = []
        self.server = PageServer(snapshot, self.requests.append, port=port, **options)
        self.place = self.server.url.split("/")[2]
        self.live = f"ws://{self.place}/live"

    def enter(self, code=None, **headers):
        """Status, cookie and text of the exchange of a code, by default of a new one."""
        connection = http.client.HTTPConnection(self.place, timeout=10.0)
        code = self.server.links.new().partition("#code=")[2] if code is None else code
        connection.request("GET", "/enter", headers={"X-Code": code, **headers})
        answer = connection.getresponse()
        return answer.status, (answer.headers["Set-Cookie"] or "").partition(";")[0], answer.read().decode()

    def raw(self, *lines):
        """Status of a request given line by line."""
        with socket.create_connection(("127.0.0.1", self.server.port), 10.0) as client:
            client.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
            return int(client.makefile("rb").readline().split()[1])

    def upgrade(self):
        """A request for the websocket, by a client that may then read nothing."""
        lines = ("GET /live HTTP/1.1", f"Host: {self.place}", *UPGRADE, "", "")
        return "\r\n".join(lines).encode()


@contextmanager
def commanding(page):
    """A client of the websocket that may command."""
    _, cookie, key = page.enter()
    with connect(page.live, additional_headers={"Cookie": cookie}) as client:
        assert ask(client, {"key": key}) == ""
        yield client


def answer(client):
    """The first answer to a request, among the pictures."""
    while "error" not in (said := json.loads(client.recv(timeout=10.0))):
        pass
    return said["error"]


@contextmanager
def forwarder(to):
    """A proxy on this machine, such as one for TLS: passes bytes on from another port, which it yields."""

    def serve_one(client):
        with client, socket.create_connection(("127.0.0.1", to), 10.0) as server:
            back = threading.Thread(target=pump, args=(server, client), daemon=True)
            back.start()
            pump(client, server)
            back.join()

    def pump(source, sink):
        with suppress(OSError):
            while more := source.recv(65536):
                sink.sendall(more)
            sink.shutdown(socket.SHUT_WR)

    def accept():
        with suppress(OSError):
            while True:
                threading.Thread(target=serve_one, args=(listener.accept()[0],), daemon=True).start()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        threading.Thread(target=accept, daemon=True).start()
        yield listener.getsockname()[1]
        listener.shutdown(socket.SHUT_RDWR)


def raw_websocket(port, headers):
    """A websocket whose headers are these."""
    given = {name: value for name, value in headers.items() if name != "Host"}
    return connect(
        f"ws://{headers['Host']}/live", additional_headers=given, sock=socket.create_connection(("127.0.0.1", port))
    )


def ask(client, request):
    client.send(json.dumps(request))
    return answer(client)
