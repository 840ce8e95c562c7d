// Two chosen designs side by side: shape, contact, gages, forces, and how far to believe them.
// One slider moves the increment of all pictures. FD.views.show(a, b, container).
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const READINGS = [["normal_force_N", "normal force (N)"],
    ["tangential_force_N", "tangential force (N)"], ["stick_ratio", "stick ratio"],
    ["contact_width_mm", "contact width (mm)"], ["approach_mm", "approach (mm)"],
    ["shear_mm", "shear (mm)"]];
  const FIDELITY = { "plane-strain": "plane strain", "3d": "three dimensions",
    auto: "chosen by tolerance" };
  let kept = Infinity; // the chosen increment, for the next pair too
  const percent = (share) =>
    (FD.draw.isNumber(share) ? `${FD.draw.number(100 * share, 2)} %` : "not estimated");

  /** What is drawn of a design: the page's data and its detail, none of them missing. */
  function itemOf(index, letter) {
    const design = FD.data.designs[index];
    const detail = FD.detail(index) || {};
    return { ...design, letter, traces: detail.traces || {}, grips: detail.grips || [],
      geometry: detail.geometry || null, validity: design.validity || {},
      warnings: design.warnings || [] };
  }

  const mark = (letter) => FD.el("span", { class: `v-letter v-letter-${letter}` }, letter);

  /** A heading, a word on reading, and a column a design. */
  function section(container, title, reading, items) {
    const columns = items.map(({ letter, name }) =>
      FD.el("div", { class: "v-column" }, FD.el("h4", {}, mark(letter), ` ${name}`)));
    const before = FD.el("div", {});
    const after = FD.el("div", {});
    container.append(FD.el("section", { class: "v-section" }, FD.el("h3", {}, title),
      FD.el("p", { class: "quiet" }, reading), before,
      FD.el("div", { class: `v-columns v-columns-${items.length}` }, ...columns), after));
    return { before, columns, after };
  }

  /** The slider and the readings at its increment; `followers` are told the increment. */
  function increments(bar, below, items, followers) {
    const lengths = items.map(({ traces }) => Math.max((traces.normal_force_N || []).length,
      (traces.gages || []).length, (traces.status || []).length));
    const count = Math.max(...lengths);
    if (!count) return;
    const id = FD.draw.id();
    const slider = FD.el("input", { type: "range", id, min: "1", max: String(count), step: "1" });
    slider.value = String(Math.min(kept, count));
    const shown = FD.el("output", { for: id });
    const readings = READINGS.filter(([key]) =>
      items.some(({ traces }) => (traces[key] || []).length));
    const cells = items.map(() => readings.map(() => FD.el("td", {})));
    const table = FD.el("table", { class: "v-readings" },
      FD.el("caption", {}, "At the chosen increment"),
      FD.el("thead", {}, FD.el("tr", {}, FD.el("th", { class: "text", scope: "col" }, "design"),
        ...readings.map(([, words]) => FD.el("th", { scope: "col" }, words)))),
      FD.el("tbody", {}, ...items.map(({ letter, name }, k) => FD.el("tr", {},
        FD.el("th", { class: "text", scope: "row" }, mark(letter), ` ${name}`), ...cells[k]))));
    const follow = () => {
      const chosen = Number(slider.value);
      const past = items.flatMap(({ letter }, k) =>
        lengths[k] && lengths[k] < chosen ? [`${letter} ends at ${lengths[k]}`] : []);
      shown.textContent = `${chosen} of ${count}${past.length ? ` (${past.join("; ")})` : ""}`;
      items.forEach(({ traces }, k) => readings.forEach(([key], column) => {
        const values = traces[key] || [];
        cells[k][column].textContent = FD.draw.number(values[Math.min(chosen, values.length) - 1]);
      }));
      followers.forEach((each) => each(chosen - 1));
    };
    slider.addEventListener("input", () => {
      const chosen = Number(slider.value);
      kept = chosen === count ? Infinity : chosen; // the last stays the last
      follow();
    });
    bar.append(FD.el("div", { class: "v-bar v-slider" },
      FD.el("label", { for: id }, "Increment of the path"), slider, shown));
    below.append(table);
    follow();
  }

  function validity({ columns }, items) {
    items.forEach((item, k) => {
      const { plane_strain_error: flat, mesh_error: mesh, sentences = [] } = item.validity;
      const facts = [["Computed in", FIDELITY[item.fidelity] || item.fidelity || "not known"],
        ["Plane strain overstates the normal force by",
          item.fidelity === "3d" ? "not used" : percent(flat)],
        ["Error from the mesh", percent(mesh)]];
      const list = FD.el("dl", { class: "v-facts" });
      for (const [words, value] of facts)
        list.append(FD.el("dt", {}, words), FD.el("dd", {}, value));
      columns[k].append(list);
      const told = [...sentences, ...item.warnings];
      if (told.length)
        columns[k].append(FD.el("ul", {}, ...told.map((sentence) => FD.el("li", {}, sentence))));
    });
  }

  /** Draw design a, and b (or null) beside it, in the container; what was there is gone. */
  function show(a, b, container) {
    const chosen = [a, b].filter((index) => FD.draw.isNumber(index) && FD.data.designs[index]);
    container.replaceChildren();
    container.classList.add("v-views");
    if (!chosen.length) {
      container.append(FD.el("p", {}, "No design is chosen."));
      return;
    }
    const items = chosen.map((index) => itemOf(index, index === a ? "A" : "B"));
    for (const { letter, name, failure } of items)
      if (failure)
        container.append(FD.el("p", { class: "warnings" }, mark(letter),
          ` ${name} has no result: ${failure.sentence}`));
    const contact = items.filter(({ traces }) => (traces.status || []).length);
    const deep = contact.some(({ traces }) => (traces.contact_z_mm || []).length);
    const flat = contact.some(({ traces }) => !(traces.contact_z_mm || []).length);
    const shape = section(container, "Shape", "Body (see-through), plates, and the gages on them " +
      "as pale patches; all at one scale. " + (contact.length ? "On top, at the chosen " +
      "increment: what sticks (filled) and slips (pale, dotted outline). " : "") +
      `Drag to turn, or click and use the keys. ${FD.shape.HELP}`, items);
    const followers = FD.shape.show(items, shape.before, shape.columns);
    const bar = FD.el("div", { class: "v-increment" });
    const readings = FD.el("div", { class: "scroll", tabindex: "0", role: "region",
      "aria-label": "Readings at the chosen increment" });
    container.append(bar, readings);
    const add = (part, title, reading) => {
      const { columns, after } = section(container, title, reading, items);
      followers.push(...part.show(items, after, columns));
    };
    add(FD.contact, "Contact", "Where the surface is open, sticks and slips" +
      (flat ? ", over x, a row an increment of the path; the frame is the chosen increment" : "") +
      (deep ? ", seen from above at the chosen increment, marked point by point" : "") + ".");
    add(FD.gages, "Gages", "Every gage along the path (thin), one of them brought out with its " +
      "number; the upright line is the chosen increment. Tension is positive.");
    add(FD.forces, "Forces against the friction limits", "Tangential over normal force. A path " +
      "that reaches the straight line of its own friction slips as a whole; the farther right of " +
      "it, the more force is spent on safety.");
    increments(bar, readings, items, followers);
    validity(section(container, "How far to believe it", "Forecasts and estimates of the error, " +
      "and what the analysis warns of.", items), items);
  }

  FD.views = { show };
})();
