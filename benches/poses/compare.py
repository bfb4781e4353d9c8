"""Compares what the program says of a file's vertices (a line of JSON per time, on stdin) with `evaluate.py`.

Usage: compare.py FILE < LINES
"""

import json
import sys

import numpy as np

from evaluate import File, pose

# Single precision, over the few transforms between a vertex and the world.
TOLERANCE = 2e-6


def main():
    path = sys.argv[1]
    file = File(path)
    worst = 0.0
    for line in sys.stdin:
        found = json.loads(line)
        wanted = pose(file, found["seconds"])
        places = found["places"]
        if len(places) != len(wanted):
            sys.exit(f"{path}: {len(places)} places, {len(wanted)} are expected")
        for place, (name, corners) in zip(places, wanted):
            own = np.array(place["corners"])
            if place["name"] != name or own.shape != corners.shape:
                sys.exit(f"{path}: {place['name']} with {own.shape}, {name} with {corners.shape} is expected")
            size = np.abs(corners).max()
            error = np.abs(own - corners).max() / size
            worst = max(worst, error)
            if not error <= TOLERANCE:
                sys.exit(f"{path}: {name} after {found['seconds']} s is off by {error:.2e} of its size")
        print(f"{path}: {len(wanted)} places after {found['seconds']} s, off by at most {worst:.1e} of their size")


main()
