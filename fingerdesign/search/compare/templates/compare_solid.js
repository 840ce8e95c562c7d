// From a packed shape (search/compare/geometry.py) to polygons, and which box hides which.
// Axes as everywhere: x tangential, y normal (crest up), z along the plates; mm.
(() => {
  "use strict";
  const FD = (window.FD = window.FD || {});
  const SHARP_DEG = 14; // facets of one surface meet at under 7 degrees
  const BENT_RAD = 0.17; // a bent plate is drawn as boxes that turn by at most this
  const CLOSE = 1e-6;

  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => {
    const size = Math.hypot(...a) || 1;
    return [a[0] / size, a[1] / size, a[2] / size];
  };

  /** Outward normal of a polygon, anticlockwise seen from outside (Newell's sum). */
  function normalOf(vertices, polygon) {
    const sum = [0, 0, 0];
    polygon.forEach((from, k) => {
      const a = vertices[from];
      const b = vertices[polygon[(k + 1) % polygon.length]];
      sum[0] += (a[1] - b[1]) * (a[2] + b[2]);
      sum[1] += (a[2] - b[2]) * (a[0] + b[0]);
      sum[2] += (a[0] - b[0]) * (a[1] + b[1]);
    });
    return unit(sum);
  }

  /** Polygons with normals, and the edges between them: sharp, or seen as outline only. */
  function mesh(vertices, polygons, sharp = SHARP_DEG) {
    const edgeCos = Math.cos((sharp * Math.PI) / 180);
    const faces = polygons.map((polygon) => ({ polygon, normal: normalOf(vertices, polygon) }));
    const known = new Map();
    faces.forEach(({ polygon }, face) =>
      polygon.forEach((from, k) => {
        const to = polygon[(k + 1) % polygon.length];
        const key = from < to ? `${from} ${to}` : `${to} ${from}`;
        if (!known.has(key)) known.set(key, { from, to, faces: [] });
        known.get(key).faces.push(face);
      }));
    const edges = [...known.values()].map((edge) => {
      const [first, second] = edge.faces.map((face) => faces[face].normal);
      return { ...edge, sharp: second === undefined || dot(first, second) < edgeCos };
    });
    return { vertices, faces, edges };
  }

  /** Heights over lines of x and z (null: none), with straight sides down to y = 0. */
  function gridBody([xs, zs, heights], sharp) {
    const vertices = [];
    const numbers = new Map();
    const lines = heights.length / xs.length;
    const height = (i, j) => heights[i * lines + j];
    const z = (i, j) => (zs.length === heights.length ? zs[i * lines + j] : zs[j]);
    const vertex = (i, j, top) => {
      const key = `${i} ${j} ${top}`;
      if (!numbers.has(key)) {
        numbers.set(key, vertices.length);
        vertices.push([xs[i], top ? height(i, j) : 0, z(i, j)]);
      }
      return numbers.get(key);
    };
    const corners = (i, j) => [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]];
    const there = (i, j) => i >= 0 && j >= 0 && i < xs.length - 1 && j < lines - 1 &&
      corners(i, j).every(([p, q]) => height(p, q) !== null);
    const polygons = [];
    for (let i = 0; i < xs.length - 1; i += 1)
      for (let j = 0; j < lines - 1; j += 1) {
        if (!there(i, j)) continue;
        const ring = corners(i, j);
        polygons.push(ring.map(([p, q]) => vertex(p, q, true)));
        polygons.push([...ring].reverse().map(([p, q]) => vertex(p, q, false)));
        const beside = [[i - 1, j], [i, j + 1], [i + 1, j], [i, j - 1]];
        beside.forEach(([p, q], side) => {
          if (there(p, q)) return;
          const [a, b] = [ring[side], ring[(side + 1) % 4]];
          polygons.push([vertex(...a, true), vertex(...a, false), vertex(...b, false),
            vertex(...b, true)]);
        });
      }
    return mesh(vertices, polygons, sharp);
  }

  /** Half an outline (r, y, ... from the crest outward) turned about y, down to y = 0. */
  function turnedBody(rings) {
    const count = 36;
    const vertices = [[0, rings[1], 0]];
    const around = (r, y) => {
      const first = vertices.length;
      for (let k = 0; k < count; k += 1) {
        const angle = (2 * Math.PI * k) / count;
        vertices.push([r * Math.cos(angle), y, -r * Math.sin(angle)]);
      }
      return Array.from({ length: count }, (_, k) => first + k);
    };
    const polygons = [];
    let above = null;
    for (let k = 2; k <= rings.length; k += 2) {
      const last = k === rings.length;
      const ring = around(rings[last ? k - 2 : k], last ? 0 : rings[k + 1]);
      ring.forEach((from, m) => {
        const to = ring[(m + 1) % count];
        polygons.push(above === null ? [0, from, to]
          : [above[m], from, to, above[(m + 1) % count]]);
      });
      above = ring;
    }
    polygons.push([...above].reverse());
    return mesh(vertices, polygons);
  }

  const BOX = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

  /** A box of corners 0-3 (anticlockwise, one end) and 4-7 (the other end). */
  function box(vertices, kind, marks = []) {
    let polygons = BOX;
    if (dot(normalOf(vertices, BOX[1]), minus(vertices[4], vertices[0])) < 0)
      polygons = BOX.map((polygon) => [...polygon].reverse()); // plates along z: left-handed
    const faces = polygons.map((polygon) => ({ polygon, normal: normalOf(vertices, polygon) }));
    const reach = [0, 1, 2].map((k) => {
      const places = vertices.map((vertex) => vertex[k]);
      return [Math.min(...places), Math.max(...places)];
    });
    return { vertices, faces, kind, marks, reach };
  }

  /** The boxes of one plate; the middle one carries its gages and holes as marks. */
  function plate(packed, gages) {
    const [place, y, angle, length, thickness, low, high, alongZ, bend, hole, ...holes] = packed;
    const turn = (angle * Math.PI) / 180;
    const [ax, ay] = [Math.cos(turn), Math.sin(turn)];
    const space = (s, v, w) => {
      let [along, up] = [s, v];
      if (bend) {
        along = (bend + v) * Math.sin(s / bend);
        up = (bend + v) * Math.cos(s / bend) - bend;
      }
      const p = place + along * ax - up * ay;
      const q = y + along * ay + up * ax;
      return alongZ ? [w, q, p] : [p, q, w];
    };
    const half = 0.5 * thickness;
    // Odd: the middle one carries the gage.
    const count = bend ? 2 * Math.ceil((length / bend / BENT_RAD - 1) / 2) + 1 : 1;
    const patch = (face, points, kind) => ({ kind, points, face });
    const marks = [];
    const middle = 0.5 * (low + high) + (gages ? gages.z : 0);
    const sides = gages ? [[half, 1, gages.upper], [-half, -1, gages.lower]] : [];
    for (const [v, side, there] of sides) {
      for (const w of holes)
        marks.push(patch(side, Array.from({ length: 16 }, (_, k) => space(
          hole * Math.cos((Math.PI * k) / 8), v, w + hole * Math.sin((Math.PI * k) / 8))), "hole"));
      if (!there) continue;
      const s = Math.min(0.5 * gages.length, (0.5 * length) / count);
      const w = [Math.max(low, middle - 0.5 * gages.width),
        Math.min(high, middle + 0.5 * gages.width)];
      marks.push(patch(side, [[-s, w[0]], [s, w[0]], [s, w[1]], [-s, w[1]]].map(
        ([p, q]) => space(p, v, q)), "gage"));
    }
    const upward = alongZ ? [0, ax, -ay] : [-ay, ax, 0];
    marks.forEach((mark) => (mark.normal = upward.map((part) => part * mark.face)));
    return Array.from({ length: count }, (_, k) => {
      const [from, to] = [k / count - 0.5, (k + 1) / count - 0.5].map((share) => share * length);
      const end = (w) => [space(from, -half, w), space(to, -half, w), space(to, half, w),
        space(from, half, w)];
      return box([...end(low), ...end(high)], "plate", k === (count - 1) / 2 ? marks : []);
    });
  }

  /** A direction along which box `a` lies wholly below box `b`; null: they cross. */
  function between(a, b) {
    for (const k of [0, 1, 2]) { // cheap, and enough for most
      const axis = [0, 0, 0];
      axis[k] = 1;
      if (a.reach[k][1] <= b.reach[k][0] + CLOSE) return axis;
      axis[k] = -1;
      if (b.reach[k][1] <= a.reach[k][0] + CLOSE) return axis;
    }
    const axes = [...a.faces.map((face) => face.normal), ...b.faces.map((face) => face.normal)];
    const edges = (each) => [minus(each.vertices[1], each.vertices[0]),
      minus(each.vertices[3], each.vertices[0]), minus(each.vertices[4], each.vertices[0])];
    const tried = function* () {
      yield* axes;
      for (const p of edges(a)) for (const q of edges(b)) yield unit(cross(p, q));
    };
    for (const axis of tried()) {
      if (dot(axis, axis) < 0.5) continue;
      const reach = (each) => {
        const along = each.vertices.map((vertex) => dot(axis, vertex));
        return [Math.min(...along), Math.max(...along)];
      };
      const [p, q] = [reach(a), reach(b)];
      if (p[1] <= q[0] + CLOSE) return axis;
      if (q[1] <= p[0] + CLOSE) return axis.map((part) => -part);
    }
    return null;
  }

  /** Body, boxes (core, plates) and, pair by pair, the plane between two boxes. */
  function solid(packed) {
    const { body } = packed;
    const boxes = packed.plates.flatMap((each) => plate(each, packed.gages));
    if (packed.core) {
      const [x0, x1, y0, y1, z0, z1] = packed.core;
      const end = (z) => [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
      boxes.push(box([...end(z0), ...end(z1)], "core"));
    }
    const planes = [];
    for (let i = 0; i < boxes.length; i += 1)
      for (let j = i + 1; j < boxes.length; j += 1) {
        const axis = between(boxes[i], boxes[j]);
        if (axis) planes.push({ i, j, axis });
      }
    const drawn = body === null ? null
      : body.grid ? gridBody(body.grid, body.sharp_deg) : turnedBody(body.rings);
    return { body: drawn, boxes, planes, size: packed.size };
  }

  FD.solid = { solid, dot };
})();
