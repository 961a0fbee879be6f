# SPDX-License-Identifier: Apache-2.0
"""A day of frames: their names, what stands beside them, and a run that is stopped."""
import csv
import html
import json
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

from relight_runner import (PROGRAM, Exr, Png, RelightCase, contents, made_capture, tree_png,
                            write_png)

FACTS = ("--place", "40.35,-74.65", "--taken", "2011-07-22T13:00", "--zone", "-04:00",
         "--heading", "0")


class ADay(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")
        self.out = self.folder / "frames"

    def test_frames_by_local_time_and_what_stands_beside_them(self):
        answer = self.done("day", self.capture, "--hours", "8..17", "--every", "3h", "-o",
                           self.out, "--json").json
        names = [f"2011-07-22_{h:02}00.png" for h in (8, 11, 14, 17)]
        self.assertEqual([f["name"] + ".png" for f in answer["frames"]], names)
        self.assertEqual((answer["made"], answer["kept"], answer["left_out"]), (4, 0, []))
        expected = {*names, "sun.csv", "contact_sheet.png", "index.html", "relight_day.json"}
        if shutil.which("ffmpeg"):
            expected.add("day.mp4")
        else:
            self.assertIn("ffmpeg is not installed", " ".join(answer["notes"]))
        self.assertEqual({f.name for f in self.out.iterdir()}, expected)
        for name in names:
            picture = Png(self.out / name)
            self.assertEqual((picture.width, picture.height, picture.channels, picture.bits),
                             (480, 600, 3, 16))
        with open(self.out / "sun.csv", newline="") as table:
            rows = list(csv.DictReader(table))
        self.assertEqual([row["frame"] for row in rows], names)
        # NOAA's solar calculator for 40.35 N 74.65 W, 17:00 EDT: 266.29, 36.50 deg
        self.assertAlmostEqual(float(rows[3]["azimuth_deg"]), 266.29, delta=0.05)
        self.assertAlmostEqual(float(rows[3]["elevation_deg"]), 36.50, delta=0.05)
        self.assertGreater(float(rows[1]["sun_g_lx"]), float(rows[3]["sun_g_lx"]))

    def test_a_frame_is_what_hour_makes_of_the_whole_photo(self):
        self.done("day", self.capture, "--hours", "17..17", "-o", self.out)
        hour = self.folder / "hour.png"
        self.done(self.capture, "--to", "17:00", "--whole", "-o", hour)
        self.assertEqual(Png(self.out / "2011-07-22_1700.png").samples, Png(hour).samples)

    def test_the_hours_of_daylight_of_several_dates(self):
        answer = self.done("day", self.capture, "--dates", "2011-12-21,2011-06-21", "--every",
                           "4h", "-o", self.out, "--json").json
        # Sunrise and sunset of the place, standard -04:00: 5:32 to 20:32 and 8:19 to 17:36
        self.assertEqual([f["name"] for f in answer["frames"]],
                         ["2011-06-21_0800", "2011-06-21_1200", "2011-06-21_1600",
                          "2011-06-21_2000", "2011-12-21_1200", "2011-12-21_1600"])

    def test_hours_of_night_are_left_out_and_said(self):
        outcome = self.done("day", self.capture, "--hours", "4..8", "--every", "2h", "-o",
                            self.out)
        self.assertIn("1 hour is left out, for the sun is below the horizon: "
                      "2011-07-22_0400", outcome.err)
        self.assertFalse((self.out / "2011-07-22_0400.png").exists())
        self.refused("day", self.capture, "--hours", "0..3", "-o", self.folder / "night",
                     names=("below the horizon", "0..3", "--hours"))
        self.assertFalse((self.folder / "night").exists())

    def test_tree_and_shadow_on_transparency(self):
        self.done("day", self.capture, "--hours", "10..10", "--alone", "-o", self.out)
        self.done("day", self.capture, "--hours", "10..10", "--alone", "--format", "exr", "-o",
                  self.folder / "exr")
        frame = Png(self.out / "2011-07-22_1000.png")
        self.assertEqual(frame.channels, 4)
        matte = Png(self.capture / "mattes" / "view_00.png").samples
        shadows = 0
        for i, alpha in enumerate(matte):
            r, g, b, a = frame.samples[4 * i:4 * i + 4]
            self.assertGreaterEqual(a, alpha - 1)
            if alpha == 0 and a > 6000:
                shadows += 1
                self.assertEqual((r, g, b), (0, 0, 0))
        self.assertGreater(shadows, 1000)
        self.assertEqual(sorted(Exr(self.folder / "exr" / "2011-07-22_1000.exr").types),
                         ["A", "B", "G", "R"])

    def test_over_a_backdrop(self):
        backdrop = self.folder / "grey.png"
        write_png(backdrop, 480, 600, 3, lambda x, y: (200, 200, 200))
        self.done("day", self.capture, "--hours", "10..10", "--over", backdrop, "-o", self.out)
        hour = self.folder / "hour.png"
        self.done(self.capture, "--to", "10:00", "--over", backdrop, "-o", hour)
        self.assertEqual(Png(self.out / "2011-07-22_1000.png").samples, Png(hour).samples)
        small = write_png(self.folder / "small.png", 48, 60, 3, lambda x, y: (200, 200, 200))
        self.refused("day", self.capture, "--over", small, "-o", self.folder / "other",
                     names=(small, "480 x 600"))

    def test_one_exposure_for_all(self):
        answer = self.done("day", self.capture, "--hours", "13..19", "--every", "3h",
                           "--exposure", "auto", "-o", self.out, "--json").json
        # The photo's own hour is 13:00, and the brightest of these or close to it
        self.assertAlmostEqual(answer["exposure_ev"], 0.0, delta=0.35)
        answer = self.done("day", self.capture, "--hours", "17..19", "--every", "1h",
                           "--exposure", "+1", "-o", self.folder / "up", "--json").json
        self.assertEqual(answer["exposure_ev"], 1.0)

    def test_another_run_in_the_folder_is_not_lost(self):
        self.done("day", self.capture, "--hours", "12..12", "-o", self.out)
        self.refused("day", self.capture, "--hours", "12..12", "--turbidity", "5", "-o",
                     self.out, names=(self.out, "another run", "--force"))
        self.done("day", self.capture, "--hours", "15..15", "--turbidity", "5", "-o", self.out,
                  "--force")
        self.assertEqual([f.name for f in sorted(self.out.glob("2011*"))],
                         ["2011-07-22_1500.png"])
        # More hours of the same run go on where it was
        answer = self.done("day", self.capture, "--hours", "12..15", "--every", "3h",
                           "--turbidity", "5", "-o", self.out, "--json").json
        self.assertEqual((answer["made"], answer["kept"]), (1, 1))
        foreign = self.folder / "foreign"
        foreign.mkdir()
        (foreign / "index.html").write_text("mine")
        self.refused("day", self.capture, "--hours", "12..12", "-o", foreign,
                     names=(foreign / "index.html", "--force"))

    def test_a_folder_that_cannot_be(self):
        file = self.folder / "file"
        file.write_text("mine")
        for out in (file, file / "frames", "/proc/frames"):
            with self.subTest(out):
                said = self.refused("day", self.capture, "--hours", "12..12", "-o", out,
                                    names=("-o",))
                self.assertNotIn("will run", said)

    def test_words_that_cannot_be_read(self):
        for words, name in ((("--hours", "18..9"), "18..9"), (("--hours", "9"), "--hours"),
                            (("--hours", "9..25"), "9..25"), (("--every", "0m"), "--every"),
                            (("--every", "1x"), "--every"), (("--dates", "2011-02-30"),
                                                             "2011-02-30"),
                            (("--format", "jpg"), "jpg"),
                            (("--alone", "--over", "x.png"), "--over")):
            with self.subTest(words):
                self.refused("day", self.capture, *words, "-o", self.out, names=(name,), code=2)

    def test_same_bytes_whatever_the_threads(self):
        for threads in (1, 3):
            self.done("day", self.capture, "--hours", "9..17", "--every", "4h", "--threads",
                      threads, "-o", self.folder / str(threads))
        one, three = (contents(self.folder / str(t)) for t in (1, 3))
        self.assertEqual(one.keys(), three.keys())
        for name, content in one.items():
            self.assertEqual(content, three[name], f"{name} depends on the threads")

    def test_a_photo_without_a_background(self):
        photo = tree_png(self.folder / "cut.png")
        self.refused("day", photo, *FACTS, "--hours", "12..12", "--cells", "24", "-o", self.out,
                     names=(photo, "--alone", "--over"))
        self.done("day", photo, *FACTS, "--hours", "12..12", "--cells", "24", "--alone", "-o",
                  self.out)

    def test_what_is_missing_comes_with_a_command(self):
        photo = tree_png(self.folder / "cut.png")
        said = self.refused("day", photo, "--every", "2h", "--alone", names=("relight day",))
        self.assertIn("--every 2h --alone", said)


class AStoppedRun(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")
        self.out = self.folder / "frames"
        self.words = [PROGRAM, "day", str(self.capture), "--hours", "8..18", "--every", "30m",
                      "-o", str(self.out)]

    def start(self):
        return subprocess.Popen(self.words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def assert_whole_frames_only(self):
        for file in self.out.glob("*.png"):
            Png(file)  # Reads all of it, checksums too

    def test_killed_twenty_times_it_goes_on(self):
        whole = self.folder / "whole"
        self.done(*self.words[1:-1], whole)
        seconds = random.Random(4)
        kills = 0
        while kills < 20:
            run = self.start()
            time.sleep(seconds.uniform(0.05, 1.5))
            if run.poll() is not None:  # Done already: start anew
                shutil.rmtree(self.out)
                run.stderr.close()
                continue
            run.kill()
            run.wait()
            run.stderr.close()
            kills += 1
            if self.out.exists():
                self.assert_whole_frames_only()
        outcome = self.done(*self.words[1:])
        self.assertRegex(outcome.err, r"\d+ frames made")
        self.assertEqual(contents(self.out), contents(whole))

    def test_ctrl_c(self):
        run = self.start()
        deadline = time.monotonic() + 60
        while len(list(self.out.glob("2011*.png"))) < 2 and time.monotonic() < deadline:
            time.sleep(0.02)
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, said)
        self.assert_whole_frames_only()
        self.assertNoPartialFile()
        outcome = self.done(*self.words[1:])
        self.assertRegex(outcome.err, r"\d+ were there already")


@unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed: the video is not tested")
class TheVideo(RelightCase):
    def test_h264_of_all_frames(self):
        capture = made_capture(self.folder / "maple")
        out = self.folder / "frames"
        self.done("day", capture, "--hours", "9..17", "--every", "1h", "-o", out)
        probe = subprocess.run(
            ["ffprobe", "-v", "error", "-count_frames", "-show_entries",
             "stream=codec_name,width,height,pix_fmt,nb_read_frames", "-of", "csv=p=0",
             str(out / "day.mp4")], capture_output=True, text=True, check=True)
        self.assertEqual(probe.stdout.strip(), "h264,480,600,yuv420p,9")

    def test_without_ffmpeg_the_rest_is_made(self):
        capture = made_capture(self.folder / "maple")
        empty = self.folder / "bin"
        empty.mkdir()
        outcome = self.done("day", capture, "--hours", "12..12", "-o", self.folder / "frames",
                            env={"PATH": str(empty)})
        self.assertIn("no video: ffmpeg is not installed", outcome.err)
        self.assertFalse((self.folder / "frames" / "day.mp4").exists())
        self.assertTrue((self.folder / "frames" / "index.html").exists())


@unittest.skipUnless(shutil.which("chromium"), "chromium is not installed: the page is not tested")
class ThePage(RelightCase):
    """The page as a browser runs it from a folder, its slider moved by a script of ours."""
    WATCH = """<script>
      window.errors = [];
      window.addEventListener('error', e => errors.push(e.message));
      console.error = (...words) => errors.push(words.join(' '));
    </script>"""
    MOVE = """<script>
      addEventListener('load', async () => {
        const seen = [];
        const slider = document.querySelector('input[type=range]');
        for (let i = +slider.min; i <= +slider.max; ++i) {
          slider.value = i;
          slider.dispatchEvent(new Event('input', {bubbles: true}));
          const image = document.querySelector('img');
          while (!image.complete) await new Promise(next => setTimeout(next, 10));
          const canvas = document.createElement('canvas');
          [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
          const paper = canvas.getContext('2d');
          paper.drawImage(image, 0, 0);
          const pixels = paper.getImageData(0, 0, canvas.width, canvas.height).data;
          let sum = 0;
          for (let k = 0; k < pixels.length; k += 4) sum += pixels[k + 1];
          seen.push({size: [canvas.width, canvas.height], sum,
                     text: document.querySelector('output').textContent});
        }
        const result = document.createElement('pre');
        result.id = 'result';
        result.textContent = JSON.stringify({seen, errors});
        document.body.append(result);
      });
    </script>"""

    def test_the_slider_changes_the_picture(self):
        capture = made_capture(self.folder / "maple")
        out = self.folder / "frames"
        self.done("day", capture, "--hours", "9..18", "--every", "3h", "-o", out)
        page = (out / "index.html").read_text()
        self.assertNotRegex(page, r"""(src|href)=["']?https?:""")
        moved = out / "moved.html"
        moved.write_text(page.replace("<head>", "<head>" + self.WATCH)
                         .replace("</body>", self.MOVE + "</body>"))
        run = subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
             f"--user-data-dir={self.folder / 'profile'}", "--enable-logging=stderr",
             "--virtual-time-budget=20000", "--dump-dom", moved.as_uri()],
            capture_output=True, text=True, timeout=180)
        found = re.search(r'<pre id="result">(.*?)</pre>', run.stdout, re.S)
        self.assertTrue(found, run.stderr[-2000:])
        result = json.loads(html.unescape(found.group(1)))
        self.assertEqual(result["errors"], [])
        self.assertNotIn("CONSOLE", run.stderr)
        seen = result["seen"]
        self.assertEqual([s["size"] for s in seen], [[480, 600]] * 4)
        self.assertEqual(len({s["sum"] for s in seen}), 4, "the picture does not change")
        for shown, hour in zip(seen, ("09:00", "12:00", "15:00", "18:00")):
            self.assertIn(f"2011-07-22 {hour}", shown["text"])


if __name__ == "__main__":
    unittest.main()
