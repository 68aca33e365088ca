"""The page of a report in a real browser: python drive.py PAGE.html

Drives the player of the belief, by mouse and by keys, at three widths, in light and dark, and without JavaScript.
Ends with 1 at the first fault, a console error among them; with 0 and a line where there is no browser.
"""

import os
import shutil
import sys
from pathlib import Path

BROWSERS = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"]


def browser_here():
    named = os.environ.get("BALLMARK_BROWSER")
    found = filter(None, map(shutil.which, [named] if named else BROWSERS))
    return next(found, None)


def check(is_so, fault):
    if not is_so:
        sys.exit(f"fault: {fault}")


def watched(page, faults):
    """Notes what must not happen: errors, and requests for anything but the page itself."""
    page.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("request", lambda asked: faults.append(f"asked for {asked.url[:80]}") if not asked.url.startswith(("file:", "data:")) else None)
    return page


def ink(page):
    """What the first picture of the player shows."""
    return page.evaluate("document.querySelector('.player .belief > canvas').toDataURL()")


def play(page):
    """Every way to move the player moves it."""
    page.wait_for_selector(".player[data-ready=yes]", timeout=10_000)
    where = page.locator("[data-part=where]")
    said = lambda: where.inner_text().split(",")[0]
    first = ink(page)
    check(said().startswith("step 1 of "), f"starts at `{said()}`")
    page.locator("[data-part=step]").fill("3")
    check(said().startswith("step 4 of "), f"the slider at 3 says `{said()}`")
    check(ink(page) != first, "the slider changes no picture")
    page.locator("[data-part=on]").click()
    check(said().startswith("step 5 of "), f"a step on says `{said()}`")
    page.locator("[data-part=back]").click()
    check(said().startswith("step 4 of "), f"a step back says `{said()}`")
    page.locator(".player").first.focus()
    for key, expected in [("ArrowRight", "step 5 of "), ("ArrowLeft", "step 4 of "), ("Home", "step 1 of ")]:
        page.keyboard.press(key)
        check(said().startswith(expected), f"{key} says `{said()}`; expected `{expected}`")
    page.keyboard.press("Space")
    moved = lambda: not said().startswith("step 1 of ")
    for _ in range(50):
        if not moved():
            page.wait_for_timeout(100)
    check(moved(), "after the space bar nothing moves")
    page.keyboard.press("Space")
    page.keyboard.press("End")
    step, steps = said().removeprefix("step ").split(" of ")
    check(step == steps, f"End says `{said()}`")
    page.locator("[data-part=play]").click()  # from the end it begins anew
    check(said().startswith("step 1 of "), f"play at the end says `{said()}`")
    page.locator("[data-part=play]").click()
    page.locator("[data-part=step]").fill("2")
    before = ink(page)
    choice = page.locator("[data-part=trial]")
    if choice.locator("option").count() > 1:
        choice.select_option(index=1)
        page.locator("[data-part=step]").fill("2")
        check(ink(page) != before, "another trial shows the same")
    page.locator(".choice summary").click()
    shown = page.locator(".belief:visible").count()
    page.locator("[data-part=systems] input:not(:checked)").first.check()
    check(page.locator(".belief:visible").count() == shown + 1, "a system that is chosen is not shown")
    alt = page.locator(".player .belief > canvas").first.get_attribute("aria-label")
    check("step " in alt and "m off" in alt, f"the picture is described as `{alt}`")


def main(path):
    address = Path(path).resolve().as_uri()
    program = browser_here()
    if program is None:
        print("SKIPPED: no browser here (BALLMARK_BROWSER names one)")
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for width in (390, 820, 1400):
            for scheme in ("light", "dark"):
                faults = []
                page = watched(browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme), faults)
                page.goto(address)
                play(page)
                wide = page.evaluate("document.documentElement.scrollWidth")
                check(wide <= width, f"{width} px: the page is {wide} px wide")
                nameless = page.evaluate(
                    "[...document.querySelectorAll('img, [role=img]')].filter("
                    "e => !(e.alt || e.getAttribute('aria-label'))).length"
                )
                check(nameless == 0, f"{nameless} pictures without a description")
                check(not faults, f"{width} px, {scheme}: {faults}")
                page.close()
        still = browser.new_context(java_script_enabled=False).new_page()
        still.goto(address)
        check(still.locator("table").first.is_visible(), "without JavaScript no table is seen")
        check(still.locator(".player noscript svg, .player svg").first.is_visible(), "without JavaScript no still picture is seen")
        check(not still.locator(".player .controls").first.is_visible(), "without JavaScript there are dead buttons")
        browser.close()
    print("the player plays at three widths, in light and dark, and the page reads without JavaScript")


if __name__ == "__main__":
    main(sys.argv[1])
