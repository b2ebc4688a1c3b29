# SPDX-License-Identifier: Apache-2.0
# Stores over HTTP, from a server that also fails, stalls, cuts short and lies.
import csv
import http.server
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import harness


class Handler(http.server.BaseHTTPRequestHandler):
    """Files and parts of them; `server.trouble(path, n)` names what goes wrong with the nth request for a path."""
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = -1

    def do_HEAD(self):
        self.do_GET()

    def do_GET(self):
        server, name = self.server, self.path.lstrip("/").split("?")[0]
        with server.lock:
            server.requests.append((self.command, name, self.headers.get("Range", "")))
            trouble = server.trouble(name, sum(1 for r in server.requests if r[1] == name))
        file = os.path.join(server.folder, name.removeprefix("bucket/"))
        if not os.path.isfile(file):
            return self.answer(404, b"<html>nothing here</html>")
        with open(file, "rb") as data:
            content = data.read()
        wanted = re.fullmatch(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        headers, status, body = {}, 200, content
        if wanted and trouble != "no ranges":
            first, last = int(wanted[1]), min(int(wanted[2]), len(content) - 1)
            if trouble == "another range":
                first, last = max(0, first - 1), last - 1
            status, body = 206, content[first:last + 1]
            headers["Content-Range"] = f"bytes {first}-{last}/{len(content)}"
        if isinstance(trouble, int):
            return self.answer(trouble, b"<html>try later</html>", {"Location": self.path})
        if trouble == "page":
            return self.answer(200, b"<html>log in first</html>")
        if trouble == "lie":
            body = bytes(b ^ 255 for b in body)
        if trouble == "stall":
            server.stalled.set()
            server.release.wait(60)
            self.close_connection = True
            return None
        if trouble in ("cut", "hang up"):
            self.close_connection = True
            if trouble == "hang up":
                return None
            return self.answer(status, body[:len(body) // 2], {**headers, "Content-Length": str(len(body))})
        if trouble == "short":
            body = body[:len(body) // 2]
        return self.answer(status, body, headers)

    def answer(self, status, body, headers=None):
        self.send_response(status)
        for key, value in {"Content-Length": str(len(body)), **(headers or {})}.items():
            self.send_header(key, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)
        return None

    def handle(self):
        try:
            super().handle()
        except OSError:
            pass  # the other side has left

    def log_message(self, *_):
        pass


class RemoteTest(harness.CliTest):
    @classmethod
    def setUpClass(cls):
        """A store of 6 x 6 tiles, made once."""
        cls.shared = tempfile.mkdtemp(prefix="terray_remote_")
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        subprocess.run([harness.TERRAY, "bake", "synthetic:town?size=2600", "-o", "s.terray", "-q"], cwd=cls.shared, check=True)

    def setUp(self):
        super().setUp()
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        server.daemon_threads = True
        server.folder, server.requests, server.lock = self.shared, [], threading.Lock()
        server.trouble = lambda name, n: None
        server.stalled, server.release = threading.Event(), threading.Event()
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for clean in (server.server_close, server.shutdown, server.release.set):
            self.addCleanup(clean)
        self.server = server
        self.port = server.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/s.terray"
        os.environ["GDAL_HTTP_LOW_SPEED_TIME"] = "1"
        self.addCleanup(os.environ.pop, "GDAL_HTTP_LOW_SPEED_TIME")
        self.near = ["--eye", "1300,1300,+60", "--heading", "40", "--pitch=-20", "--size", "200x120"]

    def picture(self, source, *more):
        self.good("render", source, "-o", "x.png", *self.near, *more)
        with open(self.path("x.png"), "rb") as data:
            return data.read()

    def local(self):
        return self.picture(os.path.join(self.shared, "s.terray"))

    def names(self, part):
        return [r for r in self.server.requests if part in r[1]]

    def test_opens_and_reads_with_few_requests(self):
        self.good("info", self.url)
        mips = 4
        self.assertEqual(len(self.server.requests), 2 + mips, self.server.requests)
        self.server.requests.clear()
        local = self.local()
        for url in ("/vsicurl/" + self.url + "/", self.url + "?key=1"):
            self.assertEqual(self.picture(url), local, url)
        self.server.requests.clear()
        self.assertEqual(self.picture(self.url), local)
        self.assertEqual({r[0] for r in self.server.requests}, {"GET"})
        self.assertEqual(len(self.names("bounds/")), mips)
        self.assertEqual(self.names(".vrt") + self.names(".xml"), [])
        blocks = {r for r in self.names("height/m") if not r[2].startswith("bytes=0-")}
        headers = [r for r in self.names("height/m") if r[2].startswith("bytes=0-")]
        self.assertEqual(len(self.names("height/m")) - len(headers), len(blocks))  # none twice
        self.assertLessEqual(len(self.names("edges/")), len(blocks))
        self.assertLess(len(blocks), 36 + 9 + 4 + 1)  # only what the picture wants
        places = ["700,700", "1900.5,800"]
        answers = [self.good("query", source, "height", *places).stdout
                   for source in (os.path.join(self.shared, "s.terray"), self.url)]
        self.assertEqual(*answers)

    def test_what_goes_wrong_for_a_while_is_not_to_be_seen(self):
        """The first two answers for each file of tiles are wrong, each in another way; then those for all files fail once."""
        local = self.local()
        seen, troubles = [], (500, 503, 429, 302, "page", "lie", "short", "cut", "hang up", "another range", "no ranges")

        def spread(name, n):
            if n > 2 or not re.match("s.terray/(height|edges)", name):
                return None
            seen.append(troubles[len(seen) % len(troubles)])
            return seen[-1]

        self.server.trouble = spread
        self.assertEqual(self.picture(self.url), local)
        self.assertEqual(set(seen), set(troubles))
        for trouble in (503, "hang up"):
            self.server.requests.clear()
            self.server.trouble = lambda name, n: trouble if n == 1 else None
            self.assertEqual(self.picture(self.url), local, trouble)

    def test_stalled_reads_are_given_up_and_tried_again(self):
        self.server.trouble = lambda name, n: "stall" if n == 1 and name.endswith("m0/y2_x0.tif") else None
        self.assertEqual(self.picture(self.url), self.local())
        self.assertTrue(self.server.stalled.is_set())

    def test_tiles_that_cannot_be_had(self):
        for trouble in (503, "lie"):
            self.server.trouble = lambda name, n: trouble if "height/m0/y2" in name else None
            error = self.fails(1, ["tile (", "run again", "--allow-missing"], "render", self.url, "-o", "y.png", *self.near)
            self.assertNotIn("y.png", self.left())
            if trouble == 503:
                self.assertIn("HTTP status 503", error)
        self.picture(self.url, "--allow-missing", "--stats", "s.json")
        self.assertGreater(self.stats("s.json")["tiles_late"], 0)
        self.server.trouble = lambda name, n: None
        self.assertEqual(self.picture(self.url, "--allow-missing"), self.local())

    def test_stores_that_cannot_be_opened(self):
        for part, trouble, words in (("terrain.json", 503, "503"), ("terrain.json", "lie", "terrain.json"),
                                     ("terrain.json", "page", "terrain.json"), ("hashes.bin", "lie", "hashes.bin"),
                                     ("bounds/m0.tif", "short", "bounds/m0.tif"), ("bounds/m1.tif", 404, "404")):
            self.server.trouble = lambda name, n: trouble if name.endswith(part) else None
            self.fails(3, words, "info", self.url)
        self.server.trouble = lambda name, n: None
        self.fails(3, ["is not a store", "404"], "info", self.url.replace("s.terray", "none.terray"))
        self.fails(3, "is not a store", "info", "http://127.0.0.1:1/s.terray")

    def test_passwords_are_not_shown(self):
        secret = self.url.replace("//", "//me:secret@") + "?token=secret"
        said = self.good("info", secret, "--json").stdout
        self.server.trouble = lambda name, n: 503 if "height/m0/y2" in name else None
        said += self.fails(1, "tile (", "render", secret, "-o", "y.png", *self.near)
        self.server.trouble = lambda name, n: 403
        said += self.fails(3, "403", "info", secret)
        self.assertNotIn("secret", said)
        self.assertIn(self.url, said)

    def test_interrupts_end_stalled_reads(self):
        for part in ("terrain.json", "height/m0/"):
            self.server.stalled.clear()
            self.server.trouble = lambda name, n: "stall" if part in name else None
            environment = {**os.environ, "GDAL_HTTP_LOW_SPEED_TIME": "60"}
            running = subprocess.Popen([harness.TERRAY, "render", self.url, "-o", "y.png", *self.near], cwd=self.folder,
                                       env=environment, stderr=subprocess.PIPE)
            self.assertTrue(self.server.stalled.wait(60))
            running.send_signal(signal.SIGINT)
            running.communicate(timeout=20)
            self.assertEqual(running.returncode, 130)
        self.assertEqual(self.left(), [])

    def test_frames_keep_coming(self):
        """In real time, with tiles that fail at first: frames are made meanwhile, and the last one lacks nothing."""
        self.write("f.txt", "0 1300,1300,+60 40,-20\n5 1310,1310,+60 42,-20\n")
        for trouble in (503, "stall"):
            self.server.requests.clear()
            self.server.trouble = lambda name, n: trouble if "height/m0" in name and n <= 3 else None
            self.good("fly", self.url, "--flight", "f.txt", "--fps", 4, "--size", "96x64", "-o", "f/%03d.png", "--realtime",
                      "--stats", "f.csv")
            with open(self.path("f.csv"), newline="") as text:
                rows = list(csv.DictReader(text))
            self.assertGreater(len(rows), 3)  # a busy machine skips some
            self.assertGreater(float(rows[0]["tiles_absent"]), 0)
            self.assertEqual(float(rows[-1]["tiles_absent"]), 0, trouble)

    def test_stores_in_the_cloud(self):
        """Through GDAL's file layer, which caches: what was wrong is forgotten and asked for again."""
        settings = {"AWS_S3_ENDPOINT": f"127.0.0.1:{self.port}", "AWS_HTTPS": "NO", "AWS_VIRTUAL_HOSTING": "FALSE",
                    "AWS_NO_SIGN_REQUEST": "YES", "GDAL_HTTP_MAX_RETRY": "0"}
        os.environ.update(settings)
        for key in settings:
            self.addCleanup(os.environ.pop, key)
        local = self.local()
        self.assertEqual(self.picture("s3://bucket/s.terray"), local)
        for trouble in (503, "lie"):
            self.server.requests.clear()
            self.server.trouble = lambda name, n: trouble if n == 3 and "height/m0" in name else None
            self.assertEqual(self.picture("/vsis3/bucket/s.terray"), local, trouble)

    def test_dems_over_http(self):
        self.server.folder = self.folder
        self.ascii_grid("dem.asc")
        self.good("render", "dem.asc", "-o", "a.png", "--size", "96x64")
        self.good("render", f"http://127.0.0.1:{self.port}/dem.asc", "-o", "b.png", "--size", "96x64")
        with open(self.path("a.png"), "rb") as a, open(self.path("b.png"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.fails(3, ["none.asc", "cannot be opened"], "info", f"http://127.0.0.1:{self.port}/none.asc")

    def test_verify_over_http(self):
        self.good("verify", self.url)
        self.server.trouble = lambda name, n: "lie" if name.endswith("m0/y2_x0.tif") else None
        self.assertIn("tile (0, 2) of mip 0", self.terray("verify", self.url).stdout)


if __name__ == "__main__":
    harness.main()
