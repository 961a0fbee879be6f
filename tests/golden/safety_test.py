# SPDX-License-Identifier: Apache-2.0
"""A full disk, a stop at any moment, and captures that came from anywhere: nothing half-written,
nothing lost, nothing written elsewhere."""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

from relight_runner import (PROGRAM, SAMPLE, RelightCase, contents, made_capture, relight,
                            small_capture, tree_png)


class FullDisk(RelightCase):
    """A limit of the size of files stands for a disk that gets full while writing."""

    def test_outputs_of_every_format(self):
        capture = made_capture(self.folder / "maple")
        for extension in ("png", "jpg", "tif", "exr"):
            with self.subTest(extension):
                output = self.folder / f"x.{extension}"
                output.write_bytes(b"what was there before")
                self.refused(capture, "--to", "17:00", "-o", output, file_limit=20_000,
                             names=[output, "free some space"])
                self.assertEqual(output.read_bytes(), b"what was there before")
        for option in ("--irradiance", "--ratio"):
            layer = self.folder / "layer.exr"
            self.refused(capture, "--to", "17:00", "-o", self.folder / "y.png", option, layer,
                         file_limit=20_000, names=[layer, "free some space"])
            self.assertFalse(layer.exists())
            self.assertFalse((self.folder / "y.png").exists())

    def test_every_stage(self):
        # Each limit stops another file: matte, colours, volume, its light, the picture
        capture = small_capture(self.folder / "maple")
        stopped = set()
        for limit in (1_000, 20_000, 100_000, 200_000, 400_000, 800_000, 1_600_000, 3_200_000):
            outcome = relight(capture, "--to", "17:00", file_limit=limit)
            self.assertNoPartialFile()
            if outcome.code == 0:
                break
            self.assertEqual(outcome.code, 1, outcome.err)
            message = outcome.err[outcome.err.rfind("relight: "):]
            self.assertIn("free some space", message)
            self.assertIn(str(capture), message)
            stopped.add(pathlib.Path(message.split(": ")[1]).suffix)
        self.assertGreaterEqual(len(stopped), 2, stopped)
        self.done(capture, "--to", "17:00")
        # What it came to by pieces is what it is in one go
        whole = small_capture(self.folder / "whole")
        self.done(whole, "--to", "17:00")
        self.assertEqual((capture / "out" / "view_00_1700.png").read_bytes(),
                         (whole / "out" / "view_00_1700.png").read_bytes())

    def test_disk_that_is_really_full(self):
        disk = self.folder / "disk"
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)],
                                 capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("mounting is not allowed here; the tests above limit the file size")
        try:
            capture = made_capture(self.folder / "maple")
            message = self.refused(capture, "--to", "17:00", "-o", disk / "x.png",
                                   names=[disk / "x.png", "free some space"])
            self.assertIn("No space left", message)
        finally:
            subprocess.run(["umount", str(disk)], check=True)

    def test_init(self):
        new = self.folder / "new"
        new.mkdir()
        self.refused("init", new, SAMPLE / "photos" / "view_00.jpg", file_limit=1000,
                     names=[new / "photos" / "view_00.jpg", "free some space"])
        self.assertFalse((new / "capture.toml").exists())

    def test_standard_output(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "sky", "--place", "40,-74", "--taken",
                                   "2011-07-22T17:00-04:00"], stdout=full, stderr=subprocess.PIPE,
                                  text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("standard output cannot be written", done.stderr)


class Stop(RelightCase):
    def start(self, *words):
        return subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def test_in_each_stage(self):
        for stage in ("mattes", "volume", "light", "relight"):
            with self.subTest(stage):
                capture = small_capture(self.folder / f"at_{stage}")
                # Fine enough that each stage lasts longer than the signal takes
                run = self.start(capture, "--to", "17:00", "--cells", "64")
                self.addCleanup(run.stderr.close)
                self.addCleanup(run.stdout.close)
                for line in run.stderr:
                    if line == f"relight: {stage}…\n":
                        break
                run.send_signal(signal.SIGINT)
                rest = run.stderr.read()
                self.assertEqual(run.wait(60), 130, rest)
                self.assertIn("stopped; nothing half-written is left", rest)
                self.assertEqual(run.stdout.read(), "")
                self.assertNoPartialFile()
                self.assertFalse((capture / "out").exists())
                # What was done stays done
                answer = self.done(capture, "--to", "17:00", "--cells", "64", "--json").json
                order = ["mattes", "volume", "light", "relight"]
                self.assertEqual(answer["stages"], order[-len(answer["stages"]):])
                self.assertIn(answer["stages"][0], order[order.index(stage):])

    def test_at_any_moment(self):
        made = small_capture(self.folder / "maple")
        chance = random.Random(7)
        codes = set()
        for _ in range(8):
            run = self.start(made, "--to", "17:00", "--force", "-o", self.folder / "x.png")
            time.sleep(chance.uniform(0.3, 4))
            run.send_signal(signal.SIGTERM)
            out, err = run.communicate(timeout=60)
            # 143: it ended before it listened; that is no half-written file either
            self.assertIn(run.returncode, (0, 130, -signal.SIGTERM), err)
            self.assertEqual(out != "", run.returncode == 0)
            self.assertEqual((self.folder / "x.png").exists(), run.returncode == 0)
            (self.folder / "x.png").unlink(missing_ok=True)
            self.assertNoPartialFile()
            codes.add(run.returncode)
        self.assertIn(130, codes)


class CapturesFromAnywhere(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")
        self.secret = self.folder / "secret.jpg"
        shutil.copy(SAMPLE / "photos" / "view_00.jpg", self.secret)

    def test_names_that_lead_out_of_capture_toml(self):
        toml = self.capture / "capture.toml"
        views = toml.read_text()
        for entry in (f'photo = "{self.secret}"', 'photo = "../secret.jpg"',
                      'photo = "photos/../../secret.jpg"', 'photo = ""', 'photo = "photos/"',
                      'name = "../x"\nphoto = "photos/view_00.jpg"',
                      'name = "/x"\nphoto = "photos/view_00.jpg"',
                      'name = "a/b"\nphoto = "photos/view_00.jpg"',
                      'name = ".."\nphoto = "photos/view_00.jpg"',
                      'name = "a\\nb"\nphoto = "photos/view_00.jpg"'):
            with self.subTest(entry):
                toml.write_text(f"[[view]]\n{entry}\n" + views)
                for verb in (("hour",), ("info",), ("matte",), ("volume",)):
                    to = ("--to", "17:00") if verb == ("hour",) else ()
                    self.refused(*verb, self.capture, *to, names=["capture.toml:1: "])

    def test_names_that_lead_out_of_images_txt(self):
        images = self.capture / "cameras" / "images.txt"
        text = images.read_text()
        for name in (str(self.secret), "../secret.jpg", "a/../../view_00.jpg"):
            with self.subTest(name):
                images.write_text(text.replace("view_00", name))
                self.refused(self.capture, "--to", "17:00", names=["images.txt", name, "refused"])

    def test_folders_that_are_links(self):
        elsewhere = self.folder / "elsewhere"
        for name in ("mattes", "cache", "out", "cache/foreground", "cameras"):
            with self.subTest(name):
                elsewhere.mkdir()
                capture = self.folder / f"linked_{name.replace('/', '_')}"
                shutil.copytree(self.capture, capture)
                shutil.rmtree(capture / name)
                (capture / name).symlink_to(elsewhere)
                if name == "cameras":
                    words = ("cameras", capture, "--import", "colmap", self.capture / "cameras")
                else:
                    words = (capture, "--to", "17:00")
                self.refused(*words, names=[capture / name, "leads out of the capture",
                                            elsewhere])
                self.assertEqual(list(elsewhere.iterdir()), [])
                elsewhere.rmdir()

    def test_a_file_that_is_a_link_is_replaced_and_not_followed(self):
        victim = self.folder / "victim"
        victim.write_bytes(b"mine")
        for name in ("volume.vdb", "mattes/view_04.png", "cache/light.vdb",
                     "cache/foreground/view_00.exr", "out/view_00_1700.png"):
            file = self.capture / name
            file.unlink(missing_ok=True)
            file.symlink_to(victim)
        outcome = relight(self.capture, "--to", "17:00", "--force")
        self.assertIn(outcome.code, (0, 1), outcome.err)
        self.assertEqual(victim.read_bytes(), b"mine")

    def test_records_from_anywhere(self):
        records = self.capture / "cache" / "stages.json"
        records.write_text('{"volume": {"key": "x", "files": {"../secret.jpg": "x", '
                           '"/etc/passwd": "y", "/dev/zero": "z"}}}')
        before = self.secret.read_bytes()
        self.done(self.capture, "--to", "17:00")
        self.assertEqual(self.secret.read_bytes(), before)

    def test_no_shell_sees_a_name(self):
        name = "$(touch pwned); `touch pwned` 'x\" & tree.png"
        photo = tree_png(self.folder / name)
        self.done(name, "--lit-from", "30,40", "--to-light", "90,20", "--cells", "24",
                  cwd=self.folder)
        self.assertFalse((self.folder / "pwned").exists())
        message = self.refused(name, "--to", "17:00", cwd=self.folder, names=["--taken"])
        # The command that is shown is quoted as a shell needs it
        command = message[message.index("relight hour"):].splitlines()[0]
        ran = subprocess.run(["sh", "-c", command.replace("relight", '"$0"', 1), PROGRAM],
                             cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertFalse((self.folder / "pwned").exists())
        self.assertTrue(photo.exists())


if __name__ == "__main__":
    unittest.main()
