#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Panoramas as skies, drawn and read again; what stands beside the tree."""
import struct
import unittest

from relight_runner import Exr, Png, RelightCase, made_capture

WHERE = ("--place", "40.35,-74.65", "--taken", "2011-07-22T17:00-04:00")
LIGHTS = ("sun_normal_lx_rgb", "sun_horizontal_lx_rgb", "sky_horizontal_lx_rgb")


class Panoramas(RelightCase):
    def test_what_is_drawn_is_read_as_the_same_light(self):
        file = self.folder / "sky.exr"
        for sky in ("preetham", "atmosphere", "overcast"):
            drawn = self.done("sky", *WHERE, "--sky", sky, "-o", file, "--json").json
            read = self.done("sky", *WHERE, "--sky", f"panorama:{file}", "--json").json
            self.assertEqual(read["sky"], "panorama:sky.exr")
            whole = [sum(drawn[light][c] for light in LIGHTS[1:]) for c in range(3)]
            for light in LIGHTS:
                for a, b, all_light in zip(drawn[light], read[light], whole):
                    # The glow within a degree of the sun goes over to it: 1.5 % at most
                    self.assertAlmostEqual(a, b, delta=0.015 * max(a, all_light), msg=(sky, light))

    def test_a_picture_to_look_at(self):
        file = self.folder / "sky.png"
        said = self.done("sky", *WHERE, "-o", file).err
        self.assertIn("1 - exp(-L / 2 m)", said)
        png = Png(file)
        self.assertEqual((png.width, png.height, png.channels), (1024, 512, 3))
        self.assertEqual(max(png.samples[-3 * 1024:]), 0)  # Nothing below the horizon
        self.assertGreater(max(png.samples), 0.9 * (2 ** png.bits - 1))  # The sun
        self.refused("sky", *WHERE, "-o", self.folder / "sky.jpg", names=[".exr", ".png"], code=2)

    def radiance_hdr(self, name, width, height, pixel):
        """Radiance .hdr, not compressed; `pixel` gives the four bytes."""
        head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
        file = self.folder / name
        file.write_bytes(head + b"".join(
            struct.pack("4B", *pixel(x, y)) for y in range(height) for x in range(width)))
        return file

    def test_an_hdr_without_unit_or_north(self):
        # A sun of 2^12 in a sky of 1, 45 degrees high, a quarter to the left of the middle
        def pixel(x, y):
            return (128, 128, 128, 141) if (x, y) in ((32, 16), (31, 16)) else (128, 128, 128, 129)
        file = self.radiance_hdr("noon.hdr", 128, 64, pixel)
        outcome = self.done("sky", *WHERE, "--sky", f"panorama:{file}", "--json")
        self.assertIn("is turned", outcome.err)
        self.assertIn("that of the hour", outcome.err)  # The hour's stands lower
        self.assertIn("level of a clear day", outcome.err)
        self.assertAlmostEqual(outcome.json["light_azimuth_deg"], 266.29, delta=0.1)
        self.assertAlmostEqual(outcome.json["light_elevation_deg"], 45, delta=1.5)
        kept = self.done("sky", *WHERE, "--sky", f"panorama:{file}", "--panorama-heading", "180",
                         "--panorama-scale", "1000", "--json").json
        self.assertAlmostEqual(kept["light_azimuth_deg"], 90, delta=0.5)
        # The sky of 1 lights the ground with pi
        self.assertAlmostEqual(kept["sky_horizontal_lx_rgb"][1], 3141.6, delta=10)

    def test_refusals(self):
        flat = self.radiance_hdr("flat.hdr", 96, 64, lambda x, y: (128, 128, 128, 129))
        self.refused("sky", *WHERE, "--sky", f"panorama:{flat}",
                     names=["flat.hdr", "twice as wide as high"])
        gone = self.folder / "gone.exr"
        self.refused("sky", *WHERE, "--sky", f"panorama:{gone}", names=["gone.exr", "no such file"])
        self.refused("sky", *WHERE, "--sky", "panorama:", names=["panorama:FILE"], code=2)
        self.refused("sky", *WHERE, "--panorama-heading", "10", names=["--sky panorama:FILE"],
                     code=2)
        self.refused("sky", *WHERE, "--sky", "preetham", "--ground-albedo", "0.5",
                     names=["--sky atmosphere"], code=2)
        text = self.folder / "text.hdr"
        text.write_text("no picture")
        self.refused("sky", *WHERE, "--sky", f"panorama:{text}", names=["text.hdr"])

    def test_a_tree_under_a_panorama(self):
        capture = self.folder / "maple"
        made_capture(capture)
        sky = self.folder / "evening.exr"
        self.done("sky", *WHERE, "-o", sky)
        drawn, read = self.folder / "drawn.exr", self.folder / "read.exr"
        air = ("--turbidity", "3")  # As `sky` has it; a capture reads its own from the photos
        self.done("hour", capture, "--to", "17:00", "--sky", "preetham", *air,
                  "--no-correction", "-o", drawn)
        answer = self.done("hour", capture, "--to", "17:00", "--sky", f"panorama:{sky}", *air,
                           "--input-sky", "preetham", "-o", read, "--json").json
        self.assertEqual(answer["sky"]["target"], "panorama:evening.exr")
        a, b = Exr(drawn).values(), Exr(read).values()
        # The same light but for the sky's pixels: means of the tree within 1 %
        for channel in "RGB":
            self.assertAlmostEqual(sum(b[channel]) / sum(a[channel]), 1, delta=0.01)


class Neighbours(RelightCase):
    WALL = "v -9 -40 -1\nv -9 40 -1\nv -9 40 25\nv -9 -40 25\nf 1 2 3 4\n"

    def test_a_house_takes_the_evening_sun(self):
        capture, house = self.folder / "maple", self.folder / "house.obj"
        made_capture(capture)
        house.write_text(self.WALL)
        files = ["--irradiance", self.folder / "light.exr", "--components", "--no-correction"]

        def light(*words):
            self.done("hour", capture, "--to", "17:00", *words, *files, "-o", self.folder / "o.png")
            values = Exr(self.folder / "light.exr").values()
            return {part: sum(values[f"target.{part}.G"]) for part in ("sun", "sky")}

        free, behind = light(), light("--occluder", house)
        self.assertGreater(free["sun"], 0)
        self.assertEqual(behind["sun"], 0)
        self.assertLess(behind["sky"], 0.95 * free["sky"])
        self.assertGreater(behind["sky"], 0.4 * free["sky"])
        self.assertEqual(light(), free)  # What is kept in the capture belongs to no house

    def test_refusals(self):
        capture, house = self.folder / "maple", self.folder / "house.obj"
        made_capture(capture)
        house.write_text("v 0 0 0\nf 1 2 3\n")
        self.refused("hour", capture, "--to", "17:00", "--occluder", house,
                     names=["house.obj:2", "vertex 2 of 1"])
        self.refused("hour", capture, "--to", "17:00", "--occluder", "house.ply", names=[".obj"])


class Fit(RelightCase):
    def test_the_photos_own_shading_is_shown_when_it_is_asked(self):
        capture = self.folder / "maple"
        made_capture(capture)
        words = ["hour", capture, "--to", "17:00", "-o", self.folder / "o.png", "--json"]
        self.assertIsNone(self.done(*words).json["fit"])
        answer = self.done(*words, "--fit-light").json
        for part in ("sky", "density"):
            # Four deviations of the prior around the simulation as it is
            self.assertGreater(answer["fit"][part]["times"], 0.3)
            self.assertLess(answer["fit"][part]["times"], 3.4)
        self.assertTrue([n for n in answer["notes"] if "by the photo's own shading" in n])


if __name__ == "__main__":
    unittest.main()
