#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Checks every #include against layers.txt: downward only, third-party headers in their own rooms.
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
SYSTEM = re.compile(r'^(\w+|sys/\w+\.h|\w*intrin\.h|(unistd|fcntl|signal|malloc|string|math|std\w+|errno)\.h)$')
SOURCES = {".h", ".cpp", ".inl"}


def read_rules(path):
    """layers: folder -> number; allowed: pairs on one layer; third_party: prefix -> rooms."""
    layers, allowed, third_party = {}, set(), {}
    for line in path.read_text().splitlines():
        word, *rest = line.split("#")[0].split() or [""]
        if word == "layer":
            layers.update({folder: int(rest[0]) for folder in rest[1:]})
        elif word == "allow":
            allowed.add((rest[0], rest[1]))
        elif word == "third_party":
            third_party[rest[0]] = set(rest[1:])
    return layers, allowed, third_party


def room_of(path):
    """src/kernel/simd/x.cpp -> kernel; include/terray/x.h -> include; apps/cli/x.cpp -> apps."""
    return path.parts[1] if path.parts[0] == "src" else path.parts[0]


def fault_of(path, kind, target, rules):
    """What is wrong with one include, or None."""
    layers, allowed, third_party = rules
    room, into = room_of(path), target.split("/")[0]
    is_test = re.search("_test$|^test_", path.stem) or room == "tests"
    if into == "terray":
        return None
    if kind == "<" or any(target.startswith(p) for p in third_party if p.endswith("/")):
        if SYSTEM.match(target):
            return None
        rooms = next((r for p, r in third_party.items() if target.startswith(p)), None)
        if rooms is None:
            return "third-party header without a third_party line in layers.txt"
        if "*" in rooms and room != "include" or room in rooms or is_test:
            return None
        return f"only {', '.join(sorted(rooms))} may include it, not {room}"
    if "/" not in target:
        return None if room in ("apps", "bench", "examples", "tests") else "write the whole path from src/"
    if room in ("include", "apps", "examples"):
        return f"{room} may only include terray/ headers"
    if room in ("bench", "tests") or is_test:
        return None
    if room not in layers or into not in layers:
        return f"no layer for {room if room not in layers else into} in layers.txt"
    if room == "technique" == into and path.parts[2:3] != tuple(target.split("/")[1:2]) \
            and target.count("/") > 1 and len(path.parts) > 3:
        return "techniques do not include one another"
    if into == room or layers[into] < layers[room] or (room, into) in allowed:
        return None
    return f"layer {layers[room]} ({room}) may not include layer {layers[into]} ({into})"


def check(root):
    """One line for each forbidden include: file:line: the include, and why."""
    root = pathlib.Path(root)
    rules = read_rules(root / "layers.txt")
    faults = []
    for top in ("include", "src", "apps", "bench", "examples", "tests"):
        for path in sorted(p for p in (root / top).rglob("*") if p.suffix in SOURCES):
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                fault = match and fault_of(path.relative_to(root), *match.groups(), rules)
                if fault:
                    faults.append(f"{path.relative_to(root)}:{number}: {line.strip()}: {fault}")
    return faults


if __name__ == "__main__":
    found = check(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    print("\n".join(found) or "layers: ok")
    sys.exit(bool(found))
