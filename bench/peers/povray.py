#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The same view of a DEM by POV-Ray's height_field and by `terray render`: pictures side by side, seconds and peak memory.

  scripts/install-deps --bench
  bench/peers/povray.py BUILD_DIR DEM... [--out DIR] [--runs 3] [--size 1920x1080]

DEMs must be in a projected CRS (or in none) and north-up: POV-Ray knows no others. A scene as a POV-Ray user writes it: a smooth
height_field from a 16-bit PNG, a colour map by height, a sun with shadows, a fill light for the sky, fog, anti-aliasing
(+A0.3, up to 9 rays a pixel). POV-Ray's time is from the PNG on; making it from the DEM is not counted. All threads for both.
Pictures: OUT/NAME-povray.png and OUT/NAME-terray.png.
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import time

SCENE = """#version 3.7;
global_settings {{ assumed_gamma 1 }}
camera {{ perspective location <{eye[0]}, {eye[2]}, {eye[1]}> right x*image_width/image_height angle {angle}
         look_at <{aim[0]}, {aim[2]}, {aim[1]}> }}
light_source {{ <{aim[0]}, {aim[2]}, {aim[1]}> + {far}*<-0.5417, 0.6428, 0.5417> rgb 1.1*<1.00, 0.95, 0.86> parallel
               point_at <{aim[0]}, {aim[2]}, {aim[1]}> }}
light_source {{ <{aim[0]}, {aim[2]}, {aim[1]}> + {far}*<0, 1, 0> rgb 0.3*<0.55, 0.70, 1.00> shadowless }}
sky_sphere {{ pigment {{ gradient y color_map {{ [0 rgb <0.80, 0.85, 0.90>] [1 rgb <0.30, 0.45, 0.70>] }} }} }}
fog {{ distance {fog} rgb <0.80, 0.85, 0.90> }}
height_field {{ png "{png}" smooth
  scale <{width}, {range}, {depth}> translate <0, {low}, 0>
  texture {{ pigment {{ gradient y translate <0, 0, 0> scale {range} translate <0, {low}, 0> color_map {{
    [0.00 srgb <0.49, 0.57, 0.44>] [0.25 srgb <0.70, 0.72, 0.53>] [0.50 srgb <0.83, 0.73, 0.55>]
    [0.75 srgb <0.66, 0.52, 0.41>] [0.90 srgb <0.62, 0.60, 0.58>] [1.00 srgb <0.96, 0.96, 0.96>] }} }}
    finish {{ ambient 0.1 diffuse 0.8 }} }} }}
"""


def run(command):
    """(seconds, peak RSS in MiB) of a process; stops on failure."""
    start = time.monotonic()
    process = subprocess.Popen([str(c) for c in command], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{' '.join(map(str, command))}: {errors.decode()[-2000:]}")
    return time.monotonic() - start, usage.ru_maxrss / 1024


def median_of(runs, command):
    results = [run(command) for _ in range(runs)]
    return {"seconds": round(statistics.median(r[0] for r in results), 2), "peak_mib": round(max(r[1] for r in results))}


def compare(dem, args, width, height):
    name = dem.stem
    info = json.loads(subprocess.check_output(["gdalinfo", "-json", "-mm", dem]))
    columns, rows = info["size"]
    left, pixel_x, turn, top, _, pixel_y = info.get("geoTransform", [0, 1, 0, rows, 0, -1])
    if turn != 0 or pixel_y >= 0 or "GEOGCRS" in info.get("coordinateSystem", {}).get("wkt", "")[:8]:
        sys.exit(f"{dem}: give a north-up DEM in a projected CRS (gdalwarp -t_srs EPSG:n)")
    low, high = info["bands"][0]["computedMin"], info["bands"][0]["computedMax"]
    png = args.out / f"{name}-heights.png"
    run(["gdal_translate", "-q", "-of", "PNG", "-ot", "UInt16", "-scale", low, high, 0, 65535, dem, png])

    # From the south-south-west, 28 degrees down; metres from the lower left corner.
    wide, deep = (columns - 1) * pixel_x, (rows - 1) * -pixel_y
    aim = (wide / 2, deep / 2, low + (high - low) / 3)
    away = args.distance * math.hypot(wide, deep)
    heading, down = math.radians(22.5), math.radians(28)
    eye = (aim[0] - away * math.sin(heading) * math.cos(down), aim[1] - away * math.cos(heading) * math.cos(down),
           aim[2] + away * math.sin(down))
    fov = 45
    angle = 2 * math.degrees(math.atan(math.tan(math.radians(fov / 2)) * width / height))
    scene = args.out / f"{name}.pov"
    scene.write_text(SCENE.format(eye=eye, aim=aim, angle=angle, far=20 * away, fog=25 * away, png=png, width=wide, depth=deep,
                                  range=high - low, low=low))
    pictures = {peer: args.out / f"{name}-{peer}.png" for peer in ("povray", "terray")}
    povray = ["povray", f"+I{scene}", f"+O{pictures['povray']}", f"+W{width}", f"+H{height}", "+A0.3", "-D", "-GA", "+FN8"]

    def place(p):
        return f"{left + pixel_x / 2 + p[0]},{top + pixel_y * (rows - 0.5) + p[1]},{p[2]}"

    terray = [args.build / "bin" / "terray", "render", dem, "--eye=" + place(eye), "--look-at=" + place(aim), "--fov", fov,
              "--size", f"{width}x{height}", "-o", pictures["terray"], "--quiet", "--memory", "4GiB"]
    row = {"dem": name, "posts": f"{columns}x{rows}", "povray": median_of(args.runs, povray),
           "terray": median_of(args.runs, terray)}
    print(json.dumps(row), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("dems", type=pathlib.Path, nargs="+")
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--distance", type=float, default=0.75, help="of the eye, in diagonals of the DEM")
    args = parser.parse_args()
    args.out = args.out or args.build / "bench-data" / "povray"
    args.out.mkdir(parents=True, exist_ok=True)
    width, height = map(int, args.size.split("x"))
    for dem in args.dems:
        compare(dem, args, width, height)


if __name__ == "__main__":
    main()
