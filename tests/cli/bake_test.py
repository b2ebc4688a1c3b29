# SPDX-License-Identifier: Apache-2.0
# Stores from outside: same picture, same bytes after kills, damage named and mended, GDAL opens the parts.
import functools
import http.server
import json
import math
import os
import random
import re
import signal
import subprocess
import threading
import time
import unittest

import harness


def files_of(folder):
    """Relative path to content of all files."""
    found = {}
    for where, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(where, name)
            with open(path, "rb") as data:
                found[os.path.relpath(path, folder)] = data.read()
    return found


class RangeHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files, parts of them too, as web servers do."""

    def do_GET(self):
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        path = self.translate_path(self.path)
        if not wanted or not os.path.isfile(path):
            return super().do_GET()
        first, last = int(wanted[1]), min(int(wanted[2]), os.path.getsize(path) - 1)
        with open(path, "rb") as data:
            data.seek(first)
            content = data.read(last - first + 1)
        self.send_response(206)
        self.send_header("Content-Range", f"bytes {first}-{last}/{os.path.getsize(path)}")
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        pass


class BakeTest(harness.CliTest):
    def dem(self, size=1400):
        """A float DEM, quick to make and slow enough to bake that a kill meets it."""
        self.ascii_grid("small.asc", columns=80, rows=80, cell=10.0, left=500000, bottom=5200000)
        self.gdal("gdal_translate", "-q", "-a_srs", "EPSG:32632", "-ot", "Float32", "-outsize", size, size, "-r",
                  "cubic", "small.asc", "dem.tif")
        return "dem.tif"

    def test_a_store_larger_than_memory_gives_the_same_pictures_and_numbers(self):
        self.good("bake", self.dem(2600), "-o", "s.terray", "--max-error", "0.05")
        views = [[], ["--eye", "500300,5200200,+40", "--heading", "50", "--pitch=-10"],
                 ["--projection", "ortho", "--extent", "500100,5200100,500300,5200300", "--samples", "1"]]
        for view in views:
            for name, memory in (("whole", "1GiB"), ("part", "100MiB")):
                self.good("render", "s.terray", "-o", f"{name}.png", "--size", "320x180", "--memory", memory,
                        "--stats", f"{name}.json", *view)
            whole, part = self.stats("whole.json"), self.stats("part.json")
            self.assertEqual(whole["tiles_per_mip"], part["tiles_per_mip"])
            self.assertLess(part["resident_bytes"], 0.95 * whole["resident_bytes"])
            with open(self.path("whole.png"), "rb") as a, open(self.path("part.png"), "rb") as b:
                self.assertEqual(a.read(), b.read(), view)
        rays = [f"{500050 + 35 * k},{5200100 + 23 * k},+{20 * k + 1},{37 * k},{-3 * k}" for k in range(20)]
        for kind, places in (("height", [",".join(ray.split(",")[:2]) for ray in rays]), ("ray", rays)):
            answers = [self.good("query", "s.terray", "--memory", memory, kind, *places).stdout
                       for memory in ("1GiB", "100MiB")]
            self.assertEqual(answers[0], answers[1])
        self.fails(3, "--memory", "render", "s.terray", "-o", "x.png", "--memory", "16MiB")
        self.damaged_tiles()

    def damaged_tiles(self):
        """A still fails, unless tiles may be missing: then coarser ones stand in, and a warning names each once."""
        path = self.path("s.terray/height/m0/y2_x0.tif")
        with open(path, "r+b") as shard:
            shard.seek(os.path.getsize(path) // 2)
            shard.write(bytes(20000))
        near = ["--eye", "500400,5200400,+300", "--heading", "0", "--pitch=-85", "--memory", "100MiB", "--size", "160x90",
                "--tolerance", "0.02"]
        self.fails(1, ["tile (", "--allow-missing"], "render", "s.terray", "-o", "x.png", *near)
        self.assertNotIn("x.png", self.left())
        done = self.good("render", "s.terray", "-o", "y.png", "--allow-missing", "--stats", "y.json", *near)
        stats = self.stats("y.json")
        self.assertGreater(stats["tiles_absent"], 0)
        self.assertGreater(stats["tiles_late"], 0)
        named = [line for line in done.stderr.splitlines() if "stands in" in line]
        self.assertEqual(len(named), len(set(named)))
        self.assertGreater(len(named), 0)

    def gdal(self, program, *arguments):
        return super().gdal(program, *map(str, arguments))

    def test_lossless_store_gives_the_same_picture_and_answers(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "a.terray", "--max-error", "0")
        places = ["500321.5,5200654.25", "500100,5200300"]
        for source, name in ((dem, "dem"), ("a.terray", "store")):
            self.good("render", source, "-o", name + ".png", "--size", "200x120")
            with open(self.path(name + ".csv"), "w") as out:
                out.write(self.good("query", source, "height", *places).stdout)
        for kind in ("png", "csv"):
            with open(self.path("dem." + kind), "rb") as a, open(self.path("store." + kind), "rb") as b:
                self.assertEqual(a.read(), b.read(), kind)

    def photo(self, dem):
        """A photo of another CRS and finer pixels than the DEM, over part of it."""
        self.good("render", dem, "--projection", "ortho", "--size", "600x600", "-o", "map.tif", "-q")
        self.gdal("gdalwarp", "-q", "-t_srs", "EPSG:32633", "-dstalpha", "-te_srs", "EPSG:32632", "-te", 500200, 5200100,
                  500700, 5200600, "-tr", 1.1, 1.1, "map.tif", "photo.tif")
        return "photo.tif"

    def test_store_with_a_photo(self):
        dem = self.dem(300)
        photo = self.photo(dem)
        self.good("bake", dem, "--photo", photo, "--photo-quality", "lossless", "--max-error", 0, "-o", "exact.terray")
        self.good("bake", dem, "--photo", photo, "--max-error", 0, "-o", "small.terray")
        for name in ("exact", "small"):
            self.assertIn("whole", self.good("verify", name + ".terray").stdout)
        pixels = {}
        for name, source in (("direct", [dem, "--photo", photo]), ("exact", ["exact.terray"]), ("small", ["small.terray"])):
            self.good("render", *source, "--relief-on-photo", 0, "--size", "200x120", "-o", name + ".png")
            pixels[name] = harness.read_png(self.path(name + ".png"))
        self.assertEqual(pixels["exact"], pixels["direct"])
        self.assertNotEqual(pixels["small"], pixels["direct"])
        facts = json.loads(self.good("info", "small.terray", "--json").stdout)
        self.assertIn("photo.tif", facts["photo"])
        self.assertIn("warped", facts["photo"])
        self.assertNotIn("photo", self.good("query", "small.terray", "height", "500500,5200300").stderr)
        self.good("bake", dem, "-o", "bare.terray")
        self.fails(2, "--relief-on-photo", "render", "bare.terray", "--relief-on-photo", 20)
        self.fails(2, "--photo-quality", "bake", dem, "--photo", photo, "--photo-quality", 101, "-o", "x.terray")
        self.fails(2, "--photo", "bake", dem, "--photo-quality", 80, "-o", "x.terray")
        self.fails(3, "missing.tif", "bake", dem, "--photo", "missing.tif", "-o", "x.terray")

    def test_gdal_opens_the_photo(self):
        dem = self.dem(300)
        photo = self.photo(dem)
        for quality in ("90", "lossless"):
            self.good("bake", dem, "--photo", photo, "--photo-quality", quality, "-o", quality + ".terray", "-q")
            vrt = quality + ".terray/photo.vrt"
            facts = json.loads(self.gdal("gdalinfo", "-json", vrt))
            self.assertEqual([band["colorInterpretation"] for band in facts["bands"]], ["Red", "Green", "Blue", "Alpha"])
            columns, rows = facts["size"]
            halves = [tuple(overview["size"]) for overview in facts["bands"][0]["overviews"]]
            self.assertEqual(halves[0], ((columns + 1) // 2, (rows + 1) // 2))
            x, y = 500560.0, 5200310.0  # a place on the ground: the photo there, and its coarser mip
            value = [list(map(int, self.gdal("gdallocationinfo", "-valonly", *overview, "-l_srs", "EPSG:32632", name, x,
                                             y).split())) for name, overview in ((photo, ()), (vrt, ()), (vrt, ("-overview", 1)))]
            self.assertEqual(len(value[1]), 4)
            for channel in range(4):
                self.assertLess(abs(value[1][channel] - value[0][channel]), 12, value)
                self.assertLess(abs(value[2][channel] - value[0][channel]), 20, value)
            outside = self.gdal("gdallocationinfo", "-valonly", vrt, 0, 0).split()
            self.assertEqual(outside[3], "0")

    def test_unlike_dems_are_joined_the_last_one_on_top(self):
        self.ascii_grid("coarse.asc", columns=40, rows=40, cell=20.0, left=500000, bottom=5200000, height=lambda x, y: 100.0)
        self.ascii_grid("fine.asc", columns=40, rows=40, cell=5.0, left=500303, bottom=5200302, height=lambda x, y: 200.0)
        for name in ("coarse", "fine"):
            self.gdal("gdal_translate", "-q", "-a_srs", "EPSG:32632", name + ".asc", name + ".tif")
        self.gdal("gdalwarp", "-q", "-t_srs", "EPSG:32633", "-dstnodata", -9999, "fine.tif", "other.tif")
        for last in ("fine", "other"):
            store = last + ".terray"
            self.good("bake", "coarse.tif", last + ".tif", "-o", store)
            rows = self.good("query", store, "height", "500100,5200100", "500400,5200400", "-q").stdout.splitlines()[1:]
            for row, height in zip(rows, (100, 200)):
                self.assertAlmostEqual(float(row.split(",")[-1]), height, delta=0.011)
        self.good("bake", "fine.tif", "coarse.tif", "-o", "covered.terray")
        row = self.good("query", "covered.terray", "height", "500400,5200400", "-q").stdout.splitlines()[1]
        self.assertAlmostEqual(float(row.split(",")[-1]), 100, delta=0.011)

    def test_a_source_in_place_is_mip_0_and_must_stay_as_it_is(self):
        self.dem(700)
        tiled = ["-co", "TILED=YES", "-co", "BLOCKXSIZE=512", "-co", "BLOCKYSIZE=512", "-a_nodata", 61]
        os.mkdir(self.path("stores"))
        for kind in ("Int16", "Float32"):
            source = kind + ".tif"
            self.gdal("gdal_translate", "-q", "-ot", kind, *tiled, "dem.tif", source)
            self.good("bake", source, "-o", "stores/in.terray", "--max-error", 0, "--in-place", "-q")
            self.good("bake", source, "-o", "stores/copy.terray", "--max-error", 0, "-q")
            self.good("verify", "stores/in.terray")
            copied, used = files_of(self.path("stores/copy.terray")), files_of(self.path("stores/in.terray"))
            self.assertEqual(set(copied) - set(used), {"height/m0/y0_x0.tif", "height/m0/y1_x0.tif"})
            told = {"terrain.json", "hashes.bin", "height.vrt"}
            self.assertEqual({name: copied[name] for name in used if name not in told},
                             {name: used[name] for name in used if name not in told})
            for name in ("in", "copy"):
                self.good("render", f"stores/{name}.terray", "-o", name + ".png", "--size", "200x120", "-q")
            self.assertEqual(harness.read_png(self.path("in.png")), harness.read_png(self.path("copy.png")))
            for place in ((333, 222), (600, 650)):
                self.assertEqual(*(self.gdal("gdallocationinfo", "-valonly", f"stores/{name}.terray/height.vrt", *place)
                                   for name in ("in", "copy")))
            os.rename(self.path("stores"), self.path("moved"))  # one level up is one level up
            self.good("info", "moved/in.terray")
            os.rename(self.path("moved"), self.path("stores"))
            os.utime(self.path(source), (1, 1))
            self.fails(3, [source, "has changed"], "render", "stores/in.terray", "-o", "x.png")
            self.fails(1, "damaged in 1 place", "verify", "stores/in.terray")
            os.remove(self.path(source))
            self.fails(3, [source, "not there"], "info", "stores/in.terray")
        self.fails(3, ["--in-place", "512 x 512"], "bake", "dem.tif", "-o", "x.terray", "--in-place")

    def test_killed_at_random_moments_the_result_is_the_same(self):
        dem = self.dem()
        started = time.monotonic()
        self.good("bake", dem, "-o", "good.terray")
        duration = time.monotonic() - started
        good = files_of(self.path("good.terray"))
        rng = random.Random(5)
        for _ in range(8):
            process = subprocess.Popen([harness.TERRAY, "bake", dem, "-o", "a.terray", "-q"], cwd=self.folder,
                                       stderr=subprocess.PIPE)
            time.sleep(rng.uniform(0, duration))
            process.send_signal(signal.SIGKILL)
            process.wait()
            process.stderr.close()
            if os.path.exists(self.path("a.terray")):
                self.good("verify", "a.terray")
        self.good("bake", dem, "-o", "a.terray")
        self.assertEqual(files_of(self.path("a.terray")), good)
        self.assertEqual([name for name in self.left() if name.startswith("a.terray")], ["a.terray"])

    def test_interrupted_says_that_it_goes_on(self):
        dem = self.dem()
        process = subprocess.Popen([harness.TERRAY, "bake", dem, "-o", "a.terray"], cwd=self.folder,
                                   stderr=subprocess.PIPE, text=True)
        while not os.path.exists(self.path("a.terray.baking/journal.bin")) and process.poll() is None:
            time.sleep(0.005)
        process.send_signal(signal.SIGINT)
        words = process.communicate()[1]
        if process.returncode == 0:
            self.skipTest("the machine was quicker than the signal")
        self.assertEqual(process.returncode, 130, words)
        self.assertIn("the same command goes on", words)
        self.good("bake", dem, "-o", "a.terray")
        self.good("verify", "a.terray")

    def test_damage_is_named_and_mended(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "a.terray")
        good = files_of(self.path("a.terray"))
        path = self.path("a.terray/height/m0/y1_x0.tif")
        with open(path, "r+b") as data:
            data.seek(os.path.getsize(path) - 200)
            byte = data.read(1)
            data.seek(-1, 1)
            data.write(bytes([byte[0] ^ 255]))
        done = self.terray("verify", "a.terray")
        self.assertEqual(done.returncode, 1)
        self.assertIn("height/m0/y1_x0.tif: tile (1, 1) of mip 0 is damaged", done.stdout)
        self.good("bake", dem, "-o", "a.terray", "--resume")
        self.assertEqual(files_of(self.path("a.terray")), good)
        self.assertIn("whole", self.good("verify", "a.terray").stdout)

    def test_wrong_uses(self):
        dem = self.dem(200)
        self.fails(2, "--max-error", "bake", dem, "-o", "a.terray", "--max-error", "-1")
        self.fails(2, "-o", "bake", dem)
        self.fails(3, "missing.tif", "bake", "missing.tif", "-o", "a.terray")
        self.fails(1, "a.terray", "bake", dem, "-o", "no/such/folder/a.terray")
        self.fails(3, "not a store", "render", "a.terray")
        self.fails(3, "not a store", "verify", "a.terray")
        os.mkdir(self.path("taken"))
        self.fails(1, ["taken", "no store"], "bake", dem, "-o", "taken")
        self.good("bake", dem, "-o", "a.terray")
        self.fails(2, ["--nodata", "is a store"], "render", "a.terray", "--nodata", "5")
        self.good("bake", self.dem(), "-o", "large.terray")
        self.fails(3, ["large.terray", "--memory"], "render", "large.terray", "--memory", "16MiB")
        os.remove(self.path("a.terray/bounds/m0.tif"))
        self.fails(3, "bounds/m0.tif", "render", "a.terray")
        self.write("a.terray/terrain.json", "{")
        self.fails(3, ["terrain.json", "damaged"], "info", "a.terray")

    def test_info_says_what_is_in_it(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "a.terray", "--max-error", "0.5")
        info = json.loads(self.good("info", "a.terray", "--json").stdout)
        plain = json.loads(self.good("info", dem, "--json").stdout)
        self.assertEqual(info["driver"], "Terray store")
        for same in ("columns", "rows", "working_columns", "mips", "geo_transform", "holes"):
            self.assertEqual(info[same], plain[same], same)
        self.assertAlmostEqual(info["max_height"], plain["max_height"], delta=0.5)
        self.assertIn("within 0.5 m", " ".join(info["assumptions"]))

    def test_exported_cog_holds_the_mips(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "a.terray", "--max-error", "0", "--export-cog", "cog.tif")
        cog = self.describe("cog.tif")
        self.assertEqual(cog["metadata"]["IMAGE_STRUCTURE"]["LAYOUT"], "COG")
        self.assertEqual(cog["size"], [701, 701])  # 700 posts in 2 n + 1
        self.assertEqual([o["size"] for o in cog["bands"][0]["overviews"]], [[351, 351]])
        _, _, (values,) = self.floats("cog.tif")
        _, _, (exact,) = self.floats(dem)
        for row in (0, 511, 512, 699):
            self.assertEqual(values[row * 701:row * 701 + 700], exact[row * 700:row * 700 + 700], row)
        self.assertTrue(math.isnan(values[700]) and math.isnan(values[-1]))
        self.gdal("gdal_translate", "-q", "-ovr", "0", "-outsize", "351", "351", "cog.tif", "overview.tif")
        self.assertEqual(self.floats("overview.tif")[2][0], self.floats("a.terray/height/m1.vrt")[2][0])
        self.assertEqual([name for name in self.left() if "cog" in name], ["cog.tif"])
        self.fails(1, "no/cog.tif", "bake", dem, "-o", "a.terray", "--export-cog", "no/cog.tif")

    def test_a_store_over_http_gives_the_same_picture(self):
        self.good("bake", self.dem(700), "-o", "a.terray")
        handler = functools.partial(RangeHandler, directory=self.folder)
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.addCleanup(server.server_close)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.shutdown)
        url = f"/vsicurl/http://127.0.0.1:{server.server_address[1]}/"
        for source, name in (("a.terray", "local.png"), (url + "a.terray", "remote.png")):
            self.good("render", source, "-o", name, "--size", "200x120")
        with open(self.path("local.png"), "rb") as a, open(self.path("remote.png"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.fails(3, "not a store", "info", url + "b.terray")

    def test_tiles_of_a_dem_make_the_store_of_the_whole(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "whole.terray", "--max-error", "0")
        for name, window in (("a", (0, 0, 400, 700)), ("b", (399, 0, 301, 420)), ("c", (380, 400, 320, 300))):
            self.gdal("gdal_translate", "-q", "-srcwin", *window, dem, name + ".tif")
        self.good("bake", "c.tif", "a.tif", "b.tif", "-o", "tiles.terray", "--max-error", "0")
        whole, tiles = (files_of(self.path(name + ".terray")) for name in ("whole", "tiles"))
        # VRTs and the manifest may spell the CRS in another way
        posts = [name for name in whole if name.endswith((".tif", ".bin")) and name != "hashes.bin"]
        self.assertGreater(len(posts), 5)
        for name in posts:
            self.assertTrue(whole[name] == tiles[name], name)
        self.assertIn("c.tif", self.good("info", "tiles.terray").stdout)

    def test_gdal_opens_each_part_with_the_right_values(self):
        dem = self.dem(700)
        self.good("bake", dem, "-o", "a.terray", "--max-error", "0")
        self.assertEqual(self.describe("a.terray/height.vrt")["size"], [700, 700])
        self.assertEqual(self.floats("a.terray/height.vrt")[2][0], self.floats(dem)[2][0])
        source, store = self.describe(dem), self.describe("a.terray/height.vrt")
        self.assertEqual(store["geoTransform"], source["geoTransform"])
        self.assertIn("UTM zone 32N", store["coordinateSystem"]["wkt"])
        self.assertEqual([o["size"] for o in store["bands"][0]["overviews"]], [[351, 351]])
        mip1 = self.describe("a.terray/height/m1.vrt")
        pixel = source["geoTransform"][1]
        self.assertAlmostEqual(mip1["geoTransform"][1], 2 * pixel, places=9)
        self.assertAlmostEqual(mip1["geoTransform"][0] + pixel, source["geoTransform"][0] + pixel / 2, places=6)
        bounds = self.describe("a.terray/bounds/m0.tif")
        self.assertEqual((bounds["size"], len(bounds["bands"])), ([16, 16], 8))
        part = self.describe("a.terray/height/m0/y1_x0.tif")
        self.assertEqual((part["size"], part["bands"][0]["block"]), ([700, 188], [512, 512]))


if __name__ == "__main__":
    harness.main()
