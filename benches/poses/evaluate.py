"""Where the vertices of an animated glTF file are: an evaluation that shares nothing with the program's own.

It reads .glb and .gltf by itself, and follows the formulas of the glTF 2.0 specification: sampler interpolation (appendix C),
skins (section 3.7.3.3), morph targets (section 3.7.2.2). Everything is computed in double precision.
"""

import base64
import json
import pathlib
import struct
import urllib.parse

import numpy as np

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class File:
    """A glTF file with its buffers."""

    def __init__(self, path):
        path = pathlib.Path(path)
        data = path.read_bytes()
        binary = None
        if data[:4] == b"glTF":
            chunks, at = [], 12
            while at + 8 <= len(data):
                length, kind = struct.unpack_from("<II", data, at)
                chunks.append((kind, data[at + 8 : at + 8 + length]))
                at += 8 + length
            text = next(chunk for kind, chunk in chunks if kind == 0x4E4F534A)
            binary = next((chunk for kind, chunk in chunks if kind == 0x004E4942), None)
        else:
            text = data
        self.json = json.loads(text)
        self.buffers = []
        for buffer in self.json.get("buffers", []):
            uri = buffer.get("uri")
            if uri is None:
                self.buffers.append(binary)
            elif uri.startswith("data:"):
                self.buffers.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                self.buffers.append((path.parent / urllib.parse.unquote(uri)).read_bytes())

    def list(self, name):
        return self.json.get(name, [])

    def _elements(self, view, start, kind, width, count):
        view = self.json["bufferViews"][view]
        data = self.buffers[view["buffer"]]
        start += view.get("byteOffset", 0)
        size = np.dtype(kind).itemsize * width
        stride = view.get("byteStride", size)
        rows = [np.frombuffer(data, kind, width, start + i * stride) for i in range(count)]
        return np.array(rows).reshape(count, width)

    def accessor(self, number):
        """All elements, a row each; normalized integers as the numbers that they stand for."""
        accessor = self.json["accessors"][number]
        kind, width, count = COMPONENTS[accessor["componentType"]], WIDTHS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            values = self._elements(accessor["bufferView"], accessor.get("byteOffset", 0), kind, width, count).copy()
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where, what = sparse["indices"], sparse["values"]
            places = self._elements(
                where["bufferView"], where.get("byteOffset", 0), COMPONENTS[where["componentType"]], 1, sparse["count"]
            )
            values[places[:, 0]] = self._elements(
                what["bufferView"], what.get("byteOffset", 0), kind, width, sparse["count"]
            )
        numbers = values.astype(np.float64)
        if accessor.get("normalized", False):
            most = np.iinfo(kind).max
            numbers = np.maximum(numbers / most, -1.0)
        return numbers if kind == np.float32 or accessor.get("normalized", False) else values.astype(np.int64)


def slerp(a, b, t):
    """Spherical linear interpolation of unit quaternions, the short way."""
    dot = float(np.dot(a, b))
    angle = np.arccos(min(abs(dot), 1.0))
    if angle < 1e-9:
        return a + (np.sign(dot or 1.0) * b - a) * t
    return (np.sin(angle * (1 - t)) * a + np.sign(dot or 1.0) * np.sin(angle * t) * b) / np.sin(angle)


def sample(times, values, how, seconds, is_rotation):
    """The value of a sampler; `values` has a row per element, three per key for splines."""
    at = lambda key: values[3 * key + 1] if how == "CUBICSPLINE" else values[key]
    last = len(times) - 1
    if seconds <= times[0]:
        result = at(0)
    elif seconds >= times[last]:
        result = at(last)
    else:
        key = int(np.searchsorted(times, seconds, side="right")) - 1
        span = times[key + 1] - times[key]
        t = (seconds - times[key]) / span
        if how == "STEP":
            result = at(key)
        elif how == "LINEAR":
            a, b = at(key), at(key + 1)
            result = slerp(a / np.linalg.norm(a), b / np.linalg.norm(b), t) if is_rotation else a + (b - a) * t
        else:
            leaving, arriving = values[3 * key + 2], values[3 * (key + 1)]
            result = (
                (2 * t**3 - 3 * t**2 + 1) * at(key)
                + span * (t**3 - 2 * t**2 + t) * leaving
                + (-2 * t**3 + 3 * t**2) * at(key + 1)
                + span * (t**3 - t**2) * arriving
            )
    return result / np.linalg.norm(result) if is_rotation else result


def matrix_of(translation, rotation, scale):
    x, y, z, w = rotation
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    result = np.eye(4)
    result[:3, :3] = turn * np.asarray(scale, np.float64)
    result[:3, 3] = translation
    return result


def pose(file, seconds):
    """For each node that shows a mesh: its name, and the corners of its triangles in the world."""
    nodes = [dict(node) for node in file.list("nodes")]
    chosen = file.list("animations")
    targets = [
        {(c["target"].get("node"), c["target"]["path"]) for c in animation["channels"]} for animation in chosen
    ]
    # Animations that move the same exclude each other: the first one is meant.
    if any(targets[i] & targets[j] for i in range(len(targets)) for j in range(i)):
        chosen = chosen[:1]
    for animation in chosen:
        for channel in animation["channels"]:
            node, path = channel["target"].get("node"), channel["target"]["path"]
            if node is None:
                continue
            sampler = animation["samplers"][channel["sampler"]]
            times = file.accessor(sampler["input"])[:, 0]
            values = file.accessor(sampler["output"])
            how = sampler.get("interpolation", "LINEAR")
            if path == "weights":
                values = values.reshape(len(times) * (3 if how == "CUBICSPLINE" else 1), -1)
            nodes[node][path] = sample(times, values, how, seconds, path == "rotation")

    world = {}

    def place(number, above):
        node = nodes[number]
        if "matrix" in node:
            local = np.array(node["matrix"], np.float64).reshape(4, 4).T
        else:
            rotation = np.asarray(node.get("rotation", [0, 0, 0, 1]), np.float64)
            local = matrix_of(
                node.get("translation", [0, 0, 0]), rotation / np.linalg.norm(rotation), node.get("scale", [1, 1, 1])
            )
        world[number] = above @ local
        for child in node.get("children", []):
            place(child, world[number])

    children = {child for node in nodes for child in node.get("children", [])}
    for number in range(len(nodes)):
        if number not in children:
            place(number, np.eye(4))

    shown, waiting = [], list(reversed(file.json["scenes"][file.json.get("scene", 0)]["nodes"]))
    while waiting:
        number = waiting.pop()
        shown.append(number)
        waiting.extend(reversed(nodes[number].get("children", [])))
    result = []
    for number in shown:
        node = nodes[number]
        if "mesh" not in node:
            continue
        mesh = file.list("meshes")[node["mesh"]]
        weights = node.get("weights", mesh.get("weights", []))
        corners = [
            corners_of(file, primitive, weights, node, world, world[number]) for primitive in mesh["primitives"]
        ]
        result.append((node.get("name", f"node {number}"), np.concatenate(corners)))
    return result


def corners_of(file, primitive, weights, node, world, own):
    attributes = primitive["attributes"]
    points = file.accessor(attributes["POSITION"]).astype(np.float64)
    for weight, target in zip(weights, primitive.get("targets", [])):
        if "POSITION" in target:
            points = points + weight * file.accessor(target["POSITION"])
    points = np.hstack([points, np.ones((len(points), 1))])
    if "skin" in node:
        skin = file.list("skins")[node["skin"]]
        binds = file.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = np.array([world[joint] @ bind for joint, bind in zip(skin["joints"], binds)])
        blended = np.zeros((len(points), 4, 4))
        total = np.zeros(len(points))
        number = 0
        while f"JOINTS_{number}" in attributes:
            indices = file.accessor(attributes[f"JOINTS_{number}"]).astype(np.int64)
            shares = file.accessor(attributes[f"WEIGHTS_{number}"]).astype(np.float64)
            blended += np.einsum("vj,vjab->vab", shares, joints[indices])
            total += shares.sum(axis=1)
            number += 1
        points = np.einsum("vab,vb->va", blended / total[:, None, None], points)
    else:
        points = points @ own.T
    points = points[:, :3]
    if "indices" in primitive:
        return points[file.accessor(primitive["indices"])[:, 0]]
    return points
