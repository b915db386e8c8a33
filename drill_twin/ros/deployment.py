# SPDX-License-Identifier: Apache-2.0
"""Deployment of the nodes: discovery on this host only, and fast, unless the environment says otherwise; security.

Without the Fast DDS profile of this package a node that joins later is discovered after up to 3 s, with it within
0.5 s. Variables that the user has set keep their values. The Fast DDS of the wheels is built without security plugins
(SROS2); with a whole ROS 2 Jazzy they are there. What is required and not there is refused.
"""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drill_twin.core.errors import DrillTwinError
from drill_twin.core.numerals import whole_number
from drill_twin.scene.paths import config_dir

HIGHEST_DOMAIN = 101
"""Highest ROS_DOMAIN_ID whose ports stay below Linux's ephemeral range."""
_HIGHEST_POSSIBLE = 232


def prepare() -> None:
    """Set the environment variables that DDS reads when it starts; called before `rclpy.init`.

    Raises:
        DrillTwinError: ROS_DOMAIN_ID is not a domain, or the required security is not available.
    """
    refuse_unsecured()
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    profile = config_dir() / "dds" / "discovery.xml"
    if profile.is_file():
        os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(profile))
    if "HOME" not in os.environ:
        os.environ.setdefault("ROS_LOG_DIR", str(Path.cwd() / "log"))
    domain_of_environment()


def domain_of_environment() -> int | None:
    """ROS_DOMAIN_ID as a number; None when not set.

    Raises:
        DrillTwinError: The variable is not a whole number from 0 to 232.
    """
    text = os.environ.get("ROS_DOMAIN_ID", "").strip()
    if not text:
        return None
    if (domain := whole_number(text)) is None or domain > _HIGHEST_POSSIBLE:
        raise DrillTwinError(f"ROS_DOMAIN_ID: expected a whole number from 0 to {_HIGHEST_POSSIBLE}, found {text!r}")
    return domain


class DomainClaim:
    """Exclusive use of a DDS domain among the demos and tests on this machine.

    The claim is an abstract socket name: it ends with the process, also after a kill, and leaves no file.
    """

    def __init__(self, wanted: int | None = None, *, start: int | None = None) -> None:
        """Claim one domain.

        Args:
            wanted: The domain; None: the first that is free.
            start: First domain to try, by default spread by process id.

        Raises:
            DrillTwinError: That domain, or every domain, is in use.
        """
        first = os.getpid() if start is None else start
        choices = [wanted] if wanted is not None else [1 + (first + k) % HIGHEST_DOMAIN for k in range(HIGHEST_DOMAIN)]
        for domain in choices:
            claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            try:
                claim.bind(f"\0drill_twin_domain_{domain}")
            except OSError:
                claim.close()
                continue
            self.domain, self._socket = domain, claim
            return
        if wanted is not None:
            raise DrillTwinError(
                f"ROS_DOMAIN_ID={wanted} is in use by another drill_twin demo or test on this machine; "
                "choose another domain, or unset ROS_DOMAIN_ID and a free one is taken"
            )
        raise DrillTwinError(
            f"expected a free DDS domain from 1 to {HIGHEST_DOMAIN}, found all in use by drill_twin demos or tests"
        )

    def release(self) -> None:
        """End the claim."""
        self._socket.close()


@contextmanager
def own_domain(logs: Path) -> Iterator[int]:
    """Context in which the nodes started here, and their logs, are in a domain of their own; yields its number.

    Raises:
        DrillTwinError: The domain of the environment, or every domain, is in use; the required security is not there.
    """
    claim = DomainClaim(domain_of_environment())
    os.environ["ROS_DOMAIN_ID"], os.environ["ROS_LOG_DIR"] = str(claim.domain), str(logs)
    prepare()
    try:
        yield claim.domain
    finally:
        claim.release()


def refuse_unsecured() -> None:
    """Refuse to start if `ROS_SECURITY_STRATEGY=Enforce` is set but would have no effect.

    Raises:
        DrillTwinError: ROS 2 would start without security, or has no keys.
    """
    if os.environ.get("ROS_SECURITY_STRATEGY", "").lower() != "enforce":
        return
    enabled, keys = os.environ.get("ROS_SECURITY_ENABLE", ""), os.environ.get("ROS_SECURITY_KEYSTORE", "")
    if enabled.lower() != "true":
        raise DrillTwinError(
            "ROS_SECURITY_STRATEGY=Enforce: expected ROS_SECURITY_ENABLE=true beside it, found "
            f"{enabled or 'none'}, with which ROS 2 would start unsecured; set it, or unset ROS_SECURITY_STRATEGY"
        )
    if not os.path.isdir(keys):  # noqa: PTH112 - a path of the environment, used once
        raise DrillTwinError(
            f"ROS_SECURITY_STRATEGY=Enforce: expected the folder of the keys in ROS_SECURITY_KEYSTORE, found "
            f"{keys or 'none'}; make one with ros2 security create_keystore"
        )


@contextmanager
def readable_refusal() -> Iterator[None]:
    """Turn the errors with which rclpy refuses to create a node into one line.

    Raises:
        DrillTwinError: rclpy refused to create it.
    """
    try:
        yield
    except RuntimeError as error:  # rclpy's RCLError is one
        text = " ".join(str(error).partition(", at ")[0].split())
        if "security" not in text:
            raise DrillTwinError(f"expected ROS to make this node, found: {text}") from error
        raise DrillTwinError(
            f"expected a Fast DDS with security, found: {text.removeprefix('error creating node: ')}; the Fast DDS "
            "of the wheels has none: use a whole ROS 2 Jazzy, or unset ROS_SECURITY_ENABLE to run unsecured"
        ) from error
