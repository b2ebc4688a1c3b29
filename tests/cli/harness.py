# SPDX-License-Identifier: Apache-2.0
# Runs terray in an empty folder, makes DEMs, reads pictures: shared by the command-line tests.
import array
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest
import zlib

TERRAY = os.path.abspath(sys.argv[1]) if len(sys.argv) > 1 else "terray"


class CliTest(unittest.TestCase):
    """Each test has an empty folder of its own and runs in it."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory(prefix="terray_cli_")
        self.addCleanup(self._folder.cleanup)
        self.folder = self._folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def terray(self, *arguments, stdin=None, timeout=300, stdout=subprocess.PIPE):
        return subprocess.run([TERRAY, *map(str, arguments)], cwd=self.folder, input=stdin,
                              stdout=stdout, stderr=subprocess.PIPE, text=True, encoding="utf-8",
                              errors="replace", timeout=timeout)

    def good(self, *arguments, **options):
        done = self.terray(*arguments, **options)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        return done

    def fails(self, code, words, *arguments, **options):
        """Fails with that exit code and exactly one line on stderr that has all the words."""
        done = self.terray(*arguments, **options)
        self.assertEqual(done.returncode, code, f"{arguments}: {done.stderr}{done.stdout}")
        errors = [line for line in done.stderr.splitlines() if line.startswith("terray: ")]
        self.assertEqual(len(errors), 1, done.stderr)
        for word in [words] if isinstance(words, str) else words:
            self.assertIn(word, errors[0])
        return errors[0]

    def left(self):
        return sorted(os.listdir(self.folder))

    def write(self, name, content):
        with open(self.path(name), "wb" if isinstance(content, bytes) else "w") as out:
            out.write(content)
        return name

    def ascii_grid(self, name="dem.asc", columns=65, rows=49, cell=10.0, left=0.0, bottom=0.0,
                   height=None):
        """Posts at (left + i cell, bottom + j cell), j counted from the south."""
        height = height or hills
        lines = [f"ncols {columns}", f"nrows {rows}", f"xllcenter {left}", f"yllcenter {bottom}",
                 f"cellsize {cell}", "NODATA_value -9999"]
        for j in reversed(range(rows)):
            lines.append(" ".join(repr(float(height(i * cell, j * cell))) for i in range(columns)))
        return self.write(name, "\n".join(lines) + "\n")

    def gdal(self, program, *arguments):
        done = subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def describe(self, name):
        return json.loads(self.gdal("gdalinfo", "-json", name))

    def floats(self, name):
        """(width, height, bands) of a float raster; a band is an array, row by row."""
        info = self.describe(name)
        width, height = info["size"]
        self.gdal("gdal_translate", "-q", "-of", "ENVI", "-ot", "Float32", "-co", "INTERLEAVE=BSQ",
                  name, name + ".raw")
        with open(self.path(name + ".raw"), "rb") as data:
            values = array.array("f", data.read())
        for leftover in (name + ".raw", name + ".hdr", name + ".raw.aux.xml"):
            if os.path.exists(self.path(leftover)):
                os.remove(self.path(leftover))
        count = width * height
        return width, height, [values[k * count:(k + 1) * count] for k in range(len(info["bands"]))]

    def stats(self, name):
        with open(self.path(name)) as text:
            return json.load(text)


def hills(x, y):
    """A smooth surface with a ridge and a cliff, 0..120 m over 640 x 480 m."""
    cliff = 30.0 if x > 400 else 0.0
    return 60 + 30 * math.sin(x / 70) * math.cos(y / 50) + cliff + 0.01 * y


def read_png(path):
    """(width, height, channels, rows of bytes) of an 8-bit PNG; standard library only."""
    with open(path, "rb") as data:
        content = data.read()
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(content):
        length = int.from_bytes(content[at:at + 4], "big")
        kind, body = content[at + 4:at + 8], content[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height = (int.from_bytes(body[k:k + 4], "big") for k in (0, 4))
            channels = {0: 1, 2: 3, 4: 2, 6: 4}[body[9]]
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride = zlib.decompress(packed), width * channels
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for k in range(stride):
            a = row[k - channels] if k >= channels else 0
            b, c = above[k], above[k - channels] if k >= channels else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[k] = (row[k] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
        rows.append(bytes(row))
        above = row
    return width, height, channels, rows


def main():
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
