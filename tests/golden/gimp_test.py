# SPDX-License-Identifier: Apache-2.0
"""The plug-in on the real GIMP 2.10, in batch: what it adds to an image, what it leaves alone,
and what it says when something is wrong.

The plug-in is below $RELIGHT_GIMP_PLUGINS; GIMP gets a profile of its own. GIMP's exit status
says nothing of a script's errors: each script ends with a mark, and the log is read.
"""
import atexit
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import unittest

from relight_runner import Png, RelightCase, made_capture, relight, tree_png, write_png

GIMP = shutil.which("gimp-console-2.10")
PROFILE = pathlib.Path(tempfile.mkdtemp(prefix="relight_gimp_"))
atexit.register(shutil.rmtree, PROFILE, ignore_errors=True)
PLUGINS = os.environ.get("RELIGHT_GIMP_PLUGINS", "")
NAMES = ("to", "exposure", "lit-from", "to-light", "like", "capture", "view", "place", "zone",
         "taken", "heading")
FACTS = {"place": "40.35,-74.65", "zone": "-04:00", "taken": "2011-07-22T13:00", "heading": "0"}
SIDES = {"lit-from": "180,45", "to-light": "90,25"}  # As a camera sees them

PRELUDE = """
(define mark-port #f)
(define (mark . words)
  (for-each (lambda (w) (display w mark-port) (display " " mark-port)) words)
  (newline mark-port))
(define (load-picture file) (car (gimp-file-load RUN-NONINTERACTIVE file file)))
(define (active image) (car (gimp-image-get-active-layer image)))
(define (name item) (car (gimp-item-get-name item)))
(define (save image drawable file) (file-png-save RUN-NONINTERACTIVE image drawable file file
                                                  0 6 0 0 0 0 0))
(define (top image) (aref (cadr (gimp-image-get-layers image)) 0))
(define (child group n) (aref (cadr (gimp-item-get-children group)) n))
"""


def relight_call(image="image", layer="(active image)", shadow=True, mode="RUN-NONINTERACTIVE",
                 **said):
    texts = {k.replace("_", "-"): v for k, v in said.items()}
    words = " ".join(f'"{texts.pop(name, "")}"' for name in NAMES)
    assert not texts, texts
    return (f"(car (plug-in-relight-tree {mode} {image} {layer} {words} "
            f"{'TRUE' if shadow else 'FALSE'}))")


def wide_profile(file):
    """An ICC profile of the primaries of Adobe RGB (1998), on D50, with a gamma of 2.2."""
    def xyz(*values):
        return b"XYZ \0\0\0\0" + b"".join(struct.pack(">i", round(v * 65536)) for v in values)
    curve = b"curv\0\0\0\0" + struct.pack(">IH", 1, round(2.2 * 256)) + b"\0\0"
    tags = {b"desc": b"desc\0\0\0\0" + struct.pack(">I", 5) + b"wide\0" + b"\0" * 78,
            b"cprt": b"text\0\0\0\0none\0\0\0\0", b"wtpt": xyz(0.9642, 1, 0.8249),
            b"rXYZ": xyz(0.60974, 0.31111, 0.01947), b"gXYZ": xyz(0.20528, 0.62567, 0.06087),
            b"bXYZ": xyz(0.14919, 0.06322, 0.74457),
            b"rTRC": curve, b"gTRC": curve, b"bTRC": curve}
    table, data = struct.pack(">I", len(tags)), b""
    for name, value in tags.items():
        value += b"\0" * (-len(value) % 4)
        table += name + struct.pack(">II", 132 + 12 * len(tags) + len(data), len(value))
        data += value
    size = 128 + len(table) + len(data)
    head = (struct.pack(">I", size) + b"\0" * 4 + bytes([2, 0x20, 0, 0]) + b"mntrRGB XYZ " +
            struct.pack(">6H", 2026, 1, 1, 0, 0, 0) + b"acsp" + b"\0" * 28 +
            xyz(0.9642, 1, 0.8249)[8:])
    file.write_bytes(head + b"\0" * (128 - len(head)) + table + data)
    return file


@unittest.skipUnless(GIMP, "gimp-console-2.10 is not installed: the plug-in is not tested")
@unittest.skipUnless(pathlib.Path(PLUGINS, "relight-tree", "relight-tree").is_file(),
                     "the plug-in was not built (libgimp2.0-dev): not tested")
class InGimp(RelightCase):
    """One profile for all, so that GIMP asks its plug-ins once."""

    def batch(self, *scripts):
        """Runs each script by itself in one GIMP; the words marked by each, and the log."""
        (PROFILE / "gradients").mkdir(exist_ok=True)
        (PROFILE / "gimprc").write_text(
            f'(plug-in-path "${{gimp_plug_in_dir}}/plug-ins:{PLUGINS}")\n')
        words, files = [], []
        for i, script in enumerate(scripts):
            file, marks = self.folder / f"script_{i}.scm", self.folder / f"marks_{i}"
            file.write_text(PRELUDE + f'(set! mark-port (open-output-file "{marks}"))\n' +
                            script + '\n(mark "end")\n(close-output-port mark-port)\n')
            files.append(marks)
            words += ["-b", f'(load "{file}")']
        log = subprocess.run(
            [GIMP, "-i", "-d", "-f", "-n", *words, "-b", "(gimp-quit 0)"],
            env={**os.environ, "GIMP2_DIRECTORY": str(PROFILE), "NO_AT_BRIDGE": "1"},
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, timeout=300).stdout
        self.assertNotRegex(log, "fatal error|inconsistent state|crashed")
        found = [f.read_text().split("\n")[:-1] if f.is_file() else [] for f in files]
        return [[line.strip() for line in lines] for lines in found], log

    def done(self, *scripts):
        marks, log = self.batch(*scripts)
        for lines in marks:
            self.assertEqual(lines[-1:], ["end"], log)
        self.assertNotIn("GIMP-Error", log)
        return [lines[:-1] for lines in marks]

    def refused(self, *scripts):
        """The messages of scripts that each end with one."""
        marks, log = self.batch(*scripts)
        for lines in marks:
            self.assertNotIn("end", lines, log)
        messages = re.findall(r"^Error: (.*?)\n\n", log + "\n", re.M | re.S)
        self.assertEqual(len(messages), len(scripts), log)
        self.assertNotIn("error of Relight Tree", log)
        return messages

    def assertSamePictures(self, ours, theirs, steps=1):
        """Within `steps` of 8 bits where the alpha says that there is something."""
        scale_a, scale_b = (255 / (2 ** p.bits - 1) for p in (ours, theirs))
        self.assertEqual((ours.width, ours.height), (theirs.width, theirs.height))
        self.assertEqual(ours.channels, theirs.channels)
        n, seen = ours.channels, 0
        for i in range(0, len(ours.samples), n):
            a = [v * scale_a for v in ours.samples[i:i + n]]
            b = [v * scale_b for v in theirs.samples[i:i + n]]
            if n == 4 and b[3] == 0:
                self.assertLessEqual(a[3], 0.5)
                continue
            seen += 1
            self.assertLessEqual(max(abs(x - y) for x, y in zip(a, b)), steps + 0.01,
                                 f"pixel {i // n}: {a} {b}")
        self.assertGreater(seen, 500)


class APhotoOfACapture(InGimp):
    def test_equals_the_program_and_leaves_the_layer_as_it_was(self):
        capture = made_capture(self.folder / "maple")
        photo = capture / "photos" / "view_00.jpg"
        tree, shadow, whole = (self.folder / f"{n}.png" for n in ("tree", "shadow", "whole"))
        as_opened, untouched = self.folder / "as_opened.png", self.folder / "untouched.png"
        deep, retouched = self.folder / "deep.png", self.folder / "retouched.png"
        opening = f'(define image (load-picture "{photo}"))\n'
        first, again, precise, float_one, painted = self.done(
            opening +
            f"""(define layer (active image))
            (save image layer "{as_opened}")
            (gimp-image-select-ellipse image CHANNEL-OP-REPLACE 10 10 50 50)
            (define tree {relight_call(to="17:00")})
            (define group (top image))
            (mark (name group) "/" (name (child group 0)) "/" (name (child group 1)))
            (mark (= tree (child group 0)) (= (car (gimp-layer-get-mode (child group 1)))
                                              LAYER-MODE-MULTIPLY-LEGACY)
                  (car (gimp-item-get-visible layer)) (car (gimp-item-get-visible tree)))
            (save image tree "{tree}")
            (save image (child group 1) "{shadow}")
            (mark (car (gimp-item-get-visible tree)) (car (gimp-item-get-parasite-list layer)))
            (save image layer "{untouched}")""",
            # The layer remembers, and the last values can be repeated
            opening +
            f"""{relight_call(to="2011-09-23T16:00", view="view_00", shadow=False)}
            (mark (name (top image)) (car (gimp-item-get-children (top image))))
            (define layer (aref (cadr (gimp-image-get-layers image)) 1))
            (mark (car (gimp-item-get-parasite-list layer)))
            {relight_call(mode="RUN-WITH-LAST-VALS", layer="layer")}
            (mark (car (gimp-image-get-layers image))
                  (car (gimp-item-get-children (top image))))""",
            opening +
            f"""(gimp-image-convert-precision image PRECISION-U16-GAMMA)
            (define tree {relight_call(to="17:00")})
            (mark (car (gimp-image-get-precision image)))
            (save image tree "{deep}")""",
            opening +
            f"""(gimp-image-convert-precision image PRECISION-FLOAT-LINEAR)
            (define tree {relight_call(to="17:00", exposure="auto")})
            (mark (car (gimp-image-get-precision image)) PRECISION-FLOAT-LINEAR)""",
            # A retouched pixel counts: red where the crown is
            opening +
            f"""(gimp-context-set-foreground '(255 0 0))
            (gimp-image-select-rectangle image CHANNEL-OP-REPLACE 230 250 12 12)
            (gimp-edit-fill (active image) FILL-FOREGROUND)
            (gimp-selection-none image)
            (save image {relight_call(to="17:00")} "{retouched}")""")
        self.assertEqual(first[0], "Relit 17:00 / Tree 17:00 / Shadow 17:00")
        self.assertEqual(first[1], "#t #t 0 1")
        self.assertEqual(first[2], "1 1")
        self.assertEqual(Png(untouched).samples, Png(as_opened).samples)
        self.assertEqual(again, ["Relit 2011-09-23 16:00 1", "1", "3 1"])
        self.assertEqual(precise, ["250"])  # PRECISION-U16-GAMMA
        self.assertEqual(len(set(float_one[0].split())), 1)

        relit = RelightCase.done(self, "hour", capture, "--view", "view_00", "--to", "17:00",
                                 "-o", self.folder / "hour.png",
                                 "--shadow", self.folder / "hour_shadow.png")
        self.assertEqual(relit.code, 0)
        theirs = Png(self.folder / "hour.png")
        self.assertSamePictures(Png(tree), theirs)
        self.assertEqual(Png(deep).bits, 16)
        self.assertSamePictures(Png(deep), theirs)
        self.assertSamePictures(Png(shadow), Png(self.folder / "hour_shadow.png"))
        red = Png(retouched).at(236, 256)
        self.assertGreater(red[0], 5 * red[1] + 50)


class ACutOut(InGimp):
    def test_lit_from_and_by_the_clock(self):
        photo = tree_png(self.folder / "cut_out.png", 96, 8)
        sides, clock = self.folder / "sides.png", self.folder / "clock.png"
        masked, adobe = self.folder / "masked.png", self.folder / "adobe.png"
        profile = wide_profile(self.folder / "wide.icc")
        opening = f'(define image (load-picture "{photo}"))\n'
        pasted, timed, profiled, mask = self.done(
            # Pasted into an image without a file, in a group, off its corner
            opening +
            f"""(define other (car (gimp-image-new 300 200 RGB)))
            (define group (car (gimp-layer-group-new other)))
            (gimp-image-insert-layer other group 0 0)
            (define layer (car (gimp-layer-new-from-drawable (active image) other)))
            (gimp-image-insert-layer other layer group 0)
            (gimp-layer-set-offsets layer 40 30)
            (define tree {relight_call(image="other", layer="layer", **SIDES)})
            (define made (car (gimp-item-get-parent tree)))
            (mark (name tree))
            (mark (= (car (gimp-item-get-parent made)) group) (gimp-drawable-offsets tree)
                  (gimp-drawable-offsets (child made 1)) (gimp-drawable-offsets layer))
            (save other tree "{sides}")
            ; What was said of its light stays with the layer
            {relight_call(image="other", layer="layer", to_light="270,25", shadow=False)}
            (mark (car (gimp-image-get-layers other)))""",
            opening +
            f"""(save image {relight_call(to="2011-07-22T17:00", **FACTS)} "{clock}")""",
            # In another profile: it is kept, and what is seen is the same. Three stops darker, so
            # that nothing is cut: that depends on the profile
            opening +
            f"""(gimp-image-convert-precision image PRECISION-U16-GAMMA)
            (gimp-image-convert-color-profile-from-file image "{profile.as_uri()}" 1 FALSE)
            (define kept (car (gimp-image-get-color-profile image)))
            (define tree {relight_call(exposure="-3", **SIDES)})
            (mark (= kept (car (gimp-image-get-color-profile image))) (> kept 0))
            (define plain (car (gimp-image-new-with-precision 96 96 RGB PRECISION-U16-GAMMA)))
            (define copy (car (gimp-layer-new-from-drawable tree plain)))
            (gimp-image-insert-layer plain copy 0 0)
            (save plain copy "{adobe}")""",
            # A mask that hides the left half is a part of the alpha
            opening +
            f"""(define layer (active image))
            (define mask (car (gimp-layer-create-mask layer ADD-MASK-WHITE)))
            (gimp-layer-add-mask layer mask)
            (gimp-image-select-rectangle image CHANNEL-OP-REPLACE 0 0 48 96)
            (gimp-context-set-foreground '(0 0 0))
            (gimp-edit-fill mask FILL-FOREGROUND)
            (gimp-selection-none image)
            (save image {relight_call(layer="layer", **SIDES)} "{masked}")""")
        self.assertEqual(pasted[0], "Tree from the right, 25°")
        self.assertEqual(pasted[1], "#t (40 30) (40 30) (40 30)")
        self.assertEqual(pasted[2], "1")
        self.assertEqual(timed, [])
        self.assertEqual(profiled, ["#t #t"])
        self.assertEqual(mask, [])
        RelightCase.done(self, "hour", photo, "--lit-from", "180,45", "--to-light", "90,25", "-o",
                         self.folder / "hour_sides.png")
        self.assertSamePictures(Png(sides), Png(self.folder / "hour_sides.png"))
        RelightCase.done(self, "hour", photo, "--lit-from", "180,45", "--to-light", "90,25", "-o",
                         self.folder / "hour_darker.png", "--exposure", "-3")
        self.assertSamePictures(Png(adobe), Png(self.folder / "hour_darker.png"))
        words = [w for k, v in FACTS.items() for w in (f"--{k}", v)]
        RelightCase.done(self, "hour", photo, *words, "--to", "17:00", "-o",
                         self.folder / "hour_clock.png")
        self.assertSamePictures(Png(clock), Png(self.folder / "hour_clock.png"))
        half = Png(masked)
        self.assertTrue(all(half.at(x, y)[3] == 0 for x in range(48) for y in range(96)))
        self.assertEqual(half.at(56, 38)[3], 255)


class WrongInput(InGimp):
    def test_each_says_what_and_the_remedy(self):
        cut_out = tree_png(self.folder / "cut_out.png", 48, 8)
        opaque = write_png(self.folder / "opaque.png", 40, 30, 3, lambda x, y: (90, 120, y))
        grey = write_png(self.folder / "grey.png", 40, 30, 1, lambda x, y: (x,))
        before = {f: f.read_bytes() for f in (cut_out, opaque, grey)}
        opening = f'(define image (load-picture "{cut_out}"))\n'
        night = {**FACTS, "to": "2011-07-22T23:00"}
        scripts = (
            (opening + relight_call(**night), ("below the horizon", "05:51", "Date and hour")),
            (opening + relight_call(to="17:00"),
             ("no place", "“Place”", "“Time zone”", "“Taken”", "“Heading”")),
            (opening + relight_call(lit_from="180"), ("“Light in the photo from”", '"180"')),
            (opening + relight_call(**SIDES, exposure="bright"), ("“Exposure”", "bright")),
            (opening + relight_call(to="17:00", to_light="90,25", **FACTS),
             ("“Date and hour”", "one of them")),
            (opening + relight_call(capture=str(self.folder), **SIDES), ("capture.toml",)),
            (opening + relight_call(mode="RUN-WITH-LAST-VALS"), ("nothing to repeat",)),
            (f'(define image (load-picture "{opaque}"))\n' + relight_call(**SIDES),
             ("no transparency", "cut the tree out", "capture's folder")),
            (f'(define image (load-picture "{grey}"))\n' + relight_call(**SIDES),
             ("is grey", "Image > Mode > RGB")),
            (opening +
             f"""(define channel (car (gimp-channel-new image 48 48 "red" 50 '(255 0 0))))
             (gimp-image-insert-channel image channel 0 0)
             """ + relight_call(layer="channel", **SIDES),
             ("red is a channel", "select the layer")),
            (opening + relight_call(**SIDES) + "\n" + relight_call(**SIDES),
             ("result of Relight Tree", "made from")),
            # 12000 x 9000 takes more memory than some computers have, and is refused before work;
            # with the memory, that the layer is empty is what is said
            ("(define image (car (gimp-image-new 12000 9000 RGB)))\n"
             '(define layer (car (gimp-layer-new image 12000 9000 RGBA-IMAGE "huge" 100 0)))\n'
             "(gimp-image-insert-layer image layer 0 0)\n" + relight_call(**SIDES), ("huge",)),
        )
        for message, (_, names) in zip(self.refused(*(s for s, _ in scripts)), scripts):
            for name in names:
                self.assertIn(name, message)
            self.assertNotIn("--", message, "options are the command line's, not the dialog's")
        for file, content in before.items():
            self.assertEqual(file.read_bytes(), content)


class Check(RelightCase):
    """relight gimp --check, beside programs that only answer their version."""

    def program(self, name, words, stream=1, mode=0o755):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"#!/bin/sh\necho '{words}' >&{stream}\n")
        file.chmod(mode)
        return file

    def check(self, code, *names):
        outcome = relight("gimp", "--check", "--json", env={
            "PATH": str(self.folder / "bin"), "GIMP2_DIRECTORY": str(self.folder / "profile"),
            "GIMP2_PLUGINDIR": str(self.folder / "system")})
        self.assertEqual(outcome.code, code, outcome.err)
        self.assertEqual(outcome.json["seen"], code == 0)
        for name in names:
            self.assertIn(str(name), outcome.out)
        return outcome.json

    def test_each_fault_and_its_remedy(self):
        version = self.done("--version").out.split()[1]
        self.check(1, "GIMP is not installed", "apt-get install gimp")
        self.program("bin/gimp", "GNU Image Manipulation Program version 3.0.4")
        self.check(1, "is GIMP 3.0.4", "for 2.10")
        self.program("bin/gimp", "GNU Image Manipulation Program version 2.10.34")
        self.check(1, "no folder", "./bootstrap install", self.folder / "system/plug-ins")
        name = "profile/plug-ins/relight-tree"
        loose = self.program(name, f"relight-tree {version}", 2)
        self.check(1, "not in a folder of its own", "move it")
        loose.unlink()
        plugin = f"{name}/relight-tree"
        self.program(plugin, f"relight-tree {version}", 2, mode=0o644)
        if os.geteuid() != 0 or not os.access(self.folder / plugin, os.X_OK):
            self.check(1, "not executable", "chmod +x")
        self.program(plugin, "error while loading shared libraries: libx.so", 2)
        self.check(1, "does not start", "libx.so")
        self.program(plugin, "relight-tree 0.0.0", 2)
        self.check(1, "version 0.0.0", version)
        self.program(plugin, f"relight-tree {version}", 2)
        found = self.check(0)
        self.assertEqual(found["plugin"], str(self.folder / plugin))
        self.assertEqual((found["version"], found["gimp"]["version"]), (version, "2.10.34"))
        # The last line of the user's own settings says where
        (self.folder / "profile" / "gimprc").write_text(
            '# (plug-in-path "/nowhere")\n(plug-in-path "${gimp_dir}/other")\n')
        found = self.check(1, "no folder")
        self.assertEqual([f["folder"] for f in found["folders"]],
                         [str(self.folder / "profile" / "other")])


if __name__ == "__main__":
    unittest.main()
