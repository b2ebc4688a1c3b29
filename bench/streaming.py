#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# A store far larger than memory: start, still, random flight within a budget, and flights in real time.
"""streaming.py TERRAY FOLDER [--source DEM] [--memory 512] [--seconds 20] [--fps 10] [--real DEM@LON,LAT ...] [--real-memory 160]

Bakes the source (terray's fractal of 16384 x 16384 floats unless given; with --source none: this part is left out) into FOLDER once, then
- renders a still on demand and whole, and compares the bytes;
- flies a random flight on demand, each frame waiting for its tiles, and fails where peak memory exceeds the budget, above what a
  2 x 2 DEM takes, by more than 64 MiB, or a frame lacks a tile.
Bakes each --real DEM once, too (a store is taken as it is). Over it and the source it flies from the place given, at 1.5, 30 and 250 m/s in real time (30 frames a
second at most, numbered JPEGs), and tells the share of hits that miss the tolerance for want of a tile after two seconds.
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


SPEEDS = (("walking, 1.5 m/s", 1.5, 2, 0.5), ("car, 30 m/s", 30, 5, 1), ("jet, 250 m/s", 250, 500, 5))


def flight_file(path, start, metres, inside, seconds, speed, seed, height, lonlat=False):
    """Key frames every two seconds that wander from a place, above the ground; `metres`: of one step in x and y."""
    dice = random.Random(seed)
    (x, y), heading = start, dice.uniform(0, 360)
    with open(path, "w") as text:
        text.write("lonlat\n" if lonlat else "")
        for k in range(seconds // 2 + 1):
            text.write(f"{2 * k} {x:.7f},{y:.7f},+{height} {heading:.2f},-10\n")
            heading += dice.uniform(-40, 40)
            for _ in range(36):
                angle = math.radians(heading)
                to = (x + 2 * speed * math.sin(angle) / metres[0], y + 2 * speed * math.cos(angle) / metres[1])
                if inside(*to):
                    break
                heading += 10
            x, y = to


def fly(terray, store, folder, film, flight, memory, *more):
    stats = os.path.join(folder, "flight.csv")
    run(terray, "fly", store, "--flight", flight, "-o", os.path.join(folder, film), "--memory", memory, "--stats", stats, *more)
    with open(stats) as text:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(text)]


def in_real_time(options, name, store, memory, write_flight):
    """A row for each speed; true if a goal is missed."""
    missed = False
    for title, speed, height, goal in SPEEDS:
        flight = os.path.join(options.folder, "live.txt")
        write_flight(flight, speed, height)
        rows = fly(options.terray, store, options.folder, "live/%05d.jpg", flight, f"{memory}MiB", "--size", options.size, "--fps", "30",
                   "--samples", str(options.samples), "--realtime")
        late = [r for r in rows if r["time"] >= 2]
        if "missing_tile_pixels" not in rows[0]:
            raise SystemExit(f"{name} fits into {memory} MiB")
        share = 100 * sum(r["missing_tile_pixels"] for r in late) / max(1, sum(r["hits"] for r in late))
        missed = missed or share > goal
        has_photo = "photo_missing_pixels" in rows[0]
        coarse = f"{100 * sum(r['photo_missing_pixels'] for r in late) / max(1, sum(r['hits'] for r in late)):.3f} %" if has_photo else "-"
        print(f"| {name}, {memory} MiB | {title} | {len(rows) / options.seconds:.1f} | {max(r['tiles_wanted'] for r in late):.0f} | "
              f"{max(r['tolerance_px'] for r in late):.2f} | {sum(r['tiles_loaded'] for r in late):.0f} | "
              f"{100 * sum(r['tiles_absent'] > 0 for r in late) / len(late):.1f} % | {share:.3f} % | {goal} % | {coarse} | "
              f"{rows[-1]['tile_latency_ms']:.1f}, {rows[-1]['tile_latency_p99_ms']:.0f} |", flush=True)
    return missed


def real_terrains(options):
    """The --real DEMs, baked: name, store, writer of flights."""
    for real in options.real:
        dem, place = real.rsplit("@", 1)
        lon, lat = (float(v) for v in place.split(","))
        name = os.path.splitext(os.path.basename(dem))[0]
        store = dem if dem.endswith(".terray") else os.path.join(options.folder, name + ".terray")
        if store != dem:
            run(options.terray, "bake", dem, "-o", store)
        degree = (111320 * math.cos(math.radians(lat)), 111320)
        yield name, store, lambda path, speed, height, start=(lon, lat), metres=degree: flight_file(
            path, start, metres, lambda x, y: True, options.seconds, speed, 2, height, lonlat=True)


def whole_and_on_demand(options, store, info, inside):
    """Stills and a flight that waits; whether something is wrong."""
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
    flight_file(flight, options.start, (1, 1), inside, options.seconds, 400, 1, 300)
    rows = fly(options.terray, store, options.folder, "random.mp4", flight, budget, "--size", options.size, "--fps", options.fps)
    above = max(row["peak_rss_bytes"] for row in rows) - idle
    times = sorted(row["setup_ms"] for row in rows)
    print(f"\nRandom flight at 400 m/s, {len(rows)} frames of {options.size}: {sum(r['tiles_loaded'] for r in rows):.0f} tiles loaded, "
          f"{sum(r['tiles_evicted'] for r in rows):.0f} evicted; set-up with waiting {times[len(times) // 2]:.1f} ms (median), "
          f"{times[-1]:.0f} ms at most; primary {sum(r['primary_ms'] for r in rows) / len(rows):.1f} ms a frame; "
          f"peak memory {above / MIB:.0f} MiB above idle, the film's encoder included.\n")
    wrong = []
    if not (same or reduced) or any(r["tiles_absent"] > 0 for r in rows):
        wrong.append("a picture lacks tiles")
    if above > (options.memory + 64) * MIB:
        wrong.append("more memory than the budget and 64 MiB")
    return wrong


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
    parser.add_argument("--samples", type=int, default=1, help="of frames in real time")
    parser.add_argument("--real", nargs="*", default=[], metavar="DEM@LON,LAT")
    parser.add_argument("--real-memory", type=int, default=160, help="MiB for those")
    options = parser.parse_args()
    os.makedirs(os.path.join(options.folder, "live"), exist_ok=True)
    live, wrong = [], []
    if options.source != "none":
        store = os.path.join(options.folder, "source.terray")
        run(options.terray, "bake", options.source, "-o", store)
        info = json.loads(run(options.terray, "info", store, "--json").stdout)
        x0, dx, _, y0, _, dy = info["geo_transform"]
        across, down = dx * info["columns"], dy * info["rows"]
        options.start = (x0 + across * 0.4, y0 + down * 0.4)

        def inside(x, y):
            return 0.1 < (x - x0) / across < 0.9 and 0.1 < (y - y0) / down < 0.9

        wrong += whole_and_on_demand(options, store, info, inside)
        live.append(("source", store, options.memory, lambda path, speed, height: flight_file(
            path, options.start, (1, 1), inside, options.seconds, speed, 2, height)))
    live += [(name, store, options.real_memory, write) for name, store, write in real_terrains(options)]
    print("| in real time | speed | frames a second | tiles wanted, most | tolerance drawn, px | tiles loaded | frames that lack a tile | "
          "hits that miss the tolerance | goal | hits that show a coarser photo | tile latency, median and 99 %, ms |\n|---|---|---|---|---|---|---|---|---|---|---|")
    for name, store, memory, write in live:
        if in_real_time(options, name, store, memory, write):
            wrong.append(f"{name}: more pixels miss the tolerance in real time than may")
    if wrong:
        raise SystemExit("; ".join(wrong))


main()
