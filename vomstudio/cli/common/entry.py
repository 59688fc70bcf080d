"""Entry point, which runs a command line and returns its exit code.

Commands import their libraries only when they are needed.
"""

from __future__ import annotations

import importlib
import itertools
import logging
import os
import sys
import time
import traceback
import warnings
from collections.abc import Sequence

from vomstudio.cli.common.arguments import HelpRequested, Parser
from vomstudio.cli.common.first_word import COMMANDS, check_first_word
from vomstudio.cli.common.global_options import (
    GLOBAL_OPTIONS,
    add_global_options,
    run_global_option,
)
from vomstudio.cli.common.output import Channel, Output, preserve_stdout, to_json
from vomstudio.cli.common.reporting import reporting
from vomstudio.cli.common.stop_signals import interrupt_on_stop_signals
from vomstudio.core.errors import Cancelled, InputError, VomError
from vomstudio.core.failures import (
    log,  # noqa: F401 - without a log nothing of it reaches stderr
    stop_requests,
)
from vomstudio.core.failures.missing_libraries import missing_library
from vomstudio.core.files import memory_limit
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; this function never raises exceptions."""
    arguments = [_expand_home(word) for word in (sys.argv[1:] if argv is None else argv)]
    memory_limit.enable_limits()
    with preserve_stdout() as channel, interrupt_on_stop_signals():
        try:
            return _run(arguments, channel)
        except BrokenPipeError:  # `| head` has read enough
            return 0
        except KeyboardInterrupt:  # while writing
            return Cancelled.exit_code
        except VomError as error:  # stdout itself could not be written
            return _report_failure(error, None, Output(writes_json=False))


def _expand_home(word: str) -> str:
    """Expand a leading `~` of a word or option value, unless a file of that name exists."""
    option, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
    if value != "~" and not value.startswith("~/"):
        return word
    return word if os.path.lexists(value) else option + equals + os.path.expanduser(value)


def _has_json_progress(arguments: Sequence[str]) -> bool:
    return "--progress=json" in arguments or ("--progress", "json") in itertools.pairwise(arguments)


def _run(arguments: list[str], channel: Channel) -> int:
    start_time_s = time.monotonic()
    # Read before parsing so that parsing errors have the requested form.
    output = Output(writes_json="--json" in arguments, json_events=_has_json_progress(arguments))
    failure: VomError | None = None
    is_debug = os.environ.get("VOMSTUDIO_DEBUG", "") not in ("", "0")
    try:
        with warnings.catch_warnings():
            if not is_debug:
                # Warnings of libraries are intended for programmers; users get findings.
                warnings.simplefilter("ignore")
            check_first_word(arguments)
            args = build_parser(arguments).parse_args(arguments)
            stop_requests.check()
            output.quiet, output.shows_codes = args.quiet, args.verbose
            with reporting(
                is_quiet=args.quiet,
                is_verbose=args.verbose,
                json_events=output.writes_events,
                start_time_s=start_time_s,
            ) as args.reporter:
                args.run(args, output)
            stop_requests.check()
        text = output.stdout_text()
    except HelpRequested as wanted:
        channel.write(f"{wanted}\n")
        return 0
    except KeyboardInterrupt:
        failure = Cancelled()
    except Exception as error:  # noqa: BLE001 - the promise is a sentence, never a traceback
        # If an import is interrupted, the installation would appear to be broken.
        failure = Cancelled() if stop_requests.is_requested() else _to_vom_error(error)
        if is_debug:
            traceback.print_exception(error)
    if failure is not None:
        return _report_failure(failure, channel if output.writes_json else None, output)
    _write_stderr(output.stderr_text())
    channel.write(text)
    return InputError.exit_code if output.has_failed else 0


class _InternalError(VomError):
    exit_code = 1


def _to_vom_error(error: Exception) -> VomError:
    match error:
        case VomError():
            return error
        case ImportError() if (finding := missing_library(error)) is not None:
            return VomError(finding)
        case MemoryError():
            remedy = tr("Close other programs and try again.")
            return _InternalError(Finding("job.out-of-memory", remedy=remedy))
        case OSError():
            return _convert_os_error(error)
    logging.getLogger(__name__).error("an internal error", exc_info=error)
    return _InternalError(
        Finding("command.internal-error", type=type(error).__name__, error=str(error))
    )


def _convert_os_error(error: OSError) -> VomError:
    finding = Finding("system.refused", reason=error.strerror or str(error))
    if isinstance(error, BrokenPipeError) or error.filename is None:
        return _InternalError(finding)
    name = os.fsdecode(error.filename) if isinstance(error.filename, bytes) else error.filename
    return InputError(finding, file=str(name))


def _report_failure(error: VomError, channel: Channel | None, output: Output) -> int:
    sentence = f"vomstudio: {' '.join(str(error).splitlines())}"
    _write_stderr(output.format_stderr_line(sentence, error=error.to_dict()) + "\n")
    if channel is not None:
        channel.write(to_json({"error": error.to_dict()}) + "\n")
    return error.exit_code


def _write_stderr(text: str) -> None:
    if text and sys.stderr is not None:
        try:
            sys.stderr.write(text)
            sys.stderr.flush()
        except OSError:  # stderr is closed, so the exit code must suffice
            pass


def build_parser(arguments: Sequence[str]) -> Parser:
    """Return a parser with the command named by the first word, or with all commands.

    Only the modules of these commands are imported; none if the first word is a global option.

    Parameters
    ----------
    arguments : sequence of str
        Words of the command line.

    Returns
    -------
    Parser
    """
    parser = Parser(
        prog="vomstudio",
        description=tr("Measure geological structures on virtual outcrop models."),
        epilog=tr("Without a command, the window opens: vomstudio [FILE or PROJECT]."),
    )
    add_global_options(parser)
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)
    command = arguments[0] if arguments else ""
    for name in [command] if command in COMMANDS else [] if command in GLOBAL_OPTIONS else COMMANDS:
        importlib.import_module(f"vomstudio.cli.{name}").add_parser(subparsers)
    parser.set_defaults(run=run_global_option, quiet=False, verbose=False)
    return parser
