#!/usr/bin/env python3
"""Our reading of a frame beside the pixel stages that one would write with OpenCV, on the very same frames.

    cargo build -p acquirer --example frame_time      (the reading is fully optimised in this profile, too)
    python3 tests/compare/opencv_stages.py [--sizes 640x480,1280x720] [--rounds 5] [--program PATH]

Prints a Markdown table: CPU time per frame (median over rounds, one thread) and the ratios. In each round OpenCV's two
variants and our program run one after the other, so that a slow minute of the machine hits all. OpenCV only labels
pixels and finds blobs where rows and columns cross; it does not decode: our time is that from frame to labelled grid.

natural  HSV, background test against mean and deviation in float, opening, inRange per colour, Sobel magnitude,
         connected components, goodFeaturesToTrack
tuned    the same in 8 bits with reused buffers: full-circle hue, classes by LUT, spatialGradient, components of the
         places where dilated rows and columns meet
"""
import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: this needs numpy and OpenCV. Install them outside of the repository:\n"
             "  python3 -m venv /tmp/compare && /tmp/compare/bin/pip install numpy opencv-contrib-python-headless\n"
             "and run this script with /tmp/compare/bin/python")

ROOT = Path(__file__).resolve().parents[2]
SIGMAS = 4.0                      # a pixel is foreground this many standard deviations from the background
LEAST_SIGMA = {"hue": 2.0, "saturation": 4.0}     # two black frames can't show less; OpenCV's units
LEAST_EDGE = 60                   # Sobel magnitude of an edge
KERNEL = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
# The shipped grid's colours as ranges of OpenCV's hue (0 to 179): red comes twice, at both ends.
HUES = {"red": ((0, 14), (170, 179)), "yellow": ((15, 44),), "green": ((45, 89),), "magenta": ((135, 169),)}


class Background:
    """Mean and threshold of hue and saturation, per pixel, from the frames under black."""

    def __init__(self, frames, code, circle):
        hsv = np.stack([cv2.cvtColor(frame, code)[..., :2] for frame in frames]).astype(np.float32)
        self.mean_hue, self.mean_sat = (np.ascontiguousarray(hsv.mean(0)[..., k]) for k in (0, 1))
        spread = hsv.std(0)
        least = (LEAST_SIGMA["hue"] * circle / 180, LEAST_SIGMA["saturation"])
        self.far_hue, self.far_sat = (SIGMAS * np.maximum(spread[..., k], least[k]).astype(np.float32) for k in (0, 1))
        self.bytes = [np.rint(np.clip(plane, 0, 255)).astype(np.uint8)
                      for plane in (self.mean_hue, self.mean_sat, self.far_hue, self.far_sat)]


class Natural:
    def __init__(self, black):
        self.back = Background(black, cv2.COLOR_BGR2HSV, 180)

    def __call__(self, frame):
        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV)
        hue, sat, _ = cv2.split(hsv)
        off_hue = cv2.absdiff(hue.astype(np.float32), self.back.mean_hue)
        off_hue = cv2.min(off_hue, 180.0 - off_hue)
        off_sat = cv2.absdiff(sat.astype(np.float32), self.back.mean_sat)
        mask = cv2.bitwise_or(cv2.compare(off_hue, self.back.far_hue, cv2.CMP_GT),
                              cv2.compare(off_sat, self.back.far_sat, cv2.CMP_GT))
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, KERNEL)
        classes = [self.of_hue(hsv, mask, ranges) for ranges in HUES.values()]
        grey = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
        grey = cv2.bitwise_and(grey, grey, mask=mask)
        edge = cv2.magnitude(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
        edge = cv2.threshold(edge, LEAST_EDGE, 255, cv2.THRESH_BINARY)[1]
        blobs = cv2.connectedComponentsWithStats(mask)
        apart = 5.0 * max(1.0, frame.shape[1] / 640)
        corners = cv2.goodFeaturesToTrack(grey, 1000, 0.05, apart, mask=mask)
        return classes, edge, blobs, corners

    @staticmethod
    def of_hue(hsv, mask, ranges):
        found = [cv2.inRange(hsv, (low, 40, 30), (high, 255, 255)) for low, high in ranges]
        found = found[0] if len(found) == 1 else cv2.bitwise_or(*found)
        return cv2.bitwise_and(found, mask)


class Tuned:
    def __init__(self, black):
        self.back = Background(black, cv2.COLOR_BGR2HSV_FULL, 256)
        shape = black[0].shape[:2]
        self.hsv = np.empty_like(black[0])
        self.hue, self.sat, self.off, self.other, self.mask, self.classes = (np.empty(shape, np.uint8) for _ in range(6))
        self.lut = np.zeros(256, np.uint8)
        for k, ranges in enumerate(HUES.values()):
            for low, high in ranges:
                self.lut[low * 256 // 180:(high + 1) * 256 // 180] = k + 1
        side = max(3, round(3 * shape[1] / 640) | 1)
        self.bar_x, self.bar_y = np.ones((1, 3 * side), np.uint8), np.ones((3 * side, 1), np.uint8)

    def __call__(self, frame):
        mean_hue, mean_sat, far_hue, far_sat = self.back.bytes
        cv2.cvtColor(frame, cv2.COLOR_BGR2HSV_FULL, self.hsv)
        cv2.extractChannel(self.hsv, 0, self.hue)
        cv2.extractChannel(self.hsv, 1, self.sat)
        cv2.absdiff(self.hue, mean_hue, self.off)
        cv2.min(self.off, cv2.bitwise_not(self.off, self.other), self.off)
        cv2.compare(self.off, far_hue, cv2.CMP_GT, self.off)
        cv2.compare(cv2.absdiff(self.sat, mean_sat, self.other), far_sat, cv2.CMP_GT, self.other)
        cv2.morphologyEx(cv2.bitwise_or(self.off, self.other, self.off), cv2.MORPH_OPEN, KERNEL, self.mask)
        cv2.bitwise_and(cv2.LUT(self.hue, self.lut, self.classes), self.mask, self.classes)
        grey = cv2.bitwise_and(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), self.mask)
        across, down = cv2.spatialGradient(grey)
        edge = cv2.add(cv2.convertScaleAbs(across), cv2.convertScaleAbs(down))
        edge = cv2.threshold(edge, LEAST_EDGE, 255, cv2.THRESH_BINARY)[1]
        rows = cv2.morphologyEx(self.mask, cv2.MORPH_OPEN, self.bar_x)
        columns = cv2.morphologyEx(self.mask, cv2.MORPH_OPEN, self.bar_y)
        blobs = cv2.connectedComponentsWithStats(cv2.bitwise_and(rows, columns), connectivity=8, ltype=cv2.CV_32S)
        return self.classes, edge, blobs


def cpu_ms(run, frame, budget_s=0.3):
    """Median CPU time of one call, ms."""
    times, end = [], time.perf_counter() + budget_s
    while len(times) < 5 or time.perf_counter() < end:
        before = time.process_time_ns()
        run(frame)
        times.append((time.process_time_ns() - before) / 1e6)
    return statistics.median(times)


def ours_ms(program, size):
    out = subprocess.run([program, "--size", size, "--threads", "1"], check=True, capture_output=True, text=True).stdout
    return dict((name, float(ms)) for name, ms in map(str.split, out.splitlines()))["frame_to_grid"]


def measure(program, size, rounds):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "--size", size, "--dump", folder, "--no-timing"], check=True)
        black = [cv2.imread(str(path)) for path in sorted(Path(folder).glob("black-*.png"))]
        frame = cv2.imread(str(Path(folder) / "coded-0.png"))
    natural, tuned = Natural(black), Tuned(black)
    runs = []
    for k in range(rounds):
        print(f"{size}: round {k + 1} of {rounds}", file=sys.stderr)
        runs.append((cpu_ms(natural, frame), cpu_ms(tuned, frame), ours_ms(program, size)))
    middle = [statistics.median(run[k] for run in runs) for k in range(3)]
    ratios = [statistics.median(run[2] / run[k] for run in runs) for k in (1, 0)]
    return middle + ratios


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", default="640x480,1280x720,1920x1080")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--program", default=str(ROOT / "target/debug/examples/frame_time"))
    arguments = parser.parse_args()
    if not Path(arguments.program).exists():
        sys.exit(f"no {arguments.program}: cargo build -p acquirer --example frame_time")
    cv2.setNumThreads(1)
    print("| camera | natural OpenCV ms | tuned OpenCV ms | ours ms | ours / tuned | ours / natural |")
    print("|---|--:|--:|--:|--:|--:|")
    for size in arguments.sizes.split(","):
        natural, tuned, ours, to_tuned, to_natural = measure(arguments.program, size, arguments.rounds)
        print(f"| {size} | {natural:.2f} | {tuned:.2f} | {ours:.2f} | {to_tuned:.2f} | {to_natural:.2f} |", flush=True)


if __name__ == "__main__":
    main()
