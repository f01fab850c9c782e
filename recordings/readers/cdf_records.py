"""The chain of internal records of a CDF 3 file, walked before a library follows it: no circle, no count too large.

Offsets of fields are those of the CDF Internal Format Description, version 3: every record begins with its size (8
bytes) and type (4 bytes), numbers are big-endian.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

HEADER = 8
"""Bytes of the mark and of the kind of compression."""
WHOLE, COMPRESSED = b"\x00\x00\xff\xff", b"\xcc\xcc\x00\x01"
"""The second four bytes of a file: not compressed, or one gzip stream."""
STREAM_AT = 40
"""The first byte of the stream of a compressed file, behind the header and the record's own fields."""
GZIP = b"\x1f\x8b\x08"
STEP = 4096
"""Bytes of a stream that are decompressed at once: a stream of some bytes costs no copy of the whole file."""
MOST_COUNT = 10_000
"""Variables, attributes and entries of a file; the specification's largest number of dimensions is 10."""
MOST_DIMENSIONS = 10
MOST_RECORDS = 100_000
INDEX = 6
"""The type of a record of a variable's index, VXR."""


class DamagedCdfError(Exception):
    """A CDF file whose internal records contradict each other, or are larger than what is read."""


def inflated(data: bytes, most: int) -> bytes:
    """Return a gzip stream decompressed, as far as whole; DamagedCdfError for more than `most` bytes."""
    return b"".join(_pieces(data, Expanded(most)))


@dataclass
class Expanded:
    """The bytes that may still pass through the decompressor."""

    most: int
    spent: int = 0

    def spend(self, size: int) -> None:
        """Count bytes; DamagedCdfError for more than `most`."""
        self.spent += size
        if self.spent > self.most:
            raise DamagedCdfError(f"more than {self.most} bytes are compressed in it")


def _pieces(data: bytes | memoryview, expanded: Expanded) -> Iterator[bytes]:
    """Yield a gzip stream decompressed, as far as whole, piece by piece."""
    stream = zlib.decompressobj(31)
    try:
        for at in range(0, len(data), STEP):
            expanded.spend(min(STEP, len(data) - at))
            rest = bytes(data[at : at + STEP])
            while rest and not stream.eof:
                piece = stream.decompress(rest, 1 << 20)
                expanded.spend(len(piece))
                yield piece
                rest = stream.unconsumed_tail
            if stream.eof:
                return
    except zlib.error:
        return  # the mark of a stream may stand in numbers


def check_records(data: bytes, most: int) -> None:
    """Raise DamagedCdfError for records that no reader can follow, and for more than `most` bytes decompressed."""
    if data[4:HEADER] == COMPRESSED:
        data = data[:HEADER] + inflated(data[STREAM_AT:], most)
    expanded, at = Expanded(most), data.find(GZIP)
    while at >= 0:
        for _ in _pieces(memoryview(data)[at:], expanded):
            pass
        at = data.find(GZIP, at + 1)
    walk = _Walk(data)
    gdr = walk.number(HEADER + 12, 8)
    walk.below(gdr + 56, MOST_DIMENSIONS)
    walk.below(gdr + 44, MOST_COUNT)
    for adr in walk.chain(walk.number(gdr + 28, 8), walk.below(gdr + 48, MOST_COUNT)):
        walk.spend(walk.below(adr + 36, MOST_COUNT) + walk.below(adr + 56, MOST_COUNT))
    for vdr in walk.chain(walk.number(gdr + 20, 8), walk.below(gdr + 60, MOST_COUNT)):
        walk.below(vdr + 340, MOST_DIMENSIONS)
        walk.index(walk.number(vdr + 28, 8))


@dataclass
class _Walk:
    """The numbers of a file by their offsets, and the records that have been visited."""

    data: bytes
    seen: set[int] = field(default_factory=set)
    spent: int = 0

    def number(self, at: int, size: int) -> int:
        """Return the number of `size` bytes at an offset."""
        if not 0 <= at <= len(self.data) - size:
            raise DamagedCdfError("a record lies beyond the end")
        return int.from_bytes(self.data[at : at + size], "big", signed=True)

    def below(self, at: int, most: int) -> int:
        """Return the count of 4 bytes at an offset."""
        count = self.number(at, 4)
        if not 0 <= count <= most:
            raise DamagedCdfError(f"a count is {count}")
        return count

    def spend(self, records: int) -> None:
        """Count records that a reader would follow."""
        self.spent += records
        if self.spent > MOST_RECORDS:
            raise DamagedCdfError(f"it has more than {MOST_RECORDS} records")

    def visit(self, at: int) -> None:
        """Count a record that stands in one place of the file alone."""
        if at in self.seen:
            raise DamagedCdfError("its records lead in a circle")
        self.seen.add(at)
        self.spend(1)

    def chain(self, at: int, count: int) -> Iterator[int]:
        """Yield the records of a chain, whose next offset stands behind size and type."""
        for _ in range(count):
            self.visit(at)
            yield at
            at = self.number(at + 12, 8)

    def index(self, head: int) -> None:
        """Visit the records of a variable's index and of its values; a head of 0 or -1 is a variable without any."""
        waiting = [head]
        while waiting:
            at = waiting.pop()
            if at <= 0:
                continue
            self.visit(at)
            entries = self.below(at + 20, len(self.data) // 16)
            used = self.below(at + 24, entries)
            offsets = [self.number(at + 28 + 8 * entries + 8 * k, 8) for k in range(used)]
            for offset in offsets:
                if self.number(offset + 8, 4) == INDEX:
                    waiting.append(offset)
                else:
                    self.visit(offset)
            waiting.append(self.number(at + 12, 8))
