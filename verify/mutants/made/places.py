"""Walks the AST of a unit and lists every fault that the operators can make in it."""
import bisect
import hashlib
import re
from dataclasses import dataclass

from clang.cindex import CursorKind as K, StorageClass, TypeKind

import operators
from units import has_faults

FUNCTIONS = {K.FUNCTION_DECL, K.CXX_METHOD, K.CONSTRUCTOR, K.DESTRUCTOR, K.CONVERSION_FUNCTION, K.FUNCTION_TEMPLATE}
LITERALS = {K.INTEGER_LITERAL, K.FLOATING_LITERAL, K.CXX_BOOL_LITERAL_EXPR}
SCOPES = FUNCTIONS | {K.COMPOUND_STMT, K.FOR_STMT, K.CXX_FOR_RANGE_STMT, K.LAMBDA_EXPR, K.IF_STMT, K.WHILE_STMT}
LOOPS = {K.FOR_STMT, K.WHILE_STMT, K.CXX_FOR_RANGE_STMT, K.DO_STMT}
# Constant expressions, and declarations that are no code.
CLOSED = {K.STATIC_ASSERT, K.ENUM_DECL, K.TEMPLATE_NON_TYPE_PARAMETER, K.TEMPLATE_TYPE_PARAMETER, K.TYPE_REF, K.TEMPLATE_REF,
          K.TEMPLATE_TEMPLATE_PARAMETER, K.TYPEDEF_DECL, K.TYPE_ALIAS_DECL, K.STRING_LITERAL, K.GNU_NULL_EXPR}


@dataclass(frozen=True)
class Fault:
    """`text` stands for the bytes begin..end of the file; shape says how: as an expression, as a statement that is left
    out (text is empty), or as one that is put before (begin == end)."""
    path: str
    begin: int
    end: int
    shape: str
    operator: str
    text: str
    original: str
    function: str
    line: int

    def key(self, ordinal):
        """The same after edits elsewhere: nothing of it is a position; `ordinal` counts equal ones of a function."""
        words = "|".join((self.path, self.function, self.operator, normal(self.original), normal(self.text), str(ordinal)))
        return hashlib.sha256(words.encode()).hexdigest()[:12]


def normal(text):
    return re.sub(r"\s+", " ", text).strip()


class Walk:
    """One unit."""

    def __init__(self, unit, read):
        self.unit, self.read = unit, read
        self.found = []
        self.in_macros = 0  # expressions left out because a macro's text is in them
        self.variables = [[]]  # scopes: (name, type)
        self.functions = []

    def run(self, known):
        """The faults of files that are not among `known` yet."""
        for cursor in self.unit.tree.cursor.get_children():
            path = self.unit.path_of(cursor)
            if has_faults(path) and path not in known:
                self.path, self.bytes = path, self.read(path)
                self.lines = [0] + [m.end() for m in re.finditer(rb"\n", self.bytes)]
                self.macros = sorted(self.unit.macros.get(path, []))
                self.visit(cursor, None)
        return self.found

    # --- text

    def extent(self, cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def text(self, begin, end):
        return self.bytes[begin:end].decode()

    def text_of(self, cursor):
        return self.text(*self.extent(cursor))

    def has_macro(self, begin, end):
        """Whether a macro is expanded inside, or around."""
        i = bisect.bisect_left(self.macros, (begin, 0))
        if i < len(self.macros) and self.macros[i][0] < end:
            return True
        return any(b <= begin < e for b, e in self.macros[max(0, i - 4):i])

    def add(self, begin, end, shape, pairs):
        original = self.text(begin, end)
        line = bisect.bisect_right(self.lines, begin)
        function = "::".join(self.functions)
        for operator, text in pairs:
            self.found.append(Fault(self.path, begin, end, shape, operator, text, original, function, line))

    def add_expression(self, cursor, pairs):
        begin, end = self.extent(cursor)
        if self.has_macro(begin, end):
            self.in_macros += 1
        elif end > begin:
            self.add(begin, end, "expression", pairs)

    # --- the walk

    def visit(self, cursor, parent):
        kind = cursor.kind
        if kind in CLOSED or kind.is_attribute():
            return
        if kind in (K.VAR_DECL, K.FIELD_DECL, K.PARM_DECL) and not self.enter_variable(cursor):
            return
        named = kind in FUNCTIONS or kind in (K.NAMESPACE, K.STRUCT_DECL, K.CLASS_DECL, K.CLASS_TEMPLATE)
        if named:
            self.functions.append(cursor.spelling)
        if kind in SCOPES:
            self.variables.append([])
        children = list(cursor.get_children())
        self.expression(cursor, parent, children)
        self.statements(cursor, children)
        if kind in FUNCTIONS:
            self.early_return(cursor, children)
        for i, child in enumerate(children):
            if not self.is_constant(cursor, child, i):
                self.visit(child, cursor)
        if kind in SCOPES:
            self.variables.pop()
        if named:
            self.functions.pop()

    def enter_variable(self, cursor):
        """False: its initialiser is a constant expression, or evaluated as one."""
        if cursor.kind == K.PARM_DECL:
            self.variables[-1].append((cursor.spelling, self.plain_type(cursor)))
            return False  # default arguments
        if cursor.kind == K.FIELD_DECL:
            return True
        begin = cursor.extent.start.offset
        head = self.text(begin, cursor.location.offset)
        local = bool(self.functions) and cursor.semantic_parent.kind in FUNCTIONS | {K.LAMBDA_EXPR}
        if "constexpr" in head or not local or cursor.storage_class == StorageClass.STATIC or "static" in head:
            return False
        self.variables[-1].append((cursor.spelling, self.plain_type(cursor)))
        if cursor.type.is_const_qualified() and not any(
                c.kind in (K.DECL_REF_EXPR, K.CALL_EXPR, K.MEMBER_REF_EXPR) for c in cursor.walk_preorder()):
            return False
        return True

    def plain_type(self, cursor):
        type_ = cursor.type.get_canonical()
        if type_.kind in (TypeKind.LVALUEREFERENCE, TypeKind.RVALUEREFERENCE):
            type_ = type_.get_pointee()
        return type_.spelling.replace("const ", "")

    def is_constant(self, cursor, child, index):
        """Template arguments, array bounds, labels, the condition of `if constexpr`."""
        if child.kind in LITERALS or child.kind == K.UNEXPOSED_EXPR:
            if cursor.kind in (K.DECL_REF_EXPR, K.MEMBER_REF_EXPR, K.TYPE_REF, K.TEMPLATE_REF):
                return True
            begin, end = self.extent(child)
            before = self.bytes[max(0, begin - 40):begin].rstrip()[-1:]
            after = self.bytes[end:end + 40].lstrip()[:1]
            if before == b"[" and after == b"]" and cursor.kind in (K.VAR_DECL, K.FIELD_DECL):
                return True
            if before in (b"<", b",") and after in (b">",) or before == b"<" and after == b",":
                return True
        if cursor.kind == K.CASE_STMT:
            return index == 0
        if cursor.kind == K.IF_STMT and index == 0:
            return "constexpr" in self.text(cursor.extent.start.offset, child.extent.start.offset)
        if cursor.kind in (K.VAR_DECL, K.FIELD_DECL) and cursor.type.kind in (TypeKind.CONSTANTARRAY, ):
            return child.kind.is_expression() and child.extent.end.offset <= self.bytes.find(b"]", cursor.location.offset)
        return False

    # --- expressions

    def converted(self, cursor, parent):
        """The type that an implicit conversion gives an expression, or its own."""
        if parent is not None and parent.kind == K.UNEXPOSED_EXPR and self.extent(parent) == self.extent(cursor):
            return parent.type.get_canonical()
        return cursor.type.get_canonical()

    def expression(self, cursor, parent, children):
        kind = cursor.kind
        if not self.functions:
            return
        if kind in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR) and len(children) == 2:
            self.binary(cursor, parent, children[0], children[1])
        elif kind == K.CALL_EXPR:
            self.call(cursor, children)
        elif kind in LITERALS:
            self.add_expression(cursor, operators.literal(cursor, self.text_of(cursor), self.converted(cursor, parent)))
        elif kind == K.MEMBER_REF_EXPR:
            self.member(cursor)
        elif kind == K.DECL_REF_EXPR:
            self.name(cursor, parent)
        elif kind == K.CONDITIONAL_OPERATOR and children:
            self.add_expression(children[0], operators.condition(self.text_of(children[0])))
        elif kind == K.UNARY_OPERATOR and children and parent is not None:
            self.unary(cursor, parent, children[0])

    def binary(self, cursor, parent, left, right):
        begin, end = self.extent(cursor)
        between = self.text(left.extent.end.offset, right.extent.start.offset)
        symbol = between.strip()
        pairs = list(operators.binary(symbol, self.text_of(left), between, self.text_of(right)))
        outermost = parent is None or parent.kind not in (K.BINARY_OPERATOR, K.PAREN_EXPR)
        if outermost and symbol in ("+", "-", "*", "/", "%", "<<", ">>", "&", "|"):
            pairs += operators.value(cursor, self.text(begin, end))
        self.add_expression(cursor, pairs)

    def unary(self, cursor, parent, operand):
        begin, end = self.extent(cursor)
        text = self.text_of(operand)
        symbol = (self.text(begin, operand.extent.start.offset) + self.text(operand.extent.end.offset, end)).strip()
        if symbol == "!":
            self.add_expression(cursor, [("logical", f"static_cast<bool>({text})")])
        elif symbol == "-" and operand.kind not in LITERALS:
            self.add_expression(cursor, [("arithmetic", f"+{text}")])
        elif symbol in ("++", "--") and parent.kind != K.FOR_STMT:
            other = "--" if symbol == "++" else "++"
            self.add_expression(cursor, [("arithmetic", self.text(begin, end).replace(symbol, other))])

    def call(self, cursor, children):
        if cursor.spelling.startswith("operator") and len(children) == 3:
            left, right = sorted((children[0], children[2]), key=lambda c: c.extent.start.offset)
            if left.extent.end.offset <= right.extent.start.offset:
                between = self.text(left.extent.end.offset, right.extent.start.offset)
                if between.strip() == cursor.spelling[len("operator"):]:
                    self.add_expression(cursor, operators.binary(between.strip(), self.text_of(left), between,
                                                                 self.text_of(right)))
            return
        arguments = list(cursor.get_arguments())
        begin, end = self.extent(cursor)
        if len(arguments) < 2 or self.bytes[end - 1:end] != b")":
            return
        first = arguments[0].extent.start.offset
        callee = self.text(begin, first).rstrip()
        if not callee.endswith("(") or first <= begin:
            return
        typed = [(self.plain_type(a), self.text_of(a)) for a in arguments]
        if all(a.extent.end.offset > a.extent.start.offset for a in arguments):
            name = cursor.spelling or re.split(r"\W", callee[:-1].rstrip())[-1]
            self.add_expression(cursor, operators.call(name, callee[:-1], typed))

    def member(self, cursor):
        begin, end = self.extent(cursor)
        name = cursor.spelling
        if not self.text(begin, end).endswith(name) or cursor.referenced is None:
            return
        head = self.text(begin, end - len(name))
        if name in operators.COMPONENT and head:
            self.add_expression(cursor, [("component", head + operators.COMPONENT[name])])
        elif cursor.referenced.kind == K.FIELD_DECL:
            type_ = self.plain_type(cursor.referenced)
            parent = cursor.referenced.semantic_parent
            names = [f.spelling for f in parent.get_children()
                     if f.kind == K.FIELD_DECL and self.plain_type(f) == type_ and f.spelling]
            self.sibling(cursor, head, name, names)

    def name(self, cursor, parent):
        text = self.text_of(cursor)
        at = cursor.referenced
        if at is None:
            return
        if at.kind in (K.VAR_DECL, K.PARM_DECL) and text == cursor.spelling:
            type_ = self.plain_type(at)
            names = [n for scope in self.variables for n, t in scope if t == type_ and n]
            self.sibling(cursor, "", text, names)
            if at.kind == K.VAR_DECL and "constexpr" in (at.storage_class.name.lower() + self.head_of(at)):
                self.add_expression(cursor, operators.literal(cursor, text, self.converted(cursor, parent)))
        elif cursor.spelling.startswith("memory_order"):
            self.add_expression(cursor, [(op, text.replace(cursor.spelling, other))
                                         for op, other in operators.order_of_memory(cursor.spelling)])

    def head_of(self, declaration):
        path = self.unit.path_of(declaration)
        if path is None:
            return ""
        return self.read(path)[declaration.extent.start.offset:declaration.location.offset].decode()

    def sibling(self, cursor, head, name, names):
        """The next of the same type, in the order of declaration."""
        others = list(dict.fromkeys(names))
        if name in others and len(others) > 1:
            other = others[(others.index(name) + 1) % len(others)]
            self.add_expression(cursor, [("sibling", head + other)])

    # --- statements

    def statements(self, cursor, children):
        kind = cursor.kind
        if kind == K.COMPOUND_STMT:
            for child in children:
                self.statement(child)
        elif kind in LOOPS or kind == K.IF_STMT:
            conditions = [c for c in children if c.kind.is_expression()][:1] if kind != K.CXX_FOR_RANGE_STMT else []
            if kind == K.FOR_STMT:  # init; condition; step
                conditions = [c for c in children[:-1] if c.kind.is_expression() and self.ends_with(c, b";")]
                conditions = conditions[-1:]
            bodies = children[1:] if kind == K.IF_STMT else children[-1:]
            for child in bodies:
                self.statement(child)
            if children and children[0].kind == K.VAR_DECL:
                conditions = []  # a variable that is its own condition
            if conditions and "constexpr" not in self.text(cursor.extent.start.offset, conditions[0].extent.start.offset):
                text = self.text_of(conditions[0])
                pairs = list(operators.condition(text))
                # A loop without end, or the other way round, tells nothing.
                self.add_expression(conditions[0], pairs if kind == K.IF_STMT else pairs[2:])
        elif kind == K.VAR_DECL and children and children[-1].kind.is_expression():
            between = self.text(cursor.location.offset, children[-1].extent.start.offset)
            if between.rstrip().endswith("=") and self.plain_type(cursor) == self.plain_type(children[-1]):
                self.add_expression(children[-1], operators.initial_value(
                    cursor.type.get_canonical().kind, self.text_of(children[-1])))

    def ends_with(self, cursor, symbol):
        return self.bytes[cursor.extent.end.offset:][:40].lstrip().startswith(symbol)

    def statement(self, cursor):
        begin, end = self.extent(cursor)
        macro = any(b == begin and e >= end for b, e in self.macros)
        if macro:
            end = max(e for b, e in self.macros if b == begin)
        simple = cursor.kind in (K.BREAK_STMT, K.CONTINUE_STMT) or (
            cursor.kind == K.RETURN_STMT and not list(cursor.get_children()))
        if not (cursor.kind.is_expression() or simple or macro):
            return
        semicolon = re.match(rb"\s*;", self.bytes[end:end + 100])
        if semicolon is None or (self.has_macro(begin, end) and not macro):
            return
        text = self.text(begin, end)
        if re.match(r"(const|auto|SCOTTY_RETURN|co_return|return\s+\S|SCOTTY_CHECK|\(void\))", text):
            return
        self.add(begin, end + semicolon.end(), "statement", [("barrier" if operators.is_barrier(text) else "statement", "")])

    def early_return(self, function, children):
        """Before the statements of a function's own block, from the second on."""
        body = children[-1] if children else None
        if body is None or body.kind != K.COMPOUND_STMT or function.kind == K.DESTRUCTOR:
            return
        result = function.result_type.get_canonical().kind
        if result in (TypeKind.LVALUEREFERENCE, TypeKind.RVALUEREFERENCE):
            return
        text = "return;" if result == TypeKind.VOID or function.kind == K.CONSTRUCTOR else "return {};"
        for statement in list(body.get_children())[1:]:
            begin = statement.extent.start.offset
            if statement.kind != K.RETURN_STMT and not self.has_macro(begin, begin + 1):
                self.add(begin, begin, "before", [("early-return", text)])
