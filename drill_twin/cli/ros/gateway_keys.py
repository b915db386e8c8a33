# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin gateway-keys`: certificate, private key and users of the gateway."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Annotated

import typer


def gateway_keys(
    folder: Annotated[Path, typer.Argument(help="Folder of the keys; made where it is missing.")],
    user: Annotated[str, typer.Option(help="User to add, or who gets another password.")],
    password: Annotated[
        str,
        typer.Option(
            prompt=True,
            hide_input=True,
            help="Password, 8 characters or more; asked for if left out (others see the options of a command).",
        ),
    ],
    host: Annotated[str, typer.Option(help="Name of the machine in the certificate; without it this one's.")] = "",
) -> None:
    """Make the keys of the gateway: a self-signed certificate, and users that may command. Needs the extra opcua.

    Put the certificates of clients into FOLDER/trusted.
    """
    try:
        from drill_twin.gateway.opc_ua.keys import CERTIFICATE, TRUSTED, USERS, make_keys
    except ModuleNotFoundError as error:
        from drill_twin.core.extras import missing

        raise missing(error, "opcua") from error
    new = make_keys(folder, "urn:drill_twin:gateway", host or socket.gethostname(), {user: password})
    print(f"{folder / USERS}: {user} is {'new' if user in new else 'given another password'}")
    print(f"{folder / CERTIFICATE}: for clients to trust; put theirs into {folder / TRUSTED}")
