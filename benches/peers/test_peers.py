"""Tests of what the peers share. They need numpy and none of the renderers.

    python -m unittest discover benches/peers
"""

import json
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np

import gltf
import jobs
import pictures


def triangle(name="t", material=0):
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    normals = np.tile([0.0, 0.0, 1.0], (3, 1))
    return gltf.Mesh(name, material, positions, normals, positions[:, :2], np.array([[0, 1, 2]]))


class Gltf(unittest.TestCase):
    def test_what_is_written_is_read_again(self):
        lamp = gltf.Material("lamp", (0.0, 0.0, 0.0), emission=(18.0, 14.0, 9.0))
        metal = gltf.Material("metal", (0.9, 0.7, 0.4), metallic=True, roughness=0.4)
        camera = gltf.Camera.looking((0, 1, 5), (0, 1, 0), 40.0)
        scene = gltf.Scene([triangle("a", 1), triangle("b", 0)], [lamp, metal], camera)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.gltf"
            gltf.write(scene, path)
            again = gltf.read(path)
        self.assertEqual([(mesh.name, mesh.material) for mesh in again.meshes], [("a", 1), ("b", 0)])
        np.testing.assert_allclose(again.meshes[0].positions, triangle().positions)
        np.testing.assert_allclose(again.materials[0].emission, lamp.emission)
        self.assertEqual(again.materials[1], metal)
        np.testing.assert_allclose(again.camera.to_world, camera.to_world)
        np.testing.assert_allclose(again.camera.target, [0, 1, 4])

    def test_a_mirrored_mesh_keeps_its_front(self):
        scene = gltf.Scene()
        mirror = np.diag([-2.0, 1.0, 1.0, 1.0])
        scene.add(gltf.Scene([triangle()], [gltf.Material("m")]), transform=mirror)
        mesh = scene.meshes[0]
        a, b, c = mesh.positions[mesh.triangles[0]]
        self.assertGreater(np.cross(b - a, c - a) @ mesh.normals[0], 0.0)

    def test_meshes_may_be_chosen_and_painted(self):
        other = gltf.Scene([triangle("a"), triangle("b")], [gltf.Material("m")])
        scene = gltf.Scene([triangle()], [gltf.Material("first")])
        scene.add(other, only=["b"], material=gltf.Material("gray"))
        self.assertEqual([mesh.name for mesh in scene.meshes], ["t", "b"])
        self.assertEqual(scene.materials[scene.meshes[1].material].name, "gray")

    def test_a_placement_scales_turns_and_moves(self):
        place = gltf.placement((1, 2, 3), 90.0, 10.0)
        np.testing.assert_allclose(place @ [0, 0, 1, 1], [11, 2, 3, 1], atol=1e-12)


class Jobs(unittest.TestCase):
    def read(self, **fields):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "job.json"
            path.write_text(json.dumps(fields))
            return jobs.Job.read(path)

    def test_a_job_is_read(self):
        job = self.read(task="render", scene="a.gltf", width=4, height=3, spp=[1, 2], out="o", threads=2)
        self.assertEqual((job.scene, job.threads, job.max_depth), (Path("a.gltf"), 2, 9))

    def test_a_wrong_job_is_refused(self):
        right = {"task": "render", "scene": "a", "width": 4, "height": 3, "spp": [1], "out": "o"}
        for wrong in ({"sppp": 4}, {"task": "paint"}):
            with self.assertRaises(ValueError):
                self.read(**(right | wrong))
        with self.assertRaises(ValueError):
            self.read(task="render")

    def test_increases_are_those_of_the_same_run(self):
        self.assertEqual(jobs.increase([3.0, 6.0], [2.0, 4.0]), {"median": 50.0, "low": 50.0, "high": 50.0})
        self.assertEqual(jobs.spread([4, 1, 2, 3])["median"], 2.5)


class Pictures(unittest.TestCase):
    def test_a_reference_is_reduced_by_blocks(self):
        big = np.arange(4 * 4 * 3, dtype=float).reshape(4, 4, 3)
        small = pictures.reduced(big, (2, 2, 3))
        np.testing.assert_allclose(small[0, 0], big[:2, :2].mean((0, 1)))
        with self.assertRaises(ValueError):
            pictures.reduced(big, (3, 3, 3))

    def test_errors_are_relative_but_not_to_darkness(self):
        reference = np.ones((2, 2, 3))
        measured = pictures.errors(1.1 * reference, reference)
        self.assertAlmostEqual(measured["relative_rmse"], 0.1)
        self.assertAlmostEqual(measured["level"], 1.1)
        reference[0, 0] = 0.0
        measured = pictures.errors(reference + 0.01, reference)
        self.assertLess(measured["relative_rmse"], 0.1)

    def test_a_sheet_is_a_png(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            np.save(folder / "a.npy", np.full((2, 3, 3), 0.5, np.float32))
            job = {
                "reference": folder / "a.npy",
                "pictures": [{"file": folder / "a.npy", "spp": 4}],
                "sheet": folder / "sheet.png",
            }
            compared = pictures.compare(job)
            data = (folder / "sheet.png").read_bytes()
        self.assertEqual(compared["errors"][0]["relative_rmse"], 0.0)
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        length = int.from_bytes(data[33:37])
        self.assertEqual(len(zlib.decompress(data[41 : 41 + length])), 2 * (1 + 6 * 3))


if __name__ == "__main__":
    unittest.main()
