// What the charts of all designs that pass the filter have in common.
FD.sentence = (number, columns) => `${FD.name(number)}: ${columns.map((column) =>
  `${column.heading} ${FD.number(FD.value(number, column))}`).join(", ")}`;
/** A chart whose designs are gone through by keys and mouse: Enter or a click chooses. */
FD.walked = (id, { order, ring, sentence, draw }) => {
  const place = FD.byId(id);
  if (!place) return () => {};
  let at = null; // the active design
  const move = (number) => {
    at = number;
    FD.byId(`${id}-active`).textContent = at === null ? "" : sentence(at);
    const { x, y } = ring(at);
    if (place.data) Plotly.restyle(place, { x: [x], y: [y] }, [1]);
  };
  const ways = { ...FD.WAYS, ArrowUp: 1, ArrowDown: -1, ArrowRight: 1, ArrowLeft: -1 };
  place.addEventListener("keydown", (event) => {
    const list = order(event.key === "ArrowUp" || event.key === "ArrowDown");
    if (event.ctrlKey || event.metaKey || event.altKey || !list.length) return;
    if (event.key in ways) move(FD.step(list, at, ways[event.key]));
    else if (event.key === "Escape") move(null);
    else if (event.key !== "Enter" && event.key !== " ") return;
    else if (at !== null) FD.toggle(at);
    event.preventDefault();
  });
  const under = (event) => event.points[0].customdata ?? null;
  const events = { plotly_hover: (event) => under(event) !== at && move(under(event)),
    plotly_click: (event) => FD.toggle(under(event)),
    plotly_selected: (event) => event?.range && FD.bound(event.range) };
  const again = FD.lazily(place.parentElement, () => {
    const drawn = draw((...chart) => FD.chart(place, ...chart, events), place);
    move(drawn.includes(at) ? at : null);
  });
  for (const event of ["shown", "select"]) FD.on(event, again);
  return again;
};
