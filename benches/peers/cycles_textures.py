"""Plain gray, rust and scratches as nodes of Blender, after the project's own textures in `user_textures/`.

The graphs are those of `patina bench textures`: rust is gray blended with rust by a mask of noise and ambient occlusion,
scratches brighten gray. Frequencies, octaves, ramps, thresholds are the same; Blender's noises have other hashes, so the
patterns are other ones of the same kind. Left out is what Blender has no input for, the fading of details smaller than a
pixel. Rows of nodes that a person would lay out by hand are built by the small helper `Nodes`.
"""

import math

# rust_color's ramp: position and sRGB colour.
RUST = [(0.0, "170d09"), (0.28, "3a1a0e"), (0.5, "6b3213"), (0.75, "9c4d1d"), (1.0, "c98a4b")]
GRAY = (0.5, 0.5, 0.5)
BRIGHT = (0.8, 0.8, 0.8)
AO_DISTANCE = 0.25
# From octave to octave, weaker and finer by these factors.
GAIN, LACUNARITY = 0.55, 2.03
# The first octave of the textures' sums; Blender's is 1.
FIRST = 0.85


class Graph:
    """The material of the model, with one graph at a time."""

    def __init__(self, material):
        self.tree = material.node_tree
        self.edited = None
        self.base = 0.0

    def show(self, texture, ao_samples):
        """Replaces the nodes."""
        self.tree.nodes.clear()
        nodes = Nodes(self.tree)
        diffuse = self.tree.nodes.new("ShaderNodeBsdfDiffuse")
        output = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
        if texture == "gray":
            diffuse.inputs["Color"].default_value = (*GRAY, 1.0)
            return
        if texture == "rust":
            factor, self.edited = rust_mask(nodes, ao_samples)
            over = rust_color(nodes)
        else:
            factor, self.edited = scratches(nodes)
            over = BRIGHT
        self.base = self.edited.default_value
        self.tree.links.new(nodes.mix(factor, GRAY, over), diffuse.inputs["Color"])

    def edit(self, _texture, number):
        """Another value each time for the parameter that says how much is rusty or scratched."""
        self.edited.default_value = self.base + 0.01 * (1 + number)


class Nodes:
    """Arithmetic of sockets: arguments are sockets, numbers or vectors."""

    def __init__(self, tree):
        self.tree = tree

    def node(self, kind, inputs=None, **properties):
        """A node of that kind with properties set and inputs filled."""
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in (inputs or {}).items():
            self._fill(node.inputs[name], value)
        return node

    def _fill(self, socket, value):
        if hasattr(value, "is_output"):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation, *values, clamp=False):
        node = self.node("ShaderNodeMath", dict(enumerate(values)), operation=operation, use_clamp=clamp)
        return node.outputs[0]

    def add(self, a, b):
        return self.math("ADD", a, b)

    def mul(self, a, b):
        return self.math("MULTIPLY", a, b)

    def fma(self, a, b, c):
        """a b + c"""
        return self.math("MULTIPLY_ADD", a, b, c)

    def vector(self, operation, *values):
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for socket, value in zip(node.inputs, values, strict=False):
            self._fill(socket, value)
        return node.outputs["Vector"]

    def scaled(self, vector, factor):
        node = self.node("ShaderNodeVectorMath", {"Scale": factor}, operation="SCALE")
        self._fill(node.inputs[0], vector)
        return node.outputs["Vector"]

    def dot(self, a, b):
        node = self.node("ShaderNodeVectorMath", operation="DOT_PRODUCT")
        self._fill(node.inputs[0], a)
        self._fill(node.inputs[1], b)
        return node.outputs["Value"]

    def smoothstep(self, low, high, value):
        inputs = {"Value": value, "From Min": low, "From Max": high}
        return self.node("ShaderNodeMapRange", inputs, interpolation_type="SMOOTHSTEP").outputs["Result"]

    def mix(self, factor, a, b):
        """Of two colours; 1 is all of `b`."""
        node = self.node("ShaderNodeMix", data_type="RGBA")
        # Sockets of all types are there, and have one name.
        for name, value in (("Factor_Float", factor), ("A_Color", a), ("B_Color", b)):
            socket = next(s for s in node.inputs if s.identifier == name)
            self._fill(socket, (*value, 1.0) if isinstance(value, tuple) else value)
        return next(s for s in node.outputs if s.identifier == "Result_Color")

    def _noise(self, vector, octaves, dimensions, offset):
        if offset:
            vector = self.vector("ADD", vector, (offset,) * 3)
        inputs = {"Vector": vector, "Scale": 1.0, "Detail": octaves - 1.0, "Roughness": GAIN, "Lacunarity": LACUNARITY}
        return self.node("ShaderNodeTexNoise", inputs, noise_dimensions=dimensions, noise_type="FBM", normalize=False)

    def noise(self, vector, octaves=1, dimensions="3D", offset=0.0):
        """Signed gradient noise."""
        return self._noise(vector, octaves, dimensions, offset).outputs[0]

    def noises(self, vector, offset=0.0):
        """Three independent ones of one octave, as a vector."""
        return self._noise(vector, 1, "3D", offset).outputs["Color"]

    def position(self, scale):
        return self.scaled(self.node("ShaderNodeNewGeometry").outputs["Position"], scale)

    def cells(self, vector, feature, dimensions):
        return self.node("ShaderNodeTexVoronoi", {"Vector": vector, "Scale": 1.0}, feature=feature,
                         voronoi_dimensions=dimensions).outputs  # fmt: skip

    def red(self, color):
        return self.node("ShaderNodeSeparateColor", {"Color": color}).outputs[0]

    def split(self, vector):
        return self.node("ShaderNodeSeparateXYZ", {"Vector": vector}).outputs

    def joined(self, x, y):
        return self.node("ShaderNodeCombineXYZ", {"X": x, "Y": y}).outputs[0]


def _linear(code):
    """Linear Rec.709 of a colour's six hexadecimal digits."""
    values = (int(code[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
    return tuple(v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values)


def rust_color(n):
    """`rust_color.wgsl` with scale 7."""
    p = n.position(7.0)
    warp = n.noises(n.scaled(p, 0.7))
    stains = n.noise(n.vector("MULTIPLY_ADD", warp, (0.9,) * 3, p), octaves=6)
    speckles = n.noise(n.vector("MULTIPLY_ADD", warp, (0.5,) * 3, n.scaled(p, 9.0)), octaves=4)
    ragged = n.noises(n.scaled(p, 7.0), offset=3.3)
    at = n.vector("MULTIPLY_ADD", warp, (0.6,) * 3, n.scaled(p, 1.7))
    at = n.vector("MULTIPLY_ADD", ragged, (0.16,) * 3, at)
    nearest, second = n.cells(at, "F1", "3D"), n.cells(at, "F2", "3D")
    border = n.math("SUBTRACT", second["Distance"], nearest["Distance"])
    patch = n.fma(stains, 0.4 * FIRST, n.noise(n.scaled(p, 0.45), offset=71.0))
    blistered = n.smoothstep(-0.1, 0.5, patch)
    lift = n.fma(n.smoothstep(0.0, 0.3, border), 0.35, n.fma(n.red(nearest["Color"]), 0.5, -0.46))
    # Flakes and grain have half of their strength.
    lift = n.mul(n.mul(lift, 0.5), blistered)
    t = n.fma(stains, 0.42 * FIRST, n.add(lift, n.fma(speckles, 0.2 * FIRST, 0.5)))
    ramp = n.node("ShaderNodeValToRGB", {0: t})
    ramp.color_ramp.interpolation = "EASE"
    elements = ramp.color_ramp.elements
    while len(elements) < len(RUST):
        elements.new(0.5)
    for element, (position, code) in zip(elements, RUST, strict=True):
        element.position, element.color = position, (*_linear(code), 1.0)
    pits = n.fma(n.smoothstep(0.35 / FIRST, 0.75 / FIRST, speckles), -0.3, 1.0)
    return n.scaled(ramp.outputs["Color"], pits)


def rust_mask(n, ao_samples):
    """`rust_mask.wgsl` with scale 2.2, and the socket of `amount`."""
    p = n.position(2.2)
    fray = n.noises(n.scaled(p, 2.7))
    patches = n.noise(n.vector("MULTIPLY_ADD", fray, (0.25,) * 3, p), octaves=6)
    ao = n.node("ShaderNodeAmbientOcclusion", {"Distance": AO_DISTANCE}, samples=ao_samples)
    occluded = n.math("SUBTRACT", 1.0, ao.outputs["AO"])
    crevice = n.mul(n.mul(occluded, 1.5), n.fma(patches, 0.6 * FIRST, 0.6))
    amount = n.node("ShaderNodeValue").outputs[0]
    amount.default_value = 0.42
    odds = n.math("DIVIDE", n.math("SUBTRACT", 1.0, amount), amount)
    threshold = n.mul(n.math("LOGARITHM", odds, math.e), 0.13)
    # The width of the edge at contrast 0.7.
    softness = 0.015 + 0.3 * (1.0 - 0.7)
    value = n.math("SUBTRACT", n.fma(patches, FIRST, crevice), threshold)
    return n.smoothstep(-softness, softness, value), amount


def scratches(n):
    """`scratches.wgsl` with scale 6 and amount 0.8, and the socket of `amount`."""
    uv = n.scaled(n.node("ShaderNodeTexCoord").outputs["UV"], 6.0)
    amount = n.node("ShaderNodeValue").outputs[0]
    amount.default_value = 0.8
    untouched = None
    for layer in range(4):
        # Layers fan out around the main direction, each a little finer than the one before.
        angle = 0.5 + 0.6 * math.pi * ((0.37, 0.81, 0.13, 0.59)[layer] - 0.5)
        frequency = 1.0 + 0.45 * layer
        c, s = frequency * math.cos(angle), frequency * math.sin(angle)
        offset = 37.0 * layer
        p = n.joined(n.add(n.dot(uv, (c, s, 0.0)), offset), n.add(n.dot(uv, (-s, c, 0.0)), offset))
        drawn = _scratch(n, p, amount)
        left = n.fma(drawn, -(1.0 - 0.15 * layer), 1.0)
        untouched = left if untouched is None else n.mul(untouched, left)
    return n.math("SUBTRACT", 1.0, untouched), amount


def _scratch(n, p, amount):
    """One layer: some borders of long random cells, bent by noise."""
    length, width, waviness = 14.0, 0.08, 0.3
    bend = n.fma(n.noise(n.scaled(p, 0.9), dimensions="2D", offset=5.0), 0.35,
                 n.noise(n.scaled(p, 0.21), dimensions="2D"))  # fmt: skip
    x, y, _ = n.split(p)
    q = n.joined(n.mul(x, 1.0 / length), n.fma(bend, 1.5 * waviness, y))
    nearest, second = n.cells(q, "F1", "2D"), n.cells(q, "F2", "2D")
    border = n.math("SUBTRACT", second["Distance"], nearest["Distance"])
    across = n.vector("NORMALIZE", n.vector("SUBTRACT", second["Position"], nearest["Position"]))
    along = n.smoothstep(0.5, 0.9, n.split(across)["Y"])
    beside = n.split(n.vector("SUBTRACT", nearest["Position"], q))["X"]
    taper = n.mul(along, n.fma(n.math("ABSOLUTE", beside), -2.2, 1.5))
    random = n.node("ShaderNodeSeparateColor", {"Color": nearest["Color"]}).outputs
    half_width = n.mul(n.fma(random[1], 0.7 * width, 0.3 * width), n.math("MAXIMUM", taper, 1e-4))
    inside = n.smoothstep(0.0, 1.0, n.math("DIVIDE", border, half_width))
    strength = n.mul(n.fma(random[2], 0.65, 0.35), n.math("LESS_THAN", random[0], amount))
    return n.mul(strength, n.math("SUBTRACT", 1.0, inside))
