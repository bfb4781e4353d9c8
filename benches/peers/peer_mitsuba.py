"""Mitsuba 3: compiled with LLVM where that is found (`DRJIT_LIBLLVM_PATH`), else the scalar variant."""

import os

import numpy as np

from gltf import read
from jobs import Render, Result, run, timed

# Lanes of a kernel: more samples are rendered in several passes, as memory is limited.
MOST_LANES = 1 << 24


def version():
    import mitsuba

    return mitsuba.__version__


def _variant():
    import mitsuba as mi

    compiled = "llvm_ad_rgb"
    return compiled if compiled in mi.variants() and os.environ.get("DRJIT_LIBLLVM_PATH") else "scalar_rgb"


def _color(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def _bsdf(material):
    color = _color(material.color)
    if material.image is not None:
        # A factor on the image isn't known to the diffuse BSDF: the image is multiplied while it is loaded.
        color = _image(material)
    if material.metallic:
        bsdf = {"type": "principled", "base_color": color, "metallic": 1.0, "roughness": material.roughness}
    else:
        bsdf = {"type": "diffuse", "reflectance": color}
    return {"type": "twosided", "bsdf": bsdf}


def _image(material):
    import mitsuba as mi

    bitmap = mi.Bitmap(str(material.image)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    data = np.array(bitmap) * np.asarray(material.color, np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(data.astype(np.float32)), "raw": True, "filter_type": "bilinear"}


def _mesh(mesh, material, bsdf):
    import mitsuba as mi

    properties = mi.Properties()
    properties["bsdf"] = bsdf
    if material.emits:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": _color(material.emission)})
    made = mi.Mesh(
        mesh.name, len(mesh.positions), len(mesh.triangles), props=properties, has_vertex_normals=True,
        has_vertex_texcoords=True,
    )  # fmt: skip
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = mesh.positions.astype(np.float32).ravel()
    parameters["vertex_normals"] = mesh.normals.astype(np.float32).ravel()
    parameters["vertex_texcoords"] = mesh.uvs.astype(np.float32).ravel()
    parameters["faces"] = mesh.triangles.astype(np.uint32).ravel()
    parameters.update()
    return made


def _scene(job):
    import mitsuba as mi

    scene = read(job.scene)
    camera = scene.camera
    look = mi.ScalarTransform4f().look_at(*(v.tolist() for v in (camera.position, camera.target, camera.up)))
    described = {
        "type": "scene",
        # Counts the lamp's vertex as well.
        "integrator": {"type": "path", "max_depth": job.max_depth + 1},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": float(np.degrees(camera.y_fov)),
            "near_clip": 0.01,
            "to_world": look,
            "film": {
                "type": "hdrfilm",
                "width": job.width,
                "height": job.height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": "independent"},
        },
    }
    if max(job.environment) > 0.0:
        described["environment"] = {"type": "constant", "radiance": _color(job.environment)}
    # One BSDF for all meshes of a material: each is a case of the compiled kernel.
    bsdfs = [mi.load_dict(_bsdf(material)) for material in scene.materials]
    for number, mesh in enumerate(scene.meshes):
        described[f"mesh{number}"] = _mesh(mesh, scene.materials[mesh.material], bsdfs[mesh.material])
    return mi.load_dict(described)


def _render(scene, job, spp, seed):
    """The mean of as many passes as memory asks for."""
    import mitsuba as mi

    per_pass = max(1, min(spp, MOST_LANES // (job.width * job.height)))
    total = np.zeros((job.height, job.width, 3), np.float64)
    done = 0
    while done < spp:
        count = min(per_pass, spp - done)
        # Passes differ by their seeds, and so must renders.
        picture = mi.render(scene, spp=count, seed=seed * 100_003 + done)
        total += count * np.array(picture, np.float64)
        done += count
    return (total / spp).astype(np.float32)


def render(job):
    import mitsuba as mi

    variant = _variant()
    mi.set_variant(variant)
    import drjit

    # Counts the threads that help the calling one.
    drjit.set_thread_count(max(job.threads - 1, 0) if variant == "scalar_rgb" else job.threads)

    def load():
        scene = _scene(job)
        # Compiles the kernel, which doesn't depend on the number of samples.
        _render(scene, job, 1, 12345)
        _render(scene, job, min(job.spp), 12345)
        return scene

    scene, seconds = timed(load)
    result = Result(f"{variant}, independent samples", seconds)
    for spp in job.spp:
        picture, taken = timed(lambda spp=spp: _render(scene, job, spp, job.seed))
        path = job.picture(f"mitsuba-{spp}-{job.seed}.npy")
        np.save(path, picture)
        result.renders.append(Render(spp, taken, str(path)))
    return result


if __name__ == "__main__":
    run(version, render)
