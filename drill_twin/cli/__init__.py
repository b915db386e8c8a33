# SPDX-License-Identifier: Apache-2.0
"""Command line `drill-twin`, a module for each sub-command.

Results go to stdout, all else to stderr. Exit codes: 0 success, 1 a run that stopped or a check that failed, 2 an error
of input or use (one line on stderr), 130 stopped with Ctrl-C, 143 ended by SIGTERM.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from drill_twin.cli import interrupt
from drill_twin.core.errors import printable, words_cut
from drill_twin.core.process import (
    end_process,
    error_text,
    open_closed_streams,
    refuse_too_little_memory,
    use_one_thread_of_blas,
)

_LONGEST_MESSAGE = 3000


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and end the process with its exit code."""
    interrupt.install()
    open_closed_streams()
    use_one_thread_of_blas()
    try:
        code = run_command(list(sys.argv[1:] if arguments is None else arguments))
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of stdout has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    interrupt.ignore()
    end_process(code)


def run_command(arguments: Sequence[str]) -> int:
    """Run one command; returns the exit code."""
    try:
        return _run_command(arguments)
    except interrupt.Interrupted as stopped:
        print("drill-twin: stopped", file=sys.stderr)
        return stopped.exit_code


def _run_command(arguments: Sequence[str]) -> int:
    from drill_twin.core.errors import DrillTwinError, StoppedError

    try:
        refuse_too_little_memory()
    except DrillTwinError as error:
        return _fail(str(error), code=1)
    from typer.main import get_command

    from drill_twin.cli.app import app

    try:
        code = get_command(app).main(list(arguments), prog_name="drill-twin", standalone_mode=False)
    except StoppedError as error:
        return _fail(str(error), code=1)
    except DrillTwinError as error:
        return _fail(str(error))
    except BrokenPipeError:
        raise
    except (OSError, MemoryError) as error:
        return _fail(error_text(error), code=1)
    except Exception as error:
        if not hasattr(error, "format_message"):  # usage errors have one in every version of typer and click
            raise
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "drill-twin"
        text = error.format_message().rstrip(".").replace("Value error, ", "").replace("not one of '', ", "not one of ")
        return _fail(f"{text}; see `{command} --help`")
    return int(code or 0)


def _fail(message: str, code: int = 2) -> int:
    text = printable(words_cut(" ".join(message.split())))
    shown = text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."
    print(f"drill-twin: error: {shown}", file=sys.stderr)
    return code
