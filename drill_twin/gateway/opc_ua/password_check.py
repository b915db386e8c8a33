# SPDX-License-Identifier: Apache-2.0
"""Check of passwords beside the event loop of the server, for a hash takes tenths of a second.

asyncua asks its user manager while the loop waits. So the activation of a session is held up here until a thread has
the verdict, which the user manager then finds; without a verdict nobody is let in.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any

from asyncua import ua
from asyncua.server import binary_server_asyncio
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import struct_from_binary

_ACTIVATE = ua.NodeId(ua.ObjectIds.ActivateSessionRequest_Encoding_DefaultBinary)
_AT_ONCE = 2  # 128 MiB each; a connection has one under way, and connections are bounded
_VERDICT: ContextVar[tuple[str, str] | None] = ContextVar("verdict", default=None)
_THREADS = ThreadPoolExecutor(_AT_ONCE, thread_name_prefix="passwords")


def is_checked(name: str, password: str) -> bool:
    """True if the request that is worked on brought this name and password, and they were found right."""
    return _VERDICT.get() == (name, password)


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
