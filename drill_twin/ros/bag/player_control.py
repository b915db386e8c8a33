# SPDX-License-Identifier: Apache-2.0
"""Control of a replay under the names of rosbag2's player: pause, resume, one message at a time, rate, seek.

The types of these services are of the package `rosbag2_interfaces`, which a whole ROS 2 has and the wheels lack.
Without the package, services that need no number are `std_srvs/Trigger`; parameters stand in for the other services.
"""

import importlib
import math
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from rclpy.parameter import Parameter as RosParameter
from std_srvs.srv import Trigger

from drill_twin.core.errors import DrillTwinError
from drill_twin.io.messages.stamps import NANOSECONDS
from drill_twin.ros.core.node import TwinNode

SERVICES = {
    "pause": "Pause", "resume": "Resume", "toggle_paused": "TogglePaused", "play_next": "PlayNext", "stop": "Stop",
    "burst": "Burst", "is_paused": "IsPaused", "get_rate": "GetRate", "set_rate": "SetRate", "seek": "Seek",
}  # fmt: skip
"""Names under the node and types of rosbag2's player."""
WITHOUT_NUMBERS = ("pause", "resume", "toggle_paused", "play_next", "stop")
"""Services that the type `std_srvs/Trigger` can do."""


class Playhead:
    """Place in a bag [s from its start]: it moves with the wall clock, rests, or goes elsewhere."""

    def __init__(self, place: float, rate: float, *, paused: bool) -> None:
        """Rest at a place until the replay begins."""
        self.rate, self.paused, self.waits = rate, paused, True
        """Times as fast as recorded, 0 as fast as possible; whether a user or the node itself holds the replay."""
        self.singles = 0
        """Messages that a paused replay is still to publish."""
        self.target: float | None = None
        """Place to go to next [s]; None: on from here."""
        self.arrive(place)

    @property
    def place(self) -> float:
        """Present place [s]."""
        moves = not (self.paused or self.waits)
        return self._place + moves * self.rate * (time.monotonic() - self._since)

    def change(self, **values: Any) -> None:
        """Change rate, rests or target from now on."""
        self.arrive(self.place)
        vars(self).update(values)

    def arrive(self, place: float) -> None:
        """Be at a place [s]."""
        self._place, self._since = place, time.monotonic()

    def time_to(self, place: float) -> float:
        """Time until the message at a place is due [s]; infinite while the replay rests."""
        if self.paused or self.waits:
            return 0.0 if self.singles and not self.waits else math.inf
        return max((place - self.place) / self.rate, 0.0) if self.rate else 0.0

    def passed(self, place: float) -> None:
        """Note that the message at a place was published."""
        if self.paused or not self.rate:
            self.arrive(place)
        self.singles = max(self.singles - 1, 0) if self.paused else 0


class PlayerControl:
    """An answer to each service, as fields of its response."""

    def __init__(self, head: Playhead, start: int, length: float, node: TwinNode) -> None:
        """Control a playhead.

        Args:
            head: The playhead.
            start: Time of recording of the first message [ns].
            length: Length of the bag [s].
            node: The replayer.
        """
        self._head, self._start, self._length, self._node = head, start, length, node

    def pause(self, _: Any = None) -> dict[str, Any]:
        """Rest."""
        self._head.change(paused=True)
        return self._said("paused")

    def resume(self, _: Any = None) -> dict[str, Any]:
        """Go on."""
        self._head.change(paused=False, singles=0)
        return self._said("going on")

    def toggle_paused(self, _: Any) -> dict[str, Any]:
        """Rest, or go on."""
        return self.resume() if self._head.paused else self.pause()

    def is_paused(self, _: Any) -> dict[str, Any]:
        """State: paused or not."""
        return {"paused": self._head.paused}

    def play_next(self, _: Any) -> dict[str, Any]:
        """Publish the next message of a paused replay."""
        return self.burst(SimpleNamespace(num_messages=1))

    def burst(self, request: Any) -> dict[str, Any]:
        """Publish the next messages of a paused replay."""
        if not self._head.paused:
            raise DrillTwinError(f"expected a paused replay, found it playing; call {self._node.get_name()}/pause")
        self._head.singles += request.num_messages
        return self._said("next message") | {"actually_burst": request.num_messages}

    def get_rate(self, _: Any) -> dict[str, Any]:
        """Times as fast as recorded."""
        return {"rate": self._head.rate}

    def set_rate(self, request: Any) -> dict[str, Any]:
        """Set the parameter `rate`."""
        result = self._node.set_parameters([RosParameter("rate", value=float(request.rate))])[0]
        return {"success": bool(result.successful)}

    def seek(self, request: Any) -> dict[str, Any]:
        """Go to a time of recording."""
        self.go_to((request.time.sec * NANOSECONDS + request.time.nanosec - self._start) / NANOSECONDS)
        return {"success": True}

    def stop(self, _: Any) -> dict[str, Any]:
        """End the node."""
        self._node.end()
        return self._said("ending")

    def go_to(self, place: float) -> None:
        """Go to a place [s from the start].

        Raises:
            DrillTwinError: The bag does not reach there.
        """
        self.check(place)
        self._head.change(target=place)

    def check(self, place: float) -> None:
        """Refuse a place [s from the start] outside the bag.

        Raises:
            DrillTwinError: The bag does not reach there.
        """
        if not 0.0 <= place <= self._length:
            raise DrillTwinError(f"expected a place in the bag, 0 to {self._length:.3f} s, found {place:.3f} s")

    def _said(self, what: str) -> dict[str, Any]:
        rests = "" if self._node.active else "inactive; once the node is active: "
        return {"success": True, "message": f"{rests}{what} at {self._head.place:.3f} s"}


def offer(node: TwinNode, control: PlayerControl) -> None:
    """Offer rosbag2's services: with its types where they are installed, else the services that need no number."""
    try:
        kinds: Any = importlib.import_module("rosbag2_interfaces.srv")
    except ImportError:
        kinds = SimpleNamespace(**dict.fromkeys((SERVICES[name] for name in WITHOUT_NUMBERS), Trigger))
    for name, kind in SERVICES.items():
        if hasattr(kinds, kind):
            node.create_service(getattr(kinds, kind), f"~/{name}", _answering(getattr(control, name)))


def _answering(action: Callable[[Any], dict[str, Any]]) -> Callable[[Any, Any], Any]:
    """Callback that fills the fields that the response has."""

    def answer(request: Any, response: Any) -> Any:
        try:
            found = action(request)
        except DrillTwinError as error:
            found = {"success": False, "message": str(error)}
        for name, value in found.items():
            if hasattr(response, name):
                setattr(response, name, value)
        return response

    return answer
