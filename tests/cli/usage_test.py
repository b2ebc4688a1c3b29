# SPDX-License-Identifier: Apache-2.0
# Wrong usage: exit code 2 (or 4), one line that names the option and says what to do.
import json
import os
import subprocess

from harness import TERRAY, CliTest, main


class Usage(CliTest):
    def test_help_and_version_of_every_command(self):
        commands = [[], ["info"], ["render"], ["query"], ["query", "x", "height"],
                    ["query", "x", "ray"], ["query", "x", "line-of-sight"], ["techniques"],
                    ["shadings"], ["devices"], ["bench"]]
        for command in commands:
            done = self.good(*command, "--help")
            self.assertGreater(len(done.stdout), 100, command)
            self.assertEqual(done.stderr, "")
            self.assertIn("xample", done.stdout, command)
        self.assertRegex(self.good("--version").stdout, r"\d+\.\d+\.\d+")

    def test_help_names_every_flag_of_render(self):
        text = self.good("render", "--help").stdout
        flags = """--assign-crs --crs --height-unit --nodata --band --encoding --photo --photo-bands
            --photo-stretch --eye --look-at --heading --pitch --roll --fov --size --lonlat --camera
            --projection --extent --samples --shading --contours --legend --scale-bar --north-arrow
            --base --relief-on-photo --ramp --sun --time --shadows --exaggeration --haze
            --background --surface --tolerance --curvature --refraction --technique --device --aov
            --stats --quiet --threads --memory --output""".split()
        for flag in flags:
            self.assertIn(flag, text)

    def test_commands(self):
        self.fails(2, ["command", "--help"])
        self.fails(2, ["'film'", "--help"], "film", "dem.tif")
        self.fails(2, ["'view'"], "view", "dem.tif")
        self.fails(2, ["SOURCE", "terray render --help"], "render")
        self.fails(2, ["'more'"], "info", "a.tif", "more")
        self.fails(2, ["--frobnicate", "terray render --help"], "render", "a.tif", "--frobnicate")
        self.fails(2, "'--siz' is not", "render", "a.tif", "--siz", "10x10", "--more")
        self.fails(2, "'-1,2' is not", "render", "a.tif", "-1,2", "b.tif")
        self.fails(2, ["--fov", "missing"], "render", "a.tif", "--fov")
        self.fails(2, ["terray query --help"], "query", "a.tif")
        self.fails(2, ["nothing is asked"], "query", "a.tif", "height")

    def test_values(self):
        wrong = {
            "--fov": ["0", "179.5", "nan", "inf", "wide", "", "1e999"], "--pitch": ["91", "-90.5", "x"],
            "--heading": ["north", "1e9"], "--size": ["0x10", "10", "10x", "10x-3", "1000001x1", "1.5x2"],
            "--eye": ["1", "1,2", "1,2,3,4", "a,b,c", "nan,0,1", "1,2,+", "1,,3"],
            "--samples": ["0", "3", "17", "two", "4.5"], "--exaggeration": ["0", "-1", "nan", "1001"],
            "--tolerance": ["-1", "nan"], "--refraction": ["1", "x"], "--shadows": ["yes", "1"],
            "--sun": ["10", "10,95", "a,b"], "--time": ["noon", "2024-13-01T00:00:00Z"],
            "--haze": ["-1", "x"], "--contours": ["-5", "nan"], "--background": ["red", "#12"],
            "--relief-on-photo": ["-1", "101"], "--shading": ["pretty"], "--surface": ["cubic"],
            "--technique": ["magic"], "--device": ["gpu"], "--curvature": ["maybe"],
            "--threads": ["0", "-2", "x"], "--memory": ["lots", "1", "-5GiB", "5XiB"],
            "--band": ["0", "x"], "--nodata": ["x"], "--height-unit": ["yd"], "--encoding": ["rgb"],
            "--projection": ["fisheye"], "--extent": ["1,2,3"], "--photo-bands": ["0", "1,2", "a"],
            "--photo-stretch": ["2", "98,2", "-1,50"], "--jpeg-quality": ["0", "101"],
            "--aov": ["distance", "distance=", "depht=a.tif", "depth=a.png", "depth=a"],
            "--output": ["a.xyz", "noextension"], "--stats": ["s.txt"],
        }
        for flag, values in wrong.items():
            for value in values:
                with self.subTest(flag=flag, value=value):
                    # The source does not exist: usage is judged before anything is read.
                    error = self.fails(2, [], "render", "missing.tif", f"{flag}={value}")
                    name = "a.xyz" if value == "a.xyz" else "noextension" if value == "noextension" \
                        else "magic" if value == "magic" else flag
                    self.assertIn(name, error)
        self.assertEqual(self.left(), [])

    def test_errors_are_one_line_whatever_the_names_hold(self):
        dem = self.ascii_grid()
        self.fails(3, "no?such.tif", "info", "no\nsuch.tif")
        self.write("bytes.txt", b"\xff\xfe\x00\x01\n1 2 3 4\n")
        self.fails(3, ["bytes.txt", "line 1", "colour name"], "render", dem, "--ramp", "bytes.txt")
        self.fails(3, ["'.'", "cannot be read"], "render", dem, "--ramp", ".")

    def test_negative_numbers_are_values(self):
        dem = self.ascii_grid(left=-500, bottom=-400)
        out = self.good("query", dem, "height", "-490,-390").stdout
        self.assertTrue(out.splitlines()[1].startswith("-490,-390,"), out)
        self.good("render", dem, "--size", "32x32", "--eye", "-200,-300,300", "--look-at",
                  "-180,-200", "-q")

    def test_flags_that_contradict_each_other(self):
        eye = ["--eye", "1,2,3"]
        for words, flags in [
            ("--fov", ["--projection", "panorama", "--fov", "45"]),
            ("--fov", ["--projection", "ortho", "--fov", "45"]),
            ("--roll", ["--projection", "panorama", "--roll", "0", *eye]),
            ("--extent", ["--extent", "0,0,1,1"]),
            ("--extent", ["--projection", "ortho", "--extent", "1,0,0,1"]),
            ("ortho", ["--projection", "ortho", *eye]),
            ("--curvature", ["--projection", "ortho", "--curvature", "on"]),
            ("--look-at", [*eye, "--look-at", "5,5", "--heading", "3"]),
            ("--look-at", ["--look-at", "5,5"]),
            ("--time", ["--time", "2024-06-21T12:00:00Z", "--sun", "1,2"]),
            ("--photo", ["--photo-bands", "1"]),
            ("--photo", ["--photo-stretch", "2,98"]),
            ("twice", ["-o", "a.tif", "--aov", "depth=a.tif"]),
            ("--legend", ["-o", "a.exr", "--legend"]),
        ]:
            with self.subTest(flags=flags):
                self.fails(2, words, "render", "missing.tif", *flags)

    def test_devices_that_are_not_there(self):
        self.fails(4, "--device vulkan", "render", "missing.tif", "--device", "vulkan:99")
        self.fails(4, "--device vulkan", "fly", "missing.tif", "--flight", "missing.txt", "-o", "a.mp4",
                   "--device", "vulkan:99")
        without = {**os.environ, "VK_DRIVER_FILES": "/dev/null"}
        done = subprocess.run([TERRAY, "render", "missing.tif", "--device", "vulkan"], env=without,
                              capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1), done.stderr)
        self.assertIn("--device cpu", done.stderr)

    def test_devices_are_listed(self):
        lines = self.good("devices").stdout.splitlines()
        self.assertTrue(lines[0].startswith("cpu"), lines)
        self.assertTrue(all(line.startswith("vulkan") for line in lines[1:]), lines)
        self.assertGreater(len(lines), 1)

    def test_camera_files(self):
        dem = self.ascii_grid()
        self.write("c.json", json.dumps({"eye": [300, 10, "+200"], "look_at": [300, 200],
                                         "fov": 30, "size": [40, 30]}))
        self.good("render", dem, "--camera", "c.json", "-o", "a.png")
        self.assertEqual(self.describe("a.png")["size"], [40, 30])
        self.good("render", dem, "--camera", "c.json", "--size", "20x10", "-o", "b.png")
        self.assertEqual(self.describe("b.png")["size"], [20, 10])
        for text in ["", "[]", "{\"eyes\": 1}", "{\"eye\": [1]}", "{\"fov\": \"wide\"}", "{"]:
            self.write("bad.json", text)
            self.fails(3, "bad.json", "render", dem, "--camera", "bad.json")
        self.fails(3, "none.json", "render", dem, "--camera", "none.json")

    def test_places_that_are_not_there(self):
        dem = self.ascii_grid()
        self.fails(2, ["--eye", "no ground"], "render", dem, "--eye", "-1000,0,+5", "--heading", "0")
        self.fails(2, ["--look-at", "no ground"], "render", dem, "--eye", "0,0,500", "--look-at",
                   "9000,9000")
        self.fails(2, "--lonlat", "render", dem, "--lonlat", "--eye", "3,4,500")
        self.fails(2, "--time", "render", dem, "--time", "2024-06-21T12:00:00Z")
        self.fails(2, "--curvature", "render", dem, "--curvature", "on")
        self.assertEqual(self.left(), ["dem.asc"])

    def test_closed_or_full_standard_output(self):
        dem = self.ascii_grid()
        for arguments in (["--help"], ["shadings"], ["info", dem], ["query", dem, "height", "5,5"]):
            read_end, write_end = os.pipe()
            os.close(read_end)
            done = subprocess.run([TERRAY, *arguments], cwd=self.folder, stdout=write_end,
                                  stderr=subprocess.PIPE, text=True)
            os.close(write_end)
            self.assertEqual(done.returncode, 1, done.stderr)
            with open("/dev/full", "w") as full:
                done = self.terray(*arguments, stdout=full)
            self.assertEqual(done.returncode, 1)
            self.assertIn("standard output", done.stderr)


if __name__ == "__main__":
    main()
