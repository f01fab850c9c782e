"""The messages of a ROS bag by topic, their numbers as columns: ROS 1 `.bag`, ROS 2 `.db3` and `.mcap`."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.readers.base import library
from recordings.readers.ros.expansion import EXTRA, bound_index, bounded_expansion, chunk_by_chunk
from recordings.readers.ros.fields import Layout, layout_of, needed_types
from recordings.readers.ros.mounts import TRANSFORMS, Mounts
from scenarios.arrays import Array
from scenarios.errors import InputError

ROS1_MARK, MCAP_MARK, SQLITE_MARK = b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\x00"
METADATA = "metadata.yaml"
"""The file by which a directory is a ROS 2 bag."""
METADATA_MARK = b"rosbag2_bagfile_information"
BLOCK = 4096
"""Messages of a topic that are held before they become arrays."""
MOST_WRONG = 100_000
"""Messages that cannot be decoded above which a bag is refused."""
MOST_LETTERS = 80
"""Letters of a text that are kept: a mode, a frame. Texts are arrays as wide as the longest."""
LATEST_NS = 2**62
"""Later times of receipt, in the year 2116, are damage."""
DAMAGE = (
    *(ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, MemoryError, OSError, RuntimeError),
    *(SyntaxError, TypeError, ValueError, struct.error),
)
"""Built-in exceptions that the library raises for damaged bags, besides those of its own."""
Stamps = NDArray[np.int64]
Damage = tuple[type[Exception], ...]


@dataclass(frozen=True, eq=False)
class Topic:
    """The messages of a topic, in the order of receipt.

    Parameters
    ----------
    kind : the type, as "sensor_msgs/msg/Imu".
    received_ns : (n,) when the recorder got each message. stamp_ns : (n,) `header.stamp`, 0 where not set.
    frames : (n,) `header.frame_id`, empty without a header.
    columns : name of a field, as "angular_velocity.x" -> (n,) numbers or words. A fixed array of numbers and a
        sequence are a column for each member, as "channels[0]", NaN where a message has fewer members.
    """

    name: str
    kind: str
    received_ns: Stamps
    stamp_ns: Stamps
    frames: NDArray[np.str_]
    columns: Mapping[str, NDArray[Any]]

    def vector(self, *names: str) -> Array:
        """Return fields as (n, k)."""
        return np.column_stack([self.columns[name].astype(np.float64) for name in names])

    def by_receipt(self) -> NDArray[np.intp]:
        """Return the order (n,) of receipt."""
        return np.argsort(self.received_ns, kind="stable")

    def rows(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> Topic:
        """Return some of the messages."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        return Topic(
            self.name, self.kind, self.received_ns[chosen], self.stamp_ns[chosen], self.frames[chosen], columns
        )


@dataclass(eq=False)
class _Collected:
    """The messages of a topic while a bag is read."""

    name: str
    kind: str
    layout: Layout
    received_ns: list[int] = field(default_factory=list)
    heads: list[Any] = field(default_factory=list)
    rows: list[tuple[Any, ...]] = field(default_factory=list)
    blocks: list[Array] = field(default_factory=list)
    words: dict[str, list[str]] = field(default_factory=dict)
    _numbers: Callable[[Any], tuple[Any, ...]] = field(init=False)
    _words: tuple[tuple[str, Callable[[Any], str]], ...] = field(init=False)

    def __post_init__(self) -> None:
        self._numbers = self.layout.getter()
        self._words = tuple((name, attrgetter(name)) for name in self.layout.words)
        self.words = {name: [] for name in self.layout.words}

    def add(self, received_ns: int, message: Any) -> None:
        """Take the numbers, the words and the header of a message; ValueError for an impossible time of receipt."""
        if not 0 <= received_ns < LATEST_NS:
            raise ValueError(f"received at {received_ns} ns")
        row = self._numbers(message)
        head = _head(message.header) if self.layout.stamped else (0, "")
        for name, get in self._words:
            self.words[name].append(get(message)[:MOST_LETTERS])
        self.rows.append(row)
        self.heads.append(head)
        self.received_ns.append(received_ns)
        if len(self.rows) >= BLOCK:
            self._flush()

    def _flush(self) -> None:
        if self.rows:
            self.blocks.append(self.layout.block(self.rows))
            self.rows = []

    def topic(self) -> Topic:
        """Return what was collected."""
        self._flush()
        names, values = self.layout.joined(self.blocks)
        columns: dict[str, NDArray[Any]] = dict(zip(names, values.T, strict=True))
        columns |= {name: np.array(words, np.str_) for name, words in self.words.items()}
        stamps = np.array([stamp for stamp, _ in self.heads], np.int64)
        frames = np.array([frame for _, frame in self.heads], np.str_)
        topic = Topic(self.name, self.kind, np.array(self.received_ns, np.int64), stamps, frames, columns)
        return topic if np.all(np.diff(topic.received_ns) >= 0) else topic.rows(topic.by_receipt())


def _head(header: Any) -> tuple[int, str]:
    """Return the stamp of a header in ns, and the frame."""
    return header.stamp.sec * 10**9 + header.stamp.nanosec, header.frame_id[:MOST_LETTERS]


@dataclass(frozen=True, eq=False)
class Bag:
    """The topics of a bag by name, a line for each thing that could not be read, and the mounts of its frames."""

    topics: Mapping[str, Topic]
    notes: tuple[str, ...] = ()
    mounts: Mounts = field(default_factory=Mounts)


def read_bag(path: Path, needed: Callable[[str, str, Layout], bool]) -> Bag:
    """Read the topics of a bag for which needed(name, type, layout) is true.

    A bag that is damaged in the middle gives the messages ahead of the damage. Raises InputError for a bag that cannot
    be opened.
    """
    first = library(path, "rosbags.rosbag1", EXTRA)
    second = library(path, "rosbags.rosbag2", EXTRA)
    old = path.suffix.lower() == ".bag"
    with bounded_expansion(path) as bounded:
        with _bag_errors_about(path):
            place = path.parent if path.name == METADATA else path
            reader = (first.Reader if old else second.Reader)(place)
            bound_index(reader, bounded)
            reader.open()
        try:
            chunk_by_chunk(reader)
            return _bag(path, reader, old, needed)
        finally:
            reader.close()


def _bag(path: Path, reader: Any, old: bool, needed: Callable[[str, str, Layout], bool]) -> Bag:
    """Return the needed topics of an open bag."""
    types = library(path, "rosbags.typesys", EXTRA)
    with _bag_errors_about(path):
        store = _typestore(types, reader.connections, old)
        collected, unknown = _selected(reader.connections, store, needed)
    mounts = Mounts()
    sinks: dict[int, _Collected | Mounts] = dict(collected)
    sinks |= {one.id: mounts for one in reader.connections if one.msgtype in TRANSFORMS}
    broken = _collect(path, reader, sinks, store.deserialize_ros1 if old else store.deserialize_cdr)
    topics = [_joined([one for one in collected.values() if one.name == name]) for name in _names(collected)]
    left = [f"topics of unknown types left out: {', '.join(unknown[:4])}"] if unknown else []
    return Bag({topic.name: topic for topic in topics}, (*left, *broken), mounts)


def joined_bags(bags: Sequence[Bag]) -> Bag:
    """Return the parts of one recording as one bag, topics in the order of receipt."""
    names = dict.fromkeys(name for bag in bags for name in bag.topics)
    parts = {name: [bag.topics[name] for bag in bags if name in bag.topics] for name in names}
    topics = {name: _in_order([one for one in some if one.kind == some[0].kind]) for name, some in parts.items()}
    mounts = Mounts()
    for bag in bags:
        mounts.join(bag.mounts)
    return Bag(topics, tuple(dict.fromkeys(note for bag in bags for note in bag.notes)), mounts)


def _names(collected: Mapping[int, _Collected]) -> list[str]:
    return list(dict.fromkeys(one.name for one in collected.values() if one.received_ns))


def _joined(parts: list[_Collected]) -> Topic:
    """Return the messages of several publishers of a topic, in the order of receipt; of the first's type alone."""
    return _in_order([one.topic() for one in parts if one.kind == parts[0].kind and one.received_ns])


def _in_order(topics: Sequence[Topic]) -> Topic:
    """Return parts of a topic, at least one, as one topic in the order of receipt."""
    topic = topics[0]
    if len(topics) == 1:
        return topic
    order = np.argsort(np.concatenate([one.received_ns for one in topics]), kind="stable")

    def of(get: Callable[[Topic], NDArray[Any]]) -> NDArray[Any]:
        return np.concatenate([get(one) for one in topics])[order]

    names = [name for name in topic.columns if all(name in one.columns for one in topics)]
    columns = {name: np.concatenate([one.columns[name] for one in topics])[order] for name in names}
    times = of(attrgetter("received_ns")), of(attrgetter("stamp_ns")), of(attrgetter("frames"))
    return Topic(topic.name, topic.kind, *times, columns)


def _typestore(types: Any, connections: Sequence[Any], old: bool) -> Any:
    """Return the message types: as the bag defines them, else as ROS 1 Noetic or the latest ROS 2 does."""
    found: dict[str, Any] = {}
    for one in connections:
        parse = {"MSG": types.get_types_from_msg, "IDL": types.get_types_from_idl}.get(one.msgdef.format.name)
        if parse is None:
            continue
        try:
            text = (one.msgdef.data,) if parse is types.get_types_from_idl else (one.msgdef.data, one.msgtype)
            found.update(parse(*text))
        except (*DAMAGE, types.TypesysError):
            continue
    store = types.get_typestore(types.Stores.EMPTY)
    usual = types.get_typestore(types.Stores.ROS1_NOETIC if old else types.Stores.LATEST)
    store.register(needed_types({**usual.fielddefs, **found}, [one.msgtype for one in connections]))
    return store


def _selected(
    connections: Iterable[Any], store: Any, needed: Callable[[str, str, Layout], bool]
) -> tuple[dict[int, _Collected], list[str]]:
    """Return the connections to read, by number, and the topics of unknown types."""
    chosen, unknown = {}, []
    for one in connections:
        layout = layout_of(store.fielddefs, one.msgtype)
        if layout is None:
            unknown.append(one.topic)
        elif needed(one.topic, one.msgtype, layout):
            chosen[one.id] = _Collected(one.topic, one.msgtype, layout)
    return chosen, unknown


def _collect(
    path: Path, reader: Any, sinks: Mapping[int, _Collected | Mounts], decode: Callable[[bytes, str], Any]
) -> list[str]:
    """Read all messages, and return a line for each kind of damage; InputError for too many that cannot be read."""
    chosen = [one for one in reader.connections if one.id in sinks]
    wrong, notes = 0, list[str]()
    for item in _messages(reader, chosen, notes) if chosen else ():
        connection, received_ns, raw = item
        try:
            sinks[connection.id].add(received_ns, decode(raw, connection.msgtype))
        except _damage():
            wrong += 1
            if wrong > MOST_WRONG:
                what = f"more than {MOST_WRONG} messages are of another form than their types"
                raise InputError(what, where=str(path), do="record it again") from None
    return [*notes, *([f"{wrong} messages of another form left out"] if wrong else [])]


def _messages(reader: Any, chosen: list[Any], notes: list[str]) -> Iterator[tuple[Any, int, bytes]]:
    """Yield messages up to the first damage, of which `notes` then tells."""
    found = iter(reader.messages(connections=chosen))
    while True:
        try:
            item = next(found)
        except StopIteration:
            return
        except InputError:
            raise
        except _damage() as error:
            notes.append(f"damaged: the messages ahead of the damage are read ({_short(error)})")
            return
        yield item


@contextmanager
def _bag_errors_about(path: Path) -> Iterator[None]:
    """Turn what the library raises into an InputError about the file."""
    try:
        yield
    except InputError:
        raise
    except _damage() as error:
        do = "close the recorder properly, repair it with `rosbag reindex`, `ros2 bag reindex` or `mcap recover`"
        raise InputError(f"cannot be read as a ROS bag: {_short(error)}", where=str(path), do=do) from None


def _damage() -> Damage:
    """Return the exceptions that a damaged bag raises: of Python, of the library and of the libraries below."""
    import apsw
    from rosbags import rosbag1, rosbag2, serde, typesys
    from rosbags.rosbag2.storage_mcap import zstd

    own = (rosbag1.ReaderError, rosbag2.ReaderError, serde.SerdeError, typesys.TypesysError, apsw.Error, zstd.ZstdError)
    return (*DAMAGE, *own)


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:120] or type(error).__name__
