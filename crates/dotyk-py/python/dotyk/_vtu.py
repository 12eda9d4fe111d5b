"""The point arrays of a VTU file that the library wrote."""

from __future__ import annotations

import base64
import struct
import zlib
from typing import Any
from xml.etree import ElementTree

_KINDS = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}


def arrays_of(text: str) -> dict[str, Any]:
    """Point arrays by name: (n,) or (n, components)."""
    import numpy as np

    piece = ElementTree.fromstring(text).find("UnstructuredGrid/Piece/PointData")
    found: dict[str, Any] = {}
    for array in piece.iter("DataArray") if piece is not None else []:
        kind, name = array.get("type", ""), array.get("Name", "")
        values = np.frombuffer(_bytes((array.text or "").strip()), dtype=_KINDS[kind])
        components = int(array.get("NumberOfComponents", "1"))
        found[name] = (values.reshape(-1, components) if components > 1 else values).copy()
    return found


def _bytes(text: str) -> bytes:
    """Blocks of zlib behind a header: their number, their size, that of the last, their compressed sizes."""
    (blocks,) = struct.unpack("<Q", base64.b64decode(text[:12])[:8])
    length = -(-8 * (3 + blocks) // 3) * 4
    sizes = struct.unpack(f"<{3 + blocks}Q", base64.b64decode(text[:length])[: 8 * (3 + blocks)])[3:]
    data, start, parts = base64.b64decode(text[length:]), 0, []
    for size in sizes:
        parts.append(zlib.decompress(data[start : start + size]))
        start += size
    return b"".join(parts)
