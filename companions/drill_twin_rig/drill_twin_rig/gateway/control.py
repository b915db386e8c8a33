# SPDX-License-Identifier: Apache-2.0
"""Control by grant and heartbeat, as in the ADCS interface of D-WIS: one holder, for as long as his heartbeat lasts."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from drill_twin.core.errors import shortened
from drill_twin_rig.gateway.signals import CommandTarget, Limits, why_refused

REQUEST, HEARTBEAT = "Request", "Heartbeat"
"""Names of the nodes that a client writes: to the first true to request control and false to give it back, to the
second a number that changes."""
PERMISSION, HOLDER, REFUSAL = "Permission", "Holder", "Refusal"
"""Names of the nodes that the gateway writes."""


class Permission(IntEnum):
    """Permission, with the numbers of D-WIS."""

    UNSET = 0
    GRANTED = 1
    PENDING = 2
    DENIED = 3
    INVALID = 4


@dataclass(frozen=True, eq=False)
class User:
    """User of one session; two sessions of a person are two users."""

    name: str = ""
    """Name; empty for an anonymous one."""
    may_command: bool = False
    """True for a known user with a trusted certificate on an encrypted connection."""
    role: object = None
    """Role that the server's library wants of a user."""


class Refusal(NamedTuple):
    """Refusal of a write."""

    text: str
    """Reason, as a sentence."""
    of_value: bool = False
    """True if another value would have been taken."""


class Control:
    """Decides which writes are taken; may be called from several threads."""

    def __init__(
        self,
        targets: Sequence[CommandTarget],
        timeout: float,
        changed: Callable[[], None],
        limits: Limits,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Start without a holder.

        Args:
            targets: Set-points.
            timeout: Wall time without a heartbeat after which control is lost [s].
            changed: Called when the holder has set a target.
            limits: Limits of the simulator, as they are known at a time.
            clock: Monotonic time [s].
        """
        self._targets = {target.name: target for target in targets}
        self._timeout, self._changed, self._limits, self._clock = timeout, changed, limits, clock
        self._lock = threading.RLock()
        self._beat: tuple[object, float] = (None, -math.inf)  # last heartbeat, and the time at which it came
        self.permission = Permission.UNSET
        self.user: User | None = None
        """Holder of control, or the user who requests it."""
        self.lost = ""
        """Reason for which the last holder lost control; empty after an orderly end."""
        self.values: dict[str, float] = {}
        """Targets set by the holder, by quantity [SI]."""

    # --- called by the server -----------------------------------------------------------------------------------

    def refusal(self, user: User, name: str, value: object) -> Refusal | None:
        """Reason why a write is not taken; None if it is."""
        with self._lock:
            if not user.may_command:
                return Refusal(f"{user.name or 'an anonymous user'} may not command")
            other = self.user is not None and self.user is not user
            if name == REQUEST:
                return Refusal(f"{self.user.name} has control or requests it") if other and self.user else None
            if name == HEARTBEAT and self.user is user:
                return None
            if self.permission is not Permission.GRANTED or other:
                return Refusal(f"{user.name} has no control; write true to {REQUEST} first")
        if (target := self._targets.get(name)) is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return Refusal(f"{name}: expected a finite number, found {shortened(repr(value), 60)}", of_value=True)
        reason = why_refused(target, value, self._limits)
        return Refusal(f"{name}: {reason}", of_value=True) if reason else None

    def is_unsure(self, name: str) -> bool:
        """Return True for a target whose limits the simulator has not told: it may refuse later what is taken here."""
        return name in self._targets and self._targets[name].quantity not in self._limits

    def write(self, user: User, name: str, value: object) -> None:
        """Take a write that is not refused."""
        with self._lock:
            if name == REQUEST:
                self._request(user, wanted=bool(value))
            elif name == HEARTBEAT:
                if value != self._beat[0]:
                    self._beat = (value, self._clock())
            elif name in self._targets and isinstance(value, int | float):
                target = self._targets[name]
                self.values[target.quantity] = float(value) * target.factor
                self._changed()

    def _request(self, user: User, *, wanted: bool) -> None:
        if wanted and self.user is None:
            self.user, self.permission = user, Permission.PENDING
            self._beat = (None, self._clock())
        elif not wanted and self.user is user:
            self._end(Permission.UNSET, "")

    # --- called by the node -------------------------------------------------------------------------------------

    def grant(self) -> bool:
        """Grant what is requested; returns False if nothing is."""
        with self._lock:
            if self.permission is not Permission.PENDING:
                return False
            self.permission, self.lost, self.values = Permission.GRANTED, "", {}
            self._beat = (None, self._clock())
            return True

    def deny(self, reason: str) -> bool:
        """Deny what is requested or take control away; returns False if there is neither."""
        with self._lock:
            if self.user is None:
                return False
            self._end(Permission.DENIED, reason if self.permission is Permission.GRANTED else "")
            return True

    def check_heartbeat(self) -> bool:
        """End the control of a holder who is silent; returns True if that happened now."""
        with self._lock:
            if self.user is None or self._clock() - self._beat[1] <= self._timeout:
                return False
            granted = self.permission is Permission.GRANTED
            reason = f"no heartbeat of {self.user.name} for {self._timeout:g} s"
            self._end(Permission.INVALID, reason if granted else "")
            return granted

    def _end(self, permission: Permission, lost: str) -> None:
        self.permission, self.user, self.lost, self.values = permission, None, lost, {}

    @property
    def holder(self) -> str:
        """Name of the holder; empty without one."""
        user = self.user
        return user.name if user is not None and self.permission is Permission.GRANTED else ""
