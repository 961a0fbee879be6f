# SPDX-License-Identifier: Apache-2.0
"""The main job: a photo at another hour, what is written and what is said."""
import math
import shutil
import unittest

from relight_runner import (SAMPLE, VIEWS, Exr, Png, RelightCase, contents, made_capture, tree_png,
                            with_exif, write_png)

PHOTO = SAMPLE / "photos" / "view_00.jpg"
FACTS = ("--place", "40.35,-74.65", "--taken", "2011-07-22T13:00", "--zone", "-04:00",
         "--heading", "0")
COARSE = ("--cells", "24")


class TheSampleAsItComes(RelightCase):
    def test_one_command(self):
        capture = self.folder / "maple"
        shutil.copytree(SAMPLE, capture)
        outcome = self.done(capture, "--to", "17:00")
        result = capture / "out" / "view_00_1700.png"
        self.assertEqual(outcome.out, f"{result}\n")
        picture = Png(result)
        self.assertEqual((picture.width, picture.height, picture.channels, picture.bits),
                         (480, 600, 4, 16))
        # Where the sun is at that hour and place, by the sample's cameras: the north is ahead
        self.assertIn("photo: sun behind you, 70° high, shadow falls away from you. "
                      "Wanted: from the left, 37°.", outcome.err)


class OfACapture(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")

    def test_names_of_what_is_written(self):
        for words, name in (((), "view_00_1700.png"),
                            (("--view", "view_08"), "view_08_1700.png"),
                            (("--to-light", "20,30"), "view_00_relit.png"),
                            (("--to", "2011-09-23T16:30"), "view_00_2011-09-23_1630.png"),
                            (("--to", "+3h"), "view_00_1600.png"),
                            (("--to", "same"), "view_00_1300.png")):
            with self.subTest(words):
                to = () if any(w.startswith("--to") for w in words) else ("--to", "17:00")
                outcome = self.done(self.capture, *words, *to)
                self.assertEqual(outcome.out, f"{self.capture / 'out' / name}\n")
                self.assertTrue((self.capture / "out" / name).is_file())

    def test_json_and_nothing_else_on_stdout(self):
        answer = self.done("hour", self.capture, "--view", "view_04", "--to", "17:00",
                           "--json").json
        self.assertEqual(answer["files"], [str(self.capture / "out" / "view_04_1700.png")])
        self.assertEqual(answer["view"], "view_04")
        self.assertAlmostEqual(answer["heading_deg"], 115.2, delta=0.1)  # As the camera is posed
        self.assertEqual(answer["target"]["time"], "2011-07-22T17:00:00-04:00")
        # NOAA's solar calculator for 40.35 N 74.65 W, 17:00 EDT: 266.29, 36.50 deg
        self.assertAlmostEqual(answer["target"]["azimuth_deg"], 266.29, delta=0.05)
        self.assertAlmostEqual(answer["target"]["elevation_deg"], 36.50, delta=0.05)
        self.assertGreater(answer["mean_ratio"], 0.2)
        self.assertLess(answer["mean_ratio"], 2)

    def test_quiet_prints_nothing(self):
        outcome = self.done(self.capture, "--to", "17:00", "--quiet")
        self.assertEqual((outcome.out, outcome.err), ("", ""))
        outcome = self.done("-q", "hour", self.capture, "--to", "17:00", "--json")
        self.assertEqual(outcome.err, "")
        self.assertIn("files", outcome.json)
        self.assertEqual(self.done("-q", "matte", self.capture, "--force").out, "")

    def test_same_input_same_bytes_whatever_the_threads(self):
        copies = []
        for threads in (1, 2, 3):
            copy = self.folder / f"copy_{threads}"
            shutil.copytree(self.capture, copy)
            self.done(copy, "--to", "17:00", "--force", "--threads", threads, "--irradiance",
                      copy / "light.exr", "--ratio", copy / "ratio.exr")
            self.done(copy, "--to", "17:00", "--threads", threads, "-o", copy / "out" / "x.exr")
            self.done(copy, "--to", "17:00", "--threads", threads, "-o", copy / "out" / "x.jpg")
            self.done(copy, "--to", "17:00", "--threads", threads, "-o", copy / "out" / "x.tif")
            copies.append(contents(copy))
        for other in copies[1:]:
            self.assertEqual(copies[0].keys(), other.keys())
            for name, content in copies[0].items():
                self.assertEqual(content, other[name], f"{name} depends on the threads")

    def test_a_photo_relit_to_its_own_hour_is_itself(self):
        def pixel(x, y):
            return tuple((x * 7919 + y * 104729 * (c + 1)) % 65521 for c in range(3))
        photo = write_png(self.folder / "graded.png", 480, 600, 3, pixel, bits=16)
        before = Png(photo)
        output = self.folder / "x.png"
        self.done(self.capture, "--photo", photo, "--to", "same", "--whole", "-o", output)
        after = Png(output)
        # The ratio is 1; linear light in floats comes back within half a step of 16 bits
        self.assertEqual(after.samples, before.samples)

    EVERY_TRANSPORT = ("--bounce", "--ground-albedo", "0.3", "--leaf-transmission", "0.4",
                       "--multiple-scattering", "0.3", "--clumping", "0.3", "--gap-length", "0.05")

    def test_ratio_of_the_own_hour_is_one(self):
        ratio = self.folder / "ratio.exr"
        for transport in ((), self.EVERY_TRANSPORT):
            self.done(self.capture, "--to", "same", *transport, "--ratio", ratio)
            values = Exr(ratio).values()
            self.assertEqual(sorted(values), ["B", "G", "R"])
            for name, channel in values.items():
                self.assertEqual((min(channel), max(channel)), (1.0, 1.0), name)

    def test_light_of_ground_and_leaves_is_indirect(self):
        light = self.folder / "light.exr"
        for words, is_lit in (((), False), (("--bounce",), True),
                              (("--multiple-scattering", "0.3"), True)):
            self.done(self.capture, "--to", "17:00", "--irradiance", light, "--components", *words)
            values = Exr(light).values()
            for hour in ("input", "target"):
                self.assertEqual(max(values[f"{hour}.indirect.G"]) > 0, is_lit, (words, hour))

    def test_the_papers_method_has_none_of_it(self):
        for words in (("--bounce",), ("--leaf-transmission", "0.4"), ("--clumping", "0.3"),
                      ("--multiple-scattering", "0.3")):
            self.refused(self.capture, "--to", "17:00", "--method", "cabral2011", *words,
                         names=["cabral2011", words[0]], code=2)

    def test_outside_the_tree_the_whole_photo_is_as_taken(self):
        photo = write_png(self.folder / "graded.png", 480, 600, 3,
                          lambda x, y: (x * 100, y * 100, 30000), bits=16)
        output = self.folder / "x.png"
        self.done(self.capture, "--photo", photo, "--to", "17:00", "--whole", "--keep-shadow",
                  "-o", output)
        before, after = Png(photo), Png(output)
        matte = Png(self.capture / "mattes" / "view_00.png")
        outside = [i for i, a in enumerate(matte.samples) if a == 0]
        inside = [i for i, a in enumerate(matte.samples) if a == 65535]
        self.assertGreater(len(outside), 10000)
        for i in outside:
            self.assertEqual(after.samples[3 * i:3 * i + 3], before.samples[3 * i:3 * i + 3])
        changed = sum(after.samples[3 * i:3 * i + 3] != before.samples[3 * i:3 * i + 3]
                      for i in inside)
        self.assertGreater(changed, len(inside) * 0.9)

    def test_layers_are_32_bit_and_agree_with_the_ratio(self):
        light, ratio = self.folder / "light.exr", self.folder / "ratio.exr"
        self.done(self.capture, "--to", "17:00", "--irradiance", light)
        names = {f"{hour}.{c}" for hour in ("input", "target") for c in "RGB"} | {"weight.Y"}
        self.assertEqual(set(Exr(light).types), names)
        outcome = self.done(self.capture, "--to", "17:00", "--irradiance", light, "--ratio", ratio,
                            "--components")
        self.assertEqual(outcome.out.split()[1:], [str(light), str(ratio)])
        exr = Exr(light)
        parts = {f"{hour}.{part}.{c}" for hour in ("input", "target")
                 for part in ("sun", "sky", "indirect") for c in "RGB"}
        self.assertEqual(set(exr.types), names | parts)
        self.assertEqual(set(exr.types.values()), {"float"})
        self.assertEqual(set(Exr(ratio).types.values()), {"float"})
        values = exr.values()
        for hour in ("input", "target"):
            total = values[f"{hour}.G"]
            self.assertGreater(max(total), 1000)  # Lux
            for i in range(0, len(total), 97):
                parts = sum(values[f"{hour}.{part}.G"][i] for part in ("sun", "sky", "indirect"))
                # Three floats added in another order
                self.assertAlmostEqual(parts, total[i], delta=1e-5 * max(total))

    def test_exposure(self):
        def answer(*words):
            return self.done(self.capture, "--to", "17:00", "--json", *words).json
        same, brighter = answer(), answer("--exposure", "+1.5")
        self.assertEqual(same["exposure_ev"], 0)
        self.assertEqual(brighter["exposure_ev"], 1.5)
        self.assertEqual(brighter["mean_ratio"], same["mean_ratio"])
        auto = answer("--exposure", "auto")
        self.assertAlmostEqual(auto["exposure_ev"], -math.log2(same["mean_ratio"]), places=9)
        for wrong in ("bright", "nan", "99", "1EV"):
            self.refused(self.capture, "--to", "17:00", "--exposure", wrong, code=2,
                         names=["--exposure must be same, auto or a number", wrong])

    def test_one_stop_is_twice_the_light(self):
        pictures = []
        for ev in ("-3", "-2"):
            output = self.folder / f"ev{ev}.png"
            self.done(self.capture, "--to", "17:00", "-o", output, f"--exposure={ev}")
            pictures.append(Png(output))

        def linear(sample):
            s = sample / 65535
            return s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4
        checked = 0
        for i in range(0, len(pictures[0].samples), 4 * 53):
            if pictures[0].samples[i + 3] == 65535:
                a, b = linear(pictures[0].samples[i + 1]), linear(pictures[1].samples[i + 1])
                # Half a step of 16 bits in both, steepest at the light end: 2 * 2.3 / 65535
                self.assertAlmostEqual(b, 2 * a, delta=1e-4)
                checked += a > 0
        self.assertGreater(checked, 100)

    def test_light_given_as_the_camera_sees_it(self):
        answer = self.done(self.capture, "--lit-from", "180,60", "--to-light", "90,20",
                           "--json").json
        self.assertAlmostEqual(answer["input"]["azimuth_deg"],
                               (answer["heading_deg"] + 180) % 360, places=6)
        self.assertAlmostEqual(answer["target"]["azimuth_deg"],
                               (answer["heading_deg"] + 90) % 360, places=6)
        self.assertAlmostEqual(answer["target"]["elevation_deg"], 20, places=9)
        self.assertIn("right", answer["target"]["words"])
        for wrong in ("90", "90,0", "90,91", "a,b", "nan,20", "90,20,1"):
            self.refused(self.capture, "--to-light", wrong, code=2,
                         names=["--to-light must be AZ,EL in degrees", wrong])

    def test_like_a_backdrop(self):
        # The backdrop's camera looks west; what it sees at 17:00 is the sun ahead of it
        backdrop = with_exif(PHOTO, self.folder / "backdrop.jpg", time="2011:07:22 17:00:00",
                             offset="-04:00", place=(40.35, -74.65), heading=266.29)
        answer = self.done(self.capture, "--like", backdrop, "--json").json
        relative = (answer["target"]["azimuth_deg"] - answer["heading_deg"] + 180) % 360 - 180
        self.assertAlmostEqual(relative, 0, delta=0.02)  # EXIF holds 1e-4, the sun 0.0003 deg
        self.assertAlmostEqual(answer["target"]["elevation_deg"], 36.50, delta=0.02)
        self.assertEqual(answer["target"]["time"], "2011-07-22T17:00:00-04:00")

    def test_baseline_method(self):
        answer = self.done(self.capture, "--to", "17:00", "--method", "cabral2011", "--json").json
        other = self.done(self.capture, "--to", "17:00", "--json").json
        self.assertNotEqual(answer["mean_ratio"], other["mean_ratio"])
        self.refused(self.capture, "--to", "17:00", "--method", "cabral2011", "--turbidity", "3",
                     code=2, names=["cabral2011", "--turbidity"])

    def test_results_know_what_they_are(self):
        for extension in ("png", "jpg", "tif", "exr"):
            with self.subTest(extension):
                output = self.folder / f"x.{extension}"
                self.done(self.capture, "--to", "17:00", "-o", output)
                made = self.done("info", output, "--json").json
                self.assertTrue(made["made_by_relight"])
                self.assertEqual(made["made"]["photo"], "view_00.jpg")
                self.assertEqual(made["made"]["target"]["time"], "2011-07-22T17:00:00-04:00")
                self.assertIn("cells=32", made["made"]["options"])

    def test_info_of_a_capture(self):
        answer = self.done("info", self.capture, "--json").json
        self.assertEqual([v["name"] for v in answer["views"]], list(VIEWS))
        # Sun in the south, camera north
        self.assertEqual(answer["views"][0]["light"], "front light")
        self.assertEqual(answer["lacks"], [])
        self.assertIn("view_04", self.done("info", self.capture).out)


class OfOnePhoto(RelightCase):
    def setUp(self):
        super().setUp()
        self.tree = tree_png(self.folder / "tree.png")

    def test_a_png_with_alpha_needs_no_matte(self):
        outcome = self.done("tree.png", *FACTS, *COARSE, "--to", "17:00", cwd=self.folder)
        self.assertEqual(outcome.out, "tree_1700.png\n")
        self.assertIn("one photo alone", outcome.err)
        before, after = Png(self.tree), Png(self.folder / "tree_1700.png")
        self.assertEqual(after.samples[3::4], before.samples[3::4])  # Its alpha is kept
        # The sun goes to the left of the camera: the left half of the crown gets brighter than
        # the right one, which were alike at noon
        def mean(picture, columns):
            greens = [picture.at(x, y)[1] for y in range(12, 40) for x in columns
                      if picture.at(x, y)[3]]
            return sum(greens) / len(greens)
        left, right = range(14, 30), range(34, 50)
        self.assertAlmostEqual(mean(before, left) / mean(before, right), 1, delta=0.05)
        self.assertGreater(mean(after, left) / mean(after, right), 1.1)

    def test_only_directions_of_light(self):
        outcome = self.done("tree.png", "--lit-from", "180,60", "--to-light=-90,15", *COARSE,
                            cwd=self.folder)
        self.assertEqual(outcome.out, "tree_relit.png\n")

    def test_a_matte_by_name(self):
        shutil.copy(PHOTO, self.folder / "photo.jpg")
        matte = SAMPLE / "truth" / "view_00_alpha.png"
        outcome = self.done("photo.jpg", "--matte", matte, *COARSE, "--to", "17:00", "-o", "x.jpg",
                            cwd=self.folder)
        self.assertEqual(outcome.out, "x.jpg\n")
        self.assertEqual((self.folder / "x.jpg").read_bytes()[:3], b"\xff\xd8\xff")

    def test_magnetic_heading_is_corrected(self):
        facts = dict(time="2011:07:22 13:00:00", offset="-04:00", place=(40.35, -74.65),
                     focal_35mm=28)
        matte = SAMPLE / "truth" / "view_00_alpha.png"
        headings = {}
        for reference in "TM":
            photo = with_exif(PHOTO, self.folder / f"{reference}.jpg", heading=100,
                              reference=reference, **facts)
            outcome = self.done(photo, "--matte", matte, *COARSE, "--to", "17:00", "--json")
            headings[reference] = outcome.json["heading_deg"]
            self.assertEqual("magnetic" in outcome.err, reference == "M")
        self.assertAlmostEqual(headings["T"], 100, places=3)
        # The declination at Princeton in July 2011 is 12.7 deg west (WMM2010 at 40.35 N 74.65 W
        # by NOAA's calculator); WMM2010 is good to half a degree
        self.assertAlmostEqual(headings["M"], 100 - 12.7, delta=0.5)

    def test_place_known_only_by_zone_is_said(self):
        words = [w for w in FACTS if w not in ("--place", "40.35,-74.65")]
        words[words.index("-04:00")] = "America/New_York"
        outcome = self.done("tree.png", *words, *COARSE, "--to", "17:00", cwd=self.folder)
        self.assertIn("only known by the time zone America/New_York", outcome.err)
        self.assertIn("--place", outcome.err)
        outcome = self.done("tree.png", *FACTS, *COARSE, "--to", "17:00", cwd=self.folder)
        self.assertNotIn("only known", outcome.err)

    def test_matte_of_one_photo(self):
        shutil.copy(PHOTO, self.folder / "photo.jpg")
        outcome = self.done("matte", "photo.jpg", "--trimap", SAMPLE / "trimaps" / "view_00.png",
                            "--foreground", "f.exr", cwd=self.folder)
        self.assertEqual(outcome.out.split(), ["photo_matte.png", "f.exr"])
        matte = Png(self.folder / "photo_matte.png")
        trimap = Png(SAMPLE / "trimaps" / "view_00.png")
        self.assertEqual((matte.bits, matte.channels), (16, 1))
        for a, t in zip(matte.samples, trimap.samples):
            if t in (0, 255):
                self.assertEqual(a, 65535 if t else 0)
        self.assertEqual(set(Exr(self.folder / "f.exr").types.values()), {"half"})
        self.refused("matte", "photo.jpg", "--trimap", "photo_matte.png", "-o", "photo_matte.png",
                     cwd=self.folder, names=["photo_matte.png", "is an input"])


class Sky(RelightCase):
    WHERE = ("--place", "40.35,-74.65", "--taken", "2011-07-22T17:00-04:00")

    def test_figures(self):
        answer = self.done("sky", *self.WHERE, "--json").json
        self.assertAlmostEqual(answer["sun_azimuth_deg"], 266.29, delta=0.01)
        self.assertGreater(answer["sun_normal_lx_rgb"][0], answer["sun_normal_lx_rgb"][2])
        text = self.done("sky", *self.WHERE).out
        self.assertIn("266.28", text)

    def test_panorama(self):
        file = self.folder / "sky.exr"
        self.done("sky", *self.WHERE, "-o", file)
        exr = Exr(file)
        self.assertEqual((exr.width, exr.height), (1024, 512))
        self.assertEqual(set(exr.types.values()), {"float"})

    def test_night(self):
        night = ("--place", "40.35,-74.65", "--taken", "2011-07-22T23:00-04:00")
        self.assertIn("below the horizon", self.done("sky", *night).out)
        self.refused("sky", *night, "-o", self.folder / "x.exr",
                     names=["below the horizon", "it is up from 05:"])


if __name__ == "__main__":
    unittest.main()
