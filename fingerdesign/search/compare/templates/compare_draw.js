// Drawing of charts: axes with round ticks, paths with gaps, markers. SVG whose colours are CSS
// variables, so that one drawing serves light, dark and paper without being drawn again.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  let made = 0; // ids must not meet

  // One look a series: colour (class), dashes and marker all differ, so that no one is needed.
  const LOOKS = [
    { name: "v-blue", dash: "", marker: "circle" },
    { name: "v-vermilion", dash: "7 3", marker: "square" },
    { name: "v-green", dash: "2 2.5", marker: "triangle" },
    { name: "v-purple", dash: "8 3 2 3", marker: "diamond" },
    { name: "v-muted", dash: "4 2 1 2 1 2", marker: "down" },
  ];
  const DESIGNS = [
    { letter: "A", ...LOOKS[0] },
    { letter: "B", ...LOOKS[1] },
  ];

  const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

  function number(value, digits = 3) {
    if (!isNumber(value)) return "none";
    const size = Math.abs(value);
    if (size !== 0 && (size >= 1e5 || size < 1e-3)) return value.toExponential(digits - 1);
    const text = String(Number(value.toPrecision(digits)));
    return text.replace("-", "−");
  }

  /** Round numbers from lo to hi, about `most` of them. */
  function ticks(lo, hi, most = 5) {
    const span = hi - lo;
    if (!(span > 0)) return [lo];
    const rough = span / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((each) => each * power >= rough * 0.999);
    const found = [];
    for (let k = Math.ceil(lo / step - 1e-6); k * step <= hi + 1e-6 * span; k += 1)
      found.push(Number((k * step).toPrecision(12)));
    return found;
  }

  /** Least and greatest of lists of numbers, widened by `more` of their span; never empty. */
  function bounds(lists, more = 0.05, always = []) {
    let lo = Infinity;
    let hi = -Infinity;
    for (const list of [...lists, always])
      for (const value of list)
        if (isNumber(value)) {
          lo = Math.min(lo, value);
          hi = Math.max(hi, value);
        }
    if (lo > hi) return [0, 1];
    if (lo === hi) return [lo - 0.5 * (Math.abs(lo) || 1), hi + 0.5 * (Math.abs(hi) || 1)];
    const extra = more * (hi - lo);
    return [lo - (lo === 0 ? 0 : extra), hi + extra];
  }

  /** A path through points, broken where a coordinate is missing. */
  function line(points) {
    let open = false;
    let text = "";
    for (const [x, y] of points) {
      if (isNumber(x) && isNumber(y)) {
        text += `${open ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
        open = true;
      } else open = false;
    }
    return text;
  }

  /** A marker's outline about (x, y), of radius r. */
  function marker(shape, x, y, r) {
    const at = (dx, dy) => `${(x + dx * r).toFixed(1)} ${(y + dy * r).toFixed(1)}`;
    switch (shape) {
      case "square":
        return `M${at(-0.9, -0.9)}L${at(0.9, -0.9)}L${at(0.9, 0.9)}L${at(-0.9, 0.9)}Z`;
      case "triangle":
        return `M${at(0, -1.2)}L${at(1.1, 0.8)}L${at(-1.1, 0.8)}Z`;
      case "down":
        return `M${at(0, 1.2)}L${at(1.1, -0.8)}L${at(-1.1, -0.8)}Z`;
      case "diamond":
        return `M${at(0, -1.3)}L${at(1.3, 0)}L${at(0, 1.3)}L${at(-1.3, 0)}Z`;
      case "cross":
        return `M${at(-1, -1)}L${at(1, 1)}M${at(-1, 1)}L${at(1, -1)}`;
      default: {
        const half = `A${r} ${r} 0 1 0`;
        return `M${at(-1, 0)}${half} ${at(1, 0)}${half} ${at(-1, 0)}Z`;
      }
    }
  }

  /**
   * Empty axes. x, y: [least, greatest]; label: the text alternative.
   * Returns the element, the layer to draw in (clipped), one over it, and the scales X, Y.
   */
  function plot({ width = 440, height = 240, x, y, xLabel, yLabel, label, left = 52, right = 14,
    down = false, xTicks, yTicks }) {
    const top = 12;
    const bottom = 40;
    const inner = { width: width - left - right, height: height - top - bottom };
    const X = (value) => left + ((value - x[0]) / (x[1] - x[0])) * inner.width;
    const share = (value) => (value - y[0]) / (y[1] - y[0]);
    const Y = (value) => top + (down ? share(value) : 1 - share(value)) * inner.height;
    const id = `v-clip-${(made += 1)}`;
    const svg = FD.svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img",
      "aria-label": label, class: "v-chart" });
    const clip = FD.svg("clipPath", { id },
      FD.svg("rect", { x: left, y: top, width: inner.width, height: inner.height }));
    const axes = FD.svg("g", { class: "v-axes", "aria-hidden": "true" });
    for (const value of xTicks || ticks(x[0], x[1], Math.round(inner.width / 70))) {
      const at = X(value).toFixed(1);
      axes.append(FD.svg("path", { class: "v-grid", d: `M${at} ${top}V${top + inner.height}` }));
      axes.append(FD.svg("text", { x: at, y: top + inner.height + 15, "text-anchor": "middle" },
        number(value, 6)));
    }
    for (const value of yTicks || ticks(y[0], y[1], Math.max(2, Math.round(inner.height / 40)))) {
      const at = Y(value);
      const d = `M${left} ${at.toFixed(1)}h${inner.width}`;
      axes.append(FD.svg("path", { class: "v-grid", d }));
      axes.append(FD.svg("text", { x: left - 6, y: (at + 4).toFixed(1), "text-anchor": "end" },
        number(value, 6)));
    }
    axes.append(FD.svg("path", { class: "v-frame",
      d: `M${left} ${top}v${inner.height}h${inner.width}` }));
    axes.append(FD.svg("text", { class: "v-title", x: left + inner.width / 2, y: height - 6,
      "text-anchor": "middle" }, xLabel));
    axes.append(FD.svg("text", { class: "v-title", "text-anchor": "middle",
      transform: `translate(13 ${top + inner.height / 2}) rotate(-90)` }, yLabel));
    const layer = FD.svg("g", { "clip-path": `url(#${id})`, "aria-hidden": "true" });
    const over = FD.svg("g", { "aria-hidden": "true" });
    svg.append(clip, axes, layer, over);
    return { svg, layer, over, X, Y, left, right, top, width, height, inner };
  }

  /** A legend: list of [element of SVG drawn in 34 x 14, words]. */
  function legend(entries) {
    const list = FD.el("ul", { class: "v-legend" });
    for (const [drawn, words] of entries)
      list.append(FD.el("li", {},
        FD.svg("svg", { viewBox: "0 0 34 14", width: 34, height: 14, "aria-hidden": "true" },
          ...drawn), FD.el("span", {}, words)));
    return list;
  }

  /** A wide drawing in a box that scrolls sideways on narrow screens, by keys too. */
  const scrolled = (name, ...children) => FD.el("div", { class: "v-scroll", tabindex: "0",
    role: "region", "aria-label": name }, ...children);

  const stroke = (look, d, more = "") =>
    FD.svg("path", { class: `v-line ${look.name} ${more}`, d, "stroke-dasharray": look.dash });
  const sign = (look, x, y, r = 3.2, hollow = false) =>
    FD.svg("path", { class: `${hollow ? "v-hollow" : "v-sign"} ${look.name}`,
      d: marker(look.marker, x, y, r) });

  FD.draw = { LOOKS, DESIGNS, isNumber, number, ticks, bounds, line, marker, plot, legend,
    scrolled, stroke, sign, id: () => `v-${(made += 1)}` };
})();
