"""What a bag's compressed parts may expand to: bounded decompression in place of the library's."""

from __future__ import annotations

import bz2
import io
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO

from recordings.readers.base import library
from scenarios.errors import InputError

EXTRA = "ros"
"""The optional extra that the library comes with."""
MOST_CHUNK_BYTES = 200_000_000
"""Bytes that one compressed chunk or message may hold: recorders write chunks of 1 to 4 MB, or of one picture."""
LEAST_TOTAL_BYTES, MOST_RATIO = 30_000_000, 30
"""Bytes that all of a bag may expand to, or this multiple of the bag's size where more: sensors' messages are
compressed three to ten times."""
STEP_BYTES = 1 << 20
INDEX_ENTRY_BYTES, MOST_INDEXED = 12, 5_000_000
"""Bytes of an entry of a ROS 1 index, and the most entries: some 100 bytes of memory each."""
FEWER = "give a bag of the magnetometer's and the vehicle's topics alone"
Decompressor = Callable[[], Any]


@dataclass
class Expansion:
    """The bytes that the compressed parts of a bag may still expand to; `path` is for messages."""

    path: Path
    left: int
    indexed: int = 0

    def expand(self, data: bytes, new: Decompressor, most: int = MOST_CHUNK_BYTES) -> bytes:
        """Return the frames of a compressed part decompressed; InputError for more bytes than are read.

        new : makes an object with `decompress(data, max_length)`, `eof` and `unused_data`, as `bz2.BZ2Decompressor`.
        Raises ValueError for a part that ends early.
        """
        most, parts, size = min(most, self.left), list[bytes](), 0
        while data:
            frame = new()
            while not frame.eof:
                parts.append(frame.decompress(data, min(STEP_BYTES, most + 1 - size)))
                data, size = b"", size + len(parts[-1])
                if size > most:
                    raise self.refusal()
                if not parts[-1] and not frame.eof:
                    raise ValueError("compressed data end early")
            data = frame.unused_data or b""
        self.left -= size
        return b"".join(parts)

    def of(self, new: Decompressor) -> Callable[..., bytes]:
        """Return the function (data, size that is stated) -> data decompressed."""
        return lambda data, size=MOST_CHUNK_BYTES: self.expand(data, new, min(size, MOST_CHUNK_BYTES))

    def copied(self, data: bytes) -> bytes:
        """Return a chunk that is not compressed; counted, since entries of an index may call it again and again."""
        self.spend(len(data))
        return data

    def index(self, size: int) -> None:
        """Count bytes of a ROS 1 index; InputError for more messages than are read."""
        self.indexed += size
        if self.indexed > INDEX_ENTRY_BYTES * MOST_INDEXED:
            what = f"its index lists more than {MOST_INDEXED:.3g} messages"
            raise InputError(what, where=str(self.path), do=FEWER)

    def spend(self, size: int) -> None:
        """Count bytes that were expanded elsewhere; InputError for more than are left."""
        self.left -= size
        if self.left < 0:
            raise self.refusal()

    def refusal(self) -> InputError:
        """Return the error for a bag that expands to more than is read."""
        what = f"its compressed parts expand to more than {MOST_RATIO} times the bag"
        return InputError(what, where=str(self.path), do=FEWER)


class _Counted(io.RawIOBase):
    """A decompressing file whose bytes are counted while the library copies them to a file of its own."""

    def __init__(self, file: BinaryIO, expansion: Expansion) -> None:
        self._file, self._expansion = file, expansion

    def read(self, size: int = -1) -> bytes:
        data = self._file.read(STEP_BYTES if size < 0 else size)
        self._expansion.spend(len(data))
        return data

    def close(self) -> None:
        self._file.close()
        super().close()


def bag_size(path: Path) -> int:
    """Return the bytes of a bag's file, or of all files beside its metadata."""
    files = path.parent.iterdir() if path.suffix == ".yaml" else (path,)
    return sum(one.stat().st_size for one in files if one.is_file())


@contextmanager
def bounded_expansion(path: Path) -> Iterator[Expansion]:
    """Within, the library decompresses no more than is read of a bag at this path.

    The library has its decompressors in tables of its modules, which this replaces and then restores.
    """
    from rosbags.rosbag1 import reader as first
    from rosbags.rosbag2 import reader as second
    from rosbags.rosbag2 import storage_mcap as mcap

    lz4 = library(path, "lz4.frame", EXTRA).LZ4FrameDecompressor
    bounded, zstd = Expansion(path, max(LEAST_TOTAL_BYTES, MOST_RATIO * bag_size(path))), mcap.zstd
    old = {"none": bounded.copied, "bz2": bounded.of(bz2.BZ2Decompressor), "lz4": bounded.of(lz4)}
    new = {"lz4": bounded.of(lz4), "zstd": bounded.of(zstd.ZstdDecompressor)}
    files = SimpleNamespace(
        decompress=bounded.of(zstd.ZstdDecompressor),
        open=lambda *arguments: _Counted(zstd.open(*arguments), bounded),
        ZstdError=zstd.ZstdError,
    )
    with ExitStack() as stack:
        for table, entries in ((first.decompressors, old), (mcap.DECOMPRESSORS, new), (vars(second), {"zstd": files})):
            stack.enter_context(_replaced(table, entries))
        yield bounded


@contextmanager
def _replaced(table: dict[str, Any], entries: dict[str, Any]) -> Iterator[None]:
    """Within, some entries of a table are others."""
    before = {name: table[name] for name in entries}
    table.update(entries)
    try:
        yield
    finally:
        table.update(before)


def bound_index(reader: Any, bounded: Expansion) -> None:
    """Let a ROS 1 reader that is not yet open count its index, as often as entries of the bag point at it."""
    read: Callable[..., None] | None = getattr(reader, "read_index_data", None)
    if read is not None:
        reader.read_index_data = _counted(read, reader, bounded)


def _counted(read: Callable[..., None], reader: Any, bounded: Expansion) -> Callable[..., None]:
    def counted(*arguments: Any) -> None:
        start = reader.bio.tell()
        read(*arguments)
        bounded.index(reader.bio.tell() - start)

    return counted


def chunk_by_chunk(reader: Any) -> None:
    """Let an open reader of MCAP hold one chunk at a time, whatever times the chunks claim.

    The messages then come in the order of the chunks.
    """
    storage = getattr(reader, "storage", None)
    for one in getattr(storage, "storages", [storage]):
        if getattr(one, "chunks", None):
            one.messages = _one_at_a_time(one, one.messages)


def _one_at_a_time(storage: Any, messages: Callable[..., Iterator[Any]]) -> Callable[..., Iterator[Any]]:
    def each(*arguments: Any) -> Iterator[Any]:
        for chunk in list(storage.chunks):
            storage.chunks = [chunk]
            yield from messages(*arguments)

    return each
