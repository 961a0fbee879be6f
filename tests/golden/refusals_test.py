# SPDX-License-Identifier: Apache-2.0
"""What cannot be done is said in one message that names the thing and the remedy; exit code 1;
no partial file, nothing lost (RelightCase.refused checks the last three each time)."""
import os
import shlex
import shutil
import unittest

from relight_runner import (SAMPLE, RelightCase, made_capture, relight, small_capture, tree_png,
                            with_exif, write_png)

FACTS = ("--place", "48.85,2.35", "--taken", "2011-07-22T13:00", "--zone", "Europe/Paris",
         "--heading", "SW")
PHOTO = SAMPLE / "photos" / "view_00.jpg"


class OnePhotoLacks(RelightCase):
    def setUp(self):
        super().setUp()
        self.matte = tree_png(self.folder / "tree.png")

    def photo(self, **facts):
        return with_exif(PHOTO, self.folder / "photo.jpg", **facts)

    def test_everything_in_one_message_with_a_command_that_runs(self):
        message = self.refused("tree.png", "--to", "17:00", "--cells", "24", "-o", "a b.png",
                               cwd=self.folder,
                               names=["tree.png", "no capture time in EXIF", "no time zone",
                                      "no place in EXIF", "no heading in EXIF", "--taken", "--zone",
                                      "--place", "--heading"])
        command = shlex.split(message[message.index("relight hour"):])
        self.done(*command[1:], cwd=self.folder)
        self.assertTrue((self.folder / "a b.png").exists())

    def test_no_exif_time(self):
        photo = self.photo(place=(40.35, -74.65), heading=10)
        message = self.refused(photo, "--to", "17:00",
                               names=[photo, "no capture time in EXIF", "--taken", "--zone"])
        self.assertNotIn("no place", message)
        self.assertNotIn("no heading", message)

    def test_time_without_zone(self):
        photo = self.photo(time="2011:07:22 13:00:00", place=(40.35, -74.65), heading=10)
        message = self.refused(photo, "--to", "17:00",
                               names=[photo, "the time has no zone", "--zone Europe/Paris"])
        self.assertNotIn("no capture time", message)

    def test_no_place(self):
        photo = self.photo(time="2011:07:22 13:00:00", offset="-04:00", heading=10)
        message = self.refused(photo, "--to", "17:00",
                               names=[photo, "no place in EXIF", "--place 48.85,2.35"])
        self.assertNotIn("--zone", message)

    def test_no_heading(self):
        photo = self.photo(time="2011:07:22 13:00:00", offset="-04:00", place=(40.35, -74.65))
        message = self.refused(photo, "--to", "17:00",
                               names=[photo, "no heading in EXIF", "--heading SW"])
        self.assertNotIn("no place", message)

    def test_no_matte_and_no_sky_to_make_one_against(self):
        photo = write_png(self.folder / "wall.png", 64, 64, 3,
                          lambda x, y: ((x * 7919 + y * 104729) % 97, 60, 40))
        self.refused(photo, *FACTS, "--to", "17:00",
                     names=[photo, "no tree against sky", "--scribbles", "matte"])

    def test_sun_below_the_horizon_at_the_wanted_hour(self):
        self.refused(self.matte, *FACTS, "--to", "23:30",
                     names=["the wanted hour 2011-07-22T23:30:00+02:00", "below the horizon",
                            "it is up from 06:", "--to"])

    def test_sun_below_the_horizon_at_the_photos_hour(self):
        self.refused(self.matte, *FACTS, "--taken", "2011-07-22T02:00", "--to", "12:00",
                     code=2)  # One option twice is wrong usage
        night = [w.replace("T13:00", "T02:00") for w in FACTS]
        self.refused(self.matte, *night, "--to", "12:00",
                     names=["the photo's hour 2011-07-22T02:00:00+02:00", "below the horizon",
                            "--taken"])

    def test_matte_of_another_size(self):
        photo = self.photo()
        self.refused(photo, *FACTS, "--to", "17:00", "--matte", self.matte,
                     names=[self.matte, "64 x 64", "480 x 600", "at the photo's size"])

    def test_matte_without_tree(self):
        photo = self.photo()
        black = write_png(self.folder / "black.png", 480, 600, 1, lambda x, y: (0,))
        self.refused(photo, *FACTS, "--to", "17:00", "--matte", black,
                     names=[photo, "holds no tree", "--matte"])

    def test_backdrop_without_time(self):
        backdrop = with_exif(PHOTO, self.folder / "backdrop.jpg")
        self.refused(self.matte, *FACTS, "--like", backdrop,
                     names=[backdrop, "no capture time in EXIF", "--to"])


class BadFiles(RelightCase):
    def setUp(self):
        super().setUp()
        self.tree = tree_png(self.folder / "tree.png")
        self.output = self.folder / "result.png"

    def refuse(self, photo, *names):
        self.refused(photo, *FACTS, "--to", "17:00", "--matte", self.tree, "-o", self.output,
                     names=[photo, *names])
        self.assertFalse(self.output.exists())

    def test_truncated_jpeg(self):
        cut = self.folder / "cut.jpg"
        cut.write_bytes(PHOTO.read_bytes()[:60000])
        matte = write_png(self.folder / "m.png", 480, 600, 1, lambda x, y: (255,))
        self.refused(cut, *FACTS, "--to", "17:00", "--matte", matte,
                     names=[cut, "cut off or damaged", "copy it again"])

    def test_truncated_exr(self):
        cut = self.folder / "cut.exr"
        whole = (SAMPLE / "truth" / "view_00_1700.exr").read_bytes()
        cut.write_bytes(whole[:len(whole) // 2])
        self.refused(cut, *FACTS, "--to", "17:00", names=[cut, "cut off or damaged"])

    def test_empty_file(self):
        empty = self.folder / "empty.jpg"
        empty.write_bytes(b"")
        self.refuse(empty, "is empty", "copy it again")

    def test_no_picture(self):
        text = self.folder / "text.jpg"
        text.write_text("this is no picture\n" * 100)
        self.refuse(text, "not a picture", "relight reads JPEG")

    def test_huge_file_of_nothing(self):
        huge = self.folder / "huge.jpg"
        with open(huge, "wb") as f:
            f.truncate(20 << 30)  # Sparse
        outcome = relight(huge, *FACTS, "--to", "17:00", timeout=60)
        huge.unlink()
        self.assertEqual(outcome.code, 1, outcome.err)
        self.assertIn(str(huge), outcome.err)
        self.assertNotIn("error of relight", outcome.err)

    def test_picture_that_claims_to_be_huge(self):
        data = bytearray(self.tree.read_bytes())
        import struct
        import zlib
        data[16:24] = struct.pack(">II", 2_000_000, 2_000_000)
        data[29:33] = struct.pack(">I", zlib.crc32(bytes(data[12:29])))
        huge = self.folder / "huge.png"
        huge.write_bytes(data)
        self.refuse(huge)

    def test_folder_named_like_a_photo(self):
        folder = self.folder / "photo.jpg"
        folder.mkdir()
        self.refuse(folder, "not a capture folder", "relight init")

    def test_missing_photo(self):
        self.refuse(self.folder / "nowhere.jpg", "not there", "give a photo or a capture")

    def test_a_result_is_not_relit_again(self):
        self.done(self.tree, "--lit-from", "30,40", "--to-light=-60,20", "--cells", "24", "-o",
                  self.output)
        self.refused(self.output, *FACTS, "--to", "17:00",
                     names=[self.output, "result of relight", "tree.png"])
        self.refused("init", self.folder / "new", self.output,
                     names=[self.output, "result of relight"])


class BadCaptures(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")
        self.toml = self.capture / "capture.toml"

    def refuse(self, *names, words=(), **how):
        return self.refused(self.capture, "--to", "16:00", *words, names=names, **how)

    def append(self, text):
        self.toml.write_text(self.toml.read_text() + text)

    def test_not_a_capture_folder(self):
        self.refused(self.capture / "photos", "--to", "17:00",
                     names=["photos: not a capture folder", "no capture.toml", "relight init"])

    def test_unknown_view(self):
        self.refuse("no view \"view_99\"", "view_00, view_04, view_08",
                    words=["--view", "view_99"])

    def test_photo_is_gone(self):
        (self.capture / "photos" / "view_04.jpg").unlink()
        self.refuse("view_04.jpg", "not there", "put it back")
        self.refuse("view_04.jpg", "not there", "put it back", words=["--view", "view_04"])

    def test_camera_without_photo(self):
        text = self.toml.read_text()
        self.toml.write_text(text.replace('\n[[view]]\nphoto = "photos/view_08.jpg"\n', ""))
        self.refuse("images.txt", "view_08", "has no photo", "relight init")

    def test_photo_without_camera(self):
        shutil.copy(PHOTO, self.capture / "photos" / "extra.jpg")
        self.append('\n[[view]]\nphoto = "photos/extra.jpg"\n')
        self.refuse("extra.jpg", "photo without camera", words=["--view", "extra"])
        self.refused("cameras", self.capture, "--import", "colmap", SAMPLE / "cameras",
                     names=["cameras without a photo in the capture", "view_01",
                            "photos without a camera in the model: extra", "--matching-only"])
        self.done("cameras", self.capture, "--import", "colmap", SAMPLE / "cameras",
                  "--matching-only")

    def test_no_cameras(self):
        shutil.rmtree(self.capture / "cameras")
        self.refuse("no cameras yet", "relight cameras", "--import PATH")

    def test_matte_of_another_size(self):
        write_png(self.capture / "mattes" / "view_00.png", 48, 60, 1, lambda x, y: (255,))
        self.refuse("view_00.png", "48 x 60", "480 x 600", "at the photo's size")

    def test_matte_of_another_shape(self):
        write_png(self.capture / "mattes" / "view_04.png", 64, 60, 1, lambda x, y: (255,))
        self.refuse("view_04", "64 x 60", "480 x 600", "at the photo's size")

    def test_trimap_of_another_size(self):
        (self.capture / "mattes" / "view_04.png").unlink()
        write_png(self.capture / "trimaps" / "view_04.png", 48, 60, 1, lambda x, y: (255,))
        message = self.refuse("view_04.png", "48 x 60", "480 x 600", "at the photo's size")
        self.assertIn("trimaps", message)

    def test_neither_matte_nor_trimap(self):
        (self.capture / "mattes" / "view_04.png").unlink()
        (self.capture / "trimaps" / "view_04.png").unlink()
        outcome = self.done(self.capture, "--to", "16:00")
        self.assertIn("mattes of 1 photos, against the sky", outcome.err)
        self.assertTrue((self.capture / "mattes" / "view_04.png").exists())

    def test_truncated_photo(self):
        photo = self.capture / "photos" / "view_00.jpg"
        photo.write_bytes(photo.read_bytes()[:60000])
        self.refuse("view_00.jpg", "cut off or damaged")

    def test_damaged_volume(self):
        (self.capture / "volume.vdb").write_bytes(b"no volume")
        self.refuse("volume.vdb")
        self.done(self.capture, "--to", "16:00", "--force")

    def test_capture_toml_errors_name_line_and_remedy(self):
        views = self.toml.read_text()
        for text, line, names in (
                ("place = [1, 2\n", 1, ["mend this line"]),
                ("\nplace = 5\n", 2, ["place must be [latitude, longitude]"]),
                ("place = [95.0, 0.0]\n", 1, ["latitude -90 to 90", "95"]),
                ("zone = \"Europe/Pariss\"\n", 1, ["Europe/Pariss"]),
                ("zone = 2\n", 1, ["zone must be a text in quotes", "Europe/Paris"]),
                ("taken = \"yesterday\"\n", 1, ["yesterday", "2011-09-23T17:00"]),
                ("heading = \"SW\"\n", 1, ["heading must be a number"]),
                ("heading = 700\n", 1, ["heading must be", "0 to 360"]),
                ("# a comment\nzome = \"Europe/Paris\"\n", 2, ["unknown key \"zome\"", "zone"]),
                ("view = 3\n", 1, ["[[view]]"]),
                ("options = 3\n", 1, ["[options]"])):
            with self.subTest(text):
                self.toml.write_text(text)
                self.refuse(f"capture.toml:{line}:", *names)
        for text, names in (
                ("turbidity = 99\n", ["turbidity", "99", "1.7"]),
                ("cells = \"many\"\n", ["cells must be a whole number", "many"]),
                ("turbidty = 3\n", ["unknown option \"turbidty\"", "turbidity"]),
                ("cells = [1]\n", ["an option must be a number"])):
            with self.subTest(text):
                self.toml.write_text(views.split("[options]")[0] + "[options]\n" + text)
                last = len(self.toml.read_text().splitlines())
                self.refuse(f"capture.toml:{last}:", *names)
        for text, names in (
                ("\n[[view]]\nname = \"x\"\n", ["a view without photo", "photo ="]),
                ("\n[[view]]\nphoto = \"photos/view_00.jpg\"\n", ["a second view named"]),
                ("\n[[view]]\nphoto = \"a.jpg\"\ntaken = \"noon\"\n", ["noon"])):
            with self.subTest(text):
                self.toml.write_text(views + text)
                self.refuse("capture.toml:", *names)

    def test_no_view_in_it(self):
        self.toml.write_text("")
        self.refuse("no [[view]] in it", "relight init")


class Outputs(RelightCase):
    def setUp(self):
        super().setUp()
        self.capture = made_capture(self.folder / "maple")

    def refuse(self, output, *names, **how):
        self.refused(self.capture, "--to", "16:00", "-o", output, names=[output, *names], **how)

    def test_an_input_is_never_overwritten(self):
        for name in ("photos/view_00.jpg", "photos/view_04.jpg", "trimaps/view_00.png",
                     "mattes/view_08.png", "photos/../photos/view_00.jpg"):
            with self.subTest(name):
                self.refuse(self.capture / name, "is an input", "-o")

    def test_nor_through_a_link(self):
        link = self.folder / "link.png"
        link.symlink_to(self.capture / "trimaps" / "view_00.png")
        self.refuse(link, "is an input")
        hard = self.folder / "hard.jpg"
        os.link(self.capture / "photos" / "view_00.jpg", hard)
        self.refuse(hard, "is an input")

    def test_nor_the_backdrop_nor_the_matte(self):
        backdrop = self.folder / "backdrop.png"
        shutil.copy(SAMPLE / "trimaps" / "view_00.png", backdrop)
        self.refused(self.capture, "--to", "16:00", "--matte", backdrop, "-o", backdrop,
                     names=[backdrop, "is an input"])

    def test_ratio_and_light_too(self):
        for option in ("--ratio", "--irradiance"):
            self.refused(self.capture, "--to", "16:00", option, self.folder / "x.png", code=2,
                         names=["x.png", ".exr"])
        same = self.folder / "x.exr"
        self.refused(self.capture, "--to", "16:00", "--ratio", same, "-o", same, code=2,
                     names=[same, "two outputs"])

    def test_folder_that_is_not_there(self):
        self.refuse(self.folder / "nowhere" / "x.png", "does not exist", "make it first")

    def test_a_folder(self):
        self.refuse(self.folder, "is a folder", "-o")

    def test_unknown_format(self):
        self.refuse(self.folder / "x.gif", ".png", ".exr", code=2)
        self.refuse(self.folder / "x", ".png", ".exr", code=2)

    @unittest.skipUnless(os.geteuid() == 0, "needs another user to be refused as")
    def test_folder_that_may_not_be_written_as_another_user(self):
        self.folder.chmod(0o755)
        self.refuse(self.folder / "x.png", "Permission denied", "-o", user=65534)

    @unittest.skipIf(os.geteuid() == 0, "the super-user may write anywhere")
    def test_folder_that_may_not_be_written(self):
        closed = self.folder / "closed"
        closed.mkdir(mode=0o555)
        self.refuse(closed / "x.png", "Permission denied", "-o")

    def test_whole_needs_a_background(self):
        tree = tree_png(self.folder / "tree.png")
        self.refused(tree, "--lit-from", "30,40", "--to-light", "90,20", "--cells", "24", "--whole",
                     names=[tree, "no background", "--whole"])


if __name__ == "__main__":
    unittest.main()
