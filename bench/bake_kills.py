#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Kills a bake at random moments, again and again, and compares the store with an uninterrupted one.
"""bake_kills.py TERRAY DEM FOLDER [--kills 50] [--seed 1]

After every kill the journal must hold all files that it held before: what is finished is never made again."""
import argparse
import filecmp
import os
import random
import shutil
import signal
import subprocess
import time


def same(a, b):
    match = filecmp.dircmp(a, b)
    if match.left_only or match.right_only or match.funny_files:
        return False
    _, different, errors = filecmp.cmpfiles(a, b, match.common_files, shallow=False)
    return not different and not errors and all(
        same(os.path.join(a, name), os.path.join(b, name)) for name in match.common_dirs)


def finished(work):
    """Paths and inodes of the height files that are there: one that is made again gets a new inode."""
    found = {}
    for where, _, names in os.walk(os.path.join(work, "height")):
        for name in names:
            if name.endswith(".tif"):
                path = os.path.join(where, name)
                found[path] = os.stat(path).st_ino
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("terray")
    parser.add_argument("dem")
    parser.add_argument("folder")
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    good, out = (os.path.join(options.folder, name) for name in ("good.terray", "killed.terray"))
    for path in (good, out, out + ".baking"):
        shutil.rmtree(path, ignore_errors=True)
    start = time.monotonic()
    subprocess.run([options.terray, "bake", options.dem, "-o", good, "-q"], check=True)
    duration = time.monotonic() - start
    rng = random.Random(options.seed)
    again = rounds = met = 0
    while met < options.kills:
        before = finished(out + ".baking")
        process = subprocess.Popen([options.terray, "bake", options.dem, "-o", out, "-q"])
        time.sleep(rng.uniform(0, duration))
        process.send_signal(signal.SIGKILL)
        met += process.wait() == -signal.SIGKILL
        after = finished(out + ".baking")
        # one file per core may have been renamed but not journalled
        again += sum(after.get(path) not in (None, inode) for path, inode in before.items())
        if os.path.exists(out):
            if not same(good, out):
                raise SystemExit("the store differs from the uninterrupted one")
            rounds += 1
            shutil.rmtree(out)
    subprocess.run([options.terray, "bake", options.dem, "-o", out, "-q"], check=True)
    if not same(good, out):
        raise SystemExit("the store differs from the uninterrupted one")
    print(f"{met} kills over {rounds + 1} bakes of {duration:.1f} s: same bytes; "
          f"{again} files were made twice (renamed, but not yet in the journal)")


if __name__ == "__main__":
    main()
