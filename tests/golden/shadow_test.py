# SPDX-License-Identifier: Apache-2.0
"""The tree's shadow on the ground: its file, the layers, the flat result, the old shadow."""
import io
import unittest
import zipfile
from xml.etree import ElementTree

from relight_runner import Exr, Png, RelightCase, made_capture, write_png


def encoded(linear):
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055


def png_of(data, folder):
    file = folder / "of_zip.png"
    file.write_bytes(data)
    return Png(file)


class TheShadow(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")
        self.matte = Png(self.capture / "mattes" / "view_00.png")

    def shadow(self, name, *words):
        file = self.folder / name
        outcome = self.done(self.capture, *(words or ("--to", "17:00")), "-o",
                            self.folder / "tree.png", "--shadow", file)
        self.assertIn(str(file), outcome.out)
        return file

    def test_is_what_the_tree_leaves_of_the_light(self):
        exr = Exr(self.shadow("s.exr"))
        self.assertEqual((exr.width, exr.height, sorted(exr.types)), (480, 600, ["B", "G", "R"]))
        light = exr.values()
        for name in "RGB":
            self.assertGreaterEqual(min(light[name]), 0)
            self.assertEqual(max(light[name]), 1)
        # The sun stands on the left: the shadow falls to the right, and not into the sky
        dark = [i for i, g in enumerate(light["G"]) if g < 0.7]
        self.assertGreater(len(dark), 3000)
        self.assertGreater(sum(i % 480 > 240 for i in dark), 0.9 * len(dark))
        self.assertGreater(min(i // 480 for i in dark), 400)
        # It takes the sky's blue
        self.assertGreater(sum(light["B"][i] for i in dark), 1.1 * sum(light["R"][i] for i in dark))

    def test_png_is_the_same_encoded(self):
        light = Exr(self.shadow("s.exr")).values()
        png = Png(self.shadow("s.png"))
        for i in range(0, 480 * 600, 97):
            for c, name in enumerate("RGB"):
                # A half's 11 bits, and 16 of the PNG
                self.assertAlmostEqual(png.samples[3 * i + c] / 65535, encoded(light[name][i]),
                                       delta=6e-4)

    def test_no_step_at_the_foot_of_the_matte(self):
        light = Exr(self.shadow("s.exr")).values()["G"]
        # Along the rows of the ground neighbours differ as a shadow's edge does, nowhere by
        # the whole of it: the sun's disc and the voxels of 0.25 m span some pixels
        steps = [abs(light[y * 480 + x + 1] - light[y * 480 + x])
                 for y in range(470, 560) for x in range(479)]
        self.assertLess(max(steps), 0.35)

    def test_layers(self):
        ora = self.folder / "x.ora"
        self.done(self.capture, "--to", "17:00", "-o", ora)
        with zipfile.ZipFile(ora) as archive:
            first = archive.infolist()[0]
            self.assertEqual((first.filename, first.compress_type), ("mimetype",
                                                                     zipfile.ZIP_STORED))
            self.assertEqual(archive.read("mimetype"), b"image/openraster")
            layers = ElementTree.parse(io.BytesIO(archive.read("stack.xml"))).findall(
                ".//layer")
            self.assertEqual([(x.get("name"), x.get("composite-op", "svg:src-over"))
                              for x in layers],
                             [("tree", "svg:src-over"), ("shadow", "svg:multiply")])
            tree, shadow = (png_of(archive.read(x.get("src")), self.folder) for x in layers)
        self.assertEqual((tree.bits, tree.channels, shadow.bits, shadow.channels), (8, 4, 8, 3))
        for i in range(0, 480 * 600, 89):
            self.assertAlmostEqual(tree.samples[4 * i + 3] / 255, self.matte.samples[i] / 65535,
                                   delta=0.51 / 255)

    def test_flat_over_a_backdrop_is_the_layers_multiplied(self):
        backdrop = write_png(self.folder / "b.png", 480, 600, 3,
                             lambda x, y: (40 + x % 200, 200 - y % 150, (x * y) % 256))
        flat, ora = self.folder / "flat.png", self.folder / "x.ora"
        self.done(self.capture, "--to", "17:00", "--over", backdrop, "-o", flat)
        self.done(self.capture, "--to", "17:00", "-o", ora)
        with zipfile.ZipFile(ora) as archive:
            tree = png_of(archive.read("data/tree.png"), self.folder)
            shadow = png_of(archive.read("data/shadow.png"), self.folder)
        below, result = Png(backdrop), Png(flat)
        worst = 0
        for i in range(480 * 600):
            a = tree.samples[4 * i + 3] / 255
            for c in range(3):
                layers = round(below.samples[3 * i + c] * shadow.samples[3 * i + c] / 255)
                layers = round((1 - a) * layers + a * tree.samples[4 * i + c])
                worst = max(worst, abs(result.samples[3 * i + c] / 257 - layers))
        self.assertLessEqual(worst, 3)

    def test_the_old_shadow_goes_and_the_new_one_comes(self):
        moved, kept = self.folder / "moved.png", self.folder / "kept.png"
        outcome = self.done(self.capture, "--to", "17:00", "--whole", "-o", moved)
        self.assertIn("approximately", outcome.err)
        outcome = self.done(self.capture, "--to", "17:00", "--whole", "--keep-shadow", "-o",
                            kept)
        self.assertNotIn("approximately", outcome.err)
        photo = self.folder / "photo.png"
        self.done(self.capture, "--to", "same", "--whole", "-o", photo)
        before = Exr(self.shadow("in.exr", "--to", "12:55")).values()["G"]
        after = Exr(self.shadow("out.exr")).values()["G"]
        taken, old, new = Png(photo), Png(kept), Png(moved)
        was = [i for i in range(480 * 600)
               if before[i] < 0.45 and after[i] > 0.95 and self.matte.samples[i] == 0]
        comes = [i for i in range(480 * 600)
                 if before[i] > 0.95 and after[i] < 0.6 and self.matte.samples[i] == 0]
        self.assertGreater(min(len(was), len(comes)), 500)

        def green(picture, places):
            return sum(picture.samples[3 * i + 1] for i in places) / len(places)
        self.assertEqual(green(old, was), green(taken, was))
        self.assertGreater(green(new, was), 1.5 * green(taken, was))
        self.assertLess(green(new, comes), 0.8 * green(taken, comes))

    def test_the_photo_tells_the_shadow_of_its_own_hour(self):
        own = Exr(self.shadow("own.exr", "--to", "same")).values()["G"]
        later = Exr(self.shadow("later.exr", "--to", "14:30")).values()["G"]
        # Flecks of sun, which the volume's mean does not have
        def roughness(light):
            rows = range(505, 530)
            return sum(abs(light[y * 480 + x + 1] - light[y * 480 + x])
                       for y in rows for x in range(100, 380))
        self.assertGreater(roughness(own), 1.5 * roughness(later))

    def test_what_cannot_be(self):
        out = self.folder / "x.png"
        backdrop = write_png(self.folder / "small.png", 48, 60, 3, lambda x, y: (9, 9, 9))
        for words, names, code in (
                (("--whole", "--over", backdrop), ("--whole", "--over"), 2),
                (("--over", backdrop), (backdrop, "480 x 600"), 1),
                (("--over", self.folder / "no.png"), ("no.png",), 1),
                (("--shadow", self.folder / "s.txt"), ("s.txt", ".exr"), 2),
                (("--shadow", out), (out, "two outputs"), 2),
                (("--shadow", self.folder / "s.png", "--ground", "5"), ("--ground",), 1),
                (("--shadow", self.folder / "s.png", "--ground", "-100"), ("--ground",), 1)):
            with self.subTest(words):
                self.refused(self.capture, "--to", "17:00", "-o", out, *words, names=names,
                             code=code)
        self.refused(self.capture, "--to", "17:00", "--whole", "-o", self.folder / "x.ora",
                     names=("--whole",), code=2)

    def test_ground_at_another_height(self):
        high = Exr(self.shadow("high.exr", "--to", "17:00", "--ground", "0.5")).values()["G"]
        low = Exr(self.shadow("low.exr")).values()["G"]

        def lowest_row(light):
            return max(i // 480 for i, g in enumerate(light) if g < 0.7)
        self.assertLess(lowest_row(high), lowest_row(low))


if __name__ == "__main__":
    unittest.main()
