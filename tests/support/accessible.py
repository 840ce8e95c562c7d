"""Faults of a page that bar readers from it, as axe-core's serious rules have them, in Chromium.

Names of pictures, buttons, links and fields; contrast of text (WCAG 2.1, 1.4.3: 4.5, of large text
3); order of headings; the page's language and title; ids that occur twice.

And words of a page that are neither in the glossary nor among those that any reader knows.
"""

import re
from html import unescape

from fingerdesign.report.page import term_pattern

# Words of headings, columns and captions that any reader knows; all others are terms.
PLAIN_WORDS = """
coupon crest cutter determined fixes machine name planned row shows sizes try
a across advice against all along analysed and angle answer any are as at axial axis back base be
before begins believe bench bend best better bill both bound by came cases casting centre centres
change changed changes chart check checked checks chosen clean close cm cm³ come compared complete
conditions contact content contents cost count crushed cut degrees design designs details diameter
did difference different do does downloads drawn dropped each ended engineering equal error
estimated every everything faces failed failures far figures files filled final finger finish first
fixed flat follow for force forces found from front g gages geometry glossary go good greatest
grips half has have heading hole holes hollow how in incr inside is it item its key kind largest
last least left length lie lifted lifts limit limits made maeno main make mass material materials
mean measure measured memory mg microstrain middle mind missing mix mm mn model modelled mold most
motion mpa n names nearest no not notes nothing number numbers objects of off on once one open
opens or order other others out over page paper part parts passed pattern peak per picture place
plan point points positions pour quality radius read reading record reference remark report
reported row rows rubber s said same saves saving saw says scale scene search seconds see seen
shape sheet short side size slips sorts stands step steps surface table test than that the their
thickness this time times to together told took tried true two under unit up used value values
verdict volume warned warning warnings was weight went were what where which who why width with
without words work works worst x y young z
findings given tables
"""
PLAIN = set(PLAIN_WORDS.split())

FAULTS = r"""(() => {
const found = [], all = (what) => [...document.querySelectorAll(what)];
const seen = (e) => e.getClientRects().length > 0 && getComputedStyle(e).visibility === "visible";
const near = (e) => `${e.tagName} ${e.id || ""} ${(e.textContent || "").trim().slice(0, 40)}`;
const fault = (rule, e) => found.push(`${rule}: ${near(e)}`);
const labelled = (e) => (e.getAttribute("aria-labelledby") || "").split(" ").filter(Boolean)
  .map((id) => document.getElementById(id)?.textContent || "").join("");
const named = (e) => [e.getAttribute("aria-label"), labelled(e), e.getAttribute("alt"), e.title,
  e.textContent, ...[...(e.labels || [])].map((label) => label.textContent)].some((t) => t?.trim());
if (!document.documentElement.lang) fault("lang", document.documentElement);
if (!document.title.trim()) fault("title", document.documentElement);
const ids = all("[id]").map((e) => e.id);
ids.filter((id, k) => ids.indexOf(id) < k).forEach((id) => found.push(`duplicate id: ${id}`));
const needy = "img, svg, button, a[href], summary, input:not([type=hidden]), select, textarea, "
  + "[role=img], [role=region]";
const own = "[aria-hidden=true], .plot, #js-plotly-tester"; // drawn, in words next to it
for (const e of all(needy))
  if (seen(e) && !e.closest(own) && !named(e)) fault("name", e);
for (const e of all(".scroll, .drawing"))
  if (e.scrollWidth > e.clientWidth + 1 && e.tabIndex < 0) fault("scrolls without keyboard", e);
for (const e of all("a[href^='#']"))
  if (e.hash.length > 1 && !document.getElementById(e.hash.slice(1))) fault("leads nowhere", e);
let level = 0;
for (const e of all("h1, h2, h3, h4, h5, h6").filter(seen)) {
  if (+e.tagName[1] > level + 1) fault("heading order", e);
  level = +e.tagName[1];
}
const pen = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
const rgba = (colour) => {
  pen.clearRect(0, 0, 1, 1); pen.fillStyle = colour; pen.fillRect(0, 0, 1, 1);
  return [...pen.getImageData(0, 0, 1, 1).data];
};
const light = ([r, g, b]) => [r, g, b].map((v) => v / 255)
  .map((v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
  .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
const behind = (e) => {
  for (let at = e; at; at = at.parentElement) {
    const colour = rgba(getComputedStyle(at).backgroundColor);
    if (colour[3] > 250) return colour;
  }
  return rgba("Canvas");
};
const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), reported = new Set();
while (texts.nextNode()) {
  const e = texts.currentNode.parentElement, style = getComputedStyle(e);
  const aside = e.closest("script, style, noscript, .plot, .skip");
  if (!texts.currentNode.data.trim() || !seen(e) || aside) continue;
  const colour = rgba(e.closest("svg") ? style.fill : style.color);
  const pair = [light(colour), light(behind(e))].sort((a, b) => b - a);
  const size = parseFloat(style.fontSize), bold = +style.fontWeight >= 700;
  const large = size >= 24 || (size >= 18.66 && bold);
  const ratio = (pair[0] + 0.05) / (pair[1] + 0.05), key = `${colour} ${pair}`;
  if (ratio < (large ? 3 : 4.5) && !reported.has(key)) {
    reported.add(key); fault(`contrast ${ratio.toFixed(2)}`, e);
  }
}
return found;
})()"""


def faults(browser):
    """The serious faults of the page that is open, as it appears now."""
    return browser.evaluate(FAULTS)


def unexplained(page):
    """Words of headings, columns, captions and drawings that are neither plain nor in an entry."""
    main = page.partition("<main")[2].partition("</main>")[0]
    inside = main.partition('<div class="definition"')[0]
    labels = re.findall(r"<(?:th|caption|h2|h3|text)\b[^>]*>([^<]*)<", inside)
    left = (
        term_pattern().sub(" ", unescape(re.sub(r"\w+(\.\w+)+", " ", label))) for label in labels
    )
    words = {word.lower() for each in left for word in re.findall(r"[^\W\d_]{2,}", each)}
    return sorted(words - PLAIN)
