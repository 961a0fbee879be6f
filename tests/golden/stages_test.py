# SPDX-License-Identifier: Apache-2.0
"""A stage runs when something it depends on has changed, known by content and not by time; and
what a person changed by hand is used as it is."""
import math
import os
import shutil
import unittest

from relight_runner import (SAMPLE, VIEWS, Png, RelightCase, made_capture, small_capture, write_png)


class Stages(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")

    def stages(self, *words):
        return self.done(self.capture, "--to", "17:00", "--json", *words).json["stages"]

    def made(self):
        """What each file of the stages holds."""
        names = [f"mattes/{view}.png" for view in VIEWS] + ["volume.vdb", "cache/light.vdb"]
        return {name: (self.capture / name).read_bytes() for name in names}

    def test_all_of_them_at_first(self):
        capture = small_capture(self.folder / "new")
        done = self.done(capture, "--to", "17:00", "--json")
        self.assertEqual(done.json["stages"], ["mattes", "volume", "light", "relight"])
        self.assertIn("from 3 views only", done.err)

    def test_none_again(self):
        before = {n: (self.capture / n).stat().st_mtime_ns for n in self.made()}
        self.assertEqual(self.stages(), ["relight"])
        self.assertEqual({n: (self.capture / n).stat().st_mtime_ns for n in self.made()}, before)

    def test_a_touched_file_is_the_same_file(self):
        for name in ("photos/view_00.jpg", "trimaps/view_04.png", "cameras/images.txt",
                     "volume.vdb", "mattes/view_08.png", "capture.toml"):
            os.utime(self.capture / name, (2_000_000_000, 2_000_000_000))
        self.assertEqual(self.stages(), ["relight"])

    def test_another_hour_or_view_needs_nothing_but_itself(self):
        for words in (("--to", "10:00"), ("--to-light", "20,30")):
            answer = self.done(self.capture, *words, "--view", "view_04", "--json").json
            self.assertEqual(answer["stages"], ["relight"])

    def test_one_trimap(self):
        trimap = self.capture / "trimaps" / "view_04.png"
        old = Png(trimap)
        self.assertEqual((old.bits, old.channels), (8, 1))
        # A corner that was background becomes unknown
        write_png(trimap, old.width, old.height, 1,
                  lambda x, y: (128,) if x < 40 and y < 40 else old.at(x, y))
        before = self.made()
        self.assertEqual(self.stages(), ["mattes", "volume", "light", "relight"])
        after = self.made()
        for view in ("view_00", "view_08"):
            self.assertEqual(after[f"mattes/{view}.png"], before[f"mattes/{view}.png"])
        self.assertEqual(self.stages(), ["relight"])

    def test_only_the_changed_views_matte_is_made(self):
        trimap = self.capture / "trimaps" / "view_04.png"
        old = Png(trimap)
        write_png(trimap, old.width, old.height, 1,
                  lambda x, y: (0,) if y < old.height // 2 else old.at(x, y))
        outcome = self.done("matte", self.capture)
        self.assertEqual(outcome.out.split(), [str(self.capture / "mattes" / "view_04.png")])

    def test_a_camera(self):
        images = self.capture / "cameras" / "images.txt"
        lines = images.read_text().splitlines(keepends=True)
        at = next(i for i, line in enumerate(lines) if "view_08" in line)
        words = lines[at].split(" ")
        words[7] = str(float(words[7]) + 0.01)
        lines[at] = " ".join(words)
        images.write_text("".join(lines))
        self.assertEqual(self.stages(), ["volume", "light", "relight"])

    def test_a_box_of_ones_own(self):
        own = self.done("volume", self.capture, "--json").json
        low, high = own["box_m"][:3], own["box_m"][3:]
        middle = [(a + b) / 2 for a, b in zip(low, high)]
        box = ",".join([f"{2 * a - m:.6f}" for a, m in zip(low, middle)] +
                       [f"{2 * b - m:.6f}" for b, m in zip(high, middle)])
        twice = self.done("volume", self.capture, "--cells", "64", "--box", box, "--json").json
        self.assertTrue(twice["made"])
        # Twice as long, with voxels as large: empty ones around the tree are left away
        self.assertAlmostEqual(twice["cell_m"], own["cell_m"], delta=1e-6)
        for cells, as_found in zip(twice["cells"], own["cells"]):
            self.assertLessEqual(abs(cells - as_found), 1)
        self.assertAlmostEqual(twice["occupied_voxels"] / own["occupied_voxels"], 1, delta=0.1)
        self.assertFalse(self.done("volume", self.capture, "--cells", "64", "--box", box,
                                   "--json").json["made"])

        # The upper half alone
        box = ",".join(map(str, [*low[:2], middle[2], *high]))
        half = self.done("volume", self.capture, "--box", box, "--json").json
        self.assertGreater(half["box_m"][2], middle[2] - half["cell_m"])
        self.refused("volume", self.capture, "--box", "1,2,3", code=2,
                     names=["box", "X,Y,Z,X,Y,Z"])
        self.refused("volume", self.capture, "--box", "100,100,0,101,101,9",
                     names=["nothing of the tree", "--box"])

    def test_sparse_points_end_a_box_that_the_mattes_leave_open(self):
        # Three neighbours see no depth: the hull runs on towards them
        capture = self.folder / "side"
        views = ["view_11", "view_00", "view_01"]
        self.done("init", capture, *(SAMPLE / "photos" / f"{view}.jpg" for view in views))
        self.done("cameras", capture, "--import", SAMPLE / "cameras", "--matching-only")
        (capture / "trimaps").mkdir(exist_ok=True)
        for view in views:
            shutil.copy(SAMPLE / "trimaps" / f"{view}.png", capture / "trimaps")
        volume = ("volume", capture, "--cells", "24", "--iterations", "1")
        by_mattes = self.done(*volume, "--json").json
        self.assertEqual(by_mattes["box_from"], "the mattes")
        low, high = by_mattes["box_m"][:3], by_mattes["box_m"][3:]

        # Points on the front of a crown as deep as it is wide; most are between leaves
        radius = (high[0] - low[0]) / 2
        middle = ((low[0] + high[0]) / 2, 0, (low[2] + high[2]) / 2)
        tall = (high[2] - low[2]) / 2
        points = []
        for i in range(20000):
            around, up = 2.4 * i, -0.95 + 1.9 * (i + 0.5) / 20000  # Evenly
            flat = math.sqrt(1 - up * up)
            x, y = flat * math.sin(around), -abs(flat * math.cos(around))
            at = (middle[0] + 0.9 * radius * x, 0.9 * radius * y, middle[2] + 0.9 * tall * up)
            points.append(f"{i + 1} {at[0]} {at[1]} {at[2]} 90 120 60 0\n")
        (capture / "cameras" / "points3D.txt").write_text("".join(points))
        done = self.done(*volume)
        self.assertRegex(done.err, r"the box is from the mattes; south cut to \d+ sparse points")
        by_points = self.done(*volume, "--force", "--json").json
        self.assertGreater(by_points["box_m"][1], low[1] + 0.3)
        self.assertLess(by_points["box_m"][1], -0.9 * radius)
        for side in (0, 2, 3, 4, 5):  # The voxels differ in size
            self.assertAlmostEqual(by_points["box_m"][side], by_mattes["box_m"][side],
                                   delta=2 * by_mattes["cell_m"])

        hour = self.done(capture, "--view", "view_00", "--to", "16:00", "--cells", "20",
                         "--iterations", "1", "--json").json
        self.assertIn("south cut to", " ".join(hour["notes"]))

        # One's own goes before both
        own = self.done(*volume, "--box", ",".join(map(str, [*low, *high])), "--json").json
        self.assertEqual(own["box_from"], "--box")
        self.assertAlmostEqual(own["box_m"][1], low[1], delta=by_mattes["cell_m"])

    def test_options_of_the_volume_and_of_its_light(self):
        self.assertEqual(self.stages("--cells", "28"), ["volume", "light", "relight"])
        self.assertEqual(self.stages("--cells", "28"), ["relight"])
        self.assertEqual(self.stages("--cells", "28", "--sh-bands", "3"), ["light", "relight"])
        self.assertEqual(self.stages("--cells", "28", "--sh-bands", "3", "--turbidity", "4"),
                         ["relight"])

    def test_options_in_capture_toml_count_and_the_command_line_wins(self):
        toml = self.capture / "capture.toml"
        toml.write_text(toml.read_text().replace("cells = 32", "cells = 28"))
        self.assertEqual(self.stages("--cells", "32"), ["relight"])
        self.assertEqual(self.stages(), ["volume", "light", "relight"])

    def test_a_lost_file_is_made_again_as_it_was(self):
        before = self.made()
        for name, stages in (("mattes/view_04.png", ["mattes", "volume", "light", "relight"]),
                             ("volume.vdb", ["volume", "light", "relight"]),
                             ("cache/light.vdb", ["light", "relight"])):
            with self.subTest(name):
                (self.capture / name).unlink()
                # A stage before may give the very bytes that were there, then later ones run
                # no more than they have to
                ran = self.stages()
                self.assertEqual(ran[0], stages[0])
                self.assertEqual(ran[-1], "relight")
                self.assertEqual(self.made()[name], before[name])

    def test_lost_or_damaged_records_only_cost_time(self):
        records = self.capture / "cache" / "stages.json"
        for text in ("", "{", "[]", '{"volume": 3}', '{"volume": {"key": 1, "files": []}}'):
            with self.subTest(text):
                records.write_text(text)
                self.assertIn("volume", self.stages())
        self.assertEqual(self.stages(), ["relight"])

    def test_force_redoes_all(self):
        before = self.made()
        self.assertEqual(self.stages("--force"), ["mattes", "volume", "light", "relight"])
        self.assertEqual(self.made(), before)  # Same input, same bytes

    def test_an_edited_matte_is_used_as_it_is(self):
        matte = self.capture / "mattes" / "view_00.png"
        write_png(matte, 480, 600, 1, lambda x, y: (65535 if 200 <= x < 280 else 0,), bits=16)
        edited = matte.read_bytes()
        output = self.folder / "x.png"
        self.assertEqual(self.stages("-o", output), ["volume", "light", "relight"])
        self.assertEqual(self.stages("--force", "-o", output)[0], "mattes")  # Of other views
        self.assertEqual(matte.read_bytes(), edited)
        result = Png(output)
        self.assertEqual([result.at(x, 300)[3] for x in (199, 200, 279, 280)],
                         [0, 65535, 65535, 0])

    def test_an_edited_volume_is_used_as_it_is_and_said_so(self):
        volume = self.capture / "volume.vdb"
        other = made_capture(self.folder / "other")
        self.done("volume", other, "--cells", "24")
        volume.write_bytes((other / "volume.vdb").read_bytes())
        outcome = self.done(self.capture, "--to", "17:00")
        self.assertIn("volume.vdb is not as relight made it", outcome.err)
        self.assertIn("--force", outcome.err)
        self.assertEqual(volume.read_bytes(), (other / "volume.vdb").read_bytes())
        self.done(self.capture, "--to", "17:00", "--force")
        self.assertNotEqual(volume.read_bytes(), (other / "volume.vdb").read_bytes())


class SingleVerbs(RelightCase):
    def test_each_stage_by_its_own_verb(self):
        capture = small_capture(self.folder / "maple")
        mattes = self.done("matte", capture).out.split()
        self.assertEqual(mattes, [str(capture / "mattes" / f"{view}.png") for view in VIEWS])
        answer = self.done("volume", capture, "--json").json
        self.assertTrue(answer["made"])
        self.assertGreater(answer["occupied_voxels"], 100)
        self.assertFalse(self.done("volume", capture, "--json").json["made"])
        hour = self.done(capture, "--to", "17:00", "--json").json
        self.assertEqual(hour["stages"], ["light", "relight"])

    def test_a_page_of_the_volume(self):
        capture = small_capture(self.folder / "maple")
        done = self.done("volume", capture, "--report")
        page = capture / "volume.html"
        self.assertIn(str(page), done.out.split("\n"))
        text = page.read_text()
        for view in VIEWS:
            self.assertRegex(text, rf'<figure id="{view}"><img [^>]*data:image/jpeg;base64,')
            self.assertRegex(text, rf"{view}: 0\.\d+ rms apart")
        for words in ("north is up", "seen from the south", "seen from the east"):
            self.assertIn(words, text)
        self.assertNotRegex(text, r'(src|href)="(?!data:)')  # Nothing from elsewhere
        self.done("volume", capture, "--report")
        self.assertEqual(page.read_text(), text)

    def test_a_view_left_out(self):
        capture = small_capture(self.folder / "maple")
        self.done("volume", capture)
        before = (capture / "volume.vdb").read_bytes()
        left_out = self.done("volume", capture, "--leave-out", "view_04", "--json").json
        self.assertEqual(left_out["left_out"], "view_04")
        self.assertGreater(left_out["held_out_rmse"], left_out["used_rmse"])
        self.assertEqual((capture / "volume.vdb").read_bytes(), before)
        self.refused("volume", capture, "--leave-out", "view_99", names=["view_99", *VIEWS])

    def test_a_volume_of_another_program(self):
        capture = small_capture(self.folder / "maple")
        self.done("volume", capture)
        theirs = self.folder / "theirs.vdb"
        (capture / "volume.vdb").rename(theirs)
        done = self.done("volume", capture, "--import", theirs, "--scale", "0.5", "--json").json
        self.assertFalse(done["made"])
        self.assertGreater(done["occupied_voxels"], 100)
        imported = (capture / "volume.vdb").read_bytes()
        lit = self.done(capture, "--to", "17:00", "--json")
        self.assertNotIn("volume", lit.json["stages"])
        self.assertIn("not as relight made it", lit.err)
        self.assertEqual((capture / "volume.vdb").read_bytes(), imported)
        self.assertTrue(self.done("volume", capture, "--force", "--json").json["made"])
        self.refused("volume", capture, "--grid", "density", code=2, names=["--import"])
        self.refused("volume", capture, "--import", theirs, "--grid", "wood",
                     names=["theirs.vdb", "wood", "extinction"])
        self.refused("volume", capture, "--import", capture / "photos" / "view_00.jpg",
                     names=["view_00.jpg", "cannot be read as OpenVDB"])

    def test_init_from_photos_and_again(self):
        capture = small_capture(self.folder / "maple")
        new = self.folder / "new"
        photos = [capture / "photos" / f"{view}.jpg" for view in VIEWS]
        self.done("init", new, *photos[:2])
        text = (new / "capture.toml").read_text()
        self.assertEqual((new / "photos" / "view_00.jpg").read_bytes(), photos[0].read_bytes())
        (new / "capture.toml").write_text("# mine\nheading = 12.5\n" + text)
        self.done("init", new, *photos)
        text = (new / "capture.toml").read_text()
        self.assertTrue(text.startswith("# mine\nheading = 12.5\n"))
        self.assertEqual(text.count("[[view]]"), 3)
        self.done("init", new)  # Nothing new: nothing changed
        self.assertEqual((new / "capture.toml").read_text(), text)
        self.refused("init", new, self.other_photo(), names=["another photo", "view_00", "rename"])
        names = [v["name"] for v in self.done("info", new, "--json").json["views"]]
        self.assertEqual(names, list(VIEWS))

    def other_photo(self):
        other = self.folder / "elsewhere" / "view_00.png"
        other.parent.mkdir()
        return write_png(other, 8, 8, 3, lambda x, y: (x, y, 0))

    def test_cameras_come_back_as_they_went_in(self):
        capture = small_capture(self.folder / "maple")
        model = self.folder / "model"
        (capture / "cameras").rename(model)
        self.done("cameras", capture, "--import", "colmap", model)
        self.assertEqual((capture / "cameras" / "images.txt").read_text().count("view_"), 3)
        self.refused("cameras", capture, "--import", "polaroid", model,
                     names=["polaroid", "bundler", "colmap"])
        self.refused("cameras", capture, "--import", "colmap", self.folder,
                     names=["cameras.txt"])


if __name__ == "__main__":
    unittest.main()
