#!/usr/bin/python3
"""README.md's commands, what they print, and its picture are of one run.    SHAKER_BUILD=build/dev PROGRAM

To draw the picture again: README's run in an empty folder, then daemon/report/plot run.nxs daemon/report/one_run.png."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import PIL.Image

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(os.environ.get("SHAKER_BUILD", ROOT / "build/dev")).resolve()


def commands():
    """README's commands of shakerd, each with the lines it prints."""
    found = []
    for block in re.findall(r"(?:^    .*\n)+", (ROOT / "README.md").read_text(), re.M):
        for line in (line[4:] for line in block.splitlines()):
            if line.startswith("$ "):
                found.append((line[2:], []))
            elif found and "$ " in block:
                found[-1][1].append(line)
    return [(command, lines) for command, lines in found if command.startswith("shakerd ")]


def about(picture):
    with PIL.Image.open(picture) as image:
        return image.text["Title"]


class ReadmeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        path = {**os.environ, "PATH": f"{BUILD}:{os.environ['PATH']}"}
        cls.printed = [(command, lines, subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=cls.folder, env=path,
                                                       capture_output=True, text=True))
                       for command, lines in commands()]

    def test_commands_print_what_it_shows(self):
        self.assertEqual(len(self.printed), 3)
        for command, shown, done in self.printed:
            printed = (done.stdout + done.stderr).splitlines()
            with self.subTest(command=command, printed=printed):
                self.assertEqual(done.returncode, 0)
                rest = iter(printed)
                self.assertEqual([line for line in shown if line != "..." and line not in rest], [])

    def test_picture_is_of_the_same_run(self):
        subprocess.run(["/usr/bin/python3", ROOT / "daemon/report/plot", "run.nxs", "picture.png"], cwd=self.folder, check=True)
        self.assertEqual(about(ROOT / "daemon/report/one_run.png"), about(self.folder / "picture.png"))


if __name__ == "__main__":
    unittest.main()
