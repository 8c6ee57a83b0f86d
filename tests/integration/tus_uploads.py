"""Scans for uploads in pieces (tus 1.0.0), and requests that send a part of one and break off.

VACUFORM_UPLOAD_MIB makes the large scan larger; 500 was measured by hand.
"""
import hashlib
import io
import os
import socket
import struct
import zipfile

MIB = int(os.environ.get("VACUFORM_UPLOAD_MIB", "40"))
PIECE = 1 << 20


class LargeScan:
    """A binary STL of about MIB, made piece by piece: nobody holds it whole."""

    def __init__(self):
        self.count = (MIB << 20) // 50
        self.size = 84 + 50 * self.count
        self.body = b"".join(hashlib.sha256(struct.pack("<I", i)).digest() for i in range(PIECE // 32))

    def bytes(self, begin, end, header=b"Jane Doe".ljust(80)):
        head = header + struct.pack("<I", self.count)
        while begin < end:
            if begin < 84:
                piece = head[begin:min(84, end)]
            else:
                at = (begin - 84) % PIECE
                piece = self.body[at:at + min(end - begin, PIECE - at)]
            yield piece
            begin += len(piece)

    def sha256(self, header):
        digest = hashlib.sha256()
        for piece in self.bytes(0, self.size, header):
            digest.update(piece)
        return digest.hexdigest()


class ZippedScan:
    """An OBJ in a zip, with a name in it."""

    def __init__(self):
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("Jane Doe.obj", "# Jane Doe\n" + "".join(
                "v %d %d %d\n" % struct.unpack("<3H", hashlib.sha256(struct.pack("<I", i)).digest()[:6]) for i in range(20_000)) + "f 1 2 3\n")
        self.whole = packed.getvalue()
        self.size = len(self.whole)

    def bytes(self, begin, end):
        yield self.whole[begin:end]


def sending(server, place, offset, upto, scan):
    """A connection on which a PATCH with the rest of the scan has been sent up to there."""
    token = server.token_file.read_text().strip()
    s = socket.create_connection(("127.0.0.1", server.port), timeout=120)
    s.sendall((f"PATCH {place} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {token}\r\n"
               "Tus-Resumable: 1.0.0\r\nContent-Type: application/offset+octet-stream\r\n"
               f"Upload-Offset: {offset}\r\nContent-Length: {scan.size - offset}\r\n\r\n").encode())
    for piece in scan.bytes(offset, upto):
        s.sendall(piece)
    return s


def send(server, place, offset, upto, scan):
    """The status of a PATCH; None when only a part of it is sent."""
    with sending(server, place, offset, upto, scan) as s:
        if upto < scan.size:
            return None
        answer = s.makefile("rb").readline()
        return int(answer.split()[1])
