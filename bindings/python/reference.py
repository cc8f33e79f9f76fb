# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference page of the Python package in Markdown, made from its docstrings and signatures.

Run `python reference.py > ../../docs/reference/python-calls.md` with the package installed. tests/test_reference.py compares.
"""

import inspect

import gnurt

HEAD = """<!-- SPDX-License-Identifier: GPL-3.0-or-later -->
# Python calls

Every public class, method and attribute of the package `gnurt`, from its docstrings. [Python](python.md) explains them
with examples. `bindings/python/reference.py` writes this page.
"""


def page():
    """The text of the page."""
    text = HEAD
    for name in sorted(gnurt.__all__, key=str.lower):
        if name.startswith("_"):
            continue
        member = getattr(gnurt, name)
        text += f"\n## `{name}{signature(member)}`\n{docstring(member)}"
        if inspect.isclass(member):
            for inner in sorted(dir(member)):
                if not inner.startswith("_"):
                    own = inspect.getattr_static(member, inner)
                    of = getattr(member, inner)
                    text += f"\n### `{name}.{inner}{signature(of) if callable(of) else ''}`\n{docstring(own, of)}"
    return text


def signature(member):
    """Its arguments, without the object itself; the text of compiled ones is their own."""
    try:
        found = inspect.signature(member)
    except (TypeError, ValueError):
        return ""
    given = [argument for name, argument in found.parameters.items() if name != "self"]
    return str(found.replace(parameters=given))


def docstring(*members):
    """Its text, a paragraph a line; nothing where there is none."""
    for member in members:
        text = inspect.getdoc(member)
        if text:
            paragraphs = ("\n".join(part.splitlines()) for part in text.strip().split("\n\n"))
            return "\n" + "\n\n".join(paragraphs) + "\n"
    return ""


if __name__ == "__main__":
    print(page(), end="")
