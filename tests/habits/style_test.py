# SPDX-License-Identifier: Apache-2.0
"""What the formatter does not see.

- A source file (C++, Python) begins with its SPDX line; a header has #pragma once next.
- No file of code is longer than 1000 lines, no line of it longer than 100 characters.
- No note to oneself is left behind (the three usual words in capitals): an issue holds those.
"""

import re

from source_tree import TreeTest, files, run, text_of

SPDX = re.compile(r"(//|#) SPDX-License-Identifier: Apache-2\.0")
NOTE = re.compile(r"\b(?:TO" + r"DO|FIX" + r"ME|XX" + r"X)\b")
CODE = (".h", ".cpp", ".py", ".cmake", ".in")
MOST_LINES, LONGEST_LINE = 1000, 100


def is_code(path):
    return path.suffix in CODE or path.name in ("CMakeLists.txt", "bootstrap")


def check(root):
    problems = []
    for path in files(root):
        text = text_of(path)
        if text is None:
            continue
        name = path.relative_to(root).as_posix()
        lines = text.splitlines()
        if is_code(path) or path.suffix in (".md", ".toml", ".yaml"):
            for number, line in enumerate(lines, 1):
                note = NOTE.search(line)
                if note:
                    problems.append(f"{name}:{number}: {note.group()}: open an issue instead")
        if not is_code(path):
            continue

        if path.suffix in (".h", ".cpp", ".py"):
            first = 1 if lines and lines[0].startswith("#!") else 0
            if len(lines) <= first or not SPDX.fullmatch(lines[first].strip()):
                problems.append(f"{name}:{first + 1}: begin with the line "
                                "SPDX-License-Identifier: Apache-2.0, as a comment")
        if path.suffix == ".h" and "#pragma once" not in lines[:3]:
            problems.append(f"{name}:2: #pragma once comes right after the SPDX line")
        if len(lines) > MOST_LINES:
            problems.append(f"{name}: {len(lines)} lines, more than {MOST_LINES}; split it")
        for number, line in enumerate(lines, 1):
            if len(line) > LONGEST_LINE:
                problems.append(f"{name}:{number}: {len(line)} characters, more than "
                                f"{LONGEST_LINE}")
    return problems


class SelfTest(TreeTest):
    TOP = "// SPDX-License-Identifier: Apache-2.0\n"

    def test_takes_good_files(self):
        self.assertEqual(check(self.tree({
            "relight/a.h": self.TOP + "#pragma once\n", "relight/a.cpp": self.TOP,
            "tests/a.py": "#!/usr/bin/env python3\n# SPDX-License-Identifier: Apache-2.0\n",
            "docs/a.md": "x" * 500 + "\n"})), [])

    def test_finds_a_missing_licence(self):
        self.assert_one(check(self.tree({"cli/a.cpp": "\n" + self.TOP})), "cli/a.cpp:1", "SPDX")
        self.assert_one(check(self.tree({"cli/a.cpp": ""})), "SPDX")
        self.assert_one(check(self.tree({"tests/a.py": "import re\n"})), "SPDX")

    def test_finds_a_missing_guard(self):
        self.assert_one(check(self.tree({"cli/a.h": self.TOP})), "#pragma once")

    def test_finds_notes(self):
        for word in ("TO" + "DO", "FIX" + "ME", "XX" + "X"):
            self.assert_one(check(self.tree({"cli/a.cpp": self.TOP + f"// {word}: more\n"})),
                            "cli/a.cpp:2", word)
            self.assert_one(check(self.tree({"docs/a.md": word + "\n"})), word)

    def test_finds_a_long_file(self):
        self.assert_one(check(self.tree({"cli/a.cpp": self.TOP + "\n" * 1000})), "1001 lines")

    def test_finds_a_long_line(self):
        self.assert_one(check(self.tree({"CMakeLists.txt": "#" * 101})), "101 characters")


if __name__ == "__main__":
    run(check, SelfTest)
