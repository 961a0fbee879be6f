#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`relight cameras` from outside: COLMAP on real photographs ($RELIGHT_SHARED/data/photos,
skipped when they or COLMAP are not there), import, export, where on Earth, and what is said
when something is missing."""
import html
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import time
import unittest
import urllib.parse

from one_photo_test import TrueCamera, sun_direction
from relight_runner import PROGRAM, SAMPLE, SHARED, RelightCase, relight, with_exif

PHOTOS = SHARED / "data" / "photos"
HAS_COLMAP = shutil.which("colmap") is not None

# Smaller and fewer than by default, so that a run takes a minute: the figures hold all the same
QUICK = ("--features", "2000", "--longest", "1000")


def enu(place, origin):
    """East, north, up [m] of a place (WGS84) seen from another, by way of the Earth's centre."""
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)

    def ecef(lat, lon, h):
        lat, lon = math.radians(lat), math.radians(lon)
        n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
        return ((n + h) * math.cos(lat) * math.cos(lon),
                (n + h) * math.cos(lat) * math.sin(lon), (n * (1 - e2) + h) * math.sin(lat))
    x, y, z = (p - o for p, o in zip(ecef(*place), ecef(*origin)))
    lat, lon = math.radians(origin[0]), math.radians(origin[1])
    east = -math.sin(lon) * x + math.cos(lon) * y
    toward = math.cos(lon) * x + math.sin(lon) * y
    return (east, -math.sin(lat) * toward + math.cos(lat) * z,
            math.cos(lat) * toward + math.sin(lat) * z)


def positions(images_txt):
    """Camera centres of a COLMAP text model, by view."""
    found = {}
    lines = [line for line in images_txt.read_text().splitlines() if not line.startswith("#")]
    for line in lines[::2]:
        words = line.split()
        w, x, y, z = map(float, words[1:5])
        t = list(map(float, words[5:8]))
        rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
        view = words[9].rsplit("/", 1)[-1].rsplit(".", 1)[0]
        found[view] = [-sum(rotation[k][i] * t[k] for k in range(3)) for i in range(3)]
    return found


def without_exif(jpeg):
    """A JPEG as a messenger leaves it: without its APP1 segments."""
    out, at = jpeg[:2], 2
    while jpeg[at + 1] != 0xDA:
        end = at + 2 + int.from_bytes(jpeg[at + 2:at + 4], "big")
        out += b"" if jpeg[at + 1] == 0xE1 else jpeg[at:end]
        at = end
    return out + jpeg[at:]


# Stands in for COLMAP where another version is wanted than the one installed: knows the options
# of its version alone and refuses others, as COLMAP does; says what COLMAP says, and finds
# MODEL's cameras.
STAND_IN = """#!/usr/bin/python3
import json, pathlib, shutil, sys
GROUPS, REGISTERING, FOLDER, MODEL = (__GROUPS__)
step, words = sys.argv[1], sys.argv[2:]
of_step = dict(
    feature_extractor="image_list_path ImageReader.camera_model ImageReader.single_camera "
        "ImageReader.camera_params ImageReader.mask_path SiftExtraction.max_num_features "
        + GROUPS["extraction"] + ".use_gpu " + GROUPS["size"] + ".max_image_size",
    exhaustive_matcher="ExhaustiveMatching.block_size " + GROUPS["matching"] + ".use_gpu",
    sequential_matcher="SequentialMatching.overlap " + GROUPS["matching"] + ".use_gpu",
    mapper="output_path Mapper.ba_refine_focal_length")[step].split()
of_step += ["database_path", "image_path"]
if words == ["--help"]:
    sys.exit("\\n".join("  --" + name + " arg (=0)" for name in of_step))
given = dict(zip((w[2:] for w in words[::2]), words[1::2]))
for name in given:
    if name not in of_step:
        sys.exit("ERROR: Failed to parse options - unrecognised option '--" + name + "'.")
with open(FOLDER + "/calls", "a") as calls:
    calls.write(json.dumps([step, given]) + "\\n")
log = "I20261127 12:00:00.000000   123 source.cc:77] "
if step == "feature_extractor":
    photos = open(given["image_list_path"]).read().split()
    for i, photo in enumerate(photos):
        assert (pathlib.Path(given["image_path"]) / photo).is_file()
        print(log + f"Processed file [{i + 1}/{len(photos)}]", flush=True)
elif step == "mapper":
    print(log + REGISTERING, flush=True)
    shutil.copytree(MODEL, given["output_path"] + "/0")
else:
    print(log + "Matching block [1/1, 1/1]", flush=True)
"""
SIFT = {"extraction": "SiftExtraction", "size": "SiftExtraction", "matching": "SiftMatching"}
FEATURE = {"extraction": "FeatureExtraction", "size": "FeatureExtraction",
           "matching": "FeatureMatching"}


@unittest.skipUnless(HAS_COLMAP, "COLMAP is not installed")
@unittest.skipUnless(PHOTOS.is_dir(), f"{PHOTOS} is not there; set RELIGHT_SHARED")
class Colmap(RelightCase):
    def test_a_park_seen_by_a_drone_gets_its_metres_and_its_north(self):
        park = self.folder / "park"
        self.done("init", park, PHOTOS / "brighton_park" / "images")
        done = self.done("cameras", park, *QUICK, "--json", timeout=1500)
        result = done.json
        self.assertEqual(len(result["views"]), 18, done.err)
        self.assertIn("about", done.err)  # What it does and how long, before it starts
        self.assertIn("GPS", result["north"]["from"])

        # The published frame: east, north, up about 46.842 N 91.994 W, heights from take-off
        truth = positions(PHOTOS / "brighton_park" / "sparse_enu" / "images.txt")
        origin = result["origin"]
        shift = enu(origin, (46.842, -91.994, origin[2]))
        off, turns = [], []
        heights = [v["position_m"][2] - truth[v["view"]][2] for v in result["views"]]
        mean = sum(heights) / len(heights)  # Of the ground here to take-off
        for view, height in zip(result["views"], heights):
            east, north, _ = (p + s for p, s in zip(view["position_m"], shift))
            off.append(math.dist((east, north, height - mean), (*truth[view["view"]][:2], 0)))
        self.assertLess(max(off), 1.0)

        # North: the azimuth from the first camera to the farthest, here less there
        first = result["views"][0]
        for view in result["views"]:
            here = [b - a for a, b in zip(first["position_m"], view["position_m"])]
            there = [b - a for a, b in zip(truth[first["view"]], truth[view["view"]])]
            if math.hypot(*there[:2]) > 50:
                turn = math.atan2(*here[:2]) - math.atan2(*there[:2])
                turns.append((math.degrees(turn) + 180) % 360 - 180)
        turn = sum(turns) / len(turns)
        sky = self.done("sky", "--place", "46.842,-91.993", "--taken",
                        "2016-06-23T16:33-05:00", "--json").json
        for shadow in (77.6, 80.8):  # Measured in that frame
            apart = sky["sun_azimuth_deg"] - 180 - (shadow + turn)
            self.assertLess(abs(apart), 4.0)
        print(f"brighton_park: at most {max(off):.2f} m off, north {turn:+.2f} deg",
              flush=True)

    def test_fern_is_registered_whole(self):
        fern = self.folder / "fern"
        self.done("init", fern, PHOTOS / "fern" / "images")
        # Its photos were taken within half a metre, indoors: GPS tells no scale
        done = self.done("cameras", fern, *QUICK, "--scale-from", "IMG_4026", "IMG_4045", "0.5",
                         "--json", timeout=1500)
        self.assertEqual(len(done.json["views"]), 20, done.err)
        self.assertIn("compass", done.json["north"]["from"])

    def test_stopping_leaves_nothing(self):
        park = self.folder / "park"
        self.done("init", park, PHOTOS / "brighton_park" / "images")
        process = subprocess.Popen([PROGRAM, "cameras", str(park)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(4)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
        self.assertEqual(process.returncode, 130)
        self.assertFalse((park / "cameras").exists())
        running = subprocess.run(["pgrep", "-f", str(park)], capture_output=True, text=True)
        self.assertEqual(running.stdout, "", "COLMAP goes on after its stop")


class Cameras(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = self.folder / "maple"
        self.done("init", self.capture, SAMPLE / "photos")
        self.model = SAMPLE / "cameras"

    def test_without_colmap_it_says_how_to_get_it(self):
        self.refused("cameras", self.capture, env={"PATH": str(self.folder)},
                     names=["COLMAP is not installed", "apt install colmap", "--import"])

    def test_versions_of_colmap_that_call_options_otherwise(self):
        versions = {
            "3.8 to 3.11": (SIFT, "Registering image #5 (12)"),
            "3.12": ({**FEATURE, "size": "SiftExtraction"},
                     "Registering image #5 (num_reg_frames=12)"),
            "4": (FEATURE, "Registering image #5 (num_reg_frames=12)"),
        }
        (self.capture / "mattes").mkdir()  # What moves is not looked at
        shutil.copy(SAMPLE / "trimaps" / "view_00.png", self.capture / "mattes")
        for version, (groups, registering) in versions.items():
            with self.subTest(version):
                programs = self.folder / version
                programs.mkdir()
                said = f"{groups}, {registering!r}, {str(programs)!r}, {str(self.model)!r}"
                (programs / "colmap").write_text(STAND_IN.replace("__GROUPS__", said))
                (programs / "colmap").chmod(0o755)
                done = self.done("cameras", self.capture, "--force", "--json",
                                 env={"PATH": str(programs)})
                self.assertEqual(len(done.json["views"]), 12, done.err)
                calls = [json.loads(line) for line in (programs / "calls").read_text().split("\n")
                         if line]
                self.assertEqual([step for step, _ in calls],
                                 ["feature_extractor", "exhaustive_matcher", "mapper"])
                for step, given in calls[:2]:
                    gpu = [value for name, value in given.items() if name.endswith(".use_gpu")]
                    self.assertEqual(gpu, ["0"], step)
                masks = pathlib.Path(calls[0][1]["ImageReader.mask_path"])
                self.assertEqual([m.name for m in masks.iterdir()], ["view_00.jpg.png"])

    def test_a_model_in_its_own_frame_is_put_on_the_earth(self):
        # The same cameras, turned about z by 40 degrees and 3 times as large
        before = self.done("cameras", self.capture, "--import", self.model, "--json").json
        self.assertTrue(before["kept_frame"])
        self.done("cameras", self.capture, "--export", "transforms", self.folder / "t.json")
        scene = json.loads((self.folder / "t.json").read_text())
        c, s = math.cos(math.radians(40)), math.sin(math.radians(40))
        turn = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        for frame in scene["frames"]:
            m = frame["transform_matrix"]
            turned = [[sum(turn[i][k] * m[k][j] for k in range(3)) for j in range(4)]
                      for i in range(3)]
            for row in turned:
                row[3] *= 3
            frame["transform_matrix"] = turned + [[0, 0, 0, 1]]
        (self.folder / "t.json").write_text(json.dumps(scene))
        done = self.done("cameras", self.capture, "--import", self.folder / "t.json", "--json")
        after = done.json
        self.assertFalse(after["kept_frame"])
        headings = {v["view"]: v["heading_deg"] for v in before["views"]}
        for view in after["views"]:
            apart = (view["heading_deg"] - headings[view["view"]] + 180) % 360 - 180
            self.assertLess(abs(apart), 0.2)  # EXIF has places to some centimetres
        ends = [[v["position_m"] for v in result["views"]][::len(result["views"]) - 1]
                for result in (before, after)]
        self.assertAlmostEqual(math.dist(*ends[1]) / math.dist(*ends[0]), 1, delta=0.01)
        self.assertIn("sure to", done.err)

        # A distance that the user gives is joined in, and outweighs GPS
        names = [after["views"][0]["view"], after["views"][-1]["view"]]
        longer = self.done("cameras", self.capture, "--import", self.folder / "t.json",
                           "--scale-from", *names, 1.02 * math.dist(*ends[0]), "--json").json
        self.assertIn("--scale-from", longer["scale"]["from"])
        self.refused("cameras", self.capture, "--import", self.folder / "t.json",
                     "--heading", "nobody=120", names=["nobody"])

    def test_what_is_said_of_the_frame_turns_the_cameras_that_are_there(self):
        # Photos that say nothing, so that the model's own frame is taken
        for photo in (SAMPLE / "photos").iterdir():
            (self.folder / photo.name).write_bytes(without_exif(photo.read_bytes()))
        bare = self.folder / "bare"
        self.done("init", bare, *sorted(self.folder.glob("view_*.jpg")))
        before = self.done("cameras", bare, "--import", self.model, "--json").json
        view = before["views"][0]["view"]
        heading = before["views"][0]["heading_deg"]
        no_colmap = {"PATH": str(self.folder)}
        self.refused("cameras", bare, env=no_colmap,
                     names=["cameras already", "import of", "--heading", "--force"])

        # North: all headings by the same angle, no distance changes, the origin stays
        done = self.done("cameras", bare, "--heading", f"{view}={(heading + 30) % 360:.6f}",
                         "--json", env=no_colmap)
        after = done.json
        self.assertIn("--force", done.err)
        self.assertEqual(after["north"]["from"], "--heading")
        self.assertIn("had", after["scale"]["from"])
        self.assertIn("import of", after["made_by"])
        c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
        for old, new in zip(before["views"], after["views"]):
            apart = (new["heading_deg"] - old["heading_deg"] - 30 + 180) % 360 - 180
            self.assertLess(abs(apart), 0.01)
            x, y, z = old["position_m"]
            self.assertLess(math.dist(new["position_m"], (c * x + s * y, c * y - s * x, z)), 1e-2)

        # Scale alone: north stays as it was told before
        ends = [before["views"][i] for i in (0, -1)]
        length = math.dist(*(v["position_m"] for v in ends))
        larger = self.done("cameras", bare, "--scale-from", *(v["view"] for v in ends),
                           2 * length, "--report", "--json", env=no_colmap).json
        self.assertEqual(larger["north"]["from"], "--heading")
        self.assertIn("--scale-from", larger["scale"]["from"])
        for old, new in zip(after["views"], larger["views"]):
            self.assertLess(math.dist(new["position_m"], [2 * p for p in old["position_m"]]), 2e-2)
        self.assertIn("--scale-from", (bare / "cameras" / "report.html").read_text())

        # What is said of COLMAP is meant for it
        self.refused("cameras", bare, "--heading", "10", "--matching", "exhaustive",
                     env=no_colmap, names=["COLMAP is not installed"])
        self.refused("cameras", bare, "--force", env=no_colmap,
                     names=["COLMAP is not installed"])

    def test_the_report_shows_every_photo_the_map_and_the_sun(self):
        # One photo without a camera, one with a compass that is wrong, one from no zone
        photos = self.folder / "photos"
        photos.mkdir()
        for i, photo in enumerate(sorted((SAMPLE / "photos").iterdir())):
            if i not in (4, 5, 7):
                shutil.copy(photo, photos)
        headings = {v["view"]: v["heading_deg"] for v in self.done(
            "cameras", self.capture, "--import", self.model, "--json").json["views"]}
        said = {"time": "2011:07:22 13:01:20", "place": (40.35, -74.65)}
        with_exif(SAMPLE / "photos" / "view_04.jpg", photos / "view_04.jpg", offset="-04:00",
                  heading=(headings["view_04"] + 100) % 360, **{**said, "place": None})
        with_exif(SAMPLE / "photos" / "view_05.jpg", photos / "view_05.jpg", **{
            **said, "time": "2011:07:22 13:01:40", "place": None})
        with_exif(SAMPLE / "photos" / "view_07.jpg", photos / "a & <b> 50%.jpg",
                  offset="-04:00", heading=123, **said)
        capture = self.folder / "shown"
        self.done("init", capture, photos)
        done = self.done("cameras", capture, "--import", self.model, "--matching-only",
                         "--report", "--json")
        report = pathlib.Path(done.json["report"])
        page = report.read_text()
        for outside in ("http", "src=\"/", "<link", "@import"):
            self.assertNotIn(outside, page)

        # The sheet: name, time, heading and fate of all, each a way to its overlay
        sheet = page[page.index("Contact sheet"):page.index("From above")]
        cells = {}
        for tag, href, rest in re.findall(
                r'<(a|div) class="thumb"(?: href="#([^"]*)")?>(.*?)</\1>', sheet, re.S):
            lines = [html.unescape(t) for t in re.findall(r">([^<>]+)</(?:b|span)>", rest)]
            cells[lines[0]] = (urllib.parse.unquote(href), lines[1:], rest)
        self.assertEqual(len(cells), 12)
        figures = re.findall(r'<figure id="([^"]*)">', page)
        self.assertEqual(len(figures), 11)
        for view, heading in headings.items():
            if view == "view_07":
                continue
            href, (when, looks, fate), rest = cells[view]
            self.assertEqual((href, href in figures), (view, True))
            self.assertRegex(when, "^2011-07-22T13:0")
            self.assertEqual(when.endswith("of an unknown zone"), view == "view_05")
            self.assertEqual(looks, f"looks to {heading:.0f}°")
            self.assertIn("the volume is made from it", fate)
            self.assertEqual("compass is left out" in fate, view == "view_04")
            self.assertIn("data:image/jpeg;base64,/9j/", rest)
        href, lines, rest = cells["a & <b> 50%"]
        self.assertEqual((href, lines[1:]), ("", ["compass 123°", "no camera: left out"]))
        self.assertIn('class="off"', rest)
        self.assertIn("data:image/jpeg;base64,/9j/", rest)

        # The map: each camera where it is and which way it looks, the sun from its side
        svg = page[page.index("<svg"):page.index("</svg>")]
        self.assertIn(">N</text>", svg)
        foot = re.search(r'cx="([\d.]+)" cy="([\d.]+)" r="7"', svg)
        foot = [float(x) for x in foot.groups()]
        wedges = re.findall(r'd="M([\d.]+),([\d.]+)L([\d.]+),([\d.]+)L([\d.]+),([\d.]+)Z".*?'
                            r'<text[^>]*>([^<]*) (\d+)°<', svg)
        self.assertEqual(len(wedges), 11)
        places = {v["view"]: v["position_m"] for v in done.json["views"]}
        for *numbers, view, heading in wedges:
            x, y, left, top, right, bottom = map(float, numbers)
            self.assertLess(abs(float(heading) - headings[view]), 0.51)
            self.assertAzimuth(headings[view], (left + right) / 2 - x, (top + bottom) / 2 - y, 1)
            east, north, _ = places[view]
            self.assertAzimuth(math.degrees(math.atan2(east, north)), x - foot[0], y - foot[1], 1)
        sun = re.search(r'cx="([\d.]+)" cy="([\d.]+)" r="11"', svg)
        x, y = (float(a) - b for a, b in zip(sun.groups(), foot))
        sky = self.done("sky", "--place", "40.35,-74.65", "--taken", "2011-07-22T13:00-04:00",
                        "--json").json
        self.assertAzimuth(sky["sun_azimuth_deg"], x, y, 0.5)

        # What is left over, of GPS and compasses
        table = page[page.index("What is left over"):page.index("<h2>Photos")]
        self.assertIn("GPS, m off", table)
        self.assertRegex(table, r'<td>view_04</td><td></td><td class="off">-?100.0, left out<')
        self.assertNotIn("-0.0", table)

    def test_a_report_says_when_there_is_no_sun_and_no_photo(self):
        for photo in (SAMPLE / "photos").iterdir():
            (self.folder / photo.name).write_bytes(without_exif(photo.read_bytes()))
        bare = self.folder / "bare"
        self.done("init", bare, *sorted(self.folder.glob("view_*.jpg")))
        self.done("cameras", bare, "--import", self.model, "--report")
        page = (bare / "cameras" / "report.html").read_text()
        self.assertIn("the sun is not drawn", page)
        self.assertIn("neither GPS nor a compass", page)
        self.assertNotIn('r="11"', page)
        # A photo that is gone: the page says so in its place
        (bare / "photos" / "view_03.jpg").unlink()
        page = pathlib.Path(self.done("cameras", bare, "--report").out.strip()).read_text()
        self.assertIn("view_03.jpg: no such file", page)
        self.assertEqual(page.count("<figure id="), 11)

    def test_a_shadow_tells_north_and_how_well(self):
        # Photos that say nothing, and a model that is turned by 50 degrees
        for photo in (SAMPLE / "photos").iterdir():
            (self.folder / photo.name).write_bytes(without_exif(photo.read_bytes()))
        bare = self.folder / "bare"
        self.done("init", bare, *sorted(self.folder.glob("view_*.jpg")))
        before = self.done("cameras", bare, "--import", self.model, "--json").json
        true = {view["view"]: view["heading_deg"] for view in before["views"]}
        ends = math.dist(*(before["views"][i]["position_m"] for i in (0, 6)))
        self.done("cameras", bare, "--heading", f"view_00={(true['view_00'] + 50) % 360:.4f}")
        self.done("cameras", bare, "--export", "colmap", self.folder / "turned")
        shutil.rmtree(bare / "cameras")
        turned = ("cameras", bare, "--import", self.folder / "turned", "--up", "0,0,1")
        message = self.refused(*turned, names=["no photo has a compass or a place", "--heading",
                                               "no photo has a place", "--scale-from"])
        self.assertNotIn("too close", message)

        # A pole of 9 m stands at (2, 1); its shadow as view_03 sees it
        shadow = ("--scale-from", "view_00", "view_06", f"{ends:.4f}", "--north-from-shadow",
                  "view_03")
        self.refused(*turned, *shadow, "200,500", "160,500",
                     names=["view_03.jpg", "no time or no place", "taken", "place"])
        toml = bare / "capture.toml"
        toml.write_text('place = "40.35,-74.65"\ntaken = "2011-07-22T13:00-04:00"\n' +
                        toml.read_text())
        camera = TrueCamera(self.model, "view_03")
        sun = sun_direction(176.5537, 69.8635)
        foot = (2.0, 1.0, 0.0)
        tip = (foot[0] - 9 * sun[0] / sun[2], foot[1] - 9 * sun[1] / sun[2], 0.0)
        pixels = ["{:.2f},{:.2f}".format(*camera.pixel(p)) for p in (foot, tip)]
        found = self.done(*turned, *shadow, *pixels, "--json").json
        self.assertEqual(found["north"]["from"], "the shadow and the time")
        for view in found["views"]:
            apart = (view["heading_deg"] - true[view["view"]] + 180) % 360 - 180
            self.assertLess(abs(apart), 0.5)  # Pixels are given to two digits
        self.assertGreater(found["north"]["error_deg"], 2)  # A pixel turns it by as much
        self.assertLess(found["north"]["error_deg"], 20)

        # What tells nothing is no north
        self.refused(*turned, *shadow, pixels[0], f"{float(pixels[0].split(',')[0]) + 1},503",
                     names=["a longer shadow"])
        self.refused(*turned, *shadow, pixels[0], "160,20", names=["view_03", "above the horizon"])

    def assertAzimuth(self, azimuth_deg, right, down, delta_deg):
        """Of a line on a map with north up."""
        apart = (math.degrees(math.atan2(right, -down)) - azimuth_deg + 180) % 360 - 180
        self.assertLess(abs(apart), delta_deg)

    def test_exports_come_back(self):
        self.done("cameras", self.capture, "--import", "colmap", self.model, "--keep-frame")
        kept = positions(self.capture / "cameras" / "images.txt")
        for form, path in (("colmap", "model"), ("transforms", "t.json")):
            self.done("cameras", self.capture, "--export", form, self.folder / path)
            self.done("cameras", self.capture, "--import", form, self.folder / path,
                      "--keep-frame")
            again = positions(self.capture / "cameras" / "images.txt")
            self.assertEqual(kept.keys(), again.keys())
            for view, position in kept.items():
                self.assertLess(math.dist(position, again[view]), 1e-9)

    def test_wrong_words_are_refused(self):
        given = ("cameras", self.capture, "--import", self.model)
        self.refused(*given, "--up", "0,0", code=2, names=["X,Y,Z"])
        self.refused(*given, "--up", "0,0,0", code=2, names=["no direction"])
        self.refused(*given, "--scale-from", "view_00", "view_01", "-3", code=2,
                     names=["above 0 m"])
        self.refused(*given, "--scale-from", "view_00", "view_99", "3", names=["view_99"])
        self.refused(*given, "--scale-from", "view_01", "view_01", "3", code=2,
                     names=["two views", "view_01"])
        self.refused(*given, "--heading", "view_00=upwards", code=2, names=["upwards"])
        self.refused(*given, "--north-from-shadow", "view_00", "1,2", "3", code=2,
                     names=["x1,y1"])
        self.refused(*given, "--gps-error", "0", code=2, names=["gps-error", "> 0"])
        self.refused("cameras", self.capture, "--matching", "guess", code=2,
                     names=["exhaustive", "sequential"])
        self.refused("cameras", self.capture, "--import", self.folder / "nothing",
                     names=["nothing"])
        self.refused("cameras", self.folder / "nowhere", names=["nowhere"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
