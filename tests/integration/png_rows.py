"""Reads the rows of a PNG of 8-bit RGB that is not interlaced, and whose rows have no filter or that of the row above."""
import struct
import zlib


def rgb_rows(png):
    """Each row as its bytes."""
    at, data = 8, []
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (8, 2)
        if kind == b"IDAT":
            data.append(body)
        at += size + 12
    raw, count = zlib.decompress(b"".join(data)), 3 * width
    low = int.from_bytes(b"\x7f" * count, "big")
    rows, above = [], 0
    for y in range(height):
        begin = y * (count + 1)
        row = int.from_bytes(raw[begin + 1:begin + 1 + count], "big")
        if raw[begin] == 2:  # sums of bytes, all at once: the low bits, then the high ones without what they carry
            row = ((row & low) + (above & low)) ^ ((row ^ above) & ~low)
        else:
            assert raw[begin] == 0
        above = row
        rows.append(row.to_bytes(count, "big"))
    return rows
