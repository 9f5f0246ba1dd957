"""Which modules of a package import which others."""

import ast


def list_imports(source):
    """Every module that a source names in an import, also inside functions, and each name after ``from``."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def name_module(file, package):
    """The dotted name of a file, such as ``driftform.cli.app``."""
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def read_imports(package):
    """The modules of a package, and which of the others each imports, itself and its package left out."""
    sources = {name_module(file, package): file.read_text(encoding="utf-8") for file in package.rglob("*.py")}
    found = {}
    for module, source in sources.items():
        whole = {
            name if name in sources else name.rpartition(".")[0]
            for name in list_imports(source)
            if name.split(".")[0] == package.name
        }
        found[module] = {name for name in whole if name in sources} - {module, package.name}
    return found


def find_rooms(imports, package="driftform"):
    """The modules and packages directly in a package, and which of the others each imports."""
    place, rooms = package.count(".") + 1, dict[str, set[str]]()
    for module, names in imports.items():
        if module.startswith(f"{package}."):
            room = module.split(".")[place]
            below = {name.split(".")[place] for name in names if name.startswith(f"{package}.")}
            rooms.setdefault(room, set()).update(below - {room})
    return rooms
