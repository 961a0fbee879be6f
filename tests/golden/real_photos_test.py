#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Real photographs, which are not part of the repository: $RELIGHT_SHARED/data/photos, or ../shared
beside the checkout; skipped with a clear word when they are not there.

    fern           20 photos and a COLMAP model with distortion: capture, cameras
    brighton_park  18 drone photos, cast shadows measured: sun
    single_trees   one photo alone against the sky: matte from a trimap, relit by directions
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get("RELIGHT_SHARED", ROOT.parent / "shared"))
PHOTOS = SHARED / "data" / "photos"
PROGRAM = os.environ.get("RELIGHT_PROGRAM", str(ROOT / "build" / "dev" / "cli" / "relight"))

# A trimap of a tree against a blue sky, from colour alone: what a user paints in a minute.
# In a process of its own, for only Debian's python has OpenImageIO.
TRIMAP = """
import sys, numpy as np, OpenImageIO as oiio
from scipy import ndimage
rgb = oiio.ImageBuf(sys.argv[1]).get_pixels(oiio.FLOAT)[..., :3]
sky = (rgb[..., 2] > rgb[..., 1] + 0.02) & (rgb[..., 2] > 0.45)
tree = ~sky & (rgb.mean(-1) < 0.4)
tree[int(0.8 * len(tree)):] = False
solid = ndimage.binary_erosion(tree, iterations=2)
labels, count = ndimage.label(ndimage.binary_dilation(solid, iterations=6))
largest = labels == 1 + np.argmax(ndimage.sum(solid, labels, range(1, count + 1)))
trimap = np.full(sky.shape, 0.5, np.float32)
trimap[~ndimage.binary_dilation(largest, iterations=12)] = 0
trimap[ndimage.binary_erosion(sky, iterations=4)] = 0
trimap[solid & largest] = 1
image = oiio.ImageBuf(oiio.ImageSpec(*reversed(trimap.shape), 1, oiio.UINT8))
image.set_pixels(oiio.ROI(), np.ascontiguousarray(trimap[..., None]))
image.write(sys.argv[2])
"""


def relight(*words, check=True):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if check and done.returncode != 0:
        raise AssertionError(f"relight {words}: {done.returncode}\n{done.stderr}")
    return done


@unittest.skipUnless(PHOTOS.is_dir(), f"{PHOTOS} is not there; set RELIGHT_SHARED")
class RealPhotos(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.work = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def test_fern_is_a_capture_with_cameras(self):
        relight("init", self.work / "fern", PHOTOS / "fern" / "images")
        relight("cameras", self.work / "fern", "--import", "colmap", PHOTOS / "fern" / "sparse",
                "--keep-frame")
        info = json.loads(relight("info", self.work / "fern", "--json").stdout)
        self.assertEqual(len(info["views"]), 20)
        self.assertTrue(all(view["camera"] for view in info["views"]))
        self.assertTrue(any("mattes" in lack for lack in info["lacks"]))

    def test_brighton_has_the_sun_that_its_shadows_show(self):
        # SOURCE.md: shadows at 77.6 and 80.8 deg, 21:33 UTC
        sky = json.loads(relight("sky", "--place", "46.842,-91.993", "--json",
                                 "--taken", "2016-06-23T16:33-05:00").stdout)
        shadow = (sky["sun_azimuth_deg"] + 180) % 360
        self.assertAlmostEqual(shadow, 79.2, delta=2.5)  # The two shadows differ by 3.2 deg
        relight("init", self.work / "park", PHOTOS / "brighton_park" / "images")
        relight("cameras", self.work / "park", "--import", "colmap",
                PHOTOS / "brighton_park" / "sparse_enu")

    def test_one_photo_alone_is_relit_by_directions(self):
        photo = PHOTOS / "single_trees" / "oak_bark_2.jpg"
        trimap, matte = self.work / "trimap.png", self.work / "matte.png"
        made = subprocess.run(["/usr/bin/python3", "-c", TRIMAP, photo, trimap],
                              capture_output=True, text=True)
        if "ModuleNotFoundError" in made.stderr:
            self.skipTest("needs Debian's python3-openimageio and python3-scipy")
        self.assertEqual(made.returncode, 0, made.stderr)
        relight("matte", photo, "--trimap", trimap, "-o", matte)
        missing = relight("hour", photo, "--to", "17:00", "--matte", matte, check=False)
        self.assertEqual(missing.returncode, 1)
        for option in ("--taken", "--place", "--heading"):
            self.assertIn(option, missing.stderr)
        keep = os.environ.get("RELIGHT_KEEP")
        out = pathlib.Path(keep) if keep else self.work
        done = relight("hour", photo, "--matte", matte, "--lit-from", "150,60",
                       "--to-light", "-80,20", "-o", out / "oak.jpg")
        self.assertIn("silhouette", done.stderr)
        self.assertIn("from the left", done.stderr)
        # A phone's deep blue is a clear sky, too: lit from behind the camera, as it shows
        air = relight("hour", photo, "--matte", matte, "--lit-from", "180,40",
                      "--to-light", "100,40", "-o", self.work / "air.jpg", "--json")
        sky = json.loads(air.stdout)["sky"]
        self.assertEqual(sky["turbidity_from"], "photos", air.stderr)
        self.assertTrue(2 < sky["turbidity"] < 8, sky)
        self.assertGreater((out / "oak.jpg").stat().st_size, 10000)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "-v"])
