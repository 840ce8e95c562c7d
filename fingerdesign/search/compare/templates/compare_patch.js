// What sticks and what slips at an increment, as patches on the drawn surface: strips along z in
// plane strain, a small square a point in 3-D.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const KINDS = { "#": "v-patch v-stick", "/": "v-patch v-slipping" };
  const PIECES = 12; // of a strip's side, so that it follows the surface
  const LIFT = 0.02; // mm above the surface

  /** Where `value` lies among sorted places: the place before it, and the share of the way on. */
  function between(places, value) {
    const last = places.length - 2;
    let k = 0;
    while (k < last && places[k + 1] < value) k += 1;
    const share = (value - places[k]) / (places[k + 1] - places[k] || 1);
    return [k, Math.min(1, Math.max(0, share))];
  }

  const mixed = (a, b, share) => (a === null || b === null ? null : a + share * (b - a));

  /** The drawn surface: its height at (x, z), null where there is none; its ends in z over x. */
  function heightOf({ grid, rings }) {
    if (rings) {
      const r = rings.filter((_, k) => k % 2 === 0);
      const y = rings.filter((_, k) => k % 2 === 1);
      return {
        at(x, z) {
          const [k, share] = between(r, Math.hypot(x, z));
          return mixed(y[k], y[k + 1], share);
        },
        ends(x) {
          const far = Math.sqrt(Math.max(0, r[r.length - 1] ** 2 - x ** 2));
          return [-far, far];
        },
      };
    }
    const [xs, zs, heights] = grid;
    const lines = heights.length / xs.length;
    const own = (i) => (zs.length === heights.length ? zs.slice(i * lines, (i + 1) * lines) : zs);
    const along = (i, z) => {
      const [j, share] = between(own(i), z);
      return mixed(heights[i * lines + j], heights[i * lines + j + 1], share);
    };
    return {
      at(x, z) {
        const [i, share] = between(xs, x);
        return mixed(along(i, z), along(i + 1, z), share);
      },
      ends(x) {
        const [i, share] = between(xs, x);
        const [p, q] = [own(i), own(i + 1)];
        return [mixed(p[0], q[0], share), mixed(p[lines - 1], q[lines - 1], share)];
      },
    };
  }

  /** The corners in space of the patch over [x0, x1] by [z0, z1]; null where no surface is. */
  function patch(height, pieces, x0, x1, z0, z1) {
    const ring = [[x0, z0], [x1, z0], [x1, z1], [x0, z1]];
    const points = ring.flatMap(([x, z], k) => {
      const [u, w] = ring[(k + 1) % 4];
      return Array.from({ length: pieces }, (_, m) =>
        [x + (m / pieces) * (u - x), z + (m / pieces) * (w - z)]);
    }).map(([x, z]) => {
      const [near, far] = height.ends(x);
      const there = Math.min(far, Math.max(near, z));
      return [x, height.at(x, there), there];
    });
    return points.some(([, y]) => y === null) ? null
      : points.map(([x, y, z]) => [x, y + LIFT, z]);
  }

  /** A function of the increment that gives [class, corners in space] of every patch. */
  function patches(geometry, traces) {
    const { contact_x_mm: x = [], contact_z_mm: z = [], status = [] } = traces;
    if (!geometry.body || !x.length || !status.length) return () => [];
    const height = heightOf(geometry.body);
    const row = (k) => FD.status(status[Math.min(k, status.length - 1)], x.length);
    const made = (kind, pieces, ...ends) => {
      const points = patch(height, pieces, ...ends);
      return points ? [[KINDS[kind], points]] : [];
    };
    if (z.length) {
      const span = (list) => Math.max(...list) - Math.min(...list);
      const half = 0.4 * Math.sqrt((span(x) * span(z)) / x.length) || 0.1;
      const mirrored = z.every((place) => place >= -1e-9);
      return (k) => [...row(k)].flatMap((kind, point) => (!(kind in KINDS) ? []
        : (mirrored && z[point] > half ? [1, -1] : [1]).flatMap((side) =>
          made(kind, 1, x[point] - half, x[point] + half, side * z[point] - half,
            side * z[point] + half))));
    }
    const order = x.map((_, k) => k).sort((p, q) => x[p] - x[q]);
    const sorted = order.map((k) => x[k]);
    const edge = (k) => (k <= 0 ? sorted[0] : k >= sorted.length ? sorted[sorted.length - 1]
      : 0.5 * (sorted[k - 1] + sorted[k]));
    const deep = 0.5 * geometry.size[2];
    return (k) => {
      const given = row(k);
      const text = order.map((point) => given[point]).join("");
      return [...text.matchAll(/#+|\/+/g)].flatMap((run) =>
        made(run[0][0], PIECES, edge(run.index), edge(run.index + run[0].length), -deep, deep));
    };
  }

  FD.patches = patches;
})();
