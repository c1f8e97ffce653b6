"""The grammar of formulas as people write them (Lark), and what is done to their words before it is applied.

Python's, C's and GLSL's notation, POV-Ray's, Surfer's and MathMod's, and that of printed mathematics as far as it is
unambiguous: implicit products, functions without brackets, bars, superscripts. Which words are names depends on what is
known (`xyz` is a product of three, `sin` is none), so words are told apart here, between Lark's lexer and its parser.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from .formula import FormulaError
from .formula_functions import CONSTANTS, FOREIGN, WRITTEN, function_named

DEEPEST_BRACKETS = 200
LONGEST_QUOTE = 60  # characters of a formula's part in a message

GRAMMAR = r"""
start: definition* condition
definition: DEFINE condition END

?condition: conjunction | condition OR conjunction -> either
?conjunction: negation | conjunction AND negation -> both
?negation: comparison | NOT negation -> complement
?comparison: sum | sum (COMPARED sum)+ -> compared
?sum: term | sum (PLUS | MINUS) term -> sum
?term: factor | term (TIMES | OVER) factor -> product | term power -> implicit
?factor: power | (PLUS | MINUS) factor -> signed
?power: atom | atom RAISED factor -> raised | atom SUPERSCRIPT -> superscript | bare
?atom: NUMBER | VARIABLE | VALUE | FUNCTION exponent? OPEN (condition (COMMA condition)*)? CLOSE -> call
    | OPEN condition CLOSE -> group | BAR_OPEN condition BAR_CLOSE -> absolute
exponent: RAISED MINUS? NUMBER | SUPERSCRIPT
bare: FUNCTION exponent? argument
argument: first (next)*
?first: MINUS first -> signed | plain | bare
?plain: single | single RAISED factor -> raised | single SUPERSCRIPT -> superscript
?single: NUMBER | VARIABLE | VALUE | BAR_OPEN condition BAR_CLOSE -> absolute
?next: plain | OPEN condition CLOSE -> group

NUMBER: /0[xX][0-9a-fA-F]+|([0-9][0-9_]*\.?[0-9_]*|\.[0-9][0-9_]*)([eE][+-]?[0-9]+)?/
NAME.2: /(p|pos)\.[xyz](?![A-Za-z0-9_])|[A-Za-z_\u0370-\u03ff][A-Za-z0-9_\u0370-\u03ff]*/
SUPERSCRIPT: /[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+/
RAISED: "**" | "^" | ".^"
TIMES: /\.?\*|[·×⋅∗]/
OVER: /\.?\/|÷/
PLUS: "+"
MINUS: /[-−–]/
COMPARED: /<=|>=|==|!=|[<>=≤≥≠]/
AND: "&&" | "∧" | "∩" | "&"
NOT: "!" | "¬"
BAR: "|"
ROOT: "√"
OPEN: /[(\[{]/
CLOSE: /[)\]}]/
COMMA: ","
END: ";"
NEWLINE: /\r?\n/
%declare DEFINE OR VARIABLE VALUE FUNCTION BAR_OPEN BAR_CLOSE
// the parser never meets these: what they are to it is decided in between
%ignore /[ \t\u00a0]+/
%ignore NAME
%ignore BAR
%ignore ROOT
%ignore NEWLINE
"""

_LARK = Lark(GRAMMAR, parser="lalr", lexer="basic", propagate_positions=True)
ENDS_OPERAND = {"NUMBER", "VARIABLE", "VALUE", "SUPERSCRIPT", "CLOSE", "BAR_CLOSE"}
GOES_ON = {"PLUS", "MINUS", "TIMES", "OVER", "RAISED", "COMPARED", "AND", "OR", "COMMA", "BAR"}  # a line with one at an end
WORDS = {"and": "AND", "or": "OR", "not": "NOT"}
STARTS_LINE = {"let", "float", "double", "const", "var", "return"}
MEANINGS = {
    "%": "write mod(a, b) for what a division leaves", "@": "", "#": "", "'": "", '"': "", ":": "", "$": "",
    "?": "write min, max, step or mix for a choice", "\\": "write `a and not b` for a difference of solids",
    ".": "a point belongs into a number",
    "~": "write `not` for what is outside of a solid", "∪": "write `or` for a union"}


NO_PARTNER = "a bar without its partner; write `or` for a union, abs(...) for an absolute value"


def at(token) -> str:
    return f"at line {token.line}, column {token.column}"


def syntax_tree(text: str, values: dict[str, float]) -> Tree:
    """Lark's tree of `text`. Raises FormulaError with line, column, what was read and what may have been meant."""
    try:
        words = list(_LARK.lex(text, dont_ignore=True))
    except UnexpectedCharacters as error:
        meaning = MEANINGS.get(error.char, "")
        raise FormulaError(f"has {at(error)} the character {error.char!r}, which means nothing in a formula"
                           + (f"; {meaning}" if meaning else "")) from None
    words = [word for word in words if word.strip() or word.type == "NEWLINE"]
    words = [word for word in words if word.type != "__IGNORE_0"]
    if not any(word.type not in ("NEWLINE", "END") for word in words):
        raise FormulaError("is empty; write f(x, y, z), x^2 + y^2 + z^2 - 1 for instance")
    parser = _LARK.parse_interactive()
    previous = None
    try:
        for word in _with_bars(_lines(words, values)):
            parser.feed_token(word)
            previous = word
        return parser.feed_eof(previous)
    except UnexpectedInput as error:
        raise FormulaError(_unexpected(error, previous)) from None


def _unexpected(error: UnexpectedInput, previous: Token | None) -> str:
    token = error.token if isinstance(error, UnexpectedToken) else None
    if token is None or token.type == "$END":
        last = f" after {str(previous)!r}" if previous is not None else ""
        return f"ends too early, {at(previous)}{last}: a number or x, y, z is missing"
    read = f"has {at(token)} {str(token)!r}" + (f" after {str(previous)!r}" if previous is not None else "")
    if previous is not None and previous.type == "FUNCTION":
        return f"{read}: write the argument of {previous} in brackets"
    if token.type == "CLOSE":
        return f"{read}: " + ("there is no bracket to close" if previous is None or previous.type in ENDS_OPERAND
                              else "a number or x, y, z is missing before it")
    if token.type == "COMMA":
        return f"{read}: commas stand between the arguments of a function only (a decimal point is a point)"
    if token.type == "OVER" and previous is not None and previous.type == "OVER":
        return f"{read}: write floor(a / b) for a whole quotient"
    if token.type == "COMPARED" and str(token) in ("=", "=="):
        return f"{read}: an equation has one = between two formulas"
    if token.type in ("DEFINE", "END"):
        return f"{read}: a line must end before the next begins"
    return f"{read}, where a number or x, y, z should stand" if previous is None or previous.type not in ENDS_OPERAND else (
        f"{read}, where an operation should stand")


# --- lines -------------------------------------------------------------------------------------------------------------
def _lines(words: list[Token], values: dict[str, float]) -> Iterator[Token]:
    """The words of all lines, names told apart; what a line before the last defines is known in those after it."""
    known = _Names(values)
    lines = [line for line in _statements(words) if line]
    for number, line in enumerate(lines):
        while line and line[0].type == "NAME" and str(line[0]) in STARTS_LINE and len(line) > 1 and line[1].type == "NAME":
            line = line[1:]
        if line[0].type == "NAME" and str(line[0]) == "return" and len(line) > 1:
            line = line[1:]
        last = number == len(lines) - 1
        name = line[0]
        of_xyz = "".join(str(word).lower() for word in line[1:8]) == "(x,y,z)"
        head = 8 if of_xyz else 1
        defines = (name.type == "NAME" and len(line) > head and str(line[head]) == "=" and not known.is_coordinate(name))
        if defines and last and (of_xyz or not known.has_meaning(name)):  # f(x, y, z) = ..., d = ...
            line = line[head + 1:]
            if not line:
                raise FormulaError(f"ends too early, {at(name)} after '=': a number or x, y, z is missing")
        elif defines and not last:
            if of_xyz or function_named(name):
                raise FormulaError(f"defines {at(name)} the function {str(name)!r}; helper lines have plain names, "
                                   "r = sqrt(x^2 + y^2) for instance")
            if name in known.values or name in known.helpers:
                raise FormulaError(f"gives {at(name)} {str(name)!r} a second value")
            yield _like(name, "DEFINE", str(name))
            yield from known.told_apart(line[head + 1:])
            known.helpers.add(str(name))
            yield _like(name, "END", ";")
            continue
        elif not last:
            raise FormulaError(f"has {at(name)} a line that is neither the last nor a helper line; write name = ... "
                               "(x, y, z keep their meaning), or one formula only")
        yield from known.told_apart(line)


def _statements(words: list[Token]) -> list[list[Token]]:
    """Lines end at ; and, outside of brackets, at line breaks; an operation before or after a break carries on."""
    lines, depth, opened = [[]], 0, []
    for k, word in enumerate(words):
        if word.type == "OPEN":
            opened.append(word)
            if len(opened) > DEEPEST_BRACKETS:
                raise FormulaError(f"has {at(word)} more than {DEEPEST_BRACKETS} brackets in each other")
        if word.type == "CLOSE":
            if not opened or "([{".index(str(opened[-1])) != ")]}".index(str(word)):
                before = f" after the {str(opened[-1])!r} {at(opened[-1])}" if opened else ""
                raise FormulaError(f"has {at(word)} {str(word)!r}{before}: that bracket does not fit")
            opened.pop()
        depth = len(opened)
        if word.type == "END" and not depth:
            lines.append([])
        elif word.type == "NEWLINE":
            following = next((w for w in words[k + 1:] if w.type != "NEWLINE"), None)
            goes_on = depth or (lines[-1] and lines[-1][-1].type in GOES_ON) or (
                following is not None and (following.type in GOES_ON or str(following).lower() in ("and", "or")))
            if not goes_on:
                lines.append([])
        else:
            lines[-1].append(word)
    if opened:
        raise FormulaError(f"has {at(opened[-1])} {str(opened[-1])!r}, which is not closed")
    return lines


# --- names -------------------------------------------------------------------------------------------------------------
class _Names:
    """What the names of a formula mean."""

    def __init__(self, values: dict[str, float]):
        self.values, self.helpers = values, set()

    def kind(self, name: str) -> str | None:
        if name in self.values or (name in CONSTANTS and name not in self.helpers):
            return "VALUE"
        if name in self.helpers or name.lower() in ("x", "y", "z"):
            return "VARIABLE"
        return "FUNCTION" if function_named(name) else None

    def has_meaning(self, name) -> bool:
        return bool(self.kind(str(name)) or self._ways(str(name)))

    def is_coordinate(self, name) -> bool:
        return str(name).lower() in ("x", "y", "z")

    def told_apart(self, words: Iterable[Token]) -> Iterator[Token]:
        words = list(words)
        for k, word in enumerate(words):
            if word.type == "ROOT":
                yield _like(word, "FUNCTION", "sqrt")
            elif word.type != "NAME":
                yield word
            elif str(word).lower() in WORDS:
                yield _like(word, WORDS[str(word).lower()], str(word))
            elif "." in word:
                yield _like(word, "VARIABLE", str(word)[-1])
            elif kind := self.kind(str(word)):
                yield _like(word, kind, str(word))
            else:
                yield from self._product(word, k + 1 < len(words) and words[k + 1].type == "OPEN")

    def _product(self, word: Token, is_called: bool) -> Iterator[Token]:
        """xyz as x y z, 2pix as 2 pi x, sinx as sin x: where a word is names side by side in one way only."""
        ways = self._ways(str(word))
        if len(ways) != 1:
            read = f"{str(word)[:LONGEST_QUOTE]!r}, which may be {' or '.join(map(' '.join, ways))}; write * between factors"
            raise FormulaError(f"has {at(word)} {read if ways else self._unknown(str(word), is_called)}")
        place = 0
        for name in ways[0]:
            yield Token(self.kind(name), name, word.start_pos + place, word.line, word.column + place, word.line,
                        word.column + place + len(name), word.start_pos + place + len(name))
            place += len(name)

    def _ways(self, text: str) -> list[list[str]]:
        found: dict[int, list[list[str]]] = {len(text): [[]]}
        for start in reversed(range(len(text))):
            found[start] = [[text[start:stop], *rest] for stop in range(start + 1, len(text) + 1)
                            if text[start:stop] != "e" and self.kind(text[start:stop])
                            for rest in found[stop][:2]][:2]
        return found[0] if len(text) <= LONGEST_QUOTE else []

    def _unknown(self, name: str, is_called: bool) -> str:
        quoted = repr(name[:LONGEST_QUOTE])
        names = {**{f.lower(): f for f in WRITTEN}, **{n.lower(): n for n in (*self.values, *self.helpers)}}
        close = FOREIGN.get(name.lower()) or next(iter(difflib.get_close_matches(name.lower(), names, 1, 0.7)), None)
        if is_called:
            return f"the unknown function {quoted}" + (f": did you mean {names.get(close, close)}?" if close else
                                                      f"; known are {', '.join(sorted(WRITTEN))}")
        if close:
            return f"the unknown name {quoted}: did you mean {names.get(close, close)}?"
        digits = name.lstrip("xyzXYZ")
        if digits != name and digits.isdigit():
            return f"the unknown name {quoted}: did you mean {name[:-len(digits)]}^{digits}?"
        if name.lower() in ("t", "time", "i", "u", "v", "w"):
            return f"the unknown name {quoted}: a surface is a formula of x, y, z; give {name} a value in \"parameters\""
        return f"the unknown name {quoted}: give it a value in \"parameters\", or on a line {name[:20]} = ... before the last"


# --- bars --------------------------------------------------------------------------------------------------------------
def _with_bars(words: Iterator[Token]) -> Iterator[Token]:
    """|a| is an absolute value, || between two operands without open bars is `or`."""
    words, opened, ends, skip = list(words), [0], False, False
    for k, word in enumerate(words):
        if skip:
            skip = False
            continue
        if word.type == "BAR":
            double = k + 1 < len(words) and words[k + 1].type == "BAR" and words[k + 1].start_pos == word.end_pos
            if ends and not opened[-1] and double:
                word, skip = _like(word, "OR", "||"), True
            elif ends and opened[-1]:
                opened[-1] -= 1
                word = _like(word, "BAR_CLOSE", "|")
            else:
                opened[-1] += 1
                word = _like(word, "BAR_OPEN", "|")
        elif word.type == "OPEN":
            opened.append(0)
        elif word.type == "CLOSE" or word.type == "END":
            if opened[-1]:
                raise FormulaError(f"has before {at(word)[3:]} {NO_PARTNER}")
            if word.type == "CLOSE":
                opened.pop()
        ends = word.type in ENDS_OPERAND
        yield word
    if opened[-1]:
        raise FormulaError(f"has {NO_PARTNER}")


def _like(token: Token, kind: str, value: str) -> Token:
    return Token.new_borrow_pos(kind, value, token)
