# SPDX-License-Identifier: Apache-2.0
"""Sessions of the server: users, certificates, and the writes that are taken; what is refused is counted and told."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from typing import Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import UserRole
from cryptography.hazmat.primitives.serialization import Encoding

from drill_twin.core.errors import shortened
from drill_twin.gateway.control import Control, User
from drill_twin.gateway.opc_ua.keys import Keys
from drill_twin.gateway.opc_ua.password_check import is_checked

_TOLD = 10.0  # s; for so long a refusal is told


class _SessionUser:
    """User as the library wants one: with a role that reads, and writes what nodes admit."""

    role = UserRole.User

    def __init__(self, user: User) -> None:
        self.user, self.name = user, user.name


class Sessions:
    """Callbacks of the server."""

    def __init__(self, control: Control, keys: Keys | None) -> None:
        self._control, self.keys = control, keys
        """Keys; None: everybody reads, and nobody writes."""
        self._names: Mapping[Any, str] = {}
        self._last_refusal = ("", -_TOLD)
        self.refused: Counter[str] = Counter()
        """Refused connections and writes, by kind: certificate, user, right, value, silent."""

    def watch(self, names: Mapping[Any, str]) -> None:
        """Name the nodes that are written through the control, by node id."""
        self._names = names

    @property
    def refusal(self) -> str:
        """The last refusal, for some seconds; empty afterwards."""
        text, told = self._last_refusal
        return text if time.monotonic() - told < _TOLD else ""

    def note_silent(self) -> None:
        """Count a connection that was closed without a session, as places were short."""
        self.refused["silent"] += 1

    def get_user(
        self, _server: Any, username: str | None = None, password: str | None = None, certificate: bytes | None = None
    ) -> _SessionUser | None:
        """User of a session; None refuses it."""
        if self.keys is None:
            return _SessionUser(User())
        name = shortened(username or "", 60)
        if certificate is None or (reason := self.keys.distrust(certificate)):
            self._refuse("certificate", f"client of {name or 'no user'}: {reason if certificate else 'no certificate'}")
            return None
        if not is_checked(username or "", password or ""):
            self._refuse("user", f"user {name or 'without name'}: unknown, or the password is wrong")
            return None
        return _SessionUser(User(name, may_command=True))

    async def check_certificate(self, certificate: Any, _application: Any) -> None:
        """Refuse a certificate that is not trusted, with its status.

        Raises:
            ServiceError: It is refused.
        """
        reason = self.keys.distrust(certificate.public_bytes(Encoding.DER)) if self.keys else ""
        if reason:
            self._refuse("certificate", f"client {shortened(certificate.subject.rfc4514_string(), 80)}: {reason}")
            raise ServiceError(ua.StatusCodes.BadCertificateUntrusted)

    def before_write(self, event: Any, _service: Any) -> None:
        """Refuse a write that the control does not take.

        Raises:
            ServiceError: It is refused.
        """
        if event.is_external and any(one.IndexRange for one in event.request_params.NodesToWrite):
            self._refuse("value", "a part of a value was written; each of these has none")
            raise ServiceError(ua.StatusCodes.BadIndexRangeNoData)
        for name, value in self._writes(event):
            if refusal := self._control.refusal(event.user.user, name, value):
                self._refuse("value" if refusal.of_value else "right", refusal.text)
                codes = ua.StatusCodes
                raise ServiceError(codes.BadOutOfRange if refusal.of_value else codes.BadUserAccessDenied)

    def after_write(self, event: Any, _service: Any) -> None:
        """Hand a write that was taken to the control."""
        for index, (name, value) in enumerate(self._writes(event)):
            if event.response_params[index].is_good():
                self._control.write(event.user.user, name, value)

    def _writes(self, event: Any) -> list[tuple[str, Any]]:
        """Names and values of the nodes that a client writes; any other node has the empty name."""
        if not event.is_external:
            return []
        return [
            (self._names.get(one.NodeId, ""), one.Value.Value.Value if one.Value.Value is not None else None)
            for one in event.request_params.NodesToWrite
        ]

    def _refuse(self, kind: str, text: str) -> None:
        self.refused[kind] += 1
        self._last_refusal = (text, time.monotonic())
