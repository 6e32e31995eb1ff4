"""How a report looks: on a screen, on a phone and on paper."""

from typing import Final

STYLE: Final = """
:root { color-scheme: light; --ink: #1b1b1b; --quiet: #595959; --line: #d9d9d9;
  --accent: #005a8f; --good: #00603f; --bad: #9c2b00; --wash: #f4f6f8; }
* { box-sizing: border-box; }
html { scroll-padding-top: 1rem; -webkit-text-size-adjust: 100%; }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: #fff; margin: 0; }
a { color: var(--accent); }
:focus-visible { outline: 3px solid #b35900; outline-offset: 2px; }
.paper { display: grid; grid-template-columns: minmax(0, 1fr); max-width: 84rem; margin: 0 auto;
  padding: 1.2rem 1.2rem 4rem; }
header, main, .contents { min-width: 0; }
h1 { font-size: 1.9rem; line-height: 1.15; margin: 0 0 .3rem; text-wrap: balance; }
h2 { font-size: 1.3rem; line-height: 1.25; margin: 2.6rem 0 .7rem; padding-top: .5rem;
  border-top: 2px solid var(--ink); }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; }
p, figcaption, ul.plain { max-width: 52rem; overflow-wrap: anywhere; }
.meta { color: var(--quiet); margin: .2rem 0 0; }
.headline { font-size: 1.25rem; line-height: 1.4; margin: 1rem 0; padding-left: .9rem;
  border-left: 4px solid var(--accent); }
.tally { display: flex; flex-wrap: wrap; gap: .5rem; list-style: none; margin: 1rem 0; padding: 0; }
.tally li { background: var(--wash); border-left: 4px solid var(--quiet); padding: .3rem .8rem;
  line-height: 1.25; }
.tally strong { font-size: 1.4rem; font-variant-numeric: tabular-nums; margin-right: .3rem; }
.tally .holds { border-color: var(--good); } .tally .fails { border-color: var(--bad); }
.contents { font-size: .92rem; margin-top: 1.2rem; }
.contents h2 { font-size: 1rem; margin: 0 0 .3rem; padding: 0; border: 0; }
.contents ol { margin: 0; padding-left: 2rem; columns: 18rem; }
.contents li { margin: .15rem 0; break-inside: avoid; overflow-wrap: anywhere; }
@media (min-width: 72rem) {
  .paper { grid-template-columns: 15rem minmax(0, 1fr); column-gap: 2.6rem; }
  header { grid-column: 2; } main { grid-column: 2; }
  .contents { grid-column: 1; grid-row: 1 / span 2; position: sticky; top: 1rem;
    align-self: start; max-height: calc(100vh - 2rem); overflow-y: auto; margin-top: .4rem; }
  .contents ol { columns: auto; }
}
figure { margin: 1.2rem 0; } figure svg { display: block; max-width: 100%; height: auto; }
figcaption { margin-top: .4rem; } figcaption strong { font-weight: 600; }
.note { color: var(--quiet); font-size: .88rem; margin: .2rem 0; }
.files { color: var(--quiet); font-size: .85rem; } .files a { margin-right: .5rem; }
.scroll { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .7rem .32rem 0; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: top; }
thead th { border-bottom: 1px solid var(--ink); vertical-align: bottom; } th { font-weight: 600; }
tbody th { font-weight: 400; min-width: 11rem; } td { white-space: nowrap; }
.words { display: block; white-space: normal; min-width: 10rem; max-width: 22rem; }
.few { display: block; white-space: normal; max-width: 8rem; }
.holds { color: var(--good); font-weight: 600; } .fails { color: var(--bad); font-weight: 600; }
.undecided { color: var(--quiet); font-style: italic; } .minor { color: var(--quiet); }
.tally .holds, .tally .fails, .tally .undecided { color: inherit; font-weight: 400;
  font-style: normal; }
.warning { color: var(--bad); font-weight: 600; }
code { font-size: .9em; overflow-wrap: anywhere; }
pre { background: var(--wash); padding: .6rem .9rem; white-space: pre-wrap; margin: .6rem 0;
  overflow-wrap: anywhere; }
summary { cursor: pointer; margin: .6rem 0; color: var(--accent); }
.views { position: relative; }
.views > input { position: absolute; opacity: 0; }
.views > label { display: inline-block; border: 1px solid var(--accent); color: var(--accent);
  padding: .2rem .7rem; margin: 0 .3rem .3rem 0; border-radius: 1rem; cursor: pointer;
  font-size: .9rem; }
.views > input:checked + label { background: var(--accent); color: #fff; }
.views > input:focus-visible + label { outline: 3px solid #b35900; outline-offset: 2px; }
.views > div { display: none; }
.views > input:nth-of-type(1):checked ~ div:nth-of-type(1),
.views > input:nth-of-type(2):checked ~ div:nth-of-type(2),
.views > input:nth-of-type(3):checked ~ div:nth-of-type(3) { display: block; }
.on-paper { display: none; }
@media (max-width: 44rem) {
  body { font-size: 15px; } h1 { font-size: 1.5rem; } .headline { font-size: 1.1rem; }
  .paper { padding: .8rem .8rem 3rem; }
  /* Its texts would be too small to read; it is moved within its own frame. */
  figure svg { max-width: none; width: 40rem; } figure svg.wide { width: 58rem; }
  tbody th { min-width: 8rem; }
}
@page { size: A4 portrait; margin: 14mm 12mm; }
@media print {
  .paper { display: block; padding: 0; max-width: none; } body { font-size: 10pt; }
  p, figcaption { max-width: none; } h2 { margin-top: 1.6rem; }
  .contents { position: static; max-height: none; overflow: visible; }
  .scroll { overflow: visible; } table { font-size: 8pt; line-height: 1.35; }
  th, td, tbody th { white-space: normal; min-width: 0; padding-right: .4rem; }
  .words, .few { min-width: 0; max-width: none; }
  th:first-child { overflow-wrap: anywhere; min-width: 5rem; }
  figure svg, figure svg.wide { width: auto; max-width: 100%; max-height: 95mm; }
  tr, figure, .tally li, .headline { break-inside: avoid; }
  h2, h3, summary, thead { break-after: avoid; } a { color: inherit; }
  .tally li, pre { border: 1px solid var(--line); }
  details::details-content { content-visibility: visible; block-size: auto; }
  summary { list-style: none; font-weight: 600; color: inherit; }
  .views > label { display: none; } .on-paper { display: block; }
}
"""
"""Of the page; nothing in it is loaded from elsewhere. What is closed on a screen is open on paper,
and of views that a switch has the chosen one is printed."""
