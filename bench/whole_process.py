#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times and weighs whole `terray render` processes: from files to a picture, cold application, warm page cache.

  bench/whole_process.py BUILD_DIR [--runs 5] [--large] [--only NAME]

Makes its inputs with terray itself (4096 x 4096 heights at 10 m and a photo of the same place) below
BUILD_DIR/bench-data. --large adds 16384 x 16384 float heights, made on demand by the synthetic source.
--only measures the cases whose names hold NAME (and 2 x 2, which the others are weighed against).
Exit code 1 if heights of 4096 x 4096 take more than 5 (16 bit) or 8 (float) bytes a sample.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

FRACTAL = "synthetic:fractal?size=4097&cell=10"


def run(command):
    """(seconds, peak RSS in bytes) of a process; stops on failure."""
    start = time.monotonic()
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.monotonic() - start
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{' '.join(map(str, command))}: {errors.decode()}")
    return seconds, usage.ru_maxrss * 1024


def make_inputs(terray, folder):
    folder.mkdir(parents=True, exist_ok=True)
    heights, codes, photo = (folder / n for n in ("heights_4096_float.tif", "heights_4096_int16.tif", "photo_4096.tif"))
    if not photo.exists():
        ortho = [terray, "render", FRACTAL, "--projection", "ortho", "--size", "4096x4096", "--quiet", "--tolerance", "0"]
        run(ortho + ["--aov", f"height={heights}", "-o", folder / "unused.png", "--samples", "1", "--shadows", "off"])
        run(["gdal_translate", "-q", "-ot", "Int16", heights, codes])
        run(ortho + ["--shading", "ramp", "-o", photo, "--samples", "1"])
    tiny = folder / "tiny.asc"
    tiny.write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2\n3 4\n")
    return heights, codes, photo, tiny


def measure(name, command, runs, samples=0, floor=0, most=None):
    results = [run(command) for _ in range(runs)]
    row = {"case": name, "seconds": round(statistics.median(r[0] for r in results), 3),
           "peak_rss_mib": round(max(r[1] for r in results) / 2**20, 1)}
    if samples:
        row["bytes_per_sample_above_2x2"] = round((max(r[1] for r in results) - floor) / samples, 2)
    print(json.dumps(row), flush=True)
    if most and row["bytes_per_sample_above_2x2"] > most:
        sys.exit(f"{name}: more than {most} bytes a sample")
    return max(r[1] for r in results)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    terray = args.build / "bin" / "terray"
    folder = args.build / "bench-data"
    heights, codes, photo, tiny = make_inputs(terray, folder)
    picture = ["--size", "1920x1080", "-o", folder / "picture.png", "--quiet"]
    samples = 4096 * 4096
    floor = measure("2 x 2", [terray, "render", tiny, *picture], args.runs)
    cases = [("4096^2 int16", [codes], samples, 5), ("4096^2 float", [heights], samples, 8),
             ("4096^2 int16 + photo", [codes, "--photo", photo], 0, None),
             ("4096^2 float + photo", [heights, "--photo", photo], 0, None)]
    if args.large:
        source = "synthetic:fractal?size=16384&cell=5&format=float"
        cases.append(("16384^2 float, --memory 4GiB", [source, "--memory", "4GiB"], 16384 * 16384, None))
    for name, inputs, weighed, most in cases:
        if args.only in name:
            runs = args.runs if most or not weighed else max(1, args.runs // 2)
            measure(name, [terray, "render", *inputs, *picture], runs, weighed, floor, most)


if __name__ == "__main__":
    main()
