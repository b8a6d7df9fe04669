// The scene in three.js: rigid pieces, instanced by shape; deformable surfaces; particles; contacts.

const SHADOW = 2048, DETAILED = 3000;
const MARK = new THREE.Color(1, 0.35, 0);

class Stage {
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.camera = new THREE.PerspectiveCamera();
    this.camera.up.set(0, 0, 1);
    this.sky = new THREE.HemisphereLight(0xffffff, 0x8a8680, 2.0);
    this.sky.position.set(0, 0, 1);
    this.sun = new THREE.DirectionalLight(0xfff6ea, 2.4);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(SHADOW, SHADOW);
    Object.assign(this, { canvas, chosen: -1, touches: true, touching: [] });
  }

  /** Replaces the recording. */
  show(data) {
    this.discard();
    this.data = data;
    this.bodies = [...new Set([...data.pieces, ...data.figures].map((row) => row.body))];
    this.chosen = -1;
    this.pictures = data.pictures.map((uri) => {
      const picture = new THREE.TextureLoader().load(uri, () => this.onchange?.());
      picture.colorSpace = THREE.SRGBColorSpace;
      return picture;
    });
    this.scene = new THREE.Scene();
    this.scene.fog = new THREE.Fog(0);
    this.scene.environment = surroundings();
    this.scene.environmentIntensity = 0.35;
    this.scene.add(this.sky, this.sun, this.sun.target);
    this.aimSun();
    this.groups = this.makeGroups();
    this.figures = data.figures.map((row) => row.faces ? this.makeSurface(row) : this.makeGrains(row));
    this.touchPoints = data.contacts && this.makeTouches(data.contacts);
    this.paint();
  }

  discard() {
    this.scene?.traverse((thing) => {
      thing.geometry?.dispose();
      thing.material?.dispose();
    });
    this.scene?.environment.dispose();
    for (const picture of this.pictures ?? []) picture.dispose();
  }

  aimSun() {
    const { center, radius, light } = this.data, way = new THREE.Vector3(...light).normalize();
    way.z = Math.min(way.z, -0.35);  // shadows of a lamp from the side or below are not informative
    this.sun.target.position.set(...center);
    this.sun.position.copy(this.sun.target.position).addScaledVector(way.normalize(), -8 * radius);
    const reach = 2.4 * radius;
    Object.assign(this.sun.shadow.camera, { left: -reach, right: reach, bottom: -reach, top: reach, near: radius / 10, far: 20 * radius });
    this.sun.shadow.camera.updateProjectionMatrix();
    this.sun.shadow.normalBias = 0.006 * radius;
    this.sun.shadow.bias = -0.0005;
  }

  material(row) {
    const clear = row.color[3] < 255;
    return new THREE.MeshStandardMaterial({
      roughness: row.rough, metalness: row.metal ?? 0, map: row.picture === undefined ? null : this.pictures[row.picture],
      transparent: clear, opacity: row.color[3] / 255, depthWrite: !clear, side: THREE.DoubleSide,
    });
  }

  /** Adds copies of a shape; `rows` have the body and colour of each. */
  copies(shape, material, rows) {
    const made = new THREE.InstancedMesh(shape, material, rows.length);
    made.frustumCulled = false;
    made.castShadow = made.receiveShadow = !material.transparent;
    made.userData.rows = rows;
    this.scene.add(made);
    return made;
  }

  makeGroups() {
    const groups = new Map(), shapes = this.data.meshes.map((row) => {
      const shape = new THREE.BufferGeometry();
      shape.setAttribute("position", new THREE.BufferAttribute(floats(row.points), 3));
      shape.setAttribute("normal", new THREE.BufferAttribute(row.normals, 3, true));
      if (row.uvs) shape.setAttribute("uv", new THREE.BufferAttribute(row.uvs, 2));
      return shape.setIndex(new THREE.BufferAttribute(row.faces, 1));
    });
    for (const piece of this.data.pieces) {
      const key = [piece.mesh, piece.picture, piece.color[3], piece.rough, piece.metal].join();
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(piece);
    }
    return [...groups.values()].map((pieces) => {
      const group = this.copies(shapes[pieces[0].mesh], this.material(pieces[0]), pieces);
      group.userData.places = pieces.map(matrixOf);
      pieces.forEach((piece, k) => {
        if (piece.base) group.setMatrixAt(k, matrixOf(piece.base).multiply(group.userData.places[k]));
      });
      return group;
    });
  }

  makeSurface(row) {
    const shape = new THREE.BufferGeometry();
    shape.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * row.count), 3));
    if (row.uvs) shape.setAttribute("uv", new THREE.BufferAttribute(row.uvs, 2));
    shape.setIndex(new THREE.BufferAttribute(row.faces, 1));
    const figure = this.copies(shape, this.material(row), [row]);
    figure.setMatrixAt(0, new THREE.Matrix4());
    figure.userData.update = (t) => {
      deformed(row, t, shape.attributes.position.array);
      shape.attributes.position.needsUpdate = true;
      shape.computeVertexNormals();
      shape.boundingSphere = null;
    };
    return figure;
  }

  makeGrains(row) {
    const shape = new THREE.IcosahedronGeometry(row.radius, row.count > DETAILED ? 0 : 1), points = new Float32Array(3 * row.count);
    shape.setAttribute("normal", shape.attributes.position.clone());
    shape.normalizeNormals();
    const figure = this.copies(shape, this.material(row), new Array(row.count).fill(row)), place = new THREE.Matrix4();
    figure.userData.update = (t) => {
      deformed(row, t, points);
      for (let k = 0; k < row.count; k++) figure.setMatrixAt(k, place.setPosition(points[3 * k], points[3 * k + 1], points[3 * k + 2]));
      figure.instanceMatrix.needsUpdate = true;
    };
    return figure;
  }

  makeTouches(contacts) {
    const shape = new THREE.BufferGeometry(), dot = document.createElement("canvas"), pen = dot.getContext("2d");
    dot.width = dot.height = 64;
    for (const [radius, color] of [[31, "#fff"], [22, "#d64500"]]) {
      pen.fillStyle = color;
      pen.beginPath();
      pen.arc(32, 32, radius, 0, 7);
      pen.fill();
    }
    const material = new THREE.PointsMaterial({
      map: new THREE.CanvasTexture(dot), transparent: true, sizeAttenuation: false, toneMapped: false, fog: false,
      depthTest: false,  // contact points are mostly hidden between bodies
    });
    material.map.colorSpace = THREE.SRGBColorSpace;
    material.onBeforeCompile = (shader) => {
      shader.vertexShader = shader.vertexShader.replace("uniform float size;", "attribute float size;");
    };
    shape.setAttribute("position", new THREE.BufferAttribute(floats(contacts.pos), 3));
    const size = (force) => (5 + 11 * Math.sqrt(force / (contacts.strongest || 1))) * (window.devicePixelRatio || 1);
    shape.setAttribute("size", new THREE.BufferAttribute(contacts.force.map(size), 1));
    const points = new THREE.Points(shape, material);
    points.frustumCulled = false;
    this.scene.add(points);
    return points;
  }

  /** Moves everything to its pose at a time. */
  setTime(t) {
    const poses = posesAt(this.data.links, t), place = new THREE.Matrix4();
    for (const group of this.groups) {
      group.userData.rows.forEach(({ track }, k) => {
        if (track !== undefined) group.setMatrixAt(k, place.multiplyMatrices(poses[track], group.userData.places[k]));
      });
      group.instanceMatrix.needsUpdate = true;
    }
    for (const figure of this.figures) figure.userData.update(t);
    for (const thing of [...this.groups, ...this.figures]) thing.boundingSphere = null;
    this.setTouches(t);
  }

  setTouches(t) {
    this.touching = [];
    if (!this.touchPoints) return;
    const { starts, force, pairs } = this.data.contacts, [a, b, w] = around(this.data.links.times, t), frame = w < 0.5 ? a : b;
    this.touchPoints.geometry.setDrawRange(starts[frame], starts[frame + 1] - starts[frame]);
    for (let k = starts[frame]; k < starts[frame + 1]; k++) this.touching.push([pairs[2 * k], pairs[2 * k + 1], force[k]]);
  }

  choose(number) {
    this.chosen = number;
    this.paint();
  }

  paint() {
    const chosen = this.bodies[this.chosen], color = new THREE.Color();
    for (const thing of [...this.groups, ...this.figures]) {
      thing.userData.rows.forEach((row, k) => {
        const [red, green, blue] = row.picture === undefined ? row.color.map((c) => c / 255) : [1, 1, 1];
        color.setRGB(red, green, blue, THREE.SRGBColorSpace);
        if (!row.faces && thing.userData.update) color.multiplyScalar(0.86 + 0.28 * (k * 0.618 % 1));  // to distinguish grains
        if (row.body === chosen) color.lerp(MARK, 0.45);
        thing.setColorAt(k, color);
      });
      thing.instanceColor.needsUpdate = true;
    }
  }

  /** Draws the scene. */
  draw() {
    const { canvas, data, camera, scene } = this, away = camera.position.distanceTo(this.sun.target.position);
    scene.background = new THREE.Color().setRGB(...this.background, THREE.SRGBColorSpace);
    Object.assign(scene.fog, { color: scene.background, near: away + 1.8 * data.radius, far: away + 5 * data.radius });
    if (this.touchPoints) this.touchPoints.visible = this.touches;
    this.renderer.setSize(canvas.width, canvas.height, false);
    this.renderer.render(scene, camera);
  }

  /** Index of the body at a pixel of the page; -1 if there is none. */
  pick(x, y) {
    const { clientWidth: w, clientHeight: h } = this.canvas, ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(2 * x / w - 1, 1 - 2 * y / h), this.camera);
    const [hit] = ray.intersectObjects([...this.groups, ...this.figures]);
    return hit ? this.bodies.indexOf(hit.object.userData.rows[hit.instanceId].body) : -1;
  }
}

/** Environment for reflections of metals: dark below, bright above. */
function surroundings() {
  const sheet = document.createElement("canvas"), pen = sheet.getContext("2d");
  [sheet.width, sheet.height] = [16, 64];
  const shade = pen.createLinearGradient(0, 0, 0, 64);
  for (const [place, color] of [[0, "#fff"], [0.45, "#cdd5de"], [0.55, "#6b6660"], [1, "#3a3835"]]) shade.addColorStop(place, color);
  pen.fillStyle = shade;
  pen.fillRect(0, 0, 16, 64);
  const texture = new THREE.CanvasTexture(sheet);
  texture.mapping = THREE.EquirectangularReflectionMapping;
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}
