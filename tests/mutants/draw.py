"""Small wrong changes of a program text, as a slip of the pen would make them.

A mutant is one change: a comparison or its boundary, an operator, a constant by one, by its sign or
by a factor, two arguments or two returned values in each other's place, a function in place of its
twin (sine and cosine, least and largest), a `not`, a minus or a statement gone, a default another.
What cannot change a result is not drawn: annotations, decorators, words, `strict=` of zip, and the
order of arguments where it does not matter.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

COMPARISONS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "is": ("is not",),
    "is not": ("is",),
    "in": ("not in",),
    "not in": ("in",),
}
OPERATORS = {
    "+": "-",
    "-": "+",
    "*": "/",
    "/": "*",
    "**": "*",
    "//": "/",
    "%": "*",
    "&": "|",
    "|": "&",
    "and": "or",
    "or": "and",
}
TWINS = {
    "min": "max",
    "minimum": "maximum",
    "fmin": "fmax",
    "argmin": "argmax",
    "nanmin": "nanmax",
    "sin": "cos",
    "any": "all",
    "floor": "ceil",
    "degrees": "radians",
    "prepend": "append",
    "arcsin": "arccos",
    "ones": "zeros",
    "first": "last",
    "left": "right",
    "sum": "max",
    "flatnonzero": "argsort",
    "median": "min",
}
TWINS |= {b: a for a, b in reversed(TWINS.items()) if b not in TWINS}
# Where the order of arguments does not matter, or another one is no program at all.
UNSWAPPED = frozenset(
    {
        "min",
        "max",
        "minimum",
        "maximum",
        "hypot",
        "logaddexp",
        "isinstance",
        "getattr",
        "setattr",
        "array",
        "asarray",
        "require",
        "reshape",
        "zeros",
        "ones",
        "full",
        "empty",
        "astype",
        "field",
    }
)
# A tolerance is there to be far from everything: only a thousandfold one is another.
SMALL = 1e-4


@dataclass(frozen=True)
class Mutant:
    """file : as it was named; line : from 1; kind : in words; before, after : the changed line or
    lines, without their indentation; text : the whole file after the change"""

    file: str
    line: int
    kind: str
    before: str
    after: str
    text: str


@dataclass(frozen=True)
class Change:
    """Bytes start to end of a text become `new`."""

    kind: str
    start: int
    end: int
    new: str


def places_of(text: str) -> list[list[Change]]:
    """All that can go wrong in a text, place by place."""
    places: dict[tuple[int, int, str], list[Change]] = {}
    for kind, start, end, new in _changes(ast.parse(text), _Source(text)):
        places.setdefault((start, end, kind), []).append(Change(kind, start, end, new))
    return [places[key] for key in sorted(places)]


def mutant_of(file: str, text: str, change: Change) -> Mutant | None:
    """None where the change says the same, or nothing that Python understands."""
    source = _Source(text)
    changed = source.replaced(change.start, change.end, change.new)
    try:
        if ast.dump(ast.parse(changed)) == ast.dump(ast.parse(text)):
            return None
    except SyntaxError:
        return None
    first, last = source.line_at(change.start), source.line_at(change.end)
    if source.lines[first].strip() == "continue":
        # That word alone would be any of them.
        first -= 1
    rest = len(source.lines) - last - 1
    lines = changed.splitlines()
    after = _plain(lines[first : len(lines) - rest])
    before = _plain(source.lines[first : last + 1])
    return Mutant(file, first + 1, change.kind, before, after, changed)


def _plain(lines: list[str]) -> str:
    return " ".join(line.strip() for line in lines)


class _Source:
    """A text in which ast's positions, bytes of lines, are places."""

    def __init__(self, text: str) -> None:
        self.data = text.encode()
        self.lines = text.splitlines()
        self.starts = [0]
        for line in self.data.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def span(self, node: ast.AST) -> tuple[int, int]:
        begin = self.starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        end = self.starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
        return begin, end

    def of(self, node: ast.AST) -> str:
        begin, end = self.span(node)
        return self.data[begin:end].decode()

    def line_at(self, place: int) -> int:
        return self.data.count(b"\n", 0, place)

    def replaced(self, start: int, end: int, new: str) -> str:
        return (self.data[:start] + new.encode() + self.data[end:]).decode()


Raw = tuple[str, int, int, str]


def _changes(tree: ast.Module, source: _Source) -> Iterator[Raw]:
    for node in _drawn_from(tree):
        match node:
            case ast.Compare():
                for left, right in pairwise([node.left, *node.comparators]):
                    for change in _between(source, left, right, COMPARISONS):
                        yield "comparison", *change
            case ast.BinOp() if not _is_type(node):
                twins = {sign: (other,) for sign, other in OPERATORS.items()}
                for change in _between(source, node.left, node.right, twins):
                    yield "operator", *change
            case ast.BoolOp():
                twins = {sign: (other,) for sign, other in OPERATORS.items()}
                for left, right in pairwise(node.values):
                    for change in _between(source, left, right, twins):
                        yield "operator", *change
            case ast.AugAssign():
                twins = {f"{a}=": (f"{b}=",) for a, b in OPERATORS.items() if len(a) < 3}
                for change in _between(source, node.target, node.value, twins):
                    yield "operator", *change
            case ast.Constant():
                for new in _other_constants(node.value):
                    yield "constant", *source.span(node), new
            case ast.UnaryOp(op=ast.Not()):
                yield "not removed", *source.span(node), f"({source.of(node.operand)})"
            case ast.UnaryOp(op=ast.USub()) if not isinstance(node.operand, ast.Constant):
                yield "minus removed", *source.span(node), f"({source.of(node.operand)})"
            case ast.If() | ast.While() | ast.IfExp() if isinstance(
                node.test, ast.Name | ast.Call | ast.Attribute | ast.Subscript
            ):
                yield "condition", *source.span(node.test), f"(not {source.of(node.test)})"
            case ast.Call():
                name = getattr(node.func, "attr", getattr(node.func, "id", ""))
                if name not in UNSWAPPED:
                    yield from _swapped(source, node.args, "arguments swapped")
            case ast.Return(value=ast.Tuple() as values):
                yield from _swapped(source, values.elts, "returned values swapped")
        if isinstance(node, ast.Call):
            yield from _twin(source, node.func)
        if _is_dispensable(node):
            yield "statement removed", *source.span(node), "pass"


def _drawn_from(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a tree that stand for results."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST | type(None)) or child is None:
                continue
            # Positions within f-strings are not to be trusted before Python 3.12.
            if isinstance(child, ast.JoinedStr | ast.Import | ast.ImportFrom):
                continue
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue
            if name == "args" and getattr(getattr(node, "func", None), "attr", "") == "reshape":
                continue
            if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
                continue
            yield child
            yield from _drawn_from(child)


def _between(
    source: _Source, left: ast.AST, right: ast.AST, others: dict[str, tuple[str, ...]]
) -> Iterator[tuple[int, int, str]]:
    """The sign that stands between two nodes, and what may stand there instead."""
    start, end = source.span(left)[1], source.span(right)[0]
    gap = source.data[start:end].decode()
    plain = re.sub(r"#[^\n]*", lambda comment: " " * len(comment.group().encode()), gap)
    found = re.search(r"not\s+in\b|is\s+not\b|\b(?:in|is|and|or)\b|[-<>=!+*/%&|@^]+", plain)
    if found is not None:
        for new in others.get(re.sub(r"\s+", " ", found.group()), ()):
            yield start + found.start(), start + found.end(), new


def _other_constants(value: object) -> list[str]:
    if isinstance(value, bool):
        return [str(not value)]
    if isinstance(value, int):
        return [str(value + 1), f"({value - 1})"]
    if isinstance(value, float):
        factor = 1000.0 if abs(value) < SMALL else 2.0
        others = [value * factor, value / factor, -value] if value else [1.0, -1.0]
        return [f"({other!r})" for other in others]
    return []


def _swapped(source: _Source, values: list[ast.expr], kind: str) -> Iterator[Raw]:
    for a, b in pairwise(values):
        if not isinstance(a, ast.Starred) and not isinstance(b, ast.Starred):
            start, middle, other, end = *source.span(a), *source.span(b)
            gap = source.data[middle:other].decode()
            yield kind, start, end, source.of(b) + gap + source.of(a)


def _twin(source: _Source, function: ast.expr) -> Iterator[Raw]:
    name = getattr(function, "attr", getattr(function, "id", ""))
    if name in TWINS:
        end = source.span(function)[1]
        yield "twin", end - len(name.encode()), end, TWINS[name]


def _is_type(node: ast.BinOp) -> bool:
    """Whether this is a union of types."""
    return isinstance(node.op, ast.BitOr) and any(
        isinstance(side, ast.Constant) or (isinstance(side, ast.Name) and side.id in _TYPES)
        for side in (node.left, node.right)
    )


_TYPES = frozenset(("bool", "int", "float", "str", "bytes", "list", "dict", "tuple", "set"))


def _is_dispensable(node: ast.AST) -> bool:
    """Whether the program would still be one without this statement."""
    match node:
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue():
            return True
        case ast.Assign(targets=[ast.Subscript() | ast.Attribute()]):
            return True
    return False
