"""The private folder of a run for its Unix sockets."""

from __future__ import annotations

import os
import re
import secrets
import stat
import tempfile
from pathlib import Path
from typing import Final

# sockaddr_un holds 108 bytes, including the zero at the end.
_MAX_BYTES: Final = 107
_LONGEST_NAME: Final = "channel"
# Zenoh ends the path of an endpoint at `#` or `?`, and would put the socket elsewhere.
_PLAIN: Final = re.compile(r"[\w/.,:+@~ -]+", re.ASCII)
_FALLBACKS: Final = ("/tmp", "/var/tmp", "/dev/shm")  # the folder itself is private


def socket_folder() -> Path:
    """Return the path of a new folder for sockets; raises OSError if there is no place for one.

    The folder is not made yet, so that a command killed before its processes start leaves nothing
    behind. It lies in TMPDIR, or elsewhere if socket paths there would be too long or misread.
    """
    name = f"zenvoy-{secrets.token_hex(6)}"
    places = [tempfile.gettempdir(), os.environ.get("XDG_RUNTIME_DIR", ""), *_FALLBACKS]
    for place in places:
        folder = Path(os.path.abspath(place)) / name
        if place and _is_usable(folder) and os.access(folder.parent, os.W_OK | os.X_OK):
            return folder
    raise OSError(
        f"no folder for Unix sockets, whose paths have at most {_MAX_BYTES} bytes and no # or ?; "
        f"tried {', '.join(dict.fromkeys(place for place in places if place))}"
    )


def make_private(folder: Path) -> None:
    """Make the folder for this user alone, or check that it is so already; raises OSError.

    World and channel may start in any order, and both call this before they listen in the folder.
    """
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid() or found.st_mode & 0o077:
            raise


def _is_usable(folder: Path) -> bool:
    path = str(folder / _LONGEST_NAME)
    return len(os.fsencode(path)) <= _MAX_BYTES and _PLAIN.fullmatch(path) is not None
