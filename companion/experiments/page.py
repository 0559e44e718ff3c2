"""What all pages of reports share: one look, and no need of a network."""

from collections.abc import Sequence
from html import escape


def page(title: str, body: str) -> str:
    """A whole page (HTML) with this title over this body, which is HTML."""
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
<h1>{escape(title)}</h1>
{body}
</main>
</body>
</html>
"""


def paths_section(name: str, stem: str, panel: str) -> str:
    """Pictures of a trajectory (HTML): `STEM-path.png`, a panel for each `panel`, and `STEM-time.png`."""
    name = escape(name)
    return f"""<section>
<h2>{name}</h2>
<figure><img src="{stem}-path.png" alt="{name}: desired and flown path, a panel for each {panel}">
<figcaption>Path: desired in grey, flown in colour from the dot on, with its RMS error.</figcaption></figure>
<figure><img src="{stem}-time.png" alt="{name}: each axis and the error over time">
<figcaption>Each axis over time, and the distance between desired and flown position.</figcaption></figure>
</section>
"""


def typed(commands: Sequence[str]) -> str:
    """What to type to make the same page (HTML)."""
    lines = escape("\n".join(commands))
    return f"""<section>
<h2>To make it again</h2>
<pre>{lines}</pre>
</section>"""


STYLE = """
:root {
  color-scheme: light dark;
  --ink: #1d1f23; --soft: #62676f; --line: #dcdfe4; --page: #ffffff; --card: #f3f4f5;
}
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e7e9; --soft: #9aa0a8; --line: #34383e; --page: #16181b; --card: #22252a; }
}
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 60rem; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 1rem; }
h2 { font-size: 1.25rem; margin: 2.5rem 0 .75rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.25rem; margin: 0; }
dt, .note, figcaption, small { color: var(--soft); }
dd { margin: 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .45rem .75rem; text-align: right; border-bottom: 1px solid var(--line); }
th, td { white-space: nowrap; vertical-align: top; }
th:first-child { text-align: left; padding-left: 0; }
tbody th { font-weight: 500; }
.total tbody tr:last-child > * { font-weight: 650; border-bottom: 0; }
td small { display: block; font-size: .82rem; font-weight: 400; }
th i { display: inline-block; width: .7em; height: .7em; border-radius: 50%; margin-right: .4em; }
.note, figcaption { font-size: .9rem; }
figure { margin: 1rem 0 1.5rem; }
img { display: block; box-sizing: border-box; max-width: 100%; height: auto; margin: 0 auto; }
img { background: #fff; padding: .5rem; border-radius: 6px; }
figcaption { margin-top: .4rem; }
pre { background: var(--card); padding: .9rem 1.1rem; border-radius: 6px; overflow-x: auto; }
"""
