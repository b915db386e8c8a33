# SPDX-License-Identifier: Apache-2.0
"""Addresses and names that stand for this machine only."""

import socket

import pytest

from drill_twin.core.loopback import in_url, is_loopback


@pytest.mark.parametrize("host", ["127.0.0.1", "127.9.9.9", "::1", "[::1]", "::ffff:127.0.0.1", "localhost"])
def test_this_machine(host):
    assert is_loopback(host)


@pytest.mark.parametrize(
    "host",
    ["0.0.0.0", "::", "", "10.0.0.5", "fe80::1%eth0", "::ffff:10.0.0.5", "no.such.name.invalid", "x" * 300, "\0"],  # noqa: S104 - compared with, not bound
)
def test_another(host):
    assert not is_loopback(host)


def test_a_name_counts_by_all_its_addresses(monkeypatch):
    def found(*addresses):
        monkeypatch.setattr(socket, "getaddrinfo", lambda *_: [(2, 1, 6, "", (one, 0)) for one in addresses])

    found("127.0.0.1", "::1")
    assert is_loopback("rig-pc")
    found("127.0.0.1", "10.0.0.5")
    assert not is_loopback("rig-pc")
    found()
    assert not is_loopback("rig-pc")


def test_an_ipv6_address_is_in_brackets_in_a_url():
    assert [in_url(one) for one in ("::1", "[::1]", "127.0.0.1", "rig")] == ["[::1]", "[::1]", "127.0.0.1", "rig"]
