# SPDX-License-Identifier: Apache-2.0
"""relight evaluate: the sample's own truth, and a script written apart from the program."""
import json
import subprocess
import sys
import unittest

from relight_runner import SAMPLE, SHARED, RelightCase, made_capture, tree_png

TRUTH = SAMPLE / "truth" / "view_00_1700.exr"
ALPHA = SAMPLE / "truth" / "view_00_alpha.png"
PHOTO = SAMPLE / "photos" / "view_00.jpg"
FIGURES = ("psnr_low", "corr_low", "contrast", "corr_high", "level", "colour", "ring", "psnr",
           "ssim")


class Evaluate(RelightCase):
    def setUp(self):
        super().setUp()
        capture = made_capture(self.folder / "maple")
        self.result = self.folder / "result.exr"
        self.done(capture, "--to", "17:00", "-o", self.result)

    def score(self, result):
        return self.done("evaluate", result, TRUTH, "--input", PHOTO, "--alpha", ALPHA,
                         "--json").json

    def test_the_truth_is_right(self):
        row = self.score(TRUTH)["result"]
        self.assertGreater(row["psnr_low"], 100)
        for name, right in (("corr_low", 1), ("contrast", 1), ("level", 1), ("colour", 0)):
            self.assertAlmostEqual(row[name], right, places=6)

    def test_relighting_gains_over_doing_nothing(self):
        score = self.score(self.result)
        # 26.4 dB against 22.4 are usual with all views (design figures); three coarse ones of the
        # sample still gain more than 1 dB
        self.assertGreater(score["result"]["psnr_low"], score["nothing"]["psnr_low"] + 1)
        self.assertGreater(score["result"]["corr_low"], score["nothing"]["corr_low"])

    def test_table(self):
        lines = self.done("evaluate", self.result, TRUTH, "--input", PHOTO, "--alpha",
                          ALPHA).out.splitlines()
        self.assertEqual([line.split()[0] for line in lines[1:]],
                         ["result", "nothing", "histogram"])

    def test_pictures_that_do_not_fit(self):
        tiny = self.folder / "tiny.png"
        tree_png(tiny)
        self.refused("evaluate", tiny, TRUTH, "--input", PHOTO, "--alpha", ALPHA,
                     names=["64x64", "480x600"])
        self.refused("evaluate", self.folder / "none.exr", TRUTH, "--input", PHOTO, "--alpha",
                     ALPHA, names=["none.exr"])

    def test_agrees_with_the_reference_script(self):
        script = SHARED / "reference" / "score_relight.py"
        if not script.exists():
            self.skipTest(f"{script} is not there; set RELIGHT_SHARED to the folder that holds "
                          "reference/")
        python = next((p for p in ("/usr/bin/python3", sys.executable) if subprocess.run(
            [p, "-c", "import numpy, scipy, OpenImageIO"], capture_output=True).returncode == 0),
            None)
        if python is None:
            self.skipTest("no python3 with numpy, scipy and OpenImageIO for the reference script")
        # It takes its input as linear: the picture of the truth stands for it
        ours = self.done("evaluate", self.result, TRUTH, "--input", TRUTH, "--alpha", ALPHA,
                         "--json").json
        read = subprocess.run([python, script, self.result, TRUTH, TRUTH, ALPHA, "--json"],
                              capture_output=True, text=True)
        self.assertEqual(read.returncode, 0, read.stderr)
        theirs = json.loads(read.stdout)
        for row in ("result", "histogram"):
            for figure in FIGURES:
                if figure in theirs[row]:
                    # What both were asked to agree within: dB, and figures without unit
                    self.assertAlmostEqual(ours[row][figure], theirs[row][figure], delta=0.01,
                                           msg=f"{row} {figure}")


if __name__ == "__main__":
    unittest.main()
