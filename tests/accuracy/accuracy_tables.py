# SPDX-License-Identifier: Apache-2.0
"""Tables in Markdown of what tests/accuracy/run measured."""
import collections
import dataclasses

FIGURES = ("psnr_low", "corr_low", "contrast", "level", "level off", "corr_high", "colour",
           "ring")
DIGITS = {"psnr_low": 2, "contrast": 2, "level": 2, "level off": 2, "ring": 1}
METHODS = ("nothing", "histogram", "reinhard", "monge-kantorovich", "cabral2011", "default",
           "physics")
RELIT = ("cabral2011", "default", "physics")
# Sun's elevation [deg]; the worst input hours of the paper's Fig. 19 are below 25
ELEVATIONS = ((-90, 15), (15, 25), (25, 35), (35, 50), (50, 90))
# Between where the camera looks and the sun [deg]
ANGLES = ((0, 60), (60, 90), (90, 120), (120, 180))


@dataclasses.dataclass
class Row:
    """One picture's figures."""
    tree: str
    part: str    # "hours", "low sun", "overcast", "large"
    kind: str    # Of input
    method: str
    view: str
    time: str    # Wanted
    figures: dict
    elevation_deg: float = 0.0
    angle_deg: float = 0.0
    source: str = ""  # The hour that was relit, in words


def value(row, figure):
    if figure == "level off":
        return abs(row.figures["level"] - 1)
    return row.figures.get(figure)


def mean(rows, figure):
    """The mean; none when no row has the figure."""
    values = [v for v in (value(row, figure) for row in rows) if v is not None]
    return sum(values) / len(values) if values else None


def text(number, digits, sign=False):
    if number is None:
        return "–"
    shown = f"{number:{'+' if sign else ''}.{digits}f}"
    return shown.replace("-", "−")


def lines_of(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|---" * len(head) + "|",
                      *("| " + " | ".join(row) + " |" for row in rows)])


def grouped(rows, key):
    groups = collections.defaultdict(list)
    for row in rows:
        groups[key(row)].append(row)
    return groups


def in_order(rows, name):
    return list(dict.fromkeys(getattr(row, name) for row in rows))


def means(rows):
    groups = grouped(rows, lambda r: (r.tree, r.kind, r.method))
    table = []
    for tree in in_order(rows, "tree"):
        for kind in in_order(rows, "kind"):
            for method in METHODS:
                if group := groups.get((tree, kind, method)):
                    table.append([tree, kind, method] + [
                        text(mean(group, f), DIGITS.get(f, 3)) for f in FIGURES])
    return lines_of(["tree", "input", "method", *FIGURES], table)


def paired(rows, method, other):
    """Rows of two methods for the same picture."""
    key = lambda r: (r.tree, r.part, r.kind, r.view, r.time, r.source)
    others = {key(r): r for r in rows if r.method == other}
    return [(r, others[key(r)]) for r in rows if r.method == method and key(r) in others]


def gains(rows):
    """Each tree against the paper and against histogram transfer, and the spread of trees."""
    head = ["tree", "input", "method", "psnr_low [dB]", "corr_low", "corr_high", "ring [dB]",
            "colour", "least hour [dB]", "hours better", "over histogram [dB]"]
    table, by_method = [], collections.defaultdict(list)
    for tree in in_order(rows, "tree"):
        for kind in in_order(rows, "kind"):
            here = [r for r in rows if r.tree == tree and r.kind == kind]
            for method in ("default", "physics"):
                pairs = paired(here, method, "cabral2011")
                if not pairs:
                    continue
                ours, theirs = [a for a, _ in pairs], [b for _, b in pairs]
                gain = {f: mean(ours, f) - mean(theirs, f) if mean(ours, f) is not None else None
                        for f in ("psnr_low", "corr_low", "corr_high", "ring", "colour")}
                hours = [(value(a, "psnr_low") - value(b, "psnr_low"), a) for a, b in pairs]
                least, at = min(hours, key=lambda pair: pair[0])
                over = [value(a, "psnr_low") - value(b, "psnr_low")
                        for a, b in paired(here, method, "histogram")]
                table.append([tree, kind, method, text(gain["psnr_low"], 2, True),
                              text(gain["corr_low"], 3, True), text(gain["corr_high"], 3, True),
                              text(gain["ring"], 1, True), text(gain["colour"], 3, True),
                              f"{text(least, 2, True)} ({at.view} {at.time[11:16]})",
                              f"{sum(g > 0 for g, _ in hours)} of {len(hours)}",
                              text(sum(over) / len(over), 2, True) if over else "–"])
                by_method[kind, method].append((gain["psnr_low"], gain["corr_low"], least))
    for (kind, method), trees in by_method.items():
        if len(trees) < 3:
            continue
        for word, pick in (("mean", lambda v: sum(v) / len(v)), ("least", min), ("most", max)):
            psnr, corr, least = (pick(list(column)) for column in zip(*trees))
            table.append([f"{word} of {len(trees)} trees", kind, method, text(psnr, 2, True),
                          text(corr, 3, True), "–", "–", "–", text(least, 2, True), "–", "–"])
    return lines_of(head, table)


def hours(rows, kind):
    """Every hour of every view: psnr_low and corr_low of each method."""
    rows = [r for r in rows if r.kind == kind]
    methods = [m for m in METHODS if m in in_order(rows, "method")]
    table = []
    for (tree, view, time), group in grouped(rows, lambda r: (r.tree, r.view, r.time)).items():
        by = {r.method: r for r in group}
        table.append([tree, view, time[11:16], text(group[0].elevation_deg, 0),
                      text(group[0].angle_deg, 0)] + [
            f"{text(value(by[m], 'psnr_low'), 1)} / {text(value(by[m], 'corr_low'), 2)}"
            if m in by else "–" for m in methods])
    return lines_of(["tree", "view", "hour", "sun [°]", "view–sun [°]", *methods], table)


def bins(rows, kind, attribute, edges, what):
    """Means over the pictures whose attribute lies between edges."""
    rows = [r for r in rows if r.kind == kind]
    methods = [m for m in ("nothing", "histogram", *RELIT) if m in in_order(rows, "method")]
    table = []
    for low, high in edges:
        group = [r for r in rows if low <= getattr(r, attribute) < high]
        if not group:
            continue
        by = grouped(group, lambda r: r.method)
        worst = [value(a, "psnr_low") - value(b, "psnr_low")
                 for a, b in paired(group, "default", "cabral2011")]
        table.append([f"{text(low, 0)} to {text(high, 0)}" if low > -90 else f"below {high}",
                      str(max(len(g) for g in by.values()))] + [
            f"{text(mean(by[m], 'psnr_low'), 2)} / {text(mean(by[m], 'corr_low'), 3)}"
            for m in methods] + [text(min(worst), 2, True) if worst else "–"])
    return lines_of([what, "pictures", *methods, "least hour against cabral2011 [dB]"], table)


def low_sun(rows):
    """The same pictures from the usual input hour and from one under a low sun."""
    rows_of = grouped([r for r in rows if r.part == "low sun"],
                      lambda r: (r.tree, r.view, r.source))
    table = []
    for (tree, view, source), group in rows_of.items():
        for method in (m for m in METHODS if m in in_order(group, "method")):
            low = [r for r in group if r.method == method]
            times = {r.time for r in low}
            usual = [r for r in rows if r.part == "hours" and r.kind == "clean" and
                     (r.tree, r.view, r.method) == (tree, view, method) and r.time in times]
            matched = {r.time for r in usual}
            low = [r for r in low if r.time in matched]
            if not low:
                continue
            both = lambda group: (f"{text(mean(group, 'psnr_low'), 2)} / "
                                  f"{text(mean(group, 'corr_low'), 3)}")
            cost = mean(usual, "psnr_low") - mean(low, "psnr_low")
            table.append([tree, view, source, method, str(len(low)), both(usual), both(low),
                          text(cost, 2, True), text(mean(low, "contrast"), 2)])
    return lines_of(["tree", "view", "low input", "method", "hours", "from the usual input",
                     "from the low one", "costs [dB]", "contrast"], table)


def plain(rows, figures):
    """A line a picture and method."""
    rows = sorted(rows, key=lambda r: (r.tree, r.view, r.source, r.time, METHODS.index(r.method)))
    table = [[r.tree, r.view, r.source, r.time[11:16], r.method] + [
        text(value(r, f), DIGITS.get(f, 3)) for f in figures] for r in rows]
    return lines_of(["tree", "view", "from", "to", "method", *figures], table)


def write_between(page, name, content):
    """The page with `content` between its markers "<!-- name -->" and "<!-- /name -->"."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    head, rest = page.split(begin, 1)
    return head + begin + "\n" + content + "\n" + end + rest.split(end, 1)[1]


def missing_markers(page, names):
    return [n for n in names if not 0 <= page.find(f"<!-- {n} -->") < page.find(f"<!-- /{n} -->")]
