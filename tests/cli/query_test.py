# SPDX-License-Identifier: Apache-2.0
# `terray query`: inputs, outputs, and that it says what a picture says at every pixel.
import csv
import io
import json
import math

from harness import CliTest, hills, main


def answers(done):
    return list(csv.DictReader(io.StringIO(done.stdout)))


def axes(heading, pitch):
    """right, up, forward of a camera without roll."""
    h, p = math.radians(heading), math.radians(pitch)
    return ((math.cos(h), -math.sin(h), 0.0),
            (-math.sin(h) * math.sin(p), -math.cos(h) * math.sin(p), math.cos(p)),
            (math.sin(h) * math.cos(p), math.cos(h) * math.cos(p), math.sin(p)))


def pixel_ray(x, y, width, height, heading, pitch, fov):
    """Heading and pitch of the ray through a pixel's centre."""
    right, up, forward = axes(heading, pitch)
    scale = 2 * math.tan(math.radians(fov) / 2) / height
    a, b = (x + 0.5 - width / 2) * scale, (height / 2 - y - 0.5) * scale
    d = [forward[k] + a * right[k] + b * up[k] for k in range(3)]
    return (math.degrees(math.atan2(d[0], d[1])),
            math.degrees(math.atan2(d[2], math.hypot(d[0], d[1]))))


class Query(CliTest):
    def compare_with_picture(self, dem, flags, eye, heading, pitch, fov):
        width, height = 48, 36
        self.good("render", dem, *flags, "--size", f"{width}x{height}", "--eye", eye, "--heading",
                  heading, "--pitch", pitch, "--fov", fov, "--tolerance", "0", "-q", "--aov",
                  "distance=d.tif", "--aov", "position=p.tif", "--aov", "normal=n.tif", "--aov",
                  "height=h.tif")
        _, _, (distance,) = self.floats("d.tif")
        _, _, position = self.floats("p.tif")
        _, _, normal = self.floats("n.tif")
        _, _, (heights,) = self.floats("h.tif")
        x, y, z = eye.split(",")
        rows = ["x,y,z,heading,pitch"]
        for k in range(width * height):
            h, p = pixel_ray(k % width, k // width, width, height, heading, pitch, fov)
            rows.append(f"{x},{y},{z},{h!r},{p!r}")
        hits = answers(self.good("query", dem, *flags, "--from", "-", "ray",
                                 stdin="\n".join(rows)))
        self.assertEqual(len(hits), width * height)
        seen = 0
        for k, hit in enumerate(hits):
            self.assertEqual(hit["hit"] == "1", not math.isnan(distance[k]), k)
            if hit["hit"] == "0":
                continue
            seen += 1
            t = float(hit["distance"])
            self.assertAlmostEqual(t, distance[k], delta=1e-6 * t + 1e-4)
            for band, name, slack in ((0, "x", 0.05), (1, "y", 0.5), (2, "z", 2e-3)):
                self.assertAlmostEqual(float(hit[name]), position[band][k], delta=slack)
            self.assertAlmostEqual(float(hit["z"]), heights[k], delta=2e-3)
            for band, name in enumerate(("normal_x", "normal_y", "normal_z")):
                self.assertAlmostEqual(float(hit[name]), normal[band][k], delta=0.02)
        self.assertGreater(seen, 200)

    def test_rays_hit_what_pixels_show(self):
        self.compare_with_picture(self.ascii_grid(), [], "320.5,-150.25,260", 3, -25, 50)
        self.compare_with_picture(self.ascii_grid(), ["--surface", "constant"], "700.5,500.25,200",
                                  235, -20, 40)

    def test_rays_hit_what_pixels_show_over_a_curved_earth(self):
        dem = self.ascii_grid(cell=400, left=500000, bottom=5000000,
                              height=lambda x, y: hills(x / 40, y / 40))
        self.compare_with_picture(dem, ["--assign-crs", "EPSG:32632"], "512345.5,4995000.25,900", 5,
                                  -4, 30)

    def test_heights_of_posts(self):
        dem = self.ascii_grid()
        rows = answers(self.good("query", dem, "height", "100,200", "410,50", "-5,0", "0,0"))
        self.assertAlmostEqual(float(rows[0]["height"]), hills(100, 200), delta=1e-4)
        self.assertAlmostEqual(float(rows[1]["height"]), hills(410, 50), delta=1e-4)
        self.assertEqual(rows[2]["height"], "")
        self.assertAlmostEqual(float(rows[3]["height"]), hills(0, 0), delta=1e-4)

    def test_all_inputs_ask_the_same(self):
        dem = self.ascii_grid()
        wanted = self.good("query", dem, "height", "100,200", "300,20.5").stdout
        inputs = ["100,200\n300,20.5\n", "x,y\n100,200\n300,20.5\n", "# a comment\r\n100, 200\r\n300 ,20.5",
                  '\ufeff"x","note","y"\n"100","a, b","200"\n300,"",20.5\n',
                  "name,lat,lon\na,200,100\nb,20.5,300\n", "[[100,200],[300,20.5]]",
                  '[{"x":100,"y":200},{"lon":300,"lat":20.5,"name":"b"}]']
        for text in inputs:
            with self.subTest(text=text):
                self.assertEqual(self.good("query", dem, "height", "--from", "-", stdin=text).stdout,
                                 wanted)
                self.write("in.txt", text)
                self.good("query", dem, "height", "--from", "in.txt", "-o", "out.csv")
                with open(self.path("out.csv")) as out:
                    self.assertEqual(out.read(), wanted)

    def test_json_output(self):
        dem = self.ascii_grid()
        (inside, outside) = json.loads(self.good("query", dem, "height", "--json", "100,200",
                                                 "-100,0").stdout)
        self.assertAlmostEqual(inside["height"], hills(100, 200), delta=1e-4)
        self.assertIsNone(outside["height"])
        (hit, miss) = json.loads(self.good("query", dem, "ray", "--json", "100,200,+30,0,-90",
                                           "100,200,+30,0,90").stdout)
        self.assertIs(hit["hit"], True)
        self.assertAlmostEqual(hit["distance"], 30, delta=1e-3)
        self.assertIs(miss["hit"], False)
        self.assertIsNone(miss["distance"])

    def test_line_of_sight(self):
        dem = self.ascii_grid(height=lambda x, y: 50.0 if x == 320 else 0.0)
        rows = answers(self.good("query", dem, "line-of-sight", "100,100,2,600,100,2",
                                 "100,100,60,600,100,60", "100,100,+2,300,100,+2"))
        self.assertEqual([r["visible"] for r in rows], ["0", "1", "1"])
        self.assertAlmostEqual(float(rows[0]["blocked_x"]), 310.4, delta=1e-3)
        self.assertAlmostEqual(float(rows[0]["distance"]), 500)
        self.assertEqual(rows[1]["blocked_x"], "")
        text = "from_x,from_y,from_z,to_x,to_y,to_z\n100,100,,300,100,\n"
        (row,) = answers(self.good("query", dem, "line-of-sight", "--from", "-", stdin=text))
        self.assertEqual(row["visible"], "1")

    def test_degrees_and_data_coordinates_name_the_same_places(self):
        dem = self.ascii_grid(left=500000, bottom=0, cell=100)
        flags = ["--assign-crs", "EPSG:32631"]
        (here,) = answers(self.good("query", dem, *flags, "height", "--lonlat", "3.009,0.009"))
        # Near the equator on the central meridian: 0.9996 * 111.32 km, 110.57 km a degree.
        x, y = 500000 + 0.009 * 111319.5 * 0.9996, 0.009 * 110574.4 * 0.9996
        (there,) = answers(self.good("query", dem, *flags, "height", f"{x},{y}"))
        self.assertAlmostEqual(float(here["height"]), float(there["height"]), delta=0.05)

    def test_wrong_questions(self):
        dem = self.ascii_grid()
        self.fails(2, "'1'", "query", dem, "height", "1")
        self.fails(2, ["point 1", "'a'"], "query", dem, "height", "a,1")
        self.fails(2, "too many", "query", dem, "height", "1,2,3")
        self.fails(2, "'pitch'", "query", dem, "ray", "1,2,3,4")
        self.fails(2, "pitch", "query", dem, "ray", "1,2,3,4,95")
        self.fails(2, "same", "query", dem, "line-of-sight", "5,5,1,5,5,1")
        self.fails(2, "no ground", "query", dem, "ray", "-50,0,+1,0,0")
        self.fails(3, "none.csv", "query", dem, "height", "--from", "none.csv")
        self.fails(3, "line 2", "query", dem, "height", "--from", "-", stdin="x,y\n1\n")
        self.fails(3, "'y'", "query", dem, "height", "--from", "-", stdin="x,z\n1,2\n")
        self.fails(3, "JSON", "query", dem, "height", "--from", "-", stdin="[1,")
        self.fails(3, "item 1", "query", dem, "height", "--from", "-", stdin="[3]")
        self.fails(1, "none/o.csv", "query", dem, "height", "-o", "none/o.csv", "1,2")
        self.assertEqual(self.left(), ["dem.asc"])

    def test_nothing_in_nothing_out(self):
        dem = self.ascii_grid()
        done = self.good("query", dem, "height", "--from", "-", stdin="x,y\n")
        self.assertEqual(done.stdout, "x,y,height\n")


if __name__ == "__main__":
    main()
