"""Scenes as plain arrays, read from glTF 2.0 and written to it.

Only what the comparison needs is kept, so that every renderer is given the same thing: triangles with normals and one set
of texture coordinates, in world space; materials that are diffuse or a rough metal, with one colour or one image; lamps;
one camera. Alpha, normal maps, transmission and all other layers are left out.
"""

import base64
import json
import shutil
import struct
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

import numpy as np

# Smoother metals would be mirrors to some renderers and not to others.
LOWEST_ROUGHNESS = 0.1

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass
class Material:
    """Diffuse, or a metal with a GGX distribution and Schlick's Fresnel term."""

    name: str
    color: tuple = (0.5, 0.5, 0.5)
    """Albedo, or reflectance of a metal at normal incidence; linear Rec.709. A factor where there is an image."""
    image: Path | None = None
    """sRGB, repeated, filtered bilinearly."""
    metallic: bool = False
    roughness: float = 1.0
    """The square root of GGX's alpha."""
    emission: tuple = (0.0, 0.0, 0.0)
    """Radiance, W/(m2 sr)."""

    @property
    def emits(self):
        return max(self.emission) > 0.0


@dataclass
class Mesh:
    """Triangles of one material in world space."""

    name: str
    material: int
    positions: np.ndarray
    """(n, 3) metres."""
    normals: np.ndarray
    """(n, 3) of unit length."""
    uvs: np.ndarray
    """(n, 2), glTF's way: v points down in the image."""
    triangles: np.ndarray
    """(m, 3) indices, counter-clockwise seen from the front."""


@dataclass
class Camera:
    """A pinhole that looks along its -Z, with +Y up."""

    to_world: np.ndarray
    """(4, 4), without scaling."""
    y_fov: float
    """Radians."""

    @staticmethod
    def looking(position, target, y_fov_degrees):
        """A camera that sees `target` in the middle of its picture, upright."""
        position, target = np.asarray(position, float), np.asarray(target, float)
        back = _normalized(position - target)
        right = _normalized(np.cross([0.0, 1.0, 0.0], back))
        matrix = np.eye(4)
        matrix[:3, :4] = np.column_stack([right, np.cross(back, right), back, position])
        return Camera(matrix, float(np.radians(y_fov_degrees)))

    @property
    def position(self):
        return self.to_world[:3, 3]

    @property
    def target(self):
        """A point one metre in front."""
        return self.position - self.to_world[:3, 2]

    @property
    def up(self):
        return self.to_world[:3, 1]


@dataclass
class Scene:
    meshes: list = field(default_factory=list)
    materials: list = field(default_factory=list)
    camera: Camera | None = None

    def add(self, other, only=None, transform=None, material=None):
        """Puts another scene's meshes in, or those named in `only`, moved, with a material of its own or the given one."""
        first = len(self.materials)
        self.materials.extend(other.materials if material is None else [material])
        for mesh in other.meshes:
            if only is not None and mesh.name not in only:
                continue
            moved = mesh if transform is None else _moved(mesh, transform)
            number = first + (mesh.material if material is None else 0)
            self.meshes.append(Mesh(mesh.name, number, moved.positions, moved.normals, mesh.uvs, moved.triangles))

    def triangle_count(self):
        return sum(len(mesh.triangles) for mesh in self.meshes)


def rotation_y(degrees):
    """A turn about the vertical as a (4, 4) matrix."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]], float)


def placement(translation=(0, 0, 0), turn_degrees=0.0, scale=1.0):
    """Scaled, turned about the vertical, then moved: a (4, 4) matrix."""
    matrix = rotation_y(turn_degrees)
    matrix[:3, :3] *= scale
    matrix[:3, 3] = translation
    return matrix


def read(path):
    """A .gltf or .glb file. Images stay where they are; those inside a .glb are left out with their textures."""
    return _Reader(Path(path)).scene()


def write(scene, path):
    """Writes `path` (.gltf) with a .bin and its images beside it."""
    _Writer(Path(path)).write(scene)


def _normalized(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.maximum(length, 1e-30)


def _moved(mesh, transform):
    """The mesh under a (4, 4) transform, its front still its front."""
    linear = transform[:3, :3]
    positions = mesh.positions @ linear.T + transform[:3, 3]
    normals = _normalized(mesh.normals @ np.linalg.inv(linear))
    triangles = mesh.triangles if np.linalg.det(linear) > 0 else mesh.triangles[:, ::-1]
    return Mesh(mesh.name, mesh.material, positions, normals, mesh.uvs, triangles)


class _Reader:
    def __init__(self, path):
        self.folder = path.parent
        data = path.read_bytes()
        self.binary = b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.document = json.loads(data[20 : 20 + length])
            self.binary = data[20 + length + 8 :]
        else:
            self.document = json.loads(data)
        self.buffers = [self._buffer(buffer) for buffer in self.document.get("buffers", [])]

    def _buffer(self, buffer):
        uri = buffer.get("uri")
        if uri is None:
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.partition(",")[2])
        return (self.folder / unquote(uri)).read_bytes()

    def scene(self):
        scene = Scene(materials=[self._material(m) for m in self.document.get("materials", [])])
        scene.materials.append(Material("default", (1.0, 1.0, 1.0)))
        roots = self.document["scenes"][self.document.get("scene", 0)]["nodes"]
        for root in roots:
            self._node(scene, root, np.eye(4))
        return scene

    def _node(self, scene, number, parent):
        node = self.document["nodes"][number]
        to_world = parent @ _local(node)
        if "mesh" in node:
            mesh = self.document["meshes"][node["mesh"]]
            for primitive in mesh["primitives"]:
                self._primitive(scene, node.get("name", mesh.get("name", "")), primitive, to_world)
        if "camera" in node and scene.camera is None:
            camera = self.document["cameras"][node["camera"]]
            scene.camera = Camera(to_world, camera["perspective"]["yfov"])
        for child in node.get("children", []):
            self._node(scene, child, to_world)

    def _primitive(self, scene, name, primitive, to_world):
        if primitive.get("mode", 4) != 4:
            return
        number = primitive.get("material", len(scene.materials) - 1)
        if self._transmits(number):
            return
        attributes = primitive["attributes"]
        positions = self._accessor(attributes["POSITION"])
        count = len(positions)
        if "indices" in primitive:
            triangles = self._accessor(primitive["indices"]).reshape(-1, 3).astype(np.int64)
        else:
            triangles = np.arange(count).reshape(-1, 3)
        if "NORMAL" in attributes:
            normals = self._accessor(attributes["NORMAL"])
        else:
            normals = _smooth_normals(positions, triangles)
        uvs = self._accessor(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else np.zeros((count, 2))
        mesh = Mesh(name, number, positions, normals, uvs, triangles)
        scene.meshes.append(_moved(mesh, to_world))

    def _transmits(self, number):
        materials = self.document.get("materials", [])
        extensions = materials[number].get("extensions", {}) if number < len(materials) else {}
        return "KHR_materials_transmission" in extensions

    def _accessor(self, number):
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        data = np.ndarray((count, width), kind, self.buffers[view["buffer"]], start, (stride, kind.itemsize))
        if accessor.get("normalized"):
            return data.astype(np.float64) / np.iinfo(kind).max
        return data.astype(np.float64) if kind == np.float32 else data.copy()

    def _material(self, material):
        surface = material.get("pbrMetallicRoughness", {})
        extensions = material.get("extensions", {})
        strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
        textured = "metallicRoughnessTexture" in surface
        return Material(
            name=material.get("name", ""),
            color=tuple(surface.get("baseColorFactor", [1.0] * 4)[:3]),
            image=self._image(surface.get("baseColorTexture")),
            metallic=surface.get("metallicFactor", 1.0) >= 0.5 and not textured,
            roughness=max(surface.get("roughnessFactor", 1.0), LOWEST_ROUGHNESS),
            emission=tuple(strength * e for e in material.get("emissiveFactor", [0.0] * 3)),
        )

    def _image(self, texture):
        if texture is None:
            return None
        source = self.document["textures"][texture["index"]].get("source")
        uri = None if source is None else self.document["images"][source].get("uri")
        return None if uri is None or uri.startswith("data:") else self.folder / unquote(uri)


def _local(node):
    """A node's transform; glTF's matrices go column by column."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= node.get("scale", [1.0] * 3)
    matrix[:3, 3] = node.get("translation", [0.0] * 3)
    return matrix


def _smooth_normals(positions, triangles):
    """Normals of the corners, weighted by area."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(positions)
    for i in range(3):
        np.add.at(normals, triangles[:, i], faces)
    return _normalized(normals)


class _Writer:
    def __init__(self, path):
        self.path = path
        self.bytes = bytearray()
        self.views = []
        self.accessors = []
        self.images = {}

    def write(self, scene):
        meshes = [self._mesh(mesh) for mesh in scene.meshes]
        nodes = [{"name": mesh.name, "mesh": i} for i, mesh in enumerate(scene.meshes)]
        document = {
            "asset": {"version": "2.0", "generator": "Patina's benches/peers"},
            "extensionsUsed": ["KHR_materials_specular", "KHR_materials_emissive_strength"],
            "scene": 0,
            "materials": [self._material(material) for material in scene.materials],
            "meshes": meshes,
            "nodes": nodes,
        }
        if scene.camera is not None:
            lens = {"yfov": scene.camera.y_fov, "znear": 0.01}
            document["cameras"] = [{"type": "perspective", "perspective": lens}]
            matrix = scene.camera.to_world.T.flatten().tolist()
            nodes.append({"name": "camera", "camera": 0, "matrix": matrix})
        document["scenes"] = [{"nodes": list(range(len(nodes)))}]
        binary = self.path.with_suffix(".bin")
        document["buffers"] = [{"uri": binary.name, "byteLength": len(self.bytes)}]
        document["bufferViews"] = self.views
        document["accessors"] = self.accessors
        if self.images:
            document["images"] = [{"uri": name} for name in self.images.values()]
            document["textures"] = [{"source": i} for i in range(len(self.images))]
        binary.write_bytes(self.bytes)
        self.path.write_text(json.dumps(document))

    def _mesh(self, mesh):
        positions = self._accessor(mesh.positions, np.float32, "VEC3")
        low, high = (f(mesh.positions.astype(np.float32), axis=0) for f in (np.min, np.max))
        self.accessors[positions] |= {"min": low.tolist(), "max": high.tolist()}
        attributes = {
            "POSITION": positions,
            "NORMAL": self._accessor(mesh.normals, np.float32, "VEC3"),
            "TEXCOORD_0": self._accessor(mesh.uvs, np.float32, "VEC2"),
        }
        indices = self._accessor(mesh.triangles.reshape(-1, 1), np.uint32, "SCALAR")
        primitive = {"attributes": attributes, "indices": indices, "material": mesh.material}
        return {"name": mesh.name, "primitives": [primitive]}

    def _accessor(self, values, kind, shape):
        data = np.ascontiguousarray(values, dtype=kind)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": data.nbytes}
        self.bytes += data.tobytes()
        self.views.append(view)
        component = next(code for code, known in COMPONENTS.items() if known == kind)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(data), "type": shape}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def _material(self, material):
        surface = {
            "baseColorFactor": [*material.color, 1.0],
            "metallicFactor": float(material.metallic),
            "roughnessFactor": material.roughness,
        }
        if material.image is not None:
            surface["baseColorTexture"] = {"index": self._image(material.image)}
        extensions = {}
        if not material.metallic:
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
        written = {"name": material.name, "doubleSided": True, "pbrMetallicRoughness": surface, "extensions": extensions}
        if material.emits:
            strength = max(material.emission)
            written["emissiveFactor"] = [e / strength for e in material.emission]
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        return written

    def _image(self, source):
        if source not in self.images:
            name = f"{self.path.stem}-{len(self.images)}{source.suffix}"
            shutil.copyfile(source, self.path.with_name(name))
            self.images[source] = name
        return list(self.images).index(source)
