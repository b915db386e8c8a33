# SPDX-License-Identifier: Apache-2.0
"""Who may use the front door, and what its requests and addresses cannot reach."""

import json
import os

import pytest
from served_front import answer, picture
from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.sync.client import connect

from drill_twin_dashboard.front.forms import LEFT_OUT
from drill_twin_dashboard.live import access

REFUSED = "expected a page that may command"


def ran(front):
    return [one["line"] for one in front.commands()]


def silent(client):
    """True if a client is told nothing of the folder within three snapshots."""
    try:
        while True:
            if "folder" in json.loads(client.recv(timeout=1.5)):
                return False
    except TimeoutError:
        return True


def test_without_the_cookie_nothing_is_told_and_a_new_link_is_printed(front, capsys):
    for given in ({}, {"Cookie": "drill_twin_1=x"}):
        with pytest.raises(InvalidStatus, match="403"):
            connect(f"ws://{front.place}/live", additional_headers=given)
    front.until(lambda: "a page that may command at http://" in capsys.readouterr().out, 20.0)
    for path in ("/", "/front.js", "/front.css", "/forms.js", "/connection.js", "/state.js"):  # nothing of the folder
        status, _, content = front.get(path)
        assert status == 200
        assert str(front.folder).encode() not in content


def test_cookie_and_key_are_both_needed_to_see_and_to_command(front):
    for key in ("", "guess", front.cookie.partition("=")[2]):
        with front.client(key=key) as client:
            assert answer(client).startswith(REFUSED)
            client.send(json.dumps({"do": "run", "on": ["pa6_bench"]}))
            assert answer(client).startswith(REFUSED)
            assert silent(client)
    with front.client() as client:
        assert answer(client) == ""
        assert picture(client)["commands"] == []
        client.send(json.dumps({"key": "guess"}))  # a wrong key takes the right away
        assert answer(client).startswith(REFUSED)
    assert ran(front) == []


def test_another_origin_or_name_is_refused(front):
    for headers in ({"Origin": "http://evil.example"}, {"Origin": "null"}):
        with pytest.raises(InvalidStatus, match="403"):
            connect(f"ws://{front.place}/live", additional_headers={"Cookie": front.cookie, **headers})
        (front.folder / "report.html").write_text("x", "utf-8")
        assert front.file("report.html", **headers)[0] == 403
    assert front.file("report.html", Host="evil.example")[0] == 403
    assert front.file("report.html")[0] == 200


def test_a_file_needs_the_cookie_and_the_address_that_the_page_was_told(front):
    (front.folder / "report.html").write_text("<p>mine", "utf-8")
    assert front.file("report.html")[2] == b"<p>mine"
    assert front.file("report.html", Cookie="")[0] == 403
    assert front.file("report.html", Cookie=f"{front.cookie}x")[0] == 403
    for mark in ("", "x", access._secret(), "%2e%2e"):  # noqa: SLF001
        assert front.get(f"/live/files/{mark}/report.html", Cookie=front.cookie)[0] == 403
    assert front.get("/live/files/", Cookie=front.cookie)[0] == 403
    assert front.get("/report.html", Cookie=front.cookie)[0] == 404


def test_nothing_outside_of_the_folder_and_no_other_kind_of_file_is_opened(front, tmp_path):
    secret = tmp_path / "secret.json"
    secret.write_text("secret", "utf-8")
    (front.folder / "out").mkdir()
    (front.folder / "out" / "link.json").symlink_to(secret)
    (front.folder / "above").symlink_to(tmp_path, target_is_directory=True)
    (front.folder / "circle.json").symlink_to(front.folder / "circle.json")
    (front.folder / "key.pem").write_text("secret", "utf-8")
    (front.folder / "folder.json").mkdir()
    os.mkfifo(front.folder / "pipe.json")
    (front.folder / "out" / "inside.json").symlink_to(front.folder / "good.json")
    (front.folder / "good.json").write_text("good", "utf-8")
    for name in (
        "../secret.json", "%2e%2e/secret.json", "..%2fsecret.json", "out/../../secret.json", "/etc/passwd",
        f"{secret}", f"%2f{secret}", "out/link.json", "above/secret.json", "circle.json", "key.pem", "folder.json",
        "pipe.json", "x" * 5000 + ".json", "a%00.json", "", "%ff.json", "none.json",
    ):  # fmt: skip
        status, _, content = front.file(name)
        assert (status, b"secret" in content) == (404, False), name
    assert front.file("good.json")[2] == front.file("out/inside.json")[2] == b"good"


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ({"do": "run"}, "expected one of scene new, "),
        ({"do": "rm", "on": ["x"]}, "expected one of scene new, "),
        ({"do": "run", "on": ["../other.yaml"]}, "expected a file or folder in "),
        ({"do": "run", "on": ["/etc/passwd"]}, "expected a file or folder in "),
        ({"do": "run", "on": ["--help"]}, "expected a file or folder in "),
        ({"do": "run", "on": ["a\0b"]}, "expected a file or folder in "),
        ({"do": "compare", "on": ["pa6_bench", "../x,wob=3"]}, "expected a file or folder in "),
        ({"do": "run", "on": ["pa6_bench"], "options": {"--out": "../x"}}, "expected a file or folder in "),
        ({"do": "run", "on": ["pa6_bench"], "options": {"--wob": "1\0"}}, "expected to start drill-twin run, found: "),
        ({"do": "statics", "on": ["pa6_bench"], "options": {"--measured": "/etc/passwd"}}, "expected a file or folder"),
        ({"do": "scene new", "on": ["x"], "options": {"--survey": "/etc/passwd"}}, "expected a file or folder in "),
        ({"do": "run", "on": ["pa6_bench"], "options": {"--cheat": "1"}}, "expected an option of --wob, "),
        ({"do": "run", "on": ["pa6_bench"], "options": {"--wob": 5}}, "expected a request of the page"),
        ({"do": 5}, "expected a request of the page"),
        ({"stop": "all"}, "expected a request of the page"),
    ],
)
def test_what_the_page_does_not_offer_is_refused_and_runs_nothing(front, request_, said):
    assert front.ask(**request_).startswith(said)
    assert ran(front) == []


@pytest.mark.parametrize("option", LEFT_OUT.split())
def test_options_that_the_page_leaves_out_are_refused(front, option):
    for do, on in (("run", "pa6_bench"), ("map", "pa6_bench"), ("watch", "live")):
        assert front.ask(do=do, on=[on], options={option: "1"}).startswith("expected an option of ")
    assert ran(front) == []


@pytest.mark.process
def test_a_value_is_no_option_and_no_word_of_a_shell(front):
    values = {"--wob": "--replace; touch made", "--set": "$(touch made)\n--json"}
    assert front.ask(do="run", on=["pa6_bench"], options=values) == ""
    ended = front.ended()
    assert ended["code"] == 2
    options = "'--wob=--replace; touch made' '--set=$(touch made)' --set=--json --out=out/run_pa6_bench"
    assert ended["line"] == f"drill-twin run pa6_bench {options}"
    assert "Traceback" not in ended["text"]
    assert not list(front.folder.rglob("made"))


@pytest.mark.process
def test_a_module_in_the_folder_is_not_imported_by_the_commands(front):
    (front.folder / "json.py").write_text("open('imported', 'w')\n", "utf-8")
    assert front.ask(do="run", on=["nothing"]) == ""
    assert "no such scene file" in front.ended()["text"]
    assert not (front.folder / "imported").exists()


def test_a_name_of_a_well_stays_in_the_folder_and_a_large_request_ends_its_client_alone(front):
    front.server._jobs.add = lambda words, out: asked.append((words, out))  # noqa: SLF001
    asked = []
    for name in ("../../evil", "a/b/c.yaml", "<img src=x>", ".hidden", "  "):
        tables = {"--survey": "x", "--../../tally": "y"}
        assert front.ask(do="scene new", on=[name], tables=tables).startswith("expected an option of --survey, ")
    assert front.ask(do="scene new", on=["../../evil"], tables={"--survey": "x"}) == ""
    assert asked == [(["scene", "new", "evil.yaml", "--survey=evil_survey.csv"], "evil.yaml")]
    assert {file.parent for file in front.folder.parent.rglob("*.csv")} == {front.folder}
    with front.client() as client:
        client.send(json.dumps({"do": "scene new", "tables": {"--survey": "x" * 1_000_000}}))
        with pytest.raises(ConnectionClosedError, match="1009"):
            list(client)
    assert front.commands() == []
