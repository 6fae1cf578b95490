"""browser_test.py PROGRAM [--pictures FOLDER] [NAME...]: the page of the live view in headless Chromium, driven by mouse, touch and
keys. Exit code 77 without Chromium. --pictures keeps screenshots. --list has the names of the checks."""
import os
import shutil
import sys
import tempfile

from browser import Browser
from view_protocol import Program, get, gltf_with_two_cameras, run_checks

program = pictures = None
COMPLETE = "view.header && view.header.rest && view.header.samples === view.header.target && !view.dragging"


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def picture(page, name):
    if pictures:
        page.screenshot(os.path.join(pictures, name + ".png"))


def middle(page, dx=0.0, dy=0.0):
    box = page.ask("(() => { const b = picture.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
    return box[0] + box[2] * (0.5 + dx), box[1] + box[3] * (0.5 + dy)


def camera(page):
    return page.ask("[...view.header.camera.position, ...view.header.camera.forward, view.header.camera.tan_half_fov]")


def same(a, b, within=1e-4):
    return all(abs(x - y) <= within * (1 + abs(x)) for x, y in zip(a, b))


def looks_complete(page):
    page.wait(COMPLETE)


def the_picture_on_the_canvas_is_the_one_of_scotty_render(browser):
    with Program(program, "coil", "--size", "96x72", "--spp", "4", "--filter", "none") as view:
        page = browser.page(view.link)
        looks_complete(page)
        page.wait("picture.width === 96")
        different = page.ask("""(async () => {
            const saved = await createImageBitmap(await (await fetch('picture.png')).blob());
            const canvas = new OffscreenCanvas(96, 72);
            canvas.getContext('2d').drawImage(saved, 0, 0);
            const a = canvas.getContext('2d').getImageData(0, 0, 96, 72).data;
            const b = picture.getContext('2d').getImageData(0, 0, 96, 72).data;
            return a.reduce((sum, value, i) => sum + (value !== b[i]), 0);
        })()""")
        check(different == 0, f"{different} bytes differ")
        check(page.ask("byId('said').textContent").startswith("4 of 4 samples"), "the line below the picture does not say so")
        check(not page.faults, page.faults)


def a_hand_moves_the_camera(browser):
    with Program(program, "spheres", "--size", "128x96", "--spp", "2") as view:
        page = browser.page(view.link)
        looks_complete(page)
        start = camera(page)

        def moved(what, act, back=True):
            before = camera(page)
            state = page.ask("view.header.state")
            act()
            page.wait(f"view.header.state > {state} && {COMPLETE} && view.header.shows === link.id")
            check(not same(before, camera(page)), f"{what}: the camera is where it was")
            if back:
                state = page.ask("view.header.state")
                page.key("u")
                page.wait(f"view.header.state > {state} && {COMPLETE}")
                check(same(before, camera(page)), f"{what}: undo leads elsewhere: {before}, {camera(page)}")

        moved("dragging", lambda: page.drag(middle(page), middle(page, 0.2, 0.1)))
        moved("dragging with Shift", lambda: page.drag(middle(page), middle(page, 0.1, 0.1), shift=True))
        moved("the wheel", lambda: page.mouse("mouseWheel", *middle(page), button="none", buttons=0, deltaX=0, deltaY=120))
        for key in ("ArrowLeft", "ArrowUp", "+", "-", "]", "w", "e"):
            moved(f"the key {key}", lambda: page.key(key))
        moved("Shift and an arrow", lambda: page.key("ArrowRight", shift=True))
        moved("frame all", lambda: page.key("f"))
        moved("the button", lambda: page.ask("byId('all').click()"), back=False)
        state = page.ask("view.header.state")
        page.key("o")
        page.wait(f"view.header.state > {state} && {COMPLETE}")
        check(same(start, camera(page), 0.0), "own camera: not the same bits")
        # Two fingers.
        page.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)

        def fingers(kind, apart):
            x, y = middle(page)
            points = [] if kind == "touchEnd" else [{"x": x - apart, "y": y, "id": 1}, {"x": x + apart, "y": y, "id": 2}]
            page.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)

        def pinch():
            fingers("touchStart", 40)
            for apart in (50, 60, 70, 80):
                fingers("touchMove", apart)
            fingers("touchEnd", 0)
        moved("a pinch", pinch)
        check(not page.faults, page.faults)


def cameras_of_a_file_are_offered(browser):
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "two.gltf")
        with open(scene, "w", encoding="utf-8") as file:
            file.write(gltf_with_two_cameras())
        with Program(program, scene, "--size", "64x48", "--spp", "2") as view:
            page = browser.page(view.link)
            looks_complete(page)
            check(not page.ask("byId('cameras-field').hidden"), "two cameras, and no list of them")
            check(page.ask("[...byId('cameras').options].map((o) => o.textContent)") == ["choose", "Front", "Side"], "their names")
            page.choose("cameras", "1")
            page.wait(f"view.header.camera.position[0] === 1 && {COMPLETE}")
            page.key("u")
            page.wait(f"Math.abs(view.header.camera.position[0]) < 1e-6 && {COMPLETE}")
            check(not page.faults, page.faults)


def what_is_shown_changes(browser):
    with Program(program, "coil", "--size", "96x72", "--spp", "3") as view:
        page = browser.page(view.link)
        looks_complete(page)
        check(page.ask("view.header.filter") == "median", "the filter is on at first")
        rows = page.ask("[...byId('stages').rows].map((row) => row.cells[0].textContent)")
        check("traversal, level 0" in rows and len(rows) > 6, f"times by stage and level: {rows}")
        page.key("b")
        page.wait("view.header.filter === 'none' && view.header.samples === 3")
        for key, what in zip("234567", ("distance", "primitive", "normal", "queues", "bounces", "variance")):
            page.key(key)
            page.wait(f"view.header.what === '{what}' && view.header.rest && byId('what').value === '{what}'")
            colors = page.ask("new Set(Array.from(new Uint32Array(picture.getContext('2d').getImageData(0, 0, 96, 72).data.buffer))).size")
            check(colors >= 3, f"{what}: {colors} colours")
            check(page.ask("byId('legend').hidden") == (what in ("primitive", "normal")), f"{what}: the scale")
            picture(page, what)
        page.key("1")
        page.wait("view.header.what === 'picture'")
        bright = "picture.getContext('2d').getImageData(0, 0, 96, 72).data.reduce((s, v) => s + v, 0)"
        before = page.ask(bright)
        page.key(".")
        page.wait(f"{bright} > 1.05 * {before}")
        page.choose("tone", "filmic")
        page.wait("view.state.tone === 'filmic' && view.header.state >= 1")
        page.choose("backend", "embree")
        page.wait("view.header.backend === 'embree' && !byId('cannot').hidden")
        check(page.ask("[...byId('what').options].filter((o) => o.disabled).length") == 5, "embree has no stages to show")
        check(page.ask("byId('verify-start').disabled"), "embree is not verified")
        check(not page.faults, page.faults)


def changes_say_what_they_did(browser):
    with Program(program, "coil", "--size", "96x72", "--spp", "8") as view:
        page = browser.page(view.link)
        looks_complete(page)
        first = "byId('changed').firstChild.textContent"
        for name, value, same_bits in (("width", "4", True), ("rays_per_block", "128", True), ("queue_levels", "2", True),
                                       ("early_out", "off", True), ("hit_mode", "buffer", True), ("block_order", "strided", True),
                                       ("bounces", "0", False), ("light_samples", "1", False), ("seed", "7", False)):
            page.choose(f"parameter-{name}", value)
            page.wait(f"view.state.parameters.{name} === '{value}' && {first}.includes(' to {value}')")
            text = page.ask(first)
            check(("the same bits" in text) == same_bits, f"{name}: {text}")
            check("FAULT" not in text and "ANOTHER" not in text and "ms a sample" in text, text)
        page.wait(COMPLETE)
        page.choose("backend", "simt")
        page.wait(f"{first}.includes('emulator to simt')", 200)
        check("the same bits" in page.ask(first), page.ask(first))
        check(not page.faults, page.faults)
        picture(page, "changes")


def from_a_pixel_to_its_queues(browser):
    with Program(program, "coil", "--size", "128x96", "--spp", "2") as view:
        page = browser.page(view.link)
        looks_complete(page)
        page.click(*middle(page, 0.02, 0.1))
        page.wait("view.path && !byId('path').hidden")
        count = page.ask("view.path.vertices.length")
        check(page.ask("byId('path').tBodies[0].rows.length") == count > 0, f"{count} vertices are not the table's")
        ink = page.ask("overlay.getContext('2d').getImageData(0, 0, overlay.width, overlay.height).data.some((v) => v > 0)")
        check(ink, "no path is drawn")
        x, y = page.ask("[view.path.x, view.path.y]")
        spot = page.ask("projected(view.path.vertices[0].position, view.header.camera, 128 / 96)")
        check(abs(spot[0] * 128 - x - 0.5) < 1 and abs(spot[1] * 96 - y - 0.5) < 1, f"the path of {x},{y} begins at {spot}")
        picture(page, "path")
        before = camera(page)
        page.click(*middle(page, 0.2, 0.1), count=1)
        page.click(*middle(page, 0.2, 0.1), count=2)
        page.wait(f"{COMPLETE} && Math.abs(view.header.camera.forward[0] - {before[3]}) > 1e-4")
        page.ask("byId('queues-start').click()")
        page.wait("!byId('queues-link').hidden")
        other = browser.page(view.link + "queues")
        other.wait("document.getElementById('queues-data') && /ray \\d+/.test(document.getElementById('where').textContent)")
        check(not other.faults, other.faults)
        picture(other, "queues-page")
        check(not page.faults, page.faults)


def this_view_is_verified_and_compared(browser):
    with Program(program, "cornell", "--size", "96x72", "--spp", "2") as view:
        page = browser.page(view.link)
        looks_complete(page)
        state = page.ask("view.header.state")
        page.key("ArrowLeft")
        page.wait(f"view.header.state > {state} && {COMPLETE}")
        page.ask("byId('verify-start').click()")
        page.wait("byId('verify-said').textContent === 'verification passed'", 300)
        check("cornell" in page.ask("byId('verify-output').textContent"), "the table of scotty verify")
        status, report = get(view.link, "verify")
        check(status == 200 and b"#camera=" in report, "the report is not of this camera")
        page.choose("compare-backend", "embree")
        page.ask("byId('compare-start').click()")
        page.wait("!byId('compared').hidden && byId('compare-difference').complete && byId('compare-difference').naturalWidth === 96", 120)
        page.choose("compare-backend", "simt")
        page.ask("byId('compare-start').click()")
        page.wait("byId('compare-said').textContent.startsWith('the same bits in all 6912 pixels')", 200)
        if os.path.exists(os.path.join(os.path.dirname(program), "scotty-mutants")):
            page.choose("compare-backend", "emulator")
            page.choose("compare-plant", "cosine_forgotten")
            page.ask("byId('compare-start').click()")
            page.wait("byId('compare-said').textContent !== '' && !byId('compare-start').disabled", 200)
            check("of 6912 pixels differ" in page.ask("byId('compare-said').textContent"), page.ask("byId('compare-said').textContent"))
            picture(page, "compared")
            # The same fault on both sides makes the same picture; the comparison follows the camera.
            page.choose("compare-own-plant", "cosine_forgotten")
            page.ask("byId('compare-start').click()")
            page.wait("byId('compare-said').textContent.startsWith('the same bits in all 6912 pixels')", 200)
            check("emulator with cosine_forgotten" == page.ask("byId('compare-a-name').textContent"), "the side's name")
            page.choose("compare-own-plant", "")
            page.ask("byId('compare-live').click()")
            page.key("ArrowLeft")
            page.wait("byId('compare-said').textContent.includes('of 6912 pixels differ') && view.comparedAt === view.header.state", 200)
            page.ask("byId('compare-live').click()")
        page.choose("compare-plant", "no such fault")
        page.ask("byId('compare-start').click()")
        page.wait("byId('compare-said').textContent.includes('could not be carried out')", 200)
        check(not page.faults, page.faults)


def it_fits_narrow_and_wide_light_and_dark(browser):
    with Program(program, "spheres", "--size", "160x120", "--spp", "16") as view:
        for width, height, scale, dark in ((420, 900, 2, False), (1280, 900, 1, True), (3840, 2160, 1, False)):
            page = browser.page(view.link, width, height, scale, dark)
            looks_complete(page)
            wide = page.ask("document.documentElement.scrollWidth")
            check(wide <= width, f"{width} pixels wide: the page takes {wide}")
            check(page.ask("picture.getBoundingClientRect().width") >= 0.5 * min(width, height), f"{width}: the picture is small")
            picture(page, f"page-{width}")
            nameless = page.ask("""[...document.querySelectorAll('button, input, select, canvas[role=img], img')].filter((e) =>
                !(e.labels?.length || e.getAttribute('aria-label') || e.getAttribute('aria-labelledby') || e.textContent.trim() || e.alt)).map((e) => e.id)""")
            check(nameless == [], f"without a name for a screen reader: {nameless}")
            check(not page.faults, page.faults)


def a_program_that_ends_is_said_and_a_new_one_is_found(browser):
    with Program(program, "cornell", "--size", "64x48", "--spp", "1", "--port", "0") as view:
        page = browser.page(view.link)
        looks_complete(page)
        check(view.end() == 0, "Ctrl-C")
        page.wait("byId('connection').textContent.startsWith('not connected')")


def main():
    global program, pictures
    words = sys.argv[1:]
    checks = {name.replace("_", " "): f for name, f in globals().items()
              if callable(f) and getattr(f, "__module__", "") == "__main__" and f.__code__.co_varnames[:1] == ("browser",)}
    if "--list" in words:
        print("\n".join(checks))
        return 0
    if shutil.which("chromium") is None:
        print("not run: no chromium")
        return 1 if os.environ.get("SCOTTY_REQUIRE_BROWSER") else 77
    program = os.path.abspath(words.pop(0))
    if "--pictures" in words:
        at = words.index("--pictures")
        pictures = words[at + 1]
        os.makedirs(pictures, exist_ok=True)
        del words[at:at + 2]
    with Browser() as browser:
        return run_checks(checks, words, browser)


if __name__ == "__main__":
    sys.exit(main())
