# SPDX-License-Identifier: Apache-2.0
"""Help, man page, completions, and what is said to a command that cannot be understood."""
import re
import shutil
import subprocess
import unittest

from relight_runner import RelightCase

VERBS = ("hour", "day", "init", "cameras", "matte", "volume", "sky", "info", "evaluate",
         "clean", "gimp")


class Help(RelightCase):
    def test_of_the_program(self):
        text = self.done("--help").out
        for verb in VERBS:
            self.assertRegex(text, rf"(?m)^  {verb} +\S")
        self.assertIn("Exit codes: 0 done, 1 input cannot be used, 2 wrong usage, 130 stopped",
                      text)

    def test_of_every_verb(self):
        for verb in VERBS:
            with self.subTest(verb):
                outcome = self.done(verb, "--help")
                self.assertEqual(outcome.err, "")
                self.assertIn(f"Usage: relight {verb}", outcome.out)
                # Every option has a name for its value or none, and says what it is
                options = re.findall(r"(?m)^  (-\S.*)$", outcome.out)
                self.assertGreaterEqual(len(options), 1)
                for line in options:
                    self.assertRegex(line, r"^-\S+( [][A-Z|a-z0-9,.= /]+)? {2,}\S|^-\S+( \S+)*$")

    def test_numbers_have_range_and_default(self):
        text = self.done("hour", "--help").out
        self.assertRegex(text, r"--cells N +voxels .*, 8 to 512 \[100\]")
        self.assertRegex(text, r"--method NAME +.*default or cabral2011 \[default\]")
        self.assertRegex(text, r"--turbidity N +haze.*1\.7 to 10")

    def test_version(self):
        self.assertRegex(self.done("--version").out, r"^relight \d+\.\d+\.\d+\n$")


class WrongUsage(RelightCase):
    def test_exit_code_two_and_one_line(self):
        for words, names in (
                ((), ["relight DIR|PHOTO --to", "--help"]),
                (("hour",), ["source", "relight hour --help"]),
                (("hour", "x.jpg"), ["--to 17:00", "--to-light", "--like"]),
                (("x.jpg", "--to", "17:00", "--to-light", "0,20"), ["--to", "give one"]),
                (("x.jpg", "--tto", "17:00"), ["--tto", "relight hour --help"]),
                (("x.jpg", "--to"), ["--to", "relight hour --help"]),
                (("horu", "x.jpg"), ["\"horu\" is neither a verb", "hour, day, init", "--help"]),
                (("sky",), ["--place", "relight sky --help"]),
                (("sky", "--place", "40,200", "--taken", "2011-07-22T17:00Z"),
                 ["place must be LAT,LON", "40,200"]),
                (("sky", "--place", "40,20", "--taken", "soon"), ["soon", "2011-09-23T17:00"]),
                (("sky", "--place", "40,20", "--taken", "2011-07-22T17:00", "--zone", "Paris/X"),
                 ["Paris/X", "Europe/Paris"]),
                (("sky", "--place", "40,20", "--taken", "2011-07-22T12:00Z", "--turbidity", "99"),
                 ["turbidity", "99", "1.7"]),
                (("info",), ["file", "relight info --help"]),
                (("matte", "x.jpg", "--trimap", "t.png", "--screen", "auto"),
                 ["--trimap", "--screen"]),
                (("completion", "tcsh"), ["tcsh", "bash", "--help"]),
                (("info", "x.jpg", "--threads", "-3"), ["--threads", "-3"])):
            with self.subTest(words):
                message = self.refused(*words, code=2, names=names, cwd=self.folder)
                self.assertEqual(message.count("\n"), 1)

    def test_words_that_are_wrong_for_a_photo(self):
        photo = self.folder / "x.png"
        photo.write_bytes(b"")
        self.refused(photo, "--to", "17:00", "--view", "v", code=2, names=["--view", "capture"])
        self.refused(photo, "--to", "17:00", "--photo", photo, code=2, names=["--photo"])


class Pages(RelightCase):
    def test_man_page(self):
        page = self.done("man").out
        self.assertTrue(page.startswith(".TH RELIGHT 1"))
        for verb in VERBS:
            self.assertIn(f".SH relight {verb}", page)
        self.assertIn("\\-\\-to\\-light", page)
        if not shutil.which("groff"):
            self.skipTest("groff is not there to read the page")
        read = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-K", "utf8"], input=page,
                              capture_output=True, text=True)
        self.assertEqual((read.returncode, read.stderr), (0, ""))
        self.assertIn("--to-light", re.sub(r"\x1b\[[0-9;]*m|.\x08", "", read.stdout))

    def test_completions(self):
        for shell, words in (("bash", ["complete -o filenames -F _relight relight"]),
                             ("zsh", ["#compdef relight"]), ("fish", ["complete -c relight"])):
            with self.subTest(shell):
                text = self.done("completion", shell).out
                for word in [*words, *VERBS, "to-light"]:
                    self.assertIn(word, text)
                if shutil.which(shell):
                    checked = subprocess.run([shell, "-n"], input=text, capture_output=True,
                                             text=True)
                    self.assertEqual((checked.returncode, checked.stderr), (0, ""))

    def test_completion_completes(self):
        text = self.done("completion", "bash").out
        asked = text + ("\nCOMP_WORDS=(relight hour --to-l) COMP_CWORD=2; _relight; "
                        "echo \"${COMPREPLY[@]}\"\n"
                        "COMP_WORDS=(relight vol) COMP_CWORD=1; _relight; echo \"${COMPREPLY[@]}\"")
        answer = subprocess.run(["bash"], input=asked, capture_output=True, text=True,
                                cwd=self.folder)
        self.assertEqual(answer.stdout.split("\n")[:2], ["--to-light", "volume"], answer.stderr)


if __name__ == "__main__":
    unittest.main()
