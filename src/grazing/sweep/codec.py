"""The bytes of one file of an array: numbers, little end first, compressed with zstd, and a checksum (CRC-32C).

It is what Zarr's codecs ``bytes``, ``zstd`` and ``crc32c`` write, byte for byte, so that any reader of Zarr opens a
store. Reading here takes no more memory than the array, whatever size the bytes announce.
"""

from __future__ import annotations

import re
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grazing.outcome import shown

#: The codecs as the metadata of an array names them; a cell of ``done`` is one bare byte.
CODECS = ("bytes", "zstd", "crc32c")
#: How a type of numbers or texts is called that a store may name: not by a list, nor by a letter that is no more.
_TYPE = re.compile(r"[<>=|]?[A-Zb-z?]\w*")
_CHECKSUM = 4
_MAGIC = b"\x28\xb5\x2f\xfd"


def encode(values: NDArray[Any], chunk: tuple[int, ...]) -> bytes:
    """Return the bytes of a block; one at the edge of the array is filled up to a whole one, as Zarr does."""
    import google_crc32c
    from numcodecs.zstd import compress

    if values.shape != chunk:
        whole = np.full(chunk, fill_value(values.dtype), values.dtype)
        whole[tuple(slice(size) for size in values.shape)] = values
        values = whole
    kind = values.dtype.newbyteorder("<")
    packed = bytes(compress(np.ascontiguousarray(values, kind).reshape(-1).view(np.uint8), 0, False))
    checksum: int = google_crc32c.value(packed)
    return packed + checksum.to_bytes(_CHECKSUM, "little")


def decode(content: bytes, chunk: tuple[int, ...], dtype: str) -> NDArray[Any]:
    """Return the block that :func:`encode` wrote.

    Raises
    ------
    ValueError
        For bytes that are not those of such a block.
    """
    import google_crc32c
    from numcodecs.zstd import decompress

    packed, checksum = content[:-_CHECKSUM], content[-_CHECKSUM:]
    if len(content) <= _CHECKSUM or google_crc32c.value(packed).to_bytes(_CHECKSUM, "little") != checksum:
        raise ValueError("its checksum does not fit: it is damaged or cut off")
    kind = np.dtype(dtype).newbyteorder("<")
    size = prod(chunk) * kind.itemsize
    if _announced(packed) != size:
        raise ValueError(f"it does not hold the {size} bytes of a chunk")
    try:
        raw = decompress(packed, np.empty(size, np.uint8))
    except RuntimeError as error:  # how the library says it
        raise ValueError(str(error)) from error
    return np.frombuffer(raw, kind).reshape(chunk).astype(dtype, copy=False)


def longest(chunk: tuple[int, ...], dtype: str) -> int:
    """Return more bytes than the file of a block can have."""
    size = prod(chunk) * np.dtype(dtype).itemsize
    return size + size // 128 + 1024


def type_named(name: Any, kinds: str) -> np.dtype[Any]:
    """Return the type that a store names, if it is of one of these kinds, by NumPy's letters for them.

    Examples
    --------
    >>> type_named("float64", "if"), type_named("<i2", "if")
    (dtype('float64'), dtype('int16'))

    Raises
    ------
    ValueError
        For any other, such as ``a``, an old name at which NumPy would warn.
    """
    try:
        if isinstance(name, str) and _TYPE.fullmatch(name) and np.dtype(name).kind in kinds:
            return np.dtype(name)
    except TypeError:  # as NumPy says that it knows none of this name
        pass
    raise ValueError(f"it names a type {shown(name)}, which no store has")


def fill_value(dtype: Any) -> Any:
    """Return what stands where nothing has been computed."""
    kind = np.dtype(dtype)
    return kind.type("nan") if kind.kind == "f" else np.zeros((), kind)[()]


def _announced(frame: bytes) -> int | None:
    """Return the size that a zstd frame says it will have, None if it says none (RFC 8878, 3.1.1)."""
    if len(frame) < 6 or frame[:4] != _MAGIC:
        return None
    descriptor = frame[4]
    single, width = bool(descriptor & 0x20), (1 << (descriptor >> 6)) & ~1
    width = width or int(single)  # 0 or 1, 2, 4, 8
    start = 5 + (not single) + (0, 1, 2, 4)[descriptor & 3]
    field = frame[start : start + width]
    if not width or len(field) < width:
        return None
    return int.from_bytes(field, "little") + (256 if width == 2 else 0)
