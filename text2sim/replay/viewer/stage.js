// What is drawn: rigid pieces by shape, all copies at once; surfaces that bend; particles; contacts.

const SHADOW = 2048;

class Stage {
  constructor(canvas, data) {
    const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    Object.assign(this, { gl, canvas, data, chosen: -1, touches: true });
    this.bodies = [...new Set([...data.pieces, ...data.figures].map((row) => row.body))];
    this.numbers = new Map(this.bodies.map((name, k) => [name, k]));
    this.programs = Object.fromEntries(Object.keys(SHADERS).map((name) => [name, compile(gl, name)]));
    this.pictures = data.pictures.map((uri) => this.load(uri));
    this.groups = this.makeGroups();
    this.figures = data.figures.map((row) => this.makeFigure(row));
    if (data.contacts) {
      this.spots = floats(data.contacts.pos);
      this.touchPoints = this.vertices([[0, 3], [1, 1]], [new Float32Array(3), new Float32Array(1)]);
    }
    this.makeShadow();
    this.makeNumbered();
    gl.enable(gl.DEPTH_TEST);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  vertices(columns, arrays, faces) {
    const { gl } = this, array = gl.createVertexArray(), buffers = [];
    gl.bindVertexArray(array);
    columns.forEach(([place, width], k) => {
      buffers.push(gl.createBuffer());
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[k]);
      gl.bufferData(gl.ARRAY_BUFFER, arrays[k], gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, width, gl.FLOAT, false, 0, 0);
    });
    if (faces) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    }
    const kind = faces instanceof Uint32Array ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT;
    return { array, buffers, count: faces ? faces.length : 0, kind };
  }

  /** Poses, colours and surfaces, one row each for a copy. */
  instances(mesh, count) {
    const { gl } = this, poses = new Float32Array(16 * count), rows = new Float32Array(8 * count);
    const buffers = [gl.createBuffer(), gl.createBuffer()];
    gl.bindVertexArray(mesh.array);
    for (const [buffer, first, stride, places] of [[buffers[0], 3, 64, 4], [buffers[1], 7, 32, 2]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      for (let k = 0; k < places; k++) {
        gl.enableVertexAttribArray(first + k);
        gl.vertexAttribPointer(first + k, 4, gl.FLOAT, false, stride, 16 * k);
        gl.vertexAttribDivisor(first + k, 1);
      }
    }
    return { poses, rows, buffers };
  }

  paint(group) {
    const { gl } = this;
    group.pieces.forEach((piece, k) => {
      const number = this.numbers.get(piece.body);
      group.rows.set([...piece.color.map((c) => c / 255), piece.rough, piece.metal ?? 0, number,
        number === this.chosen ? 1 : 0], 8 * k);
    });
    gl.bindBuffer(gl.ARRAY_BUFFER, group.buffers[1]);
    gl.bufferData(gl.ARRAY_BUFFER, group.rows, gl.DYNAMIC_DRAW);
  }

  makeGroups() {
    const groups = new Map();
    for (const piece of this.data.pieces) {
      const key = [piece.mesh, piece.picture ?? -1, piece.color[3] < 255].join();
      if (!groups.has(key)) groups.set(key, { pieces: [], picture: piece.picture, clear: piece.color[3] < 255 });
      groups.get(key).pieces.push(piece);
    }
    return [...groups.values()].map((group) => {
      const shape = this.data.meshes[group.pieces[0].mesh], points = floats(shape.points);
      const normals = Float32Array.from(shape.normals, (x) => x / 127);
      const uvs = shape.uvs ?? new Float32Array(points.length / 3 * 2);
      group.mesh = this.vertices([[0, 3], [1, 3], [2, 2]], [points, normals, uvs], shape.faces);
      Object.assign(group, this.instances(group.mesh, group.pieces.length));
      group.pieces.forEach((piece, k) => {
        if (piece.base) writePose(group.poses, 16 * k, ...joinedPose(piece.base.pos, piece.base.quat, piece.pos, piece.quat));
      });
      group.moves = group.pieces.some((piece) => piece.track !== undefined);
      this.paint(group);
      this.uploadPoses(group);
      return group;
    });
  }

  uploadPoses(group) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, group.buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, group.poses, gl.DYNAMIC_DRAW);
  }

  makeFigure(row) {
    const points = new Float32Array(3 * row.count);
    if (!row.faces) return { row, points, mesh: this.vertices([[0, 3]], [points]) };
    const normals = new Float32Array(3 * row.count), uvs = row.uvs ?? new Float32Array(2 * row.count);
    const mesh = this.vertices([[0, 3], [1, 3], [2, 2]], [points, normals, uvs], row.faces);
    const group = { row, points, normals, mesh, pieces: [row], picture: row.picture, clear: row.color[3] < 255 };
    Object.assign(group, this.instances(mesh, 1));
    writePose(group.poses, 0, [0, 0, 0], [1, 0, 0, 0]);
    this.paint(group);
    this.uploadPoses(group);
    return group;
  }

  load(uri) {
    const { gl } = this, texture = gl.createTexture(), image = new Image();
    image.onload = () => {
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
      gl.generateMipmap(gl.TEXTURE_2D);
      this.onchange?.();
    };
    image.src = uri;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([200, 200, 200, 255]));
    return texture;
  }

  makeShadow() {
    const { gl } = this;
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, SHADOW, SHADOW, 0, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
    for (const [name, value] of [["MIN_FILTER", gl.LINEAR], ["MAG_FILTER", gl.LINEAR], ["WRAP_S", gl.CLAMP_TO_EDGE],
      ["WRAP_T", gl.CLAMP_TO_EDGE], ["COMPARE_MODE", gl.COMPARE_REF_TO_TEXTURE]]) {
      gl.texParameteri(gl.TEXTURE_2D, gl["TEXTURE_" + name], value);
    }
    this.shadowFrame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    const { center, radius, light } = this.data, way = unit(light);
    if (way[2] > -0.35) way[2] = -0.35;  // a lamp from the side or below throws shadows that say nothing
    this.toLamp = unit(times(way, -1));
    const from = add(center, times(this.toLamp, 8 * radius));
    this.lamp = product(orthographic(2.4 * radius, 0.1 * radius, 20 * radius), viewMatrix(from, center, [0, 0, 1]));
  }

  makeNumbered() {
    const { gl } = this;
    this.numbered = { frame: gl.createFramebuffer(), color: gl.createTexture(), depth: gl.createRenderbuffer() };
  }

  /** Puts everything where it is at a time. */
  setTime(t) {
    const { gl, data } = this;
    const poses = new Array(data.links.count);
    eachPose(data.links, t, (k, pos, turn) => { poses[k] = [pos, turn]; });
    for (const group of this.groups) {
      if (!group.moves) continue;
      group.pieces.forEach((piece, k) => {
        if (piece.track === undefined) return;
        writePose(group.poses, 16 * k, ...joinedPose(...poses[piece.track], piece.pos, piece.quat));
      });
      this.uploadPoses(group);
    }
    for (const figure of this.figures) {
      deformed(figure.row, t, figure.points);
      gl.bindBuffer(gl.ARRAY_BUFFER, figure.mesh.buffers[0]);
      gl.bufferData(gl.ARRAY_BUFFER, figure.points, gl.DYNAMIC_DRAW);
      if (!figure.normals) continue;
      writeNormals(figure.points, figure.row.faces, figure.normals);
      gl.bindBuffer(gl.ARRAY_BUFFER, figure.mesh.buffers[1]);
      gl.bufferData(gl.ARRAY_BUFFER, figure.normals, gl.DYNAMIC_DRAW);
    }
    this.setTouches(t);
  }

  setTouches(t) {
    const { gl, data } = this;
    this.touching = [];
    if (!data.contacts) return;
    const [a, b, w] = around(data.links.times, t), frame = w < 0.5 ? a : b, { starts, force, pairs, strongest } = data.contacts;
    const first = starts[frame], end = starts[frame + 1];
    const strength = new Float32Array(end - first).map((_, k) => force[first + k] / (strongest || 1));
    [this.spots.subarray(3 * first, 3 * end), strength].forEach((values, k) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, this.touchPoints.buffers[k]);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    });
    for (let k = first; k < end; k++) this.touching.push([pairs[2 * k], pairs[2 * k + 1], force[k]]);
  }

  choose(number) {
    this.chosen = number;
    for (const group of [...this.groups, ...this.figures]) if (group.rows) this.paint(group);
  }

  use(name, view) {
    const { gl, data } = this, { program, places } = this.programs[name];
    gl.useProgram(program);
    const vectors = { eye: view?.pos, toLamp: this.toLamp, background: this.background, center: data.center,
      right: view?.right, above: view?.above };
    for (const [key, value] of Object.entries(vectors)) if (places[key] && value) gl.uniform3fv(places[key], value);
    if (places.camera) gl.uniformMatrix4fv(places.camera, false, view.matrix);
    if (places.lamp) gl.uniformMatrix4fv(places.lamp, false, this.lamp);
    if (places.radius) gl.uniform1f(places.radius, data.radius);
    if (places.shadow) {
      gl.activeTexture(gl.TEXTURE1);
      gl.bindTexture(gl.TEXTURE_2D, this.shadow);
      gl.uniform1i(places.shadow, 1);
      gl.activeTexture(gl.TEXTURE0);
    }
    return places;
  }

  drawMeshes(places, groups) {
    const { gl } = this;
    for (const group of groups) {
      if (places.dressed) {
        const dressed = group.picture !== undefined;
        gl.uniform1i(places.dressed, dressed ? 1 : 0);
        gl.uniform1i(places.picture, 0);
        gl.bindTexture(gl.TEXTURE_2D, dressed ? this.pictures[group.picture] : null);
      }
      gl.bindVertexArray(group.mesh.array);
      gl.drawElementsInstanced(gl.TRIANGLES, group.mesh.count, group.mesh.kind, 0, group.pieces.length);
    }
  }

  drawBalls(places, pixels, numbered) {
    const { gl } = this;
    for (const { row, mesh } of this.figures) {
      if (row.faces) continue;
      const number = this.numbers.get(row.body);
      gl.uniform1f(places.size, 2 * row.radius);
      if (places.pixels) gl.uniform1f(places.pixels, pixels);
      if (places.paint) gl.uniform4fv(places.paint, row.color.map((c) => c / 255));
      if (places.kind) gl.uniform4fv(places.kind, [Math.max(row.rough, 0.3), 0, number, number === this.chosen ? 1 : 0]);
      if (places.numbered) gl.uniform1i(places.numbered, numbered ? 1 : 0);
      gl.bindVertexArray(mesh.array);
      gl.drawArrays(gl.POINTS, 0, row.count);
    }
  }

  /** Draws all of it as a camera sees it: pos, look, up, fov [rad]. */
  draw(camera) {
    const { gl, canvas, data } = this, meshes = [...this.groups, ...this.figures.filter((figure) => figure.row.faces)];
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowFrame);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.drawMeshes(this.use("shade"), meshes.filter((group) => !group.clear));
    const spots = this.use("spot");
    for (const { row, mesh } of this.figures) {
      if (row.faces) continue;
      gl.uniform1f(spots.size, Math.max(2 * row.radius / (4.8 * data.radius) * SHADOW, 1));
      gl.bindVertexArray(mesh.array);
      gl.drawArrays(gl.POINTS, 0, row.count);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...this.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = this.see(camera);
    this.drawMeshes(this.use("mesh", view), meshes.filter((group) => !group.clear));
    this.drawBalls(this.use("ball", view), view.pixels, false);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    this.drawMeshes(this.use("mesh", view), meshes.filter((group) => group.clear));
    if (this.touches && this.touching?.length) {
      const places = this.use("touch", view);
      gl.disable(gl.DEPTH_TEST);  // where things touch is mostly between them
      gl.uniform1f(places.pixels, canvas.height / Math.max(canvas.clientHeight, 1));
      gl.bindVertexArray(this.touchPoints.array);
      gl.drawArrays(gl.POINTS, 0, this.touching.length);
      gl.enable(gl.DEPTH_TEST);
    }
    gl.depthMask(true);
  }

  see({ pos, look, up, fov }) {
    const { canvas, data } = this, away = long(minus(pos, data.center));
    const near = Math.max(Math.min(long(minus(look, pos)), away) * 0.02, 1e-4), far = away + 60 * data.radius;
    const lens = perspective(fov, canvas.width / canvas.height, near, far), [right, above] = basis(pos, look, up);
    return { pos, right, above, matrix: product(lens, viewMatrix(pos, look, up)),
      pixels: canvas.height / 2 / Math.tan(fov / 2) };
  }

  /** The number of the body in a pixel of the page; -1 if there is none. */
  pick(camera, x, y) {
    const { gl, canvas, numbered } = this, [w, h] = [canvas.width, canvas.height];
    gl.bindTexture(gl.TEXTURE_2D, numbered.color);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, w, h, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindRenderbuffer(gl.RENDERBUFFER, numbered.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, w, h);
    gl.bindFramebuffer(gl.FRAMEBUFFER, numbered.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, numbered.color, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, numbered.depth);
    gl.viewport(0, 0, w, h);
    gl.disable(gl.BLEND);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = this.see(camera), surfaces = this.figures.filter((figure) => figure.row.faces);
    this.drawMeshes(this.use("number", view), [...this.groups, ...surfaces]);
    this.drawBalls(this.use("ball", view), view.pixels, true);
    const pixel = new Uint8Array(4), scale = h / canvas.clientHeight;
    gl.readPixels(Math.floor(x * scale), h - 1 - Math.floor(y * scale), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return pixel[0] + 256 * pixel[1] + 65536 * pixel[2] - 1;
  }
}
