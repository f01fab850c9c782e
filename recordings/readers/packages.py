"""Logs of several text tables: the files of a zip archive or of a directory, with limits on what is unpacked."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import pyarrow as pa

from recordings.files import system_errors_about
from recordings.readers.damage import library_errors_about
from recordings.readers.text.encoding import decoded
from recordings.readers.text.reading import read_decoded
from scenarios.errors import InputError
from scenarios.text import figure

ZIP = b"PK\x03\x04"
MOST_FILES, MOST_BYTES = 1000, 400_000_000
"""Files of a package, and bytes of all its tables, unpacked."""
LEAST_UNPACKED, MOST_RATIO = 60_000_000, 15
"""Bytes that the tables of an archive may hold, or this multiple of its size where more: text of measured numbers is
compressed to a fourth to a tenth."""
STEP = 1 << 20
SUFFIX = ".csv"


@dataclass(frozen=True)
class TablePackage:
    """The text tables of a package by their paths within it; `read` returns the bytes of one.

    path : the archive or directory, for messages. size : of all tables in bytes, unpacked. packed : whether an archive.
    """

    path: Path
    members: tuple[str, ...]
    size: int
    read: Callable[[str], bytes]
    packed: bool = False

    def check_size(self) -> None:
        """Raise InputError for more files or bytes than are unpacked."""
        if len(self.members) > MOST_FILES or self.size > MOST_BYTES:
            most = f"at most {MOST_FILES} of {figure(MOST_BYTES / 1e6)} MB are read"
            what = f"holds {len(self.members)} tables of {figure(self.size / 1e6)} MB together, {most}"
            raise InputError(what, where=str(self.path), do="give a shorter recording")
        packed = self.path.stat().st_size
        if self.packed and self.size > max(LEAST_UNPACKED, MOST_RATIO * packed):
            what = f"expands to {figure(self.size / 1e6)} MB, more than {MOST_RATIO} times its size"
            raise InputError(what, where=str(self.path), do="give a shorter recording")

    @property
    def folders(self) -> tuple[str, ...]:
        """The folders with tables; "" is the package's own."""
        return tuple(dict.fromkeys(map(_folder, self.members)))

    def folder_of(self, names: Set[str]) -> str:
        """Return the folder with a table of one of these names; InputError for several, "" for none."""
        found = [folder for folder in self.folders if names & self.tables(folder).keys()]
        if len(found) > 1:
            what = f"holds {len(found)} recordings: {', '.join(found[:5])}"
            raise InputError(what, where=str(self.path), do="unpack it, and give one of the directories")
        return found[0] if found else ""

    def tables(self, folder: str) -> Mapping[str, str]:
        """Return the paths of a folder's tables by their names in lower case without suffix."""
        return {_stem(name): name for name in self.members if _folder(name) == folder}

    def table(self, member: str) -> pa.Table | None:
        """Return a table as the text reader gives it; None for one that holds no rows of numbers."""
        with library_errors_about(self.path, "zip archive"):
            data = self.read(member)
        try:
            return read_decoded(self.path / member, decoded(data), lambda name: True).table if data else None
        except InputError:
            return None

    def words(self, member: str) -> Mapping[str, str]:
        """Return the first row of a table of words by the names of its columns, in lower case; empty for none."""
        with library_errors_about(self.path, "zip archive"):
            text = decoded(self.read(member)).data.decode("utf-8", "replace")
            row = next(csv.DictReader(io.StringIO(text)), {})
        return {str(name).lower(): str(cell).lower() for name, cell in row.items()}


def archive(path: Path) -> TablePackage:
    """Return the package of a zip archive; InputError for a damaged archive."""
    with library_errors_about(path, "zip archive"), zipfile.ZipFile(path) as file:
        found = [one for one in file.infolist() if _is_table(one.filename)]
    size = sum(one.file_size for one in found)

    def read(member: str) -> bytes:
        with zipfile.ZipFile(path) as file, file.open(member) as part:
            return b"".join(iter(lambda: part.read(STEP), b""))  # the library ends at the size that the archive states

    return TablePackage(path, tuple(one.filename for one in found), size, read, packed=True)


def directory(path: Path, *folders: str) -> TablePackage:
    """Return the package of a directory's own tables, and of those in some of its folders."""
    with system_errors_about(path, "check the path and the permissions"):
        places = [path, *(path / folder for folder in folders if (path / folder).is_dir())]
        found = sorted(one for place in places for one in place.iterdir() if one.is_file() and _is_table(one.name))
        size = sum(one.stat().st_size for one in found)
    names = tuple(one.relative_to(path).as_posix() for one in found)
    return TablePackage(path, names, size, lambda member: (path / member).read_bytes())


def _is_table(name: str) -> bool:
    parts = PurePosixPath(name).parts
    hidden = any(part.startswith((".", "__MACOSX")) for part in parts)
    return name.lower().endswith(SUFFIX) and not hidden


def _stem(name: str) -> str:
    return PurePosixPath(name).stem.lower()


def _folder(name: str) -> str:
    parent = str(PurePosixPath(name).parent)
    return "" if parent == "." else parent
