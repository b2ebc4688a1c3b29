#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# A store far larger than memory: start, still, random flight within a budget, and flights in real time.
"""streaming.py TERRAY FOLDER [--source DEM] [--memory 512] [--seconds 20] [--fps 10]

Bakes the source (terray's fractal of 16384 x 16384 floats unless given) into FOLDER once, then
- renders a still on demand and whole, and compares the bytes;
- flies a random flight on demand, each frame waiting for its tiles, and fails where peak memory exceeds the budget, above what a
  2 x 2 DEM takes, by more than 64 MiB, or a frame lacks a tile;
- flies at 1.5, 30 and 250 m/s in real time and tells the share of frames that lack a tile after two seconds.
Markdown on standard output."""
import argparse
import csv
import json
import math
import os
import random
import subprocess

MIB = 1 << 20


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: {done.stderr}")
    return done


def still(terray, store, folder, name, memory, *more):
    picture, stats = (os.path.join(folder, f"{name}.{kind}") for kind in ("png", "json"))
    said = run(terray, "render", store, "-o", picture, "--memory", memory, "--stats", stats, *more).stderr
    with open(picture, "rb") as data, open(stats) as text:
        return data.read(), {**json.load(text), "is_reduced": "memory holds" in said}


def idle_bytes(terray, folder):
    """Peak memory of a process that draws next to nothing."""
    dem = os.path.join(folder, "tiny.asc")
    with open(dem, "w") as text:
        text.write("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2\n3 4\n")
    return still(terray, dem, folder, "tiny", "512MiB")[1]["peak_rss_bytes"]


def flight_file(path, info, seconds, speed, seed, height):
    """Key frames every two seconds that wander over the middle of the terrain, above the ground."""
    dice = random.Random(seed)
    x0, y0, dx, dy = info["geo_transform"][0], info["geo_transform"][3], info["geo_transform"][1], info["geo_transform"][5]
    across, down = dx * info["columns"], dy * info["rows"]
    x, y, heading = x0 + across * 0.4, y0 + down * 0.4, dice.uniform(0, 360)
    with open(path, "w") as text:
        for k in range(seconds // 2 + 1):
            text.write(f"{2 * k} {x:.2f},{y:.2f},+{height} {heading:.2f},-10\n")
            heading += dice.uniform(-40, 40)
            step = 2 * speed
            for _ in range(36):
                to = (x + step * math.sin(math.radians(heading)), y + step * math.cos(math.radians(heading)))
                if 0.1 < (to[0] - x0) / across < 0.9 and 0.1 < (to[1] - y0) / down < 0.9:
                    break
                heading += 10
            x, y = to


def fly(terray, store, folder, name, flight, memory, *more):
    film, stats = os.path.join(folder, f"{name}.mp4"), os.path.join(folder, f"{name}.csv")
    run(terray, "fly", store, "--flight", flight, "-o", film, "--memory", memory, "--stats", stats, *more)
    with open(stats) as text:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(text)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("terray")
    parser.add_argument("folder")
    parser.add_argument("--source", default="synthetic:fractal?size=16384&cell=5&format=float")
    parser.add_argument("--memory", type=int, default=512, help="MiB")
    parser.add_argument("--whole", default="4GiB", help="a budget that the whole terrain fits into")
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--fps", default="10")
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    store = os.path.join(options.folder, "source.terray")
    run(options.terray, "bake", options.source, "-o", store)
    info = json.loads(run(options.terray, "info", store, "--json").stdout)
    budget = f"{options.memory}MiB"
    idle = idle_bytes(options.terray, options.folder)

    print(f"{info['columns']} x {info['rows']} posts; budget {options.memory} MiB\n")
    print("| still | load ms | set-up ms | total ms | tolerance, px | tiles held MiB | peak above idle, MiB |\n|---|---|---|---|---|---|---|")
    pictures, reduced = [], False
    for name, memory in (("on demand", budget), ("whole", options.whole)):
        picture, s = still(options.terray, store, options.folder, "still", memory)
        pictures.append(picture)
        reduced = reduced or s["is_reduced"]
        print(f"| {name} | {s['load_ms']:.0f} | {s['setup_ms']:.0f} | {s['total_ms']:.0f} | {s['tolerance_px']:.2f} | "
              f"{s['resident_bytes'] / MIB:.0f} | {(s['peak_rss_bytes'] - idle) / MIB:.0f} |")
    same = pictures[0] == pictures[1]
    print("\nThe two pictures are " + ("equal to the byte." if same else "different" + (
        ": the budget holds too few tiles, and the program said so." if reduced else "!")))

    flight = os.path.join(options.folder, "random.txt")
    flight_file(flight, info, options.seconds, 400, 1, 300)
    rows = fly(options.terray, store, options.folder, "random", flight, budget, "--size", options.size, "--fps", options.fps)
    above = max(row["peak_rss_bytes"] for row in rows) - idle
    times = sorted(row["setup_ms"] for row in rows)
    print(f"\nRandom flight at 400 m/s, {len(rows)} frames of {options.size}: {sum(r['tiles_loaded'] for r in rows):.0f} tiles loaded, "
          f"{sum(r['tiles_evicted'] for r in rows):.0f} evicted; set-up with waiting {times[len(times) // 2]:.1f} ms (median), "
          f"{times[-1]:.0f} ms at most; primary {sum(r['primary_ms'] for r in rows) / len(rows):.1f} ms a frame; "
          f"peak memory {above / MIB:.0f} MiB above idle, the film's encoder included.\n")

    print("| in real time | frames | frames that lack a tile after 2 s | that draw one in place of a finer one |\n|---|---|---|---|")
    for name, speed, height in (("walking, 1.5 m/s", 1.5, 2), ("car, 30 m/s", 30, 5), ("jet, 250 m/s", 250, 500)):
        flight_file(flight, info, options.seconds, speed, 2, height)
        late = [r for r in fly(options.terray, store, options.folder, "live", flight, budget, "--size", options.size,
                               "--fps", options.fps, "--realtime") if r["time"] >= 2]
        lack, drawn = (sum(r[key] > 0 for r in late) / len(late) for key in ("tiles_absent", "tiles_late"))
        print(f"| {name} | {len(late)} | {100 * lack:.1f} % | {100 * drawn:.1f} % |")

    if not (same or reduced) or any(r["tiles_absent"] > 0 for r in rows):
        raise SystemExit("a picture lacks tiles")
    if above > (options.memory + 64) * MIB:
        raise SystemExit("more memory than the budget and 64 MiB")


main()
