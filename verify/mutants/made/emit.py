"""Writes the text of a file with faults in it, each behind its switch; lines stay those of the original."""
import re

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)


def one_line(text):
    """A replacement on one line, without comments; None: that cannot be said of this text."""
    if "#" in text or ('"' in text and "//" in text):
        return None
    return re.sub(r"\s+", " ", COMMENT.sub(" ", text)).strip()


def can_be_written(fault):
    return one_line(fault["text"]) is not None


class Emitter:
    """`faults` of one file, each with its number; begin and end are bytes."""

    def __init__(self, original, faults):
        self.original = original
        nodes = {}
        for fault in faults:
            nodes.setdefault((fault["begin"], -fault["end"], fault["shape"] != "statement", fault["shape"]), []).append(fault)
        # What is put before a statement stands before all that is around the statement.
        self.nodes = sorted(nodes.items(), key=lambda n: (n[0][0], n[0][3] != "before", n[0][1:3]))
        self.parts, self.length = [], 0
        self.ranges = []  # (begin, end, number) in the new text
        self.next = 0
        self.left_out = []  # faults whose places overlap others

    def run(self):
        self.render(0, len(self.original))
        return b"".join(self.parts)

    def put(self, data):
        self.parts.append(data)
        self.length += len(data)

    def render(self, begin, end):
        at = begin
        while self.next < len(self.nodes) and self.nodes[self.next][0][0] < end:
            (first, negative_end, _, shape), faults = self.nodes[self.next]
            last = -negative_end
            self.next += 1
            if first < at or last > end:
                self.left_out += [f["number"] for f in faults]
                continue
            self.put(self.original[at:first])
            start = self.length
            getattr(self, "put_" + shape)(first, last, faults)
            self.ranges += [(start, self.length, f["number"]) for f in faults]
            at = last
        self.put(self.original[at:end])

    def put_expression(self, begin, end, faults):
        for fault in faults:
            start = self.length
            self.put(f"(MADE({fault['number']}) ? ({one_line(fault['text'])}) : ".encode())
            self.ranges.append((start, self.length, fault["number"]))
        self.put(b"(")
        self.render(begin, end)
        self.put(b")" * (len(faults) + 1))

    def put_statement(self, begin, end, faults):
        self.put("".join(f"{{ if (!MADE({f['number']})) " for f in faults).encode())
        self.render(begin, end)
        self.put(b" }" * len(faults))

    def put_instead(self, begin, end, faults):
        for fault in faults:
            self.put(f"if (MADE({fault['number']})) {{ {one_line(fault['text'])} }} else ".encode())
        self.put(b"{ ")
        self.render(begin, end)
        self.put(b" }")

    def put_before(self, begin, end, faults):
        del begin, end
        self.put("".join(f"if (MADE({f['number']})) {f['text']} " for f in faults).encode())


def at_error(text, ranges, line, column):
    """Numbers of the faults that a compiler's error at this place of the new text is about: those of the innermost
    range, or else of the line."""
    lines = text.split(b"\n")
    if line > len(lines):
        return []
    begin = sum(len(one) + 1 for one in lines[:line - 1])
    at = begin + column - 1
    inside = sorted((e - b, number) for b, e, number in ranges if b <= at < e)
    if inside:
        return [number for size, number in inside if size == inside[0][0]]
    end = begin + len(lines[line - 1])
    return [number for b, e, number in ranges if b < end and e > begin]
