// The two fingers in space, turned by dragging, keys or buttons, both at one scale.
//
// Drawn as SVG polygons in the painter's order, without WebGL: it needs no graphics card, prints
// as lines, and follows the page's colours. The order is exact: plates and core are convex and lie
// apart, so a plane between each two (found once) says which is in front; the body is a shell whose
// far side is drawn before them and whose near side, see-through, after them.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const WIDTH = 440;
  const HEIGHT = 330;
  const START = { turn: -32, tilt: 24, zoom: 1 };
  const VIEWS = { Reset: START, Front: { turn: 0, tilt: 0, zoom: 1 },
    Side: { turn: -90, tilt: 0, zoom: 1 }, Top: { turn: 0, tilt: 90, zoom: 1 } };
  const LIGHT = [-0.35, 0.8, 0.5];
  const SHADES = 6;
  const HELP = "Arrow keys turn and tilt, plus and minus zoom, 0 resets.";
  let kept = { ...START }; // another pair of designs is seen from where the last one was
  const radians = (angle) => (angle * Math.PI) / 180;

  /** The camera's axes in space: right, up, and toward the viewer. */
  function camera({ turn, tilt }) {
    const [ct, st] = [Math.cos(radians(turn)), Math.sin(radians(turn))];
    const [cp, sp] = [Math.cos(radians(tilt)), Math.sin(radians(tilt))];
    return { right: [ct, 0, -st], up: [-sp * st, cp, -sp * ct], view: [cp * st, sp, cp * ct] };
  }

  function limited({ turn, tilt, zoom }) {
    return { turn: ((((turn + 180) % 360) + 360) % 360) - 180,
      tilt: Math.min(90, Math.max(-90, tilt)), zoom: Math.min(8, Math.max(0.5, zoom)) };
  }

  const EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 4]];

  /** Whether two boxes' corners on the page keep apart: some edge of one lies between them. */
  function apartOnPage(p, q) {
    for (const points of [p, q])
      for (const [from, to] of EDGES) {
        const nx = points[from][1] - points[to][1];
        const ny = points[to][0] - points[from][0];
        let [pLow, pHigh, qLow, qHigh] = [Infinity, -Infinity, Infinity, -Infinity];
        for (const [x, y] of p) {
          const along = nx * x + ny * y;
          if (along < pLow) pLow = along;
          if (along > pHigh) pHigh = along;
        }
        for (const [x, y] of q) {
          const along = nx * x + ny * y;
          if (along < qLow) qLow = along;
          if (along > qHigh) qHigh = along;
        }
        if (pHigh <= qLow || qHigh <= pLow) return true;
      }
    return false;
  }

  /**
   * Boxes from the farthest to the nearest, by the planes between those that overlap on the page.
   * An order of others would only close circles that are not there.
   */
  function painted(solid, view, flat) {
    const spans = flat.map((points) => {
      const xs = points.map((point) => point[0]);
      const ys = points.map((point) => point[1]);
      return [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    });
    const apart = (i, j) => {
      const [p, q] = [spans[i], spans[j]];
      return p[1] < q[0] || q[1] < p[0] || p[3] < q[2] || q[3] < p[2] ||
        apartOnPage(flat[i], flat[j]);
    };
    const behind = solid.boxes.map(() => []);
    for (const { i, j, axis } of solid.planes) {
      if (apart(i, j)) continue;
      const side = FD.solid.dot(axis, view);
      if (side > 1e-9) behind[j].push(i);
      else if (side < -1e-9) behind[i].push(j);
    }
    const order = [];
    const seen = new Uint8Array(behind.length);
    const visit = (k) => {
      if (seen[k]) return;
      seen[k] = 1;
      behind[k].forEach(visit);
      order.push(k);
    };
    behind.forEach((_, k) => visit(k));
    return order;
  }

  /** What one drawing consists of: lists of [class, points or path], from back to front. */
  function picture(solid, patches, state, scale) {
    const { right, up, view } = camera(state);
    const middle = [0, 0.5 * solid.size[1], 0];
    const size = scale * state.zoom;
    const flatten = (point) => {
      const from = [point[0] - middle[0], point[1] - middle[1], point[2] - middle[2]];
      return [WIDTH / 2 + size * FD.solid.dot(from, right),
        HEIGHT / 2 - size * FD.solid.dot(from, up)];
    };
    const text = (points) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
    const shade = (normal) => Math.round((SHADES - 1) *
      Math.min(1, Math.max(0, 0.5 + 0.55 * FD.solid.dot(normal, LIGHT))));
    const far = [];
    const near = [];
    let hidden = "";
    let shown = "";
    if (solid.body) {
      const flat = solid.body.vertices.map(flatten);
      const facing = solid.body.faces.map(({ normal }) => FD.solid.dot(normal, view) > 1e-9);
      solid.body.faces.forEach(({ polygon, normal }, k) => {
        const list = facing[k] ? near : far;
        list.push([`v-body v-shade-${shade(normal)}`, text(polygon.map((at) => flat[at]))]);
      });
      for (const { from, to, faces, sharp } of solid.body.edges) {
        const front = faces.some((face) => facing[face]);
        if (!sharp && faces.every((face) => facing[face] === front)) continue;
        const path = `M${text([flat[from]])}L${text([flat[to]])}`;
        if (front) shown += path;
        else hidden += path;
      }
    }
    const boxes = solid.boxes.map((box) => box.vertices.map(flatten));
    const inner = [];
    for (const k of painted(solid, view, boxes)) {
      const { faces, kind, marks } = solid.boxes[k];
      for (const { polygon, normal } of faces)
        if (FD.solid.dot(normal, view) > 1e-9)
          inner.push([`v-${kind} v-shade-${shade(normal)}`,
            text(polygon.map((at) => boxes[k][at]))]);
      for (const mark of marks)
        if (FD.solid.dot(mark.normal, view) > 1e-9)
          inner.push([`v-${mark.kind}`, text(mark.points.map(flatten))]);
    }
    // The surface is seen from above, or not at all.
    const touched = view[1] < 0.02 ? [] : patches.map(([name, points]) =>
      [name, text(points.map(flatten))]);
    return { far, inner, near, touched, hidden, shown };
  }

  /** A pool of polygons that takes a list of [class, points]; spare ones are taken out. */
  function pool(parent) {
    const held = [];
    return (list) => {
      list.forEach(([name, points], k) => {
        if (!held[k]) parent.append((held[k] = FD.svg("polygon", {})));
        held[k].setAttribute("class", name);
        held[k].setAttribute("points", points);
      });
      held.splice(list.length).forEach((spare) => spare.remove());
    };
  }

  /** A round length, mm, that takes some 80 of the drawing's units. */
  function scaleBar(size) {
    const power = 10 ** Math.floor(Math.log10(80 / size));
    return [5, 2, 1].map((each) => each * power).find((length) => length * size <= 90) || power;
  }

  /** One finger's drawing; `moved(change)` is told what a hand or key asks for. */
  function drawing(item, scale, moved) {
    const solid = FD.solid.solid(item.geometry);
    const svg = FD.svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "v-space", tabindex: "0",
      role: "application", "aria-roledescription": "view that can be turned",
      "aria-label": `${item.letter}: ${item.name}. ${item.geometry.words} ` +
        `${item.geometry.note} ${HELP}` });
    const layers = ["v-far", "v-inner", "v-near", "v-touched"].map((name) =>
      FD.svg("g", { class: name }));
    const patches = FD.patches(item.geometry, item.traces || {});
    let touched = [];
    const hidden = FD.svg("path", { class: "v-edge v-hidden" });
    const shown = FD.svg("path", { class: "v-edge" });
    const signs = FD.svg("g", { class: "v-signs" });
    svg.append(layers[0], hidden, ...layers.slice(1), shown, signs);
    const fill = layers.map(pool);
    function draw(state) {
      const made = picture(solid, touched, state, scale);
      fill[0](made.far);
      fill[1](made.inner);
      fill[2](made.near);
      fill[3](made.touched);
      hidden.setAttribute("d", made.hidden);
      shown.setAttribute("d", made.shown);
      const length = scaleBar(scale * state.zoom);
      const { right, up } = camera(state);
      const axes = ["x", "y", "z"].flatMap((name, k) => {
        const [dx, dy] = [24 * right[k], -24 * up[k]];
        if (Math.hypot(dx, dy) < 5) return [];
        const d = `M36 ${HEIGHT - 40}l${dx.toFixed(1)} ${dy.toFixed(1)}`;
        return [FD.svg("path", { class: "v-axis", d }),
          FD.svg("text", { x: (36 + 1.35 * dx).toFixed(1), y: (HEIGHT - 36 + 1.35 * dy).toFixed(1),
            "text-anchor": "middle" }, name)];
      });
      const end = WIDTH - 12;
      signs.replaceChildren(...axes,
        FD.svg("path", { class: "v-axis",
          d: `M${(end - length * scale * state.zoom).toFixed(1)} ${HEIGHT - 12}H${end}m0 -4v8` }),
        FD.svg("text", { x: end, y: HEIGHT - 20, "text-anchor": "end" },
          `${FD.draw.number(length)} mm`));
    }
    listen(svg, moved);
    return { svg, draw, touch(k) {
      touched = patches(k);
    } };
  }

  /** Hands and keys: `moved` gets {turn, tilt, zoom (a factor)} or "reset". */
  function listen(svg, moved) {
    const hands = new Map();
    const spread = () => {
      const [p, q] = [...hands.values()];
      return Math.hypot(p[0] - q[0], p[1] - q[1]);
    };
    svg.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      hands.set(event.pointerId, [event.clientX, event.clientY]);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const from = hands.get(event.pointerId);
      if (!from) return;
      const before = hands.size === 2 ? spread() : 0;
      hands.set(event.pointerId, [event.clientX, event.clientY]);
      if (hands.size === 2) moved({ zoom: spread() / (before || 1) });
      else if (hands.size === 1)
        moved({ turn: 0.5 * (from[0] - event.clientX), tilt: 0.5 * (event.clientY - from[1]) });
    });
    for (const name of ["pointerup", "pointercancel"])
      svg.addEventListener(name, (event) => hands.delete(event.pointerId));
    // Only where the view has the focus: the wheel otherwise scrolls the page.
    svg.addEventListener("wheel", (event) => {
      if (document.activeElement !== svg) return;
      event.preventDefault();
      moved({ zoom: Math.exp(-0.0015 * event.deltaY) });
    }, { passive: false });
    const keys = { ArrowLeft: { turn: 10 }, ArrowRight: { turn: -10 }, ArrowUp: { tilt: -10 },
      ArrowDown: { tilt: 10 }, "+": { zoom: 1.2 }, "=": { zoom: 1.2 }, "-": { zoom: 1 / 1.2 },
      0: "reset" };
    svg.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys)) return;
      event.preventDefault();
      moved(keys[event.key]);
    });
  }

  /** The drawings of one or two fingers: items {letter, name, geometry (null: not known), traces};
   * returns what follows the increment. */
  function show(items, container, columns) {
    const drawn = items.filter((item) => item.geometry && item.geometry.body);
    // One scale for both: what is longer is drawn longer, however it is turned.
    const reach = Math.max(...drawn.map((item) => Math.hypot(...item.geometry.size)), 1e-6);
    const scale = HEIGHT / reach;
    const states = drawn.map(() => ({ ...kept }));
    const pictures = [];
    const together = FD.el("input", { type: "checkbox" });
    together.checked = true;
    const told = FD.el("span", { class: "v-told", role: "status" });
    let wait = 0;
    const redraw = () => pictures.forEach((each, k) => each.draw(states[k]));
    function set(k, state) {
      states.forEach((_, other) => {
        if (other === k || k === null || together.checked) states[other] = limited({ ...state });
      });
      kept = states[k || 0];
      redraw();
      clearTimeout(wait);
      wait = setTimeout(() => {
        const { turn, tilt, zoom } = states[k || 0];
        told.textContent = `turned ${Math.round(turn)}°, tilted ${Math.round(tilt)}°, ` +
          `${Math.round(100 * zoom)} %`;
      }, 300);
    }
    const moved = (k, change) => {
      if (change === "reset") return set(k, START);
      const { turn = 0, tilt = 0, zoom = 1 } = change;
      return set(k, { turn: states[k].turn + turn, tilt: states[k].tilt + tilt,
        zoom: states[k].zoom * zoom });
    };
    const bar = FD.el("div", { class: "v-bar" });
    const button = (words, name, act) => {
      const made = FD.el("button", { type: "button", "aria-label": name }, words);
      made.addEventListener("click", act);
      bar.append(made);
    };
    for (const [name, state] of Object.entries(VIEWS))
      button(name, name === "Reset" ? "Reset the view" : `View from the ${name.toLowerCase()}`,
        () => set(null, state));
    button("+", "Zoom in", () => states.forEach((_, k) => (k === 0 || !together.checked) &&
      moved(k, { zoom: 1.2 })));
    button("−", "Zoom out", () => states.forEach((_, k) => (k === 0 || !together.checked) &&
      moved(k, { zoom: 1 / 1.2 })));
    if (drawn.length > 1) bar.append(FD.el("label", {}, together, " turn both together"));
    bar.append(told);
    if (drawn.length) container.append(bar);
    items.forEach((item, column) => {
      const k = drawn.indexOf(item);
      const cell = columns[column];
      if (k >= 0) {
        pictures[k] = drawing(item, scale, (change) => moved(k, change));
        cell.append(pictures[k].svg);
      }
      const geometry = item.geometry || { words: "", note: "Its shape is not known." };
      cell.append(FD.el("p", { class: "quiet" }, `${geometry.words} ${geometry.note}`.trim()));
    });
    redraw();
    return drawn.length ? [(k) => {
      pictures.forEach((each) => each.touch(k));
      redraw();
    }] : [];
  }

  FD.shape = { show, HELP, camera, painted };
})();
