"""The program: ``talus COMMAND``, or ``python -m sim COMMAND``.

`sim.base.command_line` reads the command. Here its function is called, and what that answers or
raises becomes output and exit code.
"""

import sys

if __name__ == "__main__" and not sys.flags.safe_path:
    # Python looks first in the present folder, whose modules are not the program's. The folder of
    # the package comes last instead, for processes that this one starts.
    del sys.path[0]
    from pathlib import Path

    sys.path.append(str(Path(__file__).absolute().parents[1]))

import errno
import io
import logging
import os
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

from sim.base.command_line import COMPLETE, INPUT_ERROR, parse
from sim.base.errors import InputError, printable
from sim.base.program import __version__, program

SYSTEM_ERROR = 1
INTERRUPTED = 130
BROKEN_PIPE = 141

#: What the program says where it is called without a command.
START = """\
Talus {version}: parameter studies of granular flow

  {program} init my-study.yaml      write a study file to start from
  {program} points my-study.yaml    list its points and what they cost
  {program} study my-study.yaml     run it, up to the report in results/
  {program} -h                      list all commands
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    ``arguments`` are those of the command line without the program's name. The code is 0 on
    success, 2 after a one-line message on standard error for unusable input, 3 from ``run`` for a
    run that failed, 130 after an interrupt; 143 from a ``run`` that saved its state first.
    """
    for stream in (sys.stdout, sys.stderr):
        # Characters that a terminal cannot show are escaped, instead of an error.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # A log that cannot be written, as on a full disk, is no reason for a traceback.
    logging.raiseExceptions = False
    # Nothing is shown in a window.
    os.environ.pop("MPLBACKEND", None)
    words = sys.argv[1:] if arguments is None else arguments
    if not words and COMPLETE not in os.environ:
        print(START.format(version=__version__, program=program()), end="", file=sys.stderr)
        return INPUT_ERROR
    try:
        options = parse(words)
        code = _call(options.pop("function"), options)
        if sys.stdout:
            sys.stdout.flush()
        return code
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return INPUT_ERROR
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        _flush_or_discard()
        return BROKEN_PIPE
    except (OSError, MemoryError, BrokenExecutor) as error:
        _flush_or_discard()
        print(f"error: {str(error) or 'out of memory'}", file=sys.stderr)
        # A name that no file system takes comes from the command line.
        is_name = isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG
        return INPUT_ERROR if is_name else SYSTEM_ERROR
    except Exception as error:
        from sim.base.additions import plugin_code_error

        if input_error := plugin_code_error(error):
            print(f"error: {input_error}", file=sys.stderr)
            return INPUT_ERROR
        raise


def _flush_or_discard() -> None:
    """Write what was printed, or discard it, so that the interpreter's last flush cannot fail."""
    try:
        if sys.stdout:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _call(function: str, options: dict[str, Any]) -> int:
    """Call the function of a command, print its result, and return the exit code."""
    # Imported here, as help and the completion of a line need no plug-in.
    from sim.base.plugins import load_from_environment

    load_from_environment()
    answer = resolve_name(function)(**options)
    if isinstance(answer, int):
        return answer
    if answer is not None:
        # Files from elsewhere may contain control sequences of terminals.
        lines = answer if isinstance(answer, list) else [answer]
        print(*(printable(str(line)) for line in lines), sep="\n")
    return 0


def warm(study_path: Path | None, processes: int, clean: bool) -> str | None:
    """Compile the code for the points of a study, or of all systems; or remove compiled code."""
    from sim.engine import command, identity
    from sim.parameters import SYSTEMS
    from sim.study.load import load_study

    if clean:
        return identity.remove_cache()
    points = [model() for model in SYSTEMS.values() if model.is_flow]
    if study_path is not None:
        points = [point.parameters for point in load_study(study_path, None).points.values()]
    logging.basicConfig(format="%(message)s", level=logging.INFO, stream=sys.stderr)
    command.warm(points, processes)
    return None


if __name__ == "__main__":
    raise SystemExit(main())
