"""The frames of a blackbox log decoded: variable-length differences from a prediction, as the flight controller wrote.

Integers are of 7 bits a byte, low bits first; signed integers are zigzag: 0, -1, 1, -2. Main frames I stand alone,
P frames hold differences from the last two main frames, S, G and H frames slow states, fixes and the home position.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.kernel_cache import njit

Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]
INTRA, INTER, SLOW, GPS, HOME = range(5)
MARKERS = b"IPSGH"
"""First bytes of frames, in the order of the rows of a table of definitions."""
EVENT = 69
"""First byte of an event, E."""
ENCODING, PREDICTOR, SIGNED = range(3)
ENCODINGS = (0, 1, 3, 6, 7, 8, 9, 10)
"""Encodings that are decoded: signed, unsigned, 14 bits negated, groups of 8, 3 and 4, nothing, 3 of varied length."""
PREDICTORS = (*range(12), 256)
"""Predictors that are known; 256 is the second home coordinate, where the log says 7 twice."""
CONSTANTS = 8
MIN_THROTTLE, VBAT_REFERENCE, MIN_MOTOR, MOTOR_0, MAIN_TIME, HOME_0, HOME_1, HOME_KNOWN = range(CONSTANTS)
CONSTANT_PREDICTORS = (
    *((4, MIN_THROTTLE), (7, HOME_0), (256, HOME_1), (9, VBAT_REFERENCE), (10, MAIN_TIME), (11, MIN_MOTOR)),
)
"""Predictors that are a constant of the log, or of the frames so far."""
STATES = 11
POSITION, VALID, LAST_US, TOTAL_US, PENDING_US, FRAMES, WRONG, ROWS, SLOW_ROWS, GPS_ROWS, ENDED = range(STATES)
LONGEST_JUMP_US = 10_000_000
"""A complete main frame that is further ahead of the last is damaged, unless the next complete frame agrees with it."""
LONGEST_STEP_US = 1_000_000
"""The same of frames of differences, which follow each other closely."""
LONGEST_FRAME = 1024
"""Bytes that a frame can have; as many zeros follow the data."""
_MASK = 0xFFFFFFFF
END_OF_LOG = np.frombuffer(b"End of log", np.uint8)


@njit(cache=True, nogil=True)
def _unsigned(data: Bytes, at: int) -> tuple[np.int64, int]:
    """Return an unsigned integer and the place behind it; 0 where it does not end within five bytes."""
    value = np.int64(0)
    for k in range(5):
        byte = np.int64(data[at])
        at += 1
        value |= (byte & 127) << (7 * k)
        if byte < 128:
            return value & _MASK, at
    return np.int64(0), at


@njit(cache=True, nogil=True)
def _signed(data: Bytes, at: int) -> tuple[int, int]:
    value, at = _unsigned(data, at)
    return (value >> 1) ^ -(value & 1), at


@njit(cache=True, nogil=True)
def _extended(value: int, bits: int) -> np.int64:
    """Return the lowest bits of a number as a signed integer."""
    half = np.int64(1) << (bits - 1)
    return ((value & (2 * half - 1)) ^ half) - half


@njit(cache=True, nogil=True)
def _bytes(data: Bytes, at: int, count: int) -> int:
    """Return a signed integer of some bytes, the lowest first."""
    value = np.int64(0)
    for k in range(count):
        value |= np.int64(data[at + k]) << (8 * k)
    found: int = _extended(value, 8 * count)
    return found


@njit(cache=True, nogil=True)
def _three(data: Bytes, at: int, values: Integers, varied: bool) -> int:
    """Read three integers: of 2, 4 or 6 bits each, or of 5, 5, 4 or 8, 7, 7 bits where varied, or of whole bytes."""
    lead = np.int64(data[at])
    kind: Any = lead >> 6
    if kind == 3:
        at += 1
        for k in range(3):
            count: Any = ((lead >> (2 * k)) & 3) + 1
            values[k] = _bytes(data, at, count)
            at += count
        return at
    second, third = np.int64(data[at + 1]), np.int64(data[at + 2])
    if kind == 0:
        values[0], values[1], values[2] = _extended(lead >> 4, 2), _extended(lead >> 2, 2), _extended(lead, 2)
    elif kind == 1 and not varied:
        values[0], values[1], values[2] = _extended(lead, 4), _extended(second >> 4, 4), _extended(second, 4)
    elif kind == 1:
        values[0], values[1] = _extended(lead >> 1, 5), _extended(lead << 4 | second >> 4, 5)
        values[2] = _extended(second, 4)
    elif not varied:
        values[0], values[1], values[2] = _extended(lead, 6), _extended(second, 6), _extended(third, 6)
    else:
        values[0], values[1] = _extended(lead << 2 | second >> 6, 8), _extended(second << 1 | third >> 7, 7)
        values[2] = _extended(third, 7)
    behind: int = at + 1 + kind
    return behind


@njit(cache=True, nogil=True)
def _four(data: Bytes, at: int, values: Integers) -> int:
    """Read four integers of 0, 4, 8 or 16 bits, packed by half bytes, the high half first."""
    selector = np.int64(data[at])
    place = 2 * (at + 1)  # in half bytes
    for k in range(4):
        kind = (selector >> (2 * k)) & 3
        halves = 0 if kind == 0 else 1 << (kind - 1)
        value = np.int64(0)
        for _ in range(halves):
            value = value << 4 | (np.int64(data[place >> 1]) >> (0 if place & 1 else 4)) & 15
            place += 1
        values[k] = _extended(value, 4 * halves) if halves else 0
    return (place + 1) >> 1


@njit(cache=True, nogil=True)
def _eight(data: Bytes, at: int, values: Integers, count: int) -> int:
    """Read a group of up to eight integers, the non-zero ones marked in a first byte; a single without it."""
    if count == 1:
        values[0], at = _signed(data, at)
        return at
    present = np.int64(data[at])
    at += 1
    for k in range(count):
        values[k] = 0
        if present >> k & 1:
            values[k], at = _signed(data, at)
    return at


@njit(cache=True, nogil=True)
def _prediction(kind: int, i: int, now: Integers, last: Integers, before: Integers, constants: Integers) -> int:
    found: int = 0
    if kind == 1:
        found = last[i]
    elif kind == 2:
        found = 2 * last[i] - before[i]
    elif kind == 3:
        total = last[i] + before[i]
        found = total // 2 if total >= 0 else -(-total // 2)
    elif kind == 5:
        found = now[constants[MOTOR_0]]
    elif kind == 6:
        found = last[i] + 1
    elif kind == 8:
        found = 1500
    else:
        for number, constant in CONSTANT_PREDICTORS:
            if kind == number:
                found = constants[constant]
    return found


@njit(cache=True, nogil=True)
def _group(encodings: Integers, i: int, count: int) -> int:
    """Return how many fields from the i-th on are encoded together."""
    if encodings[i] == 7 or encodings[i] == 10:
        return 3
    if encodings[i] == 8:
        return 4
    size = 1
    while encodings[i] == 6 and size < 8 and i + size < count and encodings[i + size] == 6:
        size += 1
    return size


@njit(cache=True, nogil=True)
def _frame(
    data: Bytes,
    at: int,
    definition: Integers,
    count: int,
    now: Integers,
    last: Integers,
    before: Integers,
    constants: Integers,
) -> int:
    """Read a frame into `now`; return the place behind it."""
    values = np.zeros(8, np.int64)
    i = 0
    while i < count:
        encoding = definition[ENCODING, i]
        size = _group(definition[ENCODING], i, count)
        values[0] = 0
        if encoding == 0:
            values[0], at = _signed(data, at)
        elif encoding == 1:
            values[0], at = _unsigned(data, at)
        elif encoding == 3:
            found, at = _unsigned(data, at)
            values[0] = -_extended(found, 14)
        elif encoding == 6:
            at = _eight(data, at, values, size)
        elif encoding == 7 or encoding == 10:
            at = _three(data, at, values, encoding == 10)
        elif encoding == 8:
            at = _four(data, at, values)
        for k in range(min(size, count - i)):
            field = i + k
            value = values[k] + _prediction(definition[PREDICTOR, field], field, now, last, before, constants)
            now[field] = _extended(value, 32) if definition[SIGNED, field] else value & _MASK
        i += size
    return at


@njit(cache=True, nogil=True)
def _event(data: Bytes, at: int, state: Integers) -> int:
    """Read an event behind its E; return the place behind it, or -1 for no event."""
    kind = data[at]
    at += 1
    if kind == 255:
        for k in range(len(END_OF_LOG)):
            if data[at + k] != END_OF_LOG[k]:
                return -1
        state[ENDED] = 1
        return at
    if kind == 0 or kind == 15 or kind == 40:  # beep, disarming, failure of the IMU
        _, at = _unsigned(data, at)
        return at
    if kind == 30:  # flight modes
        _, at = _unsigned(data, at)
        _, at = _unsigned(data, at)
        return at
    if kind == 13:  # adjustment in flight, to a float or an integer
        if data[at] > 127:
            return at + 5
        _, at = _unsigned(data, at + 1)
        return at
    if kind == 14:  # logging resumed: iteration and time
        time_us, at = _unsigned(data, _unsigned(data, at)[1])
        state[TOTAL_US] += (time_us - state[LAST_US]) & _MASK
        state[LAST_US] = time_us
        return at
    return -1


@njit(cache=True, nogil=True)
def _kind(data: Bytes, at: int) -> int:
    """Return the row of a frame's definition by its first byte, 5 for an event, -1 for anything else."""
    for k in range(5):
        if data[at] == MARKERS[k]:
            return k
    return 5 if data[at] == EVENT else -1


@njit(cache=True, nogil=True)
def _accepts(state: Integers, time_us: int, whole: bool) -> bool:
    """Return whether a main frame's time follows the last one's; take the time if so."""
    ahead = _extended(time_us - state[LAST_US], 32)
    first = state[LAST_US] < 0
    agreed = whole and state[PENDING_US] >= 0 and (time_us - state[PENDING_US]) & _MASK < LONGEST_JUMP_US
    if not (first or 0 <= ahead < (LONGEST_JUMP_US if whole else LONGEST_STEP_US) or agreed):
        state[PENDING_US] = time_us if whole else state[PENDING_US]
        return False
    state[TOTAL_US] = time_us if first else state[TOTAL_US] + ahead
    state[LAST_US], state[PENDING_US] = time_us, -1
    return True


@njit(cache=True, nogil=True)
def decode(
    data: Bytes,
    end: int,
    table: Integers,
    counts: Integers,
    constants: Integers,
    time_field: int,
    watched: Integers,
    state: Integers,
    history: Integers,
    rows: Integers,
    slow: Integers,
    gps: Integers,
) -> None:
    """Decode frames from state[POSITION] on, until the data or the room of `rows`, `slow` or `gps` ends.

    data : the log's bytes, LONGEST_FRAME zeros behind `end`. table : (5, 3, fields), encodings, predictors and signs of
    the frames of MARKERS, with counts (5,) fields. watched : (3,) fields; a row is kept where their values differ from
    the row before and are not all zero. history : (5, fields), the frame being read, the last two main frames, zeros,
    and in watched's fields the last kept row. rows, slow, gps : the time in us, then the fields of a frame.
    """
    zeros = history[3]
    while state[POSITION] < end and state[ENDED] == 0:
        if state[ROWS] == len(rows) or state[SLOW_ROWS] == len(slow) or state[GPS_ROWS] == len(gps):
            return
        start = state[POSITION]
        kind = _kind(data, start)
        at = -1
        now = history[0]
        if kind == 5:
            at = _event(data, start + 1, state)
        elif kind == INTER:
            at = _frame(data, start + 1, table[kind], counts[kind], now, history[1], history[2], constants)
        elif kind >= 0 and counts[kind] > 0:
            at = _frame(data, start + 1, table[kind], counts[kind], now, zeros, zeros, constants)
        if at < 0 or at > end or not (state[ENDED] or at == end or _kind(data, at) >= 0):
            state[POSITION], state[VALID] = start + 1, 0
            state[WRONG] += kind in (INTRA, INTER)
            continue
        state[POSITION] = at
        if kind == SLOW:
            slow[state[SLOW_ROWS], 0] = state[TOTAL_US]
            slow[state[SLOW_ROWS], 1:] = now
            state[SLOW_ROWS] += 1
        elif kind == HOME:
            constants[HOME_0], constants[HOME_1], constants[HOME_KNOWN] = now[0], now[1], 1
        elif kind == GPS and constants[HOME_KNOWN]:
            gps[state[GPS_ROWS], 0] = state[TOTAL_US]
            gps[state[GPS_ROWS], 1:] = now
            state[GPS_ROWS] += 1
        elif kind in (INTRA, INTER):
            state[FRAMES] += 1
            good = (kind == INTRA or state[VALID] == 1) and _accepts(state, now[time_field], kind == INTRA)
            state[VALID] = good
            state[WRONG] += not good
            if good:
                constants[MAIN_TIME] = now[time_field]
                history[2] = now if kind == INTRA else history[1]
                history[1] = now
                new, there = False, False
                for field in watched:
                    new = new or now[field] != history[4, field]
                    there = there or now[field] != 0
                if new and there:
                    history[4] = now
                    rows[state[ROWS], 0] = state[TOTAL_US]
                    rows[state[ROWS], 1:] = now
                    state[ROWS] += 1


def new_state() -> Any:
    """Return the state ahead of the first frame."""
    state = np.zeros(STATES, np.int64)
    state[LAST_US] = state[PENDING_US] = -1
    return state
