"""The book's reference of the Python package: signatures and docstrings, read from its sources without importing them."""

import ast
import os
import re

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python", "supercoil")
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def modules():
    """The trees of the package's modules, by name."""
    found = {}
    for name in sorted(os.listdir(PACKAGE)):
        if name.endswith(".py"):
            with open(os.path.join(PACKAGE, name), encoding="utf-8") as file:
                source = file.read()
            found[name[:-3]] = ast.parse(source)
            for node in found[name[:-3]].body:
                node.source = source.splitlines()
    return found


def names_of(tree):
    """The names in `__all__` of a module."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
            return [element.value for element in node.value.elts]
    return []


def prose(node):
    """A docstring as Markdown: reStructuredText's roles and literals are code."""
    text = ast.get_docstring(node) or ""
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


def is_property(node):
    return any(isinstance(mark, ast.Name) and mark.id in ("property", "cached_property") for mark in node.decorator_list)


def signature(node, name):
    """The call of a function, without self."""
    arguments = ast.unparse(node.args)
    arguments = re.sub(r"^(self|cls)(, )?", "", arguments)
    returns = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__init__" else ""
    return f"{name}({arguments}){returns}"


def fields_of(node):
    """The annotated attributes of a class, each after its comments."""
    lines = []
    for part in node.body:
        if isinstance(part, ast.AnnAssign) and not part.target.id.startswith("_"):
            first = part.lineno - 1
            while node.source[first - 1].lstrip().startswith("#:"):
                first -= 1
            lines += [line.replace("#:", "#") for line in node.source[first : part.lineno - 1]]
            default = f" = {ast.unparse(part.value)}" if part.value else ""
            lines.append(f"    {part.target.id}: {ast.unparse(part.annotation)}{default}")
    return lines


def class_section(node, classes):
    """A class: its fields or its call, its docstring, its public methods and properties, those of its bases included."""
    bases = [classes[base.id] for base in node.bases if isinstance(base, ast.Name) and base.id in classes]
    bodies = [part for one in [node, *bases] for part in one.body if isinstance(part, FUNCTIONS)]
    made = next((part for part in bodies if part.name == "__init__"), None)
    head = "\n".join([f"class {node.name}:", *fields_of(node)]) if fields_of(node) else f"class {node.name}"
    if made is not None and not made.args.kwarg:
        head = signature(made, node.name)
    lines = [f"### {node.name}", "", f"```python\n{head}\n```", "", prose(node), ""]
    for part in bodies:
        if not part.name.startswith("_"):
            call = f"{part.name}" if is_property(part) else signature(part, part.name)
            lines += [f"`{call}`", "", prose(part) or "–", ""]
    return lines


def reference():
    """The page."""
    trees = modules()
    public = {"": names_of(trees["__init__"]), "contact": names_of(trees["contact"]), "dna": names_of(trees["dna"])}
    classes = {node.name: node for tree in trees.values() for node in tree.body if isinstance(node, ast.ClassDef)}
    lines = []
    for module, names in public.items():
        places = [trees[module]] if module else [tree for name, tree in trees.items() if name not in public]
        own = {node.name: node for tree in places for node in tree.body if isinstance(node, (ast.ClassDef, *FUNCTIONS))}
        lines += [f"## supercoil{'.' + module if module else ''}", "", prose(trees[module or "__init__"]), ""]
        for name in names:
            node = own.get(name)
            if isinstance(node, ast.ClassDef):
                lines += class_section(node, classes)
            elif node is not None:
                lines += [f"### {name}", "", f"```python\n{signature(node, name)}\n```", "", prose(node), ""]
            elif name not in ("__version__", *public):
                raise ValueError(f"supercoil.{module}.{name} is public, but no class and no function of the package")
    return "\n".join(lines)


if __name__ == "__main__":
    print(reference())
