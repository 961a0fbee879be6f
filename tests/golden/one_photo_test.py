# SPDX-License-Identifier: Apache-2.0
"""`relight cameras PHOTO`: one photo's camera from horizon, heading and focal length, or from
points on Earth; what it writes and refuses, and that `relight hour` uses it."""
import math
import shutil
import unittest

from relight_runner import Png, SAMPLE, SHARED, RelightCase, tree_png, with_exif, write_png

MAPLE = SHARED / "data" / "maple"
PLACE = (40.35, -74.65)


class TrueCamera:
    """A pinhole of a COLMAP text model, by the format's own definition."""

    def __init__(self, model, name):
        numbers = (model / "cameras.txt").read_text().split("\n")[1].split()
        self.width, self.height = int(numbers[2]), int(numbers[3])
        self.f, self.cx, self.cy = float(numbers[4]), float(numbers[6]), float(numbers[7])
        line = next(li for li in (model / "images.txt").read_text().split("\n") if name in li)
        w, x, y, z, *self.t = map(float, line.split()[1:8])
        self.r = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                  [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                  [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]

    def turned(self, v):
        return [sum(row[k] * v[k] for k in range(3)) for row in self.r]

    def pixel(self, p):
        x, y, z = (a + b for a, b in zip(self.turned(p), self.t))
        return self.f * x / z + self.cx, self.f * y / z + self.cy

    def position(self):
        return [-sum(self.r[j][i] * self.t[j] for j in range(3)) for i in range(3)]

    def heading(self):
        return math.degrees(math.atan2(self.r[2][0], self.r[2][1])) % 360

    def horizon(self, column):
        up = [row[2] for row in self.r]
        return self.cy - (up[0] * (column - self.cx) + up[2] * self.f) / up[1]

    def focal_35mm(self):
        return self.f * math.hypot(36, 24) / math.hypot(self.width, self.height)


def sun_direction(azimuth_deg, elevation_deg):
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    return [math.cos(e) * math.sin(a), math.cos(e) * math.cos(a), math.sin(e)]


def apart_deg(a, b):
    dot = sum(x * y for x, y in zip(a, b))
    return math.degrees(math.acos(min(1, dot / math.hypot(*a) / math.hypot(*b))))


class OnePhoto(RelightCase):
    def setUp(self):
        super().setUp()
        self.photo = with_exif(SAMPLE / "photos" / "view_00.jpg", self.folder / "oak.jpg",
                               time="2011:07:22 13:00:00", offset="-04:00", place=PLACE,
                               heading=200, focal_35mm=35)

    def bare(self):
        return with_exif(SAMPLE / "photos" / "view_00.jpg", self.folder / "bare.jpg")

    def test_writes_cameras_and_overlay_beside_the_photo(self):
        outcome = self.done("cameras", self.photo)
        folder = self.folder / "oak_camera"
        self.assertEqual(outcome.out, f"{folder}\n")
        for said in ("35 mm", "EXIF", "taken as level", "heading 200.0 deg", "1.60 m",
                     "standing person", "70° high"):
            self.assertIn(said, outcome.err)
        self.assertEqual(sorted(f.name for f in folder.iterdir()),
                         ["cameras.txt", "images.txt", "overlay.jpg", "points3D.txt"])
        self.assertEqual((folder / "overlay.jpg").read_bytes()[:2], b"\xff\xd8")
        self.assertNoPartialFile()
        again = {f: f.read_bytes() for f in folder.iterdir()}
        self.done("cameras", self.photo)
        self.assertEqual(again, {f: f.read_bytes() for f in folder.iterdir()})

    def test_what_is_not_known_is_assumed_and_said(self):
        answer = self.done("cameras", self.bare(), "--heading", "SW", "--json").json
        self.assertEqual(answer["focal_35mm_mm"], 26)
        self.assertIn("4:3 phone", answer["focal_from"])
        self.assertAlmostEqual(answer["heading_deg"], 225, places=6)
        self.assertIn("level", answer["tilt_from"])
        self.assertEqual(answer["camera_height_m"], 1.6)
        self.assertNotIn("sun", answer)
        self.assertIn("the sun is not drawn", " ".join(answer["notes"]))

    def test_options_win_over_exif(self):
        answer = self.done("cameras", self.photo, "--focal-35mm", 50, "--heading", 10, "--horizon",
                           350, "--camera-height", 2.5, "--place", "48.8,2.3", "--taken",
                           "2011-07-22T10:00", "--zone", "Europe/Paris", "--json", "-o",
                           self.folder / "here").json
        self.assertEqual((answer["focal_35mm_mm"], answer["camera_height_m"]), (50, 2.5))
        self.assertAlmostEqual(answer["heading_deg"], 10, places=6)
        self.assertGreater(answer["pitch_deg"], 1)
        self.assertEqual(answer["origin"], [48.8, 2.3])
        self.assertIn("2011-07-22T10:00", answer["sun"]["time"])
        self.assertTrue((self.folder / "here" / "overlay.jpg").exists())

    def test_refusals(self):
        self.refused("cameras", self.folder / "none.jpg", names=["none.jpg", "not there"])
        self.refused("cameras", self.bare(), names=["no heading", "--heading SW", "--point"])
        for words, names in ((("--horizon", "12,13"), ["--horizon", "12,13", "X1,Y1,X2,Y2"]),
                             (("--horizon", "high"), ["--horizon", "high"]),
                             (("--focal-35mm", 0.1), ["--focal-35mm", "0.1"]),
                             (("--camera-height", -3), ["--camera-height", "-3"]),
                             (("--heading", "up"), ["heading", "up"]),
                             (("--foot", "20,1"), ["--foot", "20,1", "horizon"]),
                             (("--point", "7,8"), ["--point", "7,8", "X,Y=LAT,LON"]),
                             (("--point", "7,8=99,8"), ["place", "99,8"]),
                             (("--point", "9,9=1,2", "--heading", "N"), ["--point", "--heading"])):
            self.refused("cameras", self.photo, *words, code=2, names=names)
        self.refused("cameras", self.photo, "--point", "9,9=1,2", names=["oak.jpg", "four"])
        self.refused("cameras", write_png(self.folder / "no.txt.png", 4, 4, 3,
                                          lambda x, y: (1, 2, 3)), "--heading", "N", "-o",
                     self.photo, names=["oak.jpg"])
        photo = self.folder / "overlay.jpg"
        shutil.copy(self.photo, photo)
        self.refused("cameras", photo, "-o", self.folder, names=["overlay.jpg", "photo itself"])
        self.refused("cameras", SAMPLE, "--foot", "9,9", code=2, names=["one photo", "capture"])

    def test_a_captures_photo_is_said_to_be_one(self):
        outcome = self.done("cameras", SAMPLE / "photos" / "view_00.jpg", "-o",
                            self.folder / "out")
        self.assertIn("is a capture", outcome.err)
        self.refused("cameras", self.photo, "-o", SAMPLE / "cameras",
                     names=["not written over", "-o"])


class HourUsesIt(RelightCase):
    def setUp(self):
        super().setUp()
        self.photo = tree_png(self.folder / "elm.png", 96)
        self.words = ("hour", self.photo, "--place", "48.8,2.3", "--taken",
                      "2011-07-22T13:00+02:00", "--to", "17:00", "--cells", 24, "--json", "-o",
                      self.folder / "out.png")

    def test_heading_tilt_and_distance_come_from_the_camera(self):
        self.refused(*self.words, names=["no heading"])
        found = self.done("cameras", self.photo, "--heading", 120, "--horizon", "0,72,96,71",
                          "--camera-height", 1.7, "--json").json
        answer = self.done(*self.words).json
        self.assertAlmostEqual(answer["heading_deg"], 120, places=3)
        notes = " ".join(answer["notes"])
        self.assertIn("elm_camera", notes)
        self.assertIn("1.7 m above", notes)
        self.assertNotIn("held level", notes)
        # The stem ends at 0.9 of the height, some 15 px below the horizon's 72
        expected = 1.7 * found["focal_px"] / 15
        distance = float(notes.split(" m high at ")[1].split(" m")[0])
        self.assertAlmostEqual(distance, expected, delta=0.15 * expected)

    def test_options_win_and_a_camera_without_ground_is_left(self):
        self.done("cameras", self.photo, "--heading", 120, "--horizon", 72)
        answer = self.done(*self.words, "--heading", 30, "--distance", 12).json
        self.assertEqual(answer["heading_deg"], 30)
        notes = " ".join(answer["notes"])
        self.assertIn("at 12 m", notes)
        self.assertIn("--heading turns", notes)
        self.done("cameras", self.photo, "--heading", 120, "--horizon", 95)
        notes = " ".join(self.done(*self.words).json["notes"])
        self.assertIn("is not used", notes)
        self.assertIn("held level", notes)

    def test_another_pictures_camera_is_refused(self):
        self.done("cameras", self.photo, "--heading", 120)
        write_png(self.photo, 96, 60, 4, lambda x, y: (90, 120, 60, 255 if x < 50 else 0))
        self.refused(*self.words, names=["elm_camera", "96 x 60", "relight cameras"])


@unittest.skipUnless(MAPLE.exists(), "the tree with known truth is not there")
class AgainstTheTruth(RelightCase):
    def setUp(self):
        super().setUp()
        self.photo = self.folder / "maple.jpg"
        shutil.copy(MAPLE / "photos" / "view_00.jpg", self.photo)
        self.true = TrueCamera(MAPLE / "sparse", "view_00")

    def sun_error_deg(self, answer):
        true_sun = self.true.turned(sun_direction(176.55368841574963, 69.86345671579345))
        return apart_deg(answer["sun"]["in_camera"], true_sun)

    def test_the_sun_from_horizon_heading_and_focal_length(self):
        answer = self.done(
            "cameras", self.photo, "--horizon",
            f"0,{self.true.horizon(0)},480,{self.true.horizon(480)}", "--heading",
            f"{self.true.heading():.3f}", "--focal-35mm", self.true.focal_35mm(), "--json").json
        print(f"sun in camera axes: {self.sun_error_deg(answer):.4f} deg off")
        self.assertLess(self.sun_error_deg(answer), 0.5)
        # By EXIF's own heading and focal length, whose 35 mm equivalent is 6 % long
        answer = self.done("cameras", self.photo, "--horizon", self.true.horizon(240),
                           "--json").json
        print(f"with EXIF's focal length: {self.sun_error_deg(answer):.4f} deg off")
        self.assertLess(self.sun_error_deg(answer), 0.5)

    def places(self, points):
        """--point options of ENU metres around PLACE, on WGS84 near it."""
        a, e2 = 6378137.0, 0.00669437999014
        s = math.sin(math.radians(PLACE[0]))
        north_m = math.radians(1) * a * (1 - e2) / (1 - e2 * s * s) ** 1.5
        east_m = math.radians(1) * a / math.sqrt(1 - e2 * s * s) * math.cos(
            math.radians(PLACE[0]))
        words = []
        for x, y, z in points:
            u, v = self.true.pixel((x, y, z))
            height = f",{z}" if z else ""
            words += ["--point", f"{u:.3f},{v:.3f}={PLACE[0] + y / north_m:.9f},"
                                 f"{PLACE[1] + x / east_m:.9f}{height}"]
        return words

    def check_pose(self, points, *words):
        answer = self.done("cameras", self.photo, *self.places(points), *words, "--json").json
        position = [p - q for p, q in zip(self.true.position(), (*points[0][:2], 0))]
        error_m = math.dist(answer["position_m"], position)
        print(f"{len(points)} points: place {error_m:.3f} m, sun {self.sun_error_deg(answer):.4f} "
              f"deg off, residuals up to {max(answer['point_residual_px']):.3f} px")
        self.assertLess(error_m, 0.1)
        self.assertLess(self.sun_error_deg(answer), 0.1)
        self.assertLess(max(answer["point_residual_px"]), 0.05)
        return answer

    def test_points_give_the_pose_back(self):
        focal = ("--focal-35mm", self.true.focal_35mm())
        self.check_pose([(0, 0, 0), (-3, -2, 0), (3.5, 4, 0), (-4, 9, 0)], *focal)
        self.check_pose([(0, 0, 0), (-3, -2, 1), (3.5, 4, 5), (-4, 9, 0), (2, 1, 7)], *focal)

    def test_residuals_are_printed(self):
        words = self.places([(0, 0, 0), (-3, -2, 0), (3.5, 4, 0), (-4, 9, 0), (3, -3, 0)])
        at = words[5].split("=")
        u, v = at[0].split(",")
        words[5] = f"{float(u) + 60},{v}={at[1]}"
        outcome = self.done("cameras", self.photo, *words, "--focal-35mm",
                            self.true.focal_35mm())
        for point in range(1, 6):
            self.assertIn(f"point {point}: ", outcome.err)
        self.assertIn("look at its pixel", outcome.err)

    def test_points_in_a_line_are_refused(self):
        self.refused("cameras", self.photo,
                     *self.places([(-3, 0, 0), (-1, 2, 0), (1, 4, 0), (3, 6, 0)]),
                     names=["maple.jpg", "one line"])


class SkyBelowTheAssumedHorizon(RelightCase):
    """A tree 8 m high with eyes at 1.6 m has its horizon a fifth above its foot: here it is at
    its foot, so that a strip of sky lies where a level camera has ground."""
    WIDTH, HEIGHT, HORIZON = 240, 180, 150

    def is_tree(self, x, y):
        return ((x - 120) ** 2 + (y - 70) ** 2 < 50 ** 2 or
                (abs(x - 120) < 6 and 70 < y < self.HORIZON + 4))

    def color(self, x, y):
        leaf = 60 + (x * 7919 + y * 104729) % 97
        if self.is_tree(x, y):
            return leaf // 2, leaf * 2 // 3, leaf // 3
        if y >= self.HORIZON:
            return leaf, 20 + leaf, leaf // 2
        return 90 + y // 2, 140 + y // 2, 220

    def test_takes_no_shadow(self):
        photo = write_png(self.folder / "meadow.png", self.WIDTH, self.HEIGHT, 3, self.color)
        matte = write_png(self.folder / "matte.png", self.WIDTH, self.HEIGHT, 1,
                          lambda x, y: (255 if self.is_tree(x, y) else 0,))
        given = (photo, "--matte", matte, "--lit-from", "90,40", "--to-light", "300,25", "--whole")
        self.done("hour", *given, "-o", self.folder / "moved.png")
        self.done("hour", *given, "--keep-shadow", "-o", self.folder / "kept.png")
        moved, kept = Png(self.folder / "moved.png"), Png(self.folder / "kept.png")
        sky = ground = 0
        for y in range(self.HEIGHT):
            for x in range(self.WIDTH):
                if self.is_tree(x, y):
                    continue
                apart = moved.at(x, y) != kept.at(x, y)
                if y < self.HORIZON - 2:
                    sky += apart
                elif y > self.HORIZON + 4:
                    ground += apart
        self.assertEqual(sky, 0)
        self.assertGreater(ground, 1000)


if __name__ == "__main__":
    unittest.main()
