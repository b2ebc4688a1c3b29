#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Bake beside gdal_translate -of COG on one float file: wall and CPU time, peak memory, size; paired runs.
"""bake_speed.py TERRAY FOLDER [--side 16384] [--runs 3] [--threads 2] [--source DEM]

Makes a float32 GeoTIFF of side x side posts in FOLDER (from DEM if given, else from terray's fractal through the
store), then bakes it and converts it to a COG with the same compression, error bound and threads, in turn."""
import argparse
import os
import shutil
import statistics
import subprocess
import time


def folder_bytes(path):
    if os.path.isfile(path):
        return os.path.getsize(path)
    return sum(os.path.getsize(os.path.join(where, name)) for where, _, names in os.walk(path) for name in names)


def measure(command):
    """(wall seconds, CPU seconds, peak MiB) of one command."""
    start = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    words = child.stderr.read().decode()
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.monotonic() - start
    if status != 0:
        raise SystemExit(f"{' '.join(command)}: {words}")
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def make_source(options, path):
    if os.path.exists(path):
        return
    synthetic = f"synthetic:fractal?size={options.side}&cell=10&seed=1"
    source = options.source
    if source is None:
        store = os.path.join(options.folder, "source.terray")
        measure([options.terray, "bake", synthetic, "-o", store, "-q"])
        source = os.path.join(store, "height.vrt")
    measure(["gdal_translate", "-q", "-ot", "Float32", "-outsize", str(options.side), str(options.side), "-r", "bilinear",
             "-co", "TILED=YES", "-co", "BLOCKXSIZE=512", "-co", "BLOCKYSIZE=512", "-co", "BIGTIFF=YES", source, path])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("terray")
    parser.add_argument("folder")
    parser.add_argument("--side", type=int, default=16384)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--source")
    parser.add_argument("--errors", default="0.01,0", help="error bounds in metres, 0: lossless")
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    dem = os.path.join(options.folder, f"dem{options.side}.tif")
    make_source(options, dem)
    results = {}
    threads = str(options.threads)
    for error in options.errors.split(","):
        store = os.path.join(options.folder, "bench.terray")
        cog = os.path.join(options.folder, "bench_cog.tif")
        lossy = ["-co", "COMPRESS=LERC_ZSTD", "-co", f"MAX_Z_ERROR={float(error) * 0.999}"]
        exact = ["-co", "COMPRESS=ZSTD", "-co", "PREDICTOR=FLOATING_POINT"]
        commands = {
            "bake": ([options.terray, "bake", dem, "-o", store, "-q", "--max-error", error, "--threads", threads], store),
            "COG": (["gdal_translate", "-q", "-of", "COG", "-co", "BLOCKSIZE=512", "-co", f"NUM_THREADS={threads}", "-co",
                     "BIGTIFF=YES", *(lossy if error != "0" else exact), dem, cog], cog),
        }
        for _ in range(options.runs):
            for name, (command, made) in commands.items():
                figures = measure(command)
                results.setdefault((error, name), []).append((*figures, folder_bytes(made) / 2**20))
                shutil.rmtree(made) if os.path.isdir(made) else os.remove(made)
    print("max error  program   wall s   CPU s  peak MiB  size MiB   (medians)")
    for (error, name), runs in results.items():
        wall, cpu, peak, size = (statistics.median(column) for column in zip(*runs))
        print(f"{error:>9}  {name:8} {wall:7.1f} {cpu:7.1f} {peak:9.0f} {size:9.1f}")


if __name__ == "__main__":
    main()
