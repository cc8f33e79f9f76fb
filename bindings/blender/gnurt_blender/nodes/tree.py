# SPDX-License-Identifier: GPL-3.0-or-later
"""From a node tree to the text of one shader: walks from the output against the links, through groups, reroutes and muted nodes.

Each node becomes statements once; its outputs are variables. Functions of `osl/` are included as far as nodes call them.
"""

import pathlib
import re

NODES = {}
FOLDER = pathlib.Path(__file__).with_name("osl")
TYPES = {"VALUE": "float", "INT": "float", "BOOLEAN": "float", "VECTOR": "vector", "ROTATION": "vector", "RGBA": "color", "SHADER": "closure color"}
# Which type is which, by the first letter that handlers use.
OF_TYPE = {"float": "float", "vector": "vector", "color": "color", "closure color": "closure color"}
MOST_DEPTH = 400


def node(*types):
    """Puts a function into the table of nodes: it takes a `Place` and returns (type, expression) by identifiers of outputs."""

    def put(function):
        for each in types:
            NODES[each] = function
        return function

    return put


def number(x):
    """A number as the language writes it."""
    x = float(x)
    if x != x:
        return "0.0"
    if x in (float("inf"), float("-inf")):
        return "1e30" if x > 0 else "-1e30"
    text = repr(x)
    return f"({text})" if text.startswith("-") else text


def triple(kind, values):
    return f"{kind}({', '.join(number(x) for x in list(values)[:3])})"


class Code:
    """The shader in the making, and what it needs of its surroundings.

    `kind` is "surface", "environment" or "light"; `host` answers for images, matrices and what belongs to an object.
    """

    def __init__(self, kind, host):
        self.kind, self.host = kind, host
        self.lines, self.files, self.parameters = [], [], {}
        self.textures, self.attributes = {}, {}
        # Names of passes that it writes.
        self.aovs = set()
        # Texts of functions that nodes write themselves, by name.
        self.extra = {}
        self.count = 0
        self.made = {}
        self.depth = 0
        self.uses_object = False
        # Whether it moves vertices; then the space of the object is that of points and vectors.
        self.moves = False
        # The normal before vertices moved, in the object's space, while the relief of a surface is computed that has moved.
        self.relief = None

    def warn(self, line):
        self.host.warn(line)

    def need(self, *files):
        """Includes functions."""
        for file in files:
            if file not in self.files:
                text = (FOLDER / f"{file}.h").read_text()
                for other in re.findall(r"^// needs: (\w+)$", text, re.M):
                    self.need(other)
                if file not in self.files:
                    self.files.append(file)

    def var(self, kind, expression):
        """A variable of this value."""
        if re.fullmatch(r"[A-Za-z_]\w*", expression) or (kind == "float" and re.fullmatch(r"\(?-?[\d.]+(e[-+]?\d+)?\)?", expression)):
            return expression
        self.count += 1
        self.lines.append(f"{kind} t{self.count} = {expression};")
        return f"t{self.count}"

    def line(self, text):
        self.lines.append(text)

    def fresh(self):
        self.count += 1
        return f"t{self.count}"

    def attribute(self, kind, name):
        """A parameter that the mesh fills; `name` is what `meshes` computes."""
        known = self.attributes.setdefault((kind, name), f"a{len(self.attributes)}_{re.sub(r'[^A-Za-z0-9]', '_', name)[:40]}")
        return known

    def texture(self, image, user=None):
        """The name of an image in the shader, whether its values are coded as sRGB, and its size; or None. `user` chooses a frame."""
        return self._named(self.host.image(image, user))

    def tiles(self, image):
        """The same of the tiles of an image, by their numbers."""
        return {number: self._named(found) for number, found in self.host.tiles(image).items()}

    def _named(self, found):
        if found is None:
            return None
        name = f"image{found[0]}"
        self.textures[name] = found[0]
        return name, *found[1:]

    def made_texture(self, key, make):
        """The name of a picture in linear light that `make` returns, known by a key."""
        number = self.host.made_image(key, make)
        name = f"image{number}"
        self.textures[name] = number
        return name

    def text(self, name, result):
        """The whole shader; `result` is the closure or statement of its end."""
        kinds = {"surface": "surface", "environment": "environment"}
        declared = []
        for (kind, _), known in self.attributes.items():
            zero = "0" if kind == "float" else f"{kind}(0)"
            declared.append(f"    {kind} {known} = {zero} [[ int interpolated = 1 ]]")
        heads = [(FOLDER / f"{file}.h").read_text() for file in self.files]
        body = "\n".join(f"    {line}" for line in [*self.lines, *result])
        kind = "displacement" if self.moves else kinds[self.kind]
        return "\n".join([*heads, *self.extra.values(), f"{kind} {name} (", ",\n".join(declared), f")\n{{\n{body}\n}}\n"])


class Place:
    """A node where it is used: in a tree, which may be that of a group."""

    def __init__(self, code, tree, node, outer):
        self.code, self.tree, self.node, self.outer = code, tree, node, outer

    def __getattr__(self, name):
        return getattr(self.node, name)

    @property
    def need(self):
        return self.code.need

    @property
    def var(self):
        return self.code.var

    def warn(self, text):
        self.code.warn(f"node '{self.node.name}' of {self.code.host.owner}: {text}")

    def socket(self, identifier):
        for found in self.node.inputs:
            if found.identifier == identifier:
                return found
        return None

    def is_linked(self, identifier):
        found = self.socket(identifier)
        return found is not None and source(self.code, self.tree, found, self.outer) is not None

    def is_constant(self, identifier, value):
        """Whether an input is known to have this value."""
        found = self.socket(identifier)
        if found is None:
            return True
        if self.is_linked(identifier):
            return False
        own = found.default_value
        return all(x == value for x in own) if hasattr(own, "__len__") else own == value

    def value(self, identifier, kind, default=None):
        """The expression of an input, as a type; `default` where nothing is linked and the node takes its own."""
        found = self.socket(identifier)
        if found is None:
            return default if default is not None else ("0.0" if kind == "float" else f"{kind}(0)")
        return socket_value(self.code, self.tree, found, self.outer, kind, default)

    def f(self, identifier, default=None):
        return self.value(identifier, "float", default)

    def v(self, identifier, default=None):
        return self.value(identifier, "vector", default)

    def c(self, identifier, default=None):
        return self.value(identifier, "color", default)

    def shader(self, identifier):
        """A closure, or None if there is none."""
        return self.value(identifier, "closure color", "")  or None

    def normal(self, identifier="Normal"):
        return self.value(identifier, "vector", "N")

    def coordinates(self, identifier="Vector"):
        """Coordinates of a texture; by default generated ones."""
        return self.mapped(self.value(identifier, "vector", None) if self.is_linked(identifier) else self.generated())

    def generated(self):
        return self.code.host.generated(self.code)

    def mapped(self, expression):
        """After the old mapping that textures carry within them."""
        mapping = getattr(self.node, "texture_mapping", None)
        if mapping is None:
            return expression
        own = (tuple(mapping.translation), tuple(mapping.rotation), tuple(mapping.scale), mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)
        if own != ((0, 0, 0), (0, 0, 0), (1, 1, 1), "X", "Y", "Z"):
            self.warn("the mapping inside the texture node is not shown; use a Mapping node")
        return expression


def fed_by(socket):
    """The node and the identifier of its output that feed a socket directly, if neither the link nor the node is muted; or None."""
    link = socket.links[0] if socket.is_linked else None
    return None if link is None or link.is_muted or link.from_node.mute else (link.from_node, link.from_socket.identifier)


def source(code, tree, socket, outer):
    """The output that feeds an input: (tree, node, output, outer), or None. Passes reroutes, muted nodes and group borders."""
    for _ in range(MOST_DEPTH):
        if not socket.is_linked:
            return None
        link = next((link for link in socket.links if not link.is_muted and link.is_valid), None)
        if link is None:
            return None
        found, output = link.from_node, link.from_socket
        if found.type == "REROUTE":
            socket = found.inputs[0]
        elif found.mute:
            internal = next((each for each in found.internal_links if each.to_socket == output), None)
            if internal is None:
                return None
            socket = internal.from_socket
        elif found.type == "GROUP_INPUT":
            if outer is None:
                return None
            outer_tree, group, above = outer
            socket = next((each for each in group.inputs if each.identifier == output.identifier), None)
            if socket is None:
                return None
            tree, outer = outer_tree, above
            if not socket.is_linked:
                return ("default", socket)
        elif found.type == "GROUP":
            inner = found.node_tree
            end = inner and next((each for each in inner.nodes if each.type == "GROUP_OUTPUT" and each.is_active_output), None)
            if end is None:
                return None
            socket = next((each for each in end.inputs if each.identifier == output.identifier), None)
            if socket is None:
                return None
            outer = (tree, found, outer)
            tree = inner
            if not socket.is_linked:
                return ("default", socket)
        else:
            return (tree, found, output, outer)
    return None


def socket_value(code, tree, socket, outer, kind, default=None):
    """The expression of an input socket as a type."""
    found = source(code, tree, socket, outer)
    if found is None or found[0] == "default":
        if found is not None:
            socket = found[1]
        if kind == "closure color":
            return default
        # What is inside a group and has no value of its own takes the node's default, too.
        if default is not None and (found is None or socket.hide_value):
            return default
        return constant(socket, kind)
    tree, origin, output, outer = found
    own, expression = outputs(code, tree, origin, outer).get(output.identifier, (None, None))
    if expression is None:
        return default if default is not None else constant(socket, kind)
    return converted(code, expression, own, kind)


def outputs(code, tree, origin, outer):
    """All outputs of a node, computed once at each place where it is used."""
    key = (tree, origin.name, chain(outer))
    if key in code.made:
        return code.made[key]
    place = Place(code, tree, origin, outer)
    handler = NODES.get(origin.type) or NODES.get(origin.bl_idname)
    code.depth += 1
    if handler is None:
        place.warn(f"nodes of type {origin.bl_idname.removeprefix('ShaderNode')} are not shown")
        made = {}
    elif code.depth > MOST_DEPTH:
        place.warn("the tree is too deep")
        made = {}
    else:
        made = handler(place)
    code.depth -= 1
    made = {name: (kind, code.var(kind, expression)) for name, (kind, expression) in made.items()}
    code.made[key] = made
    return made


def chain(outer):
    names = []
    while outer is not None:
        tree, group, outer = outer
        names.append((tree, group.name))
    return tuple(names)


def constant(socket, kind):
    """The value of a socket itself."""
    own = getattr(socket, "default_value", 0.0)
    if isinstance(own, str):
        return "0.0" if kind == "float" else f"{kind}(0)"
    if not hasattr(own, "__len__"):
        return number(own) if kind == "float" else f"{kind}({number(own)})"
    if kind == "float":
        own = list(own)
        grey = 0.2126 * own[0] + 0.7152 * own[1] + 0.0722 * own[2] if socket.type == "RGBA" else sum(own[:3]) / 3
        return number(grey)
    return triple(kind, own)


def converted(code, expression, own, kind):
    """An expression of one type as another, as Cycles does at links."""
    if own == kind:
        return expression
    if kind == "closure color":
        value = "color(0)" if code.host.masks else converted(code, expression, own, "color")
        return code.var("closure color", f"{value} * emission()")
    if own == "closure color":
        return "0.0" if kind == "float" else f"{kind}(0)"
    if kind == "float":
        if own == "color":
            return f"dot(vector({expression}), vector(0.2126, 0.7152, 0.0722))"
        return f"(({expression}[0] + {expression}[1] + {expression}[2]) / 3.0)"
    if own == "float":
        return f"{kind}({expression})"
    return f"{kind}({expression}[0], {expression}[1], {expression}[2])" if not expression.startswith(own) else f"({kind}){expression}"


def compile_tree(code, tree, socket):
    """The closure that feeds a socket of an output node, or None."""
    return socket_value(code, tree, socket, None, "closure color", None)


def light_factor(code, tree, socket):
    """The colour by which the nodes of a light multiply it: that of the emission node at their end."""
    found = source(code, tree, socket, None)
    if found is None or found[0] == "default":
        return None
    tree, origin, _, outer = found
    place = Place(code, tree, origin, outer)
    if origin.type != "EMISSION":
        place.warn("lights show Emission nodes only")
        return None
    return code.var("color", f"{place.c('Color')} * {place.f('Strength')}")
