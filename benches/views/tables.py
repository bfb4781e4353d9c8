"""Samples Blender's tables of AgX and Filmic at their own nodes and writes them as PNG files.

    python benches/views/tables.py CONFIG.OCIO OUT

CONFIG.OCIO is Blender's `datafiles/colormanagement/config.ocio`, as the module `bpy` brings it. A picture has the grid's third
axis and second axis down and its first axis across. `engine/src/view/table.rs` says how colours get there.
"""

import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import PyOpenColorIO as ocio

# Of each file: the table, nodes along a side, and the whole number that stands for 1. Ten bits are an eighth of an 8-bit step.
GRIDS = {
    "agx.png": ("AgX_Base_sRGB.cube", 57, 1023),
    "filmic.png": ("filmic_desat_33.cube", 33, 4095),
}
CURVES = {"filmic-curve.png": ("filmic_to_0-70_1-03.spi1d", 1024, 65535)}


def evaluate(config, table, colors):
    """A table alone, without what the configuration does before and after."""
    transform = ocio.FileTransform(table, interpolation=ocio.INTERP_LINEAR)
    processor = config.getProcessor(transform)
    result = np.ascontiguousarray(colors, np.float32)
    processor.getOptimizedCPUProcessor(ocio.OPTIMIZATION_LOSSLESS).applyRGB(result)
    return result


def png(pixels):
    """A 16-bit picture as the bytes of a PNG file; the filter of each row is the one with the smallest differences."""
    height, width, channels = pixels.shape
    step = 2 * channels
    rows = np.frombuffer(pixels.astype(">u2").tobytes(), np.uint8)
    rows = rows.reshape(height, width * step).astype(np.int32)
    above = np.zeros_like(rows[0])
    filtered = bytearray()
    for row in rows:
        shift = lambda line: np.concatenate([np.zeros(step, np.int32), line[:-step]])
        left, corner = shift(row), shift(above)
        distances = [abs(above - corner), abs(left - corner), abs(left + above - 2 * corner)]
        nearest = np.select(
            [(distances[0] <= distances[1]) & (distances[0] <= distances[2]), distances[1] <= distances[2]],
            [left, above],
            corner,
        )
        guesses = [0 * row, left, above, (left + above) // 2, nearest]
        candidates = [(row - guess) & 255 for guess in guesses]
        costs = [np.minimum(c, 256 - c).sum() for c in candidates]
        best = int(np.argmin(costs))
        filtered.append(best)
        filtered += candidates[best].astype(np.uint8).tobytes()
        above = row
    header = struct.pack(">IIBBBBB", width, height, 16, {1: 0, 3: 2}[channels], 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(bytes(filtered), 9)), (b"IEND", b"")]
    packed = (struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def whole(values, white):
    return np.rint(np.clip(values, 0.0, 1.0) * white)


def main(config, out):
    config = ocio.Config.CreateFromFile(config)
    for name, (table, size, white) in GRIDS.items():
        axis = np.linspace(0.0, 1.0, size)
        third, second, first = np.meshgrid(axis, axis, axis, indexing="ij")
        colors = np.stack([first, second, third], -1).reshape(-1, 3)
        nodes = evaluate(config, table, colors).reshape(size * size, size, 3)
        (out / name).write_bytes(png(whole(nodes, white)))
    for name, (table, size, white) in CURVES.items():
        axis = np.linspace(0.0, 1.0, size)
        curve = evaluate(config, table, np.stack([axis] * 3, -1))[:, :1]
        (out / name).write_bytes(png(whole(curve, white).reshape(1, size, 1)))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
