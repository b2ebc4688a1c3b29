# SPDX-License-Identifier: Apache-2.0
"""Draws the primary rays a second of `terray-bench peers --json` as bars, one group a camera.

  bench/peers/report.py LINES.jsonl -o CHART.svg [--threads 1] [--who NAME ...] [--title TEXT]
"""
import argparse
import json
import pathlib
import sys
from xml.sax.saxutils import escape

COLOURS = ["#1f6f5c", "#7fb7a3", "#30445c", "#7088a3", "#a9b8c9", "#c9a86a", "#d9c8a0"]
SHOWN = ["ray_cast", "packets", "embree triangles i16", "embree grid i16", "embree triangles i1"]
LEFT, TOP, PLOT, BOTTOM, BAR, GAP = 64, 74, 300, 54, 18, 26
FONT = 'font-family="DejaVu Sans, Helvetica, Arial, sans-serif"'


def read_lines(path, threads):
    """{camera: {who: M rays/s}} of the primary rays, in the order of the file, and any line.
    One thread counts by its processor time, which other programs disturb less."""
    speed = "mrays_per_cpu_s" if threads == 1 else "mrays_per_s"
    cameras, some = {}, None
    for text in path.read_text().splitlines():
        line = json.loads(text)
        if line.get("bench") != "peers" or line["kind"] != "primary" or line["threads"] != threads:
            continue
        cameras.setdefault(line["camera"], {})[line["who"]] = line[speed]
        some = line
    if some is None:
        sys.exit(f"{path}: no primary rays with {threads} threads")
    return cameras, some


def nice_step(largest):
    """A round step that gives four to eight lines."""
    step = 1.0
    while largest / step > 8:
        step *= 2.5 if f"{step:g}".startswith("2") else 2
    return step


def label(x, y, text, size=12, anchor="middle", colour="#222", extra=""):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{colour}" '
            f'{FONT} {extra}>{escape(text)}</text>')


def legend(names, y):
    parts, x = [], LEFT
    for name, colour in zip(names, COLOURS):
        parts.append(f'<rect x="{x}" y="{y - 10}" width="12" height="12" rx="2" fill="{colour}"/>')
        parts.append(label(x + 18, y, name, anchor="start"))
        x += 34 + 7.2 * len(name)
    return parts, x


def chart(cameras, names, title):
    largest = max(speeds.get(name, 0) for speeds in cameras.values() for name in names)
    step = nice_step(largest)
    top = step * -(-largest // step)
    group = BAR * len(names) + GAP
    keys, keys_width = legend(names, TOP - 22)
    width = max(LEFT + group * len(cameras) + 16, keys_width)
    height = TOP + PLOT + BOTTOM
    body = [label(LEFT, 26, title, 15, "start", "#111", 'font-weight="bold"'), *keys]
    tick = 0.0
    while tick <= top + 1e-9:
        y = TOP + PLOT - PLOT * tick / top
        body.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{width - 12:.1f}" y2="{y:.1f}" stroke="#e1e4e8"/>')
        body.append(label(LEFT - 8, y + 4, f"{tick:g}", 11, "end", "#555"))
        tick += step
    for index, (camera, speeds) in enumerate(cameras.items()):
        x = LEFT + GAP / 2 + group * index
        for name, colour in zip(names, COLOURS):
            if name in speeds:
                bar = PLOT * speeds[name] / top
                body.append(f'<rect x="{x:.1f}" y="{TOP + PLOT - bar:.1f}" width="{BAR - 2}" height="{bar:.1f}" '
                            f'rx="1.5" fill="{colour}"/>')
                value = f"{speeds[name]:.0f}" if speeds[name] >= 9.95 else f"{speeds[name]:.1f}"
                body.append(label(x + BAR / 2 - 1, TOP + PLOT - bar - 4, value, 9, colour="#444"))
            x += BAR
        body.append(label(LEFT + group * (index + 0.5), TOP + PLOT + 20, camera))
    body.append(label(16, TOP + PLOT / 2, "M rays/s", 12, colour="#555",
                      extra=f'transform="rotate(-90 16 {TOP + PLOT / 2})"'))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height}" '
            f'viewBox="0 0 {width:.0f} {height}">\n<rect width="100%" height="100%" fill="#fff"/>\n'
            + "\n".join(body) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lines", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--who", action="append", help="contenders to show (default: some of them)")
    parser.add_argument("--title")
    options = parser.parse_args()
    cameras, some = read_lines(options.lines, options.threads)
    known = {name for speeds in cameras.values() for name in speeds}
    names = [name for name in options.who or SHOWN if name in known]
    if not names:
        sys.exit(f"{options.lines}: has none of them, only {', '.join(sorted(known))}")
    threads = f"{options.threads} thread" + ("" if options.threads == 1 else "s")
    target = f"both {some['isa'].upper()}" if some.get("isa") else some["target"]
    title = options.title or f"{pathlib.PurePath(some['terrain']).name}, {some['surface']}, {threads}, {target}"
    options.output.write_text(chart(cameras, names[:len(COLOURS)], title))


if __name__ == "__main__":
    main()
