"""What may go wrong at one place of the AST: pairs of an operator's name and the text that replaces the original.

Operators are those of the literature (Offutt et al. 1996; Mull and PIT use the same), with some for kernels: barriers
and atomics. Text in, text out; the names MADE_... are from made.h.
"""
from clang.cindex import CursorKind, TypeKind

RELATIONAL = {"<": ["<=", ">"], "<=": ["<", ">="], ">": [">=", "<"], ">=": [">", "<="], "==": ["!="], "!=": ["=="]}
ARITHMETIC = {"+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"], "%": ["/"], "<<": [">>"], ">>": ["<<"], "&": ["|"],
              "|": ["&"], "^": ["|"], "+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="], "|=": ["&="], "&=": ["|="],
              "^=": ["|="], "<<=": [">>="], ">>=": ["<<="]}
LOGICAL = {"&&": ["||"], "||": ["&&"]}
TABLES = (("relational", RELATIONAL), ("arithmetic", ARITHMETIC), ("logical", LOGICAL))
COMPONENT = {"x": "y", "y": "z", "z": "x"}
EXTREME = {"min": "max", "max": "min", "fmin": "fmax", "fmax": "fmin", "min_of": "max_of", "max_of": "min_of",
           "fminf": "fmaxf", "fmaxf": "fminf"}
COMMUTATIVE = {"dot": ""}  # products and sums of two numbers are the same either way, to the bit
ATOMICS = {"atomic_add", "atomic_max", "atomic_min", "atomic_min_distance", "fetch_add", "fetch_min"}
BARRIERS = ("SCOTTY_SYNC", "__syncthreads", "__syncwarp", "__threadfence", "barrier", "fence")

FLOATING = {TypeKind.FLOAT, TypeKind.DOUBLE}
WIDE = {TypeKind.SHORT, TypeKind.USHORT, TypeKind.INT, TypeKind.UINT, TypeKind.LONG, TypeKind.ULONG, TypeKind.LONGLONG,
        TypeKind.ULONGLONG}
NUMBERS = FLOATING | WIDE | {TypeKind.UCHAR, TypeKind.SCHAR, TypeKind.CHAR_S, TypeKind.CHAR_U}


def kind_of(cursor):
    return cursor.type.get_canonical().kind


def binary(symbol, left, between, right):
    """`between`: the text from operand to operand, of which the symbol is a part."""
    for name, table in TABLES:
        for other in table.get(symbol, ()):
            yield name, left + between.replace(symbol, other) + right


def literal(cursor, text, wanted):
    """`wanted`: the type that the literal is converted to, or its own."""
    if cursor.kind == CursorKind.CXX_BOOL_LITERAL_EXPR:
        yield "constant", "false" if text == "true" else "true"
    elif wanted.kind in NUMBERS:
        cast = f"static_cast<{wanted.spelling}>"
        yield "constant", f"{cast}({text} + 1)"
        if text.strip("0.ufULF'x") != "":
            yield "constant", f"{cast}({text} - 1)"
        if wanted.kind in FLOATING:
            yield "ulp", f"::scotty::made::one_ulp_up({cast}({text}))"


def condition(text):
    yield "condition", f"!({text})"
    yield "condition", f"((void)({text}), true)"
    yield "condition", f"((void)({text}), false)"


def value(cursor, text):
    """Of an arithmetic expression as a whole."""
    kind = kind_of(cursor)
    if kind in FLOATING:
        yield "ulp", f"::scotty::made::one_ulp_up({text})"
    elif kind in WIDE:
        yield "width", f"::scotty::made::half_as_wide({text})"


def initial_value(kind, text):
    if kind in NUMBERS or kind == TypeKind.BOOL:
        yield "initialisation", f"::scotty::made::unwritten({text})"


def call(name, callee, arguments):
    """`callee`: the text before the arguments' parenthesis; arguments: (type, text)."""
    if name in EXTREME and len(arguments) >= 2:
        head, _, tail = callee.rpartition(name)
        yield "extreme", f"{head}{EXTREME[name]}{tail}(" + ", ".join(text for _, text in arguments) + ")"
    if name in ATOMICS and callee == name and len(arguments) == 2:
        yield "atomic", f"::scotty::made::plain_{name}({arguments[0][1]}, {arguments[1][1]})"
    if name in EXTREME | COMMUTATIVE:
        return  # whose arguments may be swapped
    for i in range(len(arguments) - 1):
        (one, first), (two, second) = arguments[i], arguments[i + 1]
        if one == two and first != second:
            swapped = [text for _, text in arguments]
            swapped[i], swapped[i + 1] = second, first
            yield "arguments", f"{callee}({', '.join(swapped)})"


def order_of_memory(name):
    if name in ("memory_order_acquire", "memory_order_release", "memory_order_acq_rel", "memory_order_seq_cst"):
        yield "memory-order", "memory_order_relaxed"


def is_barrier(text):
    return any(name in text for name in BARRIERS)
