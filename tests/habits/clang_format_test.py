# SPDX-License-Identifier: Apache-2.0
"""The C++ is formatted as .clang-format says, by the one version that decides: 14.

Skipped (exit code 77) where clang-format-14 is not installed.
"""

import pathlib
import re
import shutil
import subprocess
import sys

from source_tree import CPP, TreeTest, files, run

PROGRAM = "clang-format-14"
STYLE = pathlib.Path(__file__).resolve().parents[2] / ".clang-format"


def check(root):
    sources = files(root, CPP)
    if not sources:
        return []
    done = subprocess.run([PROGRAM, f"--style=file:{STYLE}", "--dry-run", *map(str, sources)],
                          capture_output=True, text=True, check=False)
    found = re.findall(r"^(.+?):(\d+):\d+: warning", done.stderr, re.M)
    first = {}
    for name, line in found:
        first.setdefault(name, line)
    problems = [f"{pathlib.Path(name).relative_to(root)}:{line}: mend with {PROGRAM} -i"
                for name, line in first.items()]
    if done.returncode != 0 or (done.stderr and not found):
        problems.append(f"{PROGRAM}: {done.stderr.strip()}")
    return problems


class SelfTest(TreeTest):
    def test_takes_formatted_code(self):
        self.assertEqual(check(self.tree({"cli/a.cpp": "int main() { return 0; }\n"})), [])

    def test_finds_unformatted_code(self):
        self.assert_one(check(self.tree({"cli/a.cpp": "int a;\nint main( ) {return 0 ;}\n"})),
                        "cli/a.cpp:2", "mend")


if __name__ == "__main__":
    if shutil.which(PROGRAM) is None:
        print(f"{PROGRAM} is not installed: formatting is not checked here")
        sys.exit(77)
    run(check, SelfTest)
