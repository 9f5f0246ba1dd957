"""What an hour of the studio costs: memory and descriptors of the server over 2 000 requests for 20 designs.

By hand: ``pytest -m slow -s plugins/driftform-studio/tests/test_hour.py``; with ``UPDATE_DOCS=1`` the table goes into
docs/validation.md.
"""

import os
import re
import shutil
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[3] / "docs" / "validation.md"
REQUESTS, DESIGNS = 2000, 20


def measure(pid):
    """Return memory, MB, and the numbers of open descriptors and of threads of a process."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    memory, threads = (int(re.search(rf"{name}:\s+(\d+)", status)[1]) for name in ("VmRSS", "Threads"))
    return memory / 1e3, len(list(Path(f"/proc/{pid}/fd").iterdir())), threads


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="no list of descriptors")
def test_two_thousand_requests_leave_memory_and_descriptors_as_they_were(serve, folder, finished_folder):
    shutil.copytree(finished_folder / "small", folder / "small")
    server = serve()
    designs = [
        {
            "base": "pipe-inspection",
            "title": f"Design {number}",
            "flow": {"speed": 0.5 + 0.05 * number},
            "targets": {f"T{i}": [1.0 + 0.2 * number, 0.0, 0.1 * i] for i in range(1 + number % 4)},
        }
        for number in range(DESIGNS)
    ]
    run = "api/runs/small"
    rows, asked = [], 0
    while asked <= REQUESTS:
        if asked in (100, 500, 1000, 1500, REQUESTS):
            rows.append((asked, *measure(server.pid)))
        # Of each ten, what a page asks while a design is made, and what it asks of a run.
        design = designs[asked // 10 % DESIGNS]
        for path in ("api/check", "api/check", "api/check", "api/examine"):
            server.ask(path, design)
        for path in ("api/runs", run, f"{run}/status", f"{run}/flights/{asked // 10 % 30}"):
            server.ask(path)
        server.perform(f"{run}/agents/near", {})
        asked += 10
    lines = ["| requests | memory, MB | descriptors | threads |", "|---|---|---|---|"]
    lines += [f"| {asked} | {memory:.0f} | {files} | {threads} |" for asked, memory, files, threads in rows]
    print("\n".join(lines))
    if os.environ.get("UPDATE_DOCS") == "1":
        text = PAGE.read_text(encoding="utf-8")
        marked = re.compile(r"(<!-- generated: hour of the studio -->\n).*?(<!-- end -->)", re.DOTALL)
        table = "\n".join(lines)
        text, count = marked.subn(lambda found: f"{found[1]}\n{table}\n\n{found[2]}", text)
        assert count == 1, f"{PAGE.name} has no place for the table"
        PAGE.write_text(text, encoding="utf-8")
    (_, first, descriptors, threads), (_, last, *others) = rows[1], rows[-1]
    assert last < first + 10 and others[0] <= descriptors + 2 and others[1] <= threads + 2
