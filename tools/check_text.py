# SPDX-License-Identifier: Apache-2.0
# The rules that plain text shows: first lines, sizes, forbidden words, names, links, READMEs.
import os
import pathlib
import re

CODE = {".h", ".cpp", ".inl"}
SKIPPED_FOLDERS = {".git", "build", "out", "__pycache__", ".cache"}
MAX_FILE_LINES = 500
MAX_FUNCTION_LINES = 60


def files_of(root):
    """Every file of the tree, build outputs left out."""
    root = pathlib.Path(root)
    for folder, names, files in os.walk(root):
        names[:] = sorted(n for n in names if n not in SKIPPED_FOLDERS and not n.startswith("build"))
        yield from (pathlib.Path(folder, name) for name in sorted(files))


def is_code(path):
    return path.suffix in CODE


def comment_prefix(path):
    """What starts a comment line in a file of ours; None where the rules of first lines do not hold."""
    if is_code(path):
        return "//"
    if path.suffix in {".cmake", ".py", ".sh"} or path.name == "CMakeLists.txt":
        return "#"
    if path.parent.name in {"scripts", ".ci"} and not path.suffix:
        return "#"
    return None


def check_first_lines(root):
    """The SPDX line, then one sentence that says what the file is."""
    for path in files_of(root):
        prefix = comment_prefix(path)
        if prefix is None:
            continue
        lines = path.read_text().splitlines()
        if lines and lines[0].startswith("#!"):
            lines = lines[1:]
        if not lines or lines[0] != f"{prefix} SPDX-License-Identifier: Apache-2.0":
            yield f"{path.relative_to(root)}:1: the first line is not '{prefix} SPDX-License-Identifier: Apache-2.0'"
            continue
        comment = ""
        if path.suffix == ".py" and lines[1:] and lines[1].startswith('"""'):
            comment = " " + lines[1].strip('"')
        for line in lines[1:]:
            if not line.startswith(prefix + " "):
                break
            comment += line[len(prefix):]
        if not re.match(r"\s+\S+(\s+\S+)+[.:]", comment):
            yield f"{path.relative_to(root)}:2: no sentence that says what the file is"


def strip_code(text):
    """The same lines without comments, string contents and preprocessor lines."""
    pattern = re.compile(r'R"(\w*)\((?:.|\n)*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*|/\*(?:.|\n)*?\*/'
                         r'|^[ \t]*#(?:\\\n|[^\n])*', re.MULTILINE)

    def blank(match):
        found = match.group(0)
        kept = '""' if found[0] in "\"R" else "0" if found[0] == "'" else ""
        return kept + "\n" * found.count("\n")

    text = re.sub(r"(?<=\d)'(?=\d)", "", text)  # digit separators
    return pattern.sub(blank, text)


def functions_of(text):
    """(name, first line, lines of the body) of every function; nested lambdas belong to theirs."""
    code = strip_code(text)
    scopes, header, line = [], "", 1
    for c in code:
        line += c == "\n"
        if c == "{":
            body = inside_namespace_or_class(scopes) and starts_function(header)
            scope = bool(re.search(r"\b(namespace|class|struct|union|enum|extern)\b[^()]*$", header))
            keeps = inside_namespace_or_class(scopes) and not body and not scope
            name = re.search(r"([\w~:]+|operator\W+)\s*\(", header)
            scopes.append(("body" if body else "scope" if scope else "other", line,
                           name.group(1) if name else "", header if keeps else ""))
            header = ""
        elif c == "}" and scopes:
            kind, first, name, header = scopes.pop()
            if kind == "body":
                yield name, first, line - first + 1
            header += "}" if header else ""
        elif c == ";":
            header = ""
        else:
            header += c


def inside_namespace_or_class(scopes):
    return all(kind == "scope" for kind, *_ in scopes)


def starts_function(header):
    """True if a '{' after this text opens a function's body, not a member's initialiser."""
    text = header.strip()
    if not re.search(r"\)", text) or re.search(r"\b(namespace|class|struct|union|enum)\b[^()]*$", text):
        return False
    if re.search(r"(?<![=!<>])=(?![=])[^()]*$", text):
        return False
    initialisers = re.search(r"\)\s*(?:noexcept\s*)?:(?!:)", text)
    return not initialisers or text[-1] in ")}"


def read_exceptions(root):
    """tools/size_exceptions.txt: 'path [function]: reason' a line."""
    path = pathlib.Path(root, "tools/size_exceptions.txt")
    lines = path.read_text().splitlines() if path.exists() else []
    entries = [line.partition(": ") for line in lines if line.strip() and not line.startswith("#")]
    return {name: reason.strip() for name, _, reason in entries}


def check_sizes(root):
    """Files up to 500 lines, functions up to 60; longer ones have a reason."""
    exceptions, used = read_exceptions(root), set()
    for name, reason in exceptions.items():
        if not reason:
            yield f"tools/size_exceptions.txt: '{name}' has no reason"
    for path in files_of(root):
        if not (is_code(path) or path.suffix == ".py"):
            continue
        name, text = str(path.relative_to(root)), path.read_text()
        lines = text.count("\n")
        if lines > MAX_FILE_LINES:
            used.add(name)
            if name not in exceptions:
                yield f"{name}: {lines} lines, more than {MAX_FILE_LINES}"
        for function, first, length in functions_of(text) if is_code(path) else ():
            if length > MAX_FUNCTION_LINES:
                used.add(f"{name} {function}")
                if f"{name} {function}" not in exceptions:
                    yield f"{name}:{first}: {function} has {length} lines, more than {MAX_FUNCTION_LINES}"
    for name in exceptions.keys() - used:
        yield f"tools/size_exceptions.txt: '{name}' is no longer needed"


FORBIDDEN = [
    (r"\b(TODO|FIXME|XXX)\b", "no notes for later in the tree"),
    (r"^\s*#\s*if\s+0\b", "no code that is switched off"),
    (r"\bDISABLED_|\bGTEST_SKIP\b(?!\(\) << devices\.error\(\))", "no switched-off tests"),  # but where there is no device
    (r"^\s*//(?!/)\s*(.*\w\(.*\);|.*\s=\s.*;|.*\)\s*\{|\}|return\b.*;)\s*$", "commented-out code"),
    (r"(?<![\w.])/(work|home|root|tmp|Users)/", "a path of one machine"),
    (r"\b[Ii]ssue #?\d", "an issue number"),
    (r"\b[Pp]aper 0\d\d\b", "a number for a paper (docs/papers.md has names)"),
]


def check_words(root):
    """No notes for later, switched-off code or tests, machine paths, issue numbers."""
    rules = [(re.compile(pattern), why) for pattern, why in FORBIDDEN]
    for path in files_of(root):
        if path.name in {"check_text.py", "check_test.py"} or path.suffix not in CODE | {
                ".py", ".txt", ".cmake", ".md", ".json", ".sh", ""}:
            continue
        text = path.read_text(errors="replace")
        for number, line in enumerate(text.splitlines(), 1):
            for rule, why in rules:
                if rule.search(line):
                    yield f"{path.relative_to(root)}:{number}: {why}: {line.strip()}"


NAMES = [
    (re.compile(r"^\s*(?:class|struct|union|enum(?: class| struct)?)\s+(?:alignas\([^)]*\)\s*)?([A-Za-z]\w*)\s*(?:final\s*)?[:{]"),
     re.compile(r"[A-Z][A-Za-z0-9]*$"), "types are PascalCase"),
    (re.compile(r"^(?:inline |static )?constexpr [\w:<>, ]+ (\w+)\s*(?:\[[^\]]*\]\s*)?[={]"),
     re.compile(r"k[A-Z0-9]\w*$"), "constants are kName"),
    (re.compile(r"\b(get[A-Z]\w*)\("), re.compile(r"$."), "a name without 'get'"),
]


def check_names(root):
    """File names and the namings that text shows; clang-tidy checks the others."""
    for path in files_of(root):
        name = path.relative_to(root)
        if not is_code(path):
            continue
        if not re.fullmatch(r"[a-z0-9_]+(-inl)?(\.h)?", path.stem):
            yield f"{name}: file names are snake_case"
        for number, line in enumerate(strip_code(path.read_text()).splitlines(), 1):
            for finds, allows, rule in NAMES:
                for found in finds.findall(line):
                    if not allows.match(found):
                        yield f"{name}:{number}: {found}: {rule}"


def check_links(root):
    """Every relative link of every page leads somewhere."""
    for path in files_of(root):
        if path.suffix != ".md":
            continue
        text = re.sub(r"```.*?```|`[^`\n]*`", "", path.read_text(), flags=re.DOTALL)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"(https?|mailto):|#", target):
                continue
            if not (path.parent / target.split("#")[0]).exists():
                yield f"{path.relative_to(root)}: broken link {target}"


def check_readmes(root):
    """Every folder of src/ with code of its own says what lives there (a room's README speaks for its subfolders)."""
    for folder in sorted(pathlib.Path(root, "src").glob("*")):
        if folder.is_dir() and any(map(is_code, folder.rglob("*"))) and not (folder / "README.md").exists():
            yield f"{folder.relative_to(root)}: no README.md"
