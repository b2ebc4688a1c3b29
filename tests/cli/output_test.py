# SPDX-License-Identifier: Apache-2.0
# What render writes: formats, bands, buffers, georeference, figures; whole files or none.
import csv
import math
import os
import signal
import subprocess
import time

from harness import TERRAY, CliTest, main, read_png

SMALL = ["--size", "64x48", "--quiet"]


class Output(CliTest):
    def test_every_format(self):
        dem = self.ascii_grid()
        for name, driver, bands in (("a.png", "PNG", 3), ("a.jpg", "JPEG", 3), ("a.jpeg", "JPEG", 3),
                                    ("a.tif", "GTiff", 3), ("A.TIFF", "GTiff", 3)):
            self.good("render", dem, *SMALL, "-o", name)
            info = self.describe(name)
            self.assertEqual(info["driverShortName"], driver)
            self.assertEqual(info["size"], [64, 48])
            self.assertEqual(len(info["bands"]), bands)
        self.good("render", dem, *SMALL, "-o", "a.exr")
        with open(self.path("a.exr"), "rb") as data:
            self.assertEqual(data.read(4), b"\x76\x2f\x31\x01")
        self.good("render", dem, *SMALL)
        self.assertIn("terray.png", self.left())

    def test_transparent_background(self):
        dem = self.ascii_grid()
        for name in ("t.png", "t.jpg"):
            self.good("render", dem, *SMALL, "--background", "transparent", "-o", name)
        _, _, channels, rows = read_png(self.path("t.png"))
        self.assertEqual(channels, 4)
        alphas = [value for row in rows for value in row[3::4]]
        self.assertEqual(alphas[0], 0)
        self.assertIn(255, alphas)
        self.assertEqual(len(self.describe("t.jpg")["bands"]), 3)
        self.gdal("gdal_translate", "-q", "-of", "ENVI", "t.jpg", "t.raw")
        with open(self.path("t.raw"), "rb") as data:
            self.assertGreater(data.read(1)[0], 250)

    def test_the_picture_shows_terrain_and_sky(self):
        self.good("render", self.ascii_grid(), "--size", "160x120", "--quiet", "-o", "p.png")
        width, height, channels, rows = read_png(self.path("p.png"))
        self.assertEqual((width, height, channels), (160, 120, 3))
        top = rows[0][:3]
        middle = rows[height // 2][3 * (width // 2):3 * (width // 2) + 3]
        self.assertGreater(sum(abs(a - b) for a, b in zip(top, middle)), 30)

    def test_threads_and_runs_give_the_same_bytes(self):
        dem = self.ascii_grid()
        pictures = []
        for k, threads in enumerate(("1", "2", "2", "4")):
            name = f"{k}.png"
            self.good("render", dem, "--size", "200x300", "-q", "--threads", threads, "-o", name)
            with open(self.path(name), "rb") as data:
                pictures.append(data.read())
        self.assertEqual(len(set(pictures)), 1)

    def test_bands_show_what_small_pictures_show(self):
        dem = self.ascii_grid(height=lambda x, y: 50 + 0.5 * x - 0.25 * y + 20 * math.sin(x / 30))
        ortho = ["--projection", "ortho", "--quiet", "--tolerance", "0"]
        self.good("render", dem, *ortho, "--size", "32x768", "--extent", "300,0,320,480", "--aov",
                  "height=tall.tif")
        _, _, (tall,) = self.floats("tall.tif")
        for part in range(3):
            top, bottom = 480 - 160 * part, 480 - 160 * (part + 1)
            self.good("render", dem, *ortho, "--size", "32x256", "--extent",
                      f"300,{bottom},320,{top}", "--aov", "height=part.tif")
            _, _, (piece,) = self.floats("part.tif")
            for a, b in zip(tall[part * 32 * 256:(part + 1) * 32 * 256], piece):
                self.assertAlmostEqual(a, b, delta=1e-3)

    def test_wide_pictures(self):
        self.good("render", self.ascii_grid(), "--size", "100000x3", "--samples", "1", "-q", "-o",
                  "wide.png")
        self.assertEqual(self.describe("wide.png")["size"], [100000, 3])

    def test_every_buffer(self):
        dem = self.ascii_grid()
        channels = {"distance": 1, "depth": 1, "position": 3, "normal": 3, "height": 1, "mip": 1,
                    "steps": 1, "shadow": 1, "error": 1}
        flags = [f"--aov={name}={name}.tif" for name in channels]
        self.good("render", dem, *SMALL, *flags)
        self.assertNotIn("terray.png", self.left())
        misses = None
        for name, count in channels.items():
            width, height, bands = self.floats(f"{name}.tif")
            self.assertEqual((width, height, len(bands)), (64, 48, count), name)
            nan = [math.isnan(v) for v in bands[0]]
            misses = misses or nan
            self.assertEqual(nan, misses, name)
        self.assertIn(True, misses)
        self.assertIn(False, misses)
        self.good("render", dem, *SMALL, "--aov", "normal=n.exr", "-o", "p.png")
        self.assertEqual([n for n in self.left() if n in ("n.exr", "p.png")], ["n.exr", "p.png"])

    def test_ortho_pictures_lie_where_they_say(self):
        dem = self.ascii_grid(left=500000, bottom=4000000)
        flags = ["--assign-crs", "EPSG:32633", "--projection", "ortho", "--tolerance", "0"]
        self.good("render", dem, *flags, "--size", "50x40", "--extent", "500100,4000100,500350,4000300",
                  "-o", "map.tif", "--aov", "height=height.tif", "-q")
        for name in ("map.tif", "height.tif"):
            info = self.describe(name)
            for got, wanted in zip(info["geoTransform"], [500100, 5, 0, 4000300, 0, -5]):
                self.assertAlmostEqual(got, wanted, places=6)
            self.assertIn("32633", info["coordinateSystem"]["wkt"])
        _, _, (heights,) = self.floats("height.tif")
        pixels = [(3, 4), (20, 30), (49, 39), (0, 0)]
        places = [f"{500102.5 + 5 * x},{4000297.5 - 5 * y}" for x, y in pixels]
        rows = self.good("query", dem, "--assign-crs", "EPSG:32633", "height", *places).stdout
        for (x, y), row in zip(pixels, rows.splitlines()[1:]):
            self.assertAlmostEqual(heights[y * 50 + x], float(row.split(",")[2]), delta=1e-4)
        self.good("render", dem, *flags, "--heading", "20", "--size", "50x40", "-o", "turned.tif")
        self.assertNotIn("geoTransform", self.describe("turned.tif"))

    def test_stats(self):
        dem = self.ascii_grid()
        self.good("render", dem, *SMALL, "--stats", "s.json", "--stats", "s.json")
        stats = self.stats("s.json")
        for key in """device technique width height rays hits primary_ms shade_ms load_ms build_ms
                mrays_per_s steps_per_ray bytes_per_sample peak_rss_bytes""".split():
            self.assertIn(key, stats)
        self.assertEqual((stats["device"], stats["technique"]), ("cpu", "ray_cast"))
        self.assertEqual(stats["rays"], 64 * 48 * 4)
        self.assertTrue(0 < stats["hits"] < stats["rays"])
        self.assertGreater(stats["steps_per_ray"], 0)
        self.good("render", dem, *SMALL, "--stats", "s.csv")
        with open(self.path("s.csv")) as text:
            (row,) = csv.DictReader(text)
        self.assertEqual(row["rays"], str(stats["rays"]))
        self.assertEqual(set(row), set(stats))

    def test_words_after_a_render(self):
        dem = self.ascii_grid()
        done = self.good("render", dem, "--size", "64x48", "--assign-crs", "EPSG:32633")
        self.assertRegex(done.stdout, r"^terray\.png  64x48  \d.* [KM]iB  \d+\.\d\d s\n$")
        self.assertIn("note: ", done.stderr)
        done = self.good("render", dem, "--size", "64x48", "--assign-crs", "EPSG:32633", "-q")
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_time_is_said_in_the_output(self):
        done = self.good("render", self.ascii_grid(left=500000, bottom=5200000), "--size", "16x16",
                         "--assign-crs", "EPSG:32632", "--time", "2024-06-21T12:00:00+02:00")
        self.assertIn("2024-06-21T10:00:00Z", done.stderr)
        night = self.good("render", self.ascii_grid(left=500000, bottom=5200000), "--size", "16x16",
                          "--assign-crs", "EPSG:32632", "--time", "2024-12-21 23:00")
        self.assertIn("below the horizon", night.stderr)
        self.assertIn("UTC", night.stderr)

    def test_places_that_cannot_be_written(self):
        # The source is missing too: what cannot be written is found out first.
        self.write("file", "x")
        for flags in (["-o", "none/a.png"], ["-o", "file/a.png"], ["--aov", "depth=none/d.tif"],
                      ["--stats", "none/s.json"], ["-o", "/proc/a.png"]):
            with self.subTest(flags=flags):
                self.fails(1, "/", "render", "missing.tif", *flags)
        os.mkdir(self.path("folder.png"))
        self.fails(1, "folder.png", "render", "missing.tif", "-o", "folder.png")
        self.assertEqual(self.left(), ["file", "folder.png"])
        dem = self.ascii_grid()
        self.fails(1, "/dev/full", "render", dem, *SMALL, "--stats", "/dev/full")

    def test_a_file_size_limit_is_a_failed_write(self):
        dem = self.ascii_grid()
        before = self.left()
        for name in ("p.png", "p.jpg", "p.tif", "p.exr"):
            done = subprocess.run(["sh", "-c", 'ulimit -f 8; exec "$@"', "sh", TERRAY, "render", dem,
                                   "--size", "400x300", "-q", "-o", name], cwd=self.folder,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(name, done.stderr)
            self.assertEqual(self.left(), before)

    def test_the_source_is_not_overwritten(self):
        self.gdal("gdal_translate", "-q", self.ascii_grid(), "dem.tif")
        before = self.describe("dem.tif")
        self.fails(2, "input", "render", "dem.tif", *SMALL, "-o", "dem.tif")
        self.assertEqual(self.describe("dem.tif"), before)

    def test_no_input_is_overwritten(self):
        dem = self.ascii_grid()
        self.gdal("gdal_translate", "-q", "-ot", "Byte", dem, "photo.tif")
        self.write("look.csv", "0 0 0 0\n100 255 255 255\n")
        os.symlink("photo.tif", self.path("link.tif"))
        for words, flags in [("--output", ["-o", "photo.tif"]), ("--output", ["-o", "./link.tif"]),
                             ("--aov", ["--aov", "depth=link.tif"]),
                             ("--stats", ["--stats", "look.csv"])]:
            self.fails(2, [words, "input"], "render", dem, "--photo", "photo.tif", "--ramp",
                       "look.csv", *SMALL, *flags)
        self.fails(2, ["--output", dem], "query", dem, "-o", dem, "height", "1,1")

    def test_an_extent_of_another_shape_is_said(self):
        ortho = ["--projection", "ortho", "--extent", "0,0,300,200", "-o", "m.png"]
        wide = self.good("render", self.ascii_grid(), *ortho, "--size", "100x50")
        self.assertIn("25 columns and 0 rows", wide.stderr)
        self.assertIn("--size 75x50", wide.stderr)
        fits = self.good("render", "dem.asc", *ortho, "--size", "75x50")
        self.assertNotIn("--extent", fits.stderr)

    def test_a_picture_without_terrain_is_said(self):
        dem = self.ascii_grid()
        for flags in (["--eye", "0,0,500", "--heading", "200", "--pitch", "10"],
                      ["--projection", "ortho", "--extent", "9000,0,9100,100"]):
            self.assertIn("no ray", self.good("render", dem, *SMALL, *flags).stderr)
        self.assertNotIn("no ray", self.good("render", dem, *SMALL).stderr)

    def test_interrupt_leaves_nothing(self):
        dem = self.ascii_grid()
        before = self.left()
        run = subprocess.Popen([TERRAY, "render", dem, "--size", "20000x20000", "--samples", "16",
                                "--aov", "depth=d.tif", "-o", "p.png", "--stats", "s.json"],
                               cwd=self.folder, stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while self.left() == before and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.5)
        self.assertNotEqual(self.left(), before)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(timeout=60), 130, run.stderr.read())
        run.stderr.close()
        self.assertEqual(self.left(), before)


if __name__ == "__main__":
    main()
