# SPDX-License-Identifier: Apache-2.0
"""Runs the program as a user does, on a small copy of the sample, and reads what it wrote.

Standard library only: pictures are written and read here, apart from the program's own
reader and writer. The program is $RELIGHT_PROGRAM, the sample $RELIGHT_SAMPLES/maple.
"""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest
import zlib

PROGRAM = os.environ.get("RELIGHT_PROGRAM", "relight")
SAMPLE = pathlib.Path(os.environ.get(
    "RELIGHT_SAMPLES", pathlib.Path(__file__).resolve().parents[2] / "samples")) / "maple"
SHARED = pathlib.Path(os.environ.get(
    "RELIGHT_SHARED", pathlib.Path(__file__).resolve().parents[2].parent / "shared"))


# --- Running ---------------------------------------------------------------------------

class Outcome:
    def __init__(self, done):
        self.code, self.out, self.err = done.returncode, done.stdout, done.stderr

    @property
    def json(self):
        return json.loads(self.out)


def relight(*words, cwd=None, file_limit=None, user=None, env=None, timeout=300):
    """file_limit: no file may grow beyond so many bytes, as on a disk that is full."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit, file_limit))
    return Outcome(subprocess.run(
        [PROGRAM, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=timeout,
        stdin=subprocess.DEVNULL, preexec_fn=limit if file_limit else None, user=user,
        env={**os.environ, **(env or {})}))


class RelightCase(unittest.TestCase):
    """A temporary folder of each test; checks that every refusal keeps its promises."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="relight_golden_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def done(self, *words, **how):
        outcome = relight(*words, **how)
        self.assertEqual(outcome.code, 0, outcome.err)
        return outcome

    def refused(self, *words, names=(), code=1, **how):
        """The exit code, one message with all of `names`, and every file as it was."""
        before = contents(self.folder)
        outcome = relight(*words, **how)
        self.assertEqual(outcome.code, code, f"{words}: {outcome.err}")
        self.assertEqual(outcome.out, "", "a refusal prints no result")
        self.assertNotIn("error of relight", outcome.err, "a user's mistake is no bug")
        last = outcome.err[outcome.err.rfind("relight: "):]
        for name in names:
            self.assertIn(str(name), last)
        after = contents(self.folder)
        self.assertEqual([f for f in after if ".part-" in f], [], "a partial file is left")
        for file, content in before.items():
            self.assertIn(file, after, f"{file} is lost")
            if not file.endswith("stages.json"):
                self.assertEqual(after[file], content, f"{file} was changed")
        return last

    def assertNoPartialFile(self):
        self.assertEqual([f for f in contents(self.folder) if ".part-" in f], [])


def contents(folder):
    return {str(f.relative_to(folder)): f.read_bytes()
            for f in sorted(pathlib.Path(folder).rglob("*")) if f.is_file()}


# --- A capture of three views, coarse, so that a test takes seconds ---------------------

VIEWS = ("view_00", "view_04", "view_08")


def wait_until_it_listens(run):
    """Returns when the program catches SIGINT: a machine under load starts it late."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        status = pathlib.Path(f"/proc/{run.pid}/status").read_text()
        caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) >> (signal.SIGINT - 1) & 1:
            return
        time.sleep(0.01)


def small_capture(folder):
    """Three photos of the sample with their trimaps and cameras; 32 voxels an edge."""
    folder = pathlib.Path(folder)
    for name in ("photos", "trimaps", "cameras"):
        (folder / name).mkdir(parents=True)
    for view in VIEWS:
        shutil.copy(SAMPLE / "photos" / f"{view}.jpg", folder / "photos")
        shutil.copy(SAMPLE / "trimaps" / f"{view}.png", folder / "trimaps")
    shutil.copy(SAMPLE / "cameras" / "cameras.txt", folder / "cameras")
    lines = (SAMPLE / "cameras" / "images.txt").read_text().splitlines(keepends=True)
    kept, take = [], False
    for line in lines:
        if line.startswith("#"):
            kept.append(line)
        elif re.search(r"view_\d\d", line):
            take = any(view in line for view in VIEWS)
            kept += [line, "\n"] if take else []
    (folder / "cameras" / "images.txt").write_text("".join(kept))
    views = "".join(f'\n[[view]]\nphoto = "photos/{view}.jpg"\n' for view in VIEWS)
    (folder / "capture.toml").write_text(views + "\n[options]\ncells = 32\n")
    return folder


_made = {}


def made_capture(folder):
    """The same with all of its stages made: done once a run, and copied."""
    if "capture" not in _made:
        root = tempfile.mkdtemp(prefix="relight_golden_made_")
        unittest.addModuleCleanup(shutil.rmtree, root, ignore_errors=True)
        unittest.addModuleCleanup(_made.clear)
        capture = small_capture(pathlib.Path(root) / "capture")
        outcome = relight("hour", capture, "--to", "17:00")
        assert outcome.code == 0, outcome.err
        _made["capture"] = capture
    shutil.copytree(_made["capture"], folder)
    return pathlib.Path(folder)


# --- PNG -------------------------------------------------------------------------------

def write_png(file, width, height, channels, pixel, bits=8):
    """pixel(x, y): a tuple of whole numbers, 1 grey, 3 RGB, 4 RGBA."""
    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
    code = {1: 0, 3: 2, 4: 6}[channels]
    sample = {8: "B", 16: "H"}[bits]
    rows = b"".join(
        b"\0" + b"".join(struct.pack(f">{channels}{sample}", *pixel(x, y)) for x in range(width))
        for y in range(height))
    pathlib.Path(file).write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, code,
                                                            0, 0, 0)) +
        chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b""))
    return pathlib.Path(file)


class Png:
    """width, height, channels, bits, and samples row after row."""

    def __init__(self, file):
        data = pathlib.Path(file).read_bytes()
        assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{file} is no PNG"
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + size]
            assert zlib.crc32(kind + body) == struct.unpack(
                ">I", data[at + 8 + size:at + 12 + size])[0], f"{file}: damaged {kind}"
            if kind == b"IHDR":
                self.width, self.height, self.bits, code, _, _, interlaced = struct.unpack(
                    ">IIBBBBB", body)
                assert not interlaced
                self.channels = {0: 1, 2: 3, 4: 2, 6: 4}[code]
            elif kind == b"IDAT":
                packed += body
            at += 12 + size
        assert kind == b"IEND", f"{file} is cut off"
        step = self.channels * self.bits // 8
        stride = self.width * step
        raw = zlib.decompress(packed)
        above, out = bytearray(stride), bytearray()
        for y in range(self.height):
            method = raw[y * (stride + 1)]
            row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
            if method == 1:
                for i in range(step, stride):
                    row[i] = (row[i] + row[i - step]) & 255
            elif method == 2:
                for i in range(stride):
                    row[i] = (row[i] + above[i]) & 255
            elif method == 3:
                for i in range(stride):
                    row[i] = (row[i] + ((row[i - step] if i >= step else 0) + above[i]) // 2) & 255
            elif method == 4:
                for i in range(stride):
                    a = row[i - step] if i >= step else 0
                    b, c = above[i], above[i - step] if i >= step else 0
                    pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                    row[i] = (row[i] + (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255
            out += row
            above = row
        count = self.width * self.height * self.channels
        self.samples = struct.unpack(f">{count}{'B' if self.bits == 8 else 'H'}", bytes(out))

    def at(self, x, y):
        i = (y * self.width + x) * self.channels
        return self.samples[i:i + self.channels]


# --- OpenEXR ---------------------------------------------------------------------------

class Exr:
    """Channels of a scan-line OpenEXR file, as names to 'half', 'float'; values of floats."""

    def __init__(self, file):
        self.data = pathlib.Path(file).read_bytes()
        assert self.data[:4] == b"\x76\x2f\x31\x01", f"{file} is no OpenEXR"
        at, self.attributes = 8, {}
        while self.data[at]:
            name, at = self._word(at)
            _, at = self._word(at)
            size = struct.unpack("<i", self.data[at:at + 4])[0]
            self.attributes[name] = self.data[at + 4:at + 4 + size]
            at += 4 + size
        self.start = at + 1
        self.types, at = {}, 0
        table = self.attributes["channels"]
        while table[at]:
            end = table.index(b"\0", at)
            kind = struct.unpack("<i", table[end + 1:end + 5])[0]
            self.types[table[at:end].decode()] = {1: "half", 2: "float"}[kind]
            at = end + 17
        left, top, right, bottom = struct.unpack("<4i", self.attributes["dataWindow"])
        self.width, self.height, self.top = right - left + 1, bottom - top + 1, top

    def _word(self, at):
        end = self.data.index(b"\0", at)
        return self.data[at:end].decode(), end + 1

    def values(self):
        """Samples of each channel, row after row."""
        compression = self.attributes["compression"][0]
        lines = {0: 1, 2: 1, 3: 16}[compression]  # None, ZIPS, ZIP
        blocks = -(-self.height // lines)
        offsets = struct.unpack(f"<{blocks}Q", self.data[self.start:self.start + 8 * blocks])
        found = {name: [] for name in self.types}
        size_of = {"half": 2, "float": 4}
        row_bytes = sum(self.width * size_of[t] for t in self.types.values())
        for offset in offsets:
            y, size = struct.unpack("<ii", self.data[offset:offset + 8])
            block = self.data[offset + 8:offset + 8 + size]
            rows = min(lines, self.height - (y - self.top))
            if compression and size < rows * row_bytes:
                block = self._unzipped(zlib.decompress(block))
            at = 0
            for _ in range(rows):
                for name, kind in sorted(self.types.items()):
                    count = self.width * size_of[kind]
                    found[name] += struct.unpack(
                        f"<{self.width}{'f' if kind == 'float' else 'e'}", block[at:at + count])
                    at += count
        return found

    @staticmethod
    def _unzipped(block):
        block = bytearray(block)
        for i in range(1, len(block)):
            block[i] = (block[i - 1] + block[i] - 128) & 255
        half = (len(block) + 1) // 2
        whole = bytearray(len(block))
        whole[0::2], whole[1::2] = block[:half], block[half:]
        return bytes(whole)


# --- JPEG with EXIF of our own ---------------------------------------------------------

def with_exif(photo, file, time=None, offset=None, place=None, heading=None, reference="T",
              focal_35mm=None, gps_time=None):
    """Copies a JPEG without its metadata, and gives it these; gps_time as EXIF writes time."""
    def ascii_entry(tag, text):
        return tag, 2, len(text) + 1, text.encode() + b"\0"

    def rationals(tag, *values):
        return tag, 5, len(values), b"".join(
            struct.pack(">II", round(v * 10000), 10000) for v in values)

    def folder_bytes(entries, at):
        """One TIFF directory at offset `at`, with its values behind it."""
        entries = sorted(entries)
        out = struct.pack(">H", len(entries))
        behind, behind_at = b"", at + 6 + 12 * len(entries)
        for tag, kind, count, value in entries:
            if len(value) <= 4:
                out += struct.pack(">HHI", tag, kind, count) + value.ljust(4, b"\0")
            else:
                out += struct.pack(">HHII", tag, kind, count, behind_at + len(behind))
                behind += value + b"\0" * (len(value) % 2)
        return out + struct.pack(">I", 0) + behind

    exif, gps = [], []
    if time:
        exif.append(ascii_entry(0x9003, time))
    if offset:
        exif.append(ascii_entry(0x9011, offset))
    if focal_35mm:
        exif.append((0xA405, 3, 1, struct.pack(">H", focal_35mm)))
    if place:
        latitude, longitude = place
        for tag, value, letters in ((1, latitude, "NS"), (3, longitude, "EW")):
            gps.append(ascii_entry(tag, letters[value < 0]))
            gps.append(rationals(tag + 1, abs(value), 0, 0))
    if gps_time:
        gps += [ascii_entry(0x1D, gps_time[:10]),
                rationals(7, *(int(part) for part in gps_time[11:].split(":")))]
    if heading is not None:
        gps += [ascii_entry(0x10, reference), rationals(0x11, heading)]
    main_size = 6 + 12 * (bool(exif) + bool(gps))
    exif_bytes = folder_bytes(exif, 8 + main_size) if exif else b""
    gps_bytes = folder_bytes(gps, 8 + main_size + len(exif_bytes)) if gps else b""
    main = []
    if exif:
        main.append((0x8769, 4, 1, struct.pack(">I", 8 + main_size)))
    if gps:
        main.append((0x8825, 4, 1, struct.pack(">I", 8 + main_size + len(exif_bytes))))
    tiff = b"MM\0*" + struct.pack(">I", 8) + folder_bytes(main, 8) + exif_bytes + gps_bytes
    segment = b"Exif\0\0" + tiff

    data = pathlib.Path(photo).read_bytes()
    at, kept = 2, b""
    while data[at + 1] != 0xDA:
        size = struct.unpack(">H", data[at + 2:at + 4])[0]
        if data[at + 1] not in (0xE1, 0xED):  # EXIF, XMP; IPTC
            kept += data[at:at + 2 + size]
        at += 2 + size
    block = b"\xff\xe1" + struct.pack(">H", len(segment) + 2) + segment if main else b""
    pathlib.Path(file).write_bytes(b"\xff\xd8" + block + kept + data[at:])
    return pathlib.Path(file)


# --- One photo alone -------------------------------------------------------------------

def tree_png(file, size=64, bits=16):
    """A tree with an alpha: a round crown on a stem, leaves as a fixed pattern."""
    def pixel(x, y):
        crown = (x - size / 2) ** 2 + (y - size * 0.4) ** 2 < (size * 0.3) ** 2
        stem = abs(x - size / 2) < size * 0.05 and size * 0.4 < y < size * 0.9
        leaf = (x * 7919 + y * 104729) % 97
        scale = 257 if bits == 16 else 1
        return ((60 + leaf) * scale, (90 + leaf) * scale, (40 + leaf // 2) * scale,
                255 * scale if crown or stem else 0)
    return write_png(file, size, size, 4, pixel, bits)
