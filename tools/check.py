#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Runs every check of the tree, or those named; exit 1 and one line a fault if any fails.
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_layers
import check_text

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, **options)


def in_parallel(work, items):
    """Results of work(item), lists of faults, joined in order."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return [fault for faults in pool.map(work, items) for fault in faults]


def code_files(root):
    return [path for path in check_text.files_of(root) if check_text.is_code(path)]


def include_flags(build):
    """-I, -isystem and -D of all targets, from compile_commands.json."""
    commands = json.loads((build / "compile_commands.json").read_text())
    flags = {}
    for command in commands:
        words = command["command"].split()
        for word, following in zip(words, words[1:] + [""]):
            if word == "-isystem":
                flags[word + following] = None
            elif word.startswith(("-I", "-std=")) or word.startswith("-D") and '"' not in word:
                flags[word] = None
    return list(flags)


class Cache:
    """Remembers what passed, for all checkouts of a user: a key is the hash of all that the outcome depends on."""

    def __init__(self):
        home = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
        self.folder = pathlib.Path(home) / "terray-checks"
        self.folder.mkdir(parents=True, exist_ok=True)
        # Compilers and third-party headers.
        self.packages = run(["dpkg-query", "-W", "*-dev", "g++*", "clang-tidy*"]).stdout

    def passed(self, key):
        return (self.folder / key).exists()

    def note(self, key):
        (self.folder / key).touch()


def text_hash(root, path, *extra):
    """Hash of a file with all files of ours that it includes, and of what else the outcome depends on."""
    digest, seen, waiting = hashlib.sha256(repr(extra).encode()), set(), [path]
    while waiting:
        file = waiting.pop()
        text = file.read_bytes()
        digest.update(text)
        for name in re.findall(rb'^\s*#\s*include\s*[<"]([^>"]+)[>"]', text, re.MULTILINE):
            for folder in (root / "src", root / "include", file.parent):
                included = folder / name.decode()
                if included not in seen and included.is_file():
                    seen.add(included)
                    waiting.append(included)
    return digest.hexdigest()


def check_headers(root, build):
    """Each header compiles alone, with the warnings of the build as errors."""
    flags = include_flags(build)
    cache = Cache()

    def compile_alone(path):
        key = text_hash(root, path, "header", path.relative_to(root), cache.packages, [f.replace(str(root), ".") for f in flags])
        if cache.passed(key):
            return []
        result = run(["g++", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", *flags,
                      "-include", str(path), "-x", "c++", os.devnull])
        if result.returncode == 0:
            cache.note(key)
            return []
        return [f"{path.relative_to(root)}: does not compile alone:\n{result.stderr.strip()}"]

    def proven_by_build(path):
        """The source file beside it includes it before anything else."""
        source = path.with_suffix(".cpp")
        if not source.exists():
            return False
        first = re.search(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', source.read_text(), re.MULTILINE)
        return bool(first) and str(path).endswith("/" + first.group(1))

    headers = [p for p in code_files(root) if p.suffix == ".h" and not proven_by_build(p)]
    return in_parallel(compile_alone, headers)


def check_format(root, build):
    """clang-format would change nothing."""
    def dry_run(path):
        result = run(["clang-format", "--dry-run", "-Werror", str(path)])
        where = result.stderr.split(": error")[0].replace(f"{root}/", "")
        return [f"{where}: not formatted (clang-format -i)"] if result.returncode else []

    return in_parallel(dry_run, [p for p in code_files(root) if p.suffix != ".inl"])


def check_tidy(root, build):
    """clang-tidy with the rules of .clang-tidy; unit tests, and what passed before unchanged, are left out."""
    if not shutil.which("clang-tidy"):
        return ["clang-tidy is missing: scripts/install-deps"]
    # Several sources at a time, as the preset joins them: headers are read once for all.
    for command in (["cmake", "--preset", "tidy", "-S", str(root)],
                    ["cmake", "--build", str(root / "build/tidy"), "--target", "shaders"]):
        result = run(command)
        if result.returncode:
            return [f"{' '.join(command)} failed:\n{result.stdout}{result.stderr}"]
    return tidy_sources(root, root / "build/tidy")


def tidy_sources(root, joined):
    """clang-tidy on all of a build folder's translation units that are not of tests."""
    cache = Cache()
    config = (root / ".clang-tidy").read_text()
    commands = {c["file"]: c["command"] for c in json.loads((joined / "compile_commands.json").read_text())
                if "_test.dir/" not in c["command"]}

    def tidy(file):
        path = pathlib.Path(file)
        key = text_hash(root, path, "tidy", cache.packages, config, commands[file].replace(str(root), "."))
        if cache.passed(key):
            return []
        result = run(["clang-tidy", "-p", str(joined), "--quiet", file])
        if result.returncode == 0:
            cache.note(key)
            return []
        return [line.replace(f"{root}/", "") for line in result.stdout.splitlines() if " error: " in line] or [
            f"{path.name}: clang-tidy failed:\n{result.stdout}{result.stderr}"]

    return list(dict.fromkeys(in_parallel(tidy, commands)))


CHECKS = {
    "layers": lambda root, build: check_layers.check(root),
    "first lines": lambda root, build: check_text.check_first_lines(root),
    "sizes": lambda root, build: check_text.check_sizes(root),
    "words": lambda root, build: check_text.check_words(root),
    "names": lambda root, build: check_text.check_names(root),
    "links": lambda root, build: check_text.check_links(root),
    "readmes": lambda root, build: check_text.check_readmes(root),
    "format": check_format,
    "headers": check_headers,
    "tidy": check_tidy,
}


def main():
    parser = argparse.ArgumentParser(description="Runs the checks of the tree.")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release",
                        help="a configured build folder (for headers and tidy)")
    parser.add_argument("checks", nargs="*", help=f"default: all of {', '.join(CHECKS)}")
    options = parser.parse_args()
    unknown = [name for name in options.checks if name not in CHECKS]
    if unknown:
        parser.error(f"unknown check: {', '.join(unknown)}")
    failed = False
    for name in options.checks or CHECKS:
        start = time.monotonic()
        faults = list(CHECKS[name](ROOT, options.build.resolve()))
        print(f"{name}: {len(faults) or 'no'} faults ({time.monotonic() - start:.1f} s)", flush=True)
        for fault in faults:
            print(f"  {fault}")
        failed |= bool(faults)
    sys.exit(failed)


if __name__ == "__main__":
    main()
