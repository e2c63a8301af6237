// One mounted 3D view. It draws only when something has changed.
"use strict";

window.FoundrySceneView = (() => {
  const THREE = window.THREE;
  const { FULL_HEIGHT, TARGET, radians, makeAvatar, makeCone, makeTrail, makeTarget, makeSight, discard } = window.FoundrySceneParts;
  const SKY = 0x9eb3c7;
  const FADED = 0.22;
  const TURN = radians(5);

  /** Reads a GLB; pictures are decoded by <img>, since the page's policy forbids fetch() of blob: addresses. */
  async function read(glb) {
    const loader = new THREE.GLTFLoader();
    loader.register((parser) => {
      parser.textureLoader = new THREE.TextureLoader(parser.options.manager);
      return { name: "pictures-without-fetch" };
    });
    return loader.parseAsync(glb, "");
  }

  class View {
    constructor(element, gltf, episode) {
      this.element = element;
      this.episode = episode;
      this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      this.renderer.localClippingEnabled = true;
      this.canvas = this.renderer.domElement;
      this.scene = new THREE.Scene();
      this.world = new THREE.Group(); // foundry's frame: metres, Z up
      this.world.rotation.x = -Math.PI / 2;
      this.scene.add(this.world, new THREE.HemisphereLight(0xffffff, 0x8899aa, 2.6));
      this.camera = new THREE.PerspectiveCamera(40, 1, 0.05, 1000);
      this.fromEye = false;
      this.readScene(gltf);
      this.showTold();
      this.controls = new THREE.OrbitControls(this.camera, this.canvas);
      this.controls.addEventListener("change", () => this.draw());
    }

    readScene(gltf) {
      this.surfaces = gltf ? gltf.scene : null;
      this.eye = gltf?.cameras[0] ?? null;
      this.bodyHeight = this.eye?.userData.body_height ?? FULL_HEIGHT;
      this.eyeHeight = this.eye?.position.z ?? 1.6;
      this.cut = new THREE.Plane(new THREE.Vector3(0, -1, 0), Infinity);
      this.bounds = new THREE.Box3();
      this.materials = [];
      if (!this.surfaces) return;
      this.scene.add(this.surfaces);
      this.surfaces.updateMatrixWorld(true);
      this.bounds.setFromObject(this.surfaces);
      this.surfaces.traverse((part) => {
        if (part.isMesh) this.materials.push(part.material);
      });
      for (const material of this.materials) {
        material.userData.own = { opacity: material.opacity, transparent: material.transparent };
        material.clippingPlanes = [this.cut];
      }
      const places = this.surfaces.children[0].userData.targets;
      const boxes = (this.episode?.target_prims ?? []).map((path) => places[path]).filter(Boolean);
      if (boxes.length) this.world.add((this.target = makeTarget(boxes)));
    }

    /** Shows the described route, if there is one, next to the path of the agent. */
    showTold() {
      if (!this.episode?.legs) return;
      const radius = 0.015 * this.bodyHeight;
      const points = this.episode.shortest_path.map(([x, y, z]) => new THREE.Vector3(x, y, z + radius));
      this.trail = makeTrail(points, radius, 0.6, TARGET);
      this.world.add(this.trail);
    }

    /** Takes the present records. */
    update(steps) {
      this.steps = steps;
      const start = this.episode?.start ?? steps[0]?.pose;
      this.poses = start ? [start, ...steps.map((step) => step.pose_next)] : [];
      const radius = 0.02 * this.bodyHeight;
      const points = this.poses.map(({ x, y, z }) => new THREE.Vector3(x, y, z + radius));
      for (const old of [this.past, this.future]) if (old) discard(old);
      this.future = makeTrail(points, radius * 0.8, 0.45);
      this.past = makeTrail(points, radius, 1);
      this.world.add(this.future, this.past);
      for (const point of points) this.bounds.expandByPoint(this.world.localToWorld(point.clone()));
      this.seek(Math.min(this.index ?? 0, this.poses.length - 1));
    }

    seek(index) {
      if (!this.poses.length) return;
      this.index = Math.max(0, Math.min(index, this.poses.length - 1));
      const { x, y, z, yaw, pitch } = this.poses[this.index];
      if (!this.avatar) {
        this.world.add((this.avatar = makeAvatar(this.bodyHeight)));
        this.gaze = new THREE.Group();
        if (this.eye) this.gaze.add(makeCone(this.eye, 0.9 * this.bodyHeight));
        this.world.add(this.gaze);
      }
      this.avatar.position.set(x, y, z);
      this.avatar.rotation.z = radians(yaw);
      this.gaze.position.set(x, y, z + this.eyeHeight);
      this.gaze.rotation.set(0, -radians(pitch), radians(yaw), "ZYX");
      this.past.show(this.index);
      this.showSight();
      this.draw();
    }

    /** Shows the line from the eye to the target, for poses in which the agent decides. */
    showSight() {
      if (this.sight) discard(this.sight);
      this.sight = null;
      const decision = this.steps[this.index];
      if (!this.target || !decision) return;
      this.sight = makeSight(this.gaze.position, this.target.userData.middle, decision.line_of_sight, 0.01 * this.bodyHeight);
      this.world.add(this.sight);
    }

    /** The position and the centre of the view, as a text for an address; null for the whole scene. */
    get place() {
      const now = [...this.camera.position.toArray(), ...this.controls.target.toArray()].map((n) => Number(n.toFixed(3)));
      return now.join() === this.whole ? null : now.join();
    }

    set place(text) {
      const numbers = (text || "").split(",").map(Number);
      if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return;
      this.camera.position.fromArray(numbers);
      this.controls.target.fromArray(numbers, 3);
      this.controls.update();
      this.draw();
    }

    /** Shows the whole scene, from above and from the side. */
    reset() {
      const size = this.bounds.getSize(new THREE.Vector3()), centre = this.bounds.getCenter(new THREE.Vector3());
      const azimuth = size.x >= size.z ? 0.35 : Math.PI / 2 + 0.35;
      const aside = new THREE.Vector3().setFromSphericalCoords(1, radians(48), azimuth);
      const reach = size.length() / 2 || 1;
      this.camera.position.copy(centre).addScaledVector(aside, this.distanceToSeeAll(aside, size, reach));
      this.camera.near = reach / 500;
      this.camera.far = reach * 50;
      this.camera.updateProjectionMatrix();
      this.controls.target.copy(centre);
      this.controls.update();
      this.whole = null;
      this.whole = this.place;
      this.draw();
    }

    /** The distance from its centre at which a box of this size fills the picture, seen from this direction. */
    distanceToSeeAll(aside, size, least) {
      const slope = Math.tan(radians(this.camera.fov) / 2);
      const right = new THREE.Vector3(0, 1, 0).cross(aside).normalize(), up = aside.clone().cross(right);
      const distances = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => {
        const corner = new THREE.Vector3(x, y, z).multiply(size).multiplyScalar(0.5);
        const wide = Math.abs(corner.dot(right)) / this.camera.aspect, high = Math.abs(corner.dot(up));
        return Math.max(wide, high) / slope + corner.dot(aside);
      })));
      return Math.max(least, 1.06 * Math.max(...distances));
    }

    /**
     * The height of the scene, and the height of a cut that shows the rooms of the agent, both above the lowest point,
     * metres.
     */
    heights() {
      const height = this.bounds.max.y - this.bounds.min.y;
      const highest = Math.max(...this.poses.map((pose) => pose.z));
      const cut = this.poses.length ? highest + 1.02 * this.bodyHeight - this.bounds.min.y : height;
      return { height, cut: Math.min(cut, height) };
    }

    /** Hides everything above this height over the lowest point, metres, so that the user can look into rooms. */
    cutAt(height) {
      this.cut.constant = this.bounds.min.y + height + 1e-3;
      this.draw();
    }

    fade(faded) {
      for (const material of this.materials) {
        const { opacity, transparent } = material.userData.own;
        Object.assign(material, { opacity: opacity * (faded ? FADED : 1), transparent: transparent || faded });
        material.depthWrite = !material.transparent;
        material.needsUpdate = true;
      }
      this.draw();
    }

    lookThroughEye(through) {
      this.fromEye = through;
      this.controls.enabled = !through;
      this.draw();
    }

    draw() {
      this.pending ??= requestAnimationFrame(() => {
        this.pending = null;
        const { clientWidth: width, clientHeight: height } = this.element;
        if (width && height) this.fromEye && this.eye ? this.drawEye(width, height) : this.drawAll(width, height);
      });
    }

    drawAll(width, height) {
      this.renderer.setScissorTest(false);
      this.renderer.setViewport(0, 0, width, height);
      this.renderer.render(this.scene, this.camera);
    }

    /** Draws the view of the model: the same position, angle and proportions, with nothing cut or transparent. */
    drawEye(width, height) {
      const { x, y, z, yaw, pitch } = this.poses[this.index];
      const eye = new THREE.PerspectiveCamera(this.eye.fov, this.eye.aspect, 0.02, this.camera.far);
      eye.position.copy(this.world.localToWorld(new THREE.Vector3(x, y, z + this.eyeHeight)));
      eye.rotation.set(radians(pitch), radians(yaw - 90), 0, "YXZ");
      const wide = Math.min(width, height * this.eye.aspect), high = wide / this.eye.aspect;
      const { constant } = this.cut;
      this.cut.constant = Infinity;
      this.world.visible = false;
      this.scene.background = new THREE.Color(SKY);
      this.renderer.clear();
      this.renderer.setScissorTest(true);
      for (const rectangle of ["setViewport", "setScissor"])
        this.renderer[rectangle]((width - wide) / 2, (height - high) / 2, wide, high);
      this.renderer.render(this.scene, eye);
      this.scene.background = null;
      this.world.visible = true;
      this.cut.constant = constant;
    }

    resize() {
      const { clientWidth: width, clientHeight: height } = this.element;
      if (!width || !height) return;
      this.renderer.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.draw();
    }

    turn(key) {
      const away = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
      const moves = {
        ArrowLeft: () => (away.theta -= TURN),
        ArrowRight: () => (away.theta += TURN),
        ArrowUp: () => (away.phi -= TURN),
        ArrowDown: () => (away.phi += TURN),
        "+": () => (away.radius /= 1.1),
        "-": () => (away.radius *= 1.1),
      };
      if (!moves[key]) return false;
      moves[key]();
      this.camera.position.setFromSpherical(away.makeSafe()).add(this.controls.target);
      this.controls.update();
      return true;
    }

    dispose() {
      cancelAnimationFrame(this.pending);
      this.controls.dispose();
      discard(this.scene);
      this.renderer.dispose();
      this.renderer.forceContextLoss();
    }
  }

  return { View, read };
})();
