# SPDX-License-Identifier: Apache-2.0
# Odd and bad inputs: refused with exit code 3 and one sentence, or read for what they are.
import json
import math
import signal
import subprocess
import time

from harness import TERRAY, CliTest, hills, main


class Input(CliTest):
    def refused(self, words, name, *flags):
        for command in (["info", name, *flags], ["render", name, "--size", "16x16", *flags],
                        ["query", name, *flags, "height", "0,0"]):
            self.fails(3, words, *command)

    def test_files_that_are_no_terrain(self):
        self.refused("missing.tif", "missing.tif")
        self.refused("empty.tif", self.write("empty.tif", b""))
        self.refused("words.tif", self.write("words.tif", "this is no raster\n" * 50))
        self.refused("zeros.tif", self.write("zeros.tif", bytes(4096)))
        self.refused("header.asc", self.write("header.asc", "ncols 5\nnrows"))
        self.fails(3, [], "info", ".")
        self.assertEqual([n for n in self.left() if n.endswith("png")], [])

    def test_truncated_and_lying_files(self):
        self.gdal("gdal_translate", "-q", "-co", "COMPRESS=DEFLATE", self.ascii_grid(columns=200,
                  rows=200), "whole.tif")
        with open(self.path("whole.tif"), "rb") as data:
            whole = data.read()
        for share in (0.3, 0.6, 0.95):
            self.write("cut.tif", whole[:int(len(whole) * share)])
            done = self.terray("render", "cut.tif", "-o", "cut.png", "--size", "16x16")
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("cut.tif", done.stderr)
            self.assertNotIn("cut.png", self.left())
        for columns, rows in ((10**6, 10**6), (2**31 - 1, 2**31 - 1), (0, 5), (-3, 4)):
            self.refused("lie.asc", self.write(
                "lie.asc", f"ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n"))

    def test_sizes(self):
        for columns, rows in ((1, 1), (1, 9), (9, 1)):
            self.refused("2 x 2", self.ascii_grid("thin.asc", columns, rows))
        for columns, rows in ((2, 2), (2, 9), (9, 2), (17, 31), (512, 3), (513, 3), (514, 515)):
            name = self.ascii_grid("size.asc", columns, rows)
            info = json.loads(self.good("info", name, "--json").stdout)
            self.assertEqual((info["columns"], info["rows"]), (columns, rows))
            self.good("render", name, "--size", "24x16", "--samples", "1")

    def test_degrees_without_crs_are_refused_and_named_degrees_are_drawn(self):
        name = self.ascii_grid(cell=0.001, left=7.5, bottom=46.5)
        self.refused("--assign-crs", name)
        info = json.loads(self.good("info", name, "--assign-crs", "EPSG:4326", "--json").stdout)
        self.assertTrue(info["warped"])
        self.assertIn("UTM", info["working_crs_name"])
        self.assertAlmostEqual(info["working_cell_x"], 77, delta=3)
        out = self.good("query", name, "--assign-crs", "EPSG:4326", "height", "7.52,46.52").stdout
        self.assertTrue(float(out.splitlines()[1].split(",")[2]) > 0)

    def test_no_crs_is_a_warning_and_metres(self):
        name = self.ascii_grid()
        done = self.good("render", name, "--size", "16x16", "--quiet")
        self.assertEqual(done.stdout, "")
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, lines)
        self.assertTrue(lines[0].startswith("warning: ") and "--assign-crs" in lines[0], lines)
        self.assertEqual(self.good("render", name, "--size", "16x16", "--quiet", "--assign-crs",
                                   "EPSG:32631").stderr, "")

    def test_crs_names_are_not_completed(self):
        name = self.ascii_grid()
        for crs in ("foo", "UTM zone 11", "32633"):
            self.fails(2, ["--assign-crs", crs], "info", name, "--assign-crs", crs)
        self.good("info", name, "--assign-crs", "WGS 84 / UTM zone 33N")

    def test_units_nodata_and_bands(self):
        name = self.ascii_grid(height=lambda x, y: 100.0 if x < 300 else 7.0)
        for unit, factor in (("m", 1), ("ft", 0.3048), ("us-ft", 1200 / 3937)):
            info = json.loads(self.good("info", name, "--height-unit", unit, "--json").stdout)
            self.assertAlmostEqual(info["max_height"], 100 * factor, places=4)
        info = json.loads(self.good("info", name, "--nodata", "7", "--json").stdout)
        self.assertEqual(info["min_height"], 100)
        self.assertGreater(info["holes"], 1000)
        self.fails(2, "--band", "info", name, "--band", "2")

    def test_all_holes(self):
        name = self.ascii_grid(height=lambda x, y: -9999)
        info = json.loads(self.good("info", name, "--json").stdout)
        self.assertIsNone(info["min_height"])
        done = self.good("render", name, "--size", "16x16")
        self.assertIn("no sample with a height", done.stderr)

    def test_values_of_every_kind(self):
        def odd(x, y):
            return {0: 3.4e38, 10: -1e30, 20: 1e-40, 30: 9000.0}.get(x, 5.0)
        name = self.ascii_grid(height=odd)
        self.gdal("gdal_translate", "-q", "-ot", "Float32", name, "odd.tif")
        self.good("render", "odd.tif", "--size", "48x32", "--samples", "1")
        for kind in ("Byte", "UInt16", "Int16", "UInt32", "Int32", "Float32", "Float64"):
            self.gdal("gdal_translate", "-q", "-ot", kind, self.ascii_grid(), f"{kind}.tif")
            out = self.good("query", f"{kind}.tif", "height", "100,100").stdout.splitlines()[1]
            self.assertAlmostEqual(float(out.split(",")[2]), hills(100, 100), delta=0.6)
        self.gdal("gdal_translate", "-q", "-ot", "CFloat32", self.ascii_grid(), "complex.tif")
        self.refused("complex", "complex.tif")

    def test_huge_coordinates_keep_centimetres(self):
        name = self.ascii_grid(columns=40, rows=40, cell=0.01, left=1e7, bottom=-1e7,
                               height=lambda x, y: 5 + x + 2 * y)
        out = self.good("query", name, "height", "10000000.105,-9999999.815").stdout.splitlines()[1]
        self.assertAlmostEqual(float(out.split(",")[2]), 5 + 0.105 + 2 * 0.185, places=4)
        self.good("render", name, "--size", "64x48", "--aov", "height=h.tif", "-o", "h.png")
        _, _, (heights,) = self.floats("h.tif")
        seen = [h for h in heights if not math.isnan(h)]
        self.assertGreater(len(seen), 200)
        self.assertTrue(all(5 <= h <= 6.2 for h in seen))

    def test_cameras_in_odd_places(self):
        name = self.ascii_grid()
        for flags in (["--eye", "320,240,6400000", "--pitch", "-90", "--heading", "0"],
                      ["--eye", "320,240,-50", "--pitch", "90", "--heading", "0"],
                      ["--eye", "320,240,+0", "--heading", "10", "--pitch", "0"],
                      ["--eye", "320,240,+1", "--heading", "77", "--pitch", "-90", "--roll", "33"],
                      ["--eye", "-5000,240,60", "--heading", "90", "--fov", "0.01"],
                      ["--eye", "320,240,+10", "--heading", "0", "--fov", "179"],
                      ["--projection", "panorama", "--eye", "320,240,+10"],
                      ["--projection", "ortho", "--heading", "30", "--pitch", "-40"]):
            for surface in ("bilinear", "constant"):
                self.good("render", name, "--size", "40x24", "--samples", "1", *flags, "--surface",
                          surface, "--exaggeration", "3")

    def test_memory_budget(self):
        self.fails(3, ["--memory", "GiB"], "render", "synthetic:fractal?size=16384", "--memory", "1GiB")
        self.fails(3, ["--memory"], "render", "synthetic:fractal?size=1024", "--memory", "16MiB")

    def test_interrupted_while_loading(self):
        run = subprocess.Popen([TERRAY, "render", "synthetic:fractal?size=8192", "--threads", "1"],
                               cwd=self.folder, stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(timeout=120), 130, run.stderr.read())
        run.stderr.close()
        self.assertEqual(self.left(), [])


if __name__ == "__main__":
    main()
