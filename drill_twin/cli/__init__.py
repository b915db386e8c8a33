# SPDX-License-Identifier: Apache-2.0
"""Command line `drill-twin`, a module for each sub-command, or for several of one kind.

Results go to stdout, all else to stderr. Exit codes: 0 success, 1 a run that stopped or a check that failed, 2 an error
of input or use (one line on stderr), 130 stopped with Ctrl-C, 143 ended by SIGTERM.
"""

import gc
import os
import re
import sys
from collections.abc import Sequence
from itertools import pairwise

from drill_twin.cli import interrupt
from drill_twin.core.errors import DrillTwinError, printable, words_cut
from drill_twin.core.process import (
    end_process,
    error_text,
    open_closed_streams,
    refuse_too_little_memory,
    use_one_thread_of_blas,
)

_LONGEST_MESSAGE = 3000
_MADE = 100_000
"""Objects made before garbage is sought. With Python's 700, 0.1 s of a start go by, among modules that stay."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and end the process with its exit code."""
    gc.set_threshold(_MADE)
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
        print(f"drill-twin: stopped{stopped.kept and f'; {stopped.kept}'}", file=sys.stderr)
        return stopped.exit_code


def _run_command(arguments: Sequence[str]) -> int:
    try:
        refuse_too_little_memory()
    except DrillTwinError as error:
        return _fail(str(error), code=1)
    from typer import Abort
    from typer.main import get_command

    from drill_twin.cli.app import app

    try:
        code = get_command(app).main(list(arguments), prog_name="drill-twin", standalone_mode=False)
    except DrillTwinError as error:
        return _fail(str(error), error.exit_code)
    except BrokenPipeError:
        raise
    except (OSError, MemoryError) as error:
        return _fail(error_text(error), code=1)
    except Abort:
        return _fail("expected an answer to the question, found the end of the input; give it as an option")
    except Exception as error:
        if not hasattr(error, "format_message"):  # usage errors have one in every version of typer and click
            raise
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "drill-twin"
        message, name = _shaped(error.format_message(), arguments), getattr(error, "option_name", "")
        if context and name in ("--wob", "--rpm") and any("--set" in known.opts for known in context.command.params):
            message = f'expected another option, found {name}; did you mean --set "{name[2:]}=..."?'
        return _fail(f"{message}; see `{command} --help`")
    return int(code or 0)


_SHAPES = (
    (r"([^:]*): (?:Value error, )?(?:\1: )?(expected .*)", r"\1: \2"),
    (r"([^:]*): .* is not one of (?:'', )?(.*)", r"\1: expected one of \2, found {found}"),
    (r"([^:]*): Input should be a valid ([^,]*).*", r"\1: expected a valid \2, found {found}"),
    (r"([^:]*): Input should be (.*)", r"\1: expected a number \2, found {found}"),
    (r"([^:]*): .* is not (a valid|in the range) (.*)", r"\1: expected a number \2 \3, found {found}"),
    (r"Missing (?:argument|option|parameter) '?([^']+)'?.*", r"expected \1, found nothing"),
    (r"No such option: (\S+) \(Possible options: (.*)\)", r"expected another option, found \1; did you mean \2?"),
    (r"No such option: (\S+?)[.;]? Did you mean (.*)\?", r"expected another option, found \1; did you mean \2?"),
    (r"No such option: (\S+)", r"expected another option, found \1"),
    (r"Got unexpected extra arguments?(?:\(s\))? \((.*)\)", r"expected no further argument, found \1"),
    (r"Option '?([^' ]+)'? requires an argument.*", r"\1: expected a value, found nothing"),
    (r"Option '?([^' ]+)'? does not take a value.*", r"\1: expected no value, found one"),
)
"""Messages of typer and of click, in all their versions, and the shape of ours."""


def _shaped(message: str, arguments: Sequence[str]) -> str:
    """Message on a wrong option or argument in the shape of all others."""
    option, quote, rest = message.rstrip(".").removeprefix("Invalid value for '").partition("': ")
    text = f"{option}: {rest}" if quote else option
    for pattern, shape in _SHAPES:
        if match := re.fullmatch(pattern, text, re.DOTALL):
            found = next((given for name, given in pairwise(arguments) if name == match[1]), "another value")
            return match.expand(shape).replace("{found}", found)
    return text


def _fail(message: str, code: int = 2) -> int:
    text = printable(words_cut(" ".join(message.split())))
    shown = text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."
    print(f"drill-twin: error: {shown}", file=sys.stderr)
    return code
