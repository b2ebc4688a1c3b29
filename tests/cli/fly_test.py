# SPDX-License-Identifier: Apache-2.0
# terray fly from outside: films and pictures, killed and resumed runs, tracks, exit codes.
import csv
import os
import signal
import subprocess
import time

import harness

KEYS = "0 60,60,+150 45,-20\n2 300,200,+120 60,-25\n4 500,400,+150 look-at 300,300\n"
GPX = """<?xml version="1.0"?>
<gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>
<trkpt lat="46.0010" lon="9.0010">{0}</trkpt><trkpt lat="46.0025" lon="9.0030">{1}</trkpt>
<trkpt lat="46.0035" lon="9.0060">{2}</trkpt></trkseg></trk></gpx>"""


class FlyTest(harness.CliTest):
    def setUp(self):
        super().setUp()
        self.ascii_grid()
        self.write("f.txt", KEYS)
        self.common = ["fly", "dem.asc", "--flight", "f.txt", "--size", "96x64"]

    def bytes_of(self, name):
        with open(self.path(name), "rb") as data:
            return data.read()

    def test_makes_films_and_pictures_with_figures(self):
        done = self.good(*self.common, "--fps", 5, "-o", "a.mp4", "--stats", "a.csv")
        self.assertIn("21 frames", done.stdout)
        self.assertIn("--sun", done.stderr)
        self.good(*self.common, "--fps", 5, "-o", "a.webm", "-q", "--stats", "a.json")
        self.good(*self.common, "--fps", 5, "-o", "frames/%03d.jpg", "--frames", "3-5", "-q")
        self.assertEqual(self.left(), ["a.csv", "a.json", "a.mp4", "a.webm", "dem.asc", "f.txt", "frames"])
        self.assertEqual(sorted(os.listdir(self.path("frames"))), ["003.jpg", "004.jpg", "005.jpg"])
        with open(self.path("a.csv"), newline="") as text:
            rows = list(csv.DictReader(text))
        self.assertEqual([int(row["frame"]) for row in rows], list(range(21)))
        self.assertEqual(float(rows[-1]["time"]), 4.0)
        self.assertEqual(float(rows[10]["eye_x"]), 300.0)
        stats = self.stats("a.json")
        self.assertEqual((stats["made"], stats["found"], len(stats["frames"])), (21, 0, 21))

    def test_a_frame_is_the_still_of_its_view(self):
        self.good(*self.common, "--fps", 1, "-o", "%d.png", "--frames", "0", "--haze", 9)
        self.good("render", "dem.asc", "--eye", "60,60,+150", "--heading", 45, "--pitch", -20, "--size",
                  "96x64", "--sun", "315,40", "--haze", 9, "-o", "still.png")
        self.assertEqual(self.bytes_of("0.png"), self.bytes_of("still.png"))

    def test_killed_films_go_on_and_end_the_same(self):
        film = [*self.common, "--fps", 60, "-q"]
        self.good(*film, "-o", "whole.mp4")
        running = subprocess.Popen([harness.TERRAY, *map(str, film), "-o", "film.mp4"], cwd=self.folder)
        while running.poll() is None and not os.path.exists(self.path("film.mp4.parts/000000.mp4")):
            time.sleep(0.002)
        running.send_signal(signal.SIGKILL)
        running.wait()
        if running.returncode == 0:
            self.skipTest("the film was done before it could be killed")
        self.assertFalse(os.path.exists(self.path("film.mp4")))
        self.fails(2, ["--resume", "another film"], *film, "-o", "film.mp4", "--resume", "--samples", 1)
        self.good(*film, "-o", "film.mp4", "--resume", "--stats", "s.json")
        self.assertGreaterEqual(self.stats("s.json")["found"], 120)
        self.assertEqual(self.bytes_of("film.mp4"), self.bytes_of("whole.mp4"))
        self.assertEqual(self.left(), ["dem.asc", "f.txt", "film.mp4", "s.json", "whole.mp4"])

    def test_interrupted_runs_say_how_to_go_on(self):
        running = subprocess.Popen([harness.TERRAY, *map(str, self.common), "-o", "film.mp4", "--fps", "400"],
                                   cwd=self.folder, stderr=subprocess.PIPE, text=True)
        while running.poll() is None and not os.path.exists(self.path("film.mp4.parts/film.txt")):
            time.sleep(0.002)
        running.send_signal(signal.SIGINT)
        words = running.communicate()[1]
        self.assertEqual(running.returncode, 130)
        self.assertIn("--resume", words)
        self.assertFalse(os.path.exists(self.path("film.mp4")))

    def test_flies_along_tracks(self):
        self.ascii_grid("geo.asc", left=9.0, bottom=46.0, cell=0.0001)
        self.write("t.gpx", GPX.format("", "", ""))
        track = ["fly", "geo.asc", "--assign-crs", "EPSG:4326", "--flight", "t.gpx", "--size", "64x48",
                 "-o", "%d.png", "--fps", 2]
        self.fails(2, ["t.gpx", "--speed"], *track)
        done = self.good(*track, "--speed", 60, "--stats", "s.json")
        self.assertIn("--height-above-ground", done.stderr)
        # About 450 m of track.
        self.assertTrue(14 <= self.stats("s.json")["made"] <= 17, self.stats("s.json")["made"])
        moment = "<time>2024-05-01T10:00:0{}Z</time>"
        self.write("t.gpx", GPX.format(*(moment.format(k) for k in (0, 3, 7))))
        self.good(*track, "--stats", "s.json", "--height-above-ground", 90, "--pitch", -30)
        self.assertEqual(self.stats("s.json")["made"], 15)
        self.write("t.gpx", GPX.format(*(moment.format(k) for k in (0, 3, 2))))
        self.fails(3, ["t.gpx", "earlier"], *track)
        self.fails(2, "--lonlat", *track, "--lonlat")

    def test_bad_flights_are_input_errors_with_their_line(self):
        for text, words in (("", "f.txt:1"), (KEYS.splitlines()[0], "one key frame"),
                            ("0 1,2,3 4,5\n0 1,2,3 4,5\n", "f.txt:2"), ("0 nan,2,3 4,5\n", "f.txt:1"),
                            ("sway 3\n", "'sway'"), ("0 1,2,3 4,5\n9 99999,1,+3 4,5\n", "f.txt:2")):
            self.write("f.txt", text)
            self.fails(3, words, *self.common, "-o", "film.mp4")
        self.fails(3, "no such", "fly", "dem.asc", "--flight", "none.txt", "-o", "film.mp4")
        self.fails(3, "none.asc", "fly", "none.asc", "--flight", self.write("g.txt", KEYS), "-o", "f.mp4")
        self.assertEqual(self.left(), ["dem.asc", "f.txt", "g.txt"])

    def test_help_has_flags_and_examples(self):
        text = self.good("fly", "--help").stdout
        for word in ("--flight --lonlat --speed --height-above-ground --pitch --fov --output --size --fps --frames "
                     "--resume --realtime --stats --shading --sun --samples --memory film.webm hike.gpx").split():
            self.assertIn(word, text)

    def test_wrong_usage(self):
        self.fails(2, "--flight is missing", "fly", "dem.asc", "-o", "film.mp4")
        self.fails(2, "-o is missing", "fly", "dem.asc", "--flight", "f.txt")
        self.fails(2, "SOURCE", "fly", "--flight", "f.txt", "-o", "film.mp4")
        for words, *flags in (("even sides", "-o", "film.mp4", "--size", "95x64"),
                              ("neither a film", "-o", "film.avi"), ("an input", "-o", "f.txt"),
                              ("transparent", "-o", "film.mp4", "--background", "transparent"),
                              ("--realtime", "-o", "film.mp4", "--realtime", "--resume"),
                              ("--fps", "-o", "film.mp4", "--fps", "0"),
                              ("--fps", "-o", "film.mp4", "--fps", "30/0"),
                              ("--frames", "-o", "film.mp4", "--frames", "9-3"),
                              ("0 to 120", "-o", "film.mp4", "--frames", "9-999"),
                              ("tracks", "-o", "film.mp4", "--pitch", "-3"),
                              ("--stats", "-o", "film.mp4", "--stats", "figures"),
                              ("--speed", "-o", "film.mp4", "--speed", "0")):
            self.fails(2, words, *self.common, *flags)
        self.fails(1, "create the folder", *self.common, "-o", "none/film.mp4")
        self.assertEqual(self.left(), ["dem.asc", "f.txt"])

    def test_warns_of_rock_and_of_empty_frames(self):
        self.write("f.txt", "0 60,60,20 45,-20\n1 500,400,20 45,-20\n")
        self.assertIn("underground", self.good(*self.common, "-o", "%d.png", "--fps", 2).stderr)
        self.write("f.txt", "0 60,60,900 45,80\n1 500,400,900 45,80\n")
        self.assertIn("do not show", self.good(*self.common, "-o", "%d.png", "--fps", 2).stderr)


if __name__ == "__main__":
    harness.main()
