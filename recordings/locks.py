"""Exclusive locks between processes on files and directories; no lock outlives its process or leaves a file behind.

The lock itself is the `filelock` package's lock on an open descriptor (`flock` on POSIX systems, `LockFileEx` on
Windows). The package's path locks do not serve: they need a lock file, which stays in the directory on POSIX
systems. What the descriptor belongs to depends on the system:

- POSIX systems lock the file or directory itself.
- Windows opens no directory and lets nobody write a locked file: the lock is on a file `NAME.magbench-lock` next to
  NAME, opened with O_TEMPORARY, which Windows removes with the last descriptor, however the process ends.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

LOCK = ".magbench-lock"
LOCK_ATTEMPTS = 100
"""Attempts, in each of which the previous holder may remove the file, before the file counts as missing."""
ON_WINDOWS = os.name == "nt"


def lock(path: Path, flags: int, held: Exception, make: Callable[[], object] = lambda: None) -> int:
    """Return a descriptor that holds the lock of `path` until the descriptor is closed.

    flags : of `os.open`. make : called before each attempt to open.
    Raises `held` where another process holds the lock, OSError where the system refuses to open.

    The previous holder may remove or rename the file between our opening and locking it: then the descriptor belongs
    to a file that `path` no longer names, and the next attempt begins.
    """
    target = path
    if ON_WINDOWS:
        target = Path(f"{path.resolve()}{LOCK}")
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_TEMPORARY", 0)
    for _ in range(LOCK_ATTEMPTS):
        with suppress(FileNotFoundError):
            make()
            descriptor = os.open(target, flags, 0o666)
            if not _taken(descriptor):
                os.close(descriptor)
                raise held
            if os.path.samestat(os.fstat(descriptor), os.stat(target)):
                return descriptor
            os.close(descriptor)
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))


def _taken(descriptor: int) -> bool:
    """Return whether no other process holds the lock; some network file systems have no locks, and go without."""
    from filelock import lock_descriptor  # here: reading needs no lock, and the import takes 50 ms

    try:
        return lock_descriptor(descriptor, blocking=False)
    except OSError:
        return True
