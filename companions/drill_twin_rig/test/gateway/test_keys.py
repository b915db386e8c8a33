# SPDX-License-Identifier: Apache-2.0
"""Folder of keys of the gateway: users, their passwords, and who may read them."""

import asyncio
import os
import shutil
import threading
import time
from pathlib import Path

import pytest
from ports import free_port
from variants import one_of

pytest.importorskip("asyncua", reason="needs asyncua: pip install 'drill_twin[opcua]'")

from asyncua import Client, ua
from asyncua.crypto.security_policies import SecurityPolicyBasic256Sha256

from drill_twin.cli import run_command
from drill_twin.core.errors import RunError
from drill_twin_rig.gateway.control import Control
from drill_twin_rig.gateway.opc_ua import keys as keys_module
from drill_twin_rig.gateway.opc_ua.keys import (
    CERTIFICATE,
    TRUSTED,
    Keys,
    KeysError,
    PasswordHash,
    make_keys,
    read_keys,
    read_users,
    set_password,
)
from drill_twin_rig.gateway.opc_ua.server import APPLICATION, OpcUaServer

LONG, OTHER = "one two three four", "another of four words"
SCRYPT = keys_module._scrypt


@pytest.fixture(scope="module", autouse=True)
def cheap():
    """Hashes of 16 rounds, which say that they have as many as a user's: one of those takes a third of a second."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(keys_module, "_scrypt", lambda password, salt, cost, *length: SCRYPT(
            password, salt, (4, *cost[1:]), *length
        ))  # fmt: skip
        yield


@pytest.fixture
def dear(monkeypatch):
    """Hashes as users have them."""
    monkeypatch.setattr(keys_module, "_scrypt", SCRYPT)


@pytest.fixture(scope="module")
def made(cheap, tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "keys"
    make_keys(folder, APPLICATION, "localhost", {"driller": LONG})
    return folder


@pytest.fixture
def folder(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "keys"))


def test_a_user_who_is_there_gets_another_password_and_the_others_keep_theirs(folder):
    assert make_keys(folder, APPLICATION, "localhost", {"guest": LONG}) == ["guest"]
    assert make_keys(folder, APPLICATION, "localhost", {"driller": OTHER}) == []
    keys = read_keys(folder)
    assert list(keys.users) == ["driller", "guest"]
    assert keys.is_user("driller", OTHER)
    assert not keys.is_user("driller", LONG)
    assert keys.is_user("guest", LONG)
    assert not keys.is_user("nobody", LONG)
    assert sorted(path.name for path in folder.iterdir()) == [
        "certificate.der", "private_key.pem", "trusted", "users.yaml",
    ]  # fmt: skip


def test_the_command_says_what_it_did_and_the_second_time_too(tmp_path, capsys):
    def run(password):
        return run_command(["ros", "keys", str(tmp_path / "keys"), "--user", "me", "--password", password])

    assert run(LONG) == 0
    assert "me is new" in capsys.readouterr().out
    assert run(OTHER) == 0
    assert "me is given another password" in capsys.readouterr().out
    assert read_keys(tmp_path / "keys").is_user("me", OTHER)
    assert run("x") == 2
    assert "password: expected 8 to 1000 characters, found 1" in capsys.readouterr().err


@pytest.mark.parametrize("password", ["", "x", "1234567", "x" * 1001])
def test_a_password_that_is_short_or_endless_is_refused_and_nothing_changes(folder, password):
    before = (folder / "users.yaml").read_bytes()
    with pytest.raises(KeysError, match=r"^password: expected 8 to 1000 characters, found "):
        make_keys(folder, APPLICATION, "localhost", {"driller": password})
    assert (folder / "users.yaml").read_bytes() == before


@pytest.mark.parametrize("name", ["", "x" * 61, "a\nb", "\x1b[2J"])
def test_a_name_that_is_none_is_refused(folder, name):
    with pytest.raises(KeysError, match=r"^user: expected 1 to 60 printable characters, found "):
        set_password(folder / "users.yaml", name, LONG)


@pytest.mark.parametrize("name", one_of(3, ['a"b', "a: b", "é & *x", "yes", "12", "- #", "{}"]))
def test_any_other_name_is_kept_as_it_is(folder, name):
    set_password(folder / "users.yaml", name, LONG)
    assert list(read_users(folder / "users.yaml")) == ["driller", name]


@pytest.mark.parametrize("name", ["users.yaml", "private_key.pem"])
def test_secrets_are_for_their_owner_and_the_gateway_refuses_others(folder, name):
    assert (folder / name).stat().st_mode & 0o777 == 0o600
    for mode in (0o644, 0o640, 0o602):
        (folder / name).chmod(mode)
        with pytest.raises(KeysError, match=rf"found mode {mode:o}; chmod 600 "):
            read_keys(folder)


def test_a_umask_does_not_open_the_secrets(tmp_path):
    before = os.umask(0)
    try:
        make_keys(tmp_path / "open", APPLICATION, "localhost", {"driller": LONG})
    finally:
        os.umask(before)
    assert (tmp_path / "open/users.yaml").stat().st_mode & 0o777 == 0o600
    assert (tmp_path / "open/private_key.pem").stat().st_mode & 0o777 == 0o600


def test_a_hash_costs_what_owasp_asks(dear):
    found = PasswordHash.of(LONG)
    assert found.cost == (17, 8, 1)
    assert found.is_of(LONG)
    assert not found.is_of(OTHER)


@pytest.mark.parametrize(
    "line",
    [
        'a: "0011aabb:00112233445566778899aabbccddeeff"',
        'a: "99-8-1:00:00"',
        "a: x",
        "a: 1",
        "- a",
        "a: null",
        "a: b: c",
        'a: "17-8-1:0011:zz"',
        "a",
        '"a": {}',
    ],
)
def test_a_file_that_holds_no_users_is_refused(folder, line):
    (folder / "users.yaml").write_text(f"{line}\n", "utf-8")
    with pytest.raises(Exception, match=r"users\.yaml") as error:
        read_keys(folder)
    assert type(error.value).__name__ in {"KeysError", "SceneError", "YamlError"}


def test_an_unknown_user_costs_as_much_as_a_known_one(folder, dear):
    keys = read_keys(folder)

    def work(name):
        begin = time.thread_time()
        keys.is_user(name, OTHER)
        return time.thread_time() - begin

    assert work("nobody") > 0.3 * work("driller")


def test_a_write_that_fails_leaves_the_users_of_before(folder, monkeypatch):
    before = (folder / "users.yaml").read_bytes()
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(KeysError, match="No space left"):
        make_keys(folder, APPLICATION, "localhost", {"driller": OTHER})
    assert (folder / "users.yaml").read_bytes() == before
    assert len(list(folder.iterdir())) == 4


async def _client(url, folder, password):
    client = Client(url, timeout=60.0)
    client.application_uri = APPLICATION
    client.set_user("driller")
    client.set_password(password)
    own = (str(folder / CERTIFICATE), str(folder / "private_key.pem"))
    await client.set_security(SecurityPolicyBasic256Sha256, *own, None, str(folder / CERTIFICATE))
    return client


def test_others_are_served_while_a_password_is_checked(folder, monkeypatch):
    """The check of one client is held up; another reads meanwhile, which it could not if the loop did the check."""
    (folder / TRUSTED / "client.der").write_bytes((folder / CERTIFICATE).read_bytes())
    begun, go_on, check = threading.Event(), threading.Event(), Keys.is_user

    def slow(keys, name, password):
        if password == OTHER:
            begun.set()
            assert go_on.wait(60.0)
        return check(keys, name, password)

    monkeypatch.setattr(Keys, "is_user", slow)
    server = OpcUaServer(("127.0.0.1", free_port()), [], [], Control([], 2.0, lambda: None, {}), read_keys(folder))

    async def both():
        async with await _client(server.url, folder, LONG) as good:
            bad = asyncio.create_task((await _client(server.url, folder, OTHER)).connect())
            assert await asyncio.to_thread(begun.wait, 60.0)
            space = (await good.get_namespace_array()).index(APPLICATION)
            assert await good.get_node(ua.NodeId("Permission", space)).read_value() == 0
            assert not bad.done()
            go_on.set()
            with pytest.raises(ua.uaerrors.BadUserAccessDenied):
                await bad

    try:
        asyncio.run(both())
        assert server.sessions.refused == {"user": 1}
    finally:
        server.close()


def test_a_machine_that_is_too_busy_is_not_called_a_taken_port(folder, monkeypatch):
    monkeypatch.setattr("drill_twin_rig.gateway.opc_ua.server.START", 1e-3)
    with pytest.raises(RunError, match=r"was not served within 0.001 s: the machine may be too busy"):
        OpcUaServer(("127.0.0.1", free_port()), [], [], Control([], 2.0, lambda: None, {}), read_keys(folder))
