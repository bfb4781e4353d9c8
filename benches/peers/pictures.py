"""Pictures against a reference: how far they are from it, and a sheet to look at.

    pictures.py compare JOB RESULT     errors of pictures
    pictures.py mean OUT PICTURE...    the mean of pictures, as .npy

A job of `compare` is {"reference": FILE, "reference_spp": N, "pictures": [{"file": FILE, "spp": N}], "sheet": FILE}: the
sheet is a PNG of the reference and the last picture side by side.
"""

import json
import struct
import sys
import zlib
from pathlib import Path

import numpy as np

from jobs import write_json


def load(path):
    """Linear floats of shape (height, width, 3), top row first, from .npy or OpenEXR."""
    path = Path(path)
    if path.suffix == ".npy":
        return np.load(path).astype(np.float64)
    import OpenEXR

    channels = OpenEXR.File(str(path)).channels()
    packed = next((channels[name] for name in ("RGB", "RGBA") if name in channels), None)
    if packed is None:
        raise ValueError(f"{path} has no channels R, G, B but {', '.join(channels)}")
    return packed.pixels[:, :, :3].astype(np.float64)


def reduced(picture, shape):
    """The mean of blocks of pixels: what a box filter gives at the lower resolution `shape`."""
    (height, width), (rows, columns) = picture.shape[:2], shape[:2]
    if height % rows or width % columns:
        raise ValueError(f"a reference of {width}x{height} can't be reduced to {columns}x{rows}")
    return picture.reshape(rows, height // rows, columns, width // columns, 3).mean((1, 3))


def errors(picture, reference):
    """Relative and absolute root mean square error over pixels and channels, and the mean over the reference's mean.

    Relative is to the reference, but never to less than its mean: else a few bright samples in dark corners would decide.
    """
    difference = picture - reference
    relative = difference / np.maximum(reference, reference.mean())
    return {
        "relative_rmse": float(np.sqrt(np.mean(relative**2))),
        "rmse": float(np.sqrt(np.mean(difference**2))),
        "level": float(picture.mean() / reference.mean()),
    }


def png(pixels):
    """8-bit sRGB PNG of linear floats of shape (height, width, 3)."""
    linear = np.clip(np.nan_to_num(pixels), 0.0, 1.0)
    curved = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    bytes_ = (curved * 255.0 + 0.5).astype(np.uint8)
    height, width = bytes_.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in bytes_)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def compare(job):
    pictures = [(entry["spp"], load(entry["file"])) for entry in job["pictures"]]
    shape = pictures[0][1].shape
    reference = reduced(load(job["reference"]), shape)
    results = [{"spp": spp} | errors(picture, reference) for spp, picture in pictures]
    if sheet := job.get("sheet"):
        exposure = 0.4 / max(float(np.median(reference.mean(2))), 1e-6)
        side_by_side = np.concatenate([reference, pictures[-1][1]], axis=1) * min(exposure, 4.0)
        Path(sheet).write_bytes(png(side_by_side))
    return {"errors": results}


def main():
    match sys.argv[1:]:
        case ["compare", job, result]:
            write_json(result, compare(json.loads(Path(job).read_text())))
        case ["mean", out, first, *more]:
            total = load(first)
            for picture in more:
                total += load(picture)
            np.save(out, (total / (1 + len(more))).astype(np.float32))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
