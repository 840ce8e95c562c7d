"""Faults of a page that bar readers from it, as axe-core's serious rules have them, in Chromium.

Names of pictures, buttons, links and fields; contrast of text (WCAG 2.1, 1.4.3: 4.5, of large text
3); order of headings; the page's language and title; ids that occur twice.
"""

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
