# SPDX-License-Identifier: Apache-2.0
"""`relight matte`: a photo's matte from a trimap, from scribbles, before a screen, from a mask cut
by hand, or against the sky; what it prints, writes and refuses."""
import shutil
import signal
import struct
import subprocess
import time
import unittest
import zlib

from relight_runner import (PROGRAM, SAMPLE, SHARED, VIEWS, Exr, Png, RelightCase, relight,
                            small_capture, wait_until_it_listens, write_png)

PHOTO = SAMPLE / "photos" / "view_00.jpg"
TRIMAP = SAMPLE / "trimaps" / "view_00.png"
TRUE = SHARED / "data" / "maple" / "alpha" / "view_00.png"


def values(png):
    picture = Png(png)
    return [v / (2 ** picture.bits - 1) for v in picture.samples]


def apart(a, b):
    return sum(abs(x - y) for x, y in zip(a, b)) / len(a)


class OnePhoto(RelightCase):
    def setUp(self):
        super().setUp()
        self.trimap = Png(TRIMAP)
        self.given = [v / 255 for v in self.trimap.samples]

    def matte(self, *words, **how):
        out = self.folder / "m.png"
        self.done("matte", PHOTO, *words, "-o", out, **how)
        return values(out)

    def test_against_the_sky_alone(self):
        matte = self.matte()
        # Where the hand-made trimap is sure, the found one is of its mind
        wrong = sum(abs(m - g) > 0.5 for m, g in zip(matte, self.given) if g in (0, 1))
        self.assertLess(wrong / len(matte), 0.01)

    def test_says_how_sure_it_is(self):
        answer = self.done("matte", PHOTO, "-o", self.folder / "m.png", "--json").json
        self.assertEqual(answer["matte"], str(self.folder / "m.png"))
        self.assertEqual(answer["made_from"], "the sky behind the tree")
        self.assertGreater(answer["confidence"], 0.5)
        self.assertIsInstance(answer["doubts"], list)

    def test_same_bytes_whatever_the_threads(self):
        found = []
        for threads in (1, 3):
            self.done("matte", PHOTO, "-o", self.folder / "m.png", "--foreground",
                      self.folder / "f.exr", "--save-trimap", self.folder / "t.png", "--threads",
                      threads)
            found.append([(self.folder / f).read_bytes() for f in ("m.png", "f.exr", "t.png")])
        self.assertEqual(found[0], found[1])
        self.assertEqual(set(Exr(self.folder / "f.exr").types.values()), {"half"})
        self.assertEqual(set(Png(self.folder / "t.png").samples) - {0, 65535}, {32896})

    def strokes(self, file, alpha):
        """White on what the trimap knows to be tree, black on what it knows to be none, thin."""
        def pixel(x, y):
            known = self.trimap.at(x, y)[0]
            drawn = known in (0, 255) and (x % 40 < 3 or y % 40 < 3)
            if alpha:
                return (known,) * 3 + (255 if drawn else 0,)
            return (known,) * 3 if drawn else (128,) * 3
        return write_png(self.folder / file, self.trimap.width, self.trimap.height,
                         4 if alpha else 3, pixel)

    def test_scribbles(self):
        best = self.matte("--trimap", TRIMAP)
        on_grey = self.matte("--scribbles", self.strokes("s.png", False))
        on_nothing = self.matte("--scribbles", self.strokes("a.png", True))
        self.assertEqual(on_grey, on_nothing)
        self.assertLess(apart(on_grey, best), 0.08)
        helped = self.matte("--scribbles", self.strokes("s.png", False), "--automatic")
        self.assertLess(apart(helped, best), 0.05)
        # What is drawn on holds
        for x, y in ((0, 0), (0, 40)):
            if self.trimap.at(x, y)[0] == 0:
                self.assertEqual(helped[y * self.trimap.width + x], 0)

    def test_scribbles_as_two_masks(self):
        for name, label in (("tree.png", 255), ("sky.png", 0)):
            write_png(self.folder / name, self.trimap.width, self.trimap.height, 1,
                      lambda x, y: (255 if self.trimap.at(x, y)[0] == label and
                                    (x % 40 < 3 or y % 40 < 3) else 0,))
        two = self.matte("--scribbles", self.folder / "tree.png", self.folder / "sky.png")
        self.assertEqual(two, self.matte("--scribbles", self.strokes("s.png", False)))

    def test_refines_a_mask_cut_by_hand(self):
        best = self.matte("--trimap", TRIMAP)
        width, height = self.trimap.width, self.trimap.height
        # Hard edges, and holes of up to 8 pixels along a row filled
        cut = [m > 0.5 for m in best]
        for y in range(height):
            solid = [x for x in range(width) if cut[y * width + x]]
            for left, right in zip(solid, solid[1:]):
                if right - left <= 8:
                    cut[y * width + left:y * width + right] = [True] * (right - left)
        hard = write_png(self.folder / "hard.png", width, height, 1,
                         lambda x, y: (255 if cut[y * width + x] else 0,))
        refined = self.matte("--refine", hard)
        self.assertLess(apart(refined, best), 0.6 * apart(values(hard), best))

    def test_methods_and_colours_are_choices(self):
        best = self.matte("--trimap", TRIMAP)
        for words in (("--matte-method", "ruzon2000"), ("--prior", "none"),
                      ("--matting-color", "display")):
            other = self.matte("--trimap", TRIMAP, *words)
            self.assertNotEqual(other, best, words)
            self.assertLess(apart(other, best), 0.2, words)

    @unittest.skipUnless(TRUE.exists(), "the true alphas are not there")
    def test_the_default_is_nearer_to_the_truth_than_other_choices(self):
        truth = values(TRUE)
        best = apart(self.matte("--trimap", TRIMAP), truth)
        for words in (("--matte-method", "ruzon2000"), ("--prior", "none"),
                      ("--matting-color", "display")):
            self.assertLess(best, apart(self.matte("--trimap", TRIMAP, *words), truth), words)

    def test_guides_exclude_each_other(self):
        self.refused("matte", PHOTO, "--trimap", TRIMAP, "--screen", "auto", code=2,
                     names=["--trimap", "--screen", "one of them"])
        self.refused("matte", PHOTO, "--trimap", TRIMAP, "--automatic", code=2,
                     names=["--automatic", "--scribbles"])

    def test_what_is_written_is_no_input(self):
        shutil.copy(TRIMAP, self.folder / "t.png")
        self.refused("matte", PHOTO, "--trimap", self.folder / "t.png", "-o",
                     self.folder / "t.png", names=["t.png", "is an input"])

    def test_names_say_what_is_written(self):
        for words in (("-o", "m.jpg"), ("-o", "m.png", "--foreground", "f.png"),
                      ("-o", "m.png", "--save-trimap", "t.exr"),
                      ("-o", "m.png", "--save-trimap", "m.png")):
            words = [w if w[0] == "-" else self.folder / w for w in words]
            self.refused("matte", PHOTO, *words, code=2, names=[words[-1].name])
            self.assertEqual(list(self.folder.iterdir()), [])

    def test_strokes_of_another_size_and_without_strokes(self):
        small = write_png(self.folder / "small.png", 20, 20, 3, lambda x, y: (255,) * 3)
        self.refused("matte", PHOTO, "--scribbles", small,
                     names=["small.png", "20 x 20", "480 x 600"])
        grey = write_png(self.folder / "grey.png", 480, 600, 1, lambda x, y: (128,))
        self.refused("matte", PHOTO, "--scribbles", grey, names=["grey.png", "no stroke"])

    def test_ctrl_c_leaves_nothing(self):
        out = self.folder / "m.png"
        run = subprocess.Popen([PROGRAM, "matte", str(PHOTO), "--matte-method", "ruzon2000", "-o",
                                str(out)], stderr=subprocess.PIPE, text=True)
        wait_until_it_listens(run)
        time.sleep(0.4)
        run.send_signal(signal.SIGINT)
        begin = time.monotonic()
        _, said = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, said)
        self.assertLess(time.monotonic() - begin, 2)  # 0.2 s on an idle machine
        self.assertEqual(list(self.folder.iterdir()), [])


class Screens(RelightCase):
    def photo(self, screen):
        """A brown disc of soft edge, with a screen's light on its rim."""
        def pixel(x, y):
            r = ((x - 60) ** 2 + (y - 60) ** 2) ** 0.5
            a = min(1, max(0, (36 - r) / 4))
            spill = 0.3 * max(0, min(1, (r - 24) / 10))
            body = [v * (1 - spill) + s * spill for v, s in zip((120, 90, 50), screen)]
            return tuple(round(a * b + (1 - a) * s) for b, s in zip(body, screen))
        return write_png(self.folder / "photo.png", 120, 120, 3, pixel)

    def test_blue(self):
        photo = self.photo((20, 60, 200))
        answer = self.done("matte", photo, "--screen", "auto", "-o", self.folder / "m.png",
                           "--foreground", self.folder / "f.exr", "--json").json
        self.assertEqual(answer["made_from"], "the blue screen")
        matte = values(self.folder / "m.png")
        self.assertEqual(matte[5 * 120 + 5], 0)
        self.assertEqual(matte[60 * 120 + 60], 1)
        self.assertTrue(0.1 < matte[60 * 120 + 60 + 34] < 0.9)
        colours = Exr(self.folder / "f.exr").values()
        for r, g, b in zip(colours["R"], colours["G"], colours["B"]):
            self.assertLessEqual(b, max(r, g) * 1.001 + 1e-6, "blue light is left")

    def test_green_is_warned_of(self):
        outcome = self.done("matte", self.photo((30, 190, 40)), "--screen", "green", "-o",
                            self.folder / "m.png")
        self.assertIn("blue one", outcome.err)

    def test_no_screen(self):
        self.refused("matte", self.photo((128, 128, 128)), "--screen", "auto",
                     names=["photo.png", "no blue or green screen", "--screen R,G,B"])
        self.refused("matte", self.photo((20, 60, 200)), "--screen", "mauve", code=2,
                     names=["auto, blue, green", "mauve"])


class OddFiles(RelightCase):
    """Sizes and kinds of files."""
    def photo(self, width, height):
        return write_png(self.folder / "photo.png", width, height, 3,
                         lambda x, y: ((x * 37 + y) % 200, (y * 11 + x) % 200, (x * y) % 200))

    def test_sizes(self):
        for width, height in ((1, 1), (3, 20000), (2, 50)):
            photo = self.photo(width, height)
            trimap = write_png(self.folder / "t.png", width, height, 1, lambda x, y: (
                255 if y == 0 else 0 if y == height - 1 else 128,))
            self.done("matte", photo, "--trimap", trimap, "-o", self.folder / "m.png")
            matte = Png(self.folder / "m.png")
            self.assertEqual((matte.width, matte.height), (width, height))

    def trimaps(self, name, pixel, channels=1, bits=8):
        return write_png(self.folder / name, 60, 50, channels, pixel, bits)

    def test_kinds_of_trimaps(self):
        photo = self.photo(60, 50)
        def label(x):
            return 0 if x < 20 else 255 if x >= 40 else 128
        kinds = [self.trimaps("8.png", lambda x, y: (label(x),)),
                 self.trimaps("16.png", lambda x, y: (label(x) * 257,), bits=16),
                 self.trimaps("rgb.png", lambda x, y: (label(x),) * 3, channels=3),
                 self.trimaps("alpha.png", lambda x, y: (9, 8, 7, label(x)), channels=4),
                 self.palette("palette.png", [0, 128, 255], lambda x, y: (0, 1, 2)[
                     0 if x < 20 else 2 if x >= 40 else 1])]
        mattes = []
        for kind in kinds:
            self.done("matte", photo, "--trimap", kind, "-o", self.folder / "m.png")
            mattes.append((self.folder / "m.png").read_bytes())
        self.assertEqual(set(mattes), {mattes[0]})

    def palette(self, name, greys, index):
        def chunk(kind, data):
            body = kind + data
            return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))
        rows = b"".join(b"\0" + bytes(index(x, y) for x in range(60)) for y in range(50))
        file = self.folder / name
        file.write_bytes(b"\x89PNG\r\n\x1a\n" +
                         chunk(b"IHDR", struct.pack(">IIBBBBB", 60, 50, 8, 3, 0, 0, 0)) +
                         chunk(b"PLTE", b"".join(bytes([g] * 3) for g in greys)) +
                         chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
        return file

    def test_trimaps_that_lack_something(self):
        photo = self.photo(60, 50)
        for name, levels, said in (("no_tree.png", (0, 128), "no foreground"),
                                   ("no_sky.png", (128, 255), "no background")):
            trimap = self.trimaps(name, lambda x, y: (levels[x < 30],))
            self.refused("matte", photo, "--trimap", trimap, names=[name, said, "mark some"])
        known = self.trimaps("known.png", lambda x, y: (255 if x < 30 else 0,))
        self.done("matte", photo, "--trimap", known, "-o", self.folder / "m.png")
        self.assertEqual(set(Png(self.folder / "m.png").samples), {0, 65535})
        for name, levels, said in (("known.png", (0, 255), "no unknown"),
                                   ("all.png", (255, 255), "no background"),
                                   ("none.png", (0, 0), "no foreground")):
            known = self.trimaps(name, lambda x, y: (levels[x < 30],))
            done = self.done("matte", photo, "--trimap", known, "-o", self.folder / "m.png")
            self.assertIn(said, done.err)

    def test_pixels_that_are_no_numbers(self):
        if shutil.which("oiiotool") is None:
            self.skipTest("oiiotool is not there")
        photo, bad = self.photo(60, 50), self.folder / "bad.exr"
        subprocess.run(["oiiotool", str(photo),
                        "--mulc", "1e38,1,1", "--mulc", "1e38,1,1", "-d", "float", "-o", str(bad)],
                       check=True)
        trimap = self.trimaps("t.png", lambda x, y: ((0, 128, 255)[x // 20],))
        self.refused("matte", bad, "--trimap", trimap, names=["bad.exr", "NaN"])


class OfACapture(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = small_capture(self.folder / "capture")

    def test_automatic_with_one_photo_scribbled_on(self):
        trimap = Png(self.capture / "trimaps" / "view_00.png")
        shutil.rmtree(self.capture / "trimaps")
        plain = self.done("matte", self.capture, "--json").json
        self.assertEqual([r["view"] for r in plain], list(VIEWS))
        self.assertEqual({r["made_from"] for r in plain}, {"the sky behind the tree"})
        again = self.done("matte", self.capture)
        self.assertEqual(again.out, "", "nothing is made twice")

        (self.capture / "scribbles").mkdir()
        write_png(self.capture / "scribbles" / "view_00.png", trimap.width, trimap.height, 4,
                  lambda x, y: (trimap.at(x, y)[0],) * 3 +
                  (255 if trimap.at(x, y)[0] in (0, 255) and x % 60 < 3 else 0,))
        taught = self.done("matte", self.capture, "--json").json
        self.assertIn("scribbles", taught[0]["made_from"])
        self.assertEqual(self.done("matte", self.capture).out, "")

    def test_a_matte_of_ones_own_is_kept(self):
        (self.capture / "mattes").mkdir()
        own = write_png(self.capture / "mattes" / "view_04.png", 480, 600, 1,
                        lambda x, y: (255 if 100 < x < 300 else 0,)).read_bytes()
        outcome = self.done("matte", self.capture, "--force", "--json")
        self.assertEqual((self.capture / "mattes" / "view_04.png").read_bytes(), own)
        self.assertEqual(outcome.json[1]["made_from"], "")

    def test_options_of_a_photo_are_refused(self):
        self.refused("matte", self.capture, "--refine", TRIMAP, code=2,
                     names=["belong to one photo", "scribbles/"])


if __name__ == "__main__":
    unittest.main()
