'use strict';
// The page's program. Data flows one way: payload -> runs (decoded) -> pose at a time -> what is drawn.
(function () {
const data = JSON.parse(document.getElementById('perp-data').textContent);
const $ = id => document.getElementById(id);

// ---- payload -> numbers ------------------------------------------------------------------------------------------
function bytes(text) {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out.buffer;
}
// {type, data, n, low, step}: n numbers a row; integers stand for low + step times them
function numbers(a) {
  const buffer = bytes(a.data);
  if (a.type === 'f64') return new Float64Array(buffer);
  if (a.type === 'f32') return Float64Array.from(new Float32Array(buffer));
  const whole = a.type === 'u8' ? new Uint8Array(buffer) : new Uint16Array(buffer);
  const out = new Float64Array(whole.length), n = a.low ? a.low.length : 1;
  for (let i = 0; i < whole.length; ++i) out[i] = a.low ? a.low[i % n] + a.step[i % n] * whole[i] : whole[i];
  return out;
}
for (const run of data.runs) {
  for (const body of run.bodies) for (const k of ['t', 'p', 'q', 'v', 'w']) body[k] = numbers(body.keys[k]);
  for (const s of run.series) { s.t = numbers(s.t); s.y = numbers(s.y); }
  const c = run.contacts;
  if (c) for (const k of ['t', 'first', 'position', 'normal', 'friction', 'scale', 'mode', 'name']) c[k] = numbers(c[k]);
}
const [t0, t1] = data.time;
const main = data.runs[0];

// ---- pose at a time ----------------------------------------------------------------------------------------------
// The last index with t[i] <= x, at least 0.
function before(t, x) {
  let low = 0, high = t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (t[middle] <= x) low = middle; else high = middle - 1;
  }
  return low;
}
// Cubic Hermite of n components between keys i and i + 1; `rate(j)` gives both slopes.
function hermite(y0, d0, y1, d1, s, h) {
  const s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * y0 + (s3 - 2 * s2 + s) * h * d0 + (3 * s2 - 2 * s3) * y1 + (s3 - s2) * h * d1;
}
// Component k of half (0, w) q, w in world axes: of the quaternion at q[i] and the vector at w[j].
function quaternion_rate(q, i, w, j, k) {
  const a = q[i], b = q[i + 1], c = q[i + 2], d = q[i + 3], x = w[j], y = w[j + 1], z = w[j + 2];
  return (k === 0 ? -(x * b + y * c + z * d) : k === 1 ? x * a + y * d - z * c : k === 2 ? y * a + z * b - x * d : z * a + x * c - y * b) / 2;
}
function slice(a, i, n) { return Array.prototype.slice.call(a, i * n, i * n + n); }
// Position and quaternion of the body at t into out[0..6]: nothing is allocated, for frames of a thousand bodies.
function pose_into(body, t, out) {
  const { p, q, v, w } = body, i = before(body.t, t);
  const whole = i === body.t.length - 1 || t <= body.t[0] || body.t[i] === t;
  if (whole) {
    for (let k = 0; k < 3; ++k) out[k] = p[3 * i + k];
    for (let k = 0; k < 4; ++k) out[3 + k] = q[4 * i + k];
    return;
  }
  const h = body.t[i + 1] - body.t[i], s = (t - body.t[i]) / h, a = 4 * i, b = a + 4, c = 3 * i, d = c + 3;
  for (let k = 0; k < 3; ++k) out[k] = hermite(p[c + k], v[c + k], p[d + k], v[d + k], s, h);
  const sign = q[a] * q[b] + q[a + 1] * q[b + 1] + q[a + 2] * q[b + 2] + q[a + 3] * q[b + 3] < 0 ? -1 : 1;
  let length = 0;
  for (let k = 0; k < 4; ++k) {
    const rate_a = quaternion_rate(q, a, w, c, k), rate_b = sign * quaternion_rate(q, b, w, d, k);
    out[3 + k] = hermite(q[a + k], rate_a, sign * q[b + k], rate_b, s, h);
    length += out[3 + k] * out[3 + k];
  }
  length = Math.sqrt(length);
  for (let k = 3; k < 7; ++k) out[k] /= length;
}
const one_pose = new Float64Array(7);
function pose_of(body, t) {
  pose_into(body, t, one_pose);
  const i = before(body.t, t), j = Math.min(i + 1, body.t.length - 1), h = body.t[j] - body.t[i];
  const s = h > 0 ? Math.max(0, Math.min(1, (t - body.t[i]) / h)) : 0;
  const blend = a => [0, 1, 2].map(k => a[3 * i + k] + s * (a[3 * j + k] - a[3 * i + k]));
  return { position: slice(one_pose, 0, 3), orientation: Array.from(one_pose.subarray(3)), velocity: blend(body.v), angular_velocity: blend(body.w) };
}
function value_of(series, t) {
  if (series.t.length === 0) return NaN;
  return series.y[before(series.t, t)];
}

// ---- columns: those of report and joints, and of bodies from their poses -------------------------------------------
const parts = { spatial: ['x', 'y', 'z', 'qw', 'qx', 'qy', 'qz', 'vx', 'vy', 'vz', 'wx', 'wy', 'wz'],
  planar: ['x', 'y', 'vx', 'vy', 'omega'], particle: ['x', 'y', 'z', 'vx', 'vy', 'vz'], prescribed: ['x', 'y', 'z'], ground: [] };
const component = { x: p => p.position[0], y: p => p.position[1], z: p => p.position[2], qw: p => p.orientation[0],
  qx: p => p.orientation[1], qy: p => p.orientation[2], qz: p => p.orientation[3], vx: p => p.velocity[0],
  vy: p => p.velocity[1], vz: p => p.velocity[2], wx: p => p.angular_velocity[0], wy: p => p.angular_velocity[1],
  wz: p => p.angular_velocity[2], omega: p => p.angular_velocity[2] };
function columns_of(run) {
  const all = run.series.map(s => ({ name: s.name, series: s }));
  for (const body of run.bodies) for (const part of parts[body.kind])
    all.push({ name: body.name + '.' + part, body, part });
  return all;
}
function curve(column) {
  if (column.series) return column.series;
  if (!column.drawn) {
    const n = 600, t = new Float64Array(n + 1), y = new Float64Array(n + 1);
    for (let i = 0; i <= n; ++i) { t[i] = t0 + (t1 - t0) * i / n; y[i] = component[column.part](pose_of(column.body, t[i])); }
    column.drawn = { t, y };
  }
  return column.drawn;
}

// ---- the scene ------------------------------------------------------------------------------------------------------
const palette = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#b8a800', '#777777'];
const colour_of = i => palette[i % palette.length];
const arrows = { normal: '#0050c8', friction: '#d0021b' };
const flat = data.flat, radius = data.radius, centre = data.centre;
const many = main.bodies.length > 100;  // then corners and pixels are spared
const shown = { contacts: true, forces: true, joints: true, trails: false, labels: main.bodies.length <= 13, axes: false, ghost: true };
let three = null;  // renderer, camera, ...; null without WebGL

function why_no_webgl() {
  if (typeof THREE === 'undefined') return 'This page was written without three.js (Debian: libjs-three), so it has no moving scene.';
  if (data.refuse_webgl || /[#&]nowebgl/.test(location.hash)) return 'WebGL is switched off, so there is no moving scene.';
  try {
    const probe = document.createElement('canvas');
    if (probe.getContext('webgl') || probe.getContext('experimental-webgl')) return '';
  } catch (error) { /* said below */ }
  return 'This browser gives no WebGL, so there is no moving scene.';
}

// Two shades by octant, so that turning is seen.
function two_shades(geometry, shade) {
  const g = geometry.index ? geometry.toNonIndexed() : geometry, p = g.attributes.position, c = new Float32Array(p.count * 3);
  for (let f = 0; f < p.count; f += 3) {
    let x = 0, y = 0, z = 0;
    for (let k = 0; k < 3; ++k) { x += p.getX(f + k); y += p.getY(f + k); z += p.getZ(f + k); }
    const light = shade && (x > 0) !== (y > 0) !== (z > 0) ? 0.72 : 1;
    c.fill(light, 3 * f, 3 * f + 9);
  }
  g.setAttribute('color', new THREE.BufferAttribute(c, 3));
  return many ? shared_corners(g) : g;
}
// The same triangles with equal corners stored once: a renderer without a GPU spends most on corners.
function shared_corners(g) {
  const names = ['position', 'normal', 'color'], kept = { position: [], normal: [], color: [] }, index = [], at = new Map();
  for (let i = 0; i < g.attributes.position.count; ++i) {
    const corner = names.map(n => Array.from(g.attributes[n].array.subarray(3 * i, 3 * i + 3), x => Math.round(1e5 * x) + 0));
    const key = corner.join();
    if (!at.has(key)) {
      at.set(key, at.size);
      for (const n of names) kept[n].push(...g.attributes[n].array.subarray(3 * i, 3 * i + 3));
    }
    index.push(at.get(key));
  }
  const out = new THREE.BufferGeometry();
  for (const n of names) out.setAttribute(n, new THREE.BufferAttribute(new Float32Array(kept[n]), 3));
  out.setIndex(index);
  return out;
}
function flat_polygon(points, depth) {
  const shape = new THREE.Shape(points.map(p => new THREE.Vector2(p[0], p[1])));
  const g = new THREE.ExtrudeBufferGeometry(shape, { depth, bevelEnabled: false });
  g.translate(0, 0, -depth / 2);
  return g;
}
function capsule(r, length) {
  const n = 8, profile = [];
  for (let i = 0; i <= n; ++i) profile.push(new THREE.Vector2(r * Math.sin(i * Math.PI / 2 / n), -length / 2 - r * Math.cos(i * Math.PI / 2 / n)));
  for (let i = 0; i <= n; ++i) profile.push(new THREE.Vector2(r * Math.cos(i * Math.PI / 2 / n), length / 2 + r * Math.sin(i * Math.PI / 2 / n)));
  return new THREE.LatheBufferGeometry(profile, 24).rotateX(Math.PI / 2);
}
// Geometry of unit size where it may be scaled, with the scale; one geometry serves all solids of its key.
const thin = 0.012 * radius;
const ball = fine => many ? new THREE.SphereBufferGeometry(1, 10, 7) : fine ? new THREE.SphereBufferGeometry(1, 128, 80) : new THREE.SphereBufferGeometry(1, 40, 24);
const solids = {
  sphere: s => [s.size[0] > 0.6 * radius ? 'fine' : 'sphere', () => two_shades(ball(s.size[0] > 0.6 * radius), true), [s.size[0], s.size[0], s.size[0]]],
  hollow_sphere: s => ['hollow', () => new THREE.SphereBufferGeometry(1, 96, 60), [s.size[0], s.size[0], s.size[0]]],
  box: s => ['box', () => two_shades(new THREE.BoxBufferGeometry(1, 1, 1), false), [s.size[0], s.size[1], s.size[2] || 4 * thin]],
  ellipsoid: s => ['sphere', () => two_shades(ball(), true), s.size],
  capsule: s => ['capsule ' + s.size, () => two_shades(capsule(s.size[0], s.size[1]), true), [1, 1, 1]],
  cylinder: s => ['cylinder', () => two_shades(new THREE.CylinderBufferGeometry(1, 1, 1, 32).rotateX(Math.PI / 2), true), [s.size[0], s.size[0], s.size[1]]],
  disc: s => ['cylinder', () => two_shades(new THREE.CylinderBufferGeometry(1, 1, 1, 32).rotateX(Math.PI / 2), true), [s.size[0], s.size[0], flat ? 4 * thin : 0.04 * s.size[0]]],
  ellipse: s => ['cylinder', () => two_shades(new THREE.CylinderBufferGeometry(1, 1, 1, 32).rotateX(Math.PI / 2), true), [s.size[0], s.size[1], 4 * thin]],
  hollow_cylinder: s => ['tube', () => flat ? new THREE.RingBufferGeometry(1, 1.02, 96) : new THREE.CylinderBufferGeometry(1, 1, 1, 128, 1, true).rotateX(Math.PI / 2), [s.size[0], s.size[0], s.size[1] || (flat ? 6 * thin : 2 * radius)]],
  point: s => ['sphere', () => two_shades(ball(), true), [3 * thin, 3 * thin, 3 * thin]],
  polygon: s => ['polygon ' + s.vertices, () => two_shades(flat_polygon(s.vertices, 4 * thin), false), [1, 1, 1]],
  polyhedron: s => ['polyhedron ' + s.vertices, () => {
    const g = new THREE.BufferGeometry(), corners = [];
    for (const face of s.faces) for (let k = 2; k < face.length; ++k) for (const i of [face[0], face[k - 1], face[k]]) corners.push(...s.vertices[i]);
    g.setAttribute('position', new THREE.BufferAttribute(new Float32Array(corners), 3));
    g.computeVertexNormals();
    return two_shades(g, false);
  }, [1, 1, 1]],
  stick: s => ['stick', () => two_shades(new THREE.CylinderBufferGeometry(1, 1, 1, 10).translate(0, 0.5, 0).rotateX(Math.PI / 2), false), [thin, thin, Math.hypot(...s.size)]],
};
function quaternion(q) { return new THREE.Quaternion(q[1], q[2], q[3], q[0]); }
function local_matrix(s, scale) {
  const m = new THREE.Matrix4(), q = quaternion(s.place[1]);
  if (s.kind === 'stick')
    q.multiply(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...s.size).normalize()));
  return m.compose(new THREE.Vector3(...s.place[0]), q, new THREE.Vector3(...scale));
}

function material(kind, colour, ghost, inferred) {
  const hollow = kind === 'hollow' || kind === 'tube';
  if (hollow) colour = '#5b6770';
  const m = new THREE.MeshLambertMaterial({ color: colour, vertexColors: hollow ? THREE.NoColors : THREE.VertexColors,
    side: hollow ? THREE.DoubleSide : kind.startsWith('poly') ? THREE.DoubleSide : THREE.FrontSide });
  if (hollow || ghost || inferred) { m.transparent = true; m.opacity = inferred ? 0.45 : ghost ? 0.3 : flat ? 0.8 : 0.25; m.depthWrite = false; }
  return m;
}

// One instanced mesh for each kind of solid and colour; `refresh` sets all matrices from poses.
function make_bodies(run, ghost) {
  const groups = new Map();
  run.bodies.forEach((body, i) => {
    for (const s of body.solids) {
      if (s.kind === 'plane' || !solids[s.kind]) continue;
      const [key, make, scale] = solids[s.kind](s);
      const colour = body.kind === 'ground' || body.kind === 'prescribed' ? '#9aa3ab' : colour_of(body.colour);
      const name = key + colour + (s.inferred || '');
      if (!groups.has(name)) groups.set(name, { key, make, colour, inferred: s.inferred, of: [] });
      groups.get(name).of.push({ body: i, local: local_matrix(s, scale) });
    }
  });
  const made = [];
  for (const g of groups.values()) {
    const mesh = new THREE.InstancedMesh(g.make(), material(g.key, g.colour, ghost, g.inferred), g.of.length);
    mesh.frustumCulled = false;
    three.scene.add(mesh);
    made.push({ mesh, of: g.of });
  }
  return made;
}
// What the scene's lights make of a flat face: one colour, so that it need not be found for every pixel.
function lit(colour, normal) {
  const { sky, sun } = three, above = 0.5 + 0.5 * normal.dot(sky.position.clone().normalize());
  const light = sky.groundColor.clone().lerp(sky.color, above).multiplyScalar(sky.intensity);
  const direct = sun.intensity * Math.max(0, normal.dot(sun.position.clone().normalize()));
  return new THREE.Color(colour).multiply(light.addScalar(direct));
}
function make_planes(run) {
  for (const body of run.bodies) for (const s of body.solids) {
    if (s.kind !== 'plane' || (body.kind !== 'ground' && body.kind !== 'prescribed')) continue;
    const X = new THREE.Matrix4().compose(new THREE.Vector3(...body.p.slice(0, 3)), quaternion(slice(body.q, 0, 4)), new THREE.Vector3(1, 1, 1))
      .multiply(local_matrix(s, [1, 1, 1]));
    const group = new THREE.Group();
    const inverse = new THREE.Matrix4().getInverse(X), mid = new THREE.Vector3(...centre).applyMatrix4(inverse);
    // a plane that moves reaches as far as the scene's middle goes on it
    let goes = 0;
    for (let i = 0; i < body.t.length; i += Math.ceil(body.t.length / 50)) {
      const p = new THREE.Vector3(...centre).applyMatrix4(new THREE.Matrix4().getInverse(matrix_of(pose_of(body, body.t[i])).multiply(local_matrix(s, [1, 1, 1]))));
      goes = Math.max(goes, Math.hypot(p.x - mid.x, p.y - mid.y));
    }
    const half = 1.6 * radius + goes, cells = Math.min(60, 2 * Math.ceil(half / (0.2 * radius)));
    if (flat) {
      // in a planar scene the plane's z axis lies in the xy plane, and the line across it is drawn, hatched on the solid side
      const n = new THREE.Vector3(0, 0, 1).transformDirection(X), o = new THREE.Vector3(0, 0, 0).applyMatrix4(X);
      const d = new THREE.Vector3(-n.y, n.x, 0), along = new THREE.Vector3(...centre).sub(o).dot(d);
      o.addScaledVector(d, along);
      const hatching = [];
      for (let k = -40; k <= 40; ++k) {
        const p = o.clone().addScaledVector(d, k * half / 20);
        hatching.push(p, p.clone().addScaledVector(n, -half / 28).addScaledVector(d, -half / 28));
      }
      const edge = [o.clone().addScaledVector(d, -2 * half), o.clone().addScaledVector(d, 2 * half)];
      for (const [points, color] of [[edge, '#333'], [hatching, '#888']])
        group.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color })));
      three.scene.add(group);
      continue;
    }
    const sheet = new THREE.Mesh(new THREE.PlaneBufferGeometry(2 * half, 2 * half),
      new THREE.MeshBasicMaterial({ color: lit('#dfe4e8', new THREE.Vector3(0, 0, 1).transformDirection(X)), polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 }));
    const grid = new THREE.GridHelper(2 * half, cells, '#9aa3ab', '#bcc4ca');
    grid.rotateX(Math.PI / 2);
    for (const part of [sheet, grid]) { part.position.set(mid.x, mid.y, 0); group.add(part); }
    group.matrixAutoUpdate = false;
    group.matrix.copy(X);
    three.scene.add(group);
    three.planes.push({ group, grid, body, local: local_matrix(s, [1, 1, 1]) });
  }
}
function make_axes(run) {  // of bodies without solids: three short lines
  run.bodies.forEach((body, i) => {
    if (body.kind === 'ground') return;
    const bare = body.solids.length === 0;
    const size = bare ? 0.15 * radius : Math.max(0.1 * radius, 1.3 * body.extent);
    const axes = new THREE.AxesHelper(size);
    if (bare) axes.add(new THREE.Mesh(new THREE.BoxBufferGeometry(5 * thin, 5 * thin, 5 * thin), new THREE.MeshLambertMaterial({ color: colour_of(body.colour) })));
    three.scene.add(axes);
    three.axes.push({ axes, body: i, bare });
  });
}
function make_joints(run) {
  for (const joint of run.joints) {
    const group = new THREE.Group(), size = 0.07 * radius;
    if (joint.axis) {
      const g = new THREE.CylinderBufferGeometry(thin * 0.8, thin * 0.8, flat ? 6 * thin : 2 * size, 8);
      const m = new THREE.Mesh(g, new THREE.MeshBasicMaterial({ color: '#222' }));
      m.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...joint.axis).normalize());
      group.add(m);
    }
    group.add(new THREE.Mesh(new THREE.SphereBufferGeometry(1.4 * thin, 10, 8), new THREE.MeshBasicMaterial({ color: '#222' })));
    const local = new THREE.Matrix4().makeTranslation(...joint.anchor);
    group.matrixAutoUpdate = false;
    three.scene.add(group);
    three.joints.push({ group, body: joint.a, local });
  }
}
const most_markers = 4000, longest = 0.7 * radius;
function make_contacts() {
  const instanced = (geometry, colour) => {
    const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true, blending: THREE.NoBlending, side: THREE.DoubleSide }), most_markers);
    mesh.frustumCulled = false;
    mesh.count = 0;
    mesh.renderOrder = 3;
    three.scene.add(mesh);
    return mesh;
  };
  const r = 0.014 * radius * (many ? 0.45 : 1);
  const ring = many ? new THREE.RingBufferGeometry(0.7 * r, 1.3 * r, 10) : new THREE.TorusBufferGeometry(r, 0.35 * r, 6, 14);
  three.marks = { k: instanced(new THREE.BoxBufferGeometry(1.6 * r, 1.6 * r, 1.6 * r), '#222'), p: instanced(ring, '#222') };
  const head = new THREE.ConeBufferGeometry(1.1 * r, 3 * r, many ? 5 : 10).translate(0, -1.5 * r, 0);
  const shaft = new THREE.CylinderBufferGeometry(0.4 * r, 0.4 * r, 1, many ? 4 : 6, 1, many).translate(0, 0.5, 0);
  for (const kind of ['normal', 'friction'])
    three.arrows[kind] = { head: instanced(head, arrows[kind]), shaft: instanced(shaft, arrows[kind]) };
  three.head = 3 * r;
}
function make_trails(run, ghost) {
  run.bodies.forEach(body => {
    if (body.kind === 'ground' || body.kind === 'prescribed' || run.bodies.length > 60) return;
    const n = 500, points = [];
    for (let i = 0; i <= n; ++i) points.push(new THREE.Vector3(...pose_of(body, t0 + (t1 - t0) * i / n).position));
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({ color: colour_of(body.colour), transparent: ghost, opacity: ghost ? 0.4 : 1 }));
    three.scene.add(line);
    three.trails.push({ line, n });
  });
}

function first_view() {
  const up = new THREE.Vector3(...data.up), c = new THREE.Vector3(...centre), camera = three.camera;
  three.target.copy(c);
  camera.up.copy(flat ? new THREE.Vector3(0, 1, 0) : up);
  const corners = [];
  const room = main.contacts && main.contacts.t.length > 0 ? 0.08 * radius : 0;  // for arrows
  for (let k = 0; k < 8; ++k) corners.push(new THREE.Vector3(...[0, 1, 2].map(i => data.box[k >> i & 1][i] + (k >> i & 1 ? room : -room))));
  const away = new THREE.Vector3(0, 0, 1);
  if (!flat) {
    const side = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const right = side.addScaledVector(up, -side.dot(up)).normalize(), forth = new THREE.Vector3().crossVectors(up, right);
    // of four sides the first from which most floors are seen from above
    const floors = three.planes.map(p => new THREE.Vector3(0, 0, 1).transformDirection(p.group.matrix)).filter(n => n.dot(up) > 0.3);
    let most = -1;
    for (const [x, y] of [[0.55, -1.75], [1.75, 0.55], [-1.75, -0.55], [-0.55, 1.75]]) {
      const side = new THREE.Vector3().addScaledVector(right, x).addScaledVector(forth, y).addScaledVector(up, 0.8).normalize();
      const seen = floors.filter(n => n.dot(side) > 0.15).length;
      if (seen > most) { most = seen; away.copy(side); }
    }
  }
  // the least distance, or span, from which the box of all that moves is seen whole
  let low = 0.01 * radius, high = 20 * radius;
  for (let k = 0; k < 40; ++k) {
    const middle = (low + high) / 2;
    if (flat) three.span = middle;
    camera.position.copy(c).addScaledVector(away, flat ? 10 * radius : middle);
    aim();
    const seen = corners.every(p => {
      const v = p.clone().applyMatrix4(camera.matrixWorldInverse);
      if (!flat && v.z > -0.02 * radius) return false;
      v.applyMatrix4(camera.projectionMatrix);
      return Math.abs(v.x) < 0.88 && Math.abs(v.y) < 0.82;
    });
    if (seen) high = middle; else low = middle;
  }
  if (flat) three.span = high; else camera.position.copy(c).addScaledVector(away, high);
  aim();
}
function aim() {
  const camera = three.camera;
  if (flat) {
    const ratio = three.width / three.height, s = three.span;
    const [x, y] = ratio > 1 ? [s * ratio, s] : [s, s / ratio];
    camera.left = -x; camera.right = x; camera.top = y; camera.bottom = -y;
  } else {
    camera.aspect = three.width / three.height;
  }
  camera.lookAt(three.target);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld(true);
  camera.matrixWorldInverse.getInverse(camera.matrixWorld);
}
function orbit(dx, dy, move) {
  const camera = three.camera, away = camera.position.clone().sub(three.target);
  if (move || flat) {
    const scale = flat ? 2 * three.span / Math.min(three.width, three.height) : away.length() * 0.83 / three.height;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    const step = right.multiplyScalar(-dx * scale).addScaledVector(up, dy * scale);
    camera.position.add(step);
    three.target.add(step);
  } else {
    const up = camera.up.clone().normalize(), right = new THREE.Vector3().crossVectors(away, up).normalize();
    away.applyAxisAngle(up, -dx * 0.008);
    const angle = Math.acos(Math.max(-1, Math.min(1, away.dot(up) / away.length())));
    const turn = Math.max(0.05, Math.min(Math.PI - 0.05, angle - dy * 0.008)) - angle;
    away.applyAxisAngle(right, -turn);
    camera.position.copy(three.target).add(away);
  }
  aim();
}
function zoom(factor) {
  if (flat) three.span *= factor;
  else three.camera.position.sub(three.target).multiplyScalar(factor).add(three.target);
  aim();
}

function make_three() {
  const canvas = $('scene');
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: !many, preserveDrawingBuffer: true });
  renderer.setClearColor('#f4f6f8');
  const camera = flat ? new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01 * radius, 100 * radius)
    : new THREE.PerspectiveCamera(40, 1, 0.01 * radius, 200 * radius);
  three = { renderer, camera, canvas, scene: new THREE.Scene(), target: new THREE.Vector3(), bodies: [], planes: [], axes: [], joints: [],
    arrows: {}, trails: [], marks: null, span: radius, width: 1, height: 1 };
  const sky = new THREE.HemisphereLight('#ffffff', '#8a8f96', 0.58), sun = new THREE.DirectionalLight('#ffffff', 0.5);
  Object.assign(three, { sky, sun });
  sky.position.set(...data.up);  // its light falls from there
  three.scene.add(sky);
  sun.position.set(...data.up).multiplyScalar(3).add(new THREE.Vector3(1, -2, flat ? 4 : 0.6));
  three.scene.add(sun);
  make_planes(main);
  data.runs.forEach((run, i) => { three.bodies.push(make_bodies(run, i > 0)); make_trails(run, i > 0); });
  make_axes(main);
  make_joints(main);
  make_contacts();
  fit();
  first_view();
  let held = null;
  canvas.addEventListener('pointerdown', e => { held = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointerup', () => { held = null; });
  canvas.addEventListener('pointermove', e => {
    if (!held) return;
    three.touched = true;
    orbit(e.clientX - held[0], e.clientY - held[1], e.shiftKey || e.buttons === 4);
    held = [e.clientX, e.clientY];
    draw();
  });
  canvas.addEventListener('wheel', e => { e.preventDefault(); three.touched = true; zoom(Math.exp(0.001 * e.deltaY)); draw(); }, { passive: false });
}
function fit() {
  const box = $('stage').getBoundingClientRect();
  three.width = Math.max(1, box.width);
  three.height = Math.max(1, box.height);
  three.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  three.renderer.setSize(three.width, three.height, false);
  aim();
}

// ---- drawing a time -------------------------------------------------------------------------------------------------
let now = t0;
function matrix_of(pose) {
  return new THREE.Matrix4().compose(new THREE.Vector3(...pose.position), quaternion(pose.orientation), new THREE.Vector3(1, 1, 1));
}
// The matrices of all bodies of the run now; made once, filled for every frame.
function matrices_now(run) {
  if (!run.matrices) run.matrices = run.bodies.map(() => new THREE.Matrix4());
  const place = new THREE.Vector3(), turn = new THREE.Quaternion(), one = new THREE.Vector3(1, 1, 1), o = one_pose;
  run.bodies.forEach((body, i) => {
    if (body.t.length === 1 && body.placed) return;
    body.placed = true;
    pose_into(body, now, o);
    run.matrices[i].compose(place.set(o[0], o[1], o[2]), turn.set(o[4], o[5], o[6], o[3]), one);
  });
  return run.matrices;
}
function draw_scene() {
  const product = new THREE.Matrix4();
  let poses = null;
  data.runs.forEach((run, r) => {
    const matrices = matrices_now(run);
    if (r === 0) poses = matrices;
    for (const { mesh, of } of three.bodies[r]) {
      mesh.visible = r === 0 || shown.ghost;
      of.forEach(({ body, local }, k) => mesh.setMatrixAt(k, product.multiplyMatrices(matrices[body], local)));
      mesh.instanceMatrix.needsUpdate = true;
    }
  });
  for (const p of three.planes) {
    p.group.matrix.multiplyMatrices(matrix_of(pose_of(p.body, now)), p.local);
    // from behind a wall is not there, nor its grid
    const n = new THREE.Vector3(0, 0, 1).transformDirection(p.group.matrix);
    p.grid.visible = three.camera.position.clone().sub(new THREE.Vector3().setFromMatrixPosition(p.group.matrix)).dot(n) > 0;
  }
  for (const a of three.axes) {
    a.axes.visible = a.bare || shown.axes;
    poses[a.body].decompose(a.axes.position, a.axes.quaternion, a.axes.scale);
  }
  for (const j of three.joints) {
    j.group.visible = shown.joints;
    j.group.matrix.multiplyMatrices(poses[j.body], j.local);
  }
  for (const t of three.trails) {
    t.line.visible = shown.trails;
    t.line.geometry.setDrawRange(0, 1 + Math.round(t.n * (now - t0) / Math.max(t1 - t0, 1e-300)));
  }
  draw_contacts();
  const index = follow_index();
  if (index >= 0) {
    const p = new THREE.Vector3().setFromMatrixPosition(poses[index]), step = p.clone().sub(three.target);
    three.target.copy(p);
    three.camera.position.add(step);
    aim();
  }
  three.renderer.render(three.scene, three.camera);
  draw_labels(poses);
}
function draw_contacts() {
  const counts = { k: 0, p: 0, normal: 0, friction: 0 };
  const c = main.contacts, m = new THREE.Matrix4(), one = new THREE.Vector3(1, 1, 1), z = new THREE.Vector3(0, 0, 1), y = new THREE.Vector3(0, 1, 0);
  const arrow = (kind, at, force) => {
    const asked = force.length() * data.metres_per_newton, length = Math.min(asked, longest);
    if (!(length > 0.25 * three.head) || counts[kind] >= most_markers) return;
    const q = new THREE.Quaternion().setFromUnitVectors(y, force.clone().normalize());
    const { head, shaft } = three.arrows[kind], k = counts[kind]++;
    const along = force.clone().normalize(), tip = at.clone().addScaledVector(along, length);
    head.setMatrixAt(k, m.compose(tip, q, one));
    shaft.setMatrixAt(k, m.compose(at, q, new THREE.Vector3(1, Math.max(length - three.head, 1e-9), 1)));
    if (asked > length && counts[kind] < most_markers) {  // cut short: a second head says so
      const j = counts[kind]++;
      head.setMatrixAt(j, m.compose(tip.addScaledVector(along, -1.3 * three.head), q, one));
      shaft.setMatrixAt(j, m.makeScale(0, 0, 0));
    }
  };
  if (c && c.t.length > 0 && (shown.contacts || shown.forces)) {
    // a row is about the step that ends at its time
    let i = before(c.t, now);
    if (c.t[i] < now && i + 1 < c.t.length && c.t[i + 1] - now < now - c.t[i]) ++i;
    const near = Math.abs(c.t[i] - now) <= c.reach;
    for (let k = c.first[i]; near && k < c.first[i + 1]; ++k) {
      const mode = c.mode[k] === 1 ? 'k' : c.mode[k] === 2 ? 'p' : null;
      if (!mode) continue;
      const at = new THREE.Vector3(c.position[3 * k], c.position[3 * k + 1], c.position[3 * k + 2]);
      const s = c.scale[i], n = new THREE.Vector3(...slice(c.normal, k, 3)).multiplyScalar(s), f = new THREE.Vector3(...slice(c.friction, k, 3)).multiplyScalar(s);
      if (shown.contacts && counts[mode] < most_markers) {
        const q = n.lengthSq() > 0 ? new THREE.Quaternion().setFromUnitVectors(z, n.clone().normalize()) : new THREE.Quaternion();
        three.marks[mode].setMatrixAt(counts[mode]++, m.compose(at, q, one));
      }
      if (shown.forces) { arrow('normal', at, n); arrow('friction', at, f); }
    }
  }
  for (const mode of ['k', 'p']) { three.marks[mode].count = counts[mode]; three.marks[mode].instanceMatrix.needsUpdate = true; }
  for (const kind of ['normal', 'friction']) for (const part of ['head', 'shaft']) {
    three.arrows[kind][part].count = counts[kind];
    three.arrows[kind][part].instanceMatrix.needsUpdate = true;
  }
}
function project(p) {  // world -> pixels of the stage
  const v = new THREE.Vector3(...p).project(three.camera);
  return [(v.x + 1) / 2 * three.width, (1 - v.y) / 2 * three.height, v.z];
}
const labels = [];
function draw_labels(poses) {
  $('labels').hidden = !shown.labels;
  if (!shown.labels) return;
  const taken = [];
  main.bodies.forEach((body, i) => {
    let label = labels[i];
    if (!label) { label = labels[i] = $('labels').appendChild(document.createElement('span')); label.textContent = body.name; }
    const [x, y, z] = project(new THREE.Vector3().setFromMatrixPosition(poses[i]).toArray());
    const covered = taken.some(b => Math.abs(b[0] - x) < 9 + 7 * Math.max(b[2], Math.min(body.name.length, 24)) && Math.abs(b[1] - y) < 17);
    const visible = body.kind !== 'ground' && z < 1 && x > 0 && x < three.width && y > 0 && y < three.height && !covered;
    label.hidden = !visible;
    if (!visible) return;
    taken.push([x, y, Math.min(body.name.length, 24)]);
    label.style.left = x + 'px';
    label.style.top = y + 'px';
  });
}

const short = x => Number.isNaN(x) ? '–' : Math.abs(x) >= 1e-3 && Math.abs(x) < 1e5 || x === 0 ? x.toPrecision(6) : x.toExponential(3);
const listed = ['energy', 'h', 'gap_min', 'joint_error', 'res_newton_euler', 'res_kinematic', 'res_joints', 'res_normal', 'res_friction'];
function draw_values() {
  const body = $('values').tBodies[0];
  if (!body.rows.length) {
    for (const name of ['t', ...listed]) {
      if (name !== 't' && !main.series.some(s => s.name === name)) continue;
      const row = body.insertRow();
      row.insertCell().textContent = name;
      row.insertCell();
      row.dataset.name = name;
    }
  }
  for (const row of body.rows) {
    const series = main.series.find(s => s.name === row.dataset.name);
    row.cells[1].textContent = series ? short(value_of(series, now)) : now.toPrecision(7);
  }
}
// The plot's curves are drawn anew where the column or the size is another; a frame copies them and puts the line of the time over them.
const plotted = { canvas: document.createElement('canvas'), of: '' };
function draw_plot() {
  const canvas = $('plot'), ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  const name = $('column').value, of = [name, w, h, ratio].join(' ');
  if (plotted.of !== of) {
    for (const c of [canvas, plotted.canvas]) { c.width = w * ratio; c.height = h * ratio; }
    draw_curves(plotted.canvas.getContext('2d'), ratio, w, h, name);
    plotted.of = of;
  }
  if (!canvas.width || !canvas.height) return;
  const g = canvas.getContext('2d'), x = plot_edge + (w - 2 * plot_edge) * (now - t0) / Math.max(t1 - t0, 1e-300);
  g.setTransform(1, 0, 0, 1, 0, 0);
  g.clearRect(0, 0, canvas.width, canvas.height);
  g.drawImage(plotted.canvas, 0, 0);
  g.scale(ratio, ratio);
  g.strokeStyle = '#1a1a1a';
  g.beginPath();
  g.moveTo(x, 16);
  g.lineTo(x, h - 16);
  g.stroke();
}
const plot_edge = 8;
function draw_curves(g, ratio, w, h, name) {
  g.scale(ratio, ratio);
  const left = plot_edge, right = w - plot_edge, top = 16, bottom = h - 16;
  const curves = data.runs.map(run => { const c = columns_of_run(run).find(x => x.name === name); return c ? curve(c) : null; });
  let low = Infinity, high = -Infinity;
  for (const c of curves) if (c) for (const y of c.y) if (Number.isFinite(y)) { low = Math.min(low, y); high = Math.max(high, y); }
  g.font = '11px system-ui, sans-serif';
  g.fillStyle = '#5a5a5a';
  if (!(high >= low)) { g.fillText('no values', left, top + 14); return; }
  if (high - low < 1e-12 * Math.max(Math.abs(high), Math.abs(low), 1e-300)) { const d = Math.abs(high) * 1e-3 || 1; low -= d; high += d; }
  const x_of = t => left + (right - left) * (t - t0) / Math.max(t1 - t0, 1e-300), y_of = y => bottom - (bottom - top) * (y - low) / (high - low);
  g.strokeStyle = '#d5d5d5';
  g.strokeRect(left, top, right - left, bottom - top);
  g.fillText(short(high), left, top - 4);
  g.fillText(short(low), left, h - 4);
  g.textAlign = 'right';
  g.fillText('t ' + short(t0) + ' … ' + short(t1) + ' s', right, h - 4);
  g.textAlign = 'left';
  curves.forEach((c, i) => {
    if (!c) return;
    g.strokeStyle = i === 0 ? '#0072b2' : '#d55e00';
    g.setLineDash(i === 0 ? [] : [4, 3]);
    g.beginPath();
    let pen = false;
    for (let k = 0; k < c.t.length; ++k) {
      if (!Number.isFinite(c.y[k])) { pen = false; continue; }
      if (pen) g.lineTo(x_of(c.t[k]), y_of(c.y[k])); else g.moveTo(x_of(c.t[k]), y_of(c.y[k]));
      pen = true;
    }
    g.stroke();
  });
  g.setLineDash([]);
}
const run_columns = new Map();
function columns_of_run(run) {
  if (!run_columns.has(run)) run_columns.set(run, columns_of(run));
  return run_columns.get(run);
}
const event_buttons = [];
function draw() {
  if (three) draw_scene();
  draw_values();
  draw_plot();
  $('clock').textContent = 't = ' + now.toFixed(decimals) + ' s';
  $('time').value = String(Math.round(1e6 * (now - t0) / Math.max(t1 - t0, 1e-300)));
  for (const { button, t } of event_buttons) button.classList.toggle('now', Math.abs(t - now) <= 1e-9 * Math.max(1, t1 - t0));
}
const decimals = Math.max(0, Math.min(9, Math.ceil(3 - Math.log10(Math.max(t1 - t0, 1e-6)))));

// ---- time goes on ---------------------------------------------------------------------------------------------------
let playing = false, last_frame = 0, speed = 1;
const speeds = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
function seek(t) {
  now = Math.min(t1, Math.max(t0, Number(t)));
  draw();
}
function play(on) {
  playing = on === undefined ? !playing : Boolean(on);
  if (playing && now >= t1) now = t0;
  $('play').textContent = playing ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', playing ? 'pause' : 'play');
  last_frame = performance.now();
  if (playing) requestAnimationFrame(frame);
}
function frame(time) {
  if (!playing) return;
  const step = Math.max(0, Math.min(0.25, (time - last_frame) / 1000)) * speed;
  last_frame = time;
  if (now + step >= t1) { seek(t1); play(false); return; }
  seek(now + step);
  requestAnimationFrame(frame);
}
function set_speed(value) {
  speed = value;
  $('speed').value = String(value);
}
function other_speed(by) { set_speed(speeds[Math.max(0, Math.min(speeds.length - 1, speeds.indexOf(speed) + by))]); }
function event_beside(direction) {
  const times = main.events.map(e => e.t), tiny = 1e-9 * Math.max(1, t1 - t0);
  const found = direction > 0 ? times.find(t => t > now + tiny) : times.slice().reverse().find(t => t < now - tiny);
  if (found !== undefined) seek(found);
}
function follow_index() {
  const value = $('follow').value;
  return value === '' ? -1 : Number(value);
}

function make_controls() {
  $('title').textContent = data.title;
  const said = $('said');
  said.textContent = data.said;
  said.classList.toggle('stopped', data.stopped);
  $('data-said').textContent = data.data_said;
  for (const s of speeds) $('speed').add(new Option(s < 1 ? '1/' + Math.round(1 / s) : String(s), String(s)));
  set_speed(data.speed);
  $('speed').addEventListener('change', e => { speed = Number(e.target.value); });
  $('play').addEventListener('click', () => play());
  $('time').addEventListener('input', e => seek(t0 + (t1 - t0) * Number(e.target.value) / 1e6));
  const select = $('column');
  const names = columns_of_run(main).map(c => c.name);
  for (const n of names.slice(0, 2000)) select.add(new Option(n, n));
  select.value = names.includes('energy') ? 'energy' : names[0];
  select.addEventListener('change', draw_plot);
  $('plot').addEventListener('click', e => {
    const box = e.target.getBoundingClientRect();
    seek(t0 + (t1 - t0) * (e.clientX - box.left - 8) / (box.width - 16));
  });
  $('follow').add(new Option('nothing', ''));
  main.bodies.forEach((b, i) => { if (b.kind !== 'ground' && i < 2000) $('follow').add(new Option(b.name, String(i))); });
  $('follow').addEventListener('change', draw);
  const words = { contacts: 'contact points', forces: 'forces', joints: 'joints', trails: 'trails', labels: 'names', axes: 'axes' };
  if (data.runs.length > 1) words.ghost = 'the other run';
  for (const [key, word] of Object.entries(words)) {
    const label = document.createElement('label'), box = document.createElement('input');
    box.type = 'checkbox';
    box.checked = shown[key];
    box.id = 'show-' + key;
    box.addEventListener('change', () => { shown[key] = box.checked; draw(); });
    label.append(box, ' ' + word);
    $('switches').append(label);
  }
  for (const e of main.events) {
    const tick = document.createElement('i');
    tick.style.left = 100 * (e.t - t0) / Math.max(t1 - t0, 1e-300) + '%';
    $('ticks').append(tick);
  }
  for (const e of main.events.slice(0, 400)) {
    const button = document.createElement('button');
    button.textContent = e.t.toPrecision(5) + ' s ' + e.kind + (e.contact ? ' ' + e.contact : '');
    button.title = e.before || e.after ? e.before + ' → ' + e.after : '';
    button.addEventListener('click', () => { play(false); seek(e.t); });
    $('events').append(button);
    event_buttons.push({ button, t: e.t });
  }
  if (main.events.length > 400) $('events').append(document.createTextNode('and ' + (main.events.length - 400) + ' more: n, p'));
  window.addEventListener('keydown', e => {
    if (e.target.tagName === 'SELECT' || e.ctrlKey || e.metaKey || e.altKey) return;
    const frame_length = speed / 30;
    const does = { ' ': () => play(), ArrowRight: () => seek(now + (e.shiftKey ? speed : frame_length)),
      ArrowLeft: () => seek(now - (e.shiftKey ? speed : frame_length)), n: () => event_beside(1), p: () => event_beside(-1),
      Home: () => seek(t0), End: () => seek(t1), '+': () => other_speed(1), '-': () => other_speed(-1),
      0: () => { if (three) { three.touched = false; first_view(); } draw(); }, c: () => { $('show-contacts').click(); } }[e.key];
    if (!does) return;
    e.preventDefault();
    does();
  });
  window.addEventListener('resize', () => { if (three) { fit(); if (!three.touched) first_view(); } draw(); });
}
function make_key() {
  if (!main.contacts || main.contacts.t.length === 0 || !(data.metres_per_newton > 0)) return;
  $('key').innerHTML = '<i></i>normal force<i></i>friction<b></b>sticks<b class="slip"></b>slips <span></span>';
  const bars = $('key').querySelectorAll('i');
  bars[0].style.background = arrows.normal;
  bars[1].style.background = arrows.friction;
  const round_force = Number(nice(0.25 * radius / data.metres_per_newton).toPrecision(1));
  $('key').lastChild.textContent = ' · an arrow of ' + Number((data.metres_per_newton * round_force).toPrecision(3)) + ' m is ' + round_force + ' N';
}

// ---- pictures -------------------------------------------------------------------------------------------------------
// The page's views at n times as one SVG with a scale bar; pictures of the scene inside it.
function strip(n, width = 360, height = 270) {
  document.body.classList.add('bare');
  $('stage').style.flex = 'none';
  $('stage').style.width = width + 'px';
  $('stage').style.height = height + 'px';
  fit();
  first_view();
  const gap = 8, text = 22, columns = Math.min(n, 4), rows = Math.ceil(n / columns);
  const w = columns * (width + gap) + gap, h = rows * (height + text + gap) + gap + 26;
  let out = `<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="${w}" height="${h}" viewBox="0 0 ${w} ${h}" font-family="sans-serif" font-size="14"><rect width="${w}" height="${h}" fill="white"/>`;
  for (let k = 0; k < n; ++k) {
    const t = n > 1 ? t0 + (t1 - t0) * k / (n - 1) : t1, x = gap + (k % columns) * (width + gap), y = gap + Math.floor(k / columns) * (height + text + gap);
    seek(t);
    out += `<image x="${x}" y="${y}" width="${width}" height="${height}" xlink:href="${three.canvas.toDataURL('image/png')}"/>` +
      `<text x="${x + 4}" y="${y + height + 16}">t = ${t.toPrecision(4)} s</text>`;
  }
  const metres = nice(radius), pixels = metres * pixels_per_metre();
  out += `<path d="M${gap} ${h - 12}h${pixels.toFixed(1)}m0 -4v8m${(-pixels).toFixed(1)} 0v-8" stroke="black" stroke-width="1.5" fill="none"/>` +
    `<text x="${gap + pixels + 8}" y="${h - 7}">${short_length(metres)}${flat ? '' : ' at the middle of the scene'}</text></svg>`;
  return out;
}
const nice = x => { const p = Math.pow(10, Math.floor(Math.log10(x))); return x / p >= 5 ? 5 * p : x / p >= 2 ? 2 * p : p; };
const short_length = x => x >= 1 ? x + ' m' : x >= 1e-3 ? Number((1e3 * x).toPrecision(3)) + ' mm' : Number((1e6 * x).toPrecision(3)) + ' µm';
function pixels_per_metre() {
  const right = new THREE.Vector3().setFromMatrixColumn(three.camera.matrixWorld, 0), a = project(three.target.toArray());
  const b = project(three.target.clone().addScaledVector(right, 0.01 * radius).toArray());
  return Math.hypot(b[0] - a[0], b[1] - a[1]) / (0.01 * radius);
}

// ---- begin ------------------------------------------------------------------------------------------------------------
const problem = why_no_webgl();
make_controls();
if (problem) {
  $('no-scene').hidden = false;
  $('no-scene').textContent = problem + ' Plots, values and events are on the right and below.';
} else {
  make_three();
  make_key();
}
window.perp = {
  seek, play, get time() { return now; }, get playing() { return playing; }, events: main.events,
  bodies: main.bodies.map(b => b.name),
  pose(name, run = 0) {
    const body = data.runs[run].bodies.find(b => b.name === name);
    if (!body) throw new Error('there is no body ' + name);
    const pose = pose_of(body, now);
    return { position: pose.position, orientation: pose.orientation };
  },
  value(name, run = 0) { const s = data.runs[run].series.find(x => x.name === name); return s ? value_of(s, now) : undefined; },
  camera() {
    return three && { position: three.camera.position.toArray(), target: three.target.toArray(), up: three.camera.up.toArray(), flat,
      fov: flat ? undefined : three.camera.fov, span: flat ? three.span : undefined, width: three.width, height: three.height };
  },
  look(position, target) { three.touched = true; three.camera.position.set(...position); three.target.set(...target); aim(); draw(); },
  project, strip,
  show(what, on) { shown[what] = on; $('show-' + what).checked = on; draw(); },
};
const asked = Object.fromEntries(location.hash.slice(1).split('&').filter(Boolean).map(x => { const [k, v] = x.split('='); return [k, v === undefined ? '' : decodeURIComponent(v)]; }));
if ('bare' in asked) { document.body.classList.add('bare'); if (three) { fit(); first_view(); } }
seek('t' in asked ? Number(asked.t) : t0);
if ('strip' in asked && three) {
  const text = strip(Number(asked.strip));
  document.body.innerHTML = '<pre id="strip"></pre>';
  $('strip').textContent = text;
}
})();
