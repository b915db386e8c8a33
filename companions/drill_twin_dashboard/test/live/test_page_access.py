# SPDX-License-Identifier: Apache-2.0
"""Who may command by the page: links whose code is spent once and soon, a cookie and a key, each of no use alone."""

import os
import re
import socket
import stat
import threading
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from served_page import ask, commanding, forwarder, raw_websocket
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from drill_twin_dashboard.live import access
from drill_twin_dashboard.live.web_server import MOST_CONNECTIONS

REFUSED = "expected a page that may command, found a page that reads only"


def test_a_code_lets_one_in_and_once(serve):
    page = serve()
    code = page.server.links.new().partition("#code=")[2]
    for guess in ("", code[:-1], code + "x", "\xe4", "x" * 5000, code.swapcase()):
        assert page.enter(guess)[0] == 403, guess
    status, cookie, key = page.enter(code)
    assert status == 200
    assert len({code, cookie.partition("=")[2], key}) == 3
    assert len(key) >= 32
    assert page.enter(code) == (403, "", access.TOO_LATE)


def test_a_code_of_many_requests_at_once_lets_one_in(serve):
    page = serve()
    code = page.server.links.new().partition("#code=")[2]
    begin, found = threading.Barrier(16), []

    def ask_for_it():
        begin.wait()
        found.append(page.enter(code)[0])

    askers = [threading.Thread(target=ask_for_it) for _ in range(16)]
    for one in askers:
        one.start()
    for one in askers:
        one.join()
    assert sorted(found) == [200] + 15 * [403]


def test_an_old_code_lets_nobody_in_and_another_link_is_printed(serve, monkeypatch, capsys):
    page = serve()
    with monkeypatch.context() as context:
        context.setattr(access, "CODE_LIFE", 0.0)
        page.server.links.show("a twin")
    first = re.fullmatch(r"a twin at (\S+)#code=(\S+) \(for one browser, within 5 minutes\)\n", capsys.readouterr().out)
    assert first[1] == page.server.url
    assert page.enter(first[2])[0] == 403
    end, said = time.monotonic() + 20.0, ""
    while "\n" not in said:
        assert time.monotonic() < end
        said += capsys.readouterr().out
    code = re.fullmatch(rf"a page that may command at {page.server.url}#code=(\S+) \(.*\)\n", said)[1]
    assert page.enter("guess")[0] == 403
    assert ask_to_command(page).startswith(REFUSED)
    assert capsys.readouterr().out == ""  # that link is good still
    assert page.enter(code)[0] == 200


def ask_to_command(page):
    with connect(page.live) as client:
        return ask(client, {"wob": 50})


def test_cookie_and_key_are_of_no_use_alone(serve):
    page, other = serve(), serve()
    _, cookie, key = page.enter()
    _, others_cookie, others_key = other.enter()
    name, _, value = cookie.partition("=")
    with commanding(page):
        pass
    for given, said in (
        ("", key), (cookie, ""), (cookie, others_key), (others_cookie, key), (cookie, value), (f"{name}={key}", key),
        (f"drill_twin_={value}", key), (f"drill_twin_1={value}", key),
        (f"{others_cookie.partition('=')[0]}={value}", key), (f"x={cookie}", key),
        (f"{cookie}x", key), ("=;;=; ;", key),
    ):  # fmt: skip
        with connect(page.live, additional_headers={"Cookie": given}) as client:
            assert ask(client, {"wob": 50}).startswith(REFUSED), given
            assert ask(client, {"key": said}).startswith(REFUSED), given
            assert ask(client, {"wob": 50}).startswith(REFUSED), given
    for given in (f"a=b; {cookie}; {others_cookie}", f"{name}=stale; {cookie}", f"a=b;{cookie}"):
        with connect(page.live, additional_headers={"Cookie": given}) as client:
            assert ask(client, {"key": key}) == "", given
            assert ask(client, {"wob": 60}) == ""
            assert ask(client, {"key": "guess"}).startswith(REFUSED)  # a wrong one takes the right away
            assert ask(client, {"wob": 70}).startswith(REFUSED)
    for query in (f"?key={key}", f"?code={page.server.links.new().partition('=')[2]}"):
        with connect(page.live + query, additional_headers={"Cookie": cookie}) as client:
            assert ask(client, {"wob": 50}).startswith(REFUSED)
    assert page.requests == 3 * [{"wob": 60}]
    assert not other.requests


def test_two_servers_of_a_host_keep_their_cookies_apart(serve):
    """A jar of cookies knows hosts and names, and no ports."""
    one, two = serve(), serve()
    rights = [page.enter()[1:] for page in (one, two)]
    jar = dict(cookie.split("=") for cookie, _ in rights)
    sent = "; ".join(map("=".join, jar.items()))
    for page, (_, key) in zip((one, two), rights, strict=True):
        with connect(page.live, additional_headers={"Cookie": sent}) as client:
            assert ask(client, {"key": key}) == ""
            assert ask(client, {"wob": 50}) == ""
        assert page.requests == [{"wob": 50}]


def test_what_a_browser_is_told_with_the_cookie(serve):
    page = serve()
    code = page.server.links.new().partition("#code=")[2]
    host = f"Host: {page.place}"
    said = exchange(page, "GET /enter HTTP/1.1", host, f"X-Code: {code}")
    cookie = re.search(r"Set-Cookie: drill_twin_(\d+)=([\w-]{32}); Path=/live; HttpOnly; SameSite=Strict\r\n", said)
    assert int(cookie[1]) == page.server.port
    assert "Cache-Control: no-store" in said
    for path in ("/", "/main.js", "/history.json"):
        told = exchange(page, f"GET {path} HTTP/1.1", host, f"Cookie: {cookie[0].partition(': ')[2].partition(';')[0]}")
        assert "no-referrer" in told
        for secret in (code, cookie[2], said.rpartition("\r\n\r\n")[2]):
            assert secret not in told
    code = page.server.links.new().partition("#code=")[2]
    for foreign in ("null", "http://evil.example", f"http://127.0.0.1:{page.server.port + 1}", "http://localhost"):
        assert exchange(page, "GET /enter HTTP/1.1", host, f"X-Code: {code}", f"Origin: {foreign}").startswith(
            "HTTP/1.1 403"
        )
    assert page.enter(code)[0] == 200  # the refused requests have not spent the code
    assert exchange(page, "GET /enter HTTP/1.1", host, "X-Code: a", "X-Code: b").startswith("HTTP/1.1 403")
    assert exchange(page, "GET /enter HTTP/1.1", "Host: evil.example", f"X-Code: {code}").startswith("HTTP/1.1 403")


def exchange(page, *lines):
    """Whole answer to a request given line by line."""
    sent = []
    with socket.create_connection(("127.0.0.1", page.server.port), 10.0) as client:
        client.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while more := client.recv(65536):
            sent.append(more)
    return b"".join(sent).decode("utf-8", "replace")


def test_a_page_of_another_origin_cannot_use_the_cookie(serve):
    """A browser sends the cookie with it if the other page has the same host: SameSite knows no ports either."""
    page = serve()
    _, cookie, _ = page.enter()
    for origin in (f"http://127.0.0.1:{page.server.port + 1}", "http://evil.example", "null"):
        with pytest.raises(InvalidStatus, match="403"):
            connect(page.live, additional_headers={"Cookie": cookie}, origin=origin)
    with connect(page.live, additional_headers={"Cookie": cookie}, origin=page.server.url.rstrip("/")):
        pass


def test_commands_through_a_proxy_need_a_right_of_its_address(serve):
    page = serve(allowed_hosts=["rig.example"])
    requests = ({"wob": 50}, {"reset": True}, {"key": "guess"}, {"wob": 17.0}, {"key": ""}, {"key": [1]}, {"wob": 33})
    with forwarder(page.server.port) as port:
        ways = (
            (page.server.port, {}),
            (port, {}),
            (port, {"X-Forwarded-For": "127.0.0.1", "Forwarded": "for=127.0.0.1"}),
            (port, {"Host": "rig.example", "Origin": "https://rig.example"}),
            (port, {"Host": "rig.example:8443", "Origin": "https://rig.example:8443"}),
        )
        for place, headers in ways:
            named = {"Host": f"127.0.0.1:{place}", **headers}
            with raw_websocket(place, named) as client:
                for said in requests:
                    assert ask(client, said).startswith("expected "), said
        assert not page.requests
        for place, headers in ways:
            named = {"Host": f"127.0.0.1:{place}", **headers}
            _, cookie, key = page.enter(**named)
            assert cookie.startswith(f"drill_twin_{urlsplit('//' + named['Host']).port or ''}=")
            with raw_websocket(place, {**named, "Cookie": cookie}) as client:
                assert ask(client, {"key": key}) == ""
                assert ask(client, {"wob": place}) == ""
    assert page.requests == [{"wob": place} for place, _ in ways]


def test_a_link_for_other_machines_where_they_can_connect(serve, capsys):
    serve().server.links.show("here")
    assert "other machines" not in capsys.readouterr().out
    page = serve(host="0.0.0.0")  # noqa: S104
    page.server.links.show("here")
    here, there = capsys.readouterr().out.splitlines()
    assert re.fullmatch(rf"here at {page.server.url}#code=\S+ \(.*\)", here)
    other = re.fullmatch(rf"on other machines: http://{socket.gethostname()}:{page.server.port}/#code=(\S+)", there)
    assert page.enter(other[1])[0] == 200


def test_slow_and_silent_connections_lock_nobody_out(serve):
    page = serve()
    slow = []
    for number in range(2 * MOST_CONNECTIONS):
        client = socket.create_connection(("127.0.0.1", page.server.port), 10.0)
        if number % 2:  # half of them ask for a large file, and do not read
            client.sendall(f"GET /plotly.js HTTP/1.1\r\nHost: {page.place}\r\n\r\n".encode())
        slow.append(client)
    with commanding(page) as operator:  # at once, while all of them wait
        assert ask(operator, {"wob": 50}) == ""
        assert len(page.server.connections) <= MOST_CONNECTIONS
        slow += [socket.create_connection(("127.0.0.1", page.server.port), 10.0) for _ in range(2 * MOST_CONNECTIONS)]
        assert page.raw("GET / HTTP/1.1", f"Host: {page.place}") == 200
        assert ask(operator, {"wob": 60}) == ""  # a client with a place keeps it
    assert page.requests == [{"wob": 50}, {"wob": 60}]
    for client in slow:
        client.close()


def test_the_browser_of_this_machine_gets_a_file_that_only_its_user_reads(serve, tmp_path, monkeypatch):
    """What is on the command line of a browser is for every user of the machine to read."""
    monkeypatch.setenv("HOME", str(tmp_path))
    told = tmp_path / "words"
    script = tmp_path / "browser"
    script.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > {told}.new && mv {told}.new {told}\n', "utf-8")
    script.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{script} %s")
    monkeypatch.setattr(access.webbrowser, "_tryorder", None)
    old = os.umask(0)
    try:
        page = serve()
        page.server.links.open_browser()
    finally:
        os.umask(old)
    (words,) = told.read_text("utf-8").split()
    file = Path(words.removeprefix("file://"))
    assert file.parent == tmp_path  # not hidden: a browser in a snap reads it
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    code = re.search(rf'url={page.server.url}#code=([\w-]+)"', file.read_text("utf-8"))[1]
    assert code not in words
    assert page.enter(code)[0] == 200
    end = time.monotonic() + 20.0
    while file.exists():  # it is deleted once it is of no use
        assert time.monotonic() < end
        time.sleep(0.02)
    page.server.links.open_browser()
    page.server.close()
    assert not list(tmp_path.glob("*.html"))


@pytest.mark.parametrize("home", ["/nonexistent", "/proc"])
def test_without_a_home_the_file_lies_in_the_temporary_folder(serve, home, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", home)
    monkeypatch.setattr(access.tempfile, "tempdir", str(tmp_path))
    found = []
    monkeypatch.setattr(access.webbrowser, "open", lambda url: found.append(url) or "as if it were open")
    page = serve()
    page.server.links.open_browser()
    assert [str(file.as_uri()) for file in tmp_path.glob("*.html")] == found
    monkeypatch.setattr(access.webbrowser, "open", lambda _: False)
    other = serve()
    other.server.links.open_browser()
    assert len(list(tmp_path.glob("*.html"))) == 1  # no browser, no file
