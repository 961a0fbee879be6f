# SPDX-License-Identifier: Apache-2.0
"""A volume opens in Blender: its grid, its place, and what it holds."""
import json
import pathlib
import subprocess
import unittest

from relight_runner import RelightCase, small_capture

SCRIPT = pathlib.Path(__file__).parent / "blender_volume.py"


class Blender(RelightCase):
    def test_sees_the_same_tree(self):
        capture = small_capture(self.folder / "maple")
        self.done("volume", capture)
        volume = capture / "volume.vdb"
        ours = self.done("info", volume, "--json").json
        run = subprocess.run(
            ["blender", "--background", "--python-exit-code", "3", "--python", str(SCRIPT),
             "--", str(volume), str(self.folder / "sum.exr")],
            capture_output=True, text=True, timeout=300)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        line = next(x for x in run.stdout.splitlines() if x.startswith("BLENDER "))
        theirs = json.loads(line[len("BLENDER "):])
        self.assertEqual(theirs["grids"], [{"name": "extinction", "type": "FLOAT"}])
        # Blender's box is of the centres of blocks of 8 voxels, counted from our corner
        cell = ours["cell_m"]
        for axis in range(3):
            for side, voxel in (("low", 0.5), ("high", 8 * -(-ours["cells"][axis] // 8) - 0.5)):
                blocks = (theirs[side][axis] - ours["lower_corner_m"][axis] - voxel * cell) / cell
                self.assertAlmostEqual(blocks / 8, round(blocks / 8), delta=0.01)
                self.assertLessEqual(abs(blocks), 16)  # What is empty at the border is left out
        voxels = ours["cells"][0] * ours["cells"][1] * ours["cells"][2]
        held = ours["mean_per_m"] * voxels * cell ** 3
        # Its pixels and steps are finer than a voxel, and jittered: some per cent
        self.assertAlmostEqual(theirs["sum_m2"] / held, 1, delta=0.05)


if __name__ == "__main__":
    unittest.main()
