#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Times as photos and users give them: clocks that are changed, GPS against zones, photos of one
capture that are hours, days or streets apart; and how many views a large capture takes."""
import json
import shutil
import unittest

from relight_runner import (RelightCase, SAMPLE, VIEWS, made_capture, small_capture, with_exif)

PHOTO = SAMPLE / "photos" / "view_00.jpg"
HERE = (48.85, 2.35)


class ChangedClocks(RelightCase):
    def photo(self, **facts):
        return with_exif(PHOTO, self.folder / "oak.jpg", place=HERE, heading=10, **facts)

    def test_a_photo_from_the_hour_that_occurred_twice(self):
        photo = self.photo(time="2011:10:30 02:30:00")
        self.refused(photo, "--to", "12:00", "--zone", "Europe/Paris",
                     names=[photo, "2011-10-30T02:30:00 occurred twice in Europe/Paris",
                            "from 03:00 to 02:00", "2011-10-30T02:30:00+02:00 for the first",
                            "2011-10-30T02:30:00+01:00 for the second", "--taken"])

    def test_a_photo_from_the_hour_that_did_not_exist(self):
        photo = self.photo(time="2011:03:27 02:30:00")
        self.refused(photo, "--to", "12:00", "--zone", "Europe/Paris",
                     names=[photo, "2011-03-27T02:30:00 did not exist in Europe/Paris",
                            "from 02:00 to 03:00", "2011-03-27T03:30:00+02:00",
                            "2011-03-27T01:30:00+01:00"])

    def test_what_is_typed_is_wrong_usage(self):
        photo = self.photo(time="2011:07:22 13:00:00")
        for words in (["--to", "2011-03-27T02:30"],
                      ["--to", "12:00", "--taken", "2011-03-27T02:30"]):
            with self.subTest(words):
                self.refused(photo, *words, "--zone", "Europe/Paris", code=2,
                             names=[words[-2][2:], "did not exist", "2011-03-27T03:30:00+02:00"])
        self.refused("sky", "--place", "48.85,2.35", "--zone", "Europe/Paris", "--taken",
                     "2011-10-30T02:30", code=2, names=["occurred twice"])

    def test_what_capture_toml_says_names_the_file(self):
        capture = made_capture(self.folder / "maple")
        toml = capture / "capture.toml"
        toml.write_text("zone = \"America/New_York\"\n" + toml.read_text().replace(
            "view_00.jpg\"\n", "view_00.jpg\"\ntaken = \"2011-03-13T02:30\"\n"))
        self.refused(capture, "--to", "2011-07-22T16:00", names=[toml, "did not exist"])
        info = self.done("info", capture, "--json").json
        self.assertIn("did not exist", info["views"][0]["lacks"])
        self.assertTrue(any("did not exist" in note for note in info["notes"]))

    def test_gps_time_decides(self):
        photo = self.photo(time="2011:10:30 02:30:00", gps_time="2011:10:30 01:30:00")
        # At night, but at one moment
        self.refused(photo, "--to", "12:00", "--zone", "Europe/Paris",
                     names=["2011-10-30T02:30:00+01:00", "below the horizon"])

    def test_hours_of_a_day_are_never_ambiguous(self):
        capture = made_capture(self.folder / "maple")
        day = self.done("day", capture, "--zone", "America/New_York", "--dates", "2011-11-06",
                        "--hours", "0..8", "--every", "2h", "--json", "-o",
                        self.folder / "back").json
        self.assertEqual([f["name"] for f in day["frames"]], ["2011-11-06_0800"])
        hours = self.done("day", capture, "--zone", "America/New_York", "--dates", "2011-11-06",
                          "--hours", "1:30..8:30", "--every", "7h", "--json", "-o",
                          self.folder / "twice").json
        self.assertEqual([f["name"] for f in hours["left_out"]],
                         ["2011-11-06_0130", "2011-11-06_0130-0500"])
        self.refused("day", capture, "--zone", "Pacific/Apia", "--dates", "2011-12-30",
                     "--hours", "9..17",
                     names=["2011-12-30", "clocks were put forward"])  # A day without a clock


class GpsAgainstZones(RelightCase):
    def test_a_zone_that_gps_contradicts(self):
        photo = with_exif(PHOTO, self.folder / "oak.jpg", time="2011:07:22 13:00:00", place=HERE,
                          offset="+01:00", gps_time="2011:07:22 11:00:05", heading=10)
        notes = " ".join(self.done("info", photo, "--json").json["notes"])
        for part in ("oak.jpg", "2011-07-22T12:00:00+00:00", "2011-07-22T11:00:05+00:00",
                     "+02:00 would agree"):
            self.assertIn(part, notes)
        agreed = with_exif(PHOTO, self.folder / "elm.jpg", time="2011:07:22 13:00:00", place=HERE,
                           offset="+02:00", gps_time="2011:07:22 10:52:00", heading=10)
        self.assertEqual(self.done("info", agreed, "--json").json["notes"], [])

    def test_of_a_capture_it_is_said_by_init_and_info(self):
        photos = [with_exif(PHOTO, self.folder / f"p{i}.jpg", time=f"2011:07:22 13:0{i}:00",
                            place=HERE, gps_time=f"2011:07:22 17:0{i}:00") for i in range(5)]
        capture = self.folder / "c"
        self.assertNotIn("would agree", self.done("init", capture, *photos).err)
        toml = capture / "capture.toml"
        toml.write_text("zone = \"Europe/Paris\"\n" + toml.read_text())
        self.assertIn("-04:00 would agree", self.done("init", capture, *photos).err)
        notes = self.done("info", capture, "--json").json["notes"]
        self.assertEqual(len([n for n in notes if "would agree" in n]), 3)
        self.assertTrue(any("2 more photos" in note for note in notes), notes)


class PhotosApart(RelightCase):
    def capture(self, changed=None, **facts):
        photos = []
        for i, view in enumerate(VIEWS):
            said = {"time": f"2011:07:22 13:0{i}:00", "offset": "-04:00",
                    "place": (40.35, -74.65)}
            photos.append(with_exif(SAMPLE / "photos" / f"{view}.jpg",
                                    self.folder / f"{view}.jpg",
                                    **{**said, **(facts if view == changed else {})}))
        outcome = self.done("init", self.folder / "c", *photos)
        info = self.done("info", self.folder / "c", "--json").json
        return outcome.err, " ".join(info["notes"])

    def test_photos_of_one_tree_in_one_light(self):
        err, notes = self.capture()
        self.assertEqual(notes, "")
        self.assertNotIn("apart", err)

    def test_hours_apart(self):
        for text in self.capture("view_08", time="2011:07:22 16:30:00"):
            for part in ("from 13:00 (view_00) to 16:30 (view_08), 3 h 30 min apart",
                         "the sun went", "from the south, 70° high", "from the west, 42° high"):
                self.assertIn(part, text)

    def test_another_day(self):
        for text in self.capture("view_04", time="2011:07:29 13:00:00"):
            self.assertIn("view_04 was taken on another day, 2011-07-29", text)
            self.assertNotIn("the sun went", text)

    def test_another_street(self):
        for text in self.capture("view_04", place=(40.36, -74.65)):
            self.assertIn("view_04 seems to show another tree", text)
            self.assertIn("1112 m", text)

    def test_no_time_is_no_error(self):
        err, notes = self.capture("view_04", time=None, offset=None)
        self.assertIn("1 photos have no capture time", err)
        self.assertEqual(notes, "")

    def test_the_plan_of_an_hour_says_it_as_the_camera_sees_it(self):
        capture = made_capture(self.folder / "maple")
        with_exif(SAMPLE / "photos" / "view_08.jpg", capture / "photos" / "view_08.jpg",
                  time="2011:07:22 17:00:00", offset="-04:00", place=(40.35, -74.65))
        err = self.done(capture, "--view", "view_00", "--to", "16:00").err
        self.assertIn("4 h 0 min apart", err)
        self.assertIn("from behind, 70° high", err)
        self.assertIn("from the left, 37° high", err)


class OtherCameras(RelightCase):
    def test_a_camera_that_looks_away_is_named(self):
        capture = self.folder / "c"
        self.done("init", capture, SAMPLE / "photos")
        model = self.folder / "model"
        shutil.copytree(SAMPLE / "cameras", model)
        self.assertNotIn("another tree",
                         self.done("cameras", capture, "--import", "colmap", model).err)
        lines = (model / "images.txt").read_text().splitlines()
        for i, line in enumerate(lines):
            words = line.split()
            if words and words[-1].startswith("view_05") and not line.startswith("#"):
                # Turned by half a turn about its own y axis: q_y * q, and t alike
                w, x, y, z, tx, ty, tz = map(float, words[1:8])
                words[1:8] = map(repr, (-y, z, w, -x, -tx, ty, -tz))
                lines[i] = " ".join(words)
        (model / "images.txt").write_text("\n".join(lines) + "\n")
        said = self.done("cameras", capture, "--import", "colmap", model).err
        self.assertIn("view_05 seems to show another tree", said)
        notes = self.done("info", capture, "--json").json["notes"]
        self.assertEqual(len(notes), 1, notes)


class ManyViews(RelightCase):
    def test_mattes_and_volume_are_made_from_some(self):
        capture = self.folder / "c"
        self.done("init", capture, SAMPLE / "photos")
        self.done("cameras", capture, "--import", "colmap", SAMPLE / "cameras")
        shutil.copytree(SAMPLE / "trimaps", self.folder / "trimaps")
        some = ["--most-views", "4", "--cells", "24", "--iterations", "1"]
        (capture / "trimaps").mkdir(exist_ok=True)
        for trimap in (self.folder / "trimaps").iterdir():
            shutil.copy(trimap, capture / "trimaps")
        outcome = self.done(capture, "--view", "view_01", "--to", "16:00", *some)
        self.assertIn("made from 4 of 12 views", outcome.err)
        made = sorted(f.stem for f in (capture / "mattes").glob("*.png"))
        self.assertEqual(made, ["view_01", "view_02", "view_05", "view_08", "view_11"])
        # Another view gets its own, and the volume stays as it is
        volume = (capture / "volume.vdb").read_bytes()
        outcome = self.done(capture, "--view", "view_03", "--to", "16:00", *some, "--json")
        self.assertEqual(outcome.json["stages"], ["mattes", "relight"])
        self.assertEqual((capture / "volume.vdb").read_bytes(), volume)
        self.assertTrue((capture / "mattes" / "view_03.png").exists())
        self.assertEqual(json.loads(self.done("volume", capture, *some, "--json").out)["views"], 4)


if __name__ == "__main__":
    unittest.main()
