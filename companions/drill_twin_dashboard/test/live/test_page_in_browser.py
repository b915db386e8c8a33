# SPDX-License-Identifier: Apache-2.0
"""The right to command in a real browser: nothing that it is started with, shows or keeps gives it to anybody else."""

import re
from pathlib import Path

import pytest
from browser import until

from drill_twin_dashboard.live import access
from drill_twin_dashboard.live.page_state import PageState

TROUBLE = "trouble"
REFUSED = "expected a page that may command"


def live():
    """A picture of a twin that runs."""
    return {**PageState().snapshot(), "refused": ""}


@pytest.fixture
def opened(browse, serve, tmp_path, monkeypatch):
    """A page, its browser, which the file for the browser of this machine led there, and the code in that file."""
    found = []
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(access.webbrowser, "open", lambda url: found.append(url) or True)
    page = serve(live)
    page.server.links.open_browser()
    code = re.search(r"#code=([\w-]+)", Path(found[0].removeprefix("file://")).read_text("utf-8"))[1]
    return page, browse(found[0], at=page.server.url), code


def commands(page, browser, value):
    """True if the page in a browser may command; the sentence that it shows if not."""
    before = len(page.requests)
    browser.value(f"document.getElementById('{TROUBLE}').textContent = ''")
    browser.value(f"import('/connection.js').then((page) => page.say({{ wob: {value} }}))")
    until(lambda: len(page.requests) > before or browser.text(TROUBLE), "an answer")
    return page.requests[before:] == [{"wob": value}] or browser.text(TROUBLE)


def words_of_processes():
    """What every user of this machine can read."""
    for words in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            yield words.read_bytes()
        except OSError:
            continue  # it has ended


def test_a_browser_keeps_nothing_that_lets_another_command(opened, browse, tmp_path):
    page, browser, code = opened
    assert any(str(tmp_path).encode() in words for words in words_of_processes())
    assert not any(code.encode() in words for words in words_of_processes())
    assert commands(page, browser, 1) is True
    assert browser.value("location.href") == page.server.url
    assert browser.value("document.referrer + document.cookie + JSON.stringify(history.state)") == "null"
    key, cookie = page.server._access.key, page.server._access._cookie  # noqa: SLF001
    assert browser.value("localStorage.getItem('drill_twin_key')") == key
    browser.reload()
    assert commands(page, browser, 2) is True
    browser.tab(page.server.url)
    assert commands(page, browser, 3) is True
    browser.end()

    kept = {file: file.read_bytes() for file in (tmp_path / "browser").rglob("*") if file.is_file()}
    texts = [*kept.values(), *(text.decode("utf-16-le", "ignore").encode("utf-8", "ignore") for text in kept.values())]
    assert any(page.place.encode() in text for text in texts)
    codes = {found for text in texts for found in re.findall(rb"code=([\w-]{32})", text)}
    for found in codes | {code.encode()}:
        assert page.enter(found.decode())[0] == 403
    assert [file for file, text in kept.items() if cookie.encode() in text] == []
    assert all("Local Storage" in str(file) for file, text in kept.items() if key.encode() in text)

    again = browse(page.server.url)  # the same user, after the end of the browser: its cookie is gone
    assert commands(page, again, 4).startswith(REFUSED)


def test_another_watch_on_the_same_port_refuses_with_a_sentence_and_a_link_of_it_cures_all_tabs(opened, serve):
    page, browser, _ = opened
    assert commands(page, browser, 1) is True
    port = page.server.port
    page.server.close()
    second = serve(live, port=port)
    until(lambda: browser.text(TROUBLE).startswith(REFUSED), "the sentence, without a command")
    assert "of an earlier drill-twin watch; open the link" in browser.text(TROUBLE)
    first_tab = browser._socket  # noqa: SLF001
    browser.tab(second.server.links.new())
    assert commands(second, browser, 2) is True
    browser._socket = first_tab  # noqa: SLF001
    browser.reload()
    assert commands(second, browser, 3) is True


def test_a_spent_link_tells_what_to_do_and_shows_the_twin(opened, browse, capsys):
    page, browser, code = opened
    other = browse(f"{page.server.url}#code={code}", profile="another")
    assert other.text(TROUBLE) == access.TOO_LATE
    assert "a page that may command at " in until(lambda: capsys.readouterr().out, "another link")
    assert commands(page, other, 1).startswith(REFUSED)
    # A link of a browser that may command already is opened again, as from the history of a terminal.
    browser.tab(f"{page.server.url}#code={code}")
    assert commands(page, browser, 2) is True


def test_two_twins_of_a_host_in_one_browser(opened, serve):
    page, browser, _ = opened
    first = browser._socket  # noqa: SLF001
    other = serve(live)
    browser.tab(other.server.links.new())
    assert commands(other, browser, 1) is True
    browser._socket = first  # noqa: SLF001
    browser.reload()
    assert commands(page, browser, 2) is True
    assert (page.requests, other.requests) == ([{"wob": 2}], [{"wob": 1}])
