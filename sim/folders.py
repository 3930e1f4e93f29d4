"""Whether results can be written, found out before anything is computed."""

import tempfile
from pathlib import Path

from sim.errors import InputError


def require_writable(folder: Path, key: str) -> None:
    """Make sure that files can be created in ``folder``, now or once it has been made.

    Nothing stays behind: the folder itself is not made.

    Parameters
    ----------
    folder : Path
        The folder; it and its parents need not exist.
    key : str
        What named it, for the message.

    Raises
    ------
    InputError
        When it, or the nearest of its parents that exists, is no folder or refuses a file.
    """
    nearest = folder.absolute()
    while not (nearest.exists() or nearest.is_symlink()) and nearest != nearest.parent:
        nearest = nearest.parent
    try:
        # Permission bits do not tell: root ignores them, read-only and full file systems too.
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except NotADirectoryError:
        reason = f"{nearest} is not a folder"
    except OSError as error:
        reason = f"{nearest}: {error.strerror or error}"
    else:
        return
    raise InputError.of_value(key, "", str(folder), f"a folder that can be written ({reason})")
