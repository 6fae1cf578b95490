"""pictures.py PROGRAM FOLDER: the pictures of docs/view.md and the README, made anew: view.png and view-path.png."""
import os
import sys

from browser import Browser
from browser_test import COMPLETE, middle
from view_protocol import Program


def main():
    program, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
    with Browser() as browser, Program(program, "spheres", "--size", "320x240", "--spp", "48") as view:
        page = browser.page(view.link, 1280, 800)
        page.wait(COMPLETE, 600)
        for width in ("4", "8"):
            page.choose("parameter-width", width)
            page.wait(f"byId('changed').firstChild.textContent.includes(' to {width}')", 600)
        page.wait(COMPLETE, 600)
        page.screenshot(os.path.join(folder, "view.png"))
        page.click(*middle(page, 0.16, 0.3))
        page.wait("view.path && !byId('path').hidden")
        page.ask("byId('pixel-title').scrollIntoView()")
        page.screenshot(os.path.join(folder, "view-path.png"))


if __name__ == "__main__":
    main()
