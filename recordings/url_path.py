"""Paths on object stores and other file systems that fsspec knows, with the part of pathlib that a dataset needs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import IO, Any, TypeAlias
from uuid import uuid4

from scenarios.errors import InputError

WHOLE_PUTS = frozenset({"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "adl", "oss", "memory"})
"""Protocols on which a file appears whole; elsewhere it is put under another name and moved."""
LOCAL = frozenset({"file", "local"})


@dataclass(frozen=True)
class UrlPath:
    """A file or folder by its URL, such as `s3://bucket/dataset`; the protocol's package must be installed."""

    url: str

    def __str__(self) -> str:
        return self.url

    def __truediv__(self, name: str) -> UrlPath:
        return UrlPath(f"{self.url.rstrip('/')}/{name}") if name else self

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.url.rstrip("/").rpartition("/")[2]

    @property
    def parent(self) -> UrlPath:
        """The folder of the path."""
        return UrlPath(self.url.rstrip("/").rpartition("/")[0])

    def exists(self) -> bool:
        """Whether a file or folder is there."""
        system, path = self._found()
        return bool(system.exists(path))

    def is_file(self) -> bool:
        """Whether a file is there."""
        system, path = self._found()
        return bool(system.isfile(path))

    def is_dir(self) -> bool:
        """Whether a folder is there."""
        system, path = self._found()
        return bool(system.isdir(path))

    def iterdir(self) -> Iterator[UrlPath]:
        """Yield the files and folders of a folder."""
        system, path = self._found()
        return (self / one.rstrip("/").rpartition("/")[2] for one in system.ls(path, detail=False))

    def glob(self, pattern: str) -> Iterator[UrlPath]:
        """Yield the files of a folder whose names end as a pattern `*END`."""
        return (one for one in self.iterdir() if one.name.endswith(pattern.lstrip("*")))

    def mkdir(self, parents: bool = True, exist_ok: bool = True) -> None:
        """Make the folder; object stores have none."""
        system, path = self._found()
        system.makedirs(path, exist_ok=exist_ok)

    def unlink(self) -> None:
        """Remove the file."""
        system, path = self._found()
        system.rm_file(path)

    def open(self, mode: str = "rb") -> IO[bytes]:
        """Open the file for reading."""
        system, path = self._found()
        opened: IO[bytes] = system.open(path, mode)
        return opened

    def stat(self) -> SimpleNamespace:
        """Return the size, `st_size`."""
        system, path = self._found()
        return SimpleNamespace(st_size=int(system.size(path)))

    def read_text(self, encoding: str = "utf-8") -> str:
        """Return the text of the file."""
        with self.open() as file:
            return file.read().decode(encoding)

    def relative_to(self, folder: UrlPath) -> PurePosixPath:
        """Return the path as seen from a folder above."""
        return PurePosixPath(self.url.removeprefix(folder.url.rstrip("/") + "/"))

    @contextmanager
    def replaced(self, part: str) -> Iterator[Path]:
        """Yield a local file, which becomes the file at the URL, whole, when the block succeeds."""
        system, path = self._found()
        with TemporaryDirectory(prefix="magbench-") as place:
            local = Path(place) / self.name
            yield local
            if self.url.partition("://")[0] in WHOLE_PUTS:
                system.put_file(str(local), path)
                return
            aside = f"{path}.{uuid4().hex}{part}"
            system.put_file(str(local), aside)
            system.mv(aside, path)

    def _found(self) -> tuple[Any, str]:
        """Return the file system and the path in it; InputError for an unknown protocol or a missing package."""
        try:
            from fsspec.core import url_to_fs

            system, path = url_to_fs(self.url, use_listings_cache=False)
        except (ImportError, ValueError) as error:
            do = "install the package of the protocol, such as s3fs, with magbench[cluster]"
            raise InputError(" ".join(str(error).split())[:200], where=self.url, do=do) from None
        return system, str(path)


Place: TypeAlias = Path | UrlPath
"""A file or folder on this machine or on a file system of fsspec."""


def place_at(text: str) -> Place:
    """Return the place that a user names: a URL with `://`, else a path; `file://` is a path too."""
    protocol, mark, rest = text.partition("://")
    if not mark or protocol in LOCAL:
        return Path(rest if mark else text)
    return UrlPath(text.rstrip("/"))


@contextmanager
def arrow_source(path: Place) -> Iterator[Any]:
    """Yield what Arrow reads: the path, or an open file."""
    if isinstance(path, Path):
        yield path
        return
    with path.open() as file:
        yield file
