// The view: free, or that of a camera of the film.

class ViewControl {
  constructor(camera, canvas, onchange) {
    Object.assign(this, { camera, canvas, track: null, time: 0 });
    this.orbit = new THREE.OrbitControls(camera, canvas);
    this.orbit.addEventListener("start", () => this.free());
    this.orbit.addEventListener("change", onchange);
  }

  show(data) {
    this.data = data;
    if (this.track !== null) this.track = Math.min(this.track, data.cameras.length - 1);
    Object.assign(this.orbit, { minDistance: 0.02 * data.radius, maxDistance: 60 * data.radius });
  }

  /** Looks at everything from the start of the film's camera. */
  reset() {
    const { cameras, center, radius } = this.data;
    this.track = null;
    this.fov = cameras[0]?.fov ?? 40;
    if (cameras[0]) this.stand(cameras[0], 0);
    else {
      this.camera.position.set(center[0], center[1] - 4 * radius, center[2]);
      this.camera.lookAt(...center);
    }
    this.aim();
  }

  /** Makes the view free, from the pose of the film's camera. */
  free() {
    if (this.track === null) return;
    this.fov = this.data.cameras[this.track].fov;
    this.track = null;
    this.aim();
    this.onfree?.();
  }

  /** Orbits about the centre of the picture, at the distance of the scene. */
  aim() {
    const ahead = this.camera.getWorldDirection(new THREE.Vector3());
    const arm = new THREE.Vector3(...this.data.center).sub(this.camera.position), away = arm.dot(ahead);
    this.camera.up.set(0, 0, 1);
    this.orbit.target.copy(this.camera.position).addScaledVector(ahead, Math.max(away, 0.3 * arm.length(), this.orbit.minDistance));
    this.orbit.update();
  }

  /** Moves the camera to the pose of the film's camera at a time. */
  stand(film, t) {
    const [a, b, w] = around(film.times, t), { camera } = this;
    const mix = (values) => new THREE.Vector3().fromArray(values, 3 * a).lerp(new THREE.Vector3().fromArray(values, 3 * b), w);
    const look = mix(film.look);
    camera.position.copy(mix(film.pos));
    camera.up.copy(mix(film.up));
    const ahead = look.clone().sub(camera.position).normalize();
    if (Math.abs(ahead.dot(camera.up)) > 0.9999) camera.up.set(0, 1, 0);  // +y is up if it looks straight down
    camera.lookAt(look);
  }

  /** Sets the camera for a time; a narrow page shows the full width of the film. */
  look(t) {
    const { camera, data } = this, aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    this.time = t;
    if (this.track !== null) this.stand(data.cameras[this.track], t);
    const half = Math.tan((this.track === null ? this.fov : data.cameras[this.track].fov) * Math.PI / 360);
    const away = camera.position.distanceTo(new THREE.Vector3(...data.center));
    Object.assign(camera, {
      aspect, fov: Math.atan(half * Math.max(data.aspect / aspect, 1)) * 360 / Math.PI,
      near: Math.max(Math.min(data.radius, away) * 0.02, 1e-4), far: away + 60 * data.radius,
    });
    camera.updateProjectionMatrix();
  }
}
