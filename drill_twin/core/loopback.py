# SPDX-License-Identifier: Apache-2.0
"""Addresses that only this machine can use."""

import socket
from ipaddress import IPv4Address, IPv6Address, ip_address


def is_loopback(host: str) -> bool:
    """True for an address that only this machine can use, or a name that stands for nothing else.

    Args:
        host: IPv4 or IPv6 address, in brackets or not, or a name, which is looked up.
    """
    host = host.removeprefix("[").removesuffix("]")
    address = literal_address(host)
    if address is not None:
        if isinstance(address, IPv6Address) and address.ipv4_mapped:
            address = address.ipv4_mapped
        return address.is_loopback
    try:
        found = {str(entry[4][0]) for entry in socket.getaddrinfo(host, None)} if host else set()
    except (OSError, UnicodeError, ValueError):  # no such name, and therefore none of this machine
        return False
    return bool(found) and all(literal_address(one) is not None and is_loopback(one) for one in found)


def literal_address(text: str) -> IPv4Address | IPv6Address | None:
    """Address that a text is, a zone (`fe80::1%eth0`) left out; None for a name."""
    try:
        return ip_address(text.partition("%")[0])
    except ValueError:
        return None


def in_url(host: str) -> str:
    """Host as it stands in a URL: an IPv6 address in brackets."""
    return f"[{host}]" if ":" in host and not host.startswith("[") else host
