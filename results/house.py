#!/usr/bin/env python3
"""What the source is made of, two commits side by side, as a table in Markdown: `results/house.py BEFORE AFTER`.

- lines of each room of `src/`, a moved room under both names
- `pub` items: `pub fn`, `struct`, `enum`, `trait`, `type`, `const`, `static`, `mod`; `pub(…)` is not public
- pages that `cargo doc` of the core has, where DOCS_BEFORE and DOCS_AFTER name the folders `target/doc/gobo`
- three structs that were bags of options, and the five with the most fields, with how many of these are `Option`s
- pairs of files in one room that use each other, and uses of a room by a room below it, by the arrows of today
- `String` fields of the variants of `Error`
- words of the documentation
"""
import collections
import os
import re
import subprocess
import sys


# Structs that were bags of options.
BAGS = ["Grid", "Renderer", "Stage"]


def git(*arguments):
    return subprocess.check_output(["git", *arguments], text=True)


def files(commit, pattern):
    names = [name for name in git("ls-tree", "-r", "--name-only", commit).split("\n") if re.fullmatch(pattern, name)]
    request = "".join(f"{commit}:{name}\n" for name in names)
    answer = subprocess.run(["git", "cat-file", "--batch"], input=request.encode(), stdout=subprocess.PIPE, check=True).stdout
    texts, at = {}, 0
    for name in names:
        end = answer.index(b"\n", at)
        size = int(answer[at:end].split()[2])
        texts[name] = answer[end + 1 : end + 1 + size].decode()
        at = end + 2 + size
    return texts


def without_tests(text):
    """Without the unit tests, which stand at the end of a file."""
    return re.split(r"\n#\[cfg\(test\)\]\n(?:pub(?:\([^)]*\))? )?mod \w+ \{", text)[0]


def room(name):
    parts = name.split("/")
    return parts[1] if len(parts) > 2 else "(top)"


def structs(sources):
    found = []
    for name, text in sources.items():
        for match in re.finditer(r"\bstruct (\w+)(?:<[^>{]*>)?\s*\{\n(.*?)\n\s*\}", text, re.S):
            fields = re.findall(r"^\s*(?:pub(?:\([^)]*\))? )?\w+: (.+?),?$", match[2], re.M)
            found.append((len(fields), sum("Option<" in kind for kind in fields), match[1], name))
    return sorted(found, reverse=True)


def pairs(sources):
    """Files of one room that use each other: a module's own `mod.rs` aside, which only names its parts."""
    modules = {}
    for name in sources:
        path = name[len("src/") : -len(".rs")].removesuffix("/mod")
        modules[path.replace("/", "::")] = name
    uses = collections.defaultdict(set)
    for module, name in modules.items():
        text = re.sub(r"//[^\n]*", "", sources[name])
        for path in re.findall(r"\bcrate::((?:\w+::)*\w+)", text):
            parts = path.split("::")
            while parts and "::".join(parts) not in modules:
                parts.pop()
            other = "::".join(parts)
            if other and other != module and "::" in other:
                uses[module].add(other)
        parent = module.rpartition("::")[0]
        for path in re.findall(r"\bsuper::((?:\w+::)*\w+)", text):
            parts = [*parent.split("::"), *path.split("::")] if parent else path.split("::")
            while parts and "::".join(parts) not in modules:
                parts.pop()
            other = "::".join(parts)
            if other and other != module and "::" in other and not module.startswith(other + "::"):
                uses[module].add(other)
    together = {frozenset((a, b)) for a in uses for b in uses[a] if a in uses.get(b, ()) and a.split("::")[0] == b.split("::")[0]}
    return sum(not any(a.startswith(b + "::") for a in pair for b in pair if a != b) for pair in together)


def measure(commit):
    sources = {name: without_tests(text) for name, text in files(commit, r"src/.*\.rs").items()}
    docs = files(commit, r"(?:docs/.*|README|CONTRIBUTING|CHANGELOG|tests/README)(?:\.md)?")
    lines = collections.Counter()
    for name, text in sources.items():
        lines[room(name)] += text.count("\n")
    public = sum(len(re.findall(r"^\s*pub (?:const |unsafe |async )?(?:fn|struct|enum|trait|type|const|static|mod)\b", text, re.M)) for text in sources.values())
    errors = re.search(r"pub enum Error \{\n(.*?)\n\}", sources["src/error.rs"], re.S)[1]
    text = len(re.findall(r"\bString\b", errors))
    words = sum(len(text.split()) for text in docs.values())
    found = structs(sources)
    bags = {name: (fields, options) for fields, options, name, _ in reversed(found) if name in BAGS}
    return lines, public, (found[:5], bags), pairs(sources), text, words, len(sources)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    before, after = (measure(commit) for commit in sys.argv[1:])
    heads = [git("log", "-1", "--format=%h", commit).strip() for commit in sys.argv[1:]]
    print(f"| | {heads[0]} | {heads[1]} |\n|---|---|---|")
    for name in sorted({*before[0], *after[0]}):
        print(f"| lines of `{name}` | {before[0].get(name, 0) or '–'} | {after[0].get(name, 0) or '–'} |")
    print(f"| lines in all, of files | {sum(before[0].values())}, {before[6]} | {sum(after[0].values())}, {after[6]} |")
    print(f"| `pub` items | {before[1]} | {after[1]} |")
    folders = [os.environ.get(f"DOCS_{which}") for which in ("BEFORE", "AFTER")]
    if all(folders):
        pages = [sum(name.endswith(".html") for _, _, names in os.walk(folder) for name in names) for folder in folders]
        print(f"| pages of `cargo doc`, core | {pages[0]} | {pages[1]} |")
    for name in BAGS:
        row = ["%d, %d" % side[2][1][name] for side in (before, after)]
        print(f"| `{name}`: fields, of them `Option` | {row[0]} | {row[1]} |")
    for which in range(5):
        row = [f"{name} {fields}, {options}" for fields, options, name, _ in (before[2][0][which], after[2][0][which])]
        print(f"| struct {which + 1} by fields: fields, of them `Option` | {row[0]} | {row[1]} |")
    print(f"| pairs of files in a room that use each other | {before[3]} | {after[3]} |")
    print(f"| `String`s in `Error` | {before[4]} | {after[4]} |")
    print(f"| words of the documentation | {before[5]} | {after[5]} |")


main()
