"""The private folder of a run for its Unix sockets: where it may be, and who makes it."""

from __future__ import annotations

import os
import re
import secrets
import stat
import tempfile
from pathlib import Path
from typing import Final

# sockaddr_un holds 108 bytes with the zero at their end.
_MOST_BYTES: Final = 107
_LONGEST_NAME: Final = "channel"
# To Zenoh `#` and `?` end the path of an endpoint: the socket would be somewhere else.
_PLAIN: Final = re.compile(r"[\w/.,:+@~ -]+", re.ASCII)
_ELSEWHERE: Final = ("/tmp", "/var/tmp", "/dev/shm")  # private folders within them


def socket_folder() -> Path:
    """Path of a new folder where sockets may be; raises OSError where there is no place for one.

    Nothing is made yet: a command that is killed before its processes start leaves nothing behind.
    The place is TMPDIR, or another one where paths of sockets would be too long or be misread.
    """
    name = f"zenvoy-{secrets.token_hex(6)}"
    places = [tempfile.gettempdir(), os.environ.get("XDG_RUNTIME_DIR", ""), *_ELSEWHERE]
    for place in places:
        folder = Path(os.path.abspath(place)) / name
        if place and _serves(folder) and os.access(folder.parent, os.W_OK | os.X_OK):
            return folder
    raise OSError(
        f"no folder for Unix sockets, whose paths are at most {_MOST_BYTES} bytes long and hold no "
        f"# or ?; tried {', '.join(dict.fromkeys(place for place in places if place))}"
    )


def make_private(folder: Path) -> None:
    """Make the folder for this user alone, or see that it is; raises OSError.

    Whoever listens in it calls this first, in whatever order they start.
    """
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        found = folder.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid() or found.st_mode & 0o077:
            raise


def _serves(folder: Path) -> bool:
    path = str(folder / _LONGEST_NAME)
    return len(os.fsencode(path)) <= _MOST_BYTES and _PLAIN.fullmatch(path) is not None
