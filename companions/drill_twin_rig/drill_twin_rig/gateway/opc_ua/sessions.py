# SPDX-License-Identifier: Apache-2.0
"""Sessions of the server: users, certificates, and the writes that are taken; what is refused is counted and told.

A hash of a password takes tenths of a second, and asyncua asks its user manager while the event loop waits. So the
activation of a session is held up until a thread has the verdict, which the user manager then finds; without a verdict
nobody is let in.
"""

import asyncio
import time
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.crypto.permission_rules import UserRole
from asyncua.server import binary_server_asyncio
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import struct_from_binary
from cryptography.hazmat.primitives.serialization import Encoding

from drill_twin.core.errors import shortened
from drill_twin_rig.gateway.control import Control, User
from drill_twin_rig.gateway.opc_ua.keys import Keys

_ACTIVATE = ua.NodeId(ua.ObjectIds.ActivateSessionRequest_Encoding_DefaultBinary)
_AT_ONCE = 2  # hashes, of 128 MiB each; a connection has one under way, and connections are bounded
_VERDICT: ContextVar[tuple[str, str] | None] = ContextVar("verdict", default=None)
"""Name and password of the request that is worked on, if they were found right."""
_THREADS = ThreadPoolExecutor(_AT_ONCE, thread_name_prefix="passwords")


class _Processor(UaProcessor):  # type: ignore[misc]  # of a library without types
    """Requests of a connection."""

    async def _process_message(self, typeid: Any, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        _VERDICT.set(await self._verdict(requesthdr, body.copy()) if typeid == _ACTIVATE else None)
        return await super()._process_message(typeid, requesthdr, seqhdr, body)

    async def _verdict(self, header: Any, body: Any) -> tuple[str, str] | None:
        """Name and password of an activation if they are right."""
        keys = getattr(self.iserver.user_manager, "keys", None)
        session = self.session or self.iserver.lookup_external_session(header.AuthenticationToken)
        token = struct_from_binary(ua.ActivateSessionParameters, body).UserIdentityToken
        certificate = self._connection.security_policy.peer_certificate
        if keys is None or session is None or certificate is None or keys.distrust(certificate):
            return None
        if not isinstance(token, ua.UserNameIdentityToken):
            return None
        try:
            name, password = self.iserver.decrypt_user_token(session, token)
        except Exception:  # noqa: BLE001 - whatever a client sends; the library answers it
            return None
        right = await asyncio.get_running_loop().run_in_executor(_THREADS, keys.is_user, name or "", password or "")
        return (name, password) if right else None


binary_server_asyncio.UaProcessor = _Processor  # asyncua has no other place for it


_TOLD = 10.0  # s, for which a refusal is told


class Sessions:
    """Callbacks of the server."""

    def __init__(self, control: Control, keys: Keys | None) -> None:
        self._control, self.keys = control, keys
        """Keys; None: everybody reads, and nobody writes."""
        self.names: Mapping[Any, str] = {}
        """Names of the nodes that are written through the control, by node id."""
        self._last_refusal = ("", -_TOLD)
        self.refused: Counter[str] = Counter()
        """Refused connections and writes, by kind: certificate, user, right, value; and silent, for connections
        without a session that were closed as places were short."""

    @property
    def refusal(self) -> str:
        """The last refusal, for some seconds; empty afterwards."""
        text, told = self._last_refusal
        return text if time.monotonic() - told < _TOLD else ""

    def get_user(
        self, _server: Any, username: str | None = None, password: str | None = None, certificate: bytes | None = None
    ) -> User | None:
        """User of a session; None refuses it."""
        if self.keys is None:
            return User(role=UserRole.User)
        name = shortened(username or "", 60)
        if certificate is None or (reason := self.keys.distrust(certificate)):
            self._refuse("certificate", f"client of {name or 'no user'}: {reason if certificate else 'no certificate'}")
            return None
        if _VERDICT.get() != (username or "", password or ""):
            self._refuse("user", f"user {name or 'without name'}: unknown, or the password is wrong")
            return None
        return User(name, may_command=True, role=UserRole.User)

    async def check_certificate(self, certificate: Any, _application: Any) -> None:
        """Refuse a certificate that is not trusted, with its status.

        Raises:
            ServiceError: The certificate is refused.
        """
        reason = self.keys.distrust(certificate.public_bytes(Encoding.DER)) if self.keys else ""
        if reason:
            self._refuse("certificate", f"client {shortened(certificate.subject.rfc4514_string(), 80)}: {reason}")
            raise ServiceError(ua.StatusCodes.BadCertificateUntrusted)

    def before_write(self, event: Any, _service: Any) -> None:
        """Refuse a write that the control does not take.

        Raises:
            ServiceError: The write is refused.
        """
        if event.is_external and any(one.IndexRange for one in event.request_params.NodesToWrite):
            self._refuse("value", "a part of a value was written; each of these has none")
            raise ServiceError(ua.StatusCodes.BadIndexRangeNoData)
        for name, value in self._writes(event):
            if refusal := self._control.refusal(event.user, name, value):
                self._refuse("value" if refusal.of_value else "right", refusal.text)
                codes = ua.StatusCodes
                raise ServiceError(codes.BadOutOfRange if refusal.of_value else codes.BadUserAccessDenied)

    def after_write(self, event: Any, _service: Any) -> None:
        """Hand a write that was taken to the control; where the simulator may still refuse it, the client is told."""
        for index, (name, value) in enumerate(self._writes(event)):
            if event.response_params[index].is_good():
                self._control.write(event.user, name, value)
                if self._control.is_unsure(name):
                    event.response_params[index] = ua.StatusCode(ua.StatusCodes.GoodCompletesAsynchronously)

    def _writes(self, event: Any) -> list[tuple[str, Any]]:
        """Names and values of the nodes that a client writes; any other node has the empty name."""
        if not event.is_external:
            return []
        return [
            (self.names.get(one.NodeId, ""), one.Value.Value.Value if one.Value.Value is not None else None)
            for one in event.request_params.NodesToWrite
        ]

    def _refuse(self, kind: str, text: str) -> None:
        self.refused[kind] += 1
        self._last_refusal = (text, time.monotonic())
