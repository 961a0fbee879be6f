# SPDX-License-Identifier: Apache-2.0
"""Every equation in the code has a row in docs/method.md, and every row its equation.

In comments of relight/ and matting/ (CONTRIBUTING.md says the same for authors):

    [Cabral11, Eq. 10]            one equation of a paper; also Eqs. 7-9, 13
    [Preetham99]                  a paper as a whole, or [Preetham99, Table 2]: needs no row
    (V1)                          an equation of our own: one or two capitals and a number

A key has an entry <a id="cabral11"></a> in docs/bibliography.md. A row of docs/method.md is

    | equation | quantity | header Function | Test.Name, Test.Other |

where the header or its .cpp holds the tag, the header declares Function (or the type), and
each test exists in tests/. The letters of an own tag belong to one stage folder.
"""

import re

from source_tree import CPP, TreeTest, files, run, stage_of, stages

KEY = r"(?:[A-Z][A-Za-z]{2,}\d{2,5}[a-z]?|MR)"
CITATION = re.compile(rf"\[({KEY})(?![A-Za-z0-9])([^\]]*)\]")
OWN = re.compile(r"\(([A-Z]{1,2})(\d+)\)")
TEST = re.compile(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+)\s*,\s*(\w+)\s*\)", re.M)


def comments(text):
    """The comments of C++, with the line each starts on; lines that follow are one."""
    block, start = [], 0
    for number, line in enumerate(text.splitlines() + [""], 1):
        found = re.search(r"//+(.*)", line)
        alone = found and not line[:found.start()].strip()
        if block and not alone:
            yield start, " ".join(block)
            block = []
        if found:
            if not block:
                start = number
            block.append(found.group(1).strip())
    if block:
        yield start, " ".join(block)


def equations(place):
    """'Eqs. 7-9, 13' as ['7', '8', '9', '13']; sections and tables beside them are left out.

    None when it cannot be read.
    """
    result = []
    for part in re.split(r"\s*(?:,|;|\band\b)\s*", place):
        part = re.sub(r"^Eqs?\.\s*", "", part)
        ends = re.split(r"\s*[-–]\s*", part)
        if re.match(r"§|Secs?\.|Sections?\b|Table\b|Fig\.|App\.|p\.", part):
            continue
        if len(ends) == 2 and all(end.isdigit() for end in ends):
            result += [str(n) for n in range(int(ends[0]), int(ends[1]) + 1)]
        elif re.fullmatch(r"(?:[A-Z]\.?)?\d+[a-z]?(?:\.\d+)?", part):
            result.append(part)
        else:
            return None
    return result


def tags(text):
    """Tags, keys and faults of one text: {"[Cabral11, Eq. 7]", "(V1)"}, {"Cabral11"}, […]."""
    found, keys, faults = set(), set(), []
    for citation in CITATION.finditer(text):
        key, rest = citation.group(1), citation.group(2).strip()
        keys.add(key)
        if not re.search(r"\bEqs?\b", rest):
            continue
        listed = equations(rest[1:].strip()) if rest.startswith(",") else None
        if listed:
            found |= {f"[{key}, Eq. {n}]" for n in listed}
        else:
            faults.append(f"write {citation.group(0)} as [{key}, Eq. 3] or "
                          f"[{key}, Eqs. 3-5, 7]")
    found |= {f"({letters}{number})" for letters, number in OWN.findall(text)}
    return found, keys, faults


def code_tags(root, problems):
    """{file: tags} of relight/ and matting/; {tag: "file:line"} of the first of each."""
    by_file, first, keys = {}, {}, {}
    for path in files(root, CPP):
        name = path.relative_to(root).as_posix()
        if not name.startswith(("relight/", "matting/")):
            continue
        by_file[name] = set()
        for line, comment in comments(path.read_text()):
            found, cited, faults = tags(comment)
            problems += [f"{name}:{line}: {fault}" for fault in faults]
            by_file[name] |= found
            for tag in found:
                first.setdefault(tag, f"{name}:{line}")
            for key in cited:
                keys.setdefault(key, f"{name}:{line}")
    return by_file, first, keys


def rows(text):
    for number, line in enumerate(text.splitlines(), 1):
        cells = [cell.strip() for cell in line.strip().split("|")]
        if len(cells) < 3 or cells[0] or cells[-1]:
            continue
        cells = cells[1:-1]
        if cells[0] != "equation" and not re.fullmatch(r":?-+:?", cells[0]):
            yield number, cells


def test_names(root):
    names = set()
    for path in (root / "tests").rglob("*.cpp"):
        names |= {f"{suite}.{name}" for suite, name in TEST.findall(path.read_text())}
    return names


def check_row(root, where, cells, by_file, tests):
    """The problems of one row, and the tags it answers for."""
    if len(cells) != 4:
        return [f"{where}: a row is | equation | quantity | header Function | Test.Name |"], set()
    equation, _, place, named = cells
    answered, _, faults = tags(equation)
    problems = [f"{where}: {fault}" for fault in faults]
    if not answered:
        problems.append(f"{where}: `{equation}` is no tag: [Key, Eq. 3] or (V1)")

    header, _, function = place.partition(" ")
    if not header.endswith(".h") or not (root / header).is_file():
        problems.append(f"{where}: {header or 'no header'} is no header of the project")
    else:
        source = header[:-2] + ".cpp"
        for tag in sorted(answered - by_file.get(header, set()) - by_file.get(source, set())):
            problems.append(f"{where}: {tag} is in no comment of {header} or its .cpp")
        if not function:
            problems.append(f"{where}: name the function after {header}")
        elif not re.search(rf"\b{re.escape(function)}\b", (root / header).read_text()):
            problems.append(f"{where}: {header} does not declare {function}")

    for test in [name.strip() for name in named.split(",")]:
        if test not in tests:
            problems.append(f"{where}: no test {test or '(none named)'} in tests/")
    return problems, {(tag, header) for tag in answered}


def check(root):
    problems = []
    by_file, first, keys = code_tags(root, problems)
    method, bibliography = root / "docs/method.md", root / "docs/bibliography.md"
    method_text = method.read_text() if method.is_file() else ""
    anchors = set(re.findall(r'<a id="([^"]+)"></a>', bibliography.read_text())) \
        if bibliography.is_file() else set()

    for key, where in sorted(keys.items()):
        if key.lower() not in anchors:
            problems.append(f'{where}: [{key}] is not in docs/bibliography.md: add an entry '
                            f'<a id="{key.lower()}"></a>')

    order, tests, answered, homes = stages(root), test_names(root), set(), {}
    for line, cells in rows(method_text):
        found, places = check_row(root, f"docs/method.md:{line}", cells, by_file, tests)
        problems += found
        for tag, header in places:
            answered.add(tag)
            if tag.startswith("("):
                letters = tag.strip("()").rstrip("0123456789")
                homes.setdefault(letters, set()).add(stage_of(header, order) or header)
    for letters, stages_of in sorted(homes.items()):
        if len(stages_of) > 1:
            problems.append(f"docs/method.md: ({letters}n) is used for equations of "
                            f"{' and '.join(sorted(stages_of))}; take other letters for one")

    for tag in sorted(set(first) - answered):
        header = re.sub(r"(\.h|\.cpp):\d+$", ".h", first[tag])
        problems.append(f"{first[tag]}: {tag} has no row in docs/method.md; add\n"
                        f"    | {tag} | what it is | {header} Function | Test.Name |")
    return problems


class SelfTest(TreeTest):
    HEADER = "// Light. [Cabral11, Eqs. 7-8]\n//   a = b      (V1)\ndouble Light();\n"
    ROWS = ("| equation | quantity | header | test |\n|---|---|---|---|\n"
            "| [Cabral11, Eq. 7] | light | relight/sky/light.h Light | Light.Is |\n"
            "| [Cabral11, Eq. 8] | light | relight/sky/light.h Light | Light.Is |\n"
            "| (V1) | b | relight/sky/light.h Light | Light.Is, Light.Was |\n")

    def problems(self, changed=None):
        tree = {"CMakeLists.txt": "set(RELIGHT_STAGES relight/base relight/sky matting)",
                "relight/sky/light.h": self.HEADER, "docs/method.md": self.ROWS,
                "docs/bibliography.md": '<a id="cabral11"></a>Cabral and others\n',
                "tests/relight/sky/light_test.cpp":
                    "TEST(Light, Is) {}\nTEST_F(Light,\n       Was) {}\n"}
        tree.update(changed or {})
        return check(self.tree(tree))

    def test_takes_a_whole_map(self):
        self.assertEqual(self.problems(), [])

    def test_finds_a_tag_without_a_row(self):
        self.assert_one(self.problems({"matting/m.cpp": "int m;  // by (M3)\n"}),
                        "matting/m.cpp:1", "(M3) has no row", "| (M3) | what it is | matting/m.h")

    def test_finds_one_of_a_range_without_a_row(self):
        self.assert_one(self.problems(
            {"matting/m.h": "// as in [Cabral11,\n// Eqs. 8–9]\n"}), "[Cabral11, Eq. 9]")

    def test_finds_a_row_without_a_tag(self):
        self.assert_one(self.problems({"docs/method.md": self.ROWS +
            "| (V2) | c | relight/sky/light.h Light | Light.Is |\n"}), "(V2) is in no comment")

    def test_takes_a_tag_of_the_source_beside_the_header(self):
        self.assertEqual(self.problems({
            "relight/sky/light.cpp": "// (V2)\n", "docs/method.md": self.ROWS +
            "| (V2) | c | relight/sky/light.h Light | Light.Is |\n"}), [])

    def test_finds_a_header_that_is_not_there(self):
        self.assertIn("no header of the project", self.problems({"docs/method.md":
            self.ROWS + "| (V1) | c | relight/sky/dark.h Dark | Light.Is |\n"})[0])

    def test_finds_a_function_that_is_not_there(self):
        self.assert_one(self.problems({"docs/method.md":
            self.ROWS.replace("light.h Light | Light.Is |", "light.h Dark | Light.Is |", 1)}),
            "does not declare Dark")

    def test_finds_a_test_that_is_not_there(self):
        self.assert_one(self.problems({"docs/method.md":
            self.ROWS.replace("Light.Was", "Light.Will")}), "no test Light.Will")

    def test_finds_a_key_that_is_not_there(self):
        self.assert_one(self.problems({"matting/m.h": "// see [Levin08]\n"}),
                        "[Levin08] is not in docs/bibliography.md")

    def test_finds_a_tag_it_cannot_read(self):
        self.assert_one(self.problems({"matting/m.h": "// see [Cabral11 Eq. 7]\n"}),
                        "write [Cabral11 Eq. 7] as [Cabral11, Eq. 3]")

    def test_takes_sections_and_tables_beside_equations(self):
        self.assertEqual(self.problems({"matting/m.h":
            "// [Cabral11, §7.1, Eq. 7], [Cabral11, Eq. 7, Eq. 8, Table 2], [Cabral11]\n"}), [])

    def test_finds_letters_of_two_stages(self):
        self.assert_one(self.problems({"matting/m.h": "// (V2)\nint M();\n", "docs/method.md":
            self.ROWS + "| (V2) | c | matting/m.h M | Light.Is |\n"}), "take other letters")

    def test_does_not_read_code_as_tags(self):
        self.assertEqual(self.problems({"matting/m.h": "int f(V7);  // [i, j] (see V9)\n"}), [])

    def test_finds_a_row_of_another_shape(self):
        self.assert_one(self.problems({"docs/method.md": self.ROWS + "| (V1) | c |\n"}),
                        "a row is")


if __name__ == "__main__":
    run(check, SelfTest)
