# SPDX-License-Identifier: Apache-2.0
"""Folder of keys of the gateway: its certificate and private key, trusted certificates of clients, and users.

`certificate.der`, `private_key.pem`, `trusted/*.der` (or `.pem`), and `users.yaml` with a line a user (`passwords`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from asyncua.crypto.cert_gen import (
    dump_private_key_as_pem,
    generate_private_key,
    generate_self_signed_app_certificate,
)
from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.x509.oid import ExtendedKeyUsageOID

from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.whole_file import PRIVATE, write_whole
from drill_twin.gateway.opc_ua.passwords import (
    KeysError,
    PasswordHash,
    check_private,
    fitting,
    read_users,
    set_password,
)

CERTIFICATE, PRIVATE_KEY, TRUSTED, USERS = "certificate.der", "private_key.pem", "trusted", "users.yaml"
_DAYS = 3650
_FILE = ForeignFile("a certificate (DER or PEM)", 100_000, KeysError)


@dataclass(frozen=True)
class Keys:
    """Keys of a gateway."""

    folder: Path
    """Folder that they are read from."""
    certificate: bytes
    """Certificate of this application, DER."""
    trusted: frozenset[bytes]
    """Certificates of others, DER."""
    users: Mapping[str, PasswordHash]
    """Hash of the password of each user."""

    @property
    def private_key(self) -> Path:
        """File of the private key."""
        return self.folder / PRIVATE_KEY

    def distrust(self, certificate: bytes) -> str:
        """Reason why a certificate is not trusted; empty if it is."""
        if certificate not in self.trusted:
            return f"its certificate is not in {self.folder / TRUSTED}"
        known, now = x509.load_der_x509_certificate(certificate), datetime.now(UTC)
        if not known.not_valid_before_utc <= now <= known.not_valid_after_utc:
            return f"its certificate is valid from {known.not_valid_before_utc} to {known.not_valid_after_utc} only"
        return ""

    def is_user(self, name: str, password: str) -> bool:
        """Return True for a known user with this password; takes tenths of a second, for an unknown one too."""
        return fitting(self.users, name).is_of(password)


def read_keys(folder: Path) -> Keys:
    """Keys of a folder.

    Raises:
        KeysError: A file is missing or no certificate, or others than its owner can read a secret.
    """
    remedy = "make one with drill-twin gateway-keys"
    for name in (CERTIFICATE, PRIVATE_KEY, USERS):
        if not (folder / name).is_file():
            raise KeysError(f"{folder}: expected a folder of keys with {name}, found none; {remedy}")
    check_private(folder / PRIVATE_KEY)
    users = read_users(folder / USERS)
    trusted = frozenset(_certificate(path) for path in sorted((folder / TRUSTED).glob("*.[dp]e[rm]")))
    return Keys(folder, _certificate(folder / CERTIFICATE), trusted, users)


def _certificate(path: Path) -> bytes:
    data = _FILE.read(path)
    try:
        load = x509.load_pem_x509_certificate if data.startswith(b"-----") else x509.load_der_x509_certificate
        return load(data).public_bytes(serialization.Encoding.DER)
    except ValueError as error:
        raise KeysError(f"{path}: expected a certificate (DER or PEM), found {error}") from error


def make_keys(folder: Path, application: str, host: str, users: Mapping[str, str]) -> list[str]:
    """Write a folder of keys with a self-signed certificate, or add users to one; returns those who are new.

    Args:
        folder: The folder; its secrets are readable by its owner only.
        application: URI of the application.
        host: Name or address of the machine.
        users: Passwords by name; a user who is there gets this one.

    Raises:
        KeysError: It cannot be written, or a name or password is of no use.
    """
    try:
        (folder / TRUSTED).mkdir(parents=True, exist_ok=True)
        if not (folder / CERTIFICATE).exists():
            _make_certificate(folder, application, host)
        return [name for name, password in users.items() if set_password(folder / USERS, name, password)]
    except OSError as error:
        raise KeysError(f"{folder}: expected a folder that can be written, found {error.strerror}") from error


def _make_certificate(folder: Path, application: str, host: str) -> None:
    key = generate_private_key()
    names = [x509.UniformResourceIdentifier(application), x509.DNSName(host)]
    purposes = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
    certificate = generate_self_signed_app_certificate(key, application, {}, names, purposes, _DAYS)
    write_whole(folder / PRIVATE_KEY, dump_private_key_as_pem(key), PRIVATE)
    write_whole(folder / CERTIFICATE, certificate.public_bytes(serialization.Encoding.DER))
