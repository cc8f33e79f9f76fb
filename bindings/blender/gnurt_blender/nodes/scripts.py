# SPDX-License-Identifier: GPL-3.0-or-later
"""Script nodes: shaders of the shading language that users write. Their statements become a block of the material's shader.

What stands before the shader in its text, such as functions, goes before the material's shader. Tests: `tests/checks.py`.
"""

import pathlib
import re

from .tree import node

SOCKETS = {
    "float": "NodeSocketFloat",
    "int": "NodeSocketInt",
    "color": "NodeSocketColor",
    "vector": "NodeSocketVector",
    "point": "NodeSocketVector",
    "normal": "NodeSocketVector",
    "string": "NodeSocketString",
    "closure color": "NodeSocketShader",
}
HEAD = re.compile(r"\b(?:shader|surface|displacement|volume)\s+\w+\s*(?:\[\[.*?\]\]\s*)?\(", re.S)
PARAMETER = re.compile(r"^\s*(output\s+)?(closure\s+color|\w+)\s+(\w+)\s*(\[[^\]]*\])?\s*(?:=(.*))?$", re.S)


class Unreadable(Exception):
    """The text is no shader that can be shown."""


def text_of(script):
    """The text of a Script node, or None."""
    if script.mode == "INTERNAL":
        return script.script.as_string() if script.script else None
    import bpy

    path = pathlib.Path(bpy.path.abspath(script.filepath))
    return path.read_text() if script.filepath and path.is_file() else None


def closing(text, start):
    """Where the bracket that opens at `start` closes; texts and inner brackets are passed."""
    pairs, depth, inside = {"(": ")", "{": "}", "[": "]"}, 0, False
    for at in range(start, len(text)):
        letter = text[at]
        if letter == '"' and text[at - 1] != "\\":
            inside = not inside
        if inside:
            continue
        depth += (letter in pairs) - (letter in pairs.values())
        if depth == 0:
            return at
    raise Unreadable("a bracket does not close")


def split(text):
    """The parts between commas that are in no bracket and no text."""
    parts, depth, inside = [""], 0, False
    for letter in text:
        inside ^= letter == '"'
        depth += 0 if inside else (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0 and not inside:
            parts.append("")
        else:
            parts[-1] += letter
    return [part for part in parts if part.strip()]


def parsed(text):
    """The text before a shader, its parameters (is output, type, name, default), and its statements."""
    plain = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)
    found = HEAD.search(plain)
    if found is None:
        raise Unreadable("it has no shader")
    end = closing(plain, found.end() - 1)
    begin = plain.find("{", end)
    if begin < 0:
        raise Unreadable("its shader has no statements")
    parameters = []
    for part in split(re.sub(r"\[\[.*?\]\]", " ", plain[found.end() : end], flags=re.S)):
        match = PARAMETER.match(part)
        if match is None or match[4]:
            raise Unreadable(f"its parameter '{part.strip()}' is an array or unknown")
        kind = " ".join(match[2].split())
        if kind not in SOCKETS:
            raise Unreadable(f"its parameter '{match[3]}' is of type {kind}")
        parameters.append((bool(match[1]), kind, match[3], (match[5] or "").strip()))
    return plain[: found.start()], parameters, plain[begin + 1 : closing(plain, begin)]


def update(script, report):
    """Gives a Script node the sockets of its shader."""
    text = text_of(script)
    if text is None:
        return
    try:
        _, parameters, _ = parsed(text)
    except Unreadable as why:
        report({"ERROR"}, f"GNU RT: node '{script.name}': {why}")
        return
    for sockets, is_output in ((script.inputs, False), (script.outputs, True)):
        wanted = {name: SOCKETS[kind] for out, kind, name, _ in parameters if out == is_output}
        for socket in [each for each in sockets if wanted.get(each.name) != each.bl_idname]:
            sockets.remove(socket)
        for name, kind in wanted.items():
            if name not in sockets:
                made = sockets.new(kind, name)
                default = next(value for _, _, own, value in parameters if own == name)
                numbers = [float(x) for x in re.findall(r"(?<![\w.])-?\d+\.?\d*(?:[eE][-+]?\d+)?", default)]
                if numbers and not is_output and kind in {"NodeSocketFloat", "NodeSocketInt"}:
                    made.default_value = type(made.default_value)(numbers[0])
                elif numbers and not is_output and kind in {"NodeSocketColor", "NodeSocketVector"}:
                    made.default_value = [*(numbers * 3)[:3], 1.0][: len(made.default_value)]


def statements(p, before, parameters, body):
    """Puts the block into the shader; the variables of its outputs."""
    code = p.code
    if before.strip():
        code.extra[f"script {before}"] = before
    outputs, inner, after = {}, [], []
    for is_output, kind, name, default in parameters:
        zero = '""' if kind == "string" else ("" if kind.startswith("closure") else "0")
        if is_output:
            own = code.fresh()
            code.line(f"{kind} {own}" + (f" = {zero};" if zero else ";"))
            inner.append(f"{kind} {name}" + (f" = {default};" if default else ";"))
            after.append(f"{own} = {name};")
            outputs[name] = (kind, own)
            continue
        inner.append(f"{kind} {name} = {given(p, kind, name, default) or default or zero};")
    # Names of inputs may be those of variables outside: their values are read before.
    code.line("{ " + " ".join(inner))
    code.line(body)
    code.line(" ".join(after) + " }")
    return outputs


def given(p, kind, name, default):
    """What feeds an input, or its own value; None where the shader's default counts."""
    socket = p.node.inputs.get(name)
    if socket is None:
        return None
    linked = p.is_linked(socket.identifier)
    if kind == "string":
        return '"' + socket.default_value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if kind == "closure color":
        return p.shader(socket.identifier)
    # Defaults that are no numbers, such as P or N, are those of the shader.
    if not linked and re.search(r"\b(?!color\b|vector\b|point\b|normal\b|e\d)[A-Za-z_]\w*", default):
        return None
    if kind in {"float", "int"}:
        value = p.var("float", p.f(socket.identifier))
        return f"(int) {value}" if kind == "int" else value
    value = p.var("color", p.c(socket.identifier)) if kind == "color" else p.var("vector", p.v(socket.identifier))
    return value if kind in {"color", "vector"} else f"{kind}({value})"


@node("SCRIPT")
def script(p):
    text = text_of(p.node)
    if text is None:
        p.warn("it has no text")
        return {}
    try:
        before, parameters, body = parsed(text)
    except Unreadable as why:
        p.warn(f"its script is not shown: {why}")
        return {}
    if re.search(r"\breturn\b", body):
        p.warn("its script is not shown: its shader returns early")
        return {}
    kinds = {"int": "float", "point": "vector", "normal": "vector", "string": "float"}
    made = {}
    for name, (kind, own) in statements(p, before, parameters, body).items():
        socket = p.node.outputs.get(name)
        if socket is None or kind == "string":
            continue
        shown = kinds.get(kind, kind)
        made[socket.identifier] = (shown, own if shown == kind else f"({shown}) {own}")
    return made
