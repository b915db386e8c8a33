# SPDX-License-Identifier: Apache-2.0
"""The server of the page under hostile clients: who may open it, and what many or slow ones cost."""

import http.client
import json
import socket
import threading
import time
from contextlib import ExitStack

import pytest
from served_page import UPGRADE, answer, ask, commanding
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from drill_twin.core.errors import DrillTwinError, RunError
from drill_twin_dashboard.live.server import KEPT, MOST_CLIENTS, PageServer
from drill_twin_dashboard.live.web_server import MOST_CONNECTIONS


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0", "127.0.0.2", "localhost"])  # noqa: S104
def test_a_name_that_points_here_is_refused_whatever_the_server_listens_on(host, serve):
    page = serve(host=host)
    at = "127.0.0.2" if host == "127.0.0.2" else "127.0.0.1"

    def status(name, path="/"):
        connection = http.client.HTTPConnection(at, page.server.port, timeout=10.0)
        connection.request("GET", path, headers={"Host": name})
        return connection.getresponse().status

    for good in ("localhost", "127.0.0.1", "10.1.2.3", "[::1]", "LOCALHOST.", socket.gethostname()):
        assert status(f"{good}:{page.server.port}") == 200, good
        assert status(good) == 200, good
    for bad in ("evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "evil.example:80@localhost"):
        assert status(bad) in {400, 403}, bad
        assert status(bad, "/live") in {400, 403}, bad
    for odd in ("", "[", "a:b", "x/../y", "\xe4", "a" * 5000):
        assert status(odd) in {400, 403}, odd


def test_the_page_at_the_ipv6_address_of_this_machine(serve):
    try:
        page = serve(host="::1")
    except RunError:
        pytest.skip("no IPv6 here")
    assert page.server.url.startswith("http://[::1]:")
    with commanding(page) as client:
        client.send('{"wob": 1}')
        assert answer(client) == ""
    assert page.requests == [{"wob": 1}]


def test_a_name_that_is_allowed(serve):
    page = serve(allowed_hosts=["rig.example"])
    assert page.raw("GET / HTTP/1.1", "Host: rig.example:8000") == 200
    assert page.raw("GET / HTTP/1.1", "Host: rig.example.org") == 403


def test_headers_given_twice_or_not_at_all_are_bad_requests(serve):
    page = serve()
    host = f"Host: {page.place}"
    assert page.raw("GET / HTTP/1.1", host, host) == 400
    assert page.raw("GET / HTTP/1.1") == 400
    assert page.raw("GET /live HTTP/1.1", host, f"Origin: http://{page.place}", "Origin: http://evil.example") == 400
    *upgrade, key = UPGRADE
    assert page.raw("GET /live HTTP/1.1", host, *upgrade, key) == 101
    assert page.raw("GET /live HTTP/1.1", host, "Origin: null", *upgrade, key) == 403
    assert page.raw("GET /live HTTP/1.1", host, "Origin: http://evil.example", *upgrade, key) == 403
    assert page.raw("GET /live HTTP/1.1", host, f"Origin: http://{page.place}", *upgrade, key) == 101
    assert page.raw("GET /live HTTP/1.1", host, *upgrade, key, key) == 400
    with pytest.raises(IndexError):  # closed without an answer
        page.raw("POST / HTTP/1.1", host, "Content-Length: 5")
    assert page.raw("GET / HTTP/1.1", host) == 200


def test_many_clients_share_two_threads_and_places_are_kept_for_those_that_may_command(serve):
    page = serve()
    before = threading.active_count()
    with ExitStack() as stack:
        readers = MOST_CLIENTS - KEPT
        clients = [socket.create_connection(("127.0.0.1", page.server.port), 10.0) for _ in range(readers)]
        for client in clients:
            stack.enter_context(client)
            client.sendall(page.upgrade())
            assert client.recv(12) == b"HTTP/1.1 101"
        assert threading.active_count() <= before + 1
        with pytest.raises(InvalidStatus, match="503"):
            connect(page.live)
        assert page.raw("GET / HTTP/1.1", f"Host: {page.place}") == 200
        for _ in range(KEPT):
            client = stack.enter_context(commanding(page))
            assert ask(client, {"wob": 50}) == ""
        _, cookie, _ = page.enter()
        with pytest.raises(InvalidStatus, match="503"):
            connect(page.live, additional_headers={"Cookie": cookie})
    assert page.requests == KEPT * [{"wob": 50}]
    end = time.monotonic() + 20.0
    while time.monotonic() < end:
        try:
            with connect(page.live) as client:
                assert "scene" in json.loads(client.recv(timeout=10.0))
            return
        except InvalidStatus:
            time.sleep(0.1)
    pytest.fail("no place became free")


def test_connections_that_ask_for_nothing_are_bounded_and_end(serve):
    page = serve()
    silent = [socket.create_connection(("127.0.0.1", page.server.port), 10.0) for _ in range(MOST_CONNECTIONS + 20)]
    end = time.monotonic() + 20.0
    while True:
        try:
            assert page.raw("GET / HTTP/1.1", f"Host: {page.place}") == 200
            break
        except (ConnectionError, IndexError):
            assert time.monotonic() < end
            time.sleep(0.2)
    assert len(page.server.connections) <= MOST_CONNECTIONS
    for client in silent:
        client.close()


def test_a_client_that_does_not_read_is_dropped_and_others_go_on(serve):
    page = serve()
    with connect(page.live) as good, socket.socket() as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.connect(("127.0.0.1", page.server.port))
        slow.sendall(page.upgrade())
        end = time.monotonic() + 60.0
        while len(page.server.connections) < 2:
            assert time.monotonic() < end
        while len(page.server.connections) > 1:
            assert "scene" in json.loads(good.recv(timeout=10.0))
            assert time.monotonic() < end


def test_the_end_does_not_wait_for_clients_that_do_not_read(serve):
    page = serve()
    with ExitStack() as stack:
        for _ in range(5):
            client = stack.enter_context(socket.create_connection(("127.0.0.1", page.server.port), 10.0))
            client.sendall(page.upgrade())
            client.recv(12)
        page.server.close()
        assert not page.server._thread.is_alive()


def test_requests_that_are_no_commands(serve):
    page = serve()
    with commanding(page) as client:
        for rubbish in (
            "[", "1" * 4000, '{"seek": ' + "1" * 4000 + "}", '{"seek": 1e999}', '{"seek": NaN}', "[" * 4000, b"\xff",
            '{"seek": "1"}', "null", '{"a": {"b": 1}}', '{"seek": -' + "9" * 310 + "}",
        ):  # fmt: skip
            client.send(rubbish)
            said = answer(client)
            assert said.startswith("expected "), rubbish
            assert len(said) < 200
        client.send('{"seek": 1}')
        assert answer(client) == ""
    assert page.requests == [{"seek": 1}]


def test_an_error_of_a_request_is_told(serve):
    def refuse(request):
        raise DrillTwinError(f"expected another, found {request}")

    page = serve()
    page.server._on_request = refuse  # noqa: SLF001
    with commanding(page) as client:
        client.send('{"wob": 1}')
        assert answer(client).startswith("expected another")


@pytest.mark.parametrize("host", ["203.0.113.7", "no such name", "\0", "x" * 1000, "256.1.1.1"])
def test_an_address_that_is_none_of_this_machine(host):
    with pytest.raises(RunError, match=r"^expected a free port for the page, found "):
        PageServer(dict, print, host=host, port=0)
