# SPDX-License-Identifier: Apache-2.0
"""Folder of keys of the gateway: its certificate and private key, trusted certificates of clients, and users.

`certificate.der`, `private_key.pem`, `trusted/*.der` (or `.pem`), and `users.yaml` with a line a user: salted hashes of
passwords (scrypt), in a file that its owner alone reads.
"""

import hashlib
import hmac
import json
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, Self

from asyncua.crypto.cert_gen import dump_private_key_as_pem, generate_private_key, generate_self_signed_app_certificate
from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.x509.oid import ExtendedKeyUsageOID

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.files.foreign_file import ForeignFile
from drill_twin.core.files.output import PRIVATE, write_whole, writing
from drill_twin.core.files.yaml_reader import LARGEST_TEXT, plain_yaml

LEAST_LENGTH: Final = 8
"""Characters of a password at least: NIST SP 800-63B where it is one factor of two; the certificate is the other."""
_MOST, _NAME_LENGTH = 1000, 60  # characters of a password and of a name
_COST = (17, 8, 1)  # log2 n, r, p: the least that OWASP's password storage cheat sheet names for scrypt; 128 MiB
_HARDEST = (20, 16, 8)
_REMEDY = "make it with drill-twin ros keys"


class KeysError(DrillTwinError):
    """A folder of keys that cannot be used."""


_FILE = ForeignFile("a file of users", LARGEST_TEXT, KeysError)


@dataclass(frozen=True)
class PasswordHash:
    """Salted hash of a password, with the cost of computing it."""

    salt: bytes
    hash: bytes
    cost: tuple[int, int, int] = _COST
    """log2 n, r and p of scrypt."""

    @classmethod
    def of(cls, password: str) -> Self:
        """Hash of a new password.

        Raises:
            KeysError: The password is too short or too long.
        """
        if not LEAST_LENGTH <= len(password) <= _MOST:
            raise KeysError(
                f"password: expected {LEAST_LENGTH} to {_MOST} characters, found {len(password)}; four words make a "
                "good one"
            )
        salt = secrets.token_bytes(16)
        return cls(salt, _scrypt(password, salt, _COST))

    @classmethod
    def parsed(cls, text: str) -> Self:
        """Hash from a line of the file: `LOG2N-R-P:SALT:HASH`.

        Raises:
            ValueError: The text is no hash, or the hash would cost more than `_HARDEST`.
        """
        found = re.fullmatch(r"(\d{1,2})-(\d{1,2})-(\d{1,2}):([0-9a-f]{8,128}):([0-9a-f]{32,256})", text)
        if found is None:
            raise ValueError(text)
        n, r, p, salt, digest = found.groups()
        cost = (int(n), int(r), int(p))
        if not all(1 <= one <= most for one, most in zip(cost, _HARDEST, strict=True)):
            raise ValueError(text)
        return cls(bytes.fromhex(salt), bytes.fromhex(digest), cost)

    def __str__(self) -> str:
        """Line of the file."""
        return f"{'-'.join(map(str, self.cost))}:{self.salt.hex()}:{self.hash.hex()}"

    def is_of(self, password: str) -> bool:
        """True for the password; takes some tenths of a second of a core and 128 MiB, so call it beside a loop."""
        return hmac.compare_digest(_scrypt(password[: _MOST + 1], self.salt, self.cost, len(self.hash)), self.hash)


NOBODY: Final = PasswordHash(bytes(16), bytes(64))
"""Hash of no password: an unknown user costs the same time as a known one."""


def _scrypt(password: str, salt: bytes, cost: tuple[int, int, int], length: int = 64) -> bytes:
    n, r, p = 2 ** cost[0], cost[1], cost[2]
    return hashlib.scrypt(
        password.encode("utf-8", "surrogatepass"), salt=salt, n=n, r=r, p=p, maxmem=2 * 128 * r * (n + p), dklen=length
    )


def read_users(path: Path) -> dict[str, PasswordHash]:
    """Users of a file, and the hashes of their passwords.

    Raises:
        KeysError: The file cannot be read, or others than its owner can read or write it.
    """
    text = _FILE.text(path)
    check_private(path)
    lines = plain_yaml(text, str(path)) or {}
    try:
        return {str(name): PasswordHash.parsed(text) for name, text in lines.items()}
    except (AttributeError, TypeError, ValueError):
        raise KeysError(f"{path}: expected lines NAME: COST:SALT:HASH, found other lines; {_REMEDY}") from None


def set_password(path: Path, name: str, password: str) -> bool:
    """Add a user to the file, or give one who is there another password; returns True for a new one.

    The file is replaced as a whole: a reader sees the old file or the new file.

    Raises:
        KeysError: Name or password are of no use, or the file is not.
        OSError: The file cannot be written.
    """
    if not name.isprintable() or not 0 < len(name) <= _NAME_LENGTH:
        raise KeysError(f"user: expected 1 to {_NAME_LENGTH} printable characters, found {name[:80]!r}")
    users = read_users(path) if path.exists() else {}
    is_new = name not in users
    users[name] = PasswordHash.of(password)
    write_whole(path, "".join(f"{json.dumps(one)}: {json.dumps(str(users[one]))}\n" for one in users), PRIVATE)
    return is_new


def check_private(path: Path) -> None:
    """Refuse a secret that others than its owner can read or write.

    Raises:
        KeysError: Others than its owner can.
    """
    mode = path.stat().st_mode & 0o777
    if mode & 0o077:
        raise KeysError(f"{path}: expected a file that its owner alone reads, found mode {mode:o}; chmod 600 {path}")


CERTIFICATE, PRIVATE_KEY, TRUSTED, USERS = "certificate.der", "private_key.pem", "trusted", "users.yaml"
_DAYS = 3650
_CERTIFICATE_FILE = ForeignFile("a certificate (DER or PEM)", 100_000, KeysError)


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

    def distrust(self, certificate: bytes) -> str:
        """Reason why a certificate is not trusted; empty if it is."""
        if certificate not in self.trusted:
            return f"its certificate is not in {self.folder / TRUSTED}"
        known, now = x509.load_der_x509_certificate(certificate), datetime.now(UTC)
        if not known.not_valid_before_utc <= now <= known.not_valid_after_utc:
            return f"its certificate holds from {known.not_valid_before_utc} to {known.not_valid_after_utc} only"
        return ""

    def is_user(self, name: str, password: str) -> bool:
        """Return True for a known user with this password; takes tenths of a second, for an unknown one too."""
        return self.users.get(name, NOBODY).is_of(password)


def read_keys(folder: Path) -> Keys:
    """Keys of a folder.

    Raises:
        KeysError: A file is missing or no certificate, or others than its owner can read a secret.
    """
    remedy = "make one with drill-twin ros keys"
    for name in (CERTIFICATE, PRIVATE_KEY, USERS):
        if not (folder / name).is_file():
            raise KeysError(f"{folder}: expected a folder of keys with {name}, found none; {remedy}")
    check_private(folder / PRIVATE_KEY)
    users = read_users(folder / USERS)
    trusted = frozenset(_certificate(path) for path in sorted((folder / TRUSTED).glob("*.[dp]e[rm]")))
    return Keys(folder, _certificate(folder / CERTIFICATE), trusted, users)


def _certificate(path: Path) -> bytes:
    data = _CERTIFICATE_FILE.read(path)
    try:
        load = x509.load_pem_x509_certificate if data.startswith(b"-----") else x509.load_der_x509_certificate
        return load(data).public_bytes(serialization.Encoding.DER)
    except ValueError as error:
        raise KeysError(f"{path}: expected a certificate (DER or PEM), found {error}") from error


def make_keys(folder: Path, application: str, host: str, users: Mapping[str, str]) -> list[str]:
    """Write a folder of keys with a self-signed certificate, or add users to one; returns the new users' names.

    Args:
        folder: The folder; its secrets are readable by its owner only.
        application: URI of the application.
        host: Name or address of the machine.
        users: Passwords by name; a user who is there gets this one.

    Raises:
        KeysError: The folder cannot be written, or a name or password is of no use.
    """
    with writing(folder, "the keys", "choose another folder", KeysError):
        (folder / TRUSTED).mkdir(parents=True, exist_ok=True)
        if not (folder / CERTIFICATE).exists():
            _make_certificate(folder, application, host)
        return [name for name, password in users.items() if set_password(folder / USERS, name, password)]


def _make_certificate(folder: Path, application: str, host: str) -> None:
    key = generate_private_key()
    names = [x509.UniformResourceIdentifier(application), x509.DNSName(host)]
    purposes = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
    certificate = generate_self_signed_app_certificate(key, application, {}, names, purposes, _DAYS)
    write_whole(folder / PRIVATE_KEY, dump_private_key_as_pem(key), PRIVATE)
    write_whole(folder / CERTIFICATE, certificate.public_bytes(serialization.Encoding.DER))
