"""Holds our view transforms against OpenColorIO with Blender's configuration.

    python benches/views/compare.py colors COLORS
    python benches/views/compare.py check COLORS FOLDER [CONFIG.OCIO]

`colors` writes random colours as 32-bit floats; `check` reads our codes of them from FOLDER/NAME.f32, prints the largest
differences, and fails where one from OpenColorIO, or from the published formula where there is one, exceeds 1/255. `cargo xtask views` does both.
"""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import PyOpenColorIO as ocio

# Our names and Blender's.
VIEWS = {
    "standard": "Standard",
    "agx": "AgX",
    "khronos-neutral": "Khronos PBR Neutral",
    "aces2": "ACES 2.0",
    "filmic": "Filmic",
}
LIMIT = 1.0 / 255.0


def colors(count=5000, seed=17):
    """Of each kind so many: over 22 stops with channels of their own, of any saturation, plain, negative ones, greys, and colours
    of lamps that a camera would clip."""
    random = np.random.default_rng(seed)
    stops = lambda low, high, channels: 0.18 * 2.0 ** random.uniform(low, high, (count, channels))
    wide = stops(-12, 10, 3)
    kinds = [
        wide,
        stops(-8, 6, 1) * random.uniform(0, 1, (count, 3)),
        random.uniform(0, 1, (count, 3)),
        wide * np.where(random.random((count, 3)) < 0.3, -1, 1),
        random.uniform(-0.2, 1.5, (count, 3)),
        np.repeat(stops(-14, 16, 1), 3, axis=1),
        stops(4, 14, 1) * random.dirichlet([0.3, 0.3, 0.3], count),
        np.eye(3)[random.integers(0, 3, count)] * stops(-10, 14, 1),
    ]
    return np.concatenate(kinds).astype(np.float32)


def srgb(linear):
    """IEC 61966-2-1, clipped."""
    color = np.clip(linear.astype(np.float64), 0.0, 1.0)
    return np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1.0 / 2.4) - 0.055)


def neutral(linear):
    """The formula that Khronos published; Blender's table of it is off at dark colours."""
    color = np.maximum(linear.astype(np.float64), 0.0)
    least = color.min(axis=1, keepdims=True)
    color = color - np.where(least < 0.08, least - 6.25 * least**2, 0.04)
    peak = color.max(axis=1, keepdims=True)
    shown = 1.0 - 0.24**2 / np.maximum(peak + 0.24 - 0.76, 0.24)
    share = 1.0 / (0.15 * (peak - shown) + 1.0)
    bright = color * shown / np.maximum(peak, 1e-9) * share + shown * (1.0 - share)
    return srgb(np.where(peak < 0.76, color, bright))


def blenders_configuration():
    folder = Path(importlib.util.find_spec("bpy").origin).parent
    return next(folder.glob("*/datafiles/colormanagement/config.ocio"))


def reference(config, view, linear):
    transform = ocio.DisplayViewTransform(src="Linear Rec.709", display="sRGB", view=view)
    # Optimisation would put tables where there are formulas.
    processor = config.getProcessor(transform).getOptimizedCPUProcessor(ocio.OPTIMIZATION_NONE)
    codes = np.ascontiguousarray(linear, np.float32).copy()
    processor.applyRGB(codes)
    return np.clip(codes, 0.0, 1.0)


def check(linear, folder, config):
    config = ocio.Config.CreateFromFile(str(config))
    worst = 0.0
    print(f"{len(linear)} colours; differences in 1/255")
    for name, view in VIEWS.items():
        ours = np.fromfile(folder / f"{name}.f32", np.float32).reshape(-1, 3)
        blenders = reference(config, view, linear)
        judges = {"OpenColorIO": blenders}
        if name == "standard":
            # The configuration goes to XYZ and back by matrices of 7 digits, so that beside a channel of 2600 a black one is none.
            judges = {"the formula": srgb(linear), "OpenColorIO": blenders}
        if name == "khronos-neutral":
            judges = {"the formula": neutral(linear), "Blender's table": blenders}
        for number, (judge, theirs) in enumerate(judges.items()):
            difference = np.abs(ours - theirs).max(axis=1) * 255.0
            at = int(difference.argmax())
            print(
                f"{name:16} {judge:16} largest {difference[at]:.3f}  99 % {np.percentile(difference, 99):.3f}"
                f"  at {linear[at].tolist()}"
            )
            if number == 0:
                worst = max(worst, difference[at] / 255.0)
    return worst <= LIMIT


def main(command, path, *rest):
    if command == "colors":
        colors().tofile(path)
        return 0
    config = rest[1] if len(rest) > 1 else blenders_configuration()
    linear = np.fromfile(path, np.float32).reshape(-1, 3)
    return 0 if check(linear, Path(rest[0]), config) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
