# SPDX-License-Identifier: Apache-2.0
"""Command `drill-twin ros keys`: certificate and users of the gateway."""

import socket
from pathlib import Path
from typing import Annotated

import typer


def keys(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the keys; it is made if there is none.")],
    user: Annotated[str, typer.Option(metavar="NAME", help="Name of a user to add, or who gets another password.")],
    password: Annotated[
        str,
        typer.Option(
            metavar="TEXT",
            prompt=True,
            hide_input=True,
            help="Password, 8 characters or more; asked for if left out, as others see options.",
        ),
    ],
    host: Annotated[
        str,
        typer.Option(metavar="NAME", help="Name of the machine in the certificate; this machine's name if left out."),
    ] = "",
) -> None:
    """Make the keys of the gateway: a self-signed certificate, and users that may command.

    Put the certificates of clients into DIR/trusted.
    """
    from drill_twin_rig.gateway.opc_ua.keys import CERTIFICATE, TRUSTED, USERS, make_keys

    new = make_keys(folder, "urn:drill_twin:gateway", host or socket.gethostname(), {user: password})
    print(f"{folder / USERS}: {user} is {'new' if user in new else 'given another password'}")
    print(f"{folder / CERTIFICATE}: for clients to trust; put theirs into {folder / TRUSTED}")
