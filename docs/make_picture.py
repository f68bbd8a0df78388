#!/usr/bin/env python3
"""Makes docs/picture.png: the path and a frame with tracks, as the demo's report shows them.

    python3 docs/make_picture.py [REPORT.html]

Without a report apps/demo.sh is run, which does nothing where its results are there. Needs chromium.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
DEMO_REPORT = REPOSITORY / "build/demo/results/runs/hall_loop/superglue/report.html"
PICTURE = REPOSITORY / "docs/picture.png"
WIDTH = 1200
HEIGHT = 480
GRAY_LEVELS = 32  # Of the frame: a photograph in all 256 would be a PNG twice as large.

PAGE = """<!doctype html><meta charset="utf-8"><style>{style}
html{{background:#fff}}
body{{width:{width}px;height:{height}px;overflow:hidden;padding:16px 20px;background:var(--page)}}
h1{{font-size:20px;margin:0 0 10px}}
.halves{{display:grid;grid-template-columns:570px 570px;gap:20px}}
.frames{{display:grid;gap:8px}}
figure{{margin:0}}
figcaption,.legend{{font-size:15px;color:var(--ink);margin-bottom:6px;display:block}}
.legend{{display:flex}}
.frames image{{filter:url(#levels)}}
</style><body><svg style="position:absolute" width="0" height="0"><filter id="levels"
color-interpolation-filters="sRGB"><feComponentTransfer><feFuncR type="discrete"
tableValues="{levels}"/><feFuncG type="discrete" tableValues="{levels}"/><feFuncB type="discrete"
tableValues="{levels}"/></feComponentTransfer></filter></svg><h1>{title}</h1><div class="halves"><div class="path-picture">{legend}{path}</div>
<div class="frames">{frame}</div></div></body>"""


def first(pattern, text, what):
    found = re.search(pattern, text, re.DOTALL)
    if found is None:
        sys.exit(f"make_picture.py: the report has no {what}")
    return found


def frame_of_most_tracks(report):
    """The left image with the most tracks that go on, and its caption."""
    strip = report[first(r'<div class="strip">', report, "frames").end():]
    frames = re.findall(
        r"<figure>(<svg(?:(?!</svg>).)*</svg>)<figcaption><b>Frame (\d+)</b>, ([\d.]+) s[^<]*"
        r"(?:<span[^>]*>[^<]*</span>)?\. Left: (\d+) tracked, (\d+) new", strip, re.DOTALL)
    if not frames:
        sys.exit("make_picture.py: the report has no frames")
    svg, number, seconds, tracked, new = max(frames, key=lambda frame: int(frame[3]))
    caption = f"Left image at {seconds} s: {tracked} tracks that go on (yellow), {new} new (white)"
    return f"<figure><figcaption>{caption}</figcaption>{svg}</figure>"


def page_of(report):
    style = first(r"<style>(.*?)</style>", report, "style sheet").group(1)
    light = re.sub(r"@media \(prefers-color-scheme:dark\)\{:root\{.*?\}\}", "", style, flags=re.DOTALL)
    path = first(r'<svg [^>]*aria-label="From above".*?</svg>', report, "path").group(0)
    legend = first(r'<p class="legend">.*?</p>', report, "legend").group(0)
    ate = first(r"ATE[^<]*</dt><dd>([\d.]+)", report, "ATE").group(1)
    title = f"A rendered flight of 20 seconds, by SuperPoint and SuperGlue: {ate} m off (ATE)"
    levels = " ".join(f"{i / (GRAY_LEVELS - 1):.4f}" for i in range(GRAY_LEVELS))
    return PAGE.format(style=light, levels=levels, width=WIDTH, height=HEIGHT, title=title, legend=legend, path=path,
                       frame=frame_of_most_tracks(report))


def main():
    if len(sys.argv) > 1:
        report = pathlib.Path(sys.argv[1])
    else:
        report = DEMO_REPORT
        subprocess.run(["bash", REPOSITORY / "apps/demo.sh"], check=True)
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "page.html"
        page.write_text(page_of(report.read_text(encoding="utf-8")), encoding="utf-8")
        subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                        "--force-device-scale-factor=1", f"--user-data-dir={folder}/profile",
                        f"--window-size={WIDTH},{HEIGHT}", f"--screenshot={PICTURE}", page.as_uri()],
                       check=True, stderr=subprocess.DEVNULL)
    print(f"{PICTURE}: {PICTURE.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
